//! Queries along rays and segments: the nearest hit, visibility, and transparent surfaces. For
//! single rays, for streams of rays such as the paths of a tile, and for blocks of segments.

use super::block::{BLOCK, SegmentEnds, cut_segments};
use super::level::SurfaceClass;
use super::surface_set::{Object, SurfaceSet};
use super::{Geometry, Hit, Ray, Segment, SurfaceRef};
use crate::ids::PrimitiveId;
use crate::math::Vec3;

impl Geometry {
    /// The nearest hit with `0 < t < ray.t_max`, opaque or transparent.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let opaque = self.nearest(SurfaceClass::Opaque, ray);
        if !self.has_transparent() {
            return opaque;
        }
        self.nearest(SurfaceClass::Transparent, &up_to(ray, &opaque))
            .or(opaque)
    }

    /// Whether an opaque surface lies on the segment.
    pub fn occluded(&self, segment: &Segment) -> bool {
        let surfaces = &self.world.opaque;
        surfaces.any_triangle(segment)
            || (surfaces.has_objects() && self.any_object(surfaces, segment))
    }

    /// [`Geometry::intersect`] for each ray, with the same bits: element `i` of `hits` becomes the
    /// hit of `rays[i]`. Faster than single calls from a few dozen rays on, most of all for rays
    /// with similar origins and directions that are neighbors in the list.
    pub fn intersect_stream(&self, rays: &[Ray], hits: &mut Vec<Option<Hit>>) {
        self.nearest_of_class(SurfaceClass::Opaque, rays, hits);
        if self.has_transparent() {
            let rest: Vec<Ray> = rays
                .iter()
                .zip(&*hits)
                .map(|(ray, hit)| up_to(ray, hit))
                .collect();
            let mut transparent = Vec::new();
            self.nearest_of_class(SurfaceClass::Transparent, &rest, &mut transparent);
            for (hit, transparent) in hits.iter_mut().zip(transparent) {
                *hit = transparent.or(*hit);
            }
        }
    }

    /// [`Geometry::occluded`] for each segment: element `i` of `occluded` becomes the answer for
    /// `segments[i]`. Fast as [`Geometry::intersect_stream`] is.
    pub fn occluded_stream(&self, segments: &[Segment], occluded: &mut Vec<bool>) {
        let surfaces = &self.world.opaque;
        surfaces.any_triangles(segments, occluded);
        if surfaces.has_objects() {
            for (segment, occluded) in segments.iter().zip(occluded) {
                *occluded = *occluded || self.any_object(surfaces, segment);
            }
        }
    }

    /// Visibility between up to [`BLOCK`] origins and up to [`BLOCK`] targets.
    ///
    /// `wanted[i]` has one bit per target and one element per origin. Bit `j` of element `i` of the
    /// result is set if bit `j` of `wanted[i]` is set and an opaque surface lies between
    /// `origins[i]` and `targets[j]`. Fastest if both groups are compact and neighbors in space are
    /// neighbors in the lists. Equal to single calls of [`Geometry::occluded`], except for segments
    /// that graze an edge.
    pub fn occluded_block(
        &self,
        origins: &[Vec3],
        targets: &[Vec3],
        wanted: &[u64],
    ) -> [u64; BLOCK] {
        let ends = SegmentEnds { origins, targets };
        cut_segments(self, SurfaceClass::Opaque, ends, wanted)
    }

    /// [`Geometry::occluded_block`] for transparent surfaces: the segments that cross at least one.
    pub fn crossing_block(
        &self,
        origins: &[Vec3],
        targets: &[Vec3],
        wanted: &[u64],
    ) -> [u64; BLOCK] {
        let ends = SegmentEnds { origins, targets };
        cut_segments(self, SurfaceClass::Transparent, ends, wanted)
    }

    /// Whether any surface is transparent. If none is, [`Geometry::occluded`] decides visibility
    /// completely.
    pub fn has_transparent(&self) -> bool {
        !self.world.transparent.is_empty()
    }

    /// Calls `visit` for all hits of the segment with transparent surfaces, in any order, until
    /// `visit` returns true.
    pub fn visit_transparent(&self, segment: &Segment, mut visit: impl FnMut(Hit) -> bool) {
        self.visit_in_set(&self.world.transparent, segment, &mut visit);
    }

    /// Visits the hits in `surfaces`; returns whether `visit` returned true.
    pub(super) fn visit_in_set(
        &self,
        surfaces: &SurfaceSet,
        segment: &Segment,
        visit: &mut dyn FnMut(Hit) -> bool,
    ) -> bool {
        if surfaces.visit_triangles(segment, &mut *visit) {
            return true;
        }
        if !surfaces.has_objects() {
            return false;
        }
        let mut ended = false;
        let whole = segment.ray();
        surfaces.visit_objects(&whole, |object, t_max| {
            ended = match object {
                Object::Analytic(primitive) => self.visit_analytic(primitive, segment, visit),
                Object::Instance(index) => {
                    let instance = &self.instances[index];
                    let group = &self.groups[instance.group()].transparent;
                    let segment = instance.segment_in_group(segment);
                    self.visit_in_set(group, &segment, &mut |mut hit| {
                        hit.at.instance = index as u32;
                        visit(hit)
                    })
                }
            };
            if ended { 0.0 } else { t_max }
        });
        ended
    }

    /// Visits the hits with an analytic shape; returns whether `visit` returned true.
    fn visit_analytic(
        &self,
        primitive: PrimitiveId,
        segment: &Segment,
        visit: &mut dyn FnMut(Hit) -> bool,
    ) -> bool {
        /// Largest number of intersections of a line with a quadric.
        const MAX: usize = 2;
        let (mut rest, mut start) = (*segment, 0.0);
        for _ in 0..MAX {
            let shape = &self.placements[primitive.index()];
            let Some(mut hit) = shape.intersect_analytic(primitive, &rest.ray()) else {
                return false;
            };
            hit.t = start + (1.0 - start) * hit.t;
            if visit(hit) {
                return true;
            }
            let x = self.surface_point(hit.at);
            rest.from = x.offset_towards(rest.to - rest.from);
            start = hit.t;
        }
        false
    }

    /// The nearest hit with surfaces of one class.
    #[inline]
    fn nearest(&self, class: SurfaceClass, ray: &Ray) -> Option<Hit> {
        let surfaces = self.world.surfaces(class);
        let triangle = surfaces.nearest_triangle(ray);
        if !surfaces.has_objects() {
            return triangle;
        }
        self.nearest_object(class, surfaces, &up_to(ray, &triangle))
            .or(triangle)
    }

    /// The nearest hits with surfaces of one class.
    fn nearest_of_class(&self, class: SurfaceClass, rays: &[Ray], hits: &mut Vec<Option<Hit>>) {
        let surfaces = self.world.surfaces(class);
        surfaces.nearest_triangles(rays, hits);
        if surfaces.has_objects() {
            for (ray, hit) in rays.iter().zip(hits) {
                *hit = self
                    .nearest_object(class, surfaces, &up_to(ray, hit))
                    .or(*hit);
            }
        }
    }

    /// The nearest hit with an analytic shape or an instance in the set.
    fn nearest_object(&self, class: SurfaceClass, surfaces: &SurfaceSet, ray: &Ray) -> Option<Hit> {
        let mut best = None;
        let mut rest = *ray;
        surfaces.visit_objects(ray, |object, t_max| {
            rest.t_max = t_max;
            let hit = match object {
                Object::Analytic(primitive) => {
                    self.placements[primitive.index()].intersect_analytic(primitive, &rest)
                }
                Object::Instance(index) => self.nearest_in_instance(class, index, &rest),
            };
            best = hit.or(best);
            hit.map_or(t_max, |hit| hit.t)
        });
        best
    }

    /// The nearest hit with surfaces of one class in an instance.
    fn nearest_in_instance(&self, class: SurfaceClass, index: usize, ray: &Ray) -> Option<Hit> {
        let instance = &self.instances[index];
        let surfaces = self.groups[instance.group()].surfaces(class);
        let local = instance.ray_in_group(ray);
        let triangle = surfaces.nearest_triangle(&local);
        // Groups hold no instances.
        let object = self.nearest_object(class, surfaces, &up_to(&local, &triangle));
        let hit = object.or(triangle)?;
        let at = SurfaceRef {
            instance: index as u32,
            ..hit.at
        };
        Some(Hit { at, ..hit })
    }

    /// Whether an analytic shape or an instance blocks the segment.
    pub(super) fn any_object(&self, surfaces: &SurfaceSet, segment: &Segment) -> bool {
        surfaces.any_object(segment, |object| match object {
            Object::Analytic(primitive) => self.placements[primitive.index()].blocks(segment),
            Object::Instance(index) => {
                let instance = &self.instances[index];
                let group = &self.groups[instance.group()].opaque;
                let segment = instance.segment_in_group(segment);
                group.any_triangle(&segment) || self.any_object(group, &segment)
            }
        })
    }
}

/// The part of the ray before the hit.
fn up_to(ray: &Ray, hit: &Option<Hit>) -> Ray {
    Ray {
        t_max: hit.map_or(ray.t_max, |hit| hit.t),
        ..*ray
    }
}
