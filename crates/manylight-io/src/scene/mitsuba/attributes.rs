//! Textures with attributes of meshes. Materials and emitters that contain one are made for every shape.

use super::super::attributes::AttributeRequest;
use super::super::description::Additions;
use super::super::parameters::{Numbers, Parameters};
use super::builder::DescBuilder;
use super::props::Props;
use super::values::Value;
use manylight::ids::TextureId;
use manylight::texture::{Texture, VertexValues};

impl DescBuilder<'_> {
    /// The texture with an attribute of the current shape: a texture that is nested in the shape under this name, or values of its mesh.
    pub(super) fn mesh_attribute(&mut self, props: &Props<'_>) -> Option<TextureId> {
        let name = if props.plugin().value == "vertexcolors" {
            self.require_v0(props, "use `mesh_attribute`");
            "vertex_color".to_owned()
        } else {
            let name = props.required_string("name")?;
            if !name.value.contains("vertex_") && !name.value.contains("face_") {
                let expected = "the name of an attribute, which starts with `vertex_` or `face_`";
                props.refuse_named("name", expected);
                return None;
            }
            name.value.clone()
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
            self.sink
                .error_at("scene::missing_attribute", props.span(), message);
            return None;
        };
        let texture = self
            .desc
            .add(Texture::VertexColors(VertexValues::default()));
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
