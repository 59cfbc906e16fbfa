//! Bilinear lookups in octahedral tables; see [`crate::math::octahedral`].

use super::table_blocks::EDGE;
use crate::lanes::{Float, Mask, One, Pair, Vector, Width};
use crate::math::Vec3;
use crate::simd::array;

/// Texel indices (row-major, `row * side + column`) and weights of the bilinear lookup at the unit
/// vector `w` in a table of `side`² texels, with texel centers at `(i + 1/2) / side`. It wraps over
/// the edges of the map, so that the interpolant is continuous.
#[inline]
pub(super) fn bilinear(w: Vec3, side: usize) -> [(usize, f32); 4] {
    let corners = TexelCorners::<One>::of(w.into(), side as f32, Mask::splat(One, true));
    array(|k| {
        let [texel] = corners.in_rows(k);
        (texel as usize, corners.weights[k].get())
    })
}

/// The four texels around each lane's direction and their bilinear weights; inactive lanes hold any
/// value.
pub(super) struct TexelCorners<S: Width> {
    /// Rows and columns.
    places: [(Float<S>, Float<S>); 4],
    pub(super) weights: [Float<S>; 4],
    side: f32,
}

impl<S: Width> TexelCorners<S> {
    /// The corners for the unit directions `w` on a map of `side`² texels.
    #[inline(always)]
    pub(super) fn of(w: Vector<S>, side: f32, active: Mask<S>) -> Self {
        let square = square_from_directions(w);
        let (x, y) = (square.x * side - 0.5, square.y * side - 0.5);
        let (column, row) = (x.floor(), y.floor());
        let (x, y) = (x - column, y - row);
        let inside = column.min(row).ge(0.0) & column.max(row).lt(side - 1.0);
        let mut places = [
            (row, column),
            (row, column + 1.0),
            (row + 1.0, column),
            (row + 1.0, column + 1.0),
        ];
        if (active & !inside).any() {
            for place in &mut places {
                *place = wrapped_texels(*place, side);
            }
        }
        TexelCorners {
            places,
            weights: [(1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y],
            side,
        }
    }

    /// Indices of the texels of corner `k`, row by row.
    #[inline(always)]
    pub(super) fn in_rows(&self, k: usize) -> S::Each<u32> {
        // Indices are exact in floats: tables have fewer than 2²² texels.
        let (row, column) = self.places[k];
        let last = self.side * self.side - 1.0;
        let index = row * self.side + column;
        index.clamp(0.0, last).to_word().store()
    }

    /// Indices of the texels of corner `k`, block by block of [`EDGE`]² texels.
    #[inline(always)]
    pub(super) fn in_blocks(&self, k: usize) -> S::Each<u32> {
        const WIDTH: f32 = EDGE as f32;
        let across = (self.side / WIDTH).ceil();
        let (row, column) = self.places[k];
        let (row, column) = (
            row.clamp(0.0, self.side - 1.0),
            column.clamp(0.0, self.side - 1.0),
        );
        let (block_row, block_column) = (
            (row * (1.0 / WIDTH)).floor(),
            (column * (1.0 / WIDTH)).floor(),
        );
        let block = block_row * across + block_column;
        let (row, column) = (row - block_row * WIDTH, column - block_column * WIDTH);
        (block * (WIDTH * WIDTH) + row * WIDTH + column)
            .to_word()
            .store()
    }
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

/// Row and column of texels with both from -1 to `side`; see
/// [`wrapped_texel`](crate::math::octahedral::wrapped_texel).
#[inline(always)]
fn wrapped_texels<S: Width>(
    (row, column): (Float<S>, Float<S>),
    side: f32,
) -> (Float<S>, Float<S>) {
    let beyond = column.lt(0.0) | column.ge(side);
    let row = beyond.select(side - 1.0 - row, row);
    let column = column.clamp(0.0, side - 1.0);
    let beyond = row.lt(0.0) | row.ge(side);
    let column = beyond.select(side - 1.0 - column, column);
    (row.clamp(0.0, side - 1.0), column)
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
