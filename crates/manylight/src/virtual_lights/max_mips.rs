//! Upper bounds of radiant intensity over cones of directions, as small tables on the octahedral map.
//!
//! A receiver sees the lights of a cluster in directions that differ, so that the bound of a sum is the sum of each light's own bounds, and never
//! that of the summed intensity.

use crate::lanes::{LANES, Lanes, Lanes3};
use crate::math::float::floor;
use crate::math::octahedral::{direction_from_square, square_from_direction, wrapped_texel};
use crate::math::{Cone, Spread, Vec2, Vec3};
use std::f32::consts::{FRAC_1_SQRT_2, SQRT_2};
use std::sync::LazyLock;

/// Texels along an edge of the finest level, and of the next.
const SIDE: usize = 8;
const COARSE_SIDE: usize = 4;
/// Texels of the finest level.
pub(super) const TEXELS: usize = SIDE * SIDE;

/// Sums over lights of the largest luminance of each within sets of directions, in W/sr.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MaxMips {
    /// Within each of 8 x 8 texels.
    texels: [Above; TEXELS],
    /// Within a texel and its eight neighbors.
    around: [Above; TEXELS],
    /// The same on a map of 4 x 4 texels.
    coarse: [Above; COARSE_SIDE * COARSE_SIDE],
    everywhere: Above,
}

/// The upper half of a float that is not negative, rounded up: by 1/128 at most.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Above(u16);

impl Above {
    fn new(x: f32) -> Self {
        Above(((x.to_bits() + 0xffff) >> 16) as u16)
    }

    #[inline]
    fn get(self) -> f32 {
        f32::from_bits(u32::from(self.0) << 16)
    }
}

/// The largest value of each texel and its neighbors on a map of `side`² texels.
fn dilated<const N: usize>(values: &[f32; N], side: usize) -> [f32; N] {
    let side = side as i32;
    std::array::from_fn(|t| {
        let (i, j) = (t as i32 % side, t as i32 / side);
        let around = (0..9).map(|k| wrapped_texel(i + k % 3 - 1, j + k / 3 - 1, side));
        around.map(|t| values[t as usize]).fold(0.0, f32::max)
    })
}

/// The texel that the point `uv` of the unit square lies in.
#[inline(always)]
fn texel_at(uv: Vec2, side: usize) -> usize {
    let at = uv * side as f32;
    let (column, row) = (at.x as usize, at.y as usize);
    row.min(side - 1) * side + column.min(side - 1)
}

impl MaxMips {
    /// Of one light, from an upper bound of its luminance within each texel.
    pub(super) fn new(texels: [f32; TEXELS]) -> Self {
        let mut pairs = [0.0f32; COARSE_SIDE * COARSE_SIDE];
        for (t, &value) in texels.iter().enumerate() {
            let pair = t / SIDE / 2 * COARSE_SIDE + t % SIDE / 2;
            pairs[pair] = pairs[pair].max(value);
        }
        MaxMips {
            around: dilated(&texels, SIDE).map(Above::new),
            coarse: dilated(&pairs, COARSE_SIDE).map(Above::new),
            everywhere: Above::new(texels.into_iter().fold(0.0, f32::max)),
            texels: texels.map(Above::new),
        }
    }

    /// Adds the bounds of other lights.
    pub(super) fn add(&mut self, other: &MaxMips) {
        let own = self.texels.iter_mut().chain(&mut self.around);
        let own = own.chain(&mut self.coarse).chain([&mut self.everywhere]);
        let others = other.texels.iter().chain(&other.around);
        let others = others.chain(&other.coarse).chain([&other.everywhere]);
        for (sum, value) in own.zip(others) {
            *sum = Above::new(sum.get() + value.get());
        }
    }

    /// Every texel becomes the bound of all directions.
    #[cfg(any(test, feature = "testing"))]
    pub(super) fn forget_directions(&mut self) {
        let most = self.everywhere;
        self.texels.fill(most);
        self.around.fill(most);
        self.coarse.fill(most);
    }

    /// Upper bounds of the summed luminance towards one direction for each light, all of them so far from the unit vector in `axes`; lane by lane.
    ///
    /// Per radian, a direction moves by no more than `1/√2` of the unit square in either coordinate (measured: 0.7068 near ±x and ±y). So
    /// a cone whose half angle is `√2` texels of `1/side` stays within the texel of its axis and the neighbors of that.
    #[inline(always)]
    pub(super) fn bounds(&self, axes: &Lanes3, spreads: &[Spread; LANES]) -> Lanes {
        let (mut u, mut v) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let uv = square_from_direction(axes.vec(i));
            (u[i], v[i]) = (uv.x, uv.y);
        }
        let mut bounds = [0.0; LANES];
        for i in 0..LANES {
            bounds[i] = self.bound(Vec2::new(u[i], v[i]), spreads[i].half_angle);
        }
        bounds
    }

    /// The same for one direction for all lights.
    #[inline(always)]
    pub(super) fn along(&self, axis: Vec3) -> f32 {
        self.texels[texel_at(square_from_direction(axis), SIDE)].get()
    }

    /// The same for one direction, given by its place in the unit square.
    #[inline(always)]
    fn bound(&self, uv: Vec2, half_angle: f32) -> f32 {
        if half_angle > SQRT_2 / COARSE_SIDE as f32 {
            return self.everywhere.get();
        }
        let coarse = self.coarse[texel_at(uv, COARSE_SIDE)].get();
        if half_angle > SQRT_2 / SIDE as f32 {
            return coarse;
        }
        let bound = coarse.min(self.around[texel_at(uv, SIDE)].get());
        let reach = half_angle * FRAC_1_SQRT_2 * SIDE as f32;
        if reach > 0.5 {
            return bound;
        }
        bound.min(self.touched(uv * SIDE as f32, reach))
    }

    /// The sum over the texels, four at most, that a square of half the edge `reach` about `at` touches, both in texels.
    #[inline(always)]
    fn touched(&self, at: Vec2, reach: f32) -> f32 {
        let (left, right) = (floor(at.x - reach).1, floor(at.x + reach).1);
        let (top, bottom) = (floor(at.y - reach).1, floor(at.y + reach).1);
        let mut sum = 0.0;
        for row in top..=bottom {
            for column in left..=right {
                sum += self.texels[wrapped_texel(column, row, SIDE as i32) as usize].get();
            }
        }
        sum
    }
}

/// For each texel the largest bilinear value of a table of `side`² `values` within it.
pub(super) fn largest_in_texels(side: usize, values: impl Fn(usize) -> f32) -> [f32; TEXELS] {
    let mut texels = [0.0f32; TEXELS];
    let values: Vec<f32> = (0..side * side).map(values).collect();
    let first = |k: usize| k * SIDE / side;
    let last = |k: usize| ((k + 1) * SIDE - 1) / side;
    for j in 0..side {
        for i in 0..side {
            // Within this texel of the table, values are between those of the nine around.
            let around = (0..9).map(|k| {
                let (i, j) = (i as i32 + k % 3 - 1, j as i32 + k / 3 - 1);
                values[wrapped_texel(i, j, side as i32) as usize]
            });
            let largest = around.fold(0.0, f32::max);
            for row in first(j)..=last(j) {
                for column in first(i)..=last(i) {
                    let texel = &mut texels[row * SIDE + column];
                    *texel = texel.max(largest);
                }
            }
        }
    }
    texels
}

/// For each texel a cone that holds its directions.
pub(super) static TEXEL_CONES: LazyLock<[Cone; TEXELS]> = LazyLock::new(|| {
    /// Places along an edge of a texel that are asked.
    const PLACES: usize = 17;
    /// No place of the texel is farther from one of these, in radians: half a step in both coordinates, where directions move
    /// at most by `√18` per unit of the square that has the edge 2.
    const BETWEEN: f32 = 4.25 / (SIDE * (PLACES - 1)) as f32;
    std::array::from_fn(|t| {
        let corner = Vec2::new((t % SIDE) as f32, (t / SIDE) as f32);
        let at = |within: Vec2| direction_from_square((corner + within) / SIDE as f32);
        let cone = Cone::from_axis(at(Vec2::splat(0.5)));
        let angles = (0..PLACES * PLACES).map(|k| {
            let within = Vec2::new((k % PLACES) as f32, (k / PLACES) as f32);
            cone.angle_to_axis(at(within / (PLACES - 1) as f32))
        });
        Cone {
            half_angle: angles.fold(0.0, f32::max) + BETWEEN,
            ..cone
        }
    })
});

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::sampling::rng::Pcg;
    use crate::sampling::warp;

    #[test]
    fn texel_cones_hold_their_texels() {
        let mut rng = Pcg::new(3);
        for _ in 0..100_000 {
            let uv = Vec2::new(rng.next_f32(), rng.next_f32());
            let cone = TEXEL_CONES[texel_at(uv, SIDE)];
            let angle = cone.angle_to_axis(direction_from_square(uv));
            assert!(angle <= cone.half_angle, "{angle} in {cone:?}");
        }
        // Half the diagonal of a texel is 0.51 where texels are longest.
        assert!(TEXEL_CONES.iter().all(|cone| cone.half_angle < 0.6));
    }

    #[test]
    fn bounds_hold_for_one_texel_that_is_lit() {
        let mut rng = Pcg::new(4);
        for t in 0..TEXELS {
            let mut texels = [0.0; TEXELS];
            texels[t] = 1.0;
            let mips = MaxMips::new(texels);
            for _ in 0..20_000 {
                let axis = warp::sphere(Vec2::new(rng.next_f32(), rng.next_f32()));
                let half_angle = 0.5 * rng.next_f32().powi(2);
                let (sin, cos) = half_angle.sin_cos();
                let turn = 6.3 * rng.next_f32();
                let frame = crate::math::Frame::from_normal(axis);
                let w = frame.to_world(Vec3::new(sin * turn.cos(), sin * turn.sin(), cos));
                let lit = texel_at(square_from_direction(w), SIDE) == t;
                let spread = Spread::new(half_angle);
                let bound = mips.bound(square_from_direction(axis), spread.half_angle);
                assert!(
                    !lit || bound >= 1.0,
                    "{w} in texel {t} about {axis}, {half_angle}"
                );
            }
        }
    }

    #[test]
    fn rounding_goes_up() {
        let mut rng = Pcg::new(5);
        for x in [0.0, 1.0, f32::MIN_POSITIVE, 1e30, f32::INFINITY] {
            assert!(Above::new(x).get() >= x);
        }
        assert_eq!(Above::new(0.0).get(), 0.0);
        for _ in 0..10_000 {
            let x = (60.0 * rng.next_f32() - 30.0).exp();
            let above = Above::new(x).get();
            assert!((x..=1.0079 * x).contains(&above), "{x} -> {above}");
        }
    }

    #[test]
    fn small_cones_see_few_texels() {
        let mut texels = [0.0; TEXELS];
        texels[27] = 1.0;
        let mips = MaxMips::new(texels);
        let behind = square_from_direction(-direction_from_square(Vec2::splat(3.5 / 8.0)));
        assert_eq!(mips.bound(behind, 0.3), 0.0);
        assert_eq!(mips.bound(behind, std::f32::consts::PI), 1.0);
    }
}
