//! The points that stand for a light: sixteen or four of its photons' positions from near, one from far. For spheres, as many
//! directions.

use super::clamping::ClampReceiver;
use super::{Gather, Kernel};
use crate::lanes::vectors::dot;
use crate::lanes::{LaneMask, Lanes};
use crate::math::Vec3;
use crate::simd::Sixteen;
use crate::virtual_lights::VirtualLight;
use crate::virtual_lights::moments::POINTS;
use std::f32::consts::PI;

/// Distance, in radii of a disc, within which it is sixteen points. Unmeasured; see [`DISTANCE_SPREAD`].
const SIXTEEN_POINTS_WITHIN: f32 = 1.5;
/// Distance, in radii of a disc, within which it is four points, and one point beyond. Unmeasured.
const FOUR_POINTS_WITHIN: f32 = 4.0;
/// Distance, in radii of a sphere, within which sixteen directions are sampled. Unmeasured.
const SIXTEEN_DIRECTIONS_WITHIN: f32 = 2.0;
/// Distance, in radii of a sphere, within which four directions are sampled, and one beyond. Unmeasured.
const FOUR_DIRECTIONS_WITHIN: f32 = 8.0;
/// Largest relative increase of these distances, by the random number of the shading point: no ring shows where the number of
/// points changes.
const DISTANCE_SPREAD: f32 = 0.25;
/// Least area of a disc, relative to the surface area that its light represents; lights with smaller discs are points.
/// Unmeasured: one strong photon among weak ones makes a disc small that represents as much area as its neighbors.
const LEAST_DISC: f32 = 0.25;

/// A part of a light that is connected with as a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightPoint {
    /// Position, in m.
    pub(super) p: Vec3,
    /// Surface area that it represents, in m².
    pub(super) area: f32,
    /// Fraction of the light's intensity.
    pub(super) weight: f32,
    /// Directions to be sampled, for spheres.
    pub(super) directions: Option<usize>,
}

/// The shading points of a batch, by the number of light points that stand for a light.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PointCounts {
    pub(super) one: LaneMask,
    pub(super) four: LaneMask,
    pub(super) sixteen: LaneMask,
}

impl PointCounts {
    pub(super) fn are_empty(&self) -> bool {
        self.one | self.four | self.sixteen == 0
    }
}

/// The shading points of a batch that a light may reach.
#[derive(Clone, Copy)]
pub(super) struct FacingPoints<'a, W: Sixteen> {
    /// Vectors from the points to the light, in m.
    pub(super) to: [W::F; 3],
    /// Random numbers of the points, in [0, 1).
    pub(super) u: &'a Lanes,
    pub(super) facing: LaneMask,
}

impl Gather {
    /// The number of light points that stand for `light` at each shading point. `radius` is that of the light as a sphere, in m.
    #[inline(always)]
    pub(super) fn point_counts<W: Sixteen>(
        &self,
        w: W,
        light: &VirtualLight,
        radius: f32,
        points: FacingPoints<W>,
    ) -> PointCounts {
        let FacingPoints { to, u, facing } = points;
        let [sixteen, four] = match self.kernel {
            Kernel::Disc if self.is_disc(light) => [
                SIXTEEN_POINTS_WITHIN * light.radius,
                FOUR_POINTS_WITHIN * light.radius,
            ],
            Kernel::Sphere => [
                SIXTEEN_DIRECTIONS_WITHIN * radius,
                FOUR_DIRECTIONS_WITHIN * radius,
            ],
            _ => {
                return PointCounts {
                    one: facing,
                    ..PointCounts::default()
                };
            }
        };
        let d2 = dot(w, to, to);
        let stretch = w.mul_add(w.load(u), w.splat(DISTANCE_SPREAD), w.splat(1.0));
        let near = facing & within(w, d2, stretch, four);
        let sixteen = near & within(w, d2, stretch, sixteen);
        PointCounts {
            one: facing & !near,
            four: near & !sixteen,
            sixteen,
        }
    }

    /// Area that each point of `light` represents as seen from `at`, in m².
    pub(super) fn part_area(&self, at: &ClampReceiver, light: &VirtualLight) -> f32 {
        match self.part_count(at, light) {
            1 => self.whole_light(light).area,
            count => point_of_disc(light, 0, 1.0 / count as f32).area,
        }
    }

    /// Number of points that represent `light` as seen from `at`, for the kernels point and disc.
    pub(super) fn part_count(&self, at: &ClampReceiver, light: &VirtualLight) -> usize {
        let within = |radii: f32| self.is_disc(light) && is_within(radii, light, at.p, at.u);
        if within(SIXTEEN_POINTS_WITHIN) {
            POINTS
        } else if within(FOUR_POINTS_WITHIN) {
            4
        } else {
            1
        }
    }

    /// Whether a light is several points from near; see [`LEAST_DISC`].
    #[inline(always)]
    fn is_disc(&self, light: &VirtualLight) -> bool {
        self.kernel == Kernel::Disc && disc_area(light) > LEAST_DISC * light.area
    }

    /// The one point that stands for all of `light` from far.
    #[inline(always)]
    pub(super) fn whole_light(&self, light: &VirtualLight) -> LightPoint {
        let (p, area) = match self.kernel {
            Kernel::Point | Kernel::Sphere => (light.p, light.area),
            Kernel::Disc => (light.points[0], disc_area(light).max(light.area)),
        };
        LightPoint {
            p,
            area,
            weight: 1.0,
            directions: None,
        }
    }
}

/// A quarter or a sixteenth of a light: the point with the given index.
#[inline(always)]
pub(super) fn point_of_disc(light: &VirtualLight, index: usize, fraction: f32) -> LightPoint {
    LightPoint {
        p: light.points[index],
        area: disc_area(light) * fraction,
        weight: fraction,
        directions: None,
    }
}

/// Area of the disc with the second moment of a light's photons, in m².
#[inline(always)]
fn disc_area(light: &VirtualLight) -> f32 {
    PI * light.radius * light.radius
}

/// The lanes in which the squared distance `d2` is within `reach`, stretched.
#[inline(always)]
fn within<W: Sixteen>(w: W, d2: W::F, stretch: W::F, reach: f32) -> LaneMask {
    let reach = w.mul(stretch, w.splat(reach));
    w.bits(w.lt(d2, w.mul(reach, reach))) as LaneMask
}

/// Whether the point `p` with the random number `u` is within `radii` radii of `light`.
#[inline(always)]
fn is_within(radii: f32, light: &VirtualLight, p: Vec3, u: f32) -> bool {
    let reach = radii * light.radius * (1.0 + DISTANCE_SPREAD * u);
    (light.p - p).length_squared() < reach * reach
}
