//! A point on a surface, as transport sees it.

use super::{Ray, Segment};
use crate::ids::PrimitiveId;
use crate::math::{Frame, Vec2, Vec3};

/// Names a point on a surface in 24 bytes, so that particles can be stored by the million and looked at again.
/// See [`Geometry::surface_point`](super::Geometry::surface_point).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceRef {
    /// The primitive.
    pub primitive: PrimitiveId,
    /// Triangle of a mesh; 0 for other shapes.
    pub element: u32,
    /// The instance through which the primitive was hit, or [`SurfaceRef::NO_INSTANCE`].
    pub instance: u32,
    /// Barycentric coordinates of the second and third corner for meshes; the shape's own parameters otherwise.
    pub coordinates: Vec2,
}

impl SurfaceRef {
    /// Not seen through an instance.
    pub const NO_INSTANCE: u32 = u32::MAX;
}

/// A point on a surface in world space.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Position.
    pub p: Vec3,
    /// Geometric normal, unit, on the side that the shape calls outside (after `flip_normals`); never turned to the viewer.
    pub ng: Vec3,
    /// Shading frame: z is the (interpolated) shading normal, x follows `dp_du`.
    pub frame: Frame,
    /// Texture coordinates, v upwards as in the mesh file.
    pub uv: Vec2,
    /// Derivative of the position by u; for tangent space and bump maps.
    pub dp_du: Vec3,
    /// Derivative of the position by v.
    pub dp_dv: Vec3,
    /// Where this point is, compactly.
    pub at: SurfaceRef,
    /// How far a ray must start off the surface to be safe from rounding, in world units.
    pub offset: f32,
}

impl SurfacePoint {
    /// The position moved off the surface to the side of `w`.
    #[inline]
    pub fn offset_towards(&self, w: Vec3) -> Vec3 {
        self.p + self.ng * self.offset.copysign(self.ng.dot(w))
    }

    /// The geometric normal on the side of `w`.
    #[inline]
    pub fn normal_towards(&self, w: Vec3) -> Vec3 {
        self.ng * 1.0f32.copysign(self.ng.dot(w))
    }

    /// A ray that leaves along the unit vector `w`.
    #[inline]
    pub fn spawn(&self, w: Vec3) -> Ray {
        Ray::new(self.offset_towards(w), w)
    }

    /// The segment to another surface point, both ends moved off their surfaces.
    #[inline]
    pub fn segment_to(&self, other: &SurfacePoint) -> Segment {
        let w = other.p - self.p;
        Segment {
            from: self.offset_towards(w),
            to: other.offset_towards(-w),
        }
    }
}
