//! Sampling of the principled model.

use super::Principled;
use super::terms::gtr1;
use crate::bsdf::lobes::{Classes, Lobes};
use crate::bsdf::model_sample::{ModelSample, Numbers};
use crate::bsdf::models::dielectric::{HalfVector, facet_sample};
use crate::bsdf::models::fresnel::{self, reflect};
use crate::bsdf::scattering_model::ScatteringModel;
use crate::lanes::{Float, Mask, Pair, Vector, Width, cosine_hemisphere, cosine_hemisphere_pdf};
use std::f32::consts::PI;

/// Albedo of sheen at weight 1 near the horizon, where it shows. By numerical integration it is
/// 0.0003 at the normal, 0.016 at 60° and 0.066 at 84°.
pub(super) const SHEEN_ALBEDO: f32 = 0.05;

/// Lower bound of Schlick's term where the reflectance of rough surfaces is estimated at the
/// surface normal: facets reflect at other angles.
pub(super) const MIN_SCHLICK: f32 = 0.02;

/// Unnormalized probabilities of the sampling strategies.
pub(super) struct Strategies<S: Width> {
    diffuse: Float<S>,
    clearcoat: Float<S>,
    specular: Float<S>,
}

impl<S: Width> Strategies<S> {
    #[inline(always)]
    pub(super) fn total(&self) -> Float<S> {
        self.diffuse + self.clearcoat + self.specular
    }
}

impl<S: Width> Principled<S> {
    /// Probabilities for a given direction of this cosine: estimates of the light that each lobe
    /// returns, times the rate of the material. From below, only the main interface is sampled.
    #[inline(always)]
    pub(super) fn strategies(&self, cos: Float<S>, lobes: Classes<S>) -> Strategies<S> {
        let front = self.front(Classes::splat(cos.width(), Lobes::FINITE));
        let diffuse = PI * front.base.max_channel() + SHEEN_ALBEDO * front.sheen.max_channel();
        let specular =
            front.interface_reflectance(cos, MIN_SCHLICK).max_channel() + self.transmitted(cos);
        let of_specular = lobes.has(self.specular_class());
        let of_clearcoat = lobes.has(self.clearcoat_class());
        let (mut diffuse, mut specular) = (diffuse, specular);
        let mut coat = front.clearcoat_reflectance(cos);
        if self.layered {
            let layers = self.layers();
            let passing = layers.passing(cos);
            (diffuse, specular) = (diffuse * passing, specular * passing);
            coat = layers.coat_reflectance(cos);
        }
        let mut chosen = Strategies {
            diffuse: lobes.glossy.select(diffuse * self.diffuse_rate, 0.0),
            clearcoat: of_clearcoat.select(coat * self.clearcoat_rate, 0.0),
            specular: of_specular.select(specular * self.specular_rate, 0.0),
        };
        // Without a positive probability by these rates, lobes of the requested classes must be
        // reachable nevertheless.
        let unreachable = chosen.total().equals(0.0);
        let fallback = |of: Mask<S>, value: Float<S>, chosen: Float<S>| {
            unreachable.select(of.select(value, 0.0), chosen)
        };
        let one = cos.same(1.0);
        chosen.diffuse = fallback(lobes.glossy, one, chosen.diffuse);
        chosen.clearcoat = fallback(of_clearcoat, self.clearcoat_reflecting(), chosen.clearcoat);
        chosen.specular = fallback(of_specular, one, chosen.specular);
        let below = cos.lt(0.0);
        let transparent = (of_specular & self.transmits()).select(1.0, 0.0);
        Strategies {
            diffuse: below.select(0.0, chosen.diffuse),
            clearcoat: below.select(0.0, chosen.clearcoat),
            specular: below.select(transparent, chosen.specular),
        }
    }

    /// Fraction of light that the main interface transmits at the cosine `cos`: the largest
    /// channel.
    #[inline(always)]
    fn transmitted(&self, cos: Float<S>) -> Float<S> {
        let r = fresnel::dielectric(cos, cos.same(self.eta)).reflectance;
        self.bsdf * (1.0 - r) * self.base_color.max_channel().safe_sqrt()
    }

    /// Probability of transmission at a facet of the main interface with normal `m`, in proportion
    /// to the light that the facet returns.
    #[inline(always)]
    fn transmission_probability(&self, given: Vector<S>, m: Vector<S>) -> Float<S> {
        if self.transmits().none() {
            return given.z.same(0.0);
        }
        let cos = given.dot(m);
        let transmitted = self.transmitted(cos);
        let front = self.front(Classes::splat(cos.width(), Lobes::FINITE));
        let on_front = front.interface_reflectance(cos, 0.0).max_channel();
        let r = fresnel::dielectric(cos, cos.same(self.eta)).reflectance;
        let reflected = given.z.gt(0.0).select(on_front, self.bsdf * r);
        let probability = transmitted / (transmitted + reflected);
        transmitted.equals(0.0).select(0.0, probability)
    }

    /// The density for two directions with this half vector.
    #[inline(always)]
    pub(super) fn pdf_by(
        &self,
        half: &HalfVector<S>,
        given: Vector<S>,
        other: Vector<S>,
        lobes: Classes<S>,
    ) -> Float<S> {
        let strategies = self.strategies(given.z, lobes);
        let total = strategies.total();
        let m = half.m;
        let transmission = self.transmission_probability(given, m);
        let choice = half.reflects.select(1.0 - transmission, transmission);
        let specular = strategies.specular * choice * half.pdf(&self.facets, given, other);
        let mut pdf = strategies.specular.gt(0.0).select(specular, 0.0);
        let on_front = half.reflects & given.z.gt(0.0);
        let diffuse = strategies.diffuse * cosine_hemisphere_pdf(other.z);
        pdf += on_front.select(diffuse, 0.0);
        let coated = on_front & strategies.clearcoat.gt(0.0);
        if coated.any() {
            let density = match self.layered {
                true => half.pdf(self.layers().coat_facets(), given, other),
                false => self.clearcoat_density(m.z) * m.z / (4.0 * other.dot(m)),
            };
            pdf += coated.select(strategies.clearcoat * density, 0.0);
        }
        total.gt(0.0).select(pdf / total, 0.0)
    }

    /// Samples the other direction with these strategies.
    #[inline(always)]
    pub(super) fn sample_by(
        &self,
        strategies: &Strategies<S>,
        given: Vector<S>,
        u: Numbers<S>,
    ) -> ModelSample<S> {
        let chosen = u.lobe * strategies.total();
        let of_base = chosen.lt(strategies.diffuse);
        let of_clearcoat = chosen.lt(strategies.diffuse + strategies.clearcoat) & !of_base;
        let of_interface = !(of_base | of_clearcoat) & strategies.specular.gt(0.0);
        let mut sample = ModelSample::finite(cosine_hemisphere(u.direction), of_base);
        if of_clearcoat.any() {
            let m = match self.layered {
                true => {
                    let above = given * given.z.sign();
                    self.layers().coat_facets().sample(above, u.direction)
                }
                false => self.sample_clearcoat(u.direction),
            };
            let w = reflect(given, m);
            let coat = ModelSample::finite(w, w.z.gt(0.0));
            sample = ModelSample::select(of_clearcoat, &coat, &sample);
        }
        if of_interface.any() {
            let left = (chosen - strategies.diffuse - strategies.clearcoat) / strategies.specular;
            let m = self.facets.sample(given * given.z.sign(), u.direction);
            let reflects = left.ge(self.transmission_probability(given, m));
            let cos = given.dot(m);
            let interface = fresnel::dielectric(cos, cos.same(self.eta));
            let facet = facet_sample(given, m, &interface, reflects, of_interface);
            sample = ModelSample::select(of_interface, &facet, &sample);
        }
        sample.valid = sample.valid & !given.z.equals(0.0);
        sample
    }

    /// A facet normal of the clear coat.
    #[inline(always)]
    fn sample_clearcoat(&self, u: Pair<S>) -> Vector<S> {
        let a2 = self.clearcoat_alpha * self.clearcoat_alpha;
        let cos2 = (1.0 - a2.powf(1.0 - u.y)) / (1.0 - a2);
        let sin = (1.0 - cos2).safe_sqrt();
        let (sin_phi, cos_phi) = u.x.sin_cos_turns();
        Vector::new(cos_phi * sin, sin_phi * sin, cos2.safe_sqrt())
    }

    /// Density of facet normals of the clear coat.
    #[inline(always)]
    fn clearcoat_density(&self, cos_m: Float<S>) -> Float<S> {
        gtr1(self.clearcoat_excess(), self.clearcoat_norm, cos_m)
    }
}
