//! Maps from the unit square to other domains, with their densities.

use crate::math::trig::{sin_cos_octant, sin_cos_turns};
use crate::math::{Vec2, Vec3, float::safe_sqrt};
use std::f32::consts::{FRAC_1_PI, FRAC_PI_4, TAU};

/// A point of the unit disk, uniform by area. The map is continuous.
///
/// Source: Shirley and Chiu, "A Low Distortion Map", 1997.
#[inline]
pub fn disc(u: Vec2) -> Vec2 {
    let p = u * 2.0 - Vec2::ONE;
    if p == Vec2::ZERO {
        return Vec2::ZERO;
    }
    // Angles relative to the nearer axis stay within an octant.
    let along_x = p.x.abs() > p.y.abs();
    let (r, across) = if along_x { (p.x, p.y) } else { (p.y, p.x) };
    let (sin, cos) = sin_cos_octant(FRAC_PI_4 * (across / r));
    Vec2::from(if along_x { (cos, sin) } else { (sin, cos) }) * r
}

/// A direction of the upper hemisphere with density cosθ/π.
#[inline]
pub fn cosine_hemisphere(u: Vec2) -> Vec3 {
    let d = disc(u);
    d.extend(safe_sqrt(1.0 - d.length_squared()))
}

/// Density of [`cosine_hemisphere`] per solid angle.
#[inline]
pub fn cosine_hemisphere_pdf(cos_theta: f32) -> f32 {
    cos_theta.max(0.0) * FRAC_1_PI
}

/// A direction of the sphere, uniform: density 1/(4π).
#[inline]
pub fn sphere(u: Vec2) -> Vec3 {
    let z = 1.0 - 2.0 * u.y;
    polar(z, safe_sqrt(1.0 - z * z), u.x)
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
    /// Mean cosine below which the distribution counts as uniform: the inversion would lose precision.
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

/// A point of a triangle, uniform by area, as barycentric coordinates of the second and third corner.
///
/// Source: Heitz, "A Low-Distortion Map", 2019.
#[inline]
pub fn triangle(u: Vec2) -> Vec2 {
    if u.x < u.y {
        Vec2::new(u.x * 0.5, u.y - u.x * 0.5)
    } else {
        Vec2::new(u.x - u.y * 0.5, u.y * 0.5)
    }
}

/// The direction at height `z` and distance `r` from the z axis; the azimuth is `turn` full turns.
#[inline]
fn polar(z: f32, r: f32, turn: f32) -> Vec3 {
    let (sin, cos) = sin_cos_turns(turn);
    Vec3::new(r * cos, r * sin, z)
}
