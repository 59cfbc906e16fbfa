//! Indexed triangle meshes.

use crate::math::{Aabb, Vec2, Vec3};

/// Triangles over shared vertices. The geometric normal follows from the order of the three corners
/// by the right-hand rule.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Position of each vertex.
    pub positions: Vec<Vec3>,
    /// Unit shading normal of each vertex; empty for faceted shading.
    pub normals: Vec<Vec3>,
    /// Direction of the x axis of the shading frame at each vertex; if empty, that in which u
    /// grows. Needs `normals`.
    pub tangents: Vec<Vec3>,
    /// Texture coordinates of each vertex. If empty, the corners of each triangle have (0,0),
    /// (1,0), (0,1), as in Mitsuba.
    pub uvs: Vec<Vec2>,
    /// Indices of the three vertices; all smaller than `positions.len()`.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The square [-1, 1]² in the plane z = 0 with normal +z and uv from (0,0) at (-1,-1) to (1,1)
    /// at (1,1).
    pub fn rectangle() -> Self {
        Mesh {
            positions: [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)]
                .map(|(x, y)| Vec3::new(x, y, 0.0))
                .to_vec(),
            normals: vec![Vec3::Z; 4],
            tangents: Vec::new(),
            uvs: [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)]
                .map(Vec2::from)
                .to_vec(),
            triangles: vec![[1, 2, 0], [1, 3, 2]],
        }
    }

    /// The cube [-1, 1]³ with outward faceted normals and uv from (0,0) to (1,1) on each face.
    pub fn cube() -> Self {
        // Corners of each face in the order of the uvs (0,1), (1,1), (1,0), (0,0), as in Mitsuba.
        const FACES: [(Vec3, [[i8; 3]; 4]); 6] = [
            (
                Vec3::NEG_Y,
                [[1, -1, -1], [1, -1, 1], [-1, -1, 1], [-1, -1, -1]],
            ),
            (Vec3::Y, [[1, 1, -1], [-1, 1, -1], [-1, 1, 1], [1, 1, 1]]),
            (Vec3::X, [[1, -1, -1], [1, 1, -1], [1, 1, 1], [1, -1, 1]]),
            (Vec3::Z, [[1, -1, 1], [1, 1, 1], [-1, 1, 1], [-1, -1, 1]]),
            (
                Vec3::NEG_X,
                [[-1, -1, 1], [-1, 1, 1], [-1, 1, -1], [-1, -1, -1]],
            ),
            (
                Vec3::NEG_Z,
                [[1, 1, -1], [1, -1, -1], [-1, -1, -1], [-1, 1, -1]],
            ),
        ];
        let corner = |c: [i8; 3]| Vec3::from_array(c.map(f32::from));
        Mesh {
            positions: FACES.iter().flat_map(|face| face.1.map(corner)).collect(),
            normals: FACES.iter().flat_map(|face| [face.0; 4]).collect(),
            tangents: Vec::new(),
            uvs: [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]
                .map(Vec2::from)
                .repeat(6),
            triangles: (0..6)
                .flat_map(|f| [[4 * f, 4 * f + 1, 4 * f + 2], [4 * f + 3, 4 * f, 4 * f + 2]])
                .collect(),
        }
    }

    /// Bounding box of the vertices that triangles use.
    pub fn bounds(&self) -> Aabb {
        Aabb::from_points(
            self.triangles
                .iter()
                .flatten()
                .map(|&i| self.positions[i as usize]),
        )
    }
}
