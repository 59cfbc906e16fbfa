//! Guides for the emission of photons by infinite lights: where to place their rays.
//!
//! Most photons that start anywhere on the scene's bounding sphere end on the outside of a building
//! that is lit through windows. A guide is a density over the four random numbers of emission: two
//! for the direction, two for the position on a disc perpendicular to it. It is learned from the
//! light that the guiding pre-pass ([`super::prepass`]) finds arriving in the visible part of the
//! scene. Emission samples a mixture of the guide and of the unguided density, and divides by the
//! mixture density. So guides change the variance and no expected value.

use super::BoundingSphere;
use super::guide_tree::{GuideTree, PrimaryPoint, TrainingSample};
use crate::math::{Aabb, Frame, Vec2, Vec3};
use std::f32::consts::FRAC_PI_4;

/// Probability of emission without the guide, in the mixture. A photon has at most 1 / 0.2 = 5
/// times its unguided flux. At 0.1 and 0.4, the pixel variance of `photon-map` with 50,000 photon
/// paths is .94 and .93 times as large in the third-party kitchen, 1.00 and .99 in the living-room,
/// 1.00 and 1.13 in the classroom (16 seeds at 128x72; the standard error is a few percent).
pub(super) const UNGUIDED_PROBABILITY: f32 = 0.2;

/// Radius of the guide's sphere over the distance of the farthest lit point from its center: a
/// margin for lit points between and beyond those that the pre-pass found. At 1.01 and 1.3, the
/// pixel variance of the scenes above is 1.21, 1.05, 1.19 and 1.20, 1.08, 1.16 times as large.
const RADIUS_MARGIN: f32 = 1.1;

/// Smallest radius of the guide's sphere over that of the scene, for the case of a single lit
/// point.
const MIN_RELATIVE_RADIUS: f32 = 1e-3;

/// Tolerance for rounding, in radii: a point that the guide itself has placed on the border of its
/// disc counts as inside.
const BORDER_TOLERANCE: f32 = 1e-4;

/// The guides of all infinite lights, in their order; `None` for a light from which the pre-pass
/// found nothing.
#[derive(Clone, Debug)]
pub(in crate::emitters) struct InfiniteLightGuides(Vec<Option<LightGuide>>);

/// The guide of one infinite light.
#[derive(Clone, Debug)]
pub(super) struct LightGuide {
    /// Density over direction and disc position.
    tree: GuideTree,
    /// The sphere that holds the lit points of the pre-pass. Discs of this radius around its center
    /// replace those across the scene.
    center: Vec3,
    radius: f32,
    /// Geometric mean, over the light that the pre-pass found, of guided density over unguided
    /// density.
    gain: f32,
}

/// Light that arrives at a point, found by the guiding pre-pass.
#[derive(Clone, Copy, Debug)]
pub(super) struct IncidentSample {
    /// Index of the light.
    pub(super) light: usize,
    /// The numbers from which the light's emission makes `wi`.
    pub(super) u_direction: Vec2,
    /// Unit direction towards the light.
    pub(super) wi: Vec3,
    /// The lit point.
    pub(super) p: Vec3,
    /// Irradiance over pdf, as a scalar.
    pub(super) weight: f32,
}

impl InfiniteLightGuides {
    /// Learns a guide for each of `light_count` lights.
    pub(super) fn learn(
        light_count: usize,
        samples: &[IncidentSample],
        scene: &BoundingSphere,
    ) -> Self {
        let guide = |light: usize| {
            let of_light: Vec<&IncidentSample> =
                samples.iter().filter(|s| s.light == light).collect();
            LightGuide::learn(&of_light, scene)
        };
        InfiniteLightGuides((0..light_count).map(guide).collect())
    }

    pub(super) fn of_light(&self, light: usize) -> Option<&LightGuide> {
        self.0[light].as_ref()
    }

    /// The gain of each light's guide; 1 without a guide.
    pub(super) fn gains(&self) -> impl Iterator<Item = f32> {
        self.0.iter().map(|g| g.as_ref().map_or(1.0, |g| g.gain))
    }
}

impl LightGuide {
    /// `None` without light.
    fn learn(samples: &[&IncidentSample], scene: &BoundingSphere) -> Option<Self> {
        let center = Aabb::from_points(samples.iter().map(|s| s.p)).center();
        let farthest = samples
            .iter()
            .map(|s| (s.p - center).length())
            .fold(0.0, f32::max);
        let radius = (RADIUS_MARGIN * farthest).max(MIN_RELATIVE_RADIUS * scene.radius);
        let training_sample = |s: &&IncidentSample| {
            let across = Frame::from_normal(s.wi).to_local(s.p - center) / radius;
            let across = square_from_disc(across.truncate());
            TrainingSample {
                at: [s.u_direction.x, s.u_direction.y, across.x, across.y],
                weight: s.weight,
            }
        };
        let mut training: Vec<TrainingSample> = samples.iter().map(training_sample).collect();
        let mut guide = LightGuide {
            tree: GuideTree::learn(&mut training)?,
            center,
            radius,
            gain: 1.0,
        };
        let (mut log, mut total) = (0.0f64, 0.0f64);
        for s in samples {
            let frame = Frame::from_normal(s.wi);
            let across = frame.to_local(s.p - scene.center).truncate();
            let density = guide.relative_density(scene, s.u_direction, &frame, across);
            log += f64::from(s.weight * density.ln());
            total += f64::from(s.weight);
        }
        guide.gain = (log / total).exp() as f32;
        Some(guide)
    }

    /// Four uniform numbers to numbers with the learned density.
    pub(super) fn warp(&self, u: PrimaryPoint) -> PrimaryPoint {
        self.tree.warp(u)
    }

    /// Radius of the guide's disc.
    pub(super) fn radius(&self) -> f32 {
        self.radius
    }

    /// Center of the guide's disc on the plane through the center of the scene that is
    /// perpendicular to the direction `frame.n`.
    pub(super) fn disc_center(&self, scene: &BoundingSphere, frame: &Frame) -> Vec2 {
        frame.to_local(self.center - scene.center).truncate()
    }

    /// Density of the mixture over that of unguided emission, for the direction `frame.n` that the
    /// numbers `u_direction` give and the position `across` on the plane through the center of the
    /// scene.
    pub(super) fn relative_density(
        &self,
        scene: &BoundingSphere,
        u_direction: Vec2,
        frame: &Frame,
        across: Vec2,
    ) -> f32 {
        let unguided = if across.length() <= scene.radius {
            UNGUIDED_PROBABILITY
        } else {
            0.0
        };
        let q = (across - self.disc_center(scene, frame)) / self.radius;
        if q.length() > 1.0 + BORDER_TOLERANCE {
            return unguided;
        }
        let q = square_from_disc(q);
        let concentration = (scene.radius / self.radius).powi(2);
        let guided = concentration * self.tree.density([u_direction.x, u_direction.y, q.x, q.y]);
        unguided + (1.0 - UNGUIDED_PROBABILITY) * guided
    }
}

/// The inverse of [`warp::disc`](crate::sampling::warp::disc); points outside the disc go to the
/// border of the square.
fn square_from_disc(d: Vec2) -> Vec2 {
    let r = d.length().min(1.0);
    let p = if d.x.abs() > d.y.abs() {
        let x = r.copysign(d.x);
        Vec2::new(x, x * (d.y / d.x).atan() / FRAC_PI_4)
    } else if d.y != 0.0 {
        let y = r.copysign(d.y);
        Vec2::new(y * (d.x / d.y).atan() / FRAC_PI_4, y)
    } else {
        Vec2::ZERO
    };
    ((p + Vec2::ONE) * 0.5).clamp(Vec2::ZERO, Vec2::splat(1.0 - f32::EPSILON))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::warp;

    #[test]
    fn the_map_from_the_disc_inverts_that_to_the_disc() {
        for i in 0..400 {
            let u = Vec2::new((i % 20) as f32 + 0.3, (i / 20) as f32 + 0.6) / 20.0;
            assert!((square_from_disc(warp::disc(u)) - u).length() < 1e-5, "{u}");
        }
        assert_eq!(square_from_disc(Vec2::ZERO), Vec2::splat(0.5));
    }
}
