//! Dielectric coats over diffuse bases, for formats whose coats differ from Mitsuba's
//! `roughplastic`.

use glam::DVec3;
use std::f64::consts::TAU;

/// Reflectance of a dielectric of relative index `eta` at the cosine `cos` to the normal, for
/// unpolarized light.
pub fn reflectance(cos: f64, eta: f64) -> f64 {
    let sin2 = (1.0 - cos * cos) / (eta * eta);
    if sin2 >= 1.0 {
        return 1.0;
    }
    let t = (1.0 - sin2).sqrt();
    let s = (cos - eta * t) / (cos + eta * t);
    let p = (t - eta * cos) / (t + eta * cos);
    0.5 * (s * s + p * p)
}

/// Steps of the quadratures in one dimension. The results change by less than 10⁻³ with twice as
/// many.
const STEPS: usize = 48;

/// Entries of Mitsuba's table over the cosine, the mean of which it takes as the reflectance for
/// diffuse light. It is smaller than the integral by 1/64.
const COSINES: usize = 64;

/// Midpoints of `count` equal parts of (0, 1).
fn midpoints(count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |i| (i as f64 + 0.5) / count as f64)
}

/// What a rough dielectric coat does to diffuse light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    /// Index of refraction.
    pub ior: f64,
    /// Transmittance from outside.
    pub entrance: f64,
    /// Reflectance from inside, as Mitsuba takes its mean.
    pub inside: f64,
}

impl Coat {
    /// A coat of GGX facets of roughness `alpha`, with single scattering among them.
    pub fn new(alpha: f64, ior: f64) -> Coat {
        let mut entrance = 0.0;
        for cos in midpoints(STEPS) {
            let mean = facet_mean(alpha, cos, |w, m| transmitted(alpha, ior, w, m));
            entrance += 2.0 * cos * mean / STEPS as f64;
        }
        let mut inside = 0.0;
        for i in 1..COSINES {
            let cos = i as f64 / (COSINES - 1) as f64;
            let weight = 2.0 * cos / COSINES as f64;
            inside += weight * facet_mean(alpha, cos, |w, m| reflected(alpha, 1.0 / ior, w, m));
        }
        Coat {
            ior,
            entrance,
            inside,
        }
    }

    /// The reflectance of a base in PBRT that gives the light of `reflectance` in Mitsuba. In PBRT,
    /// light that the coat reflects back to the base is colored at each reflection; in Mitsuba,
    /// with `nonlinear = false`, it is not.
    pub fn pbrt_base(&self, reflectance: f64) -> f64 {
        reflectance / (1.0 - self.inside + reflectance * self.inside)
    }

    /// The factor of the base color with which a glTF dielectric has the diffuse albedo of a coated
    /// base in Mitsuba.
    pub fn gltf_factor(&self) -> f64 {
        let coated = self.entrance.powi(2) / (self.ior.powi(2) * (1.0 - self.inside));
        coated / (1.0 - half_vector_reflectance(self.ior))
    }
}

/// The mean of `event` over the facets that are visible at the cosine `cos`, by Heitz, "Sampling
/// the GGX Distribution of Visible Normals", JCGT 2018.
fn facet_mean(alpha: f64, cos: f64, event: impl Fn(DVec3, DVec3) -> f64) -> f64 {
    let w = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let stretched = DVec3::new(alpha * w.x, 0.0, w.z).normalize();
    let across = DVec3::Y;
    let up = stretched.cross(across);
    let s = 0.5 * (1.0 + stretched.z);
    let mut sum = 0.0;
    for radius in midpoints(STEPS).map(f64::sqrt) {
        for turn in midpoints(STEPS) {
            let (x, y) = (radius * (TAU * turn).cos(), radius * (TAU * turn).sin());
            let y = (1.0 - s) * (1.0 - x * x).max(0.0).sqrt() + s * y;
            let z = (1.0 - x * x - y * y).max(0.0).sqrt();
            let n = across * x + up * y + stretched * z;
            let m = DVec3::new(alpha * n.x, alpha * n.y, n.z.max(0.0)).normalize();
            sum += event(w, m);
        }
    }
    sum / (STEPS * STEPS) as f64
}

/// Fraction of the facets that are visible at the cosine `cos`.
fn masking(alpha: f64, cos: f64) -> f64 {
    let tan2 = (1.0 - cos * cos) / (cos * cos);
    2.0 / (1.0 + (1.0 + alpha * alpha * tan2).sqrt())
}

/// Fraction of light from `w` that the facet `m` reflects away from the surface.
fn reflected(alpha: f64, eta: f64, w: DVec3, m: DVec3) -> f64 {
    let cos = w.dot(m);
    let out = m * (2.0 * cos) - w;
    if out.z <= 0.0 {
        return 0.0;
    }
    reflectance(cos, eta) * masking(alpha, out.z)
}

/// Fraction of light from `w` that the facet `m` refracts into the surface.
fn transmitted(alpha: f64, eta: f64, w: DVec3, m: DVec3) -> f64 {
    let cos = w.dot(m);
    let refracted = (1.0 - (1.0 - cos * cos) / (eta * eta)).sqrt();
    let out = m * (cos / eta - refracted) - w / eta;
    if out.z >= 0.0 {
        return 0.0;
    }
    (1.0 - reflectance(cos, eta)) * masking(alpha, -out.z)
}

/// The mean of F at the half vector of two directions, both weighted by their cosines: the part of
/// diffuse light that a glTF dielectric keeps from its base.
fn half_vector_reflectance(eta: f64) -> f64 {
    let mut sum = 0.0;
    // Cosine-weighted directions have uniform squared cosines.
    for a in midpoints(STEPS) {
        for b in midpoints(STEPS) {
            for turn in midpoints(STEPS) {
                let sines = ((1.0 - a) * (1.0 - b)).sqrt();
                let cos = (a * b).sqrt() + sines * (0.5 * TAU * turn).cos();
                sum += reflectance((0.5 + 0.5 * cos).max(0.0).sqrt(), eta);
            }
        }
    }
    sum / (STEPS as f64).powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Roughness, index of refraction, and the reflectance from inside for diffuse light, from
    /// values of `roughplastic` with and without `nonlinear` in Mitsuba 3.9.1.
    const COATS: [(f64, f64, f64); 4] = [
        (0.05, 1.5, 0.5761),
        (0.2, 1.5, 0.4863),
        (0.4, 1.5, 0.3482),
        (0.04, 1.33, 0.4567),
    ];

    #[test]
    fn reflectances_are_those_of_the_literature() {
        assert!((reflectance(1.0, 1.5) - 0.04).abs() < 1e-12);
        // Egan and Hilgeman 1973: 0.0918 from outside, 0.5963 from inside.
        let smooth = Coat::new(1e-3, 1.5);
        assert!(
            (smooth.entrance - (1.0 - 0.0918)).abs() < 1e-3,
            "{smooth:?}"
        );
        let inside = smooth.inside * 64.0 / 63.0;
        assert!((inside - 0.5963).abs() < 3e-3, "{inside}");
        let half = half_vector_reflectance(1.5);
        assert!(half > 0.04 && half < 0.0918, "{half}");
    }

    #[test]
    fn coats_are_those_of_mitsuba() {
        for (alpha, ior, inside) in COATS {
            let coat = Coat::new(alpha, ior);
            assert!(
                (coat.inside - inside).abs() < 2e-3,
                "{coat:?}, expected {inside}"
            );
        }
    }

    #[test]
    fn interreflection_changes_neither_black_nor_white() {
        let coat = Coat::new(0.2, 1.5);
        for reflectance in [0.0, 1.0] {
            assert!((coat.pbrt_base(reflectance) - reflectance).abs() < 1e-12);
        }
        let base = coat.pbrt_base(0.5);
        let colored = base / (1.0 - base * coat.inside);
        assert!((colored - 0.5 / (1.0 - coat.inside)).abs() < 1e-12);
    }

    #[test]
    fn a_gltf_dielectric_needs_a_darker_base() {
        let [smooth, rough] = [0.05, 0.5].map(|alpha| Coat::new(alpha, 1.5).gltf_factor());
        assert!(smooth > 0.9 && smooth < 1.0, "{smooth}");
        assert!(rough > 0.4 && rough < smooth, "{rough}");
    }
}
