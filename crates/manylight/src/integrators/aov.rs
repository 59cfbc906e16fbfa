//! What the camera sees first: albedo, normal and depth, alpha, position and ids.

use super::camera_round::{CameraRound, FirstPart, follow_paths};
use super::camera_starts::start_paths;
use super::context::PassContext;
use crate::film::{Film, TileSamples, Tiling};
use crate::ids::MaterialId;
use crate::lanes::Width;
use crate::scene::{LimitedScene, PathLimits, Scene};
use crate::transport::stream::{PacketShader, WalkStream, Walks, shade_packets};

/// One sample per pixel. `false` if cancelled.
pub(super) fn render_pass(
    scene: &Scene,
    limits: PathLimits,
    run: &PassContext,
    film: &mut Film,
) -> bool {
    let positions = film.desc().sampler();
    run.shade(film, Tiling::OF_STREAMS, |out| {
        let mut walks = Walks::with_capacity(out.tile().count());
        let first = |first, _| first;
        start_paths(
            LimitedScene { scene, limits },
            run,
            &positions,
            out,
            first,
            &mut walks,
        );
        follow_paths(scene, limits, &mut WalkStream::new(walks), |round, next| {
            round.leave(|_| None, |_, _, _| (), out);
            let mut first = FirstVertices { round, next, out };
            shade_packets(round.arrivals.runs(), &mut first);
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
        let mut v = round.vertices(s, material, packet);
        v.add_leaves(round.scene, material);
        let mut at = round.arrive(s, &v, material);
        round.describe_and_pass_through(&mut at, lanes, self.next, self.out);
    }
}
