//! Shapes of scene files.

use super::Mesh;
use crate::math::Vec3;

/// A surface in object space. Rectangles and cubes are meshes.
#[derive(Clone, Debug)]
pub enum Shape {
    /// Indexed triangles.
    Mesh(Mesh),
    /// A sphere; normals point outwards.
    Sphere {
        /// Center.
        center: Vec3,
        /// Radius, > 0.
        radius: f32,
    },
    /// The unit disk in the plane z = 0 with normal +z; uv is (radius, azimuth / 2π).
    Disk,
    /// The open cylinder of `radius` around the segment from `p0` to `p1`; normals point outwards.
    Cylinder {
        /// Start of the axis.
        p0: Vec3,
        /// End of the axis.
        p1: Vec3,
        /// Radius, > 0.
        radius: f32,
    },
}
