//! The environment seen by walks that leave the scene.

use super::{Walks, by_lane, lanes_where, used};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::emitters::EnvironmentLobes;
use crate::lanes::{LaneKernel, Mask, Vector, Width, lane};
use crate::scene::{PathLimits, Scene};
use crate::simd::{Isa, Outlined, set_bits};
use crate::transport::direct::environment_with_mis;

/// Calls `visit` with each walk of `escaped` that may see the environment, and with the radiance
/// that arrives along it, times its MIS weight against next-event estimation at the last event, in
/// W/(m² sr). `guide(i)` are the lobes of next-event estimation for walk `i`, if it uses any.
pub(crate) fn see_environment<'g, T: Copy>(
    scene: &Scene,
    limits: PathLimits,
    walks: &Walks<T>,
    escaped: &[u32],
    guide: impl Fn(u32) -> Option<&'g EnvironmentLobes>,
    visit: impl FnMut(u32, Rgb),
) {
    if scene.emitters.has_environment() && !escaped.is_empty() {
        let escapes = Escapes {
            scene,
            limits,
            walks,
            escaped,
            guide,
            visit,
        };
        Isa::best().run_lanes(escapes);
    }
}

struct Escapes<'a, T, G, V> {
    scene: &'a Scene,
    limits: PathLimits,
    walks: &'a Walks<T>,
    escaped: &'a [u32],
    guide: G,
    visit: V,
}

impl<'g, T, G, V> LaneKernel for Escapes<'_, T, G, V>
where
    T: Copy,
    G: Fn(u32) -> Option<&'g EnvironmentLobes>,
    V: FnMut(u32, Rgb),
{
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
struct Packet<'k, 'a, T, G, V, S> {
    escapes: &'k mut Escapes<'a, T, G, V>,
    s: S,
    packet: &'k [u32],
}

impl<'g, T, G, V, S> Outlined for Packet<'_, '_, T, G, V, S>
where
    T: Copy,
    G: Fn(u32) -> Option<&'g EnvironmentLobes>,
    V: FnMut(u32, Rgb),
    S: Width,
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Packet { escapes, s, packet } = self;
        let walks = escapes.walks;
        let index = by_lane(s, packet);
        let is_hidden = |i: u32| escapes.limits.hide_emitters && walks.event(i) == Lobes::NONE;
        let seen = lanes_where(used(packet.len()), |i| !is_hidden(index.as_ref()[i]));
        if seen == 0 {
            return;
        }
        let guides = s.each(|i| (escapes.guide)(index.as_ref()[i]));
        let has_guides = guides.as_ref().iter().any(|guide| guide.is_some());
        let guides = has_guides.then_some(&guides);
        let previous = walks.previous_events(s, &index);
        let wi = Vector::from_fn(s, |i| walks.rays[index.as_ref()[i] as usize].d);
        let seen = Mask::from_bits(s, seen);
        let radiance = environment_with_mis(escapes.scene, &previous, wi, guides, seen);
        let radiance = radiance.store();
        for i in set_bits(seen.bits()) {
            (escapes.visit)(index.as_ref()[i], Rgb::from(lane(&radiance, i)));
        }
    }
}
