//! A dielectric coat over a Lambertian base, with all interreflections between the two.

use super::coat::{COSINES, Coat, CoatTables, interpolate};
use super::fresnel::{self, reflect};
use super::microfacet::Microfacets;
use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::lobes::{Classes, Lobes};
use crate::bsdf::material::ColorShift;
use crate::bsdf::model_sample::{ModelSample, Numbers};
use crate::bsdf::response::{ByClass, Response};
use crate::bsdf::scattering_model::{ModelBound, ScatteringModel};
use crate::lanes::{
    Color, Float, One, Vector, Width, cosine_hemisphere, cosine_hemisphere_pdf, in_lanes, lanewise,
};
use crate::math::Vec3;
use std::f32::consts::FRAC_1_PI;

/// The colors of coat and base, and the choice between both.
#[derive(Clone, Copy, Debug)]
struct Layers<S: Width> {
    /// Factor of the reflection at the coat.
    tint: Color<S>,
    /// Albedo of the base under the coat, without the transmittances of entry and exit: ρ / (η² (1
    /// - ρ r)), where r is the reflectance of the coat from inside for diffuse light.
    base: Color<S>,
    /// Albedo of the base with interreflections, without the transmittance of entry: the diffuse
    /// transmittance of exit is η² (1 - r).
    base_albedo: Float<S>,
    /// The tint's share of the sum of tint and `base_albedo`.
    coat_share: Float<S>,
}

in_lanes!(Layers {
    tint,
    base,
    base_albedo,
    coat_share
});

impl<S: Width> Layers<S> {
    /// `internal` is r.
    #[inline(always)]
    fn new(
        eta: f32,
        reflectance: Color<S>,
        tint: Color<S>,
        internal: f32,
        shift: ColorShift,
    ) -> Self {
        let trapped = match shift {
            ColorShift::Nonlinear => reflectance * internal,
            ColorShift::Linear => Color::grey(tint.r.same(internal)),
        };
        let base = reflectance.zip(trapped, |rho, t| rho / (eta * eta * (1.0 - t)));
        let base_albedo = base.max_channel() * (eta * eta * (1.0 - internal));
        let coat = tint.max_channel();
        let all = coat + base_albedo;
        Layers {
            tint,
            base,
            base_albedo,
            coat_share: all.gt(0.0).select(coat / all, 0.5),
        }
    }

    /// Albedo estimate of the classes `lobes` where the coat, of the classes `coat`, reflects the
    /// fraction `r`.
    #[inline(always)]
    fn albedo_estimate(&self, r: Float<S>, coat: Classes<S>, lobes: Classes<S>) -> Float<S> {
        let (of_coat, of_base) = (r * self.tint.max_channel(), (1.0 - r) * self.base_albedo);
        lobes.has(coat).select(of_coat, 0.0) + lobes.diffuse.select(of_base, 0.0)
    }

    /// Probability of sampling the coat, of the classes `coat`, instead of the base, where the coat
    /// reflects the fraction `r`.
    #[inline(always)]
    fn coat_probability(&self, r: Float<S>, coat: Classes<S>, lobes: Classes<S>) -> Float<S> {
        let (of_coat, of_base) = (r * self.coat_share, (1.0 - r) * (1.0 - self.coat_share));
        let all = of_coat + of_base;
        let beside_base = all.gt(0.0).select(of_coat / all, 1.0);
        let with_coat = lobes.diffuse.select(beside_base, 1.0);
        lobes.has(coat).select(with_coat, 0.0)
    }
}

/// A smooth coat over a Lambertian base.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct Plastic<S: Width> {
    pub eta: f32,
    layers: Layers<S>,
}

in_lanes!(Plastic { layers; eta });

impl<S: Width> Plastic<S> {
    #[inline(always)]
    pub(in crate::bsdf) fn new(
        eta: f32,
        reflectance: Color<S>,
        tint: Color<S>,
        shift: ColorShift,
    ) -> Self {
        let internal = fresnel::diffuse_reflectance(1.0 / eta);
        Plastic {
            eta,
            layers: Layers::new(eta, reflectance, tint, internal, shift),
        }
    }

    #[inline(always)]
    fn coat_class(&self, s: S) -> Classes<S> {
        Classes::splat(s, Lobes::DELTA)
    }

    /// Reflectance of the coat.
    #[inline(always)]
    fn reflectance(&self, cos: Float<S>) -> Float<S> {
        fresnel::dielectric(cos, cos.same(self.eta)).reflectance
    }

    #[inline(always)]
    fn coat_probability(&self, r: Float<S>, lobes: Classes<S>) -> Float<S> {
        self.layers
            .coat_probability(r, self.coat_class(r.width()), lobes)
    }
}

impl<S: Width> ScatteringModel<S> for Plastic<S> {
    #[inline(always)]
    fn lobes(&self) -> Classes<S> {
        Classes::splat(self.layers.tint.r.width(), Lobes::DIFFUSE.or(Lobes::DELTA))
    }

    #[inline(always)]
    fn albedo_estimate(&self, cos: Float<S>, lobes: Classes<S>) -> Float<S> {
        let r = self.reflectance(cos);
        let albedo = self
            .layers
            .albedo_estimate(r, self.coat_class(cos.width()), lobes);
        cos.gt(0.0).select(albedo, 0.0)
    }

    #[inline(always)]
    fn respond(&self, wi: Vector<S>, wo: Vector<S>, lobes: Classes<S>) -> Response<S> {
        let above = lobes.diffuse & wi.z.gt(0.0) & wo.z.gt(0.0);
        let leaves = self.reflectance(wo.z);
        let cosine = cosine_hemisphere_pdf(wi.z);
        let values = ByClass {
            diffuse: self.diffuse_weight(wi) * ((1.0 - leaves) * cosine),
            ..ByClass::black(cosine.width())
        };
        let pdf = (1.0 - self.coat_probability(leaves, lobes)) * cosine;
        Response { values, pdf }.within(above)
    }

    #[inline(always)]
    fn pdf(&self, given: Vector<S>, other: Vector<S>, lobes: Classes<S>) -> Float<S> {
        let above = lobes.diffuse & given.z.gt(0.0) & other.z.gt(0.0);
        let base = 1.0 - self.coat_probability(self.reflectance(given.z), lobes);
        above.select(base * cosine_hemisphere_pdf(other.z), 0.0)
    }

    #[inline(always)]
    fn sample(&self, given: Vector<S>, u: Numbers<S>, lobes: Classes<S>) -> ModelSample<S> {
        let above = given.z.gt(0.0);
        let r = self.reflectance(given.z);
        let probability = self.coat_probability(r, lobes);
        let coat = ModelSample::mirror(given, self.layers.tint * r, probability, above);
        let base = ModelSample::finite(cosine_hemisphere(u.direction), above);
        ModelSample::select(u.lobe.lt(probability), &coat, &base)
    }

    #[inline(always)]
    fn diffuse_weight(&self, wi: Vector<S>) -> Color<S> {
        (self.layers.base * fresnel::coat_transmittance(wi.z, self.eta)).within(wi.z.gt(0.0))
    }
}

impl<S: Width> Plastic<S> {
    /// The base times `weight`, if it is in `lobes`, for a local `wo` above the surface. The
    /// reflection at the coat is a delta lobe.
    #[inline(always)]
    pub(in crate::bsdf) fn with_wo(
        &self,
        wo: Vector<S>,
        lobes: Classes<S>,
        weight: Float<S>,
    ) -> PlasticToWo<S> {
        let exit = fresnel::coat_transmittance(wo.z, self.eta);
        let base = self.layers.base * (exit * weight * FRAC_1_PI);
        PlasticToWo {
            eta: wo.z.same(self.eta),
            inv_eta: wo.z.same(self.eta.recip()),
            base: base.within(lobes.diffuse),
        }
    }
}

/// The base of [`Plastic`] with a fixed `wo`.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct PlasticToWo<S: Width> {
    eta: Float<S>,
    inv_eta: Float<S>,
    /// The factor of the transmittance of entry and of the cosine.
    base: Color<S>,
}

lanewise!(PlasticToWo { eta, inv_eta, base });

impl<S: Width> PlasticToWo<S> {
    /// `f cosθ_i` at the cosine `cos` of `wi`.
    #[inline(always)]
    pub(in crate::bsdf) fn f_cos_wi(&self, cos: Float<S>) -> Color<S> {
        let cos = cos.max(0.0);
        self.base * (self.enters(cos) * cos)
    }

    /// Transmittance of entry at the cosine `cos` >= 0.
    #[inline(always)]
    fn enters(&self, cos: Float<S>) -> Float<S> {
        1.0 - fresnel::coat_reflectance(cos, self.eta, self.inv_eta)
    }
}

impl PlasticToWo<One> {
    /// Upper bound of all channels of [`PlasticToWo::f_cos_wi`] over a cone of `wi`.
    #[inline(always)]
    pub(in crate::bsdf) fn bound(&self, incident: &IncidentCone) -> f32 {
        let [_, cos] = incident.cosines();
        let enters = self.enters(cos.max(0.0).into()).get();
        self.base.max_channel().get() * (enters * incident.projection_above())
    }
}

impl ModelBound for Plastic<One> {
    #[inline]
    fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        if wo.z <= 0.0 {
            return 0.0;
        }
        self.with_wo(wo.into(), lobes.into(), 1.0.into())
            .bound(incident)
    }
}

/// A rough coat over a Lambertian base.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct RoughPlastic<'s, S: Width> {
    pub facets: Microfacets<S>,
    pub eta: f32,
    /// Transmittance of the coat from outside, over the cosine on [0, 1].
    pub transmittance: &'s [f32; COSINES],
    layers: Layers<S>,
}

in_lanes!(RoughPlastic<'s> { facets, layers; eta, transmittance });

impl<'s, S: Width> RoughPlastic<'s, S> {
    #[inline(always)]
    pub(in crate::bsdf) fn new(
        facets: Microfacets<S>,
        eta: f32,
        coat: &'s Coat,
        (reflectance, tint): (Color<S>, Color<S>),
        shift: ColorShift,
    ) -> Self {
        RoughPlastic {
            facets,
            eta,
            transmittance: &coat.transmittance,
            layers: Layers::new(eta, reflectance, tint, coat.internal_reflectance, shift),
        }
    }

    /// Probability of sampling the coat, for its transmittance in the given direction.
    #[inline(always)]
    fn coat_probability(&self, transmittance: Float<S>, lobes: Classes<S>) -> Float<S> {
        self.layers
            .coat_probability(1.0 - transmittance, self.facets.class(), lobes)
    }
}

impl<S: Width> ScatteringModel<S> for RoughPlastic<'_, S> {
    #[inline(always)]
    fn lobes(&self) -> Classes<S> {
        let coat = self.facets.class();
        coat.or(Classes::splat(coat.glossy.width(), Lobes::DIFFUSE))
    }

    #[inline(always)]
    fn albedo_estimate(&self, cos: Float<S>, lobes: Classes<S>) -> Float<S> {
        let r = 1.0 - interpolate(self.transmittance, cos);
        let albedo = self.layers.albedo_estimate(r, self.facets.class(), lobes);
        cos.gt(0.0).select(albedo, 0.0)
    }

    #[inline(always)]
    fn respond(&self, wi: Vector<S>, wo: Vector<S>, lobes: Classes<S>) -> Response<S> {
        let above = wi.z.gt(0.0) & wo.z.gt(0.0) & lobes.has(self.lobes());
        if above.none() {
            return Response::none(wi.z.width());
        }
        let leaves = interpolate(self.transmittance, wo.z);
        let coat = self.coat_probability(leaves, lobes);
        let m = (wi + wo).normalize();
        let cos = wo.dot(m);
        let f = fresnel::dielectric(cos, cos.same(self.eta)).reflectance;
        let density = self.facets.reflected_pdf(wo, m);
        let reflected = self.layers.tint * (f * density * self.facets.masking(wi, m));
        let cosine = cosine_hemisphere_pdf(wi.z);
        let base = self.diffuse_weight(wi) * (leaves * cosine);
        let values = ByClass {
            diffuse: base.within(lobes.diffuse),
            ..ByClass::of_microfacets(self.facets.class(), lobes, reflected)
        };
        // The probability of the coat is zero without its class, and one without that of the base.
        let pdf = coat * density + (1.0 - coat) * cosine;
        Response { values, pdf }.within(above)
    }

    #[inline(always)]
    fn pdf(&self, given: Vector<S>, other: Vector<S>, lobes: Classes<S>) -> Float<S> {
        let above = given.z.gt(0.0) & other.z.gt(0.0) & lobes.has(self.lobes());
        let coat = self.coat_probability(interpolate(self.transmittance, given.z), lobes);
        let density = self
            .facets
            .reflected_pdf(given, (given + other).normalize());
        let pdf = coat * density + (1.0 - coat) * cosine_hemisphere_pdf(other.z);
        above.select(pdf, 0.0)
    }

    #[inline(always)]
    fn sample(&self, given: Vector<S>, u: Numbers<S>, lobes: Classes<S>) -> ModelSample<S> {
        let above = given.z.gt(0.0);
        let transmittance = interpolate(self.transmittance, given.z);
        let of_coat = u.lobe.lt(self.coat_probability(transmittance, lobes));
        let mut w = cosine_hemisphere(u.direction);
        if of_coat.any() {
            let reflected = reflect(given, self.facets.sample(given, u.direction));
            w = Vector::select(of_coat, reflected, w);
        }
        ModelSample::finite(w, above & (w.z.gt(0.0) | !of_coat))
    }

    #[inline(always)]
    fn alpha(&self) -> Float<S> {
        self.facets.min_alpha()
    }

    #[inline(always)]
    fn diffuse_weight(&self, wi: Vector<S>) -> Color<S> {
        (self.layers.base * interpolate(self.transmittance, wi.z)).within(wi.z.gt(0.0))
    }
}

impl<'s, S: Width> RoughPlastic<'s, S> {
    /// The `lobes` times `weight`, for a local `wo` above the surface.
    #[inline(always)]
    pub(in crate::bsdf) fn with_wo(
        &self,
        wo: Vector<S>,
        lobes: Classes<S>,
        weight: Float<S>,
    ) -> RoughPlasticToWo<'s, S> {
        let exit = interpolate(self.transmittance, wo.z);
        let base = self.layers.base * (exit * weight * FRAC_1_PI);
        let specular = self.layers.tint * (self.facets.seen(wo) * weight);
        RoughPlasticToWo {
            facets: self.facets,
            eta: wo.z.same(self.eta),
            inv_eta: wo.z.same(self.eta.recip()),
            transmittance: CoatTables::same(wo.z.width(), self.transmittance),
            base: base.within(lobes.diffuse),
            specular: specular.within(lobes.has(self.facets.class())),
        }
    }
}

/// [`RoughPlastic`] with a fixed `wo`.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct RoughPlasticToWo<'s, S: Width> {
    facets: Microfacets<S>,
    eta: Float<S>,
    inv_eta: Float<S>,
    /// Transmittance of entry.
    transmittance: CoatTables<'s, S>,
    /// The factor of the transmittance of entry and of the cosine.
    base: Color<S>,
    /// The factor of `F D G1(wi)`.
    specular: Color<S>,
}

lanewise!(RoughPlasticToWo<'s> { facets, eta, inv_eta, transmittance, base, specular });

impl<S: Width> RoughPlasticToWo<'_, S> {
    /// `f cosθ_i` for local directions.
    #[inline(always)]
    pub(in crate::bsdf) fn f_cos_wi(&self, wi: Vector<S>, wo: Vector<S>) -> Color<S> {
        let at = self.facets.reflection(wi, wo);
        let f = fresnel::coat_reflectance(at.cos, self.eta, self.inv_eta);
        let reflected = self.specular * (f * at.density);
        // Tables of virtual lights have the glossy lobe alone.
        if self.base.is_black().all() {
            return reflected;
        }
        let cos = wi.z.max(0.0);
        self.base * (self.transmittance.interpolate(cos) * cos) + reflected
    }
}

impl RoughPlasticToWo<'_, One> {
    /// Upper bound of all channels of [`RoughPlasticToWo::f_cos_wi`] over a cone of `wi`.
    #[inline(always)]
    pub(in crate::bsdf) fn bound(&self, incident: &IncidentCone, wo: Vec3) -> f32 {
        let at = self.facets.reflection_bound(incident, wo);
        let f = fresnel::coat_reflectance(at.cosines[0].into(), self.eta, self.inv_eta).get();
        let enters = self.transmittance.largest().get();
        self.base.max_channel().get() * enters * incident.projection_above()
            + self.specular.max_channel().get() * (f * at.density)
    }
}

impl ModelBound for RoughPlastic<'_, One> {
    fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        if wo.z <= 0.0 {
            return 0.0;
        }
        self.with_wo(wo.into(), lobes.into(), 1.0.into())
            .bound(incident, wo)
    }
}
