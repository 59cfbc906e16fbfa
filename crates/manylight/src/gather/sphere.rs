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

use super::connect::{ConnectedLight, Direction, Receivers};
use super::points::{Batch, mirrored};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::ids::LightId;
use crate::lanes::{Axes, Color, Float, Mask, Sixteen, Vector, Width};
use crate::math::{Frame, Vec2, Vec3};
use crate::sampling::rng::Pcg;
use crate::sampling::warp;
use crate::virtual_lights::{Emission, RadiantIntensity, VirtualLight, VirtualLights};
use std::f32::consts::{FRAC_1_PI, TAU};

/// Squared radius of the sphere of a light of one photon, times π, relative to the area per light.
/// The sphere then reaches half as far as the tenth nearest light.
const SPHERE_AREAS: f32 = 2.5;
/// Most directions that are sampled from Ω.
const MAX_DIRECTIONS: usize = 16;
/// Directions that are sampled from the lobe at the point, and from that at the light. Unmeasured.
const LOBE_DIRECTIONS: usize = 4;
/// One minus the mean cosine of a sampling lobe, per roughness: its width is that of a GGX lobe at
/// half the height.
const SPREAD_PER_ROUGHNESS: f32 = 1.7;
/// Step between successive angles, as a fraction of a turn: the golden ratio.
const GOLDEN_TURN: f32 = 0.618_034;

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

/// Mean cosine of the lobe that samples a reflection of the given roughness.
fn mean_cosine(roughness: f32) -> f32 {
    (1.0 - SPREAD_PER_ROUGHNESS * roughness).max(0.0)
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

/// Directions sampled from the glossy lobe of a light of one photon.
pub(super) struct LightLobe {
    /// Direction of the largest intensity, away from the light; unit.
    axis: Vec3,
    /// Mean cosine.
    g: f32,
    /// Sampled directions away from the light, with the radiant intensity there in W/sr.
    drawn: [(Vec3, Rgb); LOBE_DIRECTIONS],
}

impl LightLobe {
    /// The lobe of light `id`, if it has one; `seed` chooses the directions.
    pub(super) fn of(lights: &VirtualLights, id: LightId, seed: u32) -> Option<Self> {
        let light = &lights.lights()[id.index()];
        let Emission::Single(index) = light.emission else {
            return None;
        };
        let reflection = lights.reflection(index);
        if !reflection.bsdf.lobes().has(Lobes::GLOSSY) {
            return None;
        }
        let axis = mirrored(reflection.wi, light.ns);
        let g = mean_cosine(reflection.bsdf.glossy_width());
        let frame = Frame::from_normal(axis);
        let mut rng = Pcg::new(u64::from(id.0) << 32 | u64::from(seed));
        let drawn = std::array::from_fn(|i| {
            let u = Vec2::new(
                rng.next_f32(),
                (i as f32 + rng.next_f32()) / LOBE_DIRECTIONS as f32,
            );
            let away = frame.to_world(warp::henyey_greenstein(u, g));
            (away, lights.intensity(id, away))
        });
        Some(LightLobe { axis, g, drawn })
    }
}

/// Random numbers and directions of points.
#[derive(Clone, Copy)]
pub(super) struct SphereSamples<S: Width> {
    /// Cosine and sine of the angles around the axis of Ω.
    turns: [[S::Each<f32>; 2]; MAX_DIRECTIONS],
    /// Position of the cosine of a direction within its stratum, in [0, 1).
    shift: S::Each<f32>,
    lobe: Option<PointLobe<S>>,
}

/// Directions from lobes like the reflection of each point.
#[derive(Clone, Copy)]
struct PointLobe<S: Width> {
    axis: Vector<S>,
    /// Mean cosines.
    g: Float<S>,
    directions: [Vector<S>; LOBE_DIRECTIONS],
    /// `f |w·n|` there.
    f_cos: [Color<S>; LOBE_DIRECTIONS],
}

impl<S: Sixteen> SphereSamples<S> {
    /// The samples of the points of a batch.
    #[inline(always)]
    pub(super) fn of(s: S, batch: &Batch) -> Self {
        let turn = |i: usize, u: f32| TAU * (u + GOLDEN_TURN * i as f32);
        let turns = std::array::from_fn(|i| {
            [
                batch.u.map(|u| turn(i, u).cos()),
                batch.u.map(|u| turn(i, u).sin()),
            ]
        });
        let glossy = batch.widths.iter().any(|&width| width < 1.0);
        SphereSamples {
            turns,
            shift: batch.u.map(|u| (61.0 * u).fract()),
            lobe: glossy.then(|| PointLobe::of(s, batch)),
        }
    }
}

impl<S: Sixteen> PointLobe<S> {
    #[inline(always)]
    fn of(s: S, batch: &Batch) -> Self {
        let g = batch.widths.map(mean_cosine);
        let zero = Vector::splat(s, Vec3::ZERO);
        let mut lobe = PointLobe {
            axis: batch.mirrored.vectors(s),
            g: Float::load(s, &g),
            directions: [zero; LOBE_DIRECTIONS],
            f_cos: [Color::black(s); LOBE_DIRECTIONS],
        };
        for k in 0..LOBE_DIRECTIONS {
            let direction = Vector::from_fn(s, |i| {
                let u = (k as f32 + (17.0 * batch.u[i]).fract()) / LOBE_DIRECTIONS as f32;
                let turn = (batch.u[i] * 7.0 + GOLDEN_TURN * k as f32).fract();
                let frame = Frame::from_normal(batch.mirrored.vec(i));
                frame.to_world(warp::henyey_greenstein(Vec2::new(turn, u), g[i]))
            });
            lobe.directions[k] = direction;
            lobe.f_cos[k] = batch.receivers.f_cos_wi(direction, Mask::splat(s, true));
        }
        lobe
    }
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
