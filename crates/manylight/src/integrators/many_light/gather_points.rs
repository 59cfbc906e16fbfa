//! Gather points, and what the camera paths of a tile share while they are followed.

use super::caustic_shares::PHOTON_NEIGHBORS;
use super::gather_vertices::GatherVertex;
use super::paths::PixelNumbers;
use super::prepared::PreparedPasses;
use super::radiance_cache::CACHE_NEIGHBORS;
use crate::color::Rgb;
use crate::emitters::MAX_ENVIRONMENT_LOBES;
use crate::film::TileSamples;
use crate::gather::{ShadingPoint, Strategy, Subset};
use crate::ids::MaterialId;
use crate::integrators::connections::Connections;
use crate::integrators::partition::PathStage;
use crate::maps::Neighbors;
use crate::math::Vec3;
use crate::sampling::{Pass, Stream};

/// Beyond the first gather point of a camera path, one light in this many is summed. Unmeasured: such points add a small part
/// of the image, so that their noise may be larger.
const SPARSE_STEP: u32 = 8;
/// Number of different sparse subsets in a pass, the same in all tiles: points with the same subset are summed together.
const SPARSE_CHOICES: u32 = 4;
/// Squared distance, relative to the area per light, within which a cached area per light is used again. Unmeasured.
const CACHED_AREA_REACH: f32 = 0.1;

/// A vertex of a camera path at which virtual lights and photons are summed.
pub(super) struct GatherPoint<'s> {
    /// Index of the pixel in the tile.
    pub(super) pixel: usize,
    /// Throughput of the camera path up to this vertex.
    pub(super) throughput: Rgb,
    /// Segments of the camera path up to this vertex.
    pub(super) segments: u32,
    pub(super) material: MaterialId,
    pub(super) at: ShadingPoint<'s>,
    /// Stage of the path partition before the non-specular event here.
    pub(super) stage: PathStage,
    /// Largest radius of density estimates, in m.
    pub(super) max_photon_radius: f32,
    /// See [`direction_limit`](super::compensation_photons::direction_limit); infinite if directions account for all light
    /// of emitters here.
    pub(super) direction_limit: f32,
    /// Factor on density estimates here. Photons change little within a pixel: before the first specular event, one camera path
    /// of the pixel queries the photons, weighted for all of them.
    pub(super) photon_weight: f32,
}

impl<'s> AsRef<ShadingPoint<'s>> for GatherPoint<'s> {
    fn as_ref(&self) -> &ShadingPoint<'s> {
        &self.at
    }
}

/// What the camera paths of a tile share: their gather points and the tile's samples.
pub(super) struct TileGather<'s, 'o, 't> {
    pub(super) prepared: &'o PreparedPasses<'s>,
    pub(super) out: &'o mut TileSamples<'t>,
    /// The lights of this pass.
    pub(super) lights: Subset,
    /// By pixel.
    pub(super) numbers: Vec<PixelNumbers>,
    pub(super) points: Vec<GatherPoint<'s>>,
    /// By gather point.
    pub(super) vertices: Vec<GatherVertex>,
    /// Light of sampled emitters.
    pub(super) connections: Connections,
    /// Memory for queries of the environment guide.
    pub(super) found: Neighbors,
    /// Memory for queries of the radiance cache.
    pub(super) found_photons: Neighbors,
    /// Memory for queries of caustic photons.
    pub(super) found_caustics: Neighbors,
    /// Position of the last query of the area per light, and the area in m².
    cached_area: Option<(Vec3, f32)>,
    sparse: SparseSubsets,
}

impl<'s, 'o, 't> TileGather<'s, 'o, 't> {
    pub(super) fn new(
        prepared: &'o PreparedPasses<'s>,
        pass: Pass,
        out: &'o mut TileSamples<'t>,
    ) -> Self {
        TileGather {
            prepared,
            out,
            lights: prepared.subsets.of_pass(pass.index),
            numbers: Vec::new(),
            points: Vec::new(),
            vertices: Vec::new(),
            connections: Connections::default(),
            found: Neighbors::new(MAX_ENVIRONMENT_LOBES),
            found_photons: Neighbors::new(CACHE_NEIGHBORS),
            found_caustics: Neighbors::new(PHOTON_NEIGHBORS),
            cached_area: None,
            sparse: SparseSubsets::new(prepared.gather.strategy, pass),
        }
    }

    /// A sparse subset of the lights of this pass.
    pub(super) fn sparse_lights(&mut self) -> Subset {
        self.sparse.next(self.lights)
    }

    /// Surface area per light at a position near `p`, in m².
    pub(super) fn area_per_light(&mut self, p: Vec3) -> f32 {
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
        let u = pass.sampler(Stream::Selection, 2).next_1d();
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
