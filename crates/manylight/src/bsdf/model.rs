//! The contract of all scattering models, and dispatch among them.
//!
//! Models work in a local frame with the normal as z axis. `eval` is `f(wi → wo) |cosθ_i|`, `bound` its upper bound over a cone of `wi`.
//! `sample` and `pdf` take the given direction, `wi` or `wo`: sampling is the same for both, because visible half vectors depend on
//! one direction only.

use super::incident_cone::IncidentCone;
use super::model_sample::ModelSample;
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
use super::response::{ByClass, Response};
use super::{BsdfNumbers, ExitTransmittance, Lobes, NEAR_DELTA_ALPHA};
use crate::color::Rgb;
use crate::math::Vec3;

/// A scattering model with its parameters at a point.
#[derive(Clone, Copy, Debug)]
pub(super) enum Model<'s> {
    Diffuse(Diffuse),
    RoughDiffuse(RoughDiffuse),
    DiffuseTransmitter(DiffuseTransmitter),
    SmoothConductor(SmoothConductor),
    RoughConductor(RoughConductor),
    SmoothDielectric(SmoothDielectric),
    RoughDielectric(RoughDielectric),
    ThinDielectric(ThinDielectric),
    Plastic(Plastic),
    RoughPlastic(RoughPlastic<'s>),
    Phong(Phong),
    Ward(Ward),
    Principled(Principled),
    PrincipledThin(PrincipledThin),
}

macro_rules! dispatch {
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

impl<'s> Model<'s> {
    /// The classes of the lobes.
    #[inline]
    pub(super) fn lobes(&self) -> Lobes {
        dispatch!(self, m => m.lobes())
    }

    /// Whether a finite lobe transmits light to the other side.
    #[inline]
    pub(super) fn transmits(&self) -> bool {
        match self {
            Model::RoughDielectric(_) | Model::DiffuseTransmitter(_) | Model::PrincipledThin(_) => {
                true
            }
            Model::Principled(m) => m.transmits(),
            _ => false,
        }
    }

    /// `f(wi → wo) |cosθ_i|` of the finite lobes in `lobes`.
    #[inline]
    pub(super) fn eval(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        dispatch!(self, m => m.eval(wi, wo, lobes))
    }

    /// Upper bound of all channels of [`Model::eval`] over a cone of `wi`.
    #[inline]
    pub(super) fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        dispatch!(self, m => m.bound(incident, wo, lobes))
    }

    /// Density of sampling `other` given `given` with [`Model::sample`] from the finite lobes.
    #[inline]
    pub(super) fn pdf(&self, given: Vec3, other: Vec3, lobes: Lobes) -> f32 {
        dispatch!(self, m => m.pdf(given, other, lobes))
    }

    /// [`Model::eval`] by class, and [`Model::pdf`] given `wo`, with shared computations.
    #[inline]
    pub(super) fn respond(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Response {
        match self {
            Model::RoughConductor(m) => m.respond(wi, wo, lobes),
            Model::RoughPlastic(m) => m.respond(wi, wo, lobes),
            Model::Principled(m) => m.respond(wi, wo, lobes),
            _ => Response {
                values: ByClass::of(self.lobes().and(lobes), |class| self.eval(wi, wo, class)),
                pdf: self.pdf(wo, wi, lobes),
            },
        }
    }

    /// Estimated albedo of `lobes` for a given direction with this cosine: the largest channel. It decides how often the model is
    /// sampled beside others. Positive wherever `sample` or `eval` give light, as far as one cosine tells.
    pub(super) fn albedo_estimate(&self, cos: f32, lobes: Lobes) -> f32 {
        dispatch!(self, m => m.albedo_estimate(cos, lobes))
    }

    /// Samples the other direction. `lobes` and the lobes of the model have a class in common.
    #[inline]
    pub(super) fn sample(&self, given: Vec3, u: BsdfNumbers, lobes: Lobes) -> Option<ModelSample> {
        dispatch!(self, m => m.sample(given, u, lobes))
    }

    /// Smallest roughness alpha of the `GLOSSY` lobes, at most 1; 1 without such lobes.
    pub(super) fn glossy_width(&self) -> f32 {
        let alpha = match self {
            Model::RoughConductor(m) => m.alpha(),
            Model::RoughDielectric(m) => m.alpha(),
            Model::RoughPlastic(m) => m.alpha(),
            Model::Phong(m) => m.alpha(),
            Model::Ward(m) => m.alpha(),
            Model::Principled(m) => m.glossy_alpha(),
            Model::PrincipledThin(m) => m.glossy_alpha(),
            _ => 1.0,
        };
        if alpha < NEAR_DELTA_ALPHA {
            1.0
        } else {
            alpha.min(1.0)
        }
    }

    /// `a(wi)` of the `DIFFUSE` lobe, `f = a(wi) b(wo) / π`.
    #[inline]
    pub(super) fn diffuse_weight(&self, wi: Vec3) -> Rgb {
        match self {
            Model::Diffuse(m) => m.diffuse_weight(wi),
            Model::Plastic(m) => m.diffuse_weight(wi),
            Model::RoughPlastic(m) => m.diffuse_weight(wi),
            Model::Phong(m) => m.base.diffuse_weight(wi),
            Model::Ward(m) => m.base.diffuse_weight(wi),
            _ => Rgb::BLACK,
        }
    }

    /// `b(wo)` of the `DIFFUSE` lobe.
    pub(super) fn exit_transmittance(&self) -> ExitTransmittance<'s> {
        match self {
            Model::Plastic(m) => ExitTransmittance::Fresnel { eta: m.eta },
            Model::RoughPlastic(m) => ExitTransmittance::Coated(m.transmittance),
            _ => ExitTransmittance::Lambert,
        }
    }
}
