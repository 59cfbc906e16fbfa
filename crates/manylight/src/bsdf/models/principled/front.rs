//! Reflection on the front of the principled model, without branches, so that loops over it are vectorized.

use super::terms::{ggx_masking, gtr1, schlick_weight};
use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::models::fresnel;
use crate::bsdf::models::microfacet::Microfacets;
use crate::color::Rgb;
use crate::lanes::{LANES, Lanes, Lanes3, broadcast};
use crate::math::Vec3;

/// Roughness alpha of the masking of the clear coat (Burley 2012).
const CLEARCOAT_MASKING_ALPHA: f32 = 0.25;
/// Reflectance of the clear coat at normal incidence.
const CLEARCOAT_R0: f32 = 0.04;

/// The terms at a point. Lobes that are not requested have weight 0.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct PrincipledFront {
    /// Relative index of refraction.
    pub(in crate::bsdf) eta: f32,
    /// Its inverse.
    pub(in crate::bsdf) inv_eta: f32,
    /// Weight of the Fresnel reflectance of a dielectric.
    pub(in crate::bsdf) plain: f32,
    /// Weight of Schlick's term (1 - cos)⁵.
    pub(in crate::bsdf) schlick: f32,
    /// Weight of one minus Schlick's term: reflectance at normal incidence.
    pub(in crate::bsdf) schlick_r0: Rgb,
    /// Diffuse albedo over π.
    pub(in crate::bsdf) base: Rgb,
    pub(in crate::bsdf) sheen: Rgb,
    pub(in crate::bsdf) roughness: f32,
    pub(in crate::bsdf) flatness: f32,
    /// 1 if the diffuse lobe is Lambertian under the main interface, else 0.
    pub(in crate::bsdf) layered: f32,
    pub(in crate::bsdf) clearcoat: f32,
    /// Parameters of the clear coat's distribution; see [`gtr1`].
    pub(in crate::bsdf) clearcoat_excess: f32,
    pub(in crate::bsdf) clearcoat_norm: f32,
}

/// Fresnel reflectance of the clear coat by Schlick's term.
#[inline(always)]
fn clearcoat_fresnel(s: f32) -> f32 {
    s + (1.0 - s) * CLEARCOAT_R0
}

impl PrincipledFront {
    /// Whether there is a clear coat, sheen, flatness, or a diffuse lobe under the interface.
    #[inline(always)]
    pub(in crate::bsdf) fn has_extras(&self) -> bool {
        self.clearcoat != 0.0
            || !self.sheen.is_black()
            || self.flatness != 0.0
            || self.layered != 0.0
    }

    /// Reflectance of the main interface at the cosine `cos` to a facet. Schlick's term is at least `least`.
    #[inline(always)]
    pub(in crate::bsdf) fn interface_reflectance(&self, cos: f32, least: f32) -> Rgb {
        let (r, s) = self.fresnel_terms(cos);
        self.reflectance(r, s.max(least))
    }

    /// Reflectance of a plain dielectric, and Schlick's term, at the cosine `cos` to a facet.
    #[inline(always)]
    fn fresnel_terms(&self, cos: f32) -> (f32, f32) {
        let refracted = fresnel::refracted_cosine(cos, self.inv_eta);
        let r = fresnel::reflectance(cos, refracted, self.eta);
        // From the denser side, Schlick's approximation uses the angle of the refracted direction.
        let s = schlick_weight(if self.eta > 1.0 { cos } else { refracted });
        (r, s)
    }

    /// Reflectance of the main interface by [`PrincipledFront::fresnel_terms`].
    #[inline(always)]
    fn reflectance(&self, r: f32, s: f32) -> Rgb {
        self.schlick_r0 * (1.0 - s) + Rgb::splat(self.plain * r + self.schlick * s)
    }

    /// Reflectance of the clear coat, with its weight, at the cosine `cos` to a facet.
    #[inline]
    pub(in crate::bsdf) fn clearcoat_reflectance(&self, cos: f32) -> f32 {
        self.clearcoat * clearcoat_fresnel(schlick_weight(cos))
    }

    /// `f |wi·n|` for local directions above the surface. `EXTRAS` is [`PrincipledFront::has_extras`], `seen` is [`Microfacets::seen`] of `wo`.
    #[inline(always)]
    pub(in crate::bsdf) fn eval<const EXTRAS: bool>(
        &self,
        facets: &Microfacets,
        wi: Vec3,
        wo: Vec3,
        seen: f32,
    ) -> Rgb {
        let half = wi + wo;
        // |wi + wo| = 2 wo·m for unit vectors.
        let cos = 0.5 * half.length_squared().sqrt();
        let (r, s) = self.fresnel_terms(cos);
        let reflectance = self.reflectance(r, s);
        let interface = facets.visible_density(wi, half) * seen;
        let mut rest = self.diffuse::<EXTRAS>(wi, wo, cos, r);
        if EXTRAS {
            let cos_m = half.z / (2.0 * cos);
            rest += Rgb::splat(self.clearcoat(s, cos_m, wi.z, wo.z));
        }
        reflectance * interface + rest * wi.z
    }

    /// Upper bound of all channels of [`PrincipledFront::eval`] over a cone of `wi`.
    #[inline(always)]
    pub(in crate::bsdf) fn bound(
        &self,
        facets: &Microfacets,
        incident: &IncidentCone,
        wo: Vec3,
        seen: f32,
    ) -> f32 {
        let [lowest, highest] = incident.cosines();
        let halves = incident.halves(wo);
        let [cos_d, most_cos_d] = halves.cosines;
        // All reflectances increase with the angle.
        let (r, s) = self.fresnel_terms(cos_d);
        let reflectance = self.schlick_r0.max_channel() + self.plain * r + self.schlick * s;
        let interface = facets.projected_bound(halves.highest, incident) * seen;
        let projection = incident.projection(highest);

        // Retro-reflection increases with θ_i, the rest of the diffuse lobe decreases.
        let (least_fi, fi) = (schlick_weight(highest), schlick_weight(lowest.max(0.0)));
        let fo = schlick_weight(wo.z);
        let rr = 2.0 * self.roughness * most_cos_d * most_cos_d;
        let lambert = (1.0 - 0.5 * least_fi) * (1.0 - 0.5 * fo);
        let full = (lambert + rr * (fi + fo + fi * fo * (rr - 1.0))) * projection;
        let flat = match incident.projected {
            None => 1.25 * highest / (highest + wo.z),
            Some(projected) => 1.25 * projected / (lowest.max(0.0) + wo.z),
        };
        let base = full * (1.0 - self.flatness) + flat * self.flatness;
        let base = base + (projection - base) * self.layered;
        let sheen = self.sheen.max_channel() * schlick_weight(cos_d);
        let clearcoat = self.clearcoat(s, halves.highest.max(0.0), highest, wo.z);
        let rest = self.base.max_channel() * base + (sheen + clearcoat) * projection;
        if highest > 0.0 {
            reflectance * interface + rest
        } else {
            0.0
        }
    }

    /// The clear coat, without the cosine of `wi`.
    #[inline(always)]
    fn clearcoat(&self, s: f32, cos_m: f32, cos_i: f32, cos_o: f32) -> f32 {
        let f = clearcoat_fresnel(s);
        let masking = ggx_masking(cos_i, CLEARCOAT_MASKING_ALPHA)
            * ggx_masking(cos_o, CLEARCOAT_MASKING_ALPHA);
        self.clearcoat * f * gtr1(self.clearcoat_excess, self.clearcoat_norm, cos_m) * masking
    }

    /// Diffuse reflection with retro-reflection, flatness and sheen, without the cosine of `wi`. `r` is the reflectance of the plain
    /// dielectric.
    #[inline(always)]
    fn diffuse<const EXTRAS: bool>(&self, wi: Vec3, wo: Vec3, cos_d: f32, r: f32) -> Rgb {
        let (fi, fo) = (schlick_weight(wi.z), schlick_weight(wo.z));
        let lambert = (1.0 - 0.5 * fi) * (1.0 - 0.5 * fo);
        let rr = 2.0 * self.roughness * cos_d * cos_d;
        let full = lambert + rr * (fi + fo + fi * fo * (rr - 1.0));
        if !EXTRAS {
            return self.base * full;
        }
        let f90 = 0.5 * rr;
        let fss = (1.0 + (f90 - 1.0) * fi) * (1.0 + (f90 - 1.0) * fo);
        let flat = 1.25 * (fss * (1.0 / (wi.z + wo.z) - 0.5) + 0.5);
        let shape = full + (flat - full) * self.flatness;
        let shape = shape + (1.0 - r - shape) * self.layered;
        self.base * shape + self.sheen * schlick_weight(cos_d)
    }
}

/// Sixteen fronts in SIMD lanes.
#[derive(Clone, Debug)]
pub(in crate::bsdf) struct PrincipledFrontLanes {
    eta: Lanes,
    inv_eta: Lanes,
    plain: Lanes,
    schlick: Lanes,
    schlick_r0: Lanes3,
    base: Lanes3,
    sheen: Lanes3,
    roughness: Lanes,
    flatness: Lanes,
    layered: Lanes,
    clearcoat: Lanes,
    clearcoat_excess: Lanes,
    clearcoat_norm: Lanes,
    /// Whether [`PrincipledFront::has_extras`] is true in some lane.
    pub(in crate::bsdf) has_extras: bool,
}

impl PrincipledFrontLanes {
    /// Lanes without reflection.
    pub(in crate::bsdf) fn black() -> Self {
        PrincipledFrontLanes {
            eta: [1.5; LANES],
            inv_eta: [1.5f32.recip(); LANES],
            plain: [0.0; LANES],
            schlick: [0.0; LANES],
            schlick_r0: Lanes3::ZERO,
            base: Lanes3::ZERO,
            sheen: Lanes3::ZERO,
            roughness: [1.0; LANES],
            flatness: [0.0; LANES],
            layered: [0.0; LANES],
            clearcoat: [0.0; LANES],
            clearcoat_excess: [0.0; LANES],
            clearcoat_norm: [1.0; LANES],
            has_extras: false,
        }
    }

    /// Sets lane `i`.
    pub(in crate::bsdf) fn set(&mut self, i: usize, front: &PrincipledFront, weight: f32) {
        self.eta[i] = front.eta;
        self.inv_eta[i] = front.inv_eta;
        self.plain[i] = front.plain * weight;
        self.schlick[i] = front.schlick * weight;
        self.schlick_r0.set(i, front.schlick_r0 * weight);
        self.base.set(i, front.base * weight);
        self.sheen.set(i, front.sheen * weight);
        self.roughness[i] = front.roughness;
        self.flatness[i] = front.flatness;
        self.layered[i] = front.layered;
        self.clearcoat[i] = front.clearcoat * weight;
        self.clearcoat_excess[i] = front.clearcoat_excess;
        self.clearcoat_norm[i] = front.clearcoat_norm;
        self.has_extras |= front.has_extras();
    }

    /// Copies lane 0 to all lanes.
    pub(in crate::bsdf) fn broadcast(&mut self) {
        for numbers in [
            &mut self.eta,
            &mut self.inv_eta,
            &mut self.plain,
            &mut self.schlick,
            &mut self.roughness,
            &mut self.flatness,
            &mut self.layered,
            &mut self.clearcoat,
            &mut self.clearcoat_excess,
            &mut self.clearcoat_norm,
        ] {
            broadcast(numbers);
        }
        for colors in [&mut self.schlick_r0, &mut self.base, &mut self.sheen] {
            colors.broadcast();
        }
    }

    /// Lane `i`.
    #[inline(always)]
    pub(in crate::bsdf) fn lane(&self, i: usize) -> PrincipledFront {
        PrincipledFront {
            eta: self.eta[i],
            inv_eta: self.inv_eta[i],
            plain: self.plain[i],
            schlick: self.schlick[i],
            schlick_r0: self.schlick_r0.rgb(i),
            base: self.base.rgb(i),
            sheen: self.sheen.rgb(i),
            roughness: self.roughness[i],
            flatness: self.flatness[i],
            layered: self.layered[i],
            clearcoat: self.clearcoat[i],
            clearcoat_excess: self.clearcoat_excess[i],
            clearcoat_norm: self.clearcoat_norm[i],
        }
    }
}
