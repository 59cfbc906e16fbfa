//! The environment seen by paths that leave the scene.

use super::{PathState, add_emitted};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::film::TileSamples;
use crate::integrators::first_event::FirstEvent;
use crate::lanes::{LaneKernel, Mask, Vector, Width, lane};
use crate::scene::{PathLimits, Scene};
use crate::simd::{Outlined, set_bits};
use crate::transport::direct_lanes::environment_with_mis_lanes;
use crate::transport::stream::{Walks, lanes_where, used};

/// Adds the environment to the walks of a round that leave the scene.
pub(super) struct Escapes<'a, 'o, 't> {
    pub(super) scene: &'a Scene,
    pub(super) limits: PathLimits,
    pub(super) walks: &'a Walks<PathState>,
    pub(super) escaped: &'a [u32],
    pub(super) out: &'o mut TileSamples<'t>,
}

impl LaneKernel for Escapes<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Width>(mut self, s: S) {
        for packet in self.escaped.chunks(S::LANES) {
            s.outline(Packet {
                escapes: &mut self,
                s,
                packet,
            });
        }
    }
}

/// Up to [`Width::LANES`] walks that leave the scene.
struct Packet<'k, 'a, 'o, 't, S> {
    escapes: &'k mut Escapes<'a, 'o, 't>,
    s: S,
    packet: &'k [u32],
}

impl<S: Width> Outlined for Packet<'_, '_, '_, '_, S> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Packet { escapes, s, packet } = self;
        let Escapes {
            scene,
            limits,
            walks,
            ..
        } = *escapes;
        let index = s.each(|i| packet[if i < packet.len() { i } else { 0 }]);
        let all = used(packet.len());
        let firsts = lanes_where(all, |i| walks.event(index.as_ref()[i]) == Lobes::NONE);
        let hidden = if limits.hide_emitters { firsts } else { 0 };
        let seen = Mask::from_bits(s, all & !hidden);
        if seen.any() {
            let previous = walks.previous_events(s, &index);
            let wi = Vector::from_fn(s, |i| walks.rays[index.as_ref()[i] as usize].d);
            let radiance = environment_with_mis_lanes(scene, &previous, wi, None, seen).store();
            for i in set_bits(seen.bits()) {
                let radiance = Rgb::from(lane(&radiance, i));
                add_emitted(walks, index.as_ref()[i], radiance, escapes.out);
            }
        }
        for i in set_bits(firsts) {
            let event = match limits.hide_emitters {
                true => FirstEvent::Nothing,
                false => FirstEvent::escape(scene),
            };
            walks.kept[index.as_ref()[i] as usize].add_event(scene, event, escapes.out);
        }
    }
}
