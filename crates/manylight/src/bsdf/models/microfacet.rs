//! Microfacet distributions. Directions are in the local frame, facet normals on the side of the
//! surface normal.
//!
//! Sources: Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007;
//! Heitz, "Sampling the GGX Distribution of Visible Normals", JCGT 2018; Jakob, "An Improved
//! Visible Normal Sampling Routine for the Beckmann Distribution", 2014. As in Mitsuba 3, masking
//! is separable, G(wi, wo) = G1(wi) G1(wo), and Beckmann's G1 is the rational fit of Walter et al.

use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::lobes::Classes;
use crate::bsdf::material::Distribution;
use crate::lanes::{Float, One, Pair, Vector, Width, disc, lanewise};
use crate::math::float::exp;
use crate::math::{Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, FRAC_2_PI, PI};

/// Smallest roughness alpha that single precision can represent; smaller values count as this one.
pub(super) const MIN_ALPHA: f32 = 1e-4;
/// Smallest density of normals, times the cosine, that is not set to zero.
const MIN_DENSITY: f32 = 1e-20;

/// A distribution of microfacet normals.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct Microfacets<S: Width> {
    distribution: Distribution,
    alpha: Pair<S>,
    inv_alpha: Pair<S>,
}

impl<S: Width> Microfacets<S> {
    #[inline(always)]
    pub(in crate::bsdf) fn new(
        distribution: Distribution,
        alpha_u: Float<S>,
        alpha_v: Float<S>,
    ) -> Self {
        let alpha = Pair::new(alpha_u.max(MIN_ALPHA), alpha_v.max(MIN_ALPHA));
        Microfacets {
            distribution,
            alpha,
            inv_alpha: Pair::new(alpha.x.recip(), alpha.y.recip()),
        }
    }

    /// The type of distribution.
    #[inline(always)]
    pub(in crate::bsdf) fn distribution(&self) -> Distribution {
        self.distribution
    }

    /// The smaller roughness alpha of both axes.
    #[inline(always)]
    pub(in crate::bsdf) fn min_alpha(&self) -> Float<S> {
        self.alpha.x.min(self.alpha.y)
    }

    /// The class of a lobe of these facets.
    #[inline(always)]
    pub(in crate::bsdf) fn class(&self) -> Classes<S> {
        Classes::of_microfacets(self.min_alpha())
    }

    /// `D(m)`: area of the microfacets with normal `m`, per solid angle and per area of the
    /// surface.
    #[inline(always)]
    pub(in crate::bsdf) fn density(&self, m: Vector<S>) -> Float<S> {
        let slope2 = (Pair::new(m.x, m.y) * self.inv_alpha).length_squared();
        let cos2 = m.z * m.z;
        let scale = self.inv_alpha.x * self.inv_alpha.y * FRAC_1_PI;
        let density = match self.distribution {
            Distribution::Ggx => scale / (slope2 + cos2).squared(),
            Distribution::Beckmann => scale * (-slope2 / cos2).exp() / (cos2 * cos2),
        };
        (density * m.z).gt(MIN_DENSITY).select(density, 0.0)
    }

    /// `G1(v)`: fraction of the facets with normal `m` that is visible from `v`; 0 for back sides.
    #[inline(always)]
    pub(in crate::bsdf) fn masking(&self, v: Vector<S>, m: Vector<S>) -> Float<S> {
        let t2 = (Pair::new(v.x, v.y) * self.alpha).length_squared() / (v.z * v.z);
        let unmasked = match self.distribution {
            Distribution::Ggx => 2.0 / (1.0 + (1.0 + t2).sqrt()),
            Distribution::Beckmann => {
                let a = t2.sqrt().recip();
                let a2 = a * a;
                let fit = (3.535 * a + 2.181 * a2) / (1.0 + 2.276 * a + 2.577 * a2);
                // (1/1.6)²: the fit is 1 for a >= 1.6.
                t2.le(0.390_625).select(1.0, fit)
            }
        };
        (v.dot(m) * v.z).gt(0.0).select(unmasked, 0.0)
    }

    /// `G1(wo) / (4 cosθ_o)`: the factor of reflection that depends on `wo` only, for `wo` above
    /// the surface.
    #[inline(always)]
    pub(in crate::bsdf) fn seen(&self, wo: Vector<S>) -> Float<S> {
        // The visibility test of the masking passes for all half vectors, and for the surface
        // normal.
        let zero = wo.z.same(0.0);
        self.masking(wo, Vector::new(zero, zero, wo.z.same(1.0))) / (4.0 * wo.z)
    }

    /// `D(m) G1(v)`, where `m` is the direction of `half`, which need not have unit length. `v` and
    /// `half` are above the surface and at less than 90 degrees to each other.
    #[inline(always)]
    pub(in crate::bsdf) fn visible_density(&self, v: Vector<S>, half: Vector<S>) -> Float<S> {
        match self.distribution {
            // One fraction and no normalization: a division is as expensive as the rest.
            Distribution::Ggx => {
                let length2 = half.length_squared();
                let slope2 = (Pair::new(half.x, half.y) * self.inv_alpha).length_squared();
                let spread = half.z.mul_add(half.z, slope2);
                let masked2 = (Pair::new(v.x, v.y) * self.alpha).length_squared();
                let masking = v.z + v.z.mul_add(v.z, masked2).sqrt();
                let scale = self.inv_alpha.x * self.inv_alpha.y * FRAC_2_PI;
                scale * v.z * length2 * length2 / (spread * spread * masking)
            }
            Distribution::Beckmann => {
                let m = half.normalize();
                self.density(m) * self.masking(v, m)
            }
        }
    }

    /// The facets that reflect light from `wi` to `wo`; `wo` is above the surface.
    #[inline(always)]
    pub(in crate::bsdf) fn reflection(&self, wi: Vector<S>, wo: Vector<S>) -> FacetReflection<S> {
        let half = wi + wo;
        let density = self.visible_density(wi, half);
        // For light from below, the half vector may be zero.
        let lit = wi.z.gt(0.0);
        FacetReflection {
            density: lit.select(density, 0.0),
            // |wi + wo| = 2 wo·m for unit vectors.
            cos: lit.select(0.5 * half.length(), 1.0),
        }
    }

    /// Density per solid angle of the direction reflected at a facet from [`Microfacets::sample`]:
    /// its density over the Jacobian `4 |v·m|`, which is `D(m) G1(v) / (4 cosθ_v)`.
    #[inline(always)]
    pub(in crate::bsdf) fn reflected_pdf(&self, v: Vector<S>, m: Vector<S>) -> Float<S> {
        self.density(m) * self.masking(v, m) / (4.0 * v.z.abs())
    }

    /// A facet normal visible from `v`, for `v.z > 0`.
    #[inline(always)]
    pub(in crate::bsdf) fn sample(&self, v: Vector<S>, u: Pair<S>) -> Vector<S> {
        // Stretches to roughness 1, samples a slope, and stretches back.
        let stretched = Vector::new(self.alpha.x * v.x, self.alpha.y * v.y, v.z).normalize();
        let sin2 = Pair::new(stretched.x, stretched.y).length_squared();
        let is_slanted = sin2.gt(0.0);
        let inv_sin = is_slanted.select(sin2, 1.0).sqrt().recip();
        let cos_phi = is_slanted.select(stretched.x * inv_sin, 1.0);
        let sin_phi = is_slanted.select(stretched.y * inv_sin, 0.0);
        let slope = match self.distribution {
            Distribution::Ggx => ggx_visible_slope(stretched.z, u),
            Distribution::Beckmann => beckmann_visible_slope(stretched.z, u),
        };
        let x = (cos_phi * slope.x - sin_phi * slope.y) * self.alpha.x;
        let y = (sin_phi * slope.x + cos_phi * slope.y) * self.alpha.y;
        Vector::new(-x, -y, x.same(1.0)).normalize()
    }
}

lanewise!(Microfacets { alpha, inv_alpha; distribution });

/// The microfacets with the half vector of two directions as normal `m`.
pub(in crate::bsdf) struct FacetReflection<S: Width> {
    /// `D(m) G1(wi)`; 0 for light from below.
    pub(in crate::bsdf) density: Float<S>,
    /// Cosine between `m` and the directions; 1 for light from below.
    pub(in crate::bsdf) cos: Float<S>,
}

/// Bounds of [`FacetReflection`] over a cone of directions.
pub(in crate::bsdf) struct FacetBound {
    /// Upper bound of the density.
    pub(in crate::bsdf) density: f32,
    /// Smallest and largest cosine.
    pub(in crate::bsdf) cosines: [f32; 2],
}

/// Upper bounds.
impl Microfacets<One> {
    /// Bounds of [`Microfacets::reflection`] over a cone of `wi`.
    #[inline(always)]
    pub(in crate::bsdf) fn reflection_bound(
        &self,
        incident: &IncidentCone,
        wo: Vec3,
    ) -> FacetBound {
        let halves = incident.halves(wo);
        FacetBound {
            density: self.projected_bound(halves.highest, incident),
            cosines: halves.cosines,
        }
    }

    /// Upper bound of [`Microfacets::visible_density`] for facet normals with cosines up to
    /// `highest` and directions with cosines up to `cos`.
    #[inline(always)]
    pub(in crate::bsdf) fn visible_bound(&self, highest: f32, cos: f32) -> f32 {
        let [alpha, inv_alpha] =
            [self.alpha, self.inv_alpha].map(|pair| Vec2::new(pair.x.get(), pair.y.get()));
        let scale = inv_alpha.x * inv_alpha.y * FRAC_1_PI;
        // With the larger roughness along both axes.
        let alpha2 = (alpha.x * alpha.x).max(alpha.y * alpha.y);
        let cos2 = highest * highest;
        let bound = match self.distribution {
            Distribution::Ggx => {
                let spread = if alpha2 < 1.0 {
                    (1.0 - cos2) / alpha2 + cos2
                } else {
                    alpha2.recip()
                };
                let masked2 = self.min_alpha().get().powi(2) * (1.0 - cos * cos);
                let masking = 2.0 * cos / (cos + (cos * cos + masked2).sqrt());
                scale * masking / (spread * spread)
            }
            Distribution::Beckmann => {
                // exp(-t/α²) (1 + t)² with t = tan²θ increases up to t = 2α² - 1. It is negligible
                // beyond t = 10⁴.
                let t = ((1.0 - cos2) / cos2).min(1e4).max(2.0 * alpha2 - 1.0);
                scale * exp(-t / alpha2) * (1.0 + t).powi(2)
            }
        };
        if highest > 0.0 && cos > 0.0 {
            bound
        } else {
            0.0
        }
    }

    /// [`Microfacets::visible_bound`] over a cone of directions. If the cone has its own projected
    /// cosine, the bound is for the density over the cosine to the normal times that projected
    /// cosine.
    #[inline(always)]
    pub(in crate::bsdf) fn projected_bound(&self, highest: f32, incident: &IncidentCone) -> f32 {
        let [lowest, cos] = incident.cosines();
        match incident.projected {
            None => self.visible_bound(highest, cos),
            Some(_) if cos <= 0.0 => 0.0,
            Some(projected) => {
                self.visible_bound(highest, 1.0)
                    * self.masking_per_cosine(lowest.max(0.0))
                    * projected
            }
        }
    }

    /// Upper bound of `G1(v)` over the cosine of `v`, for cosines of at least `lowest`.
    #[inline(always)]
    fn masking_per_cosine(&self, lowest: f32) -> f32 {
        match self.distribution {
            Distribution::Ggx => {
                let masked2 = self.min_alpha().get().min(1.0).powi(2) * (1.0 - lowest * lowest);
                2.0 / (lowest + (lowest * lowest + masked2).sqrt())
            }
            // The fit is below 1, used for angles up to 45 degrees, and below 3.535 cosθ / (α
            // sinθ), used beyond.
            Distribution::Beckmann => lowest
                .recip()
                .min((5.0 / self.min_alpha().get()).max(std::f32::consts::SQRT_2)),
        }
    }
}

/// A visible slope of a GGX surface of roughness 1, for a direction in the xz plane with the given
/// cosine.
#[inline(always)]
fn ggx_visible_slope<S: Width>(cos: Float<S>, u: Pair<S>) -> Pair<S> {
    // The visible part of the hemisphere of normals projects to a half disc and a half ellipse.
    let p = disc(u);
    let s = 0.5 * (1.0 + cos);
    let y = (1.0 - p.x * p.x).safe_sqrt() * (1.0 - s) + p.y * s;
    let z = (1.0 - Pair::new(p.x, y).length_squared()).safe_sqrt();
    let sin = (1.0 - cos * cos).safe_sqrt();
    Pair::new(cos * y - sin * z, p.x) * (sin * y + cos * z).recip()
}

/// A visible slope of a Beckmann surface of roughness 1, for a direction in the xz plane with the
/// given cosine.
#[inline(always)]
fn beckmann_visible_slope<S: Width>(cos: Float<S>, u: Pair<S>) -> Pair<S> {
    let inv_sqrt_pi = PI.sqrt().recip();
    let tan = (1.0 - cos * cos).safe_sqrt() / cos;
    let cot = tan.recip();
    // The cumulative distribution of the slope along x is inverted over the variable erf(slope),
    // where it is nearly linear.
    let x_max = erf(cot);
    let u_x = u.x.clamp(1e-6, 1.0 - 1e-6);
    let u_y = u.y.clamp(1e-6, 1.0 - 1e-6);
    // An initial value that is exact at grazing angles, where the distribution is least linear.
    let mut x = x_max - (x_max + 1.0) * erf((-u_x.ln()).sqrt());
    let total = u_x * (1.0 + x_max + inv_sqrt_pi * tan * (-cot * cot).exp());
    // The derivative vanishes at x_max; three steps of Newton's method suffice from this start.
    for _ in 0..3 {
        let slope = erf_inv(x);
        let value = 1.0 + x + inv_sqrt_pi * tan * (-slope * slope).exp() - total;
        x = (x - value / (1.0 - slope * tan)).clamp(-0.999_999_9, x_max);
    }
    Pair::new(erf_inv(x), erf_inv(2.0 * u_y - 1.0))
}

/// The error function. Source: Abramowitz and Stegun, "Handbook of Mathematical Functions", 7.1.26;
/// absolute error below 1.5e-7.
#[inline(always)]
fn erf<S: Width>(x: Float<S>) -> Float<S> {
    let t = 1.0 / (1.0 + 0.327_591_1 * x.abs());
    let poly = t
        * (0.254_829_6
            + t * (-0.284_496_72 + t * (1.421_413_8 + t * (-1.453_152_1 + t * 1.061_405_4))));
    (1.0 - poly * (-x * x).exp()).copysign(x)
}

/// The inverse error function. Source: Giles, "Approximating the erfinv Function", GPU Computing
/// Gems, 2011 (single precision).
#[inline(always)]
fn erf_inv<S: Width>(x: Float<S>) -> Float<S> {
    let w = -((1.0 - x) * (1.0 + x)).ln();
    let is_central = w.lt(5.0);
    let t = is_central.select(w - 2.5, w.sqrt() - 3.0);
    let mut sum = t.same(0.0);
    for (central, tail) in CENTRAL.into_iter().zip(TAIL) {
        sum = sum.mul_add(t, is_central.select(central, tail));
    }
    sum * x
}

/// Coefficients of [`erf_inv`] for the center of the interval.
const CENTRAL: [f32; 9] = [
    2.810_226_4e-8,
    3.432_739_4e-7,
    -3.523_387_7e-6,
    -4.391_506_5e-6,
    0.000_218_580_87,
    -0.001_253_725,
    -0.004_177_681_6,
    0.246_640_73,
    1.501_409_4,
];
/// Coefficients of [`erf_inv`] for the ends of the interval.
const TAIL: [f32; 9] = [
    -0.000_200_214_26,
    0.000_100_950_56,
    0.001_349_343_2,
    -0.003_673_428_4,
    0.005_739_507_7,
    -0.007_622_461_3,
    0.009_438_870_5,
    1.001_674,
    2.832_976_8,
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::warp;

    #[test]
    fn error_function_and_its_inverse() {
        for (x, y) in [
            (0.0, 0.0),
            (0.5, 0.520_499_9),
            (1.0, 0.842_700_8),
            (2.0, 0.995_322_3),
        ] {
            let (erf, erf_inv) = (
                |x: f32| erf(Float::from(x)).get(),
                |x: f32| erf_inv(Float::from(x)).get(),
            );
            assert!((erf(x) - y).abs() < 5e-7, "erf({x})");
            assert!((erf(-x) + y).abs() < 5e-7, "erf(-{x})");
            assert!((erf_inv(y) - x).abs() < 2e-5, "erf_inv({y})");
        }
    }

    #[test]
    fn visible_density_is_the_product() {
        for distribution in [Distribution::Ggx, Distribution::Beckmann] {
            for alpha in [[1e-3, 2e-3], [0.1, 0.3], [1.0, 0.5]] {
                let facets = Microfacets::new(distribution, alpha[0].into(), alpha[1].into());
                for i in 0..500 {
                    let u = |k: usize| (0.5 + (i * k) as f32 * 0.618_034) % 1.0;
                    let v = Vector::<One>::from(warp::cosine_hemisphere(Vec2::new(u(1), u(7))));
                    let w = Vector::from(warp::cosine_hemisphere(Vec2::new(u(3), u(5))));
                    let m = (v + w).normalize();
                    let product = (facets.density(m) * facets.masking(v, m)).get();
                    let value = facets.visible_density(v, v + w).get();
                    let relative = (value - product).abs() / product.max(1e-12);
                    assert!(relative < 2e-5, "{distribution:?}: {value} and {product}");
                }
            }
        }
    }

    #[test]
    fn projected_microfacets_cover_the_surface() {
        // ∫ D(m) cosθ_m dm = 1 by the midpoint rule over slopes: dm = cos³θ d²slope.
        for distribution in [Distribution::Ggx, Distribution::Beckmann] {
            let facets = Microfacets::<One>::new(distribution, 0.3.into(), 0.5.into());
            let n = 400;
            let mut sum = 0.0f64;
            for i in 0..n * n {
                // tan((u - 1/2) π) reaches the tails of the slope distribution.
                let slope = [i % n, i / n].map(|k| {
                    (((k as f64 + 0.5) / f64::from(n) - 0.5) * std::f64::consts::PI).tan()
                });
                let stretch = std::f64::consts::PI.powi(2)
                    * (1.0 + slope[0].powi(2))
                    * (1.0 + slope[1].powi(2));
                let m = Vec3::new(-slope[0] as f32, -slope[1] as f32, 1.0).normalize();
                sum += f64::from(facets.density(m.into()).get()) * f64::from(m.z).powi(4) * stretch;
            }
            sum /= f64::from(n * n);
            assert!((sum - 1.0).abs() < 2e-3, "{distribution:?}: {sum}");
        }
    }
}
