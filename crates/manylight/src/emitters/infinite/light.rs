//! One infinite light.

use super::environment::EnvironmentSampler;
use crate::color::Rgb;
use crate::emitters::Emitter;
use crate::emitters::unit_interval::split;
use crate::ids::EmitterId;
use crate::math::{Frame, Vec2, Vec3};
use crate::sampling::warp;
use std::f32::consts::PI;

/// Probability that a direction towards a constant environment is sampled uniformly over the sphere instead of by the cosine
/// to the receiver's normal. Must be positive: shading normals let receivers see below that normal. Not measured: larger values
/// cost noise on all surfaces, smaller ones make rare samples below the normal brighter.
const UNIFORM_DIRECTION_PROBABILITY: f32 = 0.1;

/// Emission of an infinite light by kind.
#[derive(Clone, Debug)]
pub(super) enum InfiniteLightKind {
    /// Light from the unit direction `wi`, with its irradiance on a perpendicular plane.
    Directional {
        wi: Vec3,
        irradiance: Rgb,
    },
    Constant {
        radiance: Rgb,
    },
    Environment(EnvironmentSampler),
}

/// An infinite light.
#[derive(Clone, Debug)]
pub(super) struct InfiniteLight {
    pub(super) emitter: EmitterId,
    pub(super) kind: InfiniteLightKind,
    /// Probability of choosing this light for direct light.
    pub(super) pmf: f32,
}

impl InfiniteLightKind {
    /// `None` for emitters that are not at infinity, and for black environment maps.
    pub(super) fn new(emitter: &Emitter) -> Option<Self> {
        match emitter {
            Emitter::Directional {
                direction,
                irradiance,
            } => Some(InfiniteLightKind::Directional {
                wi: -direction.normalize_or_zero(),
                irradiance: *irradiance,
            }),
            Emitter::Constant { radiance } => Some(InfiniteLightKind::Constant {
                radiance: *radiance,
            }),
            Emitter::Environment(environment) => {
                EnvironmentSampler::new(environment).map(InfiniteLightKind::Environment)
            }
            Emitter::Area { .. }
            | Emitter::Point { .. }
            | Emitter::Goniometric { .. }
            | Emitter::Spot { .. } => None,
        }
    }

    /// Irradiance of parallel light; for the others radiance integrated over all directions. In W/m².
    pub(super) fn total(&self) -> Rgb {
        match self {
            InfiniteLightKind::Directional { irradiance, .. } => *irradiance,
            InfiniteLightKind::Constant { radiance } => *radiance * (4.0 * PI),
            InfiniteLightKind::Environment(sampler) => sampler.total(),
        }
    }
}

impl InfiniteLight {
    /// Whether the light fills a solid angle.
    pub(super) fn fills_directions(&self) -> bool {
        !matches!(self.kind, InfiniteLightKind::Directional { .. })
    }

    /// A direction towards the light for the emission of a photon, and radiance over its pdf: the irradiance on a plane
    /// perpendicular to the direction.
    pub(super) fn sample_emission(&self, u: Vec2) -> Option<(Vec3, Rgb)> {
        match &self.kind {
            InfiniteLightKind::Directional { wi, irradiance } => Some((*wi, *irradiance)),
            InfiniteLightKind::Constant { radiance } => {
                Some((warp::sphere(u), *radiance / warp::SPHERE_PDF))
            }
            InfiniteLightKind::Environment(sampler) => {
                let sample = sampler.sample(u);
                (sample.pdf > 0.0).then(|| (sample.wi, sample.radiance / sample.pdf))
            }
        }
    }
}

/// A direction towards a constant environment for a receiver with normal `n`. `u_mixture` chooses between uniform and
/// cosine-distributed directions.
#[inline]
pub(super) fn sample_constant(n: Option<Vec3>, u_mixture: f32, u: Vec2) -> Vec3 {
    match n {
        Some(n) if !split(u_mixture, UNIFORM_DIRECTION_PROBABILITY).0 => Frame::from_normal(n)
            .to_world(warp::cosine_hemisphere(u))
            .normalize(),
        _ => warp::sphere(u),
    }
}

/// Density of [`sample_constant`] per solid angle.
#[inline]
pub(super) fn constant_pdf(n: Option<Vec3>, wi: Vec3) -> f32 {
    match n {
        Some(n) => {
            let cosine = warp::cosine_hemisphere_pdf(n.dot(wi));
            UNIFORM_DIRECTION_PROBABILITY * warp::SPHERE_PDF
                + (1.0 - UNIFORM_DIRECTION_PROBABILITY) * cosine
        }
        None => warp::SPHERE_PDF,
    }
}
