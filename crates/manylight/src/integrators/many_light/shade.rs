//! Stage 5: shading. All camera paths of a tile advance together, in rounds. A round follows one segment of every path:
//!
//! | stage | file |
//! |---|---|
//! | the paths, and what each is followed for | `paths.rs` |
//! | the ends of their segments: emission, straight-through transmission, first surfaces | `arriving.rs` |
//! | paths from the camera through specular events, up to gather points | `camera_paths.rs`, `specular_chains.rs` |
//! | a non-specular vertex becomes a gather point | `gathering.rs`, `gather_vertices.rs`, `gather_points.rs` |
//! | emitters and directions sampled at the new gather points; the directions are paths of the next round | `sampling_lanes.rs` |
//! | light that clamping removes, where directions arrive | `compensation.rs`, `compensation_photons.rs` |
//! | specular chains seen by glossy lobes | `specular_chains.rs` |
//!
//! After the last round follow, for all gather points of the tile together, the sums over virtual lights ([`crate::gather`]) and the photons
//! (`density_estimates.rs`).

use super::arriving::Arriving;
use super::caustic_shares::PHOTON_NEIGHBORS;
use super::gather_points::{GatherPoint, TileGather};
use super::prepared::PreparedPasses;
use super::sampling_lanes::{Sampling, in_order_of_material};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::film::{FilmSampler, Layer, TILE_SIZE, TileSamples, Tiling};
use crate::gather::{CutLimits, Gathered, Strategy, WeightedPoint};
use crate::integrators::camera_round::CameraRound;
use crate::integrators::context::PassContext;
use crate::integrators::partition::PathStage;
use crate::maps::Neighbors;
use crate::math::UVec2;
use crate::sampling::{Pass, Stream};
use crate::stats::Stats;
use crate::transport::stream::{follow_all, shade_packets};

/// The tiles of a pass. The points of a tile share a cut and its error: tiles that lie elsewhere in each
/// pass leave no borders in the mean.
pub(super) fn tiling(strategy: Strategy, pass: Pass) -> Tiling {
    let shift = match strategy {
        Strategy::All | Strategy::Bidirectional(_) => UVec2::ZERO,
        Strategy::Cuts(_) => {
            let u = pass.low_discrepancy_2d(Stream::Selection, 4);
            (u * TILE_SIZE as f32).as_uvec2()
        }
    };
    Tiling {
        shift,
        ..Tiling::UNSHIFTED
    }
}

impl<'s> PreparedPasses<'s> {
    /// Shades the pixels of one tile: first its camera paths, then virtual lights and photons at all gather points together.
    pub(super) fn shade_tile(
        &self,
        run: &PassContext,
        positions: &FilmSampler,
        out: &mut TileSamples,
    ) {
        let mut tile = TileGather::new(self, run.pass, out);
        let shadow_rays = self.follow_paths(run, positions, &mut tile);
        let mut points = tile.points;
        let mut counts = TileCounts {
            camera_paths: out.tile().pixels().count() as u64,
            shadow_rays,
            ..TileCounts::default()
        };
        let mut found = Neighbors::new(PHOTON_NEIGHBORS);
        let sums = self.sums(&mut points);
        for (point, sum) in points.iter().zip(&sums) {
            self.add_gather_point(point, sum, &mut found, out);
            counts.add(point, sum);
        }
        counts.add_to(run.stats);
    }

    /// Follows the camera paths of a tile to their ends. Returns the number of shadow rays to emitters.
    fn follow_paths(
        &self,
        run: &PassContext,
        positions: &FilmSampler,
        tile: &mut TileGather<'s, '_, '_>,
    ) -> u64 {
        let mut shadow_rays = 0;
        let walks = self.start_paths(run, positions, tile);
        follow_all(self.scene, walks, |walks, arrivals, next| {
            let sampled = tile.points.len();
            let round = CameraRound {
                scene: self.scene,
                limits: self.limits,
                walks,
                arrivals,
            };
            let mut arriving = Arriving { round, next, tile };
            arriving.leave();
            shade_packets(arrivals.runs(), &mut arriving);
            let order = in_order_of_material(&tile.points, sampled);
            let material = |i: u32| tile.points[i as usize].material;
            let runs = order.chunk_by(|&i, &j| material(i) == material(j));
            let mut sampling = Sampling {
                prepared: self,
                points: &tile.points,
                vertices: &mut tile.vertices,
                connections: &mut tile.connections,
                next,
            };
            shade_packets(runs.map(|run| (material(run[0]), run)), &mut sampling);
            shadow_rays += tile.connections.add_all(self.scene, tile.out);
        });
        shadow_rays
    }

    /// Adds the sum over virtual lights and the density estimates at one point to the film.
    fn add_gather_point(
        &self,
        point: &GatherPoint<'s>,
        sum: &Gathered,
        found: &mut Neighbors,
        out: &mut TileSamples,
    ) {
        let after_x = point.stage.after(Lobes::NON_SPECULAR);
        let mut add = |stage: PathStage, radiance: Rgb| {
            out.add(point.pixel, stage.layer(), point.throughput * radiance);
        };
        add(after_x.after(Lobes::NON_SPECULAR), sum.radiance);
        add(
            after_x.after(Lobes::SPECULAR),
            self.caustic_radiance(point, found),
        );
        add(
            after_x.after_compensating_event(),
            self.compensation_photon_radiance(point, found),
        );
        if point.stage == PathStage::BeforeX {
            // The error of a cluster that could not be refined has no bound.
            let error = sum.cluster_error.min(1.0);
            let bound = (point.throughput * sum.radiance * error).luminance();
            let size = Rgb::splat(sum.terms as f32);
            out.add(point.pixel, Layer::CutSize, size);
            out.add(point.pixel, Layer::CutBound, Rgb::splat(bound));
        }
    }

    /// The sums over virtual lights at the points, which it may reorder. The error of a cluster may be [`PreparedPasses::tolerance`] in a
    /// pixel.
    fn sums(&self, points: &mut [GatherPoint<'s>]) -> Vec<Gathered> {
        if let Strategy::Bidirectional(limits) = self.gather.strategy {
            return self.product_sums(points, limits);
        }
        for point in &mut *points {
            let throughput = point.throughput.luminance().max(f32::MIN_POSITIVE);
            point.at.tolerance = self.tolerance / throughput;
        }
        self.gather.sum(self.scene, &self.lights, points)
    }

    /// [`PreparedPasses::sums`] by one product cut for each pixel.
    fn product_sums(&self, points: &mut [GatherPoint<'s>], limits: CutLimits) -> Vec<Gathered> {
        points.sort_by_key(|point| point.pixel);
        let mut sums = Vec::with_capacity(points.len());
        for of_pixel in points.chunk_by(|a, b| a.pixel == b.pixel) {
            let weighted: Vec<WeightedPoint> = (of_pixel.iter())
                .map(|point| WeightedPoint {
                    at: point.at,
                    throughput: point.throughput,
                })
                .collect();
            let (lights, tolerance) = (&self.lights, self.tolerance);
            let gather = &self.gather;
            sums.extend(gather.sum_of_pixel(self.scene, lights, limits, tolerance, &weighted));
        }
        sums
    }
}

/// Statistics of a tile.
#[derive(Default)]
struct TileCounts {
    camera_paths: u64,
    connections: u64,
    shadow_rays: u64,
    /// Luminance that the clamp removed at the first gather points, and that before clamping, in W/(m² sr).
    clamped: f64,
    unclamped: f64,
}

impl TileCounts {
    fn add(&mut self, point: &GatherPoint, sum: &Gathered) {
        self.connections += sum.connections;
        self.shadow_rays += sum.shadow_rays;
        if point.stage == PathStage::BeforeX {
            let throughput = point.throughput.luminance();
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
