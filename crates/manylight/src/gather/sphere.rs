//! A light as a sphere: its flux, spread over the directions under which a sphere around it is seen.
//!
//! ```text
//! L = 1/(π r²) ∫_Ω f(w) |w·n| I(-w) dw
//! ```
//!
//! with Ω the directions from the point to the sphere of radius r, all directions inside it, and one shadow ray to its center.
//! The integral is bounded however near the light is, and goes to that of a point with `r / d`. Directions are drawn from three
//! densities, weighted by the balance heuristic: evenly from Ω, from a lobe like the reflection at the point, and from one like
//! that at the light.
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
use crate::simd::Wide;
use crate::virtual_lights::{Emission, EmissionView, VirtualLight, VirtualLights};
use std::f32::consts::{FRAC_1_PI, TAU};

/// Squared radius of the sphere of a light that shines as one photon, in surfaces per light over π. The sphere reaches half as far as
/// the tenth nearest light.
const SPHERE_SURFACES: f32 = 2.5;
/// Most samples of Ω.
const MOST: usize = 16;
/// Samples of the lobe at the point, and of that at the light.
const LOBE_SAMPLES: usize = 4;
/// How much the mean cosine of a sampling lobe lacks of 1, per roughness: as wide as a GGX lobe at half its height.
const SPREAD_PER_ROUGHNESS: f32 = 1.7;
/// Successive angles are apart by this part of a turn: the golden section.
const TURN: f32 = 0.618_034;

/// Radius of `light` as a sphere in m, when it stands for so many lights: that of its photons, or one by the surface per light.
#[inline(always)]
pub(super) fn sphere_radius(light: &VirtualLight, stands_for: f32) -> f32 {
    let spacing = (SPHERE_SURFACES * FRAC_1_PI * light.area * stands_for).sqrt();
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
pub(super) struct Cone<W: Wide> {
    axis: [W::F; 3],
    /// Cosine of the half-angle; -1 inside the sphere.
    cos: W::F,
    /// `1 - cos`.
    height: W::F,
    /// `1 / (π r²)`.
    inv_disc: W::F,
}

impl<W: Wide> Cone<W> {
    /// Around the unit directions `axis` to the center at the inverse squared distance `inv_d2`.
    #[inline(always)]
    pub(super) fn of(w: W, axis: [W::F; 3], inv_d2: W::F, radius: f32) -> Self {
        let one = w.splat(1.0);
        let sin2 = w.mul(w.splat(radius * radius), inv_d2);
        let outside = w.lt(sin2, one);
        let cos = w.sqrt(w.max(w.sub(one, sin2), w.splat(0.0)));
        // Not 1 - cos, which far from the light would be rounding.
        let height = w.div(sin2, w.add(one, cos));
        Cone {
            axis,
            cos: w.select(outside, cos, w.splat(-1.0)),
            height: w.select(outside, height, w.splat(2.0)),
            inv_disc: w.splat(FRAC_1_PI / (radius * radius).max(f32::MIN_POSITIVE)),
        }
    }
}

/// Density per solid angle of a lobe with mean cosine `g`, `(1 - g²)/(4π (1 + g² - 2 g cos)^(3/2))`.
#[inline(always)]
fn lobe_density<W: Wide>(w: W, cos: W::F, g: W::F) -> W::F {
    let one = w.splat(1.0);
    let g2 = w.mul(g, g);
    let base = w.sub(w.add(one, g2), w.mul(w.mul(w.splat(2.0), g), cos));
    let base = w.max(base, w.splat(1e-6));
    let top = w.mul(w.sub(one, g2), w.splat(0.25 * FRAC_1_PI));
    w.div(top, w.mul(base, w.sqrt(base)))
}

/// Directions from the lobe of a light that shines as one photon.
pub(super) struct LightLobe {
    /// Where it shines most, away from the light.
    axis: Vec3,
    /// Mean cosine.
    g: f32,
    /// Drawn directions away from the light, with the radiant intensity there.
    drawn: [(Vec3, Rgb); LOBE_SAMPLES],
}

impl LightLobe {
    /// Of light `id`, if it has one; `seed` chooses the directions.
    pub(super) fn of(field: &VirtualLights, id: LightId, seed: u32) -> Option<Self> {
        let light = &field.lights()[id.index()];
        let Emission::Single(index) = light.emission else {
            return None;
        };
        let reflection = field.reflection(index);
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
                (i as f32 + rng.next_f32()) / LOBE_SAMPLES as f32,
            );
            let away = frame.to_world(warp::henyey_greenstein(u, g));
            (away, field.intensity(id, away))
        });
        Some(LightLobe { axis, g, drawn })
    }
}

/// Random numbers and directions of the points of a batch.
#[derive(Debug)]
pub(super) struct Samples {
    /// Cosine and sine of the angles around the axis of Ω.
    turns: [[Lanes; 2]; MOST],
    /// In [0, 1): where in its stratum the cosine of a sample lies.
    shift: Lanes,
    lobe: Option<PointLobe>,
}

/// Directions from lobes like the reflection of each point.
#[derive(Debug)]
struct PointLobe {
    /// Mean cosines.
    g: Lanes,
    directions: [Lanes3; LOBE_SAMPLES],
    /// `f |w·n|` there.
    f_cos: [Lanes3; LOBE_SAMPLES],
}

impl Samples {
    #[inline(always)]
    pub(super) fn of<W: Wide>(w: W, batch: &Batch) -> Self {
        let turn = |i: usize, u: f32| TAU * (u + TURN * i as f32);
        let turns = std::array::from_fn(|i| {
            [
                batch.u.map(|u| turn(i, u).cos()),
                batch.u.map(|u| turn(i, u).sin()),
            ]
        });
        let glossy = batch.widths.iter().any(|&width| width < 1.0);
        Samples {
            turns,
            shift: batch.u.map(|u| (61.0 * u).fract()),
            lobe: glossy.then(|| PointLobe::of(w, batch)),
        }
    }

    /// What a light sends to the active points: the integral above, by `count` samples of Ω and those of the lobes; by its center if
    /// `count` is 1.
    #[inline(always)]
    #[expect(
        clippy::too_many_arguments,
        reason = "one light and one batch, in pieces"
    )]
    pub(super) fn sphere<W: Wide>(
        &self,
        w: W,
        batch: &Batch,
        emission_view: &EmissionView,
        light: Option<&LightLobe>,
        cone: &Cone<W>,
        count: usize,
        active: LaneMask,
    ) -> [W::F; 3] {
        let evaluate = Integrand {
            batch,
            emission_view,
            active,
        };
        let solid_angle = w.mul(w.splat(TAU), cone.height);
        if count == 1 {
            let value = evaluate.at(w, cone.axis);
            return scale3(w, value, w.mul(solid_angle, cone.inv_disc));
        }
        let mut mixture = Mixture {
            even: w.div(w.splat(count as f32), solid_angle),
            lobes: [None, None],
        };
        if let Some(lobe) = &self.lobe {
            mixture.lobes[0] = Some(Lobe {
                axis: batch.mirrored.load(w),
                g: w.load(&lobe.g),
            });
        }
        if let Some(lobe) = light {
            mixture.lobes[1] = Some(Lobe {
                axis: splat3(w, -lobe.axis),
                g: w.splat(lobe.g),
            });
        }
        let frame = around(w, cone.axis);
        let mut sum = [w.splat(0.0); 3];
        for i in 0..count.min(MOST) {
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
            let value = evaluate.at(w, direction);
            sum = add3(w, sum, mixture.weighted(w, direction, value));
        }
        if let Some(lobe) = &self.lobe {
            for (direction, f_cos) in lobe.directions.iter().zip(&lobe.f_cos) {
                let d = direction.load(w);
                let inside = active & w.bits(w.le(cone.cos, dot(w, d, cone.axis))) as LaneMask;
                if inside != 0 {
                    let intensity = emission_view.intensities(w, direction, inside).load(w);
                    let value = mixture.weighted(w, d, mul3(w, f_cos.load(w), intensity));
                    sum = add3(w, sum, only(w, inside, value));
                }
            }
        }
        if let Some(lobe) = light {
            for (away, intensity) in &lobe.drawn {
                let d = splat3(w, -*away);
                let inside = active & w.bits(w.le(cone.cos, dot(w, d, cone.axis))) as LaneMask;
                if inside != 0 {
                    let f_cos = batch
                        .receivers
                        .f_cos_wi(w, &Lanes3::store(w, d), inside)
                        .load(w);
                    let intensity = splat3(w, Vec3::from(intensity.to_array()));
                    let value = mixture.weighted(w, d, mul3(w, f_cos, intensity));
                    sum = add3(w, sum, only(w, inside, value));
                }
            }
        }
        scale3(w, sum, cone.inv_disc)
    }
}

impl PointLobe {
    #[inline(always)]
    fn of<W: Wide>(w: W, batch: &Batch) -> Self {
        let g = batch.widths.map(mean_cosine);
        let directions: [Lanes3; LOBE_SAMPLES] = std::array::from_fn(|k| {
            Lanes3::from_fn(|i| {
                let u = (k as f32 + (17.0 * batch.u[i]).fract()) / LOBE_SAMPLES as f32;
                let turn = (batch.u[i] * 7.0 + TURN * k as f32).fract();
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

/// `f |w·n| I(-w)` between a light and the points of a batch.
struct Integrand<'a> {
    batch: &'a Batch<'a, 'a>,
    emission_view: &'a EmissionView<'a, 'a>,
    active: LaneMask,
}

impl Integrand<'_> {
    #[inline(always)]
    fn at<W: Wide>(&self, w: W, wi: [W::F; 3]) -> [W::F; 3] {
        let directions = Lanes3::store(w, wi);
        let intensity = self
            .emission_view
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

/// What [`lobe_density`] asks for.
struct Lobe<W: Wide> {
    axis: [W::F; 3],
    /// Mean cosine.
    g: W::F,
}

/// Expected number of samples per solid angle.
struct Mixture<W: Wide> {
    /// Within Ω.
    even: W::F,
    /// At the point and at the light.
    lobes: [Option<Lobe<W>>; 2],
}

impl<W: Wide> Mixture<W> {
    /// `value` in a drawn direction over the density of all samples there: the balance heuristic.
    #[inline(always)]
    fn weighted(&self, w: W, direction: [W::F; 3], value: [W::F; 3]) -> [W::F; 3] {
        let mut density = self.even;
        for lobe in self.lobes.iter().flatten() {
            let own = lobe_density(w, dot(w, direction, lobe.axis), lobe.g);
            density = w.mul_add(own, w.splat(LOBE_SAMPLES as f32), density);
        }
        scale3(w, value, w.div(w.splat(1.0), density))
    }
}

/// The active lanes; 0 in others.
#[inline(always)]
pub(super) fn only<W: Wide>(w: W, active: LaneMask, value: [W::F; 3]) -> [W::F; 3] {
    let lanes = w.lanes(u32::from(active));
    [
        w.select(lanes, value[0], w.splat(0.0)),
        w.select(lanes, value[1], w.splat(0.0)),
        w.select(lanes, value[2], w.splat(0.0)),
    ]
}

/// Two unit vectors at right angles to the unit vectors `n` and each other. Source: Duff et al., "Building an Orthonormal Basis,
/// Revisited", JCGT 6(1), 2017.
#[inline(always)]
fn around<W: Wide>(w: W, n: [W::F; 3]) -> [[W::F; 3]; 2] {
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
