//! Textures with attributes of mesh files.

use super::sink::{FileSpan, Problem, Sink};
use crate::mesh::MeshAttribute;
use manylight::geometry::Mesh;
use manylight::ids::{ShapeId, TextureId};
use manylight::scene::SceneDesc;
use manylight::texture::Texture;

/// A texture with the values of an attribute of a mesh.
pub(super) struct AttributeRequest {
    pub(super) shape: ShapeId,
    /// Name as in Mitsuba.
    pub(super) name: String,
    /// Factor of the values.
    pub(super) scale: f32,
    pub(super) texture: TextureId,
    pub(super) span: FileSpan,
}

impl AttributeRequest {
    /// Stores the values of an attribute of `mesh`. Its absence is reported.
    pub(super) fn store(
        &self,
        desc: &mut SceneDesc,
        mesh: &Mesh,
        found: &[MeshAttribute],
        sink: &Sink,
    ) {
        let Some(attribute) = found.iter().find(|a| a.name == self.name) else {
            let message = format!("the mesh has no attribute `{}`", self.name);
            let names: Vec<&str> = found.iter().map(|a| a.name.as_str()).collect();
            let help = if names.is_empty() {
                "the file has no attributes".to_owned()
            } else {
                format!("it has {}", names.join(", "))
            };
            let problem = Problem::new("scene::missing_attribute", self.span, message);
            sink.error(problem.help(help));
            return;
        };
        if attribute.from_integers && attribute.name.ends_with("color") {
            let message = format!(
                "the integers of `{}` are read as sRGB values, their largest one as 1; Mitsuba takes them as they are",
                attribute.name
            );
            let problem = Problem::new("scene::integer_colors", self.span, message);
            sink.warn_once("integer colors", problem);
        }
        desc.textures[self.texture.index()] =
            Texture::VertexColors(attribute.over(mesh, self.scale));
    }
}
