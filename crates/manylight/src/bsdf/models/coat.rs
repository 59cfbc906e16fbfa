//! Tables of rough dielectric coats: transmittance from outside, reflectance from inside.

use super::fresnel::{self, Interface, reflect, refract};
use super::microfacet::Microfacets;
use crate::bsdf::material::Distribution;
use crate::lanes::{Float, One, Pair, Vector, Width};
use rayon::prelude::*;

/// Quadrature points per dimension for light into a denser medium; an even number. Not measured.
const NODES: usize = 32;
/// Quadrature points per dimension for light into a thinner medium; an even number. Total reflection makes the integrand
/// discontinuous; with 64 points the error is below 10⁻³.
const NODES_WITH_TOTAL_REFLECTION: usize = 64;
/// Cosine that replaces 0, where the distribution of visible normals has no limit.
const MIN_COSINE: f32 = 1e-6;

/// Tables of a rough coat.
#[derive(Debug)]
pub(in crate::bsdf) struct Coat {
    /// Transmittance from outside over the cosine on [0, 1].
    pub transmittance: [f32; COSINES],
    /// Reflectance from inside, averaged over diffuse light.
    pub internal_reflectance: f32,
}

/// Entries of a table over the cosine on [0, 1], with linear interpolation. Not measured.
pub const COSINES: usize = 64;

/// Linear interpolation in a table.
#[inline(always)]
pub(in crate::bsdf) fn interpolate<S: Width>(table: &[f32; COSINES], cos: Float<S>) -> Float<S> {
    interpolate_tables(&cos.width().each(|_| table), cos)
}

/// Linear interpolation in one table per lane.
#[inline(always)]
pub(in crate::bsdf) fn interpolate_tables<S: Width>(
    tables: &S::Each<&[f32; COSINES]>,
    cos: Float<S>,
) -> Float<S> {
    // The factor makes a cosine of 1 lie between the last two entries.
    let at = cos.clamp(0.0, 1.0) * ((COSINES - 1) as f32 * (1.0 - f32::EPSILON));
    let below = at.floor();
    let (s, index) = (at.width(), below.to_word().store());
    let entry =
        |i: usize, step: usize| tables.as_ref()[i][(index.as_ref()[i] as usize + step) % COSINES];
    let low = Float::from_fn(s, |i| entry(i, 0));
    let high = Float::from_fn(s, |i| entry(i, 1));
    (at - below).mul_add(high - low, low)
}

impl Coat {
    /// Tabulates a coat with index `eta` relative to the outside.
    pub(in crate::bsdf) fn new(distribution: Distribution, alpha: f32, eta: f32) -> Self {
        let facets = Microfacets::new(distribution, alpha.into(), alpha.into());
        let cosines: Vec<f32> = (0..COSINES)
            .map(|i| (i as f32 / (COSINES - 1) as f32).max(MIN_COSINE))
            .collect();
        let transmittance = average(&cosines, &facets, eta, transmitted);
        // Over cosine-weighted directions: 2 ∫ r(μ) μ dμ.
        let reflectance = average(&cosines, &facets, 1.0 / eta, reflected);
        let sum: f32 = cosines.iter().zip(&reflectance).map(|(c, r)| c * r).sum();
        Coat {
            transmittance: transmittance
                .try_into()
                .expect("invariant: one value per cosine"),
            internal_reflectance: 2.0 * sum / COSINES as f32,
        }
    }
}

/// Fraction of light that a visible facet reflects or transmits: of microfacets, direction, facet normal, interface.
type FacetEvent = fn(&Microfacets<One>, Vector<One>, Vector<One>, &Interface<One>) -> Float<One>;

fn reflected(
    facets: &Microfacets<One>,
    w: Vector<One>,
    m: Vector<One>,
    interface: &Interface<One>,
) -> Float<One> {
    let out = reflect(w, m);
    let unmasked = interface.reflectance * facets.masking(out, m);
    out.z.gt(0.0).select(unmasked, 0.0)
}

fn transmitted(
    facets: &Microfacets<One>,
    w: Vector<One>,
    m: Vector<One>,
    interface: &Interface<One>,
) -> Float<One> {
    let out = refract(w, m, interface);
    let unmasked = (1.0 - interface.reflectance) * facets.masking(out, m);
    out.z.lt(0.0).select(unmasked, 0.0)
}

/// The mean of `event` over the visible facets, for each cosine.
///
/// The integrand is symmetric to the plane of incidence, and mirroring one random number mirrors the facet. So half of the points in
/// that dimension are evaluated.
fn average(cosines: &[f32], facets: &Microfacets<One>, eta: f32, event: FacetEvent) -> Vec<f32> {
    let rule = gauss_legendre(if eta > 1.0 {
        NODES
    } else {
        NODES_WITH_TOTAL_REFLECTION
    });
    let mean = |&cos: &f32| {
        let w = Vector::new((1.0 - cos * cos).sqrt().into(), 0.0.into(), cos.into());
        let mut sum = 0.0f64;
        for &(mirrored, weight_mirrored) in &rule[..rule.len() / 2] {
            for &(other, weight) in &rule {
                let u = match facets.distribution() {
                    Distribution::Ggx => Pair::new(mirrored.into(), other.into()),
                    Distribution::Beckmann => Pair::new(other.into(), mirrored.into()),
                };
                let m = facets.sample(w, u);
                let interface = fresnel::dielectric(w.dot(m), eta.into());
                let value = event(facets, w, m, &interface).get();
                sum += f64::from(value * weight_mirrored * weight);
            }
        }
        (2.0 * sum) as f32
    };
    cosines.par_iter().map(mean).collect()
}

/// Nodes and weights of Gauss-Legendre quadrature on [0, 1].
fn gauss_legendre(n: usize) -> Vec<(f32, f32)> {
    let count = n as f64;
    (0..n)
        .map(|i| {
            // Newton's method from Tricomi's initial value.
            let mut x = -(std::f64::consts::PI * (i as f64 + 0.75) / (count + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..8 {
                let (mut p0, mut p1) = (1.0, x);
                for k in 2..=n {
                    let k = k as f64;
                    (p0, p1) = (p1, ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k);
                }
                slope = count * (x * p1 - p0) / (x * x - 1.0);
                x -= p1 / slope;
            }
            let weight = 2.0 / ((1.0 - x * x) * slope * slope);
            ((0.5 * (x + 1.0)) as f32, (0.5 * weight) as f32)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Vec2, Vec3};

    #[test]
    fn quadrature_is_exact_for_polynomials() {
        let rule = gauss_legendre(32);
        let integral: f64 = rule
            .iter()
            .map(|&(x, w)| f64::from(w) * f64::from(x).powi(20))
            .sum();
        assert!((integral - 1.0 / 21.0).abs() < 1e-6, "{integral}");
    }

    #[test]
    fn mirrored_numbers_give_mirrored_facets() {
        let w = Vector::from(Vec3::new(0.6, 0.0, 0.8));
        for distribution in [Distribution::Ggx, Distribution::Beckmann] {
            let facets = Microfacets::new(distribution, 0.4.into(), 0.4.into());
            for i in 0..100 {
                let u = Vec2::new((i % 10) as f32 + 0.4, (i / 10) as f32 + 0.3) / 10.0;
                let mirrored = match distribution {
                    Distribution::Ggx => Vec2::new(1.0 - u.x, u.y),
                    Distribution::Beckmann => Vec2::new(u.x, 1.0 - u.y),
                };
                let sample = |u: Vec2| Vec3::from(facets.sample(w, u.into()));
                let (a, b) = (sample(u), sample(mirrored));
                assert!(
                    (a - b * Vec3::new(1.0, -1.0, 1.0)).length() < 1e-4,
                    "{a} {b}"
                );
            }
        }
    }

    #[test]
    fn a_nearly_smooth_coat_transmits_what_fresnel_says() {
        let coat = Coat::new(Distribution::Ggx, 1e-3, 1.5);
        for i in [20, 40, 63] {
            let cos: Float<One> = (i as f32 / 63.0).into();
            let expected = fresnel::coat_transmittance(cos, 1.5).get();
            assert!((coat.transmittance[i] - expected).abs() < 1e-3);
        }
        assert!((coat.internal_reflectance - fresnel::diffuse_reflectance(1.0 / 1.5)).abs() < 0.02);
    }
}
