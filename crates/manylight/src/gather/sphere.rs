//! A light as a sphere: its flux, spread over the directions under which a sphere around it is seen.
//!
//! ```text
//! L = 1/(π r²) ∫_Ω f(w) |w·n| I(-w) dw
//! ```
//!
//! Ω holds the directions from the point to the sphere of radius r, all directions inside the sphere. One shadow ray goes to the
//! center. The integral is bounded however near the light is, and converges to that of a point with `r / d`. Directions are
//! sampled from three densities, weighted by the balance heuristic: evenly from Ω, from a lobe like the reflection at the
//! point, and from a lobe like that at the light.
//!
//! Source: Hašan, Křivánek, Walter, Bala, "Virtual Spherical Lights for Many-Light Rendering of Glossy Scenes", SIGGRAPH Asia 2009.

use super::points::{Batch, mirrored};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::ids::LightId;
use crate::lanes::vectors::{add3, dot, mul3, scale3, splat3};
use crate::lanes::{LaneMask, Lanes, Lanes3};
use crate::math::{Frame, Vec2, Vec3};
use crate::sampling::rng::Pcg;
use crate::sampling::warp;
use crate::simd::Sixteen;
use crate::virtual_lights::{Emission, EmissionView, VirtualLight, VirtualLights};
use std::f32::consts::{FRAC_1_PI, TAU};

/// Squared radius of the sphere of a light of one photon, times π, relative to the area per light. The sphere then reaches half
/// as far as the tenth nearest light.
const SPHERE_AREAS: f32 = 2.5;
/// Most directions that are sampled from Ω.
const MAX_DIRECTIONS: usize = 16;
/// Directions that are sampled from the lobe at the point, and from that at the light. Unmeasured.
const LOBE_DIRECTIONS: usize = 4;
/// One minus the mean cosine of a sampling lobe, per roughness: its width is that of a GGX lobe at half the height.
const SPREAD_PER_ROUGHNESS: f32 = 1.7;
/// Step between successive angles, as a fraction of a turn: the golden ratio.
const GOLDEN_TURN: f32 = 0.618_034;

/// Radius of `light` as a sphere in m: that of its photons; of a light of one photon, by `area_factor` times the area that it
/// represents.
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

/// The directions from the points of a batch to a sphere.
pub(super) struct DirectionCone<W: Sixteen> {
    axis: [W::F; 3],
    /// Cosine of the half-angle; -1 inside the sphere.
    cos: W::F,
    /// `1 - cos`.
    height: W::F,
    /// `1 / (π r²)`.
    inv_disc: W::F,
}

impl<W: Sixteen> DirectionCone<W> {
    /// Around the unit directions `axis` to the center at the inverse squared distance `inv_d2`.
    #[inline(always)]
    pub(super) fn of(w: W, axis: [W::F; 3], inv_d2: W::F, radius: f32) -> Self {
        let one = w.splat(1.0);
        let sin2 = w.mul(w.splat(radius * radius), inv_d2);
        let outside = w.lt(sin2, one);
        let cos = w.sqrt(w.max(w.sub(one, sin2), w.splat(0.0)));
        // Not 1 - cos, which far from the light would be rounding.
        let height = w.div(sin2, w.add(one, cos));
        DirectionCone {
            axis,
            cos: w.select(outside, cos, w.splat(-1.0)),
            height: w.select(outside, height, w.splat(2.0)),
            inv_disc: w.splat(FRAC_1_PI / (radius * radius).max(f32::MIN_POSITIVE)),
        }
    }
}

/// Density per solid angle of a lobe with mean cosine `g`, `(1 - g²)/(4π (1 + g² - 2 g cos)^(3/2))`.
#[inline(always)]
fn lobe_density<W: Sixteen>(w: W, cos: W::F, g: W::F) -> W::F {
    let one = w.splat(1.0);
    let g2 = w.mul(g, g);
    let base = w.sub(w.add(one, g2), w.mul(w.mul(w.splat(2.0), g), cos));
    let base = w.max(base, w.splat(1e-6));
    let top = w.mul(w.sub(one, g2), w.splat(0.25 * FRAC_1_PI));
    w.div(top, w.mul(base, w.sqrt(base)))
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

/// Random numbers and directions of the points of a batch.
#[derive(Debug)]
pub(super) struct SphereSamples {
    /// Cosine and sine of the angles around the axis of Ω.
    turns: [[Lanes; 2]; MAX_DIRECTIONS],
    /// Position of the cosine of a direction within its stratum, in [0, 1).
    shift: Lanes,
    lobe: Option<PointLobe>,
}

/// Directions from lobes like the reflection of each point.
#[derive(Debug)]
struct PointLobe {
    /// Mean cosines.
    g: Lanes,
    directions: [Lanes3; LOBE_DIRECTIONS],
    /// `f |w·n|` there.
    f_cos: [Lanes3; LOBE_DIRECTIONS],
}

impl SphereSamples {
    #[inline(always)]
    pub(super) fn of<W: Sixteen>(w: W, batch: &Batch) -> Self {
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
            lobe: glossy.then(|| PointLobe::of(w, batch)),
        }
    }

    /// The integral of the module's doc at the active points, by `count` directions of Ω and those of the lobes; by the
    /// direction to the center if `count` is 1.
    #[inline(always)]
    pub(super) fn integrate<W: Sixteen>(
        &self,
        w: W,
        sphere: &SphereConnection<W>,
        count: usize,
    ) -> [W::F; 3] {
        let SphereConnection { cone, active, .. } = sphere;
        let solid_angle = w.mul(w.splat(TAU), cone.height);
        if count == 1 {
            let value = sphere.integrand(w, cone.axis);
            return scale3(w, value, w.mul(solid_angle, cone.inv_disc));
        }
        let mixture = self.mixture(w, sphere, w.div(w.splat(count as f32), solid_angle));
        let mut sum = self.cone_directions(w, sphere, &mixture, count);
        if let Some(lobe) = &self.lobe {
            for (direction, f_cos) in lobe.directions.iter().zip(&lobe.f_cos) {
                let d = direction.load(w);
                let inside = active & w.bits(w.le(cone.cos, dot(w, d, cone.axis))) as LaneMask;
                if inside != 0 {
                    let intensity = sphere.emission.intensities(w, direction, inside).load(w);
                    let value = mixture.weighted(w, d, mul3(w, f_cos.load(w), intensity));
                    sum = add3(w, sum, only(w, inside, value));
                }
            }
        }
        if let Some(lobe) = sphere.light_lobe {
            for (away, intensity) in &lobe.drawn {
                let d = splat3(w, -*away);
                let inside = active & w.bits(w.le(cone.cos, dot(w, d, cone.axis))) as LaneMask;
                if inside != 0 {
                    let receivers = &sphere.batch.receivers;
                    let f_cos = receivers.f_cos_wi(w, &Lanes3::store(w, d), inside).load(w);
                    let intensity = splat3(w, Vec3::from(intensity.to_array()));
                    let value = mixture.weighted(w, d, mul3(w, f_cos, intensity));
                    sum = add3(w, sum, only(w, inside, value));
                }
            }
        }
        scale3(w, sum, cone.inv_disc)
    }

    /// The density of all directions to a sphere, where those of Ω have density `even`.
    #[inline(always)]
    fn mixture<W: Sixteen>(
        &self,
        w: W,
        sphere: &SphereConnection<W>,
        even: W::F,
    ) -> SamplingMixture<W> {
        let at_point = self.lobe.as_ref().map(|lobe| SamplingLobe {
            axis: sphere.batch.mirrored.load(w),
            g: w.load(&lobe.g),
        });
        let at_light = sphere.light_lobe.map(|lobe| SamplingLobe {
            axis: splat3(w, -lobe.axis),
            g: w.splat(lobe.g),
        });
        SamplingMixture {
            even,
            lobes: [at_point, at_light],
        }
    }

    /// The part of the integral by `count` directions of Ω.
    #[inline(always)]
    fn cone_directions<W: Sixteen>(
        &self,
        w: W,
        sphere: &SphereConnection<W>,
        mixture: &SamplingMixture<W>,
        count: usize,
    ) -> [W::F; 3] {
        let cone = &sphere.cone;
        let frame = around(w, cone.axis);
        let mut sum = [w.splat(0.0); 3];
        for i in 0..count.min(MAX_DIRECTIONS) {
            let v = w.mul(
                w.add(w.splat(i as f32), w.load(&self.shift)),
                w.splat(1.0 / count as f32),
            );
            let cos = w.sub(w.splat(1.0), w.mul(v, cone.height));
            let sin = w.sqrt(w.max(w.sub(w.splat(1.0), w.mul(cos, cos)), w.splat(0.0)));
            let [cos_turn, sin_turn] = &self.turns[i];
            let (x, y) = (w.mul(sin, w.load(cos_turn)), w.mul(sin, w.load(sin_turn)));
            let direction = add3(
                w,
                scale3(w, cone.axis, cos),
                add3(w, scale3(w, frame[0], x), scale3(w, frame[1], y)),
            );
            let value = sphere.integrand(w, direction);
            sum = add3(w, sum, mixture.weighted(w, direction, value));
        }
        sum
    }
}

impl PointLobe {
    #[inline(always)]
    fn of<W: Sixteen>(w: W, batch: &Batch) -> Self {
        let g = batch.widths.map(mean_cosine);
        let directions: [Lanes3; LOBE_DIRECTIONS] = std::array::from_fn(|k| {
            Lanes3::from_fn(|i| {
                let u = (k as f32 + (17.0 * batch.u[i]).fract()) / LOBE_DIRECTIONS as f32;
                let turn = (batch.u[i] * 7.0 + GOLDEN_TURN * k as f32).fract();
                let frame = Frame::from_normal(batch.mirrored.vec(i));
                frame.to_world(warp::henyey_greenstein(Vec2::new(turn, u), g[i]))
            })
        });
        let f_cos =
            std::array::from_fn(|k| batch.receivers.f_cos_wi(w, &directions[k], LaneMask::MAX));
        PointLobe {
            g,
            directions,
            f_cos,
        }
    }
}

/// The connections of the points of a batch with a light as a sphere.
pub(super) struct SphereConnection<'a, W: Sixteen> {
    pub(super) batch: &'a Batch<'a, 'a>,
    pub(super) emission: &'a EmissionView<'a, 'a>,
    /// The glossy lobe of a light of one photon.
    pub(super) light_lobe: Option<&'a LightLobe>,
    pub(super) cone: DirectionCone<W>,
    pub(super) active: LaneMask,
}

impl<W: Sixteen> SphereConnection<'_, W> {
    /// `f |w·n| I(-w)` for the unit directions `wi`.
    #[inline(always)]
    fn integrand(&self, w: W, wi: [W::F; 3]) -> [W::F; 3] {
        let directions = Lanes3::store(w, wi);
        let intensity = self
            .emission
            .intensities(w, &directions, self.active)
            .load(w);
        let f_cos = self
            .batch
            .receivers
            .f_cos_wi(w, &directions, self.active)
            .load(w);
        only(w, self.active, mul3(w, f_cos, intensity))
    }
}

/// A lobe with density [`lobe_density`].
struct SamplingLobe<W: Sixteen> {
    axis: [W::F; 3],
    /// Mean cosine.
    g: W::F,
}

/// Expected number of samples per solid angle.
struct SamplingMixture<W: Sixteen> {
    /// Within Ω.
    even: W::F,
    /// At the point and at the light.
    lobes: [Option<SamplingLobe<W>>; 2],
}

impl<W: Sixteen> SamplingMixture<W> {
    /// `value` in a sampled direction over the density of all directions there: the balance heuristic.
    #[inline(always)]
    fn weighted(&self, w: W, direction: [W::F; 3], value: [W::F; 3]) -> [W::F; 3] {
        let mut density = self.even;
        for lobe in self.lobes.iter().flatten() {
            let own = lobe_density(w, dot(w, direction, lobe.axis), lobe.g);
            density = w.mul_add(own, w.splat(LOBE_DIRECTIONS as f32), density);
        }
        scale3(w, value, w.div(w.splat(1.0), density))
    }
}

/// `value` in the active lanes, 0 in the others.
#[inline(always)]
pub(super) fn only<W: Sixteen>(w: W, active: LaneMask, value: [W::F; 3]) -> [W::F; 3] {
    let lanes = w.mask(u32::from(active));
    [
        w.select(lanes, value[0], w.splat(0.0)),
        w.select(lanes, value[1], w.splat(0.0)),
        w.select(lanes, value[2], w.splat(0.0)),
    ]
}

/// Two unit vectors at right angles to the unit vectors `n` and each other. Source: Duff et al., "Building an Orthonormal Basis,
/// Revisited", JCGT 6(1), 2017.
#[inline(always)]
fn around<W: Sixteen>(w: W, n: [W::F; 3]) -> [[W::F; 3]; 2] {
    let [x, y, z] = n;
    let sign = w.mul_sign(w.splat(1.0), z);
    let a = w.div(w.splat(-1.0), w.add(sign, z));
    let b = w.mul(w.mul(x, y), a);
    [
        [
            w.mul_add(w.mul(sign, w.mul(x, x)), a, w.splat(1.0)),
            w.mul(sign, b),
            w.mul(w.splat(-1.0), w.mul(sign, x)),
        ],
        [b, w.mul_add(w.mul(y, y), a, sign), w.mul(w.splat(-1.0), y)],
    ]
}
