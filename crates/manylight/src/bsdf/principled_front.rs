//! What the front of the Disney model reflects, in terms that need no choices, so that loops over it become vectors.

use super::bound::Arriving;
use super::fresnel;
use super::microfacet::Microfacets;
use super::principled::{ggx_masking, gtr1, schlick_weight};
use crate::color::Rgb;
use crate::lanes::{LANES, Lanes, Lanes3, broadcast};
use crate::math::Vec3;

/// The roughness that the clear coat is masked with.
const CLEARCOAT_MASKING_ALPHA: f32 = 0.25;
/// The clear coat's reflectance at normal incidence.
const CLEARCOAT_R0: f32 = 0.04;

/// The numbers of a surface; lobes that are not asked for have weight 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Front {
    /// Relative index of refraction, and its inverse.
    pub(super) eta: f32,
    pub(super) inv_eta: f32,
    /// Weight of the dielectric's reflectance.
    pub(super) plain: f32,
    /// Weight of Schlick's reflectance: of its constant 1 and of what it is at normal incidence.
    pub(super) schlick: f32,
    pub(super) schlick_r0: Rgb,
    /// Of the diffuse lobe, over π.
    pub(super) base: Rgb,
    pub(super) sheen: Rgb,
    pub(super) roughness: f32,
    pub(super) flatness: f32,
    pub(super) clearcoat: f32,
    /// The terms of its distribution; see [`gtr1`].
    pub(super) clearcoat_excess: f32,
    pub(super) clearcoat_norm: f32,
}

impl Front {
    /// Whether there is a clear coat, sheen, or a fake subsurface term.
    #[inline(always)]
    pub(super) fn has_extras(&self) -> bool {
        self.clearcoat != 0.0 || !self.sheen.is_black() || self.flatness != 0.0
    }

    /// `f |wi·n|`, for local directions above the surface, with or without the extras. `seen` is [`Microfacets::seen`] of `wo`.
    #[inline(always)]
    pub(super) fn eval<const EXTRAS: bool>(
        &self,
        facets: &Microfacets,
        wi: Vec3,
        wo: Vec3,
        seen: f32,
    ) -> Rgb {
        let half = wi + wo;
        // |wi + wo| = 2 wo·m for unit vectors.
        let cos = 0.5 * half.length_squared().sqrt();
        let refracted = fresnel::refracted_cosine(cos, self.inv_eta);
        let r = fresnel::reflectance(cos, refracted, self.eta);
        // From the denser side, Schlick's approximation is by the angle of the refracted direction.
        let s = schlick_weight(if self.eta > 1.0 { cos } else { refracted });
        let reflectance =
            self.schlick_r0 * (1.0 - s) + Rgb::splat(self.plain * r + self.schlick * s);
        let interface = facets.visible_density(wi, half) * seen;
        let mut rest = self.diffuse::<EXTRAS>(wi, wo, cos);
        if EXTRAS {
            let cos_m = half.z / (2.0 * cos);
            rest += Rgb::splat(self.clearcoat(s, cos_m, wi.z, wo.z));
        }
        reflectance * interface + rest * wi.z
    }

    /// Upper bound of every channel of [`Front::eval`] for light from a cone.
    #[inline(always)]
    pub(super) fn bound(
        &self,
        facets: &Microfacets,
        arriving: &Arriving,
        wo: Vec3,
        seen: f32,
    ) -> f32 {
        let [lowest, highest] = arriving.cosines();
        let halves = arriving.halves(wo);
        let [cos_d, most_cos_d] = halves.cosines;
        // All reflectances rise with the angle.
        let refracted = fresnel::refracted_cosine(cos_d, self.inv_eta);
        let r = fresnel::reflectance(cos_d, refracted, self.eta);
        let s = schlick_weight(if self.eta > 1.0 { cos_d } else { refracted });
        let reflectance = self.schlick_r0.max_channel() + self.plain * r + self.schlick * s;
        let interface = facets.projected_bound(halves.highest, arriving) * seen;
        let projection = arriving.projection(highest);

        // Retro-reflection rises with θ_i, the rest of the diffuse lobe falls.
        let (least_fi, fi) = (schlick_weight(highest), schlick_weight(lowest.max(0.0)));
        let fo = schlick_weight(wo.z);
        let rr = 2.0 * self.roughness * most_cos_d * most_cos_d;
        let lambert = (1.0 - 0.5 * least_fi) * (1.0 - 0.5 * fo);
        let full = (lambert + rr * (fi + fo + fi * fo * (rr - 1.0))) * projection;
        let flat = match arriving.projected {
            None => 1.25 * highest / (highest + wo.z),
            Some(projected) => 1.25 * projected / (lowest.max(0.0) + wo.z),
        };
        let base = full * (1.0 - self.flatness) + flat * self.flatness;
        let sheen = self.sheen.max_channel() * schlick_weight(cos_d);
        let clearcoat = self.clearcoat(s, halves.highest.max(0.0), highest, wo.z);
        let rest = self.base.max_channel() * base + (sheen + clearcoat) * projection;
        if highest > 0.0 {
            reflectance * interface + rest
        } else {
            0.0
        }
    }

    /// Over the cosine of `wi`.
    #[inline(always)]
    fn clearcoat(&self, s: f32, cos_m: f32, cos_i: f32, cos_o: f32) -> f32 {
        let f = s + (1.0 - s) * CLEARCOAT_R0;
        let masking = ggx_masking(cos_i, CLEARCOAT_MASKING_ALPHA)
            * ggx_masking(cos_o, CLEARCOAT_MASKING_ALPHA);
        self.clearcoat * f * gtr1(self.clearcoat_excess, self.clearcoat_norm, cos_m) * masking
    }

    /// Diffuse, retro-reflection, fake subsurface scattering and sheen; over the cosine of `wi`.
    #[inline(always)]
    fn diffuse<const EXTRAS: bool>(&self, wi: Vec3, wo: Vec3, cos_d: f32) -> Rgb {
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
        self.base * shape + self.sheen * schlick_weight(cos_d)
    }
}

/// Up to sixteen fronts side by side.
#[derive(Clone, Debug)]
pub(super) struct Fronts {
    eta: Lanes,
    inv_eta: Lanes,
    plain: Lanes,
    schlick: Lanes,
    schlick_r0: Lanes3,
    base: Lanes3,
    sheen: Lanes3,
    roughness: Lanes,
    flatness: Lanes,
    clearcoat: Lanes,
    clearcoat_excess: Lanes,
    clearcoat_norm: Lanes,
    /// Whether some lane has them.
    pub(super) has_extras: bool,
}

impl Fronts {
    /// Lanes that reflect nothing.
    pub(super) fn black() -> Self {
        Fronts {
            eta: [1.5; LANES],
            inv_eta: [1.5f32.recip(); LANES],
            plain: [0.0; LANES],
            schlick: [0.0; LANES],
            schlick_r0: Lanes3::ZERO,
            base: Lanes3::ZERO,
            sheen: Lanes3::ZERO,
            roughness: [1.0; LANES],
            flatness: [0.0; LANES],
            clearcoat: [0.0; LANES],
            clearcoat_excess: [0.0; LANES],
            clearcoat_norm: [1.0; LANES],
            has_extras: false,
        }
    }

    pub(super) fn set(&mut self, i: usize, front: &Front, weight: f32) {
        self.eta[i] = front.eta;
        self.inv_eta[i] = front.inv_eta;
        self.plain[i] = front.plain * weight;
        self.schlick[i] = front.schlick * weight;
        self.schlick_r0.set(i, front.schlick_r0 * weight);
        self.base.set(i, front.base * weight);
        self.sheen.set(i, front.sheen * weight);
        self.roughness[i] = front.roughness;
        self.flatness[i] = front.flatness;
        self.clearcoat[i] = front.clearcoat * weight;
        self.clearcoat_excess[i] = front.clearcoat_excess;
        self.clearcoat_norm[i] = front.clearcoat_norm;
        self.has_extras |= front.has_extras();
    }

    /// Lane 0 in all lanes.
    pub(super) fn broadcast(&mut self) {
        for numbers in [
            &mut self.eta,
            &mut self.inv_eta,
            &mut self.plain,
            &mut self.schlick,
            &mut self.roughness,
            &mut self.flatness,
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

    #[inline(always)]
    pub(super) fn lane(&self, i: usize) -> Front {
        Front {
            eta: self.eta[i],
            inv_eta: self.inv_eta[i],
            plain: self.plain[i],
            schlick: self.schlick[i],
            schlick_r0: self.schlick_r0.rgb(i),
            base: self.base.rgb(i),
            sheen: self.sheen.rgb(i),
            roughness: self.roughness[i],
            flatness: self.flatness[i],
            clearcoat: self.clearcoat[i],
            clearcoat_excess: self.clearcoat_excess[i],
            clearcoat_norm: self.clearcoat_norm[i],
        }
    }
}
