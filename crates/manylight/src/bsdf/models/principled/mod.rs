//! The Disney model, as Mitsuba 3's `principled`.
//!
//! Sources: Burley, "Physically Based Shading at Disney", 2012, and "Extending the Disney BRDF to a
//! BSDF with Integrated Subsurface Scattering", 2015. Where these leave a choice, it is Mitsuba
//! 3's.

mod film;
mod front;
mod layers;
mod sampling;
mod terms;
mod thin;

use film::Film;
pub(in crate::bsdf) use film::FilmParameters;
use front::PrincipledFront;
pub(in crate::bsdf) use front::PrincipledToWo;
pub(in crate::bsdf) use layers::LayerParameters;
use layers::Layers;
pub(in crate::bsdf) use thin::{PrincipledThin, PrincipledThinParameters};

use super::dielectric::{HalfVector, interface_bounds};
use super::fresnel;
use super::microfacet::Microfacets;
use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::lobes::{Classes, Lobes, NEAR_DELTA_ALPHA};
use crate::bsdf::material::{CoatReflection, Distribution};
use crate::bsdf::model_sample::{ModelSample, Numbers};
use crate::bsdf::response::{ByClass, Response};
use crate::bsdf::scattering_model::{ModelBound, ScatteringModel};
use crate::lanes::{Color, Float, Mask, One, Vector, Width, in_lanes};
use crate::math::{Vec3, float::safe_sqrt};
use std::f32::consts::{FRAC_1_PI, PI};

/// Smallest roughness alpha of the main interface, as in Mitsuba 3.
const MIN_ALPHA: f32 = 1e-3;
/// Roughness alpha of the clear coat for a gloss of 0 and of 1 (Burley 2012).
const CLEARCOAT_ALPHA: [f32; 2] = [0.1, 0.001];
/// Factor of the clear coat (Burley 2012).
pub(super) const CLEARCOAT_SCALE: f32 = 0.25;

/// Parameters at a point; names as in
/// [`PrincipledMaterial`](crate::bsdf::material::PrincipledMaterial).
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct PrincipledParameters<S: Width> {
    pub base_color: Color<S>,
    pub roughness: Float<S>,
    pub anisotropic: Float<S>,
    pub metallic: Float<S>,
    pub spec_trans: Float<S>,
    pub eta: f32,
    pub spec_tint: Float<S>,
    pub sheen: Float<S>,
    pub sheen_tint: Float<S>,
    pub flatness: Float<S>,
    pub clearcoat: Float<S>,
    pub clearcoat_gloss: Float<S>,
    pub layers: Option<LayerParameters<S>>,
    pub diffuse_rate: f32,
    pub specular_rate: f32,
    pub clearcoat_rate: f32,
}

/// The model at a point: a diffuse lobe with retro-reflection, an approximation of subsurface
/// scattering (`flatness`) and sheen; the main interface, a microfacet lobe between conductor and
/// dielectric; a clear coat.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct Principled<S: Width> {
    base_color: Color<S>,
    facets: Microfacets<S>,
    roughness: Float<S>,
    metallic: Float<S>,
    /// Weight of the opaque dielectric.
    brdf: Float<S>,
    /// Weight of the transparent dielectric.
    bsdf: Float<S>,
    eta: f32,
    spec_tint: Float<S>,
    /// The parameter times `1 - metallic`.
    sheen: Float<S>,
    sheen_tint: Float<S>,
    flatness: Float<S>,
    clearcoat: Float<S>,
    clearcoat_alpha: Float<S>,
    /// Normalization of the clear coat's distribution; see [`terms::gtr1`].
    clearcoat_norm: Float<S>,
    /// Whether the layers are those of glTF 2.0. Then `clearcoat` and `clearcoat_alpha` are those
    /// of their coat.
    layered: bool,
    coat_reflection: CoatReflection,
    /// [`LayerParameters::added`].
    tint: Color<S>,
    film: FilmParameters<S>,
    diffuse_rate: f32,
    specular_rate: f32,
    clearcoat_rate: f32,
}

in_lanes!(Principled {
    base_color,
    facets,
    roughness,
    metallic,
    brdf,
    bsdf,
    spec_tint,
    sheen,
    sheen_tint,
    flatness,
    clearcoat,
    clearcoat_alpha,
    clearcoat_norm,
    tint,
    film;
    eta,
    layered,
    coat_reflection,
    diffuse_rate,
    specular_rate,
    clearcoat_rate,
});

/// The facets of a Disney model, GGX with `alpha = roughness²` and an aspect ratio by
/// `anisotropic`.
#[inline(always)]
fn disney_facets<S: Width>(roughness: Float<S>, anisotropic: Float<S>) -> Microfacets<S> {
    let alpha = roughness * roughness;
    let aspect = (1.0 - 0.9 * anisotropic).sqrt();
    Microfacets::new(
        Distribution::Ggx,
        (alpha / aspect).max(MIN_ALPHA),
        (alpha * aspect).max(MIN_ALPHA),
    )
}

/// A color over its luminance; white for black.
#[inline(always)]
fn luminance_tint<S: Width>(color: Color<S>) -> Color<S> {
    let luminance = color.luminance();
    let is_lit = luminance.gt(0.0);
    (color / luminance).map(|v| is_lit.select(v, 1.0))
}

/// Smallest of the roughnesses alpha that belong to `GLOSSY` lobes; 1 without such lobes.
#[inline(always)]
fn least_glossy<S: Width, const N: usize>(alphas: [Float<S>; N]) -> Float<S> {
    let one = alphas[0].same(1.0);
    alphas.into_iter().fold(one, |least, alpha| {
        alpha.ge(NEAR_DELTA_ALPHA).select(least.min(alpha), least)
    })
}

impl<S: Width> Principled<S> {
    #[inline(always)]
    pub(in crate::bsdf) fn new(p: PrincipledParameters<S>) -> Self {
        let zero = p.clearcoat.same(0.0);
        let [dull, glossy] = CLEARCOAT_ALPHA;
        let (tint, clearcoat, clearcoat_alpha) = match &p.layers {
            Some(layers) => (layers.added(p.eta), layers.coat, layers.coat_alpha()),
            None => {
                let alpha = dull + (glossy - dull) * p.clearcoat_gloss;
                (Color::grey(zero), p.clearcoat, alpha)
            }
        };
        let (diffuse, coat_reflection) = match &p.layers {
            Some(layers) => (layers.diffuse, layers.coat_reflection),
            None => (zero.same(1.0), CoatReflection::Here),
        };
        let film = p.layers.as_ref().and_then(|layers| layers.film);
        let a2 = clearcoat_alpha * clearcoat_alpha;
        let layered = p.layers.is_some();
        let clearcoat_norm = match layered {
            true => zero,
            false => (a2 - 1.0) / (PI * a2.ln()),
        };
        Principled {
            base_color: p.base_color,
            facets: disney_facets(p.roughness, p.anisotropic),
            roughness: p.roughness,
            metallic: p.metallic,
            brdf: (1.0 - p.metallic) * (1.0 - p.spec_trans) * diffuse,
            bsdf: (1.0 - p.metallic) * p.spec_trans,
            eta: p.eta,
            spec_tint: p.spec_tint,
            sheen: p.sheen * (1.0 - p.metallic),
            sheen_tint: p.sheen_tint,
            flatness: p.flatness,
            clearcoat,
            clearcoat_alpha,
            clearcoat_norm,
            layered,
            coat_reflection,
            tint,
            film: film.unwrap_or(FilmParameters::none(zero.width())),
            diffuse_rate: p.diffuse_rate,
            specular_rate: p.specular_rate,
            clearcoat_rate: p.clearcoat_rate,
        }
    }

    #[inline(always)]
    fn specular_class(&self) -> Classes<S> {
        self.facets.class()
    }

    #[inline(always)]
    fn clearcoat_class(&self) -> Classes<S> {
        Classes::of_microfacets(self.clearcoat_alpha)
    }

    /// The weight with which the clear coat reflects.
    #[inline(always)]
    fn clearcoat_reflecting(&self) -> Float<S> {
        match self.coat_reflection {
            CoatReflection::Here => self.clearcoat,
            CoatReflection::Apart => self.clearcoat.same(0.0),
        }
    }

    /// Reflection on the front by class.
    #[inline(always)]
    fn front_values(&self, wi: Vector<S>, wo: Vector<S>, lobes: Classes<S>) -> ByClass<S> {
        let (front, seen) = (self.front(lobes), self.facets.seen(wo));
        let has_extras = front.has_extras().any();
        let parts = if has_extras {
            front.parts::<true>(&self.facets, wi, wo, seen)
        } else {
            front.parts::<false>(&self.facets, wi, wo, seen)
        };
        // The weights of `front` contain the requested classes.
        let one = wi.z.same(1.0);
        let mut values = ByClass::of_microfacets(self.specular_class(), lobes, parts.interface);
        values.glossy += parts.diffuse;
        if has_extras {
            let clearcoat = Color::grey(parts.clearcoat);
            values.add(
                &ByClass::of_microfacets(self.clearcoat_class(), lobes, clearcoat),
                one,
            );
            let coat = Color::grey(parts.coat);
            values.add(
                &ByClass::of_microfacets(self.clearcoat_class(), lobes, coat),
                one,
            );
        }
        values
    }

    /// Reflection by `lobes` on the front.
    #[inline(always)]
    pub(in crate::bsdf) fn front(&self, lobes: Classes<S>) -> PrincipledFront<S> {
        let weight = |requested: Mask<S>| requested.select(1.0, 0.0);
        let interface = weight(lobes.has(self.specular_class()));
        let diffuse = weight(lobes.glossy);
        let tinted = (1.0 - self.metallic) * self.spec_tint;
        let r0 = ((self.eta - 1.0) / (self.eta + 1.0)).powi(2);
        let tint = luminance_tint(self.base_color);
        let schlick_r0 = self.base_color * self.metallic + tint * (r0 * tinted);
        let sheen = tint.map(|v| (1.0 - self.sheen_tint) + v * self.sheen_tint);
        let layers = self.layers();
        let bare = interface * layers.film.bare();
        let plain = (1.0 - self.metallic) * (1.0 - self.spec_tint) * bare;
        PrincipledFront {
            eta: interface.same(self.eta),
            inv_eta: interface.same(self.eta.recip()),
            plain,
            schlick: (self.metallic + tinted) * bare,
            schlick_r0: schlick_r0 * bare,
            base: self.base_color
                * (self.brdf * FRAC_1_PI * diffuse * (1.0 - self.tint.max_channel())),
            sheen: sheen * (self.sheen * diffuse),
            roughness: self.roughness,
            flatness: self.flatness,
            clearcoat: match self.layered {
                true => interface.same(0.0),
                false => {
                    self.clearcoat * CLEARCOAT_SCALE * weight(lobes.has(self.clearcoat_class()))
                }
            },
            clearcoat_excess: self.clearcoat_excess(),
            clearcoat_norm: self.clearcoat_norm,
            layers: layers.requested(interface, plain, lobes),
        }
    }

    /// Reflection by `lobes` times `weight`, for a local `wo` above the surface.
    #[inline(always)]
    pub(in crate::bsdf) fn with_wo(
        &self,
        wo: Vector<S>,
        lobes: Classes<S>,
        weight: Float<S>,
    ) -> PrincipledToWo<S> {
        self.front(lobes).with_wo(self.facets, wo, weight)
    }

    /// The layers of glTF 2.0, if there are any.
    #[inline(always)]
    fn layers(&self) -> Layers<S> {
        match self.layered {
            true => Layers::new(
                self.tint,
                self.clearcoat,
                self.clearcoat_reflecting(),
                self.clearcoat_alpha,
                Film::new(self.film, self.normal_reflectance()),
            ),
            false => Layers::none(self.clearcoat.width()),
        }
    }

    /// Reflectance at normal incidence: that of the tinted dielectric, or of the metal.
    #[inline(always)]
    fn normal_reflectance(&self) -> Color<S> {
        let r0 = ((self.eta - 1.0) / (self.eta + 1.0)).powi(2);
        let dielectric = self.tint.map(|added| r0 + (1.0 - r0) * added);
        dielectric.lerp(self.base_color, self.metallic)
    }

    /// See [`terms::gtr1`].
    #[inline(always)]
    fn clearcoat_excess(&self) -> Float<S> {
        self.clearcoat_alpha * self.clearcoat_alpha - 1.0
    }

    /// The transparent dielectric: transmission, and reflection on the back.
    #[inline(always)]
    fn interface(&self, wi: Vector<S>, wo: Vector<S>, half: &HalfVector<S>) -> Color<S> {
        let m = half.m;
        let (i, o) = (wi.dot(m), wo.dot(m));
        let r = fresnel::dielectric(o, o.same(self.eta)).reflectance;
        let masking = self.facets.masking(wi, m) * self.facets.masking(wo, m);
        let common = self.bsdf * self.facets.density(m) * masking / wo.z.abs();
        let reflected = 0.25 * common * r;
        let scale = (1.0 - r) * common * (i * o).abs() / (o + half.eta * i).squared();
        let transmitted = self.base_color.map(Float::safe_sqrt) * scale;
        Color::select(half.reflects, Color::grey(reflected), transmitted)
    }
}

impl<S: Width> ScatteringModel<S> for Principled<S> {
    #[inline(always)]
    fn lobes(&self) -> Classes<S> {
        let has_diffuse = self.brdf.gt(0.0) | self.sheen.gt(0.0);
        let glossy = Classes::splat(has_diffuse.width(), Lobes::GLOSSY);
        self.specular_class().or(glossy.within(has_diffuse)).or(self
            .clearcoat_class()
            .within(self.clearcoat_reflecting().gt(0.0)))
    }

    #[inline(always)]
    fn albedo_estimate(&self, cos: Float<S>, lobes: Classes<S>) -> Float<S> {
        self.strategies(cos, lobes).total()
    }

    #[inline(always)]
    fn respond(&self, wi: Vector<S>, wo: Vector<S>, lobes: Classes<S>) -> Response<S> {
        let half = HalfVector::new(wo, wi, self.eta);
        if half.valid.none() {
            return Response::none(wi.z.width());
        }
        let on_front = half.valid & half.reflects & wo.z.gt(0.0);
        let mut values = self.front_values(wi, wo, lobes).map(|v| v.within(on_front));
        let through = half.valid & !on_front & self.transmits();
        if through.any() {
            let value = self.interface(wi, wo, &half).within(through);
            let one = wi.z.same(1.0);
            let interface = ByClass::of_microfacets(self.specular_class(), lobes, value);
            values.add(&interface, one);
        }
        Response {
            values,
            pdf: half.valid.select(self.pdf_by(&half, wo, wi, lobes), 0.0),
        }
    }

    #[inline(always)]
    fn pdf(&self, given: Vector<S>, other: Vector<S>, lobes: Classes<S>) -> Float<S> {
        let half = HalfVector::new(given, other, self.eta);
        half.valid
            .select(self.pdf_by(&half, given, other, lobes), 0.0)
    }

    #[inline(always)]
    fn sample(&self, given: Vector<S>, u: Numbers<S>, lobes: Classes<S>) -> ModelSample<S> {
        self.sample_by(&self.strategies(given.z, lobes), given, u)
    }

    #[inline(always)]
    fn transmits(&self) -> Mask<S> {
        self.bsdf.gt(0.0)
    }

    #[inline(always)]
    fn alpha(&self) -> Float<S> {
        let reflects = self.clearcoat_reflecting().gt(0.0);
        let clearcoat = reflects.select(self.clearcoat_alpha, 1.0);
        least_glossy([self.facets.min_alpha(), clearcoat])
    }
}

impl ModelBound for Principled<One> {
    fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        if wo.z == 0.0 {
            return 0.0;
        }
        let mut bound = 0.0;
        if wo.z > 0.0 {
            bound += self
                .with_wo(wo.into(), lobes.into(), 1.0.into())
                .bound(incident, wo);
        }
        if self.transmits().any() && lobes.has(self.specular_class().get()) {
            let [reflected, transmitted] = interface_bounds(&self.facets, self.eta, incident, wo);
            let bsdf = self.bsdf.get();
            if wo.z < 0.0 {
                bound += bsdf * reflected;
            }
            bound += bsdf * safe_sqrt(self.base_color.max_channel().get()) * transmitted;
        }
        bound
    }
}
