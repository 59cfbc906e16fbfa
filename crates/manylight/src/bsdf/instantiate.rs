//! From the parameters of a material to a scattering model at a point.

use super::material::{
    BelowInterface, ColorShift, ConstantRoughness, Material, OrenNayarVariant, PrincipledMaterial,
    PrincipledThinMaterial, Roughness,
};
use super::materials::Materials;
use super::model::Model;
use super::models::coat::Coat;
use super::models::conductor::{RoughConductor, SmoothConductor};
use super::models::dielectric::{InterfaceTints, RoughDielectric, SmoothDielectric};
use super::models::diffuse::Diffuse;
use super::models::diffuse_transmitter::DiffuseTransmitter;
use super::models::fresnel::ConductorFresnel;
use super::models::microfacet::Microfacets;
use super::models::phong::Phong;
use super::models::plastic::{Plastic, RoughPlastic};
use super::models::principled::{
    FilmParameters, LayerParameters, Principled, PrincipledParameters, PrincipledThin,
    PrincipledThinParameters,
};
use super::models::rough_diffuse::RoughDiffuse;
use super::models::substrate::Substrate;
use super::models::thin_dielectric::{RoughThinDielectric, ThinDielectric};
use super::models::ward::Ward;
use crate::geometry::SurfacePoints;
use crate::ids::MaterialId;
use crate::lanes::{Color, Float, Pair, Width};
use crate::texture::{ColorInput, FloatInput, Texture};

/// Evaluates the parameters of materials at a point in each lane.
#[derive(Clone, Copy)]
pub(super) struct ModelInstantiation<'a, 's, S: Width> {
    pub(super) materials: &'s Materials,
    pub(super) x: &'a SurfacePoints<S>,
    pub(super) textures: &'s [Texture],
}

impl<'s, S: Width> ModelInstantiation<'_, 's, S> {
    #[inline(always)]
    fn color(&self, input: &ColorInput) -> Color<S> {
        input.eval_each(self.x, self.textures)
    }

    #[inline(always)]
    pub(super) fn float(&self, input: &FloatInput) -> Float<S> {
        input.eval_each(self.x, self.textures)
    }

    #[inline(always)]
    fn microfacets(&self, r: &Roughness) -> Microfacets<S> {
        Microfacets::new(
            r.distribution,
            self.float(&r.alpha_u),
            self.float(&r.alpha_v),
        )
    }

    /// The model of a material that is no wrapper.
    #[inline(always)]
    pub(super) fn model(&self, id: MaterialId, material: &Material) -> Model<'s, S> {
        match material {
            Material::Diffuse { reflectance } => Model::Diffuse(Diffuse {
                reflectance: self.color(reflectance),
            }),
            Material::RoughDiffuse {
                reflectance,
                alpha,
                variant,
            } => self.rough_diffuse(reflectance, alpha, *variant),
            Material::DiffuseTransmitter {
                transmittance,
                below,
            } => self.diffuse_transmitter(transmittance, below.as_ref()),
            Material::Conductor {
                eta,
                k,
                specular_reflectance,
                roughness,
            } => self.conductor(eta, k, specular_reflectance, roughness.as_ref()),
            Material::Dielectric {
                eta,
                specular_reflectance: reflection,
                specular_transmittance: transmission,
                roughness,
            } => self.dielectric(*eta, reflection, transmission, roughness.as_ref()),
            Material::ThinDielectric {
                eta,
                specular_reflectance: reflection,
                specular_transmittance: transmission,
                roughness,
            } => self.thin_dielectric(*eta, reflection, transmission, roughness.as_ref()),
            Material::Plastic {
                eta,
                diffuse_reflectance: base,
                specular_reflectance: tint,
                color_shift,
                roughness,
            } => {
                let colors = (self.color(base), self.color(tint));
                let rough = roughness.as_ref().zip(self.coat(id));
                self.plastic(*eta, colors, *color_shift, rough)
            }
            Material::Phong {
                diffuse_reflectance,
                specular_reflectance,
                exponent,
            } => self.phong(diffuse_reflectance, specular_reflectance, exponent),
            Material::Ward {
                variant,
                diffuse_reflectance,
                specular_reflectance,
                alpha_u,
                alpha_v,
            } => Model::Ward(Ward::new(
                *variant,
                self.color(diffuse_reflectance),
                self.color(specular_reflectance),
                Pair::new(self.float(alpha_u), self.float(alpha_v)),
            )),
            Material::Substrate {
                diffuse_reflectance,
                specular_reflectance,
                roughness,
            } => self.substrate(diffuse_reflectance, specular_reflectance, roughness),
            Material::Principled(p) => Model::Principled(self.principled(p)),
            Material::PrincipledThin(p) => Model::PrincipledThin(self.principled_thin(p)),
            Material::Blend { .. }
            | Material::Sum { .. }
            | Material::Mask { .. }
            | Material::Null
            | Material::TwoSided { .. }
            | Material::BumpMap { .. }
            | Material::NormalMap { .. } => {
                unreachable!("invariant: wrappers are flattened first")
            }
        }
    }

    #[inline(always)]
    fn rough_diffuse(
        &self,
        reflectance: &ColorInput,
        alpha: &FloatInput,
        variant: OrenNayarVariant,
    ) -> Model<'s, S> {
        let (reflectance, alpha) = (self.color(reflectance), self.float(alpha));
        if alpha.equals(0.0).all() {
            return Model::Diffuse(Diffuse { reflectance });
        }
        Model::RoughDiffuse(RoughDiffuse::new(reflectance, alpha, variant))
    }

    #[inline(always)]
    fn diffuse_transmitter(
        &self,
        transmittance: &ColorInput,
        below: Option<&BelowInterface>,
    ) -> Model<'s, S> {
        let none = DiffuseTransmitter::plain(self.color(transmittance));
        Model::DiffuseTransmitter(match below {
            None => none,
            Some(below) => DiffuseTransmitter {
                eta: below.eta,
                coat: self.float(&below.coat),
                ..none
            },
        })
    }

    #[inline(always)]
    fn conductor(
        &self,
        eta: &ColorInput,
        k: &ColorInput,
        tint: &ColorInput,
        roughness: Option<&Roughness>,
    ) -> Model<'s, S> {
        let fresnel = ConductorFresnel::new(self.color(eta), self.color(k));
        let tint = self.color(tint);
        match roughness {
            None => Model::SmoothConductor(SmoothConductor { fresnel, tint }),
            Some(r) => Model::RoughConductor(RoughConductor {
                facets: self.microfacets(r),
                fresnel,
                tint,
            }),
        }
    }

    #[inline(always)]
    fn interface_tints(
        &self,
        reflection: &ColorInput,
        transmission: &ColorInput,
    ) -> InterfaceTints<S> {
        InterfaceTints {
            reflection: self.color(reflection),
            transmission: self.color(transmission),
        }
    }

    #[inline(always)]
    fn dielectric(
        &self,
        eta: f32,
        reflection: &ColorInput,
        transmission: &ColorInput,
        roughness: Option<&Roughness>,
    ) -> Model<'s, S> {
        let tints = self.interface_tints(reflection, transmission);
        match roughness {
            None => Model::SmoothDielectric(SmoothDielectric { eta, tints }),
            Some(r) => {
                let facets = self.microfacets(r);
                Model::RoughDielectric(RoughDielectric { facets, eta, tints })
            }
        }
    }

    #[inline(always)]
    fn thin_dielectric(
        &self,
        eta: f32,
        reflection: &ColorInput,
        transmission: &ColorInput,
        roughness: Option<&Roughness>,
    ) -> Model<'s, S> {
        let tints = self.interface_tints(reflection, transmission);
        match roughness {
            None => Model::ThinDielectric(ThinDielectric { eta, tints }),
            Some(r) => {
                let facets = self.microfacets(r);
                Model::RoughThinDielectric(RoughThinDielectric { facets, eta, tints })
            }
        }
    }

    /// The tables of the coat of a material, if that is rough.
    #[inline(always)]
    fn coat(&self, id: MaterialId) -> Option<&'s Coat> {
        self.materials.coat_of[id.index()].map(|coat| &self.materials.coats[coat])
    }

    /// `rough` is the roughness of the coat with its tables; `None`: smooth.
    #[inline(always)]
    fn plastic(
        &self,
        eta: f32,
        (base, tint): (Color<S>, Color<S>),
        shift: ColorShift,
        rough: Option<(&ConstantRoughness, &'s Coat)>,
    ) -> Model<'s, S> {
        match rough {
            None => Model::Plastic(Plastic::new(eta, base, tint, shift)),
            Some((roughness, coat)) => {
                let alpha = Float::splat(self.x.offset.width(), roughness.alpha);
                let facets = Microfacets::new(roughness.distribution, alpha, alpha);
                Model::RoughPlastic(RoughPlastic::new(facets, eta, coat, (base, tint), shift))
            }
        }
    }

    #[inline(always)]
    fn phong(
        &self,
        diffuse_reflectance: &ColorInput,
        specular_reflectance: &ColorInput,
        exponent: &FloatInput,
    ) -> Model<'s, S> {
        Model::Phong(Phong::new(
            self.color(diffuse_reflectance),
            self.color(specular_reflectance),
            self.float(exponent),
        ))
    }

    #[inline(always)]
    fn substrate(
        &self,
        diffuse_reflectance: &ColorInput,
        specular_reflectance: &ColorInput,
        roughness: &Roughness,
    ) -> Model<'s, S> {
        Model::Substrate(Substrate::new(
            self.color(diffuse_reflectance),
            self.color(specular_reflectance),
            self.microfacets(roughness),
        ))
    }

    #[inline(always)]
    fn principled_thin(&self, p: &PrincipledThinMaterial) -> PrincipledThin<S> {
        PrincipledThin::new(PrincipledThinParameters {
            base_color: self.color(&p.base_color),
            roughness: self.float(&p.roughness),
            anisotropic: self.float(&p.anisotropic),
            spec_trans: self.float(&p.spec_trans),
            eta: self.float(&p.eta),
            spec_tint: self.float(&p.spec_tint),
            sheen: self.float(&p.sheen),
            sheen_tint: self.float(&p.sheen_tint),
            flatness: self.float(&p.flatness),
            diff_trans: self.float(&p.diff_trans),
        })
    }

    #[inline(always)]
    fn principled(&self, p: &PrincipledMaterial) -> Principled<S> {
        let layers = p.layers.as_ref().map(|layers| LayerParameters {
            specular_tint: self.color(&layers.specular_tint),
            coat: self.float(&p.clearcoat),
            coat_roughness: self.float(&layers.coat_roughness),
            coat_reflection: layers.coat_reflection,
            diffuse: self.float(&layers.diffuse),
            film: layers.film.as_ref().map(|film| FilmParameters {
                weight: self.float(&film.weight).clamp(0.0, 1.0),
                eta: Float::splat(self.x.offset.width(), film.eta),
                thickness: self.float(&film.thickness),
            }),
        });
        Principled::new(PrincipledParameters {
            base_color: self.color(&p.base_color),
            roughness: self.float(&p.roughness),
            anisotropic: self.float(&p.anisotropic),
            metallic: self.float(&p.metallic),
            spec_trans: self.float(&p.spec_trans),
            eta: p.eta,
            spec_tint: self.float(&p.spec_tint),
            sheen: self.float(&p.sheen),
            sheen_tint: self.float(&p.sheen_tint),
            flatness: self.float(&p.flatness),
            clearcoat: self.float(&p.clearcoat),
            clearcoat_gloss: self.float(&p.clearcoat_gloss),
            layers,
            diffuse_rate: p.diffuse_reflectance_sampling_rate,
            specular_rate: p.main_specular_sampling_rate,
            clearcoat_rate: p.clearcoat_sampling_rate,
        })
    }
}
