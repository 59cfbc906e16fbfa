//! Attributes of meshes: colors or numbers at vertices or faces beside position, normal and texture
//! coordinates.

use manylight::color::Rgb;
use manylight::geometry::Mesh;
use manylight::texture::VertexValues;

/// Where the values of an attribute lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AttributePlace {
    /// At the vertices; they are interpolated over triangles.
    Vertices,
    /// On the triangles.
    Triangles,
}

/// A named attribute of a mesh. Numbers have three equal channels.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshAttribute {
    /// Name as in Mitsuba, which starts with `vertex_` or `face_`.
    pub name: String,
    /// Where the values lie.
    pub place: AttributePlace,
    /// Whether the file stores integers. They are read as fractions of the largest one, with the
    /// sRGB transfer function.
    pub from_integers: bool,
    /// One value for each vertex or triangle.
    pub values: Vec<Rgb>,
}

impl MeshAttribute {
    /// The values times `scale`, by the corners of the triangles of the mesh.
    pub fn over(&self, mesh: &Mesh, scale: f32) -> VertexValues<Rgb> {
        let triangles = match self.place {
            AttributePlace::Vertices => mesh.triangles.clone(),
            AttributePlace::Triangles => (0..mesh.triangles.len() as u32).map(|i| [i; 3]).collect(),
        };
        VertexValues {
            triangles,
            values: self.values.iter().map(|&value| value * scale).collect(),
        }
    }
}
