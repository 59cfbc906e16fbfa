//! A scattering model with its parameters at a point, and dispatch among all models.

use super::ExitTransmittance;
use super::incident_cone::IncidentCone;
use super::lobes::{Classes, Lobes, NEAR_DELTA_ALPHA};
use super::model_sample::{ModelSample, Numbers};
use super::models::*;
use super::response::Response;
use super::scattering_model::{self, ModelBound, ScatteringModel};
use crate::lanes::{Color, Float, Mask, One, Vector, Width};
use crate::math::Vec3;

/// Defines [`Model`] by the list of all models, and calls the functions of the one that it holds.
macro_rules! models {
    ($($name:ident($model:ty),)*) => {
        /// A scattering model with its parameters at a point.
        #[derive(Clone, Copy, Debug)]
        pub(super) enum Model<'s, S: Width> {
            $($name($model),)*
        }

        impl<S: Width> ScatteringModel<S> for Model<'_, S> {
            #[inline(always)]
            fn lobes(&self) -> Classes<S> {
                match self {
                    $(Model::$name(model) => model.lobes(),)*
                }
            }

            #[inline(always)]
            fn albedo_estimate(&self, cos: Float<S>, lobes: Classes<S>) -> Float<S> {
                match self {
                    $(Model::$name(model) => scattering_model::albedo_estimate(model, cos, lobes),)*
                }
            }

            #[inline(always)]
            fn respond(&self, wi: Vector<S>, wo: Vector<S>, lobes: Classes<S>) -> Response<S> {
                match self {
                    $(Model::$name(model) => scattering_model::respond(model, wi, wo, lobes),)*
                }
            }

            #[inline(always)]
            fn pdf(&self, given: Vector<S>, other: Vector<S>, lobes: Classes<S>) -> Float<S> {
                match self {
                    $(Model::$name(model) => scattering_model::pdf(model, given, other, lobes),)*
                }
            }

            #[inline(always)]
            fn sample(&self, given: Vector<S>, u: Numbers<S>, lobes: Classes<S>) -> ModelSample<S> {
                match self {
                    $(Model::$name(model) => scattering_model::sample(model, given, u, lobes),)*
                }
            }

            #[inline(always)]
            fn transmits(&self) -> Mask<S> {
                match self {
                    $(Model::$name(model) => model.transmits(),)*
                }
            }

            #[inline(always)]
            fn alpha(&self) -> Float<S> {
                match self {
                    $(Model::$name(model) => model.alpha(),)*
                }
            }

            #[inline(always)]
            fn diffuse_weight(&self, wi: Vector<S>) -> Color<S> {
                match self {
                    $(Model::$name(model) => model.diffuse_weight(wi),)*
                }
            }
        }

        impl<'s> Model<'s, One> {
            /// The model in all lanes.
            #[inline(always)]
            pub(super) fn in_lanes<S: Width>(&self, s: S) -> Model<'s, S> {
                match self {
                    $(Model::$name(model) => Model::$name(model.in_lanes(s)),)*
                }
            }
        }

        impl ModelBound for Model<'_, One> {
            #[inline]
            fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
                match self {
                    $(Model::$name(model) => model.bound(incident, wo, lobes),)*
                }
            }
        }
    };
}

models! {
    Diffuse(diffuse::Diffuse<S>),
    RoughDiffuse(rough_diffuse::RoughDiffuse<S>),
    DiffuseTransmitter(diffuse_transmitter::DiffuseTransmitter<S>),
    SmoothConductor(conductor::SmoothConductor<S>),
    RoughConductor(conductor::RoughConductor<S>),
    SmoothDielectric(dielectric::SmoothDielectric<S>),
    RoughDielectric(dielectric::RoughDielectric<S>),
    ThinDielectric(thin_dielectric::ThinDielectric<S>),
    RoughThinDielectric(thin_dielectric::RoughThinDielectric<S>),
    Plastic(plastic::Plastic<S>),
    RoughPlastic(plastic::RoughPlastic<'s, S>),
    Phong(phong::Phong<S>),
    Ward(ward::Ward<S>),
    Substrate(substrate::Substrate<S>),
    Principled(principled::Principled<S>),
    PrincipledThin(principled::PrincipledThin<S>),
}

impl<'s, S: Width> Model<'s, S> {
    /// Smallest roughness alpha of the `GLOSSY` lobes, at most 1; 1 without such lobes.
    #[inline(always)]
    pub(super) fn glossy_roughness(&self) -> Float<S> {
        let alpha = self.alpha();
        alpha.lt(NEAR_DELTA_ALPHA).select(1.0, alpha.min(1.0))
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
