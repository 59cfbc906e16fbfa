//! Stage 5: shading. The stages of a tile, each a file:
//!
//! | stage | file |
//! |---|---|
//! | camera paths through specular events | `camera_paths.rs` |
//! | at a non-specular vertex: emitters, directions, a gather point | `gathering.rs`, `gather_points.rs` |
//! | light that clamping removes | `compensation.rs`, `compensation_photons.rs` |
//! | specular chains seen by glossy lobes | `specular_chains.rs` |
//! | virtual lights at all gather points of the tile | [`crate::gather`] |
//! | photons at the gather points | `density_estimates.rs` |

use super::density_estimates::PHOTON_NEIGHBORS;
use super::gather_points::{GatherPoint, TileGather};
use super::prepared::PreparedPasses;
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::film::{FilmSampler, Layer, TILE_SIZE, TileSamples};
use crate::gather::{Gathered, ShadingPoint, ShareOf, Strategy};
use crate::integrators::context::PassContext;
use crate::integrators::partition::PathStage;
use crate::maps::Neighbors;
use crate::math::UVec2;
use crate::sampling::{Pass, Stream};
use crate::stats::Stats;

/// Offset of the tiles of a pass, in pixels. The points of a tile share a cut and its error: tiles that lie elsewhere in each
/// pass leave no borders in the mean.
pub(super) fn tile_shift(strategy: Strategy, pass: Pass) -> UVec2 {
    match strategy {
        Strategy::All => UVec2::ZERO,
        Strategy::Cuts(_) => {
            let u = pass.low_discrepancy_2d(Stream::Selection, 4);
            (u * TILE_SIZE as f32).as_uvec2()
        }
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
        let lights = self.subsets.of_pass(run.pass.index);
        let mut tile = TileGather::new(self.gather.strategy, run.pass, out);
        for pixel in tile.out.tile().pixels().enumerate() {
            self.trace_pixel(run, positions, pixel, lights, &mut tile);
        }
        let TileGather {
            points,
            shadow_rays,
            ..
        } = tile;
        let mut counts = TileCounts {
            camera_paths: out.tile().pixels().count() as u64,
            shadow_rays,
            ..TileCounts::default()
        };
        let mut found = Neighbors::new(PHOTON_NEIGHBORS);
        for (point, sum) in self.sums(points) {
            self.add_gather_point(&point, &sum, &mut found, out);
            counts.add(&point, &sum);
        }
        counts.add_to(run.stats);
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

    /// The points with the sums over virtual lights there. With [`ShareOf::Pixel`], points beyond the first of their camera path
    /// come after the first points, since the radiance of these sets the tolerance.
    fn sums(&self, points: Vec<GatherPoint<'s>>) -> Vec<(GatherPoint<'s>, Gathered)> {
        let limits = match self.gather.strategy {
            Strategy::Cuts(limits) if limits.share_of == ShareOf::Pixel => limits,
            _ => return self.sums_within(points, |_| self.tolerance),
        };
        let (first, beyond): (Vec<_>, Vec<_>) = points
            .into_iter()
            .partition(|point| point.stage == PathStage::BeforeX);
        let mut sums = self.sums_within(first, |_| self.tolerance);
        let pixels = sums.iter().map(|(point, _)| point.pixel + 1).max();
        let mut shown = vec![0.0; pixels.unwrap_or(0)];
        for (point, sum) in &sums {
            shown[point.pixel] += (point.throughput * sum.radiance).luminance();
        }
        sums.extend(self.sums_within(beyond, |point| {
            let shown = shown.get(point.pixel).copied().unwrap_or(0.0);
            self.tolerance.max(limits.max_error * shown)
        }));
        sums
    }

    /// The points with their sums, where a cluster of lights may be off by `tolerance` in the pixel of a point: luminance, in
    /// W/(m² sr).
    fn sums_within(
        &self,
        mut points: Vec<GatherPoint<'s>>,
        tolerance: impl Fn(&GatherPoint<'s>) -> f32,
    ) -> Vec<(GatherPoint<'s>, Gathered)> {
        for point in &mut points {
            let throughput = point.throughput.luminance().max(f32::MIN_POSITIVE);
            point.at.tolerance = tolerance(point) / throughput;
        }
        let places: Vec<ShadingPoint> = points.iter().map(|point| point.at).collect();
        let sums = self.gather.sum(self.scene, &self.lights, &places);
        points.into_iter().zip(sums).collect()
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
