//! Bilinear lookups in octahedral tables for [`LANES`] directions at once.
#![expect(
    clippy::needless_range_loop,
    reason = "loops over lanes read like what they become: vector instructions"
)]

use super::tables::{OctahedralTable, Texel, Texels};
use crate::lanes::vectors::{mul3, splat3};
use crate::lanes::{LANES, LaneMask, Lanes, Lanes3};
use crate::math::octahedral::BilinearLookup;
use crate::math::{Vec2, Vec3};
use crate::simd::Wide;

impl OctahedralTable<'_> {
    /// [`OctahedralTable::lookup`] in the directions `-wi`, lane by lane; inactive lanes hold any value.
    #[inline(always)]
    pub(super) fn lookups<W: Wide>(&self, w: W, wi: &Lanes3, active: LaneMask) -> Lanes3 {
        let corners = TexelCorners::of(w, wi, self.side as i32, active);
        let sum = match self.texels {
            Texels::Float(texels) => corners.sum(w, texels),
            Texels::Shared(texels) => corners.sum(w, texels),
        };
        let scale = splat3(w, Vec3::from(self.scale.to_array()));
        Lanes3::store(w, mul3(w, sum, scale))
    }
}

/// The four texels around each lane's direction and their bilinear weights; inactive lanes hold any value.
struct TexelCorners {
    texels: [[i32; LANES]; 4],
    weights: [Lanes; 4],
}

impl TexelCorners {
    /// The corners for the directions `-wi` on a map of `side`² texels.
    #[inline(always)]
    fn of<W: Wide>(w: W, wi: &Lanes3, side: i32, active: LaneMask) -> Self {
        let (mut columns, mut rows) = ([0; LANES], [0; LANES]);
        let (mut x, mut y) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let place = BilinearLookup::of(-wi.vec(i), side);
            (columns[i], rows[i]) = (place.column, place.row);
            (x[i], y[i]) = (place.fraction.x, place.fraction.y);
        }
        let place = |i: usize| BilinearLookup {
            column: columns[i],
            row: rows[i],
            fraction: Vec2::new(x[i], y[i]),
        };
        let mut corners = TexelCorners {
            texels: [[0; LANES]; 4],
            weights: [[0.0; LANES]; 4],
        };
        for i in 0..LANES {
            let weights = place(i).weights();
            for k in 0..4 {
                corners.weights[k][i] = weights[k];
            }
        }
        if active & !inside(w, &columns, &rows, side) == 0 {
            for i in 0..LANES {
                let first = rows[i].wrapping_mul(side).wrapping_add(columns[i]);
                corners.texels[0][i] = first;
                corners.texels[1][i] = first.wrapping_add(1);
                corners.texels[2][i] = first.wrapping_add(side);
                corners.texels[3][i] = first.wrapping_add(side + 1);
            }
        } else {
            for i in 0..LANES {
                let texels = place(i).texels(side);
                for k in 0..4 {
                    corners.texels[k][i] = texels[k];
                }
            }
        }
        corners
    }

    /// The weighted sums of the texels of `table`.
    #[inline(always)]
    fn sum<W: Wide, T: Texel>(&self, w: W, table: &[T]) -> [W::F; 3] {
        let mut sum = [w.splat(0.0); 3];
        for (texels, weights) in self.texels.iter().zip(&self.weights) {
            let fetched = fetch(table, texels);
            let mut values = Lanes3::ZERO;
            for i in 0..LANES {
                values.set(i, fetched[i].rgb());
            }
            let weight = w.load(weights);
            for (sum, value) in sum.iter_mut().zip(values.load(w)) {
                *sum = w.mul_add(value, weight, *sum);
            }
        }
        sum
    }
}

/// The lanes with four texels that no edge of the map separates: their indices need no wrapping.
#[inline(always)]
fn inside<W: Wide>(w: W, columns: &[i32; LANES], rows: &[i32; LANES], side: i32) -> LaneMask {
    let (mut lowest, mut highest) = ([0.0; LANES], [0.0; LANES]);
    for i in 0..LANES {
        let (column, row) = (columns[i] as f32, rows[i] as f32);
        lowest[i] = column.min(row);
        highest[i] = column.max(row);
    }
    let (first, last) = (w.splat(0.0), w.splat((side - 1) as f32));
    let inside = w.and(w.le(first, w.load(&lowest)), w.lt(w.load(&highest), last));
    w.bits(inside) as LaneMask
}

/// The texels with the given indices; the last texel for an index out of range.
#[inline(always)]
fn fetch<T: Texel>(table: &[T], texels: &[i32; LANES]) -> [T; LANES] {
    let mut out = [T::zeroed(); LANES];
    if let Some(last) = table.len().checked_sub(1) {
        let texels = texels.map(|t| (t as u32).min(last as u32));
        for i in 0..LANES {
            out[i] = table[texels[i] as usize];
        }
    }
    out
}
