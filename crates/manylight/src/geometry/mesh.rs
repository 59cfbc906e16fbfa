//! Indexed triangle meshes.

use crate::math::{Aabb, Vec2, Vec3};

/// Triangles over shared vertices. The geometric normal follows the right-hand rule over the three corners.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// One per vertex.
    pub positions: Vec<Vec3>,
    /// One unit shading normal per vertex, or empty for faceted shading.
    pub normals: Vec<Vec3>,
    /// One per vertex, or empty: then each triangle has (0,0), (1,0), (0,1), as Mitsuba does.
    pub uvs: Vec<Vec2>,
    /// Vertex indices; all smaller than `positions.len()`.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The square [-1, 1]² in the plane z = 0 with normal +z and uv from (0,0) at (-1,-1) to (1,1) at (1,1).
    pub fn rectangle() -> Self {
        todo!()
    }

    /// The cube [-1, 1]³ with outward faceted normals and uv [0,1]² on each face.
    pub fn cube() -> Self {
        todo!()
    }

    /// The smallest box around the vertices that triangles use.
    pub fn bounds(&self) -> Aabb {
        Aabb::from_points(self.triangles.iter().flatten().map(|&i| self.positions[i as usize]))
    }
}
