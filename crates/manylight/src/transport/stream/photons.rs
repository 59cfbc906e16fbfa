//! The step of photons at the vertices of a packet.

use super::{Bits, Generators, Vertices, WalkRow, Walks, lanes_where};
use crate::bsdf::Lobes;
use crate::lanes::{Width, lane};
use crate::scene::PathLimits;
use crate::simd::set_bits;
use crate::transport::roulette::photon_survivals;

/// Appends to `next` the photons in `lanes` that go on within the limits: straight through the surface, or scattered if they survive Russian
/// roulette. For those that scatter, the method keeps `kept(i)`.
#[inline(always)]
pub(crate) fn follow_photons<S: Width, T: Copy>(
    v: &Vertices<S>,
    (walks, limits): (&Walks<T>, PathLimits),
    lanes: Bits,
    mut generators: Generators<S>,
    kept: impl Fn(usize) -> T,
    next: &mut Walks<T>,
) {
    let goes_on = lanes_where(lanes, |i| limits.allow(v.segments.as_ref()[i] + 2));
    if goes_on == 0 {
        return;
    }
    let mut before = walks.throughput(v.w_prev.x.width(), &v.index);
    let u_through = generators.next();
    let mut scatters = goes_on;
    if let Some((passes, factor)) = v.passes(u_through, goes_on) {
        before = before * factor;
        let unchanged = (passes, |i| v.kept(walks, i));
        v.pass_through(walks, next, before, &generators, unchanged);
        scatters &= !passes;
    }
    if scatters == 0 {
        return;
    }
    let numbers = generators.next_bsdf();
    let sample = v.bsdf.sample_each_wo(v.w_prev, numbers, Lobes::ALL);
    let flux = before * sample.weight;
    let survival = photon_survivals(before, flux);
    let survives = generators.next().lt(survival);
    let alive = sample.valid & !sample.weight.is_black() & survives;
    let flux = (flux / survival).store();
    let scattered = v.scattered(&sample);
    for i in set_bits(alive.bits() & scatters) {
        next.push(WalkRow {
            ray: scattered.ray(i),
            throughput: lane(&flux, i),
            eta_squared: 1.0,
            segments: v.segments.as_ref()[i],
            previous: scattered.previous(i, None),
            sampler: generators.get(i),
            kept: kept(i),
        });
    }
}
