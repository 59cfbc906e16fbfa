//! What is made of the objects of a scene, and reports about them.

use super::super::assets::{Assets, Finish};
use super::super::description::Additions;
use super::super::names::ShapeNames;
use super::super::parameters::Parameters;
use super::super::plugins::report_unknown;
use super::super::sink::{Problem, Sink};
use super::family::PluginFamily;
use super::object::ObjectTree;
use super::props::Props;
use super::values::{ObjectId, Value};
use manylight::bsdf::Material;
use manylight::color::Rgb;
use manylight::ids::{EmitterId, MaterialId, ShapeId, TextureId};
use manylight::scene::SceneDesc;
use manylight::texture::ColorInput;
use std::collections::HashMap;
use std::path::PathBuf;

/// A plugin of Mitsuba that is not supported, and the description of its replacement in messages.
pub(super) type Substitute = (&'static str, &'static str);

/// The description for plugins without a replacement.
pub(super) const IGNORED: &str = "it is ignored";

/// Materials of shapes without a bsdf.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum PlainMaterial {
    /// Diffuse with reflectance 0.5: the default.
    Gray,
    /// Diffuse with reflectance 0: the default of emitting shapes.
    Black,
    /// No surface: the border of a medium.
    Null,
}

/// The shape that is being built.
#[derive(Clone, Copy, Debug)]
pub(super) struct CurrentShape {
    pub(super) object: ObjectId,
    /// Its geometry if that is a mesh of a file.
    pub(super) mesh: Option<ShapeId>,
}

/// An object, and the shape for which it is made if it differs between shapes.
pub(super) type Scoped = (ObjectId, Option<ObjectId>);

/// What has been made of objects, so that it is made once.
#[derive(Default)]
pub(super) struct Made {
    pub(super) materials: HashMap<Scoped, MaterialId>,
    plain_materials: HashMap<PlainMaterial, MaterialId>,
    pub(super) textures: HashMap<Scoped, TextureId>,
    /// Bitmap textures by their files and settings.
    pub(super) bitmaps: HashMap<(PathBuf, String), TextureId>,
    pub(super) area_emitters: HashMap<Scoped, EmitterId>,
    pub(super) groups: HashMap<ObjectId, usize>,
    /// Materials that are invisible from behind, by the material in front.
    pub(super) fronts: HashMap<MaterialId, MaterialId>,
    /// Shapes without parameters, by their plugins.
    pub(super) builtin_shapes: HashMap<&'static str, ShapeId>,
    /// Whether an object contains textures that differ between shapes.
    per_shape: HashMap<ObjectId, bool>,
}

/// Fills a [`SceneDesc`] from a tree of objects.
pub(super) struct DescBuilder<'a> {
    pub(super) tree: &'a ObjectTree,
    pub(super) sink: &'a Sink,
    /// Frames per second of moving cameras.
    pub(super) fps: f32,
    pub(super) desc: SceneDesc,
    pub(super) made: Made,
    pub(super) current_shape: Option<CurrentShape>,
    pub(super) shape_names: ShapeNames,
    pub(super) assets: Assets,
    /// What depends on the images.
    pub(super) finish: Vec<Finish>,
}

impl<'a> DescBuilder<'a> {
    pub(super) fn new(tree: &'a ObjectTree, fps: f32, sink: &'a Sink) -> Self {
        DescBuilder {
            tree,
            sink,
            fps,
            desc: SceneDesc::default(),
            made: Made::default(),
            current_shape: None,
            shape_names: ShapeNames::default(),
            assets: Assets::default(),
            finish: Vec::new(),
        }
    }

    pub(super) fn props(&self, id: ObjectId) -> Props<'a> {
        Props::new(self.tree, id, self.sink)
    }

    pub(super) fn plain_material(&mut self, plain: PlainMaterial) -> MaterialId {
        *self.made.plain_materials.entry(plain).or_insert_with(|| {
            let material = match plain {
                PlainMaterial::Gray => Material::default(),
                PlainMaterial::Black => Material::Diffuse {
                    reflectance: ColorInput::Constant(Rgb::BLACK),
                },
                PlainMaterial::Null => Material::Null,
            };
            self.desc.add(material)
        })
    }

    /// Whether the value is a nested texture.
    pub(super) fn nested_texture(&self, value: &Value) -> Option<ObjectId> {
        match value {
            Value::Object(id) if self.tree.get(*id).family == PluginFamily::Texture => Some(*id),
            _ => None,
        }
    }

    /// Whether the object contains textures that differ between shapes.
    pub(super) fn is_per_shape(&mut self, id: ObjectId) -> bool {
        if let Some(known) = self.made.per_shape.get(&id) {
            return *known;
        }
        let object = self.tree.get(id);
        let is_attribute = object.family == PluginFamily::Texture
            && matches!(
                object.plugin.value.as_str(),
                "mesh_attribute" | "vertexcolors"
            );
        let nested = object.params.iter().filter_map(|param| match param.value {
            Value::Object(inner) => Some(inner),
            _ => None,
        });
        let nested: Vec<ObjectId> = nested.collect();
        let result = is_attribute || nested.into_iter().any(|inner| self.is_per_shape(inner));
        self.made.per_shape.insert(id, result);
        result
    }

    /// The key of an object in the maps of what has been made.
    pub(super) fn scoped(&mut self, id: ObjectId) -> Scoped {
        let shape = self.current_shape.filter(|_| self.is_per_shape(id));
        (id, shape.map(|shape| shape.object))
    }

    /// Warns once about participating media.
    pub(super) fn ignore_medium(&self, id: ObjectId) {
        let props = self.props(id);
        let object = props.describe();
        let message = format!("{object} is ignored: participating media are not supported");
        props.unsupported("participating media", message);
    }

    /// Reports a plugin that is not in `supported`: a warning if it is in `substitutes`, else an
    /// error.
    pub(super) fn unsupported(
        &self,
        props: &Props<'_>,
        supported: &[&'static str],
        substitutes: &[Substitute],
    ) {
        let plugin = props.plugin();
        let tag = props.object().family.tag();
        if let Some((_, substitute)) = substitutes.iter().find(|(name, _)| *name == plugin.value) {
            let message = format!("{} is not supported; {substitute}", props.describe());
            let problem = Problem::new("scene::unsupported", plugin.span, message);
            self.sink
                .warn_once(props.describe(), problem.label("not supported"));
        } else if !plugin.value.is_empty() && !plugin.value.contains('$') {
            let others = substitutes.iter().map(|(name, _)| *name);
            let known = supported.iter().copied().chain(others);
            let label = format!("no {tag} plugin has this name");
            let list = format!("supported types: {}", supported.join(", "));
            report_unknown(self.sink, (tag, plugin), known, (label, list));
        }
    }

    /// Reports a plugin of 0.x in a file of a later version.
    pub(super) fn require_v0(&self, props: &Props<'_>, advice: &str) {
        if !props.is_v0() {
            let object = props.describe();
            let message = format!("{object} is supported only in files of version 0.x");
            let help = format!("{advice}, or declare `<scene version=\"0.6.0\">`");
            let problem = Problem::new("scene::unknown_plugin", props.span(), message);
            self.sink.error(problem.help(help));
        }
    }

    /// Warns once about the parameter `name`, which is not supported. `what` completes the message.
    pub(super) fn warn_feature(&self, props: &Props<'_>, name: &'static str, what: &str) {
        if let Some(param) = props.get(name) {
            let subject = format!("{} {name}", props.describe());
            let message = format!("`{name}` of {} {what}", props.describe());
            self.sink.unsupported(subject, param.name.span, message);
        }
    }
}
