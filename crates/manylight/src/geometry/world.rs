//! All surfaces of a scene: nearest hit, visibility, and points by area.

use super::{Ray, Segment, Shape, SurfacePoint, SurfaceRef};
use crate::ids::{EmitterId, MaterialId, PrimitiveId, ShapeId};
use crate::math::{Aabb, Affine3A, Vec2, Vec3};

/// One placed surface: what a ray can hit.
#[derive(Clone, Debug)]
pub struct Primitive {
    /// The shape, in object space.
    pub shape: ShapeId,
    /// Places the shape in the world (or in its group).
    pub world_from_object: Affine3A,
    /// Turn both normals round.
    pub flip_normals: bool,
    /// How it scatters.
    pub material: MaterialId,
    /// What it emits.
    pub emitter: Option<EmitterId>,
    /// Whether light can pass straight through (masks, null, thin glass): such surfaces do not block [`Geometry::occluded`].
    pub transparent: bool,
}

/// A copy of a group of primitives somewhere else.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Index of the group.
    pub group: u32,
    /// Places the group in the world.
    pub world_from_group: Affine3A,
}

/// The nearest surface along a ray.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Distance along the ray in units of its direction.
    pub t: f32,
    /// Where.
    pub at: SurfaceRef,
}

/// A point drawn uniformly by area.
#[derive(Clone, Copy, Debug)]
pub struct AreaSample {
    /// The point.
    pub point: SurfacePoint,
    /// 1 / area of the primitive, in 1/m².
    pub pdf_area: f32,
}

/// Shapes, primitives, instances and the acceleration structure over them. Immutable once built.
#[derive(Debug)]
pub struct Geometry {
    shapes: Vec<Shape>,
    primitives: Vec<Primitive>,
}

impl Geometry {
    /// Builds the acceleration structures. `primitives` holds the world's own first and then, group by group, those of
    /// the groups: `groups[g]` is the range of group `g`. Ids must be in range; degenerate triangles are allowed and never hit.
    pub fn build(
        _shapes: Vec<Shape>,
        _primitives: Vec<Primitive>,
        _groups: Vec<std::ops::Range<usize>>,
        _instances: Vec<Instance>,
    ) -> Self {
        todo!()
    }

    /// The placed surfaces; index by [`PrimitiveId`].
    pub fn primitives(&self) -> &[Primitive] {
        &self.primitives
    }

    /// The shapes in object space; index by [`ShapeId`].
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// Box around everything, instances included; empty for an empty scene.
    pub fn bounds(&self) -> Aabb {
        todo!()
    }

    /// Number of triangles stored (instances not multiplied).
    pub fn triangle_count(&self) -> usize {
        todo!()
    }

    /// The nearest surface with `0 < t < ray.t_max`, opaque or transparent.
    pub fn intersect(&self, _ray: &Ray) -> Option<Hit> {
        todo!()
    }

    /// Whether an opaque surface lies on the segment.
    pub fn occluded(&self, _segment: &Segment) -> bool {
        todo!()
    }

    /// Visibility from one point to up to 64 others at once: bit `i` is set when an opaque surface lies between `from` and `to[i]`.
    /// Bits beyond `to.len()` are 0. Equal to single [`Geometry::occluded`] calls, only faster.
    pub fn occluded_packet(&self, _from: Vec3, _to: &[Vec3]) -> u64 {
        todo!()
    }

    /// Whether any surface lets light straight through; if not, [`Geometry::occluded`] is the whole story.
    pub fn has_transparent(&self) -> bool {
        todo!()
    }

    /// The nearest transparent surface on the ray.
    pub fn intersect_transparent(&self, _ray: &Ray) -> Option<Hit> {
        todo!()
    }

    /// The full description of a hit or stored reference. Needs no ray.
    pub fn surface_point(&self, _at: SurfaceRef) -> SurfacePoint {
        todo!()
    }

    /// Area of a primitive in the world, instances ignored, in m².
    pub fn area(&self, _primitive: PrimitiveId) -> f32 {
        todo!()
    }

    /// A point of the primitive, uniform by area. `None` if its area is 0.
    pub fn sample_area(&self, _primitive: PrimitiveId, _u: Vec2) -> Option<AreaSample> {
        todo!()
    }
}
