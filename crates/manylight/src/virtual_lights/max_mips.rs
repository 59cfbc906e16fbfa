//! Upper bounds of radiant intensity over cones of directions, as small tables on the octahedral
//! map.
//!
//! A receiver sees the lights of a cluster in different directions. So the bound of a cluster is
//! the sum over its lights of the maximum of each, and not the maximum of the summed intensity.

use crate::lanes::{LANES, Lanes, Lanes3};
use crate::math::float::floor;
use crate::math::octahedral::{direction_from_square, square_from_direction, wrapped_texel};
use crate::math::{Cone, Spread, Vec2, Vec3};
use std::f32::consts::{FRAC_1_SQRT_2, SQRT_2};
use std::sync::LazyLock;

/// Texels along an edge of the finest level. More texels give tighter bounds and larger nodes; 8 x
/// 8 with the coarse level take 290 bytes.
const SIDE: usize = 8;
/// Texels along an edge of the coarse level.
const COARSE_SIDE: usize = 4;
/// Number of texels of the finest level.
pub(super) const TEXELS: usize = SIDE * SIDE;

/// Sums over lights of the maximum luminance of each light within sets of directions, in W/sr.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MaxMips {
    /// Within each texel of the finest level.
    texels: [RoundedUp; TEXELS],
    /// Within each texel of the finest level and its eight neighbors.
    dilated: [RoundedUp; TEXELS],
    /// Within each texel of the coarse level and its eight neighbors.
    coarse: [RoundedUp; COARSE_SIDE * COARSE_SIDE],
    /// Over all directions.
    everywhere: RoundedUp,
}

/// A non-negative number in 16 bits: the upper half of an f32, rounded up by at most 1/128.
#[derive(Clone, Copy, Debug, PartialEq)]
struct RoundedUp(u16);

impl RoundedUp {
    fn new(x: f32) -> Self {
        RoundedUp(((x.to_bits() + 0xffff) >> 16) as u16)
    }

    #[inline]
    fn get(self) -> f32 {
        f32::from_bits(u32::from(self.0) << 16)
    }
}

/// For each texel of an octahedral map of `side`² texels the maximum over itself and its eight
/// neighbors.
fn dilate<const N: usize>(values: &[f32; N], side: usize) -> [f32; N] {
    let side = side as i32;
    std::array::from_fn(|t| {
        let (i, j) = (t as i32 % side, t as i32 / side);
        let around = (0..9).map(|k| wrapped_texel(i + k % 3 - 1, j + k / 3 - 1, side));
        around.map(|t| values[t as usize]).fold(0.0, f32::max)
    })
}

/// Index of the texel that contains the point `uv` of the unit square.
#[inline(always)]
fn texel_at(uv: Vec2, side: usize) -> usize {
    let at = uv * side as f32;
    let (column, row) = (at.x as usize, at.y as usize);
    row.min(side - 1) * side + column.min(side - 1)
}

impl MaxMips {
    /// The bounds of one light, from upper bounds of its luminance within each texel of the finest
    /// level.
    pub(super) fn new(texels: [f32; TEXELS]) -> Self {
        let mut blocks = [0.0f32; COARSE_SIDE * COARSE_SIDE];
        for (t, &value) in texels.iter().enumerate() {
            let block = t / SIDE / 2 * COARSE_SIDE + t % SIDE / 2;
            blocks[block] = blocks[block].max(value);
        }
        MaxMips {
            dilated: dilate(&texels, SIDE).map(RoundedUp::new),
            coarse: dilate(&blocks, COARSE_SIDE).map(RoundedUp::new),
            everywhere: RoundedUp::new(texels.into_iter().fold(0.0, f32::max)),
            texels: texels.map(RoundedUp::new),
        }
    }

    /// Adds the bounds of other lights.
    pub(super) fn add(&mut self, other: &MaxMips) {
        let own = self.texels.iter_mut().chain(&mut self.dilated);
        let own = own.chain(&mut self.coarse).chain([&mut self.everywhere]);
        let others = other.texels.iter().chain(&other.dilated);
        let others = others.chain(&other.coarse).chain([&other.everywhere]);
        for (sum, value) in own.zip(others) {
            *sum = RoundedUp::new(sum.get() + value.get());
        }
    }

    /// Upper bounds of the summed luminance, lane by lane, with a direction for each light within
    /// the angle of `spreads` from the unit vectors `axes`.
    ///
    /// A rotation by one radian moves a direction by at most `1/√2` of the unit square in each
    /// coordinate (measured: 0.7068 near ±x and ±y). So a cone with half angle `√2 / side` lies
    /// within the texel of its axis and the eight neighbors.
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

    /// [`MaxMips::bounds`] of one cone.
    pub(super) fn within(&self, axis: Vec3, spread: Spread) -> f32 {
        self.bound(square_from_direction(axis), spread.half_angle)
    }

    /// The upper bound for one unit direction, common to all lights.
    #[inline(always)]
    pub(super) fn along(&self, axis: Vec3) -> f32 {
        self.texels[texel_at(square_from_direction(axis), SIDE)].get()
    }

    /// [`MaxMips::bounds`] of one cone, its axis given as a point of the unit square.
    #[inline(always)]
    fn bound(&self, uv: Vec2, half_angle: f32) -> f32 {
        if half_angle > SQRT_2 / COARSE_SIDE as f32 {
            return self.everywhere.get();
        }
        let coarse = self.coarse[texel_at(uv, COARSE_SIDE)].get();
        if half_angle > SQRT_2 / SIDE as f32 {
            return coarse;
        }
        let bound = coarse.min(self.dilated[texel_at(uv, SIDE)].get());
        let reach = half_angle * FRAC_1_SQRT_2 * SIDE as f32;
        if reach > 0.5 {
            return bound;
        }
        bound.min(self.overlapped(uv * SIDE as f32, reach))
    }

    /// Sum over the at most four texels that overlap the square with center `at` and half edge
    /// `reach`, both in texels.
    #[inline(always)]
    fn overlapped(&self, at: Vec2, reach: f32) -> f32 {
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

/// For each texel of the finest level the maximum of the bilinear function of `side`² texels with
/// the given `values`.
pub(super) fn largest_in_texels(side: usize, values: impl Fn(usize) -> f32) -> [f32; TEXELS] {
    let mut texels = [0.0f32; TEXELS];
    let values: Vec<f32> = (0..side * side).map(values).collect();
    let first = |k: usize| k * SIDE / side;
    let last = |k: usize| ((k + 1) * SIDE - 1) / side;
    for j in 0..side {
        for i in 0..side {
            // Within this texel of the table the bilinear function is at most the maximum of the 3
            // x 3 texels around.
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

/// For each texel of the finest level a cone that contains its directions.
pub(super) static TEXEL_CONES: LazyLock<[Cone; TEXELS]> = LazyLock::new(|| {
    /// Number of sample points along an edge of a texel.
    const SAMPLES: usize = 17;
    /// Largest angle from a point of the texel to the nearest sample, in rad: half a step in both
    /// coordinates, with at most `√18` rad per unit of the square of edge 2.
    const SAMPLE_DISTANCE: f32 = 4.25 / (SIDE * (SAMPLES - 1)) as f32;
    std::array::from_fn(|t| {
        let corner = Vec2::new((t % SIDE) as f32, (t / SIDE) as f32);
        let at = |within: Vec2| direction_from_square((corner + within) / SIDE as f32);
        let cone = Cone::from_axis(at(Vec2::splat(0.5)));
        let angles = (0..SAMPLES * SAMPLES).map(|k| {
            let within = Vec2::new((k % SAMPLES) as f32, (k / SAMPLES) as f32);
            cone.angle_to_axis(at(within / (SAMPLES - 1) as f32))
        });
        Cone {
            half_angle: angles.fold(0.0, f32::max) + SAMPLE_DISTANCE,
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
            assert!(RoundedUp::new(x).get() >= x);
        }
        assert_eq!(RoundedUp::new(0.0).get(), 0.0);
        for _ in 0..10_000 {
            let x = (60.0 * rng.next_f32() - 30.0).exp();
            let above = RoundedUp::new(x).get();
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
