//! Dielectric interfaces with refraction.
//!
//! Source: Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007.

use super::fresnel::{self, reflect, refract};
use super::microfacet::Microfacets;
use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::lobes::microfacet_class;
use crate::bsdf::model_sample::{DeltaEvent, ModelSample};
use crate::bsdf::{BsdfNumbers, Lobes};
use crate::color::Rgb;
use crate::math::Vec3;

/// Bounds of the reflectance of a rough interface where it is estimated at the surface normal: facets reflect and refract at other angles.
const FACET_REFLECTANCES: [f32; 2] = [0.05, 0.95];

/// Factors of the reflected and of the transmitted light of an interface.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct InterfaceTints {
    pub reflection: Rgb,
    pub transmission: Rgb,
}

impl InterfaceTints {
    /// Estimated albedo, by the largest channels, where the interface reflects the fraction `r`.
    #[inline]
    fn albedo_estimate(&self, r: f32) -> f32 {
        self.reflection.max_channel() * r + self.transmission.max_channel() * (1.0 - r)
    }

    /// Probability of sampling reflection, in proportion to the light that both events return; `None` if they return none.
    #[inline]
    fn reflection_probability(&self, r: f32) -> Option<f32> {
        let all = self.albedo_estimate(r);
        (all > 0.0).then(|| self.reflection.max_channel() * r / all)
    }
}

/// A smooth dielectric interface.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct SmoothDielectric {
    /// Interior over exterior index of refraction.
    pub eta: f32,
    pub tints: InterfaceTints,
}

impl SmoothDielectric {
    /// See [`Model::albedo_estimate`](crate::bsdf::model::Model::albedo_estimate).
    pub(in crate::bsdf) fn albedo_estimate(&self, cos: f32, _lobes: Lobes) -> f32 {
        self.tints
            .albedo_estimate(fresnel::dielectric(cos, self.eta).reflectance)
    }

    #[inline]
    pub(in crate::bsdf) fn lobes(&self) -> Lobes {
        Lobes::DELTA
    }

    #[inline]
    pub(in crate::bsdf) fn eval(&self, _wi: Vec3, _wo: Vec3, _lobes: Lobes) -> Rgb {
        Rgb::BLACK
    }

    #[inline]
    pub(in crate::bsdf) fn bound(&self, _arriving: &IncidentCone, _wo: Vec3, _lobes: Lobes) -> f32 {
        0.0
    }

    #[inline]
    pub(in crate::bsdf) fn pdf(&self, _given: Vec3, _other: Vec3, _lobes: Lobes) -> f32 {
        0.0
    }

    pub(in crate::bsdf) fn sample(
        &self,
        given: Vec3,
        u: BsdfNumbers,
        _lobes: Lobes,
    ) -> Option<ModelSample> {
        let interface = fresnel::dielectric(given.z, self.eta);
        let r = interface.reflectance;
        let reflection = self.tints.reflection_probability(r)?;
        if u.lobe < reflection {
            let fraction = self.tints.reflection * r;
            return Some(ModelSample::mirror(given, fraction, reflection));
        }
        let w = Vec3::new(
            -interface.inv_eta * given.x,
            -interface.inv_eta * given.y,
            interface.cos_t,
        );
        let delta = DeltaEvent {
            fraction: self.tints.transmission * (1.0 - r),
            probability: 1.0 - reflection,
        };
        (w.z != 0.0).then_some(ModelSample {
            w,
            eta: interface.eta,
            delta: Some(delta),
        })
    }
}

/// A rough dielectric interface.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct RoughDielectric {
    pub facets: Microfacets,
    /// Interior over exterior index of refraction.
    pub eta: f32,
    pub tints: InterfaceTints,
}

impl RoughDielectric {
    /// See [`Model::albedo_estimate`](crate::bsdf::model::Model::albedo_estimate).
    pub(in crate::bsdf) fn albedo_estimate(&self, cos: f32, _lobes: Lobes) -> f32 {
        let [least, most] = FACET_REFLECTANCES;
        let r = fresnel::dielectric(cos, self.eta).reflectance;
        self.tints.albedo_estimate(r.clamp(least, most))
    }

    #[inline]
    pub(in crate::bsdf) fn alpha(&self) -> f32 {
        self.facets.min_alpha()
    }

    #[inline]
    pub(in crate::bsdf) fn lobes(&self) -> Lobes {
        microfacet_class(self.alpha())
    }

    pub(in crate::bsdf) fn eval(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        if !lobes.has(self.lobes()) {
            return Rgb::BLACK;
        }
        let Some(half) = HalfVector::new(wo, wi, self.eta) else {
            return Rgb::BLACK;
        };
        let masking = self.facets.masking(wi, half.m) * self.facets.masking(wo, half.m);
        let common = self.facets.density(half.m) * masking / wo.z.abs();
        let f = fresnel::dielectric(wo.dot(half.m), self.eta).reflectance;
        if half.reflects {
            return self.tints.reflection * (0.25 * f * common);
        }
        // Walter et al., eq. (21), with the half vector of the medium of `wo`: this scales radiance by η².
        let (i, o) = (wi.dot(half.m), wo.dot(half.m));
        self.tints.transmission * ((1.0 - f) * common * (i * o).abs() / (o + half.eta * i).powi(2))
    }

    pub(in crate::bsdf) fn bound(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        if !lobes.has(self.lobes()) || wo.z == 0.0 {
            return 0.0;
        }
        let bounds = interface_bounds(&self.facets, self.eta, incident, wo);
        self.tints.reflection.max_channel() * bounds[0]
            + self.tints.transmission.max_channel() * bounds[1]
    }

    pub(in crate::bsdf) fn pdf(&self, given: Vec3, other: Vec3, lobes: Lobes) -> f32 {
        if !lobes.has(self.lobes()) {
            return 0.0;
        }
        let Some(half) = HalfVector::new(given, other, self.eta) else {
            return 0.0;
        };
        let r = fresnel::dielectric(given.dot(half.m), self.eta).reflectance;
        let Some(reflection) = self.tints.reflection_probability(r) else {
            return 0.0;
        };
        let event = if half.reflects {
            reflection
        } else {
            1.0 - reflection
        };
        half.pdf(&self.facets, given, other) * event
    }

    pub(in crate::bsdf) fn sample(
        &self,
        given: Vec3,
        u: BsdfNumbers,
        _lobes: Lobes,
    ) -> Option<ModelSample> {
        if given.z == 0.0 {
            return None;
        }
        let m = self
            .facets
            .sample(if given.z > 0.0 { given } else { -given }, u.direction);
        let interface = fresnel::dielectric(given.dot(m), self.eta);
        if u.lobe < self.tints.reflection_probability(interface.reflectance)? {
            let w = reflect(given, m);
            return (w.z * given.z > 0.0).then(|| ModelSample::finite(w));
        }
        let w = refract(given, m, &interface);
        (w.z * given.z < 0.0).then_some(ModelSample {
            w,
            eta: interface.eta,
            delta: None,
        })
    }
}

/// Upper bounds of `f |cosθ_i|` of reflection and of transmission at a rough interface without tints, over a cone of `wi`. For transmission it
/// uses `|o·m + η i·m| >= |η - 1|`, which follows from Snell's law.
pub(in crate::bsdf) fn interface_bounds(
    facets: &Microfacets,
    eta: f32,
    incident: &IncidentCone,
    wo: Vec3,
) -> [f32; 2] {
    let side = 1.0f32.copysign(wo.z);
    let up = |w: Vec3| Vec3::new(w.x, w.y, w.z * side);
    let (incident, wo) = (incident.map(up), up(wo));
    let eta = if side > 0.0 { eta } else { eta.recip() };
    let [lowest, _] = incident.cosines();
    let halves = incident.halves(wo);
    let seen = 4.0 * facets.seen(wo);
    let reflected = fresnel::dielectric(halves.cosines[0], eta).reflectance;
    let transmitted = if lowest < 0.0 {
        facets.visible_bound(1.0, 1.0) / (eta - 1.0).powi(2)
    } else {
        0.0
    };
    [
        0.25 * reflected * facets.projected_bound(halves.highest, &incident) * seen,
        transmitted * seen,
    ]
}

/// The microfacet that reflects or refracts one direction to another.
pub(in crate::bsdf) struct HalfVector {
    /// Its unit normal, on the outside.
    pub m: Vec3,
    /// Whether both directions are on the same side of the surface.
    pub reflects: bool,
    /// Index of refraction on the far side of `given` over that on its own side, also for reflection.
    pub eta: f32,
}

impl HalfVector {
    /// `None` if no microfacet does.
    #[inline]
    pub(in crate::bsdf) fn new(given: Vec3, other: Vec3, eta: f32) -> Option<Self> {
        let product = given.z * other.z;
        if product == 0.0 {
            return None;
        }
        let reflects = product > 0.0;
        let eta = if given.z > 0.0 { eta } else { 1.0 / eta };
        let m = (given + other * if reflects { 1.0 } else { eta }).normalize_or_zero();
        let m = if m.z < 0.0 { -m } else { m };
        // Each direction must be on the same side of the facet and of the surface.
        let agrees = given.dot(m) * given.z > 0.0 && other.dot(m) * other.z > 0.0;
        agrees.then_some(HalfVector { m, reflects, eta })
    }

    /// Density of `other` if `m` is sampled from the normals visible from `given`. Jacobians: Walter et al., eqs. (14) and (17).
    #[inline]
    pub(in crate::bsdf) fn pdf(&self, facets: &Microfacets, given: Vec3, other: Vec3) -> f32 {
        if self.reflects {
            return facets.reflected_pdf(given, self.m);
        }
        let (g, o) = (given.dot(self.m), other.dot(self.m));
        facets.pdf(given, self.m) * self.eta * self.eta * o.abs() / (g + self.eta * o).powi(2)
    }
}
