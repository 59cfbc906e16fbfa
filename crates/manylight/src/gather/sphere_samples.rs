//! Random numbers and sampled directions for lights as spheres: of the points, and of a light. See
//! [`super::sphere`].

use super::points::{Batch, mirrored};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::ids::LightId;
use crate::lanes::{Color, Float, Mask, Sixteen, Vector, Width};
use crate::math::{Frame, Vec2, Vec3};
use crate::sampling::rng::Pcg;
use crate::sampling::warp;
use crate::virtual_lights::{Emission, VirtualLights};
use std::f32::consts::TAU;

/// Most directions that are sampled from Ω.
pub(super) const MAX_DIRECTIONS: usize = 16;
/// Directions that are sampled from the lobe at the point, and from that at the light. At 2 and 8
/// (2 passes of `rich-vsl` at 72x40, 3 seeds; Glossy Room, Contacts): relMSE +2.5 and -2.3 %
/// (standard error 1 %).
pub(super) const LOBE_DIRECTIONS: usize = 4;
/// One minus the mean cosine of a sampling lobe, per roughness: its width is that of a GGX lobe at
/// half the height. At 0.85 and 3.4 (2 passes of `rich-vsl`, 128 lights at 72x40, 6 seeds; Kitchen,
/// Glossy Room, U-Shape): relMSE -0.4 and +3.9 % (standard error 1 %).
const SPREAD_PER_ROUGHNESS: f32 = 1.7;
/// Step between successive angles, as a fraction of a turn: the golden ratio.
const GOLDEN_TURN: f32 = 0.618_034;
/// Factors of the random number `u` of a point. The fractional parts of the products are further
/// random numbers. No factor is 1, because `u` itself decides the number of directions. The factors
/// are different primes, so that the products are hardly correlated.
const AZIMUTH: f32 = 13.0;
const SHIFT: f32 = 61.0;
const LOBE_HEIGHT: f32 = 17.0;
const LOBE_AZIMUTH: f32 = 7.0;

/// Mean cosine of the lobe that samples a reflection of the given roughness.
fn mean_cosine(roughness: f32) -> f32 {
    (1.0 - SPREAD_PER_ROUGHNESS * roughness).max(0.0)
}

/// Directions sampled from the glossy lobe of a light of one photon.
pub(super) struct LightLobe {
    /// Direction of the largest intensity, away from the light; unit.
    pub(super) axis: Vec3,
    /// Mean cosine.
    pub(super) g: f32,
    /// Sampled directions away from the light, with the radiant intensity there in W/sr.
    pub(super) drawn: [(Vec3, Rgb); LOBE_DIRECTIONS],
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
        let g = mean_cosine(reflection.bsdf.glossy_roughness());
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
    pub(super) turns: [[S::Each<f32>; 2]; MAX_DIRECTIONS],
    /// Position of the cosine of a direction within its stratum, in [0, 1).
    pub(super) shift: S::Each<f32>,
    pub(super) lobe: Option<PointLobe<S>>,
}

/// Directions from lobes like the reflection of each point.
#[derive(Clone, Copy)]
pub(super) struct PointLobe<S: Width> {
    pub(super) axis: Vector<S>,
    /// Mean cosines.
    pub(super) g: Float<S>,
    pub(super) directions: [Vector<S>; LOBE_DIRECTIONS],
    /// `f |w·n|` there.
    pub(super) f_cos: [Color<S>; LOBE_DIRECTIONS],
}

impl<S: Sixteen> SphereSamples<S> {
    /// The samples of the points of a batch.
    #[inline(always)]
    pub(super) fn of(s: S, batch: &Batch) -> Self {
        let turn = |i: usize, u: f32| TAU * (AZIMUTH * u + GOLDEN_TURN * i as f32);
        let turns = std::array::from_fn(|i| {
            [
                batch.u.map(|u| turn(i, u).cos()),
                batch.u.map(|u| turn(i, u).sin()),
            ]
        });
        let glossy = batch.roughness.iter().any(|&roughness| roughness < 1.0);
        SphereSamples {
            turns,
            shift: batch.u.map(|u| (SHIFT * u).fract()),
            lobe: glossy.then(|| PointLobe::of(s, batch)),
        }
    }
}

impl<S: Sixteen> PointLobe<S> {
    #[inline(always)]
    fn of(s: S, batch: &Batch) -> Self {
        let g = batch.roughness.map(mean_cosine);
        let zero = Vector::splat(s, Vec3::ZERO);
        let mut lobe = PointLobe {
            axis: batch.mirrored.vectors(s),
            g: Float::load(s, &g),
            directions: [zero; LOBE_DIRECTIONS],
            f_cos: [Color::black(s); LOBE_DIRECTIONS],
        };
        for k in 0..LOBE_DIRECTIONS {
            let direction = Vector::from_fn(s, |i| {
                let u = (k as f32 + (LOBE_HEIGHT * batch.u[i]).fract()) / LOBE_DIRECTIONS as f32;
                let turn = (LOBE_AZIMUTH * batch.u[i] + GOLDEN_TURN * k as f32).fract();
                let frame = Frame::from_normal(batch.mirrored.vec(i));
                frame.to_world(warp::henyey_greenstein(Vec2::new(turn, u), g[i]))
            });
            lobe.directions[k] = direction;
            lobe.f_cos[k] = batch.bsdfs.f_cos_wi(direction, Mask::splat(s, true));
        }
        lobe
    }
}
