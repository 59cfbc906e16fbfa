//! The ends of the segments of a round: the steps of all camera paths ([`CameraRound`]), and what each part of a path does at a vertex where
//! it scatters.

use super::compensation_photons::direction_fraction;
use super::gather_points::TileGather;
use super::gather_vertices::GatherVertex;
use super::paths::{EMISSION_PATHS, PathPart, PathState};
use crate::color::Rgb;
use crate::film::{Layer, TileSamples};
use crate::ids::MaterialId;
use crate::integrators::camera_round::CameraRound;
use crate::lanes::Width;
use crate::transport::stream::{PacketShader, Walks};

/// The camera paths of a round, at the ends of their segments.
pub(super) struct Arriving<'a, 's, 'o, 't> {
    pub(super) round: CameraRound<'a, 's, PathState>,
    pub(super) next: &'a mut Walks<PathState>,
    pub(super) tile: &'a mut TileGather<'s, 'o, 't>,
}

impl PacketShader for Arriving<'_, '_, '_, '_> {
    #[inline(always)]
    fn shade<S: Width>(&mut self, s: S, material: MaterialId, packet: &[u32]) {
        let round = self.round;
        let lanes = round.lanes(packet);
        if !lanes.matter() {
            return;
        }
        let v = round.vertices(s, material, packet);
        let mut at = round.arrive(s, &v, material);
        let TileGather { out, vertices, .. } = &mut *self.tile;
        round.see_emitters(at.v, lanes.emits, |path, radiance| {
            add_emitted(path, radiance, vertices, out);
        });
        let scatters = round.describe_and_go_on(&mut at, lanes, self.next, out);
        if scatters == 0 {
            return;
        }
        self.end_prefixes(s, &mut at, scatters);
        self.end_chains(&mut at, scatters);
        self.follow_specular(s, &mut at, scatters);
        self.end_directions(&mut at, scatters);
    }
}

impl Arriving<'_, '_, '_, '_> {
    /// Adds the environment to the paths that leave the scene.
    pub(super) fn leave(&mut self) {
        let (walks, TileGather { out, vertices, .. }) = (self.round.walks, &mut *self.tile);
        let guide = |i: u32| {
            let direction = walks.kept[i as usize].direction()?;
            vertices[direction.from as usize].environment.as_ref()
        };
        let add = |path: &PathState, radiance, out: &mut TileSamples| {
            add_emitted(path, radiance, vertices, out);
        };
        self.round.leave(guide, add, out);
    }
}

/// Adds the part for which a path accounts of the radiance that is emitted towards it.
fn add_emitted(path: &PathState, radiance: Rgb, vertices: &[GatherVertex], out: &mut TileSamples) {
    let (layer, part) = match &path.part {
        PathPart::Prefix(_) => (Layer::Emission, 1.0 / EMISSION_PATHS as f32),
        PathPart::Direction(direction) => {
            let limit = vertices[direction.from as usize].role.direction_limit();
            let part = direction_fraction(limit, direction.f_cos);
            (path.stage.layer(), part)
        }
        // Photons account for it: emitters may be small.
        PathPart::Chain(_) => return,
    };
    out.add(path.pixel as usize, layer, radiance * part);
}
