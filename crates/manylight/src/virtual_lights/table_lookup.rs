//! Bilinear lookups in octahedral tables; see [`crate::math::octahedral`].

use crate::lanes::{Float, Mask, One, Pair, Vector, Width, Word};
use crate::math::Vec3;
use crate::math::octahedral::wrapped_texel;
use crate::simd::array;

/// Texel indices (row-major, `row * side + column`) and weights of the bilinear lookup at the unit
/// vector `w` in a table of `side`² texels, with texel centers at `(i + 1/2) / side`. It wraps over
/// the edges of the map, so that the interpolant is continuous.
#[inline]
pub(super) fn bilinear(w: Vec3, side: usize) -> [(usize, f32); 4] {
    let cells = Cells::<One>::of(w.into(), side);
    let [cell] = cells.numbers.store();
    let corners = corners(cell, side);
    array(|k| {
        let (row, column) = corners[k];
        (row * side + column, cells.weights[k].get())
    })
}

/// The cells of each lane's direction: squares between four texel centers.
pub(super) struct Cells<S: Width> {
    /// Row and column of the first corner, each plus one, in the upper and lower half of a word:
    /// tables have fewer than 2¹⁶ texels along an edge.
    numbers: Word<S>,
    /// Bilinear weights of the corners.
    weights: [Float<S>; 4],
    side: usize,
}

impl<S: Width> Cells<S> {
    /// The cells of the unit directions `w` on a map of `side`² texels.
    #[inline(always)]
    pub(super) fn of(w: Vector<S>, side: usize) -> Self {
        let square = square_from_directions(w);
        let (x, y) = (square.x * side as f32 - 0.5, square.y * side as f32 - 0.5);
        let (column, row) = (x.floor(), y.floor());
        let (x, y) = (x - column, y - row);
        Cells {
            numbers: ((row + 1.0).to_word() << 16) + (column + 1.0).to_word(),
            weights: [(1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y],
            side,
        }
    }

    /// The words of the corners with their weights, with `texel(row, column)` the words of a texel.
    /// Inactive lanes hold any words.
    ///
    /// Lanes in one cell read its words once: towards a light, most of sixteen neighboring points
    /// share one or two cells.
    #[inline(always)]
    pub(super) fn words<const N: usize>(
        &self,
        active: Mask<S>,
        texel: impl Fn(usize, usize) -> [u32; N],
    ) -> [([Word<S>; N], Float<S>); 4] {
        let s = active.width();
        let mut words = [[Word::splat(s, 0); N]; 4];
        for (cell, lanes) in self.numbers.groups(active) {
            let corners = corners(cell, self.side);
            for k in 0..4 {
                let (row, column) = corners[k];
                for (all, word) in words[k].iter_mut().zip(texel(row, column)) {
                    *all = lanes.select_words(Word::splat(s, word), *all);
                }
            }
        }
        array(|k| (words[k], self.weights[k]))
    }
}

/// Rows and columns of the corners of a cell.
#[inline(always)]
fn corners(cell: u32, side: usize) -> [(usize, usize); 4] {
    // Minus one wraps around, and is then not within the map.
    let (row, column) = (
        (cell >> 16).wrapping_sub(1) as usize,
        (cell & 0xffff).wrapping_sub(1) as usize,
    );
    if row < side - 1 && column < side - 1 {
        return [
            (row, column),
            (row, column + 1),
            (row + 1, column),
            (row + 1, column + 1),
        ];
    }
    corners_across_edge(cell, side)
}

/// [`corners`] of a cell that an edge of the map crosses.
#[cold]
fn corners_across_edge(cell: u32, side: usize) -> [(usize, usize); 4] {
    let (row, column) = ((cell >> 16) as i32 - 1, (cell & 0xffff) as i32 - 1);
    array(|k| {
        let (across, down) = ((k & 1) as i32, (k >> 1) as i32);
        let texel = wrapped_texel(column + across, row + down, side as i32) as usize;
        (texel / side, texel % side)
    })
}

/// See [`square_from_direction`](crate::math::octahedral::square_from_direction).
#[inline(always)]
fn square_from_directions<S: Width>(w: Vector<S>) -> Pair<S> {
    let p = w * (w.x.abs() + w.y.abs() + w.z.abs()).recip();
    let above = p.z.ge(0.0);
    let x = above.select(p.x, (1.0 - p.y.abs()).copysign(p.x));
    let y = above.select(p.y, (1.0 - p.x.abs()).copysign(p.y));
    Pair::new(x * 0.5 + 0.5, y * 0.5 + 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::octahedral::texel_direction;

    #[test]
    fn bilinear_weights_sum_to_one_and_wrap_continuously() {
        let side = 32;
        let table: Vec<f32> = (0..side * side)
            .map(|t| texel_direction(t, side).dot(Vec3::new(0.3, 0.5, 0.8)))
            .collect();
        let eval = |w: Vec3| {
            bilinear(w, side)
                .iter()
                .map(|&(t, k)| table[t] * k)
                .sum::<f32>()
        };
        for i in 0..2000 {
            let z = 1.0 - 2.0 * (i as f32 + 0.5) / 2000.0;
            let (sin, cos) = (i as f32 * 2.399_963).sin_cos();
            let r = (1.0 - z * z).sqrt();
            let w = Vec3::new(r * cos, r * sin, z);
            let total: f32 = bilinear(w, side).iter().map(|t| t.1).sum();
            assert!((total - 1.0).abs() < 1e-5);
            let nudged = (w + Vec3::new(1e-5, -1e-5, 1e-5)).normalize();
            assert!((eval(w) - eval(nudged)).abs() < 2e-3, "jump at {w}");
        }
    }
}
