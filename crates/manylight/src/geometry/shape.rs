//! Shapes of scene files, and where they are placed.

use super::mesh::Mesh;
use crate::ids::{EmitterId, MaterialId, ShapeId};
use crate::math::{Affine3A, Vec3};

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

/// A shape with a transform, a material and an optional emitter.
#[derive(Clone, Debug)]
pub struct Primitive {
    /// The shape, in object space.
    pub shape: ShapeId,
    /// Transform of the shape into the world, or into the space of its group.
    pub world_from_object: Affine3A,
    /// Whether the geometric and the shading normal are reversed.
    pub flip_normals: bool,
    /// Scattering material.
    pub material: MaterialId,
    /// Emitter of the surface, if any.
    pub emitter: Option<EmitterId>,
    /// Whether light can pass straight through (masks, null, thin glass). Such a surface does not
    /// count in [`Geometry::occluded`](super::Geometry::occluded).
    pub transparent: bool,
    /// Whether no ray and no segment meets the surface: that of an
    /// [`InvisibleArea`](crate::emitters::Emitter::InvisibleArea).
    pub invisible: bool,
}

/// A copy of a group of primitives under another transform.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Index of the group.
    pub group: u32,
    /// Transform of the group into the world.
    pub world_from_group: Affine3A,
}
