//! What the camera sees first: albedo, normal and depth, alpha, position and ids.

use super::camera_round::{CameraRound, CameraStart, FirstPart};
use super::context::PassContext;
use super::first_event::SampleShare;
use crate::film::{Film, TileSamples, Tiling};
use crate::ids::MaterialId;
use crate::lanes::Width;
use crate::sampling::Stream;
use crate::scene::{PathLimits, Scene};
use crate::transport::stream::{PacketShader, Walks, follow_all, shade_packets};

/// One sample per pixel. `false` if cancelled.
pub(super) fn render_pass(
    scene: &Scene,
    limits: PathLimits,
    run: &PassContext,
    film: &mut Film,
) -> bool {
    let positions = film.desc().sampler();
    run.shade(film, Tiling::OF_STREAMS, |samples| {
        let mut walks = Walks::with_capacity(samples.tile().count());
        for (index, pixel) in samples.tile().pixels().enumerate() {
            let mut sampler = run.pass.sampler(Stream::Pixel, positions.index(pixel));
            let u = sampler.next_2d();
            let start =
                CameraStart::new((scene, limits), &positions, (pixel, u), sampler.next_2d());
            let path = FirstPart {
                pixel: index as u32,
                hidden: start.hidden,
                event: SampleShare {
                    filter_weight: start.filter_weight,
                    share: 1.0,
                },
                surface_share: 1.0,
            };
            walks.push(start.walk(1, sampler, path));
        }
        follow_all(scene, walks, |walks, arrivals, next| {
            let round = CameraRound {
                scene,
                limits,
                walks,
                arrivals,
            };
            round.leave(|_| None, |_, _, _| (), samples);
            let mut first = FirstVertices {
                round,
                next,
                out: samples,
            };
            shade_packets(arrivals.runs(), &mut first);
        });
    })
}

/// Ends all paths where they scatter first.
struct FirstVertices<'a, 'o, 't> {
    round: CameraRound<'a, 'a, FirstPart>,
    next: &'o mut Walks<FirstPart>,
    out: &'o mut TileSamples<'t>,
}

impl PacketShader for FirstVertices<'_, '_, '_> {
    #[inline(always)]
    fn shade<S: Width>(&mut self, s: S, material: MaterialId, packet: &[u32]) {
        let (round, lanes) = (self.round, self.round.lanes(packet));
        let v = round.vertices(s, material, packet);
        let mut at = round.arrive(s, &v, material);
        round.describe_and_go_on(&mut at, lanes, self.next, self.out);
    }
}
