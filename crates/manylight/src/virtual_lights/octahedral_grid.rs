//! The octahedral grid of all tables of one size: texel directions, solid angles, and integrals of
//! bilinear functions.

use super::table_lookup::bilinear;
use crate::color::Rgb;
use crate::math::octahedral::{
    direction_from_square, solid_angle_density, texel_direction, wrapped_texel,
};
use crate::math::{Vec2, Vec3};
use crate::simd::{Isa, Simd, SimdKernel};

/// Number of sub-samples along an edge of a texel in integrals cut at the horizon. The integral
/// then is exact to about 1e-4 (see the tests).
const FINE: usize = 6;
/// Number of sub-samples along an edge of a texel in the mean of narrow lobes.
const COARSE: usize = 2;

/// Sub-samples of one texel, row by row.
#[derive(Clone, Debug)]
struct SubSamples<const COUNT: usize> {
    /// Unit directions, by component.
    w: [[f32; COUNT]; 3],
    /// Solid angles, in sr.
    solid_angle: [f32; COUNT],
}

impl<const COUNT: usize> SubSamples<COUNT> {
    /// The sub-samples of texel `t` in a grid of `side`² texels.
    fn new(t: usize, side: usize) -> Self {
        let mut all = SubSamples {
            w: [[0.0; COUNT]; 3],
            solid_angle: [0.0; COUNT],
        };
        let fine = COUNT.isqrt();
        for s in 0..COUNT {
            let offset = Vec2::new((s % fine) as f32 + 0.5, (s / fine) as f32 + 0.5) / fine as f32;
            let uv = (Vec2::new((t % side) as f32, (t / side) as f32) + offset) / side as f32;
            let w = direction_from_square(uv);
            for axis in 0..3 {
                all.w[axis][s] = w[axis];
            }
            all.solid_angle[s] = solid_angle_density(uv) / ((side * fine) as f32).powi(2);
        }
        all
    }

    fn direction(&self, s: usize) -> Vec3 {
        Vec3::new(self.w[0][s], self.w[1][s], self.w[2][s])
    }
}

/// An octahedral grid of `side`² texels.
#[derive(Debug)]
pub(super) struct Grid {
    side: usize,
    /// Directions of the texel centers, unit.
    centers: Vec<Vec3>,
    /// Integrals of the bilinear hat functions of the texels over the sphere, in sr.
    pub(super) hats: Vec<f32>,
    fine: Vec<SubSamples<{ FINE * FINE }>>,
    /// One over the widths of the fine sub-samples of each texel, in 1/√sr.
    fine_inv_widths: Vec<[f32; FINE * FINE]>,
    /// By texel: its samples in the mean of narrow lobes.
    coarse: Vec<[TexelSample; COARSE * COARSE]>,
}

/// A direction within a texel.
#[derive(Clone, Copy, Debug)]
pub(super) struct TexelSample {
    pub(super) texel: usize,
    /// Unit direction.
    pub(super) w: Vec3,
    /// Fraction of the texel's solid angle.
    pub(super) share: f32,
}

impl TexelSample {
    /// The samples in the mean of narrow lobes over texel `t`.
    fn within(t: usize, side: usize) -> [TexelSample; COARSE * COARSE] {
        let samples = SubSamples::<{ COARSE * COARSE }>::new(t, side);
        let total: f32 = samples.solid_angle.iter().sum();
        std::array::from_fn(|s| TexelSample {
            texel: t,
            w: samples.direction(s),
            share: samples.solid_angle[s] / total,
        })
    }
}

impl Grid {
    /// A grid of `side`² texels; `side` must be even.
    pub(super) fn new(side: usize) -> Self {
        assert!(
            side >= 2 && side.is_multiple_of(2),
            "the side of a table is even: it has blocks of 2 x 2 texels"
        );
        let mut hats = vec![0.0; side * side];
        for t in 0..side * side {
            const COUNT: usize = 4 * FINE * FINE;
            let samples = SubSamples::<COUNT>::new(t, side);
            for s in 0..COUNT {
                for (texel, weight) in bilinear(samples.direction(s), side) {
                    hats[texel] += weight * samples.solid_angle[s];
                }
            }
        }
        let texels = 0..side * side;
        let fine: Vec<SubSamples<_>> = texels.clone().map(|t| SubSamples::new(t, side)).collect();
        let inv_widths = fine.iter().map(|samples| {
            let width = |s: usize| samples.solid_angle[s].sqrt();
            std::array::from_fn(|s| width(s).recip())
        });
        Grid {
            side,
            fine_inv_widths: inv_widths.collect(),
            centers: texels.clone().map(|t| texel_direction(t, side)).collect(),
            hats,
            fine,
            coarse: texels.map(|t| TexelSample::within(t, side)).collect(),
        }
    }

    /// Texels along an edge.
    pub(super) fn side(&self) -> usize {
        self.side
    }

    /// The direction of a texel's center.
    pub(super) fn center(&self, t: usize) -> Vec3 {
        self.centers[t]
    }

    /// The first texels of all blocks of 2 x 2.
    pub(super) fn blocks(&self) -> impl Iterator<Item = usize> {
        let (side, half) = (self.side, self.side / 2);
        (0..half * half).map(move |b| 2 * (b / half) * side + 2 * (b % half))
    }

    /// The four texels of the block with the first texel `corner`.
    pub(super) fn block(&self, corner: usize) -> [usize; 4] {
        [
            corner,
            corner + 1,
            corner + self.side,
            corner + self.side + 1,
        ]
    }

    /// The center of texel `t`.
    pub(super) fn at_center(&self, t: usize) -> TexelSample {
        TexelSample {
            texel: t,
            w: self.centers[t],
            share: 1.0,
        }
    }

    /// Directions within texel `t`.
    pub(super) fn within_texel(&self, t: usize) -> &[TexelSample] {
        &self.coarse[t]
    }

    /// Integral of the bilinear function over the sphere, or above the horizon of the unit normal
    /// `n`: that of all hats minus the part below the horizon.
    pub(super) fn integral(&self, texels: &[Rgb], n: Option<Vec3>) -> Rgb {
        let mut sum = [0.0f64; 3];
        for (texel, &hat) in texels.iter().zip(&self.hats) {
            for (s, v) in sum.iter_mut().zip(texel.to_array()) {
                *s += f64::from(v) * f64::from(hat);
            }
        }
        if let Some(n) = n {
            let below = Isa::best().run(BelowHorizon {
                grid: self,
                texels,
                n,
            });
            for (s, b) in sum.iter_mut().zip(below) {
                *s -= b;
            }
        }
        Rgb::new(sum[0] as f32, sum[1] as f32, sum[2] as f32)
    }
}

/// Integral below the horizon of `n` of the bilinear function of `texels`, of which those with
/// centers below the horizon are black.
struct BelowHorizon<'a> {
    grid: &'a Grid,
    texels: &'a [Rgb],
    n: Vec3,
}

impl SimdKernel for BelowHorizon<'_> {
    type Output = [f64; 3];

    #[inline(always)]
    fn run<S: Simd>(self, _s: S) -> [f64; 3] {
        let BelowHorizon { grid, texels, n } = self;
        let side = grid.side as i32;
        // Only texels that extend below the horizon and have a neighbor with its center above: a
        // texel measures at most 4.3 / side rad from center to corner.
        let (above, below) = (4.5 / side as f32, -9.5 / side as f32);
        let mut sum = [0.0f64; 3];
        for (t, center) in grid.centers.iter().enumerate() {
            if !(below..above).contains(&center.dot(n)) {
                continue;
            }
            let (i, j) = (t as i32 % side, t as i32 / side);
            let is_inside = i.min(j) > 0 && i.max(j) < side - 1;
            let solid_angles = neighbor_solid_angles(&grid.fine[t], &grid.fine_inv_widths[t], n);
            let mut around = Rgb::BLACK;
            for (k, solid_angle) in solid_angles.into_iter().enumerate() {
                let (di, dj) = (k as i32 % 3 - 1, k as i32 / 3 - 1);
                let neighbor = match is_inside {
                    true => (j + dj) * side + i + di,
                    false => wrapped_texel(i + di, j + dj, side),
                };
                around += texels[neighbor as usize] * solid_angle;
            }
            for (s, v) in sum.iter_mut().zip(around.to_array()) {
                *s += f64::from(v);
            }
        }
        sum
    }
}

/// Solid angle, in sr, of a texel below the horizon of `n`, divided among the 3 x 3 texels around
/// it by their bilinear weights.
#[inline(always)]
fn neighbor_solid_angles(
    samples: &SubSamples<{ FINE * FINE }>,
    inv_widths: &[f32; FINE * FINE],
    n: Vec3,
) -> [f32; 9] {
    let mut below = [0.0; FINE * FINE];
    for (s, below) in below.iter_mut().enumerate() {
        let cos = samples.w[0][s] * n.x + samples.w[1][s] * n.y + samples.w[2][s] * n.z;
        // A sub-sample on the horizon counts by its fraction below.
        let fraction = (0.5 - cos * inv_widths[s]).clamp(0.0, 1.0);
        *below = fraction * samples.solid_angle[s];
    }
    // Weighted sums over rows first, then over columns.
    let mut columns = [[0.0; FINE]; 3];
    for (row, below) in below.chunks_exact(FINE).enumerate() {
        for (dj, column) in columns.iter_mut().enumerate() {
            for (sum, below) in column.iter_mut().zip(below) {
                *sum += HATS[dj][row] * below;
            }
        }
    }
    std::array::from_fn(|k| {
        let column = columns[k / 3].iter().zip(&HATS[k % 3]);
        column.map(|(sum, hat)| sum * hat).sum()
    })
}

/// Bilinear weights, along one axis, of the previous, the own and the next texel at each
/// sub-sample.
const HATS: [[f32; FINE]; 3] = hats();

const fn hats() -> [[f32; FINE]; 3] {
    let mut hats = [[0.0; FINE]; 3];
    let mut s = 0;
    while s < FINE {
        let from_center = (s as f32 + 0.5) / FINE as f32 - 0.5;
        if from_center < 0.0 {
            hats[0][s] = -from_center;
            hats[1][s] = 1.0 + from_center;
        } else {
            hats[1][s] = 1.0 - from_center;
            hats[2][s] = from_center;
        }
        s += 1;
    }
    hats
}
