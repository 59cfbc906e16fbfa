//! The pilot that finds out where light from afar gets in.

use super::distant::{Arrival, Distant};
use crate::geometry::{Geometry, Ray, SurfaceRef};
use crate::ids::PrimitiveId;
use crate::math::{Frame, Vec3};
use crate::sampling::{Sampler, Stream, warp};

/// Finds out where light from afar gets in.
pub(super) struct Pilot<'a, F> {
    pub(super) geometry: &'a Geometry,
    pub(super) distant: &'a Distant,
    /// Surfaces that the pilot ignores.
    pub(super) see_through: &'a F,
}

/// Surfaces at which a walk of the pilot asks for light.
const PILOT_BOUNCES: usize = 4;

/// See-through surfaces that the pilot crosses at most on one ray.
const PILOT_CROSSINGS: usize = 8;

impl<F: Fn(PrimitiveId) -> bool> Pilot<'_, F> {
    /// Light that arrives at the surfaces of a diffuse walk from `ray`; the walk with the same index has the same numbers.
    pub(super) fn walk(&self, mut ray: Ray, index: u64) -> Vec<Arrival> {
        let mut sampler = Sampler::new(0, 0, Stream::Pass, index);
        let mut arrivals = Vec::new();
        for _ in 0..PILOT_BOUNCES {
            let Some(at) = self.nearest(ray) else { break };
            let x = self.geometry.surface_point(at);
            let n = x.normal_towards(-ray.d);
            let is_free = |wi: Vec3| self.nearest(x.spawn(wi)).is_none();
            arrivals.extend(
                self.distant
                    .arrivals((x.p, n), || sampler.next_2d(), is_free),
            );
            let w = Frame::from_normal(n)
                .to_world(warp::cosine_hemisphere(sampler.next_2d()))
                .normalize();
            ray = x.spawn(w);
        }
        arrivals
    }

    /// The nearest surface that is not ignored.
    fn nearest(&self, mut ray: Ray) -> Option<SurfaceRef> {
        for _ in 0..PILOT_CROSSINGS {
            let at = self.geometry.intersect(&ray)?.at;
            if !(self.see_through)(at.primitive) {
                return Some(at);
            }
            ray = self.geometry.surface_point(at).spawn(ray.d);
        }
        None
    }
}
