//! Rounds of a stream, and the packets of a round.

use super::{Arrivals, Walks};
use crate::ids::MaterialId;
use crate::lanes::{LaneKernel, Width};
use crate::scene::Scene;
use crate::simd::{Isa, outlined};

/// Follows walks to their ends. `round` shades the vertices of one segment of all walks, and appends the walks that go on to its last
/// argument.
pub(crate) fn follow_all<T: Copy>(
    scene: &Scene,
    mut walks: Walks<T>,
    mut round: impl FnMut(&Walks<T>, &Arrivals, &mut Walks<T>),
) {
    let mut arrivals = Arrivals::default();
    let mut next = Walks::with_capacity(walks.rays.len());
    while !walks.is_empty() {
        arrivals.trace(scene, &walks.rays);
        next.clear();
        round(&walks, &arrivals, &mut next);
        std::mem::swap(&mut walks, &mut next);
    }
}

/// What a method does with packets.
pub(crate) trait PacketShader {
    /// Shades up to [`Width::LANES`] elements of one material, by their indices. Must be `inline(always)`.
    fn shade<S: Width>(&mut self, s: S, material: MaterialId, packet: &[u32]);
}

/// Shades all elements of `runs`, each of which has one material, in packets.
pub(crate) fn shade_packets<'r, P: PacketShader>(
    runs: impl Iterator<Item = (MaterialId, &'r [u32])>,
    shader: &mut P,
) {
    Isa::best().run_lanes(Packets { runs, shader });
}

struct Packets<'k, R, P> {
    runs: R,
    shader: &'k mut P,
}

impl<'r, R, P> LaneKernel for Packets<'_, R, P>
where
    R: Iterator<Item = (MaterialId, &'r [u32])>,
    P: PacketShader,
{
    type Output = ();

    #[inline(always)]
    fn run<S: Width>(self, s: S) {
        let Packets { runs, shader } = self;
        for (material, elements) in runs {
            for packet in elements.chunks(S::LANES) {
                shade(shader, s, material, packet);
            }
        }
    }
}

outlined! {
    /// [`PacketShader::shade`]. Not part of the loop over packets, which the compiler would copy for
    /// every condition on the material.
    fn shade<P: PacketShader, S: Width>(
        shader: &mut P, s: S, material: MaterialId, packet: &[u32],
    ) -> () { s => shader.shade(s, material, packet) }
}
