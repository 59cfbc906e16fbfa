//! One infinite light.

use super::environment::EnvironmentSampler;
use crate::color::Rgb;
use crate::emitters::Emitter;
use crate::emitters::receivers::Receivers;
use crate::ids::EmitterId;
use crate::lanes::{
    Axes, Float, Mask, One, Pair, Vector, Width, cosine_hemisphere, cosine_hemisphere_pdf, sphere,
    split,
};
use crate::math::{Vec2, Vec3};
use crate::sampling::warp;
use std::f32::consts::PI;

/// Probability that a direction towards a constant environment is sampled uniformly over the sphere
/// instead of by the cosine to the receiver's normal. Must be positive: shading normals let
/// receivers see below that normal. Larger values cost noise on all surfaces, smaller ones make rare
/// samples below the normal brighter. Spheres on a plane, path tracing: 0.05 has 0.90 of the
/// variance, 0.2 has 0.99.
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
            | Emitter::InvisibleArea { .. }
            | Emitter::Point { .. }
            | Emitter::Goniometric { .. }
            | Emitter::Spot { .. } => None,
        }
    }

    /// Irradiance of parallel light; for the others radiance integrated over all directions. In
    /// W/m².
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

    /// Radiance from the unit direction `wi`; `None` for parallel light.
    pub(super) fn radiance(&self, wi: Vec3) -> Option<Rgb> {
        match &self.kind {
            InfiniteLightKind::Directional { .. } => None,
            InfiniteLightKind::Constant { radiance } => Some(*radiance),
            InfiniteLightKind::Environment(sampler) => Some(
                EnvironmentSampler::look_up(sampler, Vector::<One>::from(wi))
                    .radiance
                    .into(),
            ),
        }
    }

    /// A direction towards the light for the emission of a photon, and radiance over its pdf: the
    /// irradiance on a plane perpendicular to the direction.
    pub(super) fn sample_emission(&self, u: Vec2) -> Option<(Vec3, Rgb)> {
        match &self.kind {
            InfiniteLightKind::Directional { wi, irradiance } => Some((*wi, *irradiance)),
            InfiniteLightKind::Constant { radiance } => {
                Some((warp::sphere(u), *radiance / warp::SPHERE_PDF))
            }
            InfiniteLightKind::Environment(sampler) => {
                let sample = EnvironmentSampler::sample(sampler, u.into(), Mask::splat(One, true));
                let irradiance = Rgb::from(sample.radiance / sample.pdf);
                (sample.pdf.get() > 0.0).then(|| (sample.wi.into(), irradiance))
            }
        }
    }
}

/// Directions towards a constant environment. `u_mixture` chooses between uniform and
/// cosine-distributed directions.
#[inline(always)]
pub(super) fn sample_constant<S: Width>(
    receivers: &Receivers<S>,
    u_mixture: Float<S>,
    u: Pair<S>,
) -> Vector<S> {
    let (is_uniform, _) = split(u_mixture, UNIFORM_DIRECTION_PROBABILITY);
    let by_cosine = receivers.has_normal & !is_uniform;
    let uniform = sphere(u);
    if by_cosine.none() {
        return uniform;
    }
    let around_normal = Axes::from_normal(receivers.n)
        .to_world(cosine_hemisphere(u))
        .normalize();
    Vector::select(by_cosine, around_normal, uniform)
}

/// Density of [`sample_constant`] per solid angle.
#[inline(always)]
pub(super) fn constant_pdf<S: Width>(receivers: &Receivers<S>, wi: Vector<S>) -> Float<S> {
    let cosine = cosine_hemisphere_pdf(receivers.n.dot(wi));
    let mixture = UNIFORM_DIRECTION_PROBABILITY * warp::SPHERE_PDF
        + cosine * (1.0 - UNIFORM_DIRECTION_PROBABILITY);
    receivers.has_normal.select(mixture, warp::SPHERE_PDF)
}
