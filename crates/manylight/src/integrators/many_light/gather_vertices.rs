//! Vertices of camera paths at which light is gathered: why, with which random numbers, and what a direction sampled there knows.

use crate::color::Rgb;
use crate::emitters::EnvironmentLobes;
use crate::gather::ClampReceiver;
use crate::geometry::SurfacePoint;
use crate::ids::MaterialId;
use crate::integrators::partition::PathStage;
use crate::math::Vec3;
use crate::sampling::{LowDiscrepancySequence, Sampler};
use crate::transport::Walk;

/// A camera path from its first gather point on.
#[derive(Clone)]
pub(super) struct GatherPath<'s> {
    pub(super) walk: Walk<'s>,
    pub(super) stage: PathStage,
    /// Largest radius of density estimates at its end, in m.
    pub(super) max_photon_radius: f32,
}

/// Why lights are gathered at a vertex.
#[derive(Clone, Copy)]
pub(super) enum GatherRole {
    /// It ends a specular prefix. `photon_weight` as in [`GatherPoint`].
    FirstVertex { photon_weight: f32 },
    /// It restores light that clamping removed.
    Compensation {
        /// On transmitting surfaces, the normal of the side that was chosen.
        lit_from: Option<Vec3>,
        /// As in [`GatherPoint`].
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

/// Random numbers that the camera paths of a pixel share, so that together they fill their domains evenly.
#[derive(Clone, Copy)]
pub(super) struct PixelNumbers {
    pub(super) events: LowDiscrepancySequence,
    pub(super) emitters: LowDiscrepancySequence,
    pub(super) directions: LowDiscrepancySequence,
}

impl PixelNumbers {
    pub(super) fn draw(sampler: &mut Sampler) -> Self {
        PixelNumbers {
            events: sampler.next_sequence(),
            emitters: sampler.next_sequence(),
            directions: sampler.next_sequence(),
        }
    }
}

/// Random numbers of the directions at a gather point.
pub(super) struct DirectionNumbers {
    /// Number of directions.
    pub(super) count: u32,
    /// Index of the first direction in the sequences.
    pub(super) first: u32,
    pub(super) emitters: LowDiscrepancySequence,
    pub(super) directions: LowDiscrepancySequence,
}

impl DirectionNumbers {
    /// Those of camera path `index` of a pixel, each of which has `count`.
    pub(super) fn of_path(index: u32, count: u32, numbers: PixelNumbers) -> Self {
        DirectionNumbers {
            count,
            first: index * count,
            emitters: numbers.emitters,
            directions: numbers.directions,
        }
    }

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

/// A vertex of a camera path at which the light of emitters is not yet estimated, and no direction sampled.
pub(super) struct WaitingVertex<'s> {
    /// Index of the pixel in the tile.
    pub(super) pixel: usize,
    /// Index of its gather point in the tile.
    pub(super) point: usize,
    pub(super) material: MaterialId,
    /// The path that ends there.
    pub(super) path: GatherPath<'s>,
    pub(super) role: GatherRole,
    pub(super) numbers: DirectionNumbers,
    /// Random numbers of the directions.
    pub(super) sampler: Sampler,
    /// See [`PixelGather::first_weight`].
    pub(super) first_weight: f32,
    /// See [`GatherDirection::area_per_light`].
    pub(super) area_per_light: Option<f32>,
    /// Guide of next-event estimation.
    pub(super) environment: Option<EnvironmentLobes>,
}

/// A vertex with a direction sampled there.
pub(super) struct GatherDirection<'x> {
    pub(super) x: SurfacePoint,
    /// Unit direction to the viewer.
    pub(super) wo: Vec3,
    /// Segments of the camera path up to the vertex.
    pub(super) segments: u32,
    /// Whether it has glossy lobes.
    pub(super) is_glossy: bool,
    /// The vertex as a gather point.
    pub(super) receiver: ClampReceiver,
    /// Index of the gather point in the tile.
    pub(super) point: usize,
    /// `f cosθ` of its non-specular lobes in the direction, in 1/sr.
    pub(super) f_cos: Rgb,
    /// Surface area per light around it, in m²; `None` if too few directions share the query for it.
    pub(super) area_per_light: Option<f32>,
    /// Guide of next-event estimation there.
    pub(super) environment: Option<&'x EnvironmentLobes>,
    pub(super) role: GatherRole,
}
