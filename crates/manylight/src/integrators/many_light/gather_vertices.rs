//! Vertices of camera paths at which light is gathered: why, with which random numbers, and what their directions need to know.

use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::emitters::EnvironmentLobes;
use crate::integrators::partition::PathStage;
use crate::math::Vec3;
use crate::sampling::{LowDiscrepancySequence, Sampler};

/// A camera path that ends at a vertex at which light is gathered.
#[derive(Clone, Copy, Debug)]
pub(super) struct GatherPath {
    /// Index of the pixel in the tile.
    pub(super) pixel: u32,
    pub(super) throughput: Rgb,
    /// As in [`Walks::eta_squared`](crate::transport::stream::Walks::eta_squared).
    pub(super) eta_squared: f32,
    /// Stage of the path partition before the event at its end.
    pub(super) stage: PathStage,
    /// Largest radius of density estimates at its end, in m.
    pub(super) max_photon_radius: f32,
    /// Roulette weight of a direction sampled at the first gather point of the path.
    pub(super) first_weight: f32,
}

impl GatherPath {
    /// Weight for roulette: the largest channel of the throughput times η², which undoes the scaling of radiance by refraction.
    pub(super) fn roulette_weight(&self) -> f32 {
        self.throughput.max_channel() * self.eta_squared
    }
}

/// Why lights are gathered at a vertex.
#[derive(Clone, Copy, Debug)]
pub(super) enum GatherRole {
    /// It ends a specular prefix. `photon_weight` as in [`GatherPoint`](super::gather_points::GatherPoint).
    FirstVertex { photon_weight: f32 },
    /// It restores light that clamping removed.
    Compensation {
        /// On transmitting surfaces, the normal of the side that was chosen.
        lit_from: Option<Vec3>,
        /// As in [`GatherPoint`](super::gather_points::GatherPoint).
        direction_limit: f32,
    },
    /// A glossy lobe sees it by specular events.
    BehindSpecularChain,
}

impl GatherRole {
    pub(super) fn lit_from(self) -> Option<Vec3> {
        match self {
            GatherRole::Compensation { lit_from, .. } => lit_from,
            GatherRole::FirstVertex { .. } | GatherRole::BehindSpecularChain => None,
        }
    }

    pub(super) fn direction_limit(self) -> f32 {
        match self {
            GatherRole::Compensation {
                direction_limit, ..
            } => direction_limit,
            GatherRole::FirstVertex { .. } | GatherRole::BehindSpecularChain => f32::INFINITY,
        }
    }

    pub(super) fn photon_weight(self) -> f32 {
        match self {
            GatherRole::FirstVertex { photon_weight } => photon_weight,
            GatherRole::Compensation { .. } | GatherRole::BehindSpecularChain => 1.0,
        }
    }
}

/// Random numbers of the directions at a gather point.
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
    /// Those of one direction.
    pub(super) fn single(sampler: &mut Sampler) -> Self {
        DirectionNumbers {
            count: 1,
            first: 0,
            emitters: sampler.next_sequence(),
            directions: sampler.next_sequence(),
        }
    }
}

/// What a gather point, the one with the same index in the tile, needs for its directions and emitter samples.
pub(super) struct GatherVertex {
    pub(super) path: GatherPath,
    pub(super) role: GatherRole,
    pub(super) numbers: DirectionNumbers,
    /// Random numbers of the directions.
    pub(super) sampler: Sampler,
    /// Surface area per light around it, in m²; `None` if too few directions share the query for it.
    pub(super) area_per_light: Option<f32>,
    /// Guide of next-event estimation.
    pub(super) environment: Option<EnvironmentLobes>,
}

impl GatherVertex {
    /// Stage of the path partition after a direction was sampled here.
    pub(super) fn stage_of_directions(&self) -> PathStage {
        self.path.stage.after(Lobes::DIFFUSE)
    }
}
