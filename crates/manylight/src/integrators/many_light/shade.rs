//! Stage 6: shading. All camera paths of a tile advance together, in rounds. A round follows one
//! segment of every path:
//!
//! | stage | file |
//! |---|---|
//! | what each path is followed for | `paths.rs` |
//! | paths from the camera through specular events, up to gather points | `prefix.rs` |
//! | emitters and directions sampled at new gather points; the directions are paths of the next round | `direction.rs` |
//! | specular events, and chains of them that continue directions | `chain.rs` |
//! | light that clamping removes, where directions arrive | `compensation.rs`, `radiance_cache.rs` |
//! | a non-specular vertex becomes a gather point | `gather_point.rs` |
//!
//! After the last round follow, for all gather points of the tile together, the sums over virtual
//! lights ([`crate::gather`]) and over photons (`density_estimates.rs`, `compensation_photons.rs`).

use super::density_estimates::{caustic_radiance, compensation_photon_radiance};
use super::direction::{Sampling, emission_fraction, in_order_of_material};
use super::gather_point::{GatherPath, GatherPoint, TileGather};
use super::paths::{EMISSION_PATHS, PathPart, PathState};
use super::paths::{GroupScales, ScaleRow};
use super::trace::PHOTON_NEIGHBORS;
use super::{ManyLight, PreparedPasses, chain, direction, prefix};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::film::{FilmSampler, Layer, TILE_SIZE, TileSamples, Tiling};
use crate::gather::{CutLimits, Gathered, ShadingPoint, Strategy};
use crate::ids::{LightGroup, MaterialId};
use crate::integrators::camera_round::{CameraRound, SeenEmission, follow_paths};
use crate::integrators::context::PassContext;
use crate::integrators::light_groups::RadianceByGroup;
use crate::integrators::partition::PathStage;
use crate::lanes::Width;
use crate::maps::Neighbors;
use crate::math::UVec2;
use crate::sampling::{Pass, Stream};
use crate::stats::Stats;
use crate::transport::stream::{PacketShader, WalkStream, Walks, shade_packets};

/// The tiles of a pass. The points of a tile share a cut and its error: tiles that lie elsewhere in
/// each pass leave no borders in the mean. With interleaved lights, a tile has 64 pixels for each
/// subset of the lights, so that blocks of shadow rays are full.
pub(super) fn tiling(method: &ManyLight, pass: Pass) -> Tiling {
    let shift = match method.strategy {
        Strategy::All | Strategy::Bidirectional(_) => UVec2::ZERO,
        Strategy::Cuts(_) => {
            let u = pass.low_discrepancy_2d(Stream::Tiling, 0);
            (u * TILE_SIZE as f32).as_uvec2()
        }
    };
    Tiling {
        edge: TILE_SIZE * method.interleaving,
        shift,
    }
}

impl<'s> PreparedPasses<'s> {
    /// Shades the pixels of one tile: first its camera paths, then virtual lights and photons at
    /// all gather points together.
    pub(super) fn shade_tile(
        &self,
        run: &PassContext,
        positions: &FilmSampler,
        out: &mut TileSamples,
    ) {
        let mut tile = TileGather::new(self, run, out);
        let mut counts = self.follow_paths(run, positions, &mut tile);
        let (mut points, scales) = (tile.points, tile.scales);
        let mut found = Neighbors::new(PHOTON_NEIGHBORS);
        let mut by_group = Vec::new();
        let sums = self.sums(&mut points, &mut by_group);
        let mut light = PointLight {
            scales,
            by_group: RadianceByGroup::black(self.light_groups),
        };
        for (i, (point, sum)) in points.iter().zip(&sums).enumerate() {
            let of_point = &by_group[i * self.light_groups..][..self.light_groups];
            self.add_gather_point(point, (sum, of_point), &mut light, &mut found, out);
            counts.add(point, sum);
        }
        counts.add_to(run.stats);
    }

    /// Follows the camera paths of a tile to their ends. Returns their number and that of shadow
    /// rays to emitters.
    fn follow_paths(
        &self,
        run: &PassContext,
        positions: &FilmSampler,
        tile: &mut TileGather<'s, '_, '_>,
    ) -> TileCounts {
        let walks = prefix::start(run, positions, tile);
        let mut counts = TileCounts {
            camera_paths: walks.rays.len() as u64,
            ..TileCounts::default()
        };
        let stream = &mut WalkStream::new(walks);
        follow_paths(self.scene, self.limits, stream, |round, next| {
            let first = tile.points.len();
            let mut arriving = Arriving { round, next, tile };
            arriving.leave();
            shade_packets(round.arrivals.runs(), &mut arriving);
            let order = in_order_of_material(&tile.points, first);
            let material = |i: u32| tile.points[i as usize].material;
            let runs: Vec<(MaterialId, &[u32])> = order
                .chunk_by(|&i, &j| material(i) == material(j))
                .map(|run| (material(run[0]), run))
                .collect();
            let mut sampling = Sampling {
                prepared: self,
                points: &mut tile.points,
                connections: &mut tile.connections,
                scales: &tile.scales,
                next,
            };
            shade_packets(runs.into_iter(), &mut sampling);
            counts.shadow_rays += tile.connections.add_all(self.scene, tile.out);
        });
        counts
    }

    /// Adds the sum over virtual lights, in all and by light group, and the density estimates at one
    /// point to the film.
    fn add_gather_point(
        &self,
        point: &GatherPoint<'s>,
        (sum, sums_of_groups): (&Gathered, &[Rgb]),
        light: &mut PointLight,
        found: &mut Neighbors,
        out: &mut TileSamples,
    ) {
        let GatherPath {
            pixel,
            throughput,
            stage,
            ..
        } = point.path;
        let pixel = pixel as usize;
        let after_x = stage.after(Lobes::NON_SPECULAR);
        for (group, &radiance) in sums_of_groups.iter().enumerate() {
            light.by_group.add(LightGroup(group as u8), radiance);
        }
        let path = &point.path;
        let layer = after_x.after(Lobes::NON_SPECULAR).layer();
        light.add(path, layer, sum.radiance, out);
        let caustics = caustic_radiance(self, point, found, &mut light.by_group);
        light.add(path, after_x.after(Lobes::SPECULAR).layer(), caustics, out);
        let compensation = compensation_photon_radiance(self, point, found, &mut light.by_group);
        let layer = after_x.after_compensating_event().layer();
        light.add(path, layer, compensation, out);
        if stage == PathStage::BeforeX {
            // The error of a cluster that could not be refined has no bound.
            let error = sum.cluster_error.min(1.0);
            let bound = (throughput * sum.radiance * error).luminance();
            let size = Rgb::splat(sum.terms as f32);
            out.add(pixel, Layer::CutSize, size);
            out.add(pixel, Layer::CutBound, Rgb::splat(bound));
        }
    }

    /// The sums over virtual lights at the points, which it may reorder. The error of a cluster may
    /// be [`PreparedPasses::tolerance`] in a pixel. `by_group` becomes those of each light group.
    fn sums(&self, points: &mut [GatherPoint<'s>], by_group: &mut Vec<Rgb>) -> Vec<Gathered> {
        if let Strategy::Bidirectional(limits) = self.gather.strategy {
            return self.product_sums(points, limits, by_group);
        }
        for point in &mut *points {
            let throughput = point.path.throughput.luminance().max(f32::MIN_POSITIVE);
            point.at.tolerance = self.tolerance / throughput;
        }
        (self.gather).sum_by_group(self.scene, &self.lights, points, by_group)
    }

    /// [`PreparedPasses::sums`] by one product cut for each pixel.
    fn product_sums(
        &self,
        points: &mut [GatherPoint<'s>],
        limits: CutLimits,
        by_group: &mut Vec<Rgb>,
    ) -> Vec<Gathered> {
        points.sort_by_key(|point| point.path.pixel);
        let mut sums = Vec::with_capacity(points.len());
        for of_pixel in points.chunk_by(|a, b| a.path.pixel == b.path.pixel) {
            let weighted: Vec<(&ShadingPoint, Rgb)> = (of_pixel.iter())
                .map(|point| (&point.at, point.path.throughput))
                .collect();
            let (gather, lights) = (&self.gather, &self.lights);
            let limits = (limits, self.tolerance);
            sums.extend(gather.sum_of_pixel(self.scene, lights, limits, &weighted, by_group));
        }
        sums
    }
}

/// The camera paths of a round, at the ends of their segments.
struct Arriving<'a, 's, 'o, 't> {
    round: CameraRound<'a, 's, PathState>,
    next: &'a mut Walks<PathState>,
    tile: &'a mut TileGather<'s, 'o, 't>,
}

impl PacketShader for Arriving<'_, '_, '_, '_> {
    #[inline(always)]
    fn shade<S: Width>(&mut self, s: S, material: MaterialId, packet: &[u32]) {
        let Arriving { round, next, tile } = self;
        let lanes = round.lanes(packet);
        if lanes.are_done() {
            return;
        }
        let mut v = round.vertices(s, material, packet);
        v.add_leaves(round.scene, material);
        let mut at = round.arrive(s, &v, material);
        let TileGather {
            prepared,
            out,
            points,
            scales,
            ..
        } = &mut **tile;
        round.see_emitters(at.v, lanes.emits, |path, seen| {
            add_emitted(prepared, path, seen, (points, scales), out);
        });
        let scatters = round.describe_and_pass_through(&mut at, lanes, next, out);
        if scatters == 0 {
            return;
        }
        prefix::end(s, tile, &mut at, scatters);
        chain::end(tile, &mut at, scatters);
        chain::follow(s, tile, &mut at, scatters, next);
        direction::end(tile, &mut at, scatters);
    }
}

impl Arriving<'_, '_, '_, '_> {
    /// Adds the environment to the paths that leave the scene.
    fn leave(&mut self) {
        let walks = self.round.walks;
        let TileGather {
            prepared,
            out,
            points,
            scales,
            ..
        } = &mut *self.tile;
        let guide = |i: u32| {
            let direction = walks.state(i).payload.direction()?;
            points[direction.from as usize].environment.as_ref()
        };
        let add = |path: &PathState, seen, out: &mut TileSamples| {
            add_emitted(prepared, path, seen, (points, scales), out);
        };
        self.round.leave(guide, add, out);
    }
}

/// Adds the part for which a path accounts of the emission that it sees.
fn add_emitted(
    prepared: &PreparedPasses,
    path: &PathState,
    seen: SeenEmission,
    (points, scales): (&[GatherPoint], &GroupScales),
    out: &mut TileSamples,
) {
    let stage = path.stage;
    let (layer, part, row) = match &path.part {
        PathPart::Prefix(_) => {
            let part = Rgb::splat(1.0 / EMISSION_PATHS as f32);
            (Layer::Emission, part, ScaleRow::ONE)
        }
        PathPart::Direction(direction) => {
            let part = Rgb::splat(emission_fraction(direction, points));
            let row = points[direction.from as usize].path.scales;
            (stage.layer(), part, row)
        }
        PathPart::Chain(chain) => {
            let ray_density = prepared.ray_densities.at(seen.emitter, seen.radiance);
            let part = chain.shared.emission_fraction(ray_density);
            (stage.layer(), part, chain.scales)
        }
    };
    let (to, value) = ((path.pixel, layer), seen.at_camera() * part);
    seen.add_to(
        prepared.scene,
        to,
        value,
        |group| scales.of(row, group),
        out,
    );
}

/// Light at a gather point, on its way to the film.
struct PointLight {
    /// Of the camera paths.
    scales: GroupScales,
    /// The light by group, if groups are told apart.
    by_group: RadianceByGroup,
}

impl PointLight {
    /// Adds `radiance` at the end of a camera path to a layer, by group if groups are told apart.
    /// Then the groups are black.
    fn add(&mut self, path: &GatherPath, layer: Layer, radiance: Rgb, out: &mut TileSamples) {
        let pixel = path.pixel as usize;
        if !self.by_group.is_told_apart() {
            return out.add(pixel, layer, path.throughput * radiance);
        }
        for (group, radiance) in self.by_group.lit() {
            let scale = self.scales.of(path.scales, group);
            out.add_light(pixel, layer, group, path.throughput * radiance * scale);
        }
        self.by_group.clear();
    }
}

/// Statistics of a tile.
#[derive(Default)]
struct TileCounts {
    camera_paths: u64,
    connections: u64,
    shadow_rays: u64,
    /// Luminance that the clamp removed at the first gather points, and that before clamping, in
    /// W/(m² sr).
    clamped: f64,
    unclamped: f64,
}

impl TileCounts {
    fn add(&mut self, point: &GatherPoint, sum: &Gathered) {
        self.connections += sum.connections;
        self.shadow_rays += sum.shadow_rays;
        if point.path.stage == PathStage::BeforeX {
            let throughput = point.path.throughput.luminance();
            self.clamped += f64::from(sum.clamped * throughput);
            self.unclamped += f64::from(sum.unclamped * throughput);
        }
    }

    fn add_to(&self, stats: &Stats) {
        Stats::count(&stats.camera_paths, self.camera_paths);
        Stats::count(&stats.connections, self.connections);
        Stats::count(&stats.shadow_rays, self.shadow_rays);
        Stats::count(&stats.clamped, (self.clamped * 1e6) as u64);
        Stats::count(&stats.unclamped, (self.unclamped * 1e6) as u64);
    }
}
