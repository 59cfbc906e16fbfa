//! Gather points: the vertices of camera paths at which all light that non-specular lobes reflect
//! is estimated.
//!
//! Light of emitters is estimated by next-event estimation and by sampled directions, combined by
//! MIS (`direction.rs`). After the last round follow the sum over virtual lights and the density
//! estimates over photons. A direction that meets a surface continues in two ways:
//!
//! * by bias compensation of the sum over virtual lights (`compensation.rs`);
//! * by specular events, if the surface has specular lobes (`chain.rs`).
//!
//! Both end at another gather point, on a sparse subset of the lights.

use super::passes::PixelFootprint;
use super::paths::{GroupScales, ScaleRow};
use super::paths::{PathNumber, PixelNumbers, SPLIT};
use super::radiance_cache::CACHE_NEIGHBORS;
use super::settings::MAX_CAMERA_PATHS;
use super::trace::PHOTON_NEIGHBORS;
use super::{Compensation, PreparedPasses};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::emitters::{EnvironmentLobes, MAX_ENVIRONMENT_LOBES};
use crate::film::TileSamples;
use crate::gather::{ShadingPoint, Strategy, Subset};
use crate::ids::MaterialId;
use crate::integrators::connections::Connections;
use crate::integrators::context::PassContext;
use crate::integrators::guiding::environment_guide;
use crate::integrators::partition::PathStage;
use crate::maps::Neighbors;
use crate::math::Vec3;
use crate::sampling::{LowDiscrepancySequence, Pass, Sampler, Stream};
use crate::transport::Vertex;

/// Directions at the first gather points of the camera paths of a pixel, together. At 8 and 32 (2
/// passes of 128 lights at 72x40, 3 seeds; Kitchen, Glossy Room, U-Shape): relMSE +14 and -9.5 %
/// (standard error 4 %), shadow rays -21 and +43 %.
pub(super) const DIRECTIONS: u32 = 16;
const _: () = assert!(
    DIRECTIONS.is_multiple_of(MAX_CAMERA_PATHS),
    "each camera path has as many"
);
/// Fewest directions at a point for which a query of the area per light pays. At 2 and 8 (2 passes
/// of 128 lights at 72x40, 2 seeds; Kitchen, Glossy Room): relMSE +0.1 and +2.2 % (standard error 1
/// %).
const AREA_QUERY_DIRECTIONS: u32 = 4;
/// Beyond the first gather point of a camera path, one light in this many is summed: such points
/// add a small part of the image, so that their noise may be larger. At 4 and 16 (2 passes of 128
/// lights at 72x40, 3 seeds; Kitchen, Glossy Room, U-Shape): relMSE -1.9 and +1.7 % (standard error
/// 1 %), shadow rays +31 and -16 %.
const SPARSE_STEP: u32 = 8;
/// Number of different sparse subsets in a pass, the same in all tiles: points with the same subset
/// are summed together.
const SPARSE_CHOICES: u32 = 4;
/// Squared distance, relative to the area per light, within which a cached area per light is used
/// again: a fifth of the distance to the eighth light. At 0.05 and 0.2 (2 passes of 128 lights at
/// 72x40, 2 seeds; Kitchen, Glossy Room): pictures differ by at most 0.6 % (RMS).
const CACHED_AREA_REACH: f32 = 0.1;

/// A vertex of a camera path at which light is gathered.
pub(super) struct GatherPoint<'s> {
    /// The vertex, as the sum over virtual lights sees it.
    pub(super) at: ShadingPoint<'s>,
    pub(super) material: MaterialId,
    /// The camera path that ends here.
    pub(super) path: GatherPath,
    /// Why light is gathered here.
    pub(super) role: GatherRole,
    /// Sequences of the directions and emitter samples here.
    pub(super) numbers: DirectionNumbers,
    /// Random numbers of the paths along the directions.
    pub(super) sampler: Sampler,
    /// Surface area per light around it, in m²; `None` if too few directions share the query for
    /// it.
    pub(super) area_per_light: Option<f32>,
    /// Guide of next-event estimation.
    pub(super) environment: Option<EnvironmentLobes>,
}

/// A camera path up to a gather point.
#[derive(Clone, Copy, Debug)]
pub(super) struct GatherPath {
    /// Index of the pixel in the tile.
    pub(super) pixel: u32,
    pub(super) throughput: Rgb,
    /// As in [`WalkState::eta_squared`](crate::transport::stream::WalkState::eta_squared).
    pub(super) eta_squared: f32,
    /// Segments up to the gather point.
    pub(super) segments: u32,
    /// Stage of the path partition before the non-specular event at the gather point.
    pub(super) stage: PathStage,
    /// Largest radius of density estimates there, in m.
    pub(super) max_photon_radius: f32,
    /// Roulette weight of a direction sampled at the first gather point of the path.
    pub(super) first_weight: f32,
    /// Factors on the light of each light group.
    pub(super) scales: ScaleRow,
}

impl GatherPath {
    /// Weight for roulette: the largest channel of the throughput times η², which undoes the
    /// scaling of radiance by refraction.
    pub(super) fn roulette_weight(&self) -> f32 {
        self.throughput.max_channel() * self.eta_squared
    }

    /// Stage of the path partition after a direction was sampled.
    pub(super) fn stage_of_directions(&self) -> PathStage {
        self.stage.after(Lobes::NON_SPECULAR)
    }
}

/// Why light is gathered at a vertex.
#[derive(Clone, Copy, Debug)]
pub(super) enum GatherRole {
    /// It ends a specular prefix, of this number in its pixel.
    FirstVertex(PathNumber),
    /// It restores light that clamping removed.
    Compensation {
        /// See [`direction_limit`](super::compensation_photons::direction_limit).
        direction_limit: f32,
    },
    /// A direction from another gather point reaches it by specular events.
    BehindSpecularChain,
}

impl GatherRole {
    /// Largest `f cosθ` up to which directions account for all light of emitters, in 1/sr.
    pub(super) fn direction_limit(self) -> f32 {
        match self {
            GatherRole::Compensation { direction_limit } => direction_limit,
            GatherRole::FirstVertex(_) | GatherRole::BehindSpecularChain => f32::INFINITY,
        }
    }

    /// Factor on density estimates. Photons change little within a pixel: before the first specular
    /// event, one camera path of the pixel queries the photons, weighted for all of them, unless the
    /// pixel starts with [`SPLIT`] paths.
    pub(super) fn photon_weight(self) -> f32 {
        match self {
            GatherRole::FirstVertex(PathNumber { count: SPLIT, .. }) => 1.0,
            GatherRole::FirstVertex(PathNumber { index: 0, count }) => count as f32,
            GatherRole::FirstVertex(_) => 0.0,
            GatherRole::Compensation { .. } | GatherRole::BehindSpecularChain => 1.0,
        }
    }
}

/// Sequences of the directions and emitter samples at a gather point.
#[derive(Clone, Copy, Debug)]
pub(super) struct DirectionNumbers {
    /// Number of directions.
    pub(super) count: u32,
    /// Index of the first direction in the sequences.
    pub(super) first: u32,
    pub(super) emitters: LowDiscrepancySequence,
    pub(super) directions: LowDiscrepancySequence,
}

impl DirectionNumbers {
    /// The part of path `number` in the directions of its pixel.
    fn of_pixel(pixel: &PixelNumbers, number: PathNumber) -> Self {
        let count = DIRECTIONS / number.count;
        DirectionNumbers {
            count,
            first: number.index * count,
            emitters: pixel.emitters,
            directions: pixel.directions,
        }
    }

    /// Those of one direction.
    fn single(sampler: &mut Sampler) -> Self {
        DirectionNumbers {
            count: 1,
            first: 0,
            emitters: sampler.next_sequence(),
            directions: sampler.next_sequence(),
        }
    }
}

impl<'s> AsRef<ShadingPoint<'s>> for GatherPoint<'s> {
    fn as_ref(&self) -> &ShadingPoint<'s> {
        &self.at
    }
}

/// What the camera paths of a tile share: their gather points and the tile's samples.
pub(super) struct TileGather<'s, 'o, 't> {
    pub(super) prepared: &'o PreparedPasses<'s>,
    pub(super) pixel: PixelFootprint,
    pub(super) out: &'o mut TileSamples<'t>,
    /// The lights of this pass, by pixel.
    lights: Vec<Subset>,
    /// By pixel.
    pub(super) numbers: Vec<PixelNumbers>,
    pub(super) points: Vec<GatherPoint<'s>>,
    /// Of the camera paths.
    pub(super) scales: GroupScales,
    /// Light of sampled emitters.
    pub(super) connections: Connections,
    /// Memory for queries of the environment guide.
    found: Neighbors,
    /// Memory for queries of the radiance cache.
    pub(super) found_photons: Neighbors,
    /// Memory for queries of caustic photons besides one that is weighed.
    pub(super) found_caustics: Neighbors,
    /// Position of the last query of the area per light, and the area in m².
    cached_area: Option<(Vec3, f32)>,
    sparse: SparseSubsets,
}

impl<'s, 'o, 't> TileGather<'s, 'o, 't> {
    pub(super) fn new(
        prepared: &'o PreparedPasses<'s>,
        run: &PassContext,
        out: &'o mut TileSamples<'t>,
    ) -> Self {
        let pass = run.pass;
        let frame = pass.seed ^ run.lights_seed;
        let lights = |pixel| prepared.subsets.of_pixel(pass.index, pixel, frame);
        TileGather {
            prepared,
            pixel: PixelFootprint::of(run.camera),
            lights: out.tile().pixels().map(lights).collect(),
            scales: GroupScales::new(prepared.light_groups),
            connections: Connections::of(out),
            out,
            numbers: Vec::new(),
            points: Vec::new(),
            found: Neighbors::new(MAX_ENVIRONMENT_LOBES),
            found_photons: Neighbors::new(CACHE_NEIGHBORS),
            found_caustics: Neighbors::new(PHOTON_NEIGHBORS - 1),
            cached_area: None,
            sparse: SparseSubsets::new(prepared.gather.strategy, pass),
        }
    }

    /// The vertex `v` at the end of `path` becomes a gather point. `lit_from` as in
    /// [`ShadingPoint`].
    pub(super) fn gather(
        &mut self,
        v: &Vertex<'s>,
        path: GatherPath,
        role: GatherRole,
        lit_from: Option<Vec3>,
        sampler: &mut Sampler,
    ) {
        let prepared = self.prepared;
        let of_pixel = self.lights[path.pixel as usize];
        let (lights, numbers) = match role {
            GatherRole::FirstVertex(number) => (
                of_pixel.divided(number.index, number.count),
                DirectionNumbers::of_pixel(&self.numbers[path.pixel as usize], number),
            ),
            GatherRole::Compensation { .. } | GatherRole::BehindSpecularChain => (
                self.sparse.next(of_pixel),
                DirectionNumbers::single(sampler),
            ),
        };
        let compensates = prepared.compensation == Compensation::KolligKeller;
        let area_per_light = (compensates && numbers.count >= AREA_QUERY_DIRECTIONS)
            .then(|| self.area_per_light(v.x.p));
        let primitive = &prepared.scene.geometry.primitives()[v.x.at.primitive.index()];
        self.points.push(GatherPoint {
            at: ShadingPoint {
                x: v.x,
                wo: v.w_prev,
                bsdf: v.bsdf,
                max_photon_depth: prepared
                    .limits
                    .max_depth
                    .map(|max| max - (path.segments + 1)),
                u: sampler.next_1d(),
                lights,
                tolerance: 0.0,
                lit_from,
            },
            material: primitive.material,
            path,
            role,
            numbers,
            sampler: sampler.branch(),
            area_per_light,
            environment: environment_guide(&prepared.incident, v, &mut self.found),
        });
    }

    /// Surface area per light at a position near `p`, in m².
    fn area_per_light(&mut self, p: Vec3) -> f32 {
        if let Some((position, area)) = self.cached_area
            && position.distance_squared(p) < CACHED_AREA_REACH * area
        {
            return area;
        }
        let area = self.prepared.lights.set.surface_per_light(p);
        self.cached_area = Some((p, area));
        area
    }
}

/// Deals out sparse subsets of the lights of a pass in turn.
struct SparseSubsets {
    first: u32,
    choices: u32,
    dealt: u32,
}

impl SparseSubsets {
    fn new(strategy: Strategy, pass: Pass) -> Self {
        let u = pass.sampler(Stream::SparseSubsets, 0).next_1d();
        SparseSubsets {
            first: (u * SPARSE_STEP as f32) as u32,
            choices: match strategy {
                Strategy::All => SPARSE_CHOICES,
                // A cut uses only the size of the subset.
                Strategy::Cuts(_) | Strategy::Bidirectional(_) => 1,
            },
            dealt: 0,
        }
    }

    fn next(&mut self, lights: Subset) -> Subset {
        let choice = self.dealt % self.choices;
        self.dealt += 1;
        lights.part(
            self.first + choice * (SPARSE_STEP / self.choices),
            SPARSE_STEP,
        )
    }
}
