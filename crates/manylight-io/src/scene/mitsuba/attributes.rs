//! Textures with attributes of meshes. Materials and emitters that contain one are made for every shape.

use super::super::attributes::AttributeRequest;
use super::super::sink::Problem;
use super::DescBuilder;
use super::object::{ObjectId, PluginFamily};
use super::props::Props;
use super::values::Value;
use manylight::ids::{ShapeId, TextureId};
use manylight::texture::{Texture, VertexValues};

/// The shape that is being built.
#[derive(Clone, Copy, Debug)]
pub(super) struct CurrentShape {
    pub(super) object: ObjectId,
    /// Its geometry if that is a mesh of a file.
    pub(super) mesh: Option<ShapeId>,
}

/// An object, and the shape for which it is made if it differs between shapes.
pub(super) type Scoped = (ObjectId, Option<ObjectId>);

impl DescBuilder<'_> {
    /// Whether the object contains textures that differ between shapes.
    pub(super) fn is_per_shape(&mut self, id: ObjectId) -> bool {
        if let Some(known) = self.per_shape.get(&id) {
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
        self.per_shape.insert(id, result);
        result
    }

    /// The key of an object in the maps of what has been made.
    pub(super) fn scoped(&mut self, id: ObjectId) -> Scoped {
        let shape = self.current_shape.filter(|_| self.is_per_shape(id));
        (id, shape.map(|shape| shape.object))
    }

    /// The texture with an attribute of the current shape: a texture that is nested in the shape under this name, or values of its mesh.
    pub(super) fn mesh_attribute(&mut self, props: &Props<'_>) -> Option<TextureId> {
        let name = if props.plugin().value == "vertexcolors" {
            self.require_v0(props, "use `mesh_attribute`");
            "vertex_color".to_owned()
        } else {
            let name = props.required_string("name")?;
            if !name.value.contains("vertex_") && !name.value.contains("face_") {
                let expected = "the name of an attribute, which starts with `vertex_` or `face_`";
                props.refuse(props.get("name")?, expected);
                return None;
            }
            name.value
        };
        let scale = props.float("scale", 1.0);
        let shape = self.current_shape?;
        let owner = self.tree.get(shape.object);
        let nested = owner.params.iter().find(|param| param.name.value == name);
        if let Some(Value::Object(nested)) = nested.map(|param| &param.value) {
            let texture = self.color_texture(*nested)?;
            return Some(self.scaled(texture, scale));
        }
        let Some(mesh) = shape.mesh else {
            let message = format!(
                "{} needs the attribute `{name}`, but {} is no mesh with attributes",
                props.describe(),
                self.props(shape.object).describe()
            );
            let problem = Problem::new("scene::missing_attribute", props.span(), message);
            self.sink.error(problem);
            return None;
        };
        let texture = self.add_texture(Texture::VertexColors(VertexValues::default()));
        self.assets.add_attribute(AttributeRequest {
            shape: mesh,
            name,
            scale,
            texture,
            span: props.span(),
        });
        Some(texture)
    }
}
