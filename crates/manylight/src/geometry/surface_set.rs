//! The surfaces of one class in one space: a hierarchy over all triangles, and one over analytic
//! shapes and instances.

use super::bvh::{ObjectBvh, Shaft, TriangleBvh, TriangleHit};
use super::placement::{Numbering, PlacedShape, TriangleTable};
use super::{Hit, Ray, Segment, SurfaceRef};
use crate::ids::PrimitiveId;
use crate::math::{Aabb, Vec3};
#[cfg(any(test, feature = "testing"))]
use crate::simd::Instructions;
use crate::simd::Isa;
use std::sync::Arc;

/// An element of the hierarchy over boxes.
#[derive(Clone, Copy, Debug)]
pub(super) enum Object {
    /// A sphere, disk or cylinder.
    Analytic(PrimitiveId),
    /// An instance of a group, by index.
    Instance(usize),
}

/// The surfaces of one class in one space.
#[derive(Debug)]
pub(super) struct SurfaceSet {
    /// Triangles by their indices in the table.
    triangles: TriangleBvh,
    triangle_count: usize,
    numbering: Arc<Numbering>,
    object_bvh: ObjectBvh,
    objects: Vec<Object>,
}

impl SurfaceSet {
    pub(super) fn is_empty(&self) -> bool {
        self.triangles.is_empty() && self.object_bvh.is_empty()
    }

    pub(super) fn has_objects(&self) -> bool {
        !self.object_bvh.is_empty()
    }

    /// Instruction set of the kernels.
    pub(super) fn isa(&self) -> Isa {
        self.object_bvh.isa()
    }

    pub(super) fn bounds(&self) -> Aabb {
        self.triangles.bounds().union(self.object_bvh.bounds())
    }

    pub(super) fn triangle_count(&self) -> usize {
        self.triangle_count
    }

    pub(super) fn bytes(&self) -> usize {
        self.triangles.bytes()
    }

    #[cfg(any(test, feature = "testing"))]
    pub(super) fn use_instructions(&mut self, instructions: Instructions) {
        self.triangles.use_instructions(instructions);
        self.object_bvh.use_instructions(instructions);
    }

    #[inline]
    pub(super) fn nearest_triangle(&self, ray: &Ray) -> Option<Hit> {
        self.triangles.nearest(ray).map(|hit| self.hit(hit))
    }

    /// [`SurfaceSet::nearest_triangle`] for each ray.
    pub(super) fn nearest_triangles(&self, rays: &[Ray], hits: &mut Vec<Option<Hit>>) {
        hits.clear();
        hits.resize(rays.len(), None);
        self.triangles.nearest_stream(rays, |group, found| {
            for (lane, &index) in group.iter().enumerate() {
                if let Some(hit) = found.get(lane) {
                    hits[index as usize] = Some(self.hit(hit));
                }
            }
        });
    }

    /// [`SurfaceSet::any_triangle`] for each segment.
    pub(super) fn any_triangles(&self, segments: &[Segment], blocked: &mut Vec<bool>) {
        blocked.clear();
        blocked.resize(segments.len(), false);
        self.triangles.any_stream(segments, blocked);
    }

    /// Calls `visit` for all hits with triangles until it returns true; returns whether it has.
    pub(super) fn visit_triangles(
        &self,
        segment: &Segment,
        mut visit: impl FnMut(Hit) -> bool,
    ) -> bool {
        self.triangles
            .visit(&segment.ray(), |hit| visit(self.hit(hit)))
    }

    #[inline]
    fn hit(&self, hit: TriangleHit) -> Hit {
        let (primitive, element) = self.numbering.locate(hit.id);
        let at = SurfaceRef {
            primitive,
            element,
            instance: SurfaceRef::NO_INSTANCE,
            coordinates: hit.coordinates,
        };
        Hit { t: hit.t, at }
    }

    #[inline]
    pub(super) fn any_triangle(&self, segment: &Segment) -> bool {
        self.triangles.any(segment.from, segment.to)
    }

    #[inline]
    pub(super) fn open_of_triangles(
        &self,
        points: &[Vec3],
        lights: &[Vec3],
        wanted: &[u64],
    ) -> [u64; 64] {
        self.triangles.open_in_tile(points, lights, wanted)
    }

    /// See [`ObjectBvh::nearest`].
    pub(super) fn visit_objects(&self, ray: &Ray, mut visit: impl FnMut(Object, f32) -> f32) {
        self.object_bvh
            .nearest(ray, |index, t_max| visit(self.objects[index], t_max));
    }

    /// See [`ObjectBvh::visit_between`].
    pub(super) fn visit_objects_between(
        &self,
        shaft: &Shaft,
        mut visit: impl FnMut(Object) -> bool,
    ) -> bool {
        self.object_bvh
            .visit_between(shaft, |index| visit(self.objects[index]))
    }

    /// See [`ObjectBvh::any`].
    pub(super) fn any_object(&self, segment: &Segment, visit: impl Fn(Object) -> bool) -> bool {
        self.object_bvh
            .any(segment.from, segment.to, |index| visit(self.objects[index]))
    }
}

/// Collects the surfaces of a set.
#[derive(Default)]
pub(super) struct SurfaceSetBuilder {
    /// Indices in the table.
    triangles: Vec<u32>,
    boxes: Vec<Aabb>,
    objects: Vec<Object>,
}

impl SurfaceSetBuilder {
    pub(super) fn add_primitive(&mut self, primitive: PrimitiveId, placement: &PlacedShape) {
        match placement {
            PlacedShape::Mesh { triangles, .. } => self.triangles.extend(triangles.clone()),
            PlacedShape::Analytic { shape, .. } => {
                self.add_object(Object::Analytic(primitive), shape.bounds());
            }
        }
    }

    pub(super) fn add_instance(&mut self, index: usize, bounds: Aabb) {
        self.add_object(Object::Instance(index), bounds);
    }

    fn add_object(&mut self, object: Object, bounds: Aabb) {
        if bounds.min.is_finite() && bounds.max.is_finite() && !bounds.is_empty() {
            self.boxes.push(bounds);
            self.objects.push(object);
        }
    }

    pub(super) fn build(self, table: &TriangleTable) -> SurfaceSet {
        SurfaceSet {
            triangles: TriangleBvh::new(&self.triangles, |index| table.corners(index)),
            triangle_count: self.triangles.len(),
            numbering: Arc::clone(table.numbering()),
            object_bvh: ObjectBvh::new(&self.boxes),
            objects: self.objects,
        }
    }
}
