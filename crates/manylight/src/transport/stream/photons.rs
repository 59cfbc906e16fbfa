//! Photons: the numbers of their emission, and their step at the vertices of a packet.

use super::{Bits, Generators, Vertices, Walks, lanes_where};
use crate::bsdf::Lobes;
use crate::emitters::EmissionNumbers;
use crate::lanes::{Float, Width};
use crate::sampling::Sampler;
use crate::scene::PathLimits;
use crate::simd::set_bits;
use crate::transport::roulette::photon_survivals;

impl Sampler {
    /// Random numbers of one photon emission.
    #[inline]
    pub(crate) fn next_emission(&mut self) -> EmissionNumbers {
        EmissionNumbers {
            emitter: self.next_1d(),
            position: self.next_2d(),
            direction: self.next_2d(),
            element: self.next_1d(),
        }
    }
}

/// Appends to `next` the photons in `lanes` that go on within the limits: straight through the
/// surface, or scattered if they survive Russian roulette. Those that scatter carry `payload(i)`.
#[inline(always)]
pub(crate) fn follow_photons<S: Width, T: Copy>(
    v: &Vertices<S>,
    (walks, limits): (&Walks<T>, PathLimits),
    lanes: Bits,
    mut generators: Generators<S>,
    payload: impl Fn(usize) -> T,
    next: &mut Walks<T>,
) {
    let goes_on = lanes_where(lanes, |i| limits.allow(v.segments.as_ref()[i] + 2));
    if goes_on == 0 {
        return;
    }
    let s = v.w_prev.x.width();
    let mut before = walks.throughput(s, &v.index);
    let unchanged = |i| v.payload(walks, i);
    let u = generators.next();
    let state = (&mut before, &generators, u);
    let scatters = v.pass_through(walks, next, state, goes_on, unchanged);
    if scatters == 0 {
        return;
    }
    let numbers = generators.next_bsdf();
    let sample = v.bsdf.sample_each_wo(v.w_prev, numbers, Lobes::ALL);
    let flux = before * sample.weight;
    let survival = photon_survivals(before, flux);
    let survives = generators.next().lt(survival);
    let alive = sample.valid & !sample.weight.is_black() & survives;
    let segments = v.next_segments(&sample, flux / survival, Float::splat(s, 1.0));
    for i in set_bits(alive.bits() & scatters) {
        next.push(segments.row(i, generators.get(i), payload(i)));
    }
}
