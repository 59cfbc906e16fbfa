//! Fresnel's equations for dielectrics and conductors, and reflectance averaged over diffuse light
//! (the fits of Mitsuba 3).

use crate::color::Rgb;
use crate::lanes::{Color, Float, One, Vector, Width, lanewise};

/// Reflection and refraction of unpolarised light at a dielectric interface.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct Interface<S: Width> {
    /// Fraction reflected.
    pub reflectance: Float<S>,
    /// Cosine of the refracted direction, with the opposite sign of the given cosine; 0 for total
    /// reflection.
    pub cos_t: Float<S>,
    /// Index on the far side over that on the near side.
    pub eta: Float<S>,
    /// Inverse of `eta`: the factor of the tangential part of a refracted direction.
    pub inv_eta: Float<S>,
}

/// Fresnel's equations for a direction with cosine `cos` to the normal on the outside. `eta` is the
/// interior over the exterior index of refraction.
#[inline(always)]
pub(in crate::bsdf) fn dielectric<S: Width>(cos: Float<S>, eta: Float<S>) -> Interface<S> {
    let outside = cos.ge(0.0);
    let inverse = eta.recip();
    let (eta_far, inv_eta) = (outside.select(eta, inverse), outside.select(inverse, eta));
    let c = cos.abs();
    let t = refracted_cosine(c, inv_eta);
    Interface {
        reflectance: reflectance(c, t, eta_far),
        cos_t: outside.select(-t, t),
        eta: eta_far,
        inv_eta,
    }
}

/// Cosine of the refracted direction for a direction with cosine `cos` >= 0; 0 for total
/// reflection. `inv_eta` is the index on the near side over that on the far side.
#[inline(always)]
pub(in crate::bsdf) fn refracted_cosine<S: Width>(cos: Float<S>, inv_eta: Float<S>) -> Float<S> {
    (1.0 - (1.0 - cos * cos) * inv_eta * inv_eta).safe_sqrt()
}

/// Reflectance for unpolarised light. `c` and `t` (>= 0) are the cosines on the near and the far
/// side, `eta` is the index on the far side over that on the near side.
#[inline(always)]
pub(in crate::bsdf) fn reflectance<S: Width>(c: Float<S>, t: Float<S>, eta: Float<S>) -> Float<S> {
    // The amplitudes of both polarisations, (c - ηt)/(c + ηt) and (t - ηc)/(t + ηc), with one
    // common denominator: a division is as expensive as the rest of the function.
    let (s, s_all) = (c - eta * t, c + eta * t);
    let (p, p_all) = (t - eta * c, t + eta * c);
    let (s, p, all) = (s * p_all, p * s_all, s_all * p_all);
    let r = 0.5 * (s * s + p * p) / (all * all);
    let r = c.equals(0.0).select(1.0, r);
    eta.equals(1.0).select(0.0, r)
}

/// Fraction of light that enters a coat of relative index `eta` from outside at the cosine `cos`.
#[inline(always)]
pub(in crate::bsdf) fn coat_transmittance<S: Width>(cos: Float<S>, eta: f32) -> Float<S> {
    let (eta, inv_eta) = (cos.same(eta), cos.same(eta.recip()));
    1.0 - coat_reflectance(cos, eta, inv_eta)
}

/// One minus [`coat_transmittance`], given `eta` and its inverse.
#[inline(always)]
pub(in crate::bsdf) fn coat_reflectance<S: Width>(
    cos: Float<S>,
    eta: Float<S>,
    inv_eta: Float<S>,
) -> Float<S> {
    reflectance(cos, refracted_cosine(cos, inv_eta), eta)
}

/// The direction refracted at the microfacet `m`; `cos_t` and `inv_eta` are those of [`dielectric`]
/// for `w·m`.
#[inline(always)]
pub(in crate::bsdf) fn refract<S: Width>(
    w: Vector<S>,
    m: Vector<S>,
    interface: &Interface<S>,
) -> Vector<S> {
    m * (w.dot(m) * interface.inv_eta + interface.cos_t) - w * interface.inv_eta
}

/// The direction mirrored at the microfacet `m`.
#[inline(always)]
pub(in crate::bsdf) fn reflect<S: Width>(w: Vector<S>, m: Vector<S>) -> Vector<S> {
    m * (2.0 * w.dot(m)) - w
}

/// Reflectance of a conductor at the cosine `cos` >= 0, from η² - k² and 4 η² k².
#[inline(always)]
fn conductor_reflectance<S: Width>(
    cos: Float<S>,
    difference: Float<S>,
    product: Float<S>,
) -> Float<S> {
    let cos2 = cos * cos;
    let sin2 = 1.0 - cos2;
    let real = difference - sin2;
    let modulus = (real * real + product).safe_sqrt();
    let a = (0.5 * (modulus + real)).safe_sqrt();
    let (s1, s2) = (modulus + cos2, 2.0 * cos * a);
    let (p1, p2) = (modulus * cos2 + sin2 * sin2, s2 * sin2);
    // The mean of s = (s1 - s2)/(s1 + s2) and p = s (p1 - p2)/(p1 + p2).
    (s1 - s2) * p1 / ((s1 + s2) * (p1 + p2))
}

/// Fresnel's equations of a conductor, with precomputed terms.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct ConductorFresnel<S: Width> {
    /// η² - k².
    difference: Color<S>,
    /// 4 η² k².
    product: Color<S>,
}

impl<S: Width> ConductorFresnel<S> {
    /// From the complex index of refraction η + ik.
    #[inline(always)]
    pub(in crate::bsdf) fn new(eta: Color<S>, k: Color<S>) -> Self {
        let (eta2, k2) = (eta * eta, k * k);
        ConductorFresnel {
            difference: eta2 - k2,
            product: eta2 * k2 * 4.0,
        }
    }

    /// Reflectance of unpolarised light at the cosine `cos` >= 0.
    #[inline(always)]
    pub(in crate::bsdf) fn reflectance(&self, cos: Float<S>) -> Color<S> {
        let (d, p) = (self.difference, self.product);
        Color::new(
            conductor_reflectance(cos, d.r, p.r),
            conductor_reflectance(cos, d.g, p.g),
            conductor_reflectance(cos, d.b, p.b),
        )
    }
}

lanewise!(ConductorFresnel {
    difference,
    product
});

impl ConductorFresnel<One> {
    /// Upper bound of the reflectance for cosines between the two given ones: it has at most one
    /// minimum, so it is largest at an end.
    #[inline(always)]
    pub(in crate::bsdf) fn bound(&self, cosines: [f32; 2]) -> Rgb {
        let reflectance = |cos: f32| Rgb::from(self.reflectance(cos.into()));
        let [a, b] = cosines;
        reflectance(a).zip(reflectance(b), f32::max)
    }
}

/// Reflectance of a dielectric interface averaged over diffuse light. A fit: of Egan and Hilgeman
/// for `eta < 1`, of d'Eon and Irving otherwise.
pub(in crate::bsdf) fn diffuse_reflectance(eta: f32) -> f32 {
    if eta < 1.0 {
        return -1.4399 * (eta * eta) + 0.7099 * eta + 0.6681 + 0.0636 / eta;
    }
    let x = 1.0 / eta;
    0.919_317 + x * (-3.4793 + x * (6.75335 + x * (-7.80989 + x * (4.98554 - x * 1.36881))))
}
