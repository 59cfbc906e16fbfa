//! The points that stand for a light: sixteen or four of its photons' positions from near, one from
//! far. For spheres, as many directions.

use super::clamping::ClampReceiver;
use super::{Gather, Kernel, Subset};
use crate::lanes::{Float, Mask, One, Vector, Width};
use crate::math::Vec3;
use crate::virtual_lights::VirtualLight;
use crate::virtual_lights::moments::POINTS;
use std::f32::consts::PI;

/// Distance, in radii of a disc, within which it is sixteen points; see [`DISTANCE_SPREAD`]. On the
/// axis, four random points of a disc have a standard deviation of 10 % from there, 30 % at half of
/// the distance, 3 % at twice. At 0.75 and 3 (2 passes of 128 lights at 72x40, 2 seeds; Kitchen,
/// Glossy Room): relMSE +0.1 and -0.1 % (standard error 1 %), shadow rays -23 and +60 %.
const SIXTEEN_POINTS_WITHIN: f32 = 1.5;
/// Distance, in radii of a disc, within which it is four points, and one point beyond. On the axis,
/// one random point of a disc has a standard deviation of 4 % from there, 13 % at half of the
/// distance, 1 % at twice. At 2 and 8 (2 passes of 128 lights at 72x40, 2 seeds; Kitchen, Glossy
/// Room): relMSE +3.1 and -2.0 % (standard error 1 %), shadow rays -19 and +26 %, mean +0.2 and
/// -0.4 %.
const FOUR_POINTS_WITHIN: f32 = 4.0;
/// Distance, in radii of a sphere, within which sixteen directions are sampled. At 1 and 4 (2
/// passes of `rich-vsl` at 72x40, 3 seeds; Glossy Room, Contacts): relMSE +1.3 and -1.9 %.
const SIXTEEN_DIRECTIONS_WITHIN: f32 = 2.0;
/// Distance, in radii of a sphere, within which four directions are sampled, and one beyond. At 4
/// and 16 (2 passes of `rich-vsl` at 72x40, 3 seeds; Glossy Room, Contacts): relMSE +1.5 and -0.4 %
/// (standard error 1 %), mean +0.5 and +0.2 %.
const FOUR_DIRECTIONS_WITHIN: f32 = 8.0;
/// Largest relative increase of these distances, by the random number of the shading point: no ring
/// shows where the number of points changes. At 0.125 and 0.5 (2 passes of 128 lights of `rich-vpl`
/// and `rich-vsl` at 72x40, 6 seeds; Glossy Room, Kitchen): relMSE -0.1 and +0.2 % (at most 0.9 % in
/// one of them), mean within 0.1 %.
const DISTANCE_SPREAD: f32 = 0.25;
/// Least area of a disc, relative to the surface area that its light represents; lights with
/// smaller discs are points. One strong photon among weak ones makes a disc small that represents
/// as much area as its neighbors. At 0.125 and 0.5 (2 passes of 128 lights at 72x40, 2 seeds;
/// Kitchen, Glossy Room): relMSE 0 and 0 %.
const MIN_DISC: f32 = 0.25;

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

/// The number of light points, or of directions, that stand for a light at each shading point: one,
/// four or sixteen.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointCounts<S: Width> {
    pub(super) one: Mask<S>,
    pub(super) four: Mask<S>,
    pub(super) sixteen: Mask<S>,
}

/// The counts for `light` at the ends of the vectors `to`, in m, from shading points with the
/// random numbers `u`. `radius` is that of the light as a sphere, in m.
#[inline(always)]
pub(super) fn point_counts<S: Width>(
    gather: &Gather,
    light: &VirtualLight,
    radius: f32,
    to: Vector<S>,
    u: Float<S>,
) -> PointCounts<S> {
    let [sixteen, four] = match gather.kernel {
        Kernel::Disc if is_disc(gather, light) => [
            SIXTEEN_POINTS_WITHIN * light.radius_of_all,
            FOUR_POINTS_WITHIN * light.radius_of_all,
        ],
        Kernel::Sphere => [
            SIXTEEN_DIRECTIONS_WITHIN * radius,
            FOUR_DIRECTIONS_WITHIN * radius,
        ],
        Kernel::Point | Kernel::Disc => {
            let none = Mask::splat(u.width(), false);
            return PointCounts {
                one: !none,
                four: none,
                sixteen: none,
            };
        }
    };
    let d2 = to.length_squared();
    let near = within(d2, u, four);
    let sixteen = near & within(d2, u, sixteen);
    PointCounts {
        one: !near,
        four: near & !sixteen,
        sixteen,
    }
}

/// Number of points that represent `light` as seen from `at`, for the kernels point and disc.
pub(super) fn part_count(gather: &Gather, at: &ClampReceiver, light: &VirtualLight) -> usize {
    if !is_disc(gather, light) {
        return 1;
    }
    let to: Vector<One> = (light.p - at.p).into();
    let counts = point_counts(gather, light, 0.0, to, at.u.into());
    if counts.sixteen.any() {
        POINTS
    } else if counts.four.any() {
        4
    } else {
        1
    }
}

/// Area that each point of `light` represents as seen from `at`, in m².
pub(super) fn part_area(gather: &Gather, at: &ClampReceiver, light: &VirtualLight) -> f32 {
    light_part(gather, light, at.lights, (0, part_count(gather, at, light))).area
}

/// Whether a light is several points from near; see [`MIN_DISC`].
#[inline(always)]
fn is_disc(gather: &Gather, light: &VirtualLight) -> bool {
    gather.kernel == Kernel::Disc && disc_area(light) > MIN_DISC * light.area
}

/// Part `k` of `light`, of which there are `count`, as `lights` are seen. The one part of a light
/// from far is all of it.
#[inline(always)]
pub(super) fn light_part(
    gather: &Gather,
    light: &VirtualLight,
    lights: Subset,
    (k, count): (usize, usize),
) -> LightPoint {
    let first = lights.far_point() / count * count;
    let (p, area) = match (gather.kernel, count) {
        (Kernel::Point | Kernel::Sphere, _) => (light.p, light.area),
        (Kernel::Disc, 1) => (light.points[first], disc_area(light).max(light.area)),
        (Kernel::Disc, _) => (
            light.points[first + k],
            disc_area(light) * (1.0 / count as f32),
        ),
    };
    LightPoint {
        p,
        area,
        weight: 1.0 / count as f32,
        directions: None,
    }
}

/// Area of the disc with the second moment of a light's photons, in m².
#[inline(always)]
fn disc_area(light: &VirtualLight) -> f32 {
    PI * light.radius * light.radius
}

/// Whether the squared distance `d2` is within `reach`, stretched by the random number `u` of the
/// shading point.
#[inline(always)]
fn within<S: Width>(d2: Float<S>, u: Float<S>, reach: f32) -> Mask<S> {
    let stretch = u.mul_add(u.same(DISTANCE_SPREAD), u.same(1.0));
    d2.lt((stretch * reach).squared())
}
