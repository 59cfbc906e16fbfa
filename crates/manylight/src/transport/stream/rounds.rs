//! Rounds of a stream, and the packets of a round.

use super::absorption::absorb;
use super::{Arrivals, Bits, Vertices, Walks, used};
use crate::ids::MaterialId;
use crate::lanes::{LaneKernel, Width};
use crate::scene::Scene;
use crate::simd::{Isa, outlined};

/// The walks of a stream, with its memory, which may serve one stream after another.
#[derive(Clone, Debug)]
pub(crate) struct WalkStream<T> {
    /// The walks at their next segment.
    pub(crate) walks: Walks<T>,
    /// Those that go on after it.
    next: Walks<T>,
    arrivals: Arrivals,
}

impl<T: Copy> WalkStream<T> {
    /// The stream of these walks.
    pub(crate) fn new(walks: Walks<T>) -> Self {
        WalkStream {
            next: Walks::with_capacity(walks.rays.len()),
            walks,
            arrivals: Arrivals::default(),
        }
    }
}

/// Follows walks to their ends, after which none are left. `round` shades the vertices of one
/// segment of all walks, and appends the walks that go on to its last argument.
pub(crate) fn follow_all<T: Copy>(
    scene: &Scene,
    stream: &mut WalkStream<T>,
    mut round: impl FnMut(&Walks<T>, &Arrivals, &mut Walks<T>),
) {
    let WalkStream {
        walks,
        next,
        arrivals,
    } = stream;
    while !walks.is_empty() {
        arrivals.trace(scene, &walks.rays);
        absorb(scene, walks, arrivals);
        next.clear();
        round(walks, arrivals, next);
        std::mem::swap(walks, next);
    }
}

/// What a method does at the vertices of walks.
pub(crate) trait VertexShader<T> {
    /// Shades the vertices `v` of the walks in `lanes`, and appends those that go on to `next`.
    /// Must be `inline(always)`.
    fn shade<S: Width>(
        &mut self,
        v: &Vertices<S>,
        walks: &Walks<T>,
        lanes: Bits,
        next: &mut Walks<T>,
    );
}

/// Follows walks to their ends, with `shader` at all vertices.
pub(crate) fn follow_and_shade<T: Copy>(
    scene: &Scene,
    walks: Walks<T>,
    shader: &mut impl VertexShader<T>,
) {
    follow_all(
        scene,
        &mut WalkStream::new(walks),
        |walks, arrivals, next| {
            let mut round = Round {
                scene,
                walks,
                arrivals,
                next,
                shader: &mut *shader,
            };
            shade_packets(arrivals.runs(), &mut round);
        },
    );
}

/// One segment of all walks, and the vertices at its end.
struct Round<'k, T, V> {
    scene: &'k Scene,
    walks: &'k Walks<T>,
    arrivals: &'k Arrivals,
    next: &'k mut Walks<T>,
    shader: &'k mut V,
}

impl<T, V: VertexShader<T>> PacketShader for Round<'_, T, V> {
    #[inline(always)]
    fn shade<S: Width>(&mut self, s: S, material: MaterialId, packet: &[u32]) {
        let (scene, walks) = (self.scene, self.walks);
        let mut v = Vertices::new(s, scene, walks, self.arrivals, material, packet);
        v.add_leaves(scene, material);
        (self.shader).shade(&v, walks, used(packet.len()), self.next);
    }
}

/// What a method does with packets.
pub(crate) trait PacketShader {
    /// Shades up to [`Width::LANES`] elements of one material, by their indices. Must be
    /// `inline(always)`.
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
    /// [`PacketShader::shade`]. Not part of the loop over packets, which the compiler would copy
    /// for every condition on the material.
    fn shade<P: PacketShader, S: Width>(
        shader: &mut P, s: S, material: MaterialId, packet: &[u32],
    ) -> () { s => shader.shade(s, material, packet) }
}
