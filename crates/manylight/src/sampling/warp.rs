//! Maps from the unit square to other domains, with their densities. Those that [`lanes`] has are
//! these with one lane.

use crate::lanes::{self, Float, One, Pair};
use crate::math::{Vec2, Vec3, float::safe_sqrt};
use std::f32::consts::{FRAC_1_PI, TAU};

/// A point of the unit disk, uniform by area. The map is continuous.
///
/// Source: Shirley and Chiu, "A Low Distortion Map", 1997.
#[inline]
pub fn disc(u: Vec2) -> Vec2 {
    lanes::disc(Pair::<One>::from(u)).into()
}

/// A direction of the upper hemisphere with density cosθ/π.
#[inline]
pub fn cosine_hemisphere(u: Vec2) -> Vec3 {
    lanes::cosine_hemisphere(Pair::<One>::from(u)).into()
}

/// Density of [`cosine_hemisphere`] per solid angle.
#[inline]
pub fn cosine_hemisphere_pdf(cos_theta: f32) -> f32 {
    lanes::cosine_hemisphere_pdf(Float::<One>::from(cos_theta)).get()
}

/// A direction of the sphere, uniform: density 1/(4π).
#[inline]
pub fn sphere(u: Vec2) -> Vec3 {
    lanes::sphere(Pair::<One>::from(u)).into()
}

/// Density of [`sphere`] per solid angle.
pub const SPHERE_PDF: f32 = 0.25 * FRAC_1_PI;

/// A direction of the cone around z, uniform. `cos_max` is the cosine of the half angle.
#[inline]
pub fn cone(u: Vec2, cos_max: f32) -> Vec3 {
    let z = 1.0 - u.y * (1.0 - cos_max);
    polar(z, safe_sqrt(1.0 - z * z), u.x)
}

/// Density of [`cone`] per solid angle.
#[inline]
pub fn cone_pdf(cos_max: f32) -> f32 {
    1.0 / (TAU * (1.0 - cos_max))
}

/// A direction of the von Mises-Fisher lobe of concentration `kappa` > 0 around z.
///
/// Source: Jakob, "Numerically Stable Sampling of the von Mises-Fisher Distribution on S²", 2012.
#[inline]
pub fn von_mises_fisher(u: Vec2, kappa: f32) -> Vec3 {
    let z = 1.0
        + (u.y + (1.0 - u.y) * (-2.0 * kappa).exp())
            .max(f32::MIN_POSITIVE)
            .ln()
            / kappa;
    let z = z.clamp(-1.0, 1.0);
    polar(z, safe_sqrt(1.0 - z * z), u.x)
}

/// Density of [`von_mises_fisher`] per solid angle, at the cosine `cos` to the axis.
#[inline]
pub fn von_mises_fisher_pdf(cos: f32, kappa: f32) -> f32 {
    kappa / (TAU * (1.0 - (-2.0 * kappa).exp())) * (kappa * (cos - 1.0)).exp()
}

/// A direction of the Henyey-Greenstein distribution around z with mean cosine `g` in [0, 1).
///
/// Source: Henyey and Greenstein, "Diffuse Radiation in the Galaxy", 1941.
#[inline]
pub fn henyey_greenstein(u: Vec2, g: f32) -> Vec3 {
    /// Mean cosine below which the distribution counts as uniform: the inversion would lose
    /// precision.
    const ISOTROPIC: f32 = 1e-3;
    let z = if g < ISOTROPIC {
        1.0 - 2.0 * u.y
    } else {
        let ratio = (1.0 - g * g) / (1.0 + g - 2.0 * g * u.y);
        (1.0 + g * g - ratio * ratio) / (2.0 * g)
    };
    let z = z.clamp(-1.0, 1.0);
    polar(z, safe_sqrt(1.0 - z * z), u.x)
}

/// A point of a triangle, uniform by area, as barycentric coordinates of the second and third
/// corner.
///
/// Source: Heitz, "A Low-Distortion Map", 2019.
#[inline]
pub fn triangle(u: Vec2) -> Vec2 {
    lanes::triangle(Pair::<One>::from(u)).into()
}

/// The direction at height `z` and distance `r` from the z axis; the azimuth is `turn` full turns.
#[inline]
fn polar(z: f32, r: f32, turn: f32) -> Vec3 {
    let (sin, cos) = Float::<One>::from(turn).sin_cos_turns();
    Vec3::new(r * cos.get(), r * sin.get(), z)
}
