//! A scattering model with its parameters at a point, and dispatch among all models.

use super::ExitTransmittance;
use super::incident_cone::IncidentCone;
use super::lobes::{Classes, Lobes, NEAR_DELTA_ALPHA};
use super::model_sample::{ModelSample, Numbers};
use super::models::conductor::{RoughConductor, SmoothConductor};
use super::models::dielectric::{RoughDielectric, SmoothDielectric};
use super::models::diffuse::Diffuse;
use super::models::diffuse_transmitter::DiffuseTransmitter;
use super::models::phong::Phong;
use super::models::plastic::{Plastic, RoughPlastic};
use super::models::principled::{Principled, PrincipledThin};
use super::models::rough_diffuse::RoughDiffuse;
use super::models::thin_dielectric::ThinDielectric;
use super::models::ward::Ward;
use super::response::Response;
use super::scattering_model::{self, ScatteringModel};
use crate::lanes::{Color, Float, Mask, One, Vector, Width};
use crate::math::Vec3;

/// A scattering model with its parameters at a point.
#[derive(Clone, Copy, Debug)]
pub(super) enum Model<'s, S: Width> {
    Diffuse(Diffuse<S>),
    RoughDiffuse(RoughDiffuse<S>),
    DiffuseTransmitter(DiffuseTransmitter<S>),
    SmoothConductor(SmoothConductor<S>),
    RoughConductor(RoughConductor<S>),
    SmoothDielectric(SmoothDielectric<S>),
    RoughDielectric(RoughDielectric<S>),
    ThinDielectric(ThinDielectric<S>),
    Plastic(Plastic<S>),
    RoughPlastic(RoughPlastic<'s, S>),
    Phong(Phong<S>),
    Ward(Ward<S>),
    Principled(Principled<S>),
    PrincipledThin(PrincipledThin<S>),
}

/// Calls a function of the [`ScatteringModel`] of a [`Model`].
macro_rules! of_model {
    ($model:expr, $m:ident => $call:expr) => {
        match $model {
            Model::Diffuse($m) => $call,
            Model::RoughDiffuse($m) => $call,
            Model::DiffuseTransmitter($m) => $call,
            Model::SmoothConductor($m) => $call,
            Model::RoughConductor($m) => $call,
            Model::SmoothDielectric($m) => $call,
            Model::RoughDielectric($m) => $call,
            Model::ThinDielectric($m) => $call,
            Model::Plastic($m) => $call,
            Model::RoughPlastic($m) => $call,
            Model::Phong($m) => $call,
            Model::Ward($m) => $call,
            Model::Principled($m) => $call,
            Model::PrincipledThin($m) => $call,
        }
    };
}

impl<S: Width> ScatteringModel<S> for Model<'_, S> {
    #[inline(always)]
    fn lobes(&self) -> Classes<S> {
        of_model!(self, m => m.lobes())
    }

    #[inline(always)]
    fn albedo_estimate(&self, cos: Float<S>, lobes: Classes<S>) -> Float<S> {
        of_model!(self, m => scattering_model::albedo_estimate(m, cos, lobes))
    }

    #[inline(always)]
    fn respond(&self, wi: Vector<S>, wo: Vector<S>, lobes: Classes<S>) -> Response<S> {
        of_model!(self, m => scattering_model::respond(m, wi, wo, lobes))
    }

    #[inline(always)]
    fn pdf(&self, given: Vector<S>, other: Vector<S>, lobes: Classes<S>) -> Float<S> {
        of_model!(self, m => scattering_model::pdf(m, given, other, lobes))
    }

    #[inline(always)]
    fn sample(&self, given: Vector<S>, u: Numbers<S>, lobes: Classes<S>) -> ModelSample<S> {
        of_model!(self, m => scattering_model::sample(m, given, u, lobes))
    }
}

impl<'s, S: Width> Model<'s, S> {
    /// The lanes in which a finite lobe transmits light to the other side.
    #[inline(always)]
    pub(super) fn transmits(&self, s: S) -> Mask<S> {
        match self {
            Model::RoughDielectric(_) | Model::DiffuseTransmitter(_) | Model::PrincipledThin(_) => {
                Mask::splat(s, true)
            }
            Model::Principled(m) => m.transmits(),
            _ => Mask::splat(s, false),
        }
    }

    /// Smallest roughness alpha of the `GLOSSY` lobes, at most 1; 1 without such lobes.
    #[inline(always)]
    pub(super) fn glossy_width(&self, s: S) -> Float<S> {
        let alpha = match self {
            Model::RoughConductor(m) => m.alpha(),
            Model::RoughDielectric(m) => m.alpha(),
            Model::RoughPlastic(m) => m.alpha(),
            Model::Phong(m) => m.alpha(),
            Model::Ward(m) => m.alpha(),
            Model::Principled(m) => m.glossy_alpha(),
            Model::PrincipledThin(m) => m.glossy_alpha(),
            _ => Float::splat(s, 1.0),
        };
        alpha.lt(NEAR_DELTA_ALPHA).select(1.0, alpha.min(1.0))
    }

    /// `a(wi)` of the `DIFFUSE` lobe, `f = a(wi) b(wo) / π`.
    #[inline(always)]
    pub(super) fn diffuse_weight(&self, wi: Vector<S>) -> Color<S> {
        match self {
            Model::Diffuse(m) => m.diffuse_weight(wi),
            Model::RoughDiffuse(m) => m.diffuse_weight(wi),
            Model::Plastic(m) => m.diffuse_weight(wi),
            Model::RoughPlastic(m) => m.diffuse_weight(wi),
            Model::Phong(m) => m.diffuse_weight(wi),
            Model::Ward(m) => m.diffuse_weight(wi),
            _ => Color::black(wi.z.width()),
        }
    }

    /// `b(wo)` of the `DIFFUSE` lobe.
    #[inline(always)]
    pub(super) fn exit_transmittance(&self) -> ExitTransmittance<'s> {
        match self {
            Model::Plastic(m) => ExitTransmittance::Fresnel { eta: m.eta },
            Model::RoughPlastic(m) => ExitTransmittance::Coated(m.transmittance),
            _ => ExitTransmittance::Lambert,
        }
    }
}

impl Model<'_, One> {
    /// Upper bound of all channels of the values over a cone of `wi`.
    #[inline]
    pub(super) fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        match self {
            Model::Diffuse(m) => m.bound(incident, wo, lobes),
            Model::RoughDiffuse(m) => m.bound(incident, wo, lobes),
            Model::DiffuseTransmitter(m) => m.bound(incident, wo, lobes),
            Model::RoughConductor(m) => m.bound(incident, wo, lobes),
            Model::RoughDielectric(m) => m.bound(incident, wo, lobes),
            Model::Plastic(m) => m.bound(incident, wo, lobes),
            Model::RoughPlastic(m) => m.bound(incident, wo, lobes),
            Model::Phong(m) => m.bound(incident, wo, lobes),
            Model::Ward(m) => m.bound(incident, wo, lobes),
            Model::Principled(m) => m.bound(incident, wo, lobes),
            Model::PrincipledThin(m) => m.bound(incident, wo, lobes),
            Model::SmoothConductor(_) | Model::SmoothDielectric(_) | Model::ThinDielectric(_) => {
                0.0
            }
        }
    }
}
