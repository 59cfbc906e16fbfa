//! Tables of rough coats: how much light enters one, and how much stays under it.

use super::fresnel::{self, Interface, reflect, refract};
use super::material::Distribution;
use super::microfacet::Microfacets;
use super::plastic::{COSINES, Coat};
use crate::math::{Vec2, Vec3};
use rayon::prelude::*;

/// Points of the quadrature per dimension towards a denser medium; even.
const NODES: usize = 32;
/// The same towards a thinner one, where total reflection makes the integrand jump: the error stays below 10⁻³.
const NODES_WITH_TOTAL_REFLECTION: usize = 64;
/// Stands for grazing incidence, where the distribution of visible normals has no limit.
const MIN_COSINE: f32 = 1e-6;

impl Coat {
    /// Tabulates a coat of relative index `eta`.
    pub(super) fn new(distribution: Distribution, alpha: f32, eta: f32) -> Self {
        let facets = Microfacets::new(distribution, alpha, alpha);
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

/// What one visible facet does with light: direction, facet normal, interface -> fraction.
type FacetEvent = fn(&Microfacets, Vec3, Vec3, &Interface) -> f32;

fn reflected(facets: &Microfacets, w: Vec3, m: Vec3, interface: &Interface) -> f32 {
    let out = reflect(w, m);
    if out.z > 0.0 {
        interface.reflectance * facets.masking(out, m)
    } else {
        0.0
    }
}

fn transmitted(facets: &Microfacets, w: Vec3, m: Vec3, interface: &Interface) -> f32 {
    let out = refract(w, m, interface);
    if out.z < 0.0 {
        (1.0 - interface.reflectance) * facets.masking(out, m)
    } else {
        0.0
    }
}

/// The mean of `event` over the facets visible at each cosine.
///
/// Facets on both sides of the plane of incidence do the same, and the samples of one side are those of the other with one
/// number mirrored: half of the nodes in that dimension tell all.
fn average(cosines: &[f32], facets: &Microfacets, eta: f32, event: FacetEvent) -> Vec<f32> {
    let rule = gauss_legendre(if eta > 1.0 {
        NODES
    } else {
        NODES_WITH_TOTAL_REFLECTION
    });
    let mean = |&cos: &f32| {
        let w = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
        let mut sum = 0.0f64;
        for &(mirrored, weight_mirrored) in &rule[..rule.len() / 2] {
            for &(other, weight) in &rule {
                let u = match facets.distribution() {
                    Distribution::Ggx => Vec2::new(mirrored, other),
                    Distribution::Beckmann => Vec2::new(other, mirrored),
                };
                let m = facets.sample(w, u);
                let interface = fresnel::dielectric(w.dot(m), eta);
                sum += f64::from(event(facets, w, m, &interface) * weight_mirrored * weight);
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
            // Newton's method from Tricomi's guess.
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
        let w = Vec3::new(0.6, 0.0, 0.8);
        for distribution in [Distribution::Ggx, Distribution::Beckmann] {
            let facets = Microfacets::new(distribution, 0.4, 0.4);
            for i in 0..100 {
                let u = Vec2::new((i % 10) as f32 + 0.4, (i / 10) as f32 + 0.3) / 10.0;
                let mirrored = match distribution {
                    Distribution::Ggx => Vec2::new(1.0 - u.x, u.y),
                    Distribution::Beckmann => Vec2::new(u.x, 1.0 - u.y),
                };
                let (a, b) = (facets.sample(w, u), facets.sample(w, mirrored));
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
            let expected = fresnel::coat_transmittance(i as f32 / 63.0, 1.5);
            assert!((coat.transmittance[i] - expected).abs() < 1e-3);
        }
        assert!((coat.internal_reflectance - fresnel::diffuse_reflectance(1.0 / 1.5)).abs() < 0.02);
    }
}
