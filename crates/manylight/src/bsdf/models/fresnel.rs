//! Fresnel's equations for dielectrics and conductors, and reflectance averaged over diffuse light (the fits of Mitsuba 3).

use crate::color::Rgb;
use crate::math::{Vec3, float::safe_sqrt};

/// Reflection and refraction of unpolarised light at a dielectric interface.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct Interface {
    /// Fraction reflected.
    pub reflectance: f32,
    /// Cosine of the refracted direction, with the opposite sign of the given cosine; 0 for total reflection.
    pub cos_t: f32,
    /// Index on the far side over that on the near side.
    pub eta: f32,
    /// Inverse of `eta`: the factor of the tangential part of a refracted direction.
    pub inv_eta: f32,
}

/// Fresnel's equations for a direction with cosine `cos` to the normal on the outside. `eta` is the interior over the exterior index of refraction.
#[inline(always)]
pub(in crate::bsdf) fn dielectric(cos: f32, eta: f32) -> Interface {
    let outside = cos >= 0.0;
    let inverse = 1.0 / eta;
    let (eta_far, inv_eta) = if outside {
        (eta, inverse)
    } else {
        (inverse, eta)
    };
    let c = cos.abs();
    let t = refracted_cosine(c, inv_eta);
    Interface {
        reflectance: reflectance(c, t, eta_far),
        cos_t: if outside { -t } else { t },
        eta: eta_far,
        inv_eta,
    }
}

/// Cosine of the refracted direction for a direction with cosine `cos` >= 0; 0 for total reflection. `inv_eta` is the index on the near
/// side over that on the far side.
#[inline(always)]
pub(in crate::bsdf) fn refracted_cosine(cos: f32, inv_eta: f32) -> f32 {
    safe_sqrt(1.0 - (1.0 - cos * cos) * inv_eta * inv_eta)
}

/// Reflectance for unpolarised light. `c` and `t` (>= 0) are the cosines on the near and the far side, `eta` is the index on the far side over
/// that on the near side.
#[inline(always)]
pub(in crate::bsdf) fn reflectance(c: f32, t: f32, eta: f32) -> f32 {
    if eta == 1.0 {
        0.0
    } else if c == 0.0 {
        1.0
    } else {
        // The amplitudes of both polarisations, (c - ηt)/(c + ηt) and (t - ηc)/(t + ηc), with one common denominator: a division is as
        // expensive as the rest of the function.
        let (s, s_all) = (c - eta * t, c + eta * t);
        let (p, p_all) = (t - eta * c, t + eta * c);
        let (s, p, all) = (s * p_all, p * s_all, s_all * p_all);
        0.5 * (s * s + p * p) / (all * all)
    }
}

/// Fraction of light that enters a coat of relative index `eta` from outside at the cosine `cos`.
#[inline(always)]
pub(in crate::bsdf) fn coat_transmittance(cos: f32, eta: f32) -> f32 {
    1.0 - coat_reflectance(cos, eta, eta.recip())
}

/// One minus [`coat_transmittance`], given `eta` and its inverse.
#[inline(always)]
pub(in crate::bsdf) fn coat_reflectance(cos: f32, eta: f32, inv_eta: f32) -> f32 {
    reflectance(cos, refracted_cosine(cos, inv_eta), eta)
}

/// The direction refracted at the microfacet `m`; `cos_t` and `inv_eta` are those of [`dielectric`] for `w·m`.
#[inline]
pub(in crate::bsdf) fn refract(w: Vec3, m: Vec3, interface: &Interface) -> Vec3 {
    m * (w.dot(m) * interface.inv_eta + interface.cos_t) - w * interface.inv_eta
}

/// The direction mirrored at the microfacet `m`.
#[inline]
pub(in crate::bsdf) fn reflect(w: Vec3, m: Vec3) -> Vec3 {
    m * (2.0 * w.dot(m)) - w
}

/// Fresnel's equations of a conductor, with precomputed terms.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct ConductorFresnel {
    /// η² - k².
    difference: Rgb,
    /// 4 η² k².
    product: Rgb,
}

impl ConductorFresnel {
    /// From [`ConductorFresnel::terms`].
    #[inline(always)]
    pub(in crate::bsdf) fn from_terms([difference, product]: [Rgb; 2]) -> Self {
        ConductorFresnel {
            difference,
            product,
        }
    }

    /// `η² - k²` and `4 η² k²`.
    #[inline]
    pub(in crate::bsdf) fn terms(&self) -> [Rgb; 2] {
        [self.difference, self.product]
    }

    /// From the complex index of refraction η + ik.
    pub(in crate::bsdf) fn new(eta: Rgb, k: Rgb) -> Self {
        let (eta2, k2) = (eta * eta, k * k);
        ConductorFresnel {
            difference: eta2 - k2,
            product: eta2 * k2 * 4.0,
        }
    }

    /// Reflectance of unpolarised light at the cosine `cos` >= 0.
    #[inline(always)]
    pub(in crate::bsdf) fn reflectance(&self, cos: f32) -> Rgb {
        let cos2 = cos * cos;
        let sin2 = 1.0 - cos2;
        self.difference.zip(self.product, |difference, product| {
            let real = difference - sin2;
            let modulus = safe_sqrt(real * real + product);
            let a = safe_sqrt(0.5 * (modulus + real));
            let (s1, s2) = (modulus + cos2, 2.0 * cos * a);
            let (p1, p2) = (modulus * cos2 + sin2 * sin2, s2 * sin2);
            // The mean of s = (s1 - s2)/(s1 + s2) and p = s (p1 - p2)/(p1 + p2).
            (s1 - s2) * p1 / ((s1 + s2) * (p1 + p2))
        })
    }

    /// Upper bound of the reflectance for cosines between the two given ones: it has at most one minimum, so it is largest at an end.
    #[inline(always)]
    pub(in crate::bsdf) fn bound(&self, cosines: [f32; 2]) -> Rgb {
        let [a, b] = cosines.map(|cos| self.reflectance(cos));
        a.zip(b, f32::max)
    }
}

/// Reflectance of a dielectric interface averaged over diffuse light. A fit: of Egan and Hilgeman for `eta < 1`, of d'Eon and Irving
/// otherwise.
pub(in crate::bsdf) fn diffuse_reflectance(eta: f32) -> f32 {
    if eta < 1.0 {
        return -1.4399 * (eta * eta) + 0.7099 * eta + 0.6681 + 0.0636 / eta;
    }
    let x = 1.0 / eta;
    0.919_317 + x * (-3.4793 + x * (6.75335 + x * (-7.80989 + x * (4.98554 - x * 1.36881))))
}
