//! Mitsuba's XML scene format, versions 0.4 to 3.
//!
//! Names, defaults and meanings of plugins are those of Mitsuba 3.9. Loading has four stages:
//!
//! 1. `xml` parses text into a tree of elements with source spans.
//! 2. `object` turns it into a tree of plugins with parameters; `values` parses the parameters, and `upgrade` renames those of
//!    old files.
//! 3. One module for each plugin family (`bsdfs`, `shapes`, ...) reads the parameters by `props` and fills a [`SceneDesc`].
//! 4. `assets` reads meshes and images in parallel.
//!
//! To add a plugin, add its name to the `SUPPORTED` list of its family and an arm to the `match` there.

mod attributes;
mod bsdfs;
mod colors;
mod emitters;
mod integrators;
mod object;
mod props;
mod sensors;
mod shape_files;
mod shapes;
mod skies;
mod textures;
mod upgrade;
mod values;
mod xml;

use super::assets::Assets;
use super::names::ShapeNames;
use super::sink::{Problem, Sink};
use super::{LoadOptions, SupportedFamily};
use crate::resolve::similar;
use attributes::{CurrentShape, Scoped};
use emitters::PendingProjector;
use manylight::ids::{EmitterId, MaterialId, ShapeId, TextureId};
use manylight::scene::SceneDesc;
use object::{ObjectId, ObjectTree, PluginFamily};
use props::Props;
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

/// The supported plugins, by family.
pub(super) const SUPPORTED: &[SupportedFamily] = &[
    SupportedFamily {
        format: "mitsuba",
        name: "bsdfs",
        plugins: bsdfs::SUPPORTED,
    },
    SupportedFamily {
        format: "mitsuba",
        name: "emitters",
        plugins: emitters::SUPPORTED,
    },
    SupportedFamily {
        format: "mitsuba",
        name: "shapes",
        plugins: shapes::SUPPORTED,
    },
    SupportedFamily {
        format: "mitsuba",
        name: "textures",
        plugins: textures::SUPPORTED,
    },
    SupportedFamily {
        format: "mitsuba",
        name: "sensors",
        plugins: sensors::SUPPORTED,
    },
    SupportedFamily {
        format: "mitsuba",
        name: "filters",
        plugins: sensors::FILTERS,
    },
    SupportedFamily {
        format: "mitsuba",
        name: "integrators",
        plugins: integrators::SUPPORTED,
    },
];

/// The scene in `text`, the content of `path`, without its invalid parts. `None` only if an error has been reported.
pub(super) fn load(
    path: &Path,
    text: Arc<str>,
    options: &LoadOptions,
    sink: &Sink,
) -> Option<SceneDesc> {
    let root = xml::read_tree(path, text, &options.defines, sink)?;
    let tree = ObjectTree::new(&root, sink)?;
    let mut builder = DescBuilder {
        tree: &tree,
        sink,
        desc: SceneDesc::default(),
        materials: HashMap::new(),
        plain_materials: HashMap::new(),
        textures: HashMap::new(),
        bitmaps: HashMap::new(),
        area_emitters: HashMap::new(),
        groups: HashMap::new(),
        fronts: HashMap::new(),
        projectors: Vec::new(),
        per_shape: HashMap::new(),
        current_shape: None,
        builtin_shapes: HashMap::new(),
        shape_names: ShapeNames::default(),
        assets: Assets::default(),
    };
    builder.scene();
    let DescBuilder {
        mut desc,
        assets,
        projectors,
        ..
    } = builder;
    assets.load(&mut desc, sink);
    projectors
        .iter()
        .for_each(|projector| projector.fit(&mut desc));
    Some(desc)
}

/// A plugin of Mitsuba that is not supported, and the description of its replacement in messages.
type Substitute = (&'static str, &'static str);

/// The description for plugins without a replacement.
const IGNORED: &str = "it is ignored";

/// Fills a [`SceneDesc`] from a tree of objects. The maps keep the ids of objects that are used several times.
struct DescBuilder<'a> {
    tree: &'a ObjectTree,
    sink: &'a Sink,
    desc: SceneDesc,
    materials: HashMap<Scoped, MaterialId>,
    plain_materials: HashMap<bsdfs::PlainMaterial, MaterialId>,
    textures: HashMap<Scoped, TextureId>,
    bitmaps: HashMap<textures::BitmapKey, TextureId>,
    area_emitters: HashMap<Scoped, EmitterId>,
    groups: HashMap<ObjectId, usize>,
    /// Materials that are invisible from behind, by the material in front.
    fronts: HashMap<MaterialId, MaterialId>,
    projectors: Vec<PendingProjector>,
    /// Whether an object contains textures that differ between shapes.
    per_shape: HashMap<ObjectId, bool>,
    current_shape: Option<CurrentShape>,
    builtin_shapes: HashMap<&'static str, ShapeId>,
    shape_names: ShapeNames,
    assets: Assets,
}

impl<'a> DescBuilder<'a> {
    fn props(&self, id: ObjectId) -> Props<'a> {
        Props::new(self.tree, id, self.sink)
    }

    /// Adds all objects of the scene.
    fn scene(&mut self) {
        let root = self.props(ObjectTree::ROOT);
        for (id, _) in root.objects(PluginFamily::Bsdf) {
            if !self.is_per_shape(id) {
                self.material(id);
            }
        }
        for (id, _) in root.objects(PluginFamily::Shape) {
            self.shape(id);
        }
        for (id, _) in root.objects(PluginFamily::Emitter) {
            self.emitter(id);
        }
        for (id, _) in root.objects(PluginFamily::Sensor) {
            self.sensor(id);
        }
        for (id, _) in root.objects(PluginFamily::Texture) {
            if !self.is_per_shape(id) {
                self.texture(id);
            }
        }
        if let Some(id) = root.single(PluginFamily::Integrator) {
            self.desc.limits = integrators::limits(&self.props(id), self);
        }
        for family in [
            PluginFamily::Medium,
            PluginFamily::Phase,
            PluginFamily::Volume,
            PluginFamily::Subsurface,
        ] {
            for (id, _) in root.objects(family) {
                self.ignore_medium(id);
            }
        }
        root.objects(PluginFamily::Spectrum);
        // Settings of acceleration structures have no effect.
        for prefix in ["kd_", "embree_"] {
            root.ignore_prefix(prefix);
        }
        root.ignore(&["allow_thread_reordering", "id"]);
        self.check_whole(&root);
        root.finish();
    }

    /// Reports scenes without a sensor or an emitter.
    fn check_whole(&self, root: &Props<'_>) {
        let no_sensor = root.objects(PluginFamily::Sensor).is_empty();
        if no_sensor || self.desc.sensors.is_empty() && !self.sink.has_errors() {
            let message = if no_sensor {
                "the scene has no sensor"
            } else {
                "the scene has no supported sensor"
            };
            let problem = Problem::new("scene::no_sensor", root.span(), message);
            self.sink
                .error(problem.help("add for example <sensor type=\"perspective\"/>"));
        }
        if !self.tree.has(PluginFamily::Emitter) {
            let message = "the scene has no emitter; its image will be black";
            self.sink
                .warn(Problem::new("scene::no_emitter", root.span(), message));
        }
    }

    /// Warns once about participating media.
    fn ignore_medium(&self, id: ObjectId) {
        let props = self.props(id);
        let message = format!(
            "{} is ignored: participating media are not supported",
            props.describe()
        );
        self.sink.warn_once(
            "participating media",
            Problem::new("scene::unsupported", props.span(), message),
        );
    }

    /// Reports a plugin that is not in `supported`: a warning if it is in `substitutes`, else an error.
    fn unsupported(
        &self,
        props: &Props<'_>,
        supported: &[&'static str],
        substitutes: &[Substitute],
    ) {
        let plugin = props.plugin();
        let tag = props.object().family.tag();
        if let Some((_, substitute)) = substitutes.iter().find(|(name, _)| *name == plugin.value) {
            let message = format!("{} is not supported; {substitute}", props.describe());
            let problem =
                Problem::new("scene::unsupported", plugin.span, message).label("not supported");
            self.sink.warn_once(props.describe(), problem);
        } else if !plugin.value.is_empty() && !plugin.value.contains('$') {
            let known = supported
                .iter()
                .chain(substitutes.iter().map(|(name, _)| name))
                .copied();
            let list = format!("supported types: {}", supported.join(", "));
            let help = match similar(&plugin.value, known) {
                Some(similar) => format!("did you mean `{similar}`? {list}"),
                None => list,
            };
            let message = format!("unknown {tag} type `{}`", plugin.value);
            let problem = Problem::new("scene::unknown_plugin", plugin.span, message);
            self.sink.error(
                problem
                    .label(format!("no {tag} plugin has this name"))
                    .help(help),
            );
        }
    }

    /// Reports a plugin of 0.x in a file of a later version.
    fn require_v0(&self, props: &Props<'_>, advice: &str) {
        if !props.is_v0() {
            let message = format!(
                "{} is supported only in files of version 0.x",
                props.describe()
            );
            let help = format!("{advice}, or declare `<scene version=\"0.6.0\">`");
            self.sink
                .error(Problem::new("scene::unknown_plugin", props.span(), message).help(help));
        }
    }

    /// Warns once about the parameter `name`, which is not supported. `what` completes the message.
    fn warn_feature(&self, props: &Props<'_>, name: &'static str, what: &str) {
        if let Some(param) = props.get(name) {
            let subject = format!("{} {name}", props.describe());
            let message = format!("`{name}` of {} {what}", props.describe());
            self.sink.warn_once(
                subject,
                Problem::new("scene::unsupported", param.name.span, message),
            );
        }
    }
}
