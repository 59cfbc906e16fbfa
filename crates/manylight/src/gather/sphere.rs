//! A light as a sphere: its flux, spread over the directions under which a sphere around it is
//! seen.
//!
//! ```text
//! L = 1/(π r²) ∫_Ω f(w) |w·n| I(-w) dw
//! ```
//!
//! Ω holds the directions from the point to the sphere of radius r, all directions inside the
//! sphere. One shadow ray goes to the center. The integral is bounded however near the light is,
//! and converges to that of a point with `r / d`. Directions are sampled from three densities,
//! weighted by the balance heuristic: evenly from Ω, from a lobe like the reflection at the point,
//! and from a lobe like that at the light.
//!
//! Source: Hašan, Křivánek, Walter, Bala, "Virtual Spherical Lights for Many-Light Rendering of
//! Glossy Scenes", SIGGRAPH Asia 2009.

use super::receivers::{ConnectedLight, Direction, Receivers};
use super::sphere_samples::{LOBE_DIRECTIONS, MAX_DIRECTIONS, SphereSamples};
use crate::lanes::{Axes, Color, Float, Mask, Vector, Width};
use crate::virtual_lights::{RadiantIntensity, VirtualLight};
use std::f32::consts::{FRAC_1_PI, TAU};

/// Squared radius of the sphere of a light of one photon, times π, relative to the area per light.
/// The sphere then reaches half as far as the tenth nearest light.
const SPHERE_AREAS: f32 = 2.5;

/// Radius of `light` as a sphere in m: that of its photons; of a light of one photon, by
/// `area_factor` times the area that it represents.
#[inline(always)]
pub(super) fn sphere_radius(light: &VirtualLight, area_factor: f32) -> f32 {
    let spacing = (SPHERE_AREAS * FRAC_1_PI * light.area * area_factor).sqrt();
    if light.radius > 0.0 {
        light.radius
    } else {
        spacing
    }
}

/// The directions from points to a sphere.
struct DirectionCone<S: Width> {
    /// Unit directions to the center.
    axis: Vector<S>,
    /// Cosine of the half-angle; -1 inside the sphere.
    cos: Float<S>,
    /// `1 - cos`.
    height: Float<S>,
    /// `1 / (π r²)`.
    inv_disc: f32,
}

impl<S: Width> DirectionCone<S> {
    /// To the sphere with this radius, in m, at the end of a connection.
    #[inline(always)]
    fn of(at: &Direction<S>, radius: f32) -> Self {
        let sin2 = radius * radius * at.inv_d2;
        let outside = sin2.lt(1.0);
        let cos = (1.0 - sin2).safe_sqrt();
        // Not 1 - cos, which far from the light would be rounding.
        let height = sin2 / (1.0 + cos);
        DirectionCone {
            axis: at.wi,
            cos: outside.select(cos, -1.0),
            height: outside.select(height, 2.0),
            inv_disc: FRAC_1_PI / (radius * radius).max(f32::MIN_POSITIVE),
        }
    }

    /// Whether unit directions are within.
    #[inline(always)]
    fn contains(&self, w: Vector<S>) -> Mask<S> {
        w.dot(self.axis).ge(self.cos)
    }
}

/// Density per solid angle of a lobe with mean cosine `g`,
/// `(1 - g²)/(4π (1 + g² - 2 g cos)^(3/2))`.
#[inline(always)]
fn lobe_density<S: Width>(cos: Float<S>, g: Float<S>) -> Float<S> {
    let g2 = g * g;
    let base = (1.0 + g2 - 2.0 * g * cos).max(1e-6);
    (1.0 - g2) * (0.25 * FRAC_1_PI) / (base * base.sqrt())
}

/// The integral of the module's doc at the points `x`, by `count` directions of Ω and those of the
/// lobes; by the direction to the center if `count` is 1. Black in inactive lanes.
#[inline(always)]
pub(super) fn integrate<S: Width, E: RadiantIntensity<S>>(
    samples: &SphereSamples<S>,
    x: &impl Receivers<S>,
    light: &ConnectedLight<E>,
    at: &Direction<S>,
    count: usize,
) -> Color<S> {
    let cone = DirectionCone::of(at, light.radius);
    let solid_angle = TAU * cone.height;
    if count == 1 {
        let value = integrand(x, light, cone.axis, at.active);
        return value * (solid_angle * cone.inv_disc);
    }
    let s = solid_angle.width();
    let mixture = SamplingMixture {
        even: count as f32 / solid_angle,
        lobes: [
            (samples.lobe.as_ref()).map(|lobe| SamplingLobe {
                axis: lobe.axis,
                g: lobe.g,
            }),
            (light.lobe.as_ref()).map(|lobe| SamplingLobe {
                axis: Vector::splat(s, -lobe.axis),
                g: Float::splat(s, lobe.g),
            }),
        ],
    };
    let mut sum = Color::black(s);
    let frame = Axes::from_normal(cone.axis);
    for i in 0..count.min(MAX_DIRECTIONS) {
        let direction = samples.direction(&cone, &frame, i, count);
        let value = integrand(x, light, direction, at.active);
        sum += mixture.weighted(direction, value);
    }
    if let Some(lobe) = &samples.lobe {
        for k in 0..LOBE_DIRECTIONS {
            let direction = lobe.directions[k];
            let inside = at.active & cone.contains(direction);
            if inside.any() {
                let intensity = light.emission.intensity(-direction, inside);
                let value = mixture.weighted(direction, lobe.f_cos[k] * intensity);
                sum += value.within(inside);
            }
        }
    }
    if let Some(lobe) = &light.lobe {
        for (away, intensity) in &lobe.drawn {
            let direction = Vector::splat(s, -*away);
            let inside = at.active & cone.contains(direction);
            if inside.any() {
                let f_cos = x.f_cos_wi(direction, inside);
                let value = mixture.weighted(direction, f_cos * Color::splat(s, *intensity));
                sum += value.within(inside);
            }
        }
    }
    sum * cone.inv_disc
}

/// `f |w·n| I(-w)` for the unit directions `wi`; black in inactive lanes.
#[inline(always)]
fn integrand<S: Width, E: RadiantIntensity<S>>(
    x: &impl Receivers<S>,
    light: &ConnectedLight<E>,
    wi: Vector<S>,
    active: Mask<S>,
) -> Color<S> {
    let intensity = light.emission.intensity(-wi, active);
    (x.f_cos_wi(wi, active) * intensity).within(active)
}

impl<S: Width> SphereSamples<S> {
    /// Direction `i` of `count` of Ω.
    #[inline(always)]
    fn direction(
        &self,
        cone: &DirectionCone<S>,
        frame: &Axes<S>,
        i: usize,
        count: usize,
    ) -> Vector<S> {
        let s = cone.cos.width();
        let v = (i as f32 + Float::load(s, &self.shift)) * (1.0 / count as f32);
        let cos = 1.0 - v * cone.height;
        let sin = (1.0 - cos * cos).safe_sqrt();
        let [cos_turn, sin_turn] = &self.turns[i];
        let (x, y) = (
            sin * Float::load(s, cos_turn),
            sin * Float::load(s, sin_turn),
        );
        cone.axis * cos + (frame.s * x + frame.t * y)
    }
}

/// A lobe with density [`lobe_density`].
#[derive(Clone, Copy)]
struct SamplingLobe<S: Width> {
    axis: Vector<S>,
    /// Mean cosine.
    g: Float<S>,
}

/// Expected number of samples per solid angle.
struct SamplingMixture<S: Width> {
    /// Within Ω.
    even: Float<S>,
    /// At the point and at the light.
    lobes: [Option<SamplingLobe<S>>; 2],
}

impl<S: Width> SamplingMixture<S> {
    /// `value` in a sampled direction over the density of all directions there: the balance
    /// heuristic.
    #[inline(always)]
    fn weighted(&self, direction: Vector<S>, value: Color<S>) -> Color<S> {
        let mut density = self.even;
        for lobe in self.lobes.iter().flatten() {
            let own = lobe_density(direction.dot(lobe.axis), lobe.g);
            density = own.mul_add(own.same(LOBE_DIRECTIONS as f32), density);
        }
        value * density.recip()
    }
}
