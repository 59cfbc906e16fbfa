//! Queries of many rays at once: the paths of a tile, in the order of the paths.

use super::level::SurfaceClass;
use super::queries::up_to;
use super::{Geometry, Hit, Ray, Segment};

impl Geometry {
    /// [`Geometry::intersect`] for each ray, with the same bits: element `i` of `hits` becomes the hit of `rays[i]`. Faster than
    /// single calls from a few dozen rays on, most of all for rays with similar origins and directions that are neighbors in the list.
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

    /// [`Geometry::occluded`] for each segment: element `i` of `occluded` becomes the answer for `segments[i]`. Fast as
    /// [`Geometry::intersect_stream`] is.
    pub fn occluded_stream(&self, segments: &[Segment], occluded: &mut Vec<bool>) {
        let surfaces = &self.world.opaque;
        surfaces.any_triangles(segments, occluded);
        if surfaces.has_objects() {
            for (segment, occluded) in segments.iter().zip(occluded) {
                *occluded = *occluded || self.any_object(surfaces, segment);
            }
        }
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
}
