//! What all scattering models have in common, and the choice among them.
//!
//! Models work in a local frame whose z axis is the normal. `eval` is `f(wi → wo) |cosθ_i|`, `bound` its upper bound over a cone of `wi`; sampling is from either end
//! (`given`), because drawing a half vector as seen from one direction is the same procedure in both walks.

use super::bound::Arriving;
use super::conductor::{Mirror, RoughConductor};
use super::dielectric::{Glass, RoughGlass};
use super::diffuse::Diffuse;
use super::phong::Phong;
use super::plastic::{Plastic, RoughPlastic};
use super::principled::Principled;
use super::response::{ByClass, Response};
use super::rough_diffuse::RoughDiffuse;
use super::thin_dielectric::Pane;
use super::ward::Ward;
use super::{BsdfNumbers, ExitTransmittance, Lobes, NEAR_DELTA_ALPHA};
use crate::color::Rgb;
use crate::math::Vec3;

/// A direction that a model drew.
#[derive(Clone, Copy, Debug)]
pub(super) struct ModelSample {
    /// The direction.
    pub w: Vec3,
    /// Index of refraction on the far side over that on the near side; 1 for reflection.
    pub eta: f32,
    /// Set for Dirac lobes.
    pub delta: Option<DeltaEvent>,
}

/// The choice of one Dirac lobe.
#[derive(Clone, Copy, Debug)]
pub(super) struct DeltaEvent {
    /// Fraction of flux that goes this way.
    pub fraction: Rgb,
    /// How likely the lobe was to be chosen.
    pub probability: f32,
}

impl ModelSample {
    /// A direction of a finite lobe.
    pub(super) fn finite(w: Vec3) -> Self {
        ModelSample {
            w,
            eta: 1.0,
            delta: None,
        }
    }

    /// Mirror reflection at the normal.
    pub(super) fn mirror(given: Vec3, fraction: Rgb, probability: f32) -> Self {
        let w = Vec3::new(-given.x, -given.y, given.z);
        ModelSample {
            w,
            eta: 1.0,
            delta: Some(DeltaEvent {
                fraction,
                probability,
            }),
        }
    }
}

/// The class of a microfacet lobe.
#[inline]
pub(super) fn microfacet_class(alpha: f32) -> Lobes {
    if alpha < NEAR_DELTA_ALPHA {
        Lobes::NEAR_DELTA
    } else {
        Lobes::GLOSSY
    }
}

/// A scattering model with its parameters at a point.
#[derive(Clone, Copy, Debug)]
pub(super) enum Model<'s> {
    Diffuse(Diffuse),
    RoughDiffuse(RoughDiffuse),
    Mirror(Mirror),
    RoughConductor(RoughConductor),
    Glass(Glass),
    RoughGlass(RoughGlass),
    Pane(Pane),
    Plastic(Plastic),
    RoughPlastic(RoughPlastic<'s>),
    Phong(Phong),
    Ward(Ward),
    Principled(Principled),
}

macro_rules! dispatch {
    ($model:expr, $m:ident => $call:expr) => {
        match $model {
            Model::Diffuse($m) => $call,
            Model::RoughDiffuse($m) => $call,
            Model::Mirror($m) => $call,
            Model::RoughConductor($m) => $call,
            Model::Glass($m) => $call,
            Model::RoughGlass($m) => $call,
            Model::Pane($m) => $call,
            Model::Plastic($m) => $call,
            Model::RoughPlastic($m) => $call,
            Model::Phong($m) => $call,
            Model::Ward($m) => $call,
            Model::Principled($m) => $call,
        }
    };
}

impl<'s> Model<'s> {
    /// The classes of the model's lobes.
    #[inline]
    pub(super) fn lobes(&self) -> Lobes {
        dispatch!(self, m => m.lobes())
    }

    /// Whether a finite lobe carries light to the other side.
    #[inline]
    pub(super) fn transmits(&self) -> bool {
        match self {
            Model::RoughGlass(_) => true,
            Model::Principled(m) => m.transmits(),
            _ => false,
        }
    }

    /// `f(wi → wo) |cosθ_i|` of the finite lobes in `lobes`.
    #[inline]
    pub(super) fn eval(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        dispatch!(self, m => m.eval(wi, wo, lobes))
    }

    /// Upper bound of every channel of [`Model::eval`] for light from a cone.
    #[inline]
    pub(super) fn bound(&self, arriving: &Arriving, wo: Vec3, lobes: Lobes) -> f32 {
        dispatch!(self, m => m.bound(arriving, wo, lobes))
    }

    /// Density at which [`Model::sample`] with the same `lobes` gives `other` from a finite lobe.
    #[inline]
    pub(super) fn pdf(&self, given: Vec3, other: Vec3, lobes: Lobes) -> f32 {
        dispatch!(self, m => m.pdf(given, other, lobes))
    }

    /// [`Model::eval`] class by class and [`Model::pdf`] given `wo`, where most models have much in common.
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

    /// Draws the other direction. `lobes` shares a class with the model's.
    #[inline]
    pub(super) fn sample(&self, given: Vec3, u: BsdfNumbers, lobes: Lobes) -> Option<ModelSample> {
        dispatch!(self, m => m.sample(given, u, lobes))
    }

    /// Roughness of the narrowest `GLOSSY` lobe; 1 without any, or where it is as wide as a hemisphere.
    pub(super) fn glossy_width(&self) -> f32 {
        let alpha = match self {
            Model::RoughConductor(m) => m.alpha(),
            Model::RoughGlass(m) => m.alpha(),
            Model::RoughPlastic(m) => m.alpha(),
            Model::Phong(m) => m.alpha(),
            Model::Ward(m) => m.alpha(),
            Model::Principled(m) => m.glossy_alpha(),
            _ => 1.0,
        };
        if alpha < NEAR_DELTA_ALPHA {
            1.0
        } else {
            alpha.min(1.0)
        }
    }

    /// `a(wi)` of the `DIFFUSE` lobe (`f = a(wi) b(wo) / π`).
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

    /// `b` of the `DIFFUSE` lobe.
    pub(super) fn exit(&self) -> ExitTransmittance<'s> {
        match self {
            Model::Plastic(m) => ExitTransmittance::Fresnel { eta: m.eta },
            Model::RoughPlastic(m) => ExitTransmittance::Coated(m.transmittance),
            _ => ExitTransmittance::Lambert,
        }
    }
}
