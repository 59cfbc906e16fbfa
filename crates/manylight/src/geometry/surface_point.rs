//! Points on surfaces: full, and as compact references.

use super::{Ray, Segment};
use crate::arrays::Fields;
use crate::ids::PrimitiveId;
use crate::math::{Frame, Vec2, Vec3};

/// Reference to a point on a surface, 20 bytes: small enough to store with every particle.
/// [`Geometry::surface_point`](super::Geometry::surface_point) restores the point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceRef {
    /// The primitive.
    pub primitive: PrimitiveId,
    /// Triangle of a mesh; 0 for other shapes.
    pub element: u32,
    /// The instance through which the primitive was hit, or [`SurfaceRef::NO_INSTANCE`].
    pub instance: u32,
    /// Meshes: barycentric coordinates of the second and third corner. Other shapes: the parameters
    /// of the surface, each in a domain that the shape defines.
    pub coordinates: Vec2,
}

impl SurfaceRef {
    /// Value of `instance` for a primitive of the world.
    pub const NO_INSTANCE: u32 = u32::MAX;
    /// The first surface of a scene.
    pub(crate) const FIRST: SurfaceRef = SurfaceRef {
        primitive: PrimitiveId(0),
        element: 0,
        instance: SurfaceRef::NO_INSTANCE,
        coordinates: Vec2::ZERO,
    };

    /// As fields of a record.
    pub(crate) fn fields(&mut self, f: &mut impl Fields) {
        f.word("primitive", &mut self.primitive.0);
        f.word("element", &mut self.element);
        f.word("instance", &mut self.instance);
        f.floats("coordinates", self.coordinates.as_mut());
    }
}

/// The nearest surface along a ray.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Ray parameter: distance in units of the length of the direction.
    pub t: f32,
    /// Hit point.
    pub at: SurfaceRef,
}

/// Offset of ray origins from their surface, in units of the rounding of the coordinates.
///
/// Estimated: two roundings in the point (a sum of three products), one in the sum of point and
/// offset, about three in the distance to the plane. Twice the sum allows for an angle between the
/// offset and the exact normal.
pub(super) const OFFSET_ROUNDINGS: f32 = 12.0;

/// A point on a surface in world space.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Position.
    pub p: Vec3,
    /// Geometric normal, unit, on the outer side of the shape after `flip_normals`; never turned to
    /// the viewer.
    pub ng: Vec3,
    /// Shading frame: z is the interpolated shading normal, x the direction of `dp_du` made
    /// orthogonal to z.
    pub frame: Frame,
    /// Texture coordinates, as in the mesh file.
    pub uv: Vec2,
    /// Derivative of the position by u, for tangent spaces and bump maps.
    pub dp_du: Vec3,
    /// Derivative of the position by v.
    pub dp_dv: Vec3,
    /// Compact reference to this point.
    pub at: SurfaceRef,
    /// Distance of ray origins from the surface that outweighs rounding, in the scene's unit.
    pub offset: f32,
}

impl SurfacePoint {
    /// The position moved off the surface by `offset`, to the side of `w`.
    #[inline]
    pub fn offset_towards(&self, w: Vec3) -> Vec3 {
        self.p + self.ng * self.offset.copysign(self.ng.dot(w))
    }

    /// The geometric normal on the side of `w`.
    #[inline]
    pub fn normal_towards(&self, w: Vec3) -> Vec3 {
        self.ng * 1.0f32.copysign(self.ng.dot(w))
    }

    /// A ray from this point along the unit vector `w`.
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
