//! An environment map stored in tiles, for the choice of a cell by weight.
//!
//! Environment maps are larger than caches, and samples access them at random. An alias table over
//! rows of tiles and over the tiles of each row fits into the cache. A tile holds the weights of
//! its cells next to their texels, so that a sample reads few cache lines, and they can be
//! prefetched.

use crate::color::Rgb;
use crate::emitters::Environment;
use crate::lanes::{Mask, Pair, Width};
use crate::math::Vec2;
use crate::math::float::ONE_MINUS_EPSILON;
use crate::math::prefetch::prefetch;
use crate::sampling::alias::{Alias, AliasRows};
use crate::simd::set_bits;
use rayon::prelude::*;

/// Cells along the edge of a tile. A cell is the rectangle between four texel centers. With 4, the
/// cumulative weights fill the one cache line that a choice searches, and a tile takes six cache
/// lines, 24 bytes per cell. With 2, it takes 32 bytes per cell, and there are four times as many
/// tiles to choose from; with 8, 20 bytes, and a choice searches four lines.
const EDGE: usize = 4;

/// Texels along the edge of a tile.
const TEXELS: usize = EDGE + 1;

/// An environment map in tiles, with tables for the choice of a cell.
#[derive(Clone, Debug)]
pub(super) struct EnvironmentTiles {
    /// Cells per row: the number of columns of the image.
    pub(super) width: usize,
    /// Rows of cells: one less than the rows of the image.
    pub(super) height: usize,
    /// Tiles per row.
    across: usize,
    /// Row by row.
    tiles: Vec<EnvironmentTile>,
    /// Choice of a row of tiles.
    rows: Alias,
    /// Choice of a tile within each row.
    columns: AliasRows,
}

#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct EnvironmentTile {
    /// Sum of the weights of the cells up to and including each, row by row.
    cumulative: [f32; EDGE * EDGE],
    /// Row by row.
    texels: [Rgb; TEXELS * TEXELS],
}

/// A point in a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellPoint {
    pub(super) column: usize,
    pub(super) row: usize,
    /// Position in the cell, in [0, 1]².
    pub(super) within: Vec2,
}

impl CellPoint {
    /// The middle of the first cell.
    const FIRST: CellPoint = CellPoint {
        column: 0,
        row: 0,
        within: Vec2::splat(0.5),
    };
}

/// The texels at the corners (0,0), (1,0), (0,1), (1,1) of a cell.
pub(super) type CellCorners = [Rgb; 4];

impl EnvironmentTiles {
    /// `weight(row, corners)` is the unnormalized probability of a cell. `None` if no weight is
    /// positive.
    pub(super) fn new(
        environment: &Environment,
        weight: impl Fn(usize, &CellCorners) -> f32 + Sync,
    ) -> Option<Self> {
        let image = &environment.image;
        let (width, height) = (image.width, (image.height - 1).max(1));
        let (across, down) = (width.div_ceil(EDGE), height.div_ceil(EDGE));
        let tile = |i: usize| {
            let (left, top) = (i % across * EDGE, i / across * EDGE);
            let columns: [usize; TEXELS] = std::array::from_fn(|k| (left + k) % width);
            let rows: [usize; TEXELS] = std::array::from_fn(|k| (top + k).min(image.height - 1));
            let texels = std::array::from_fn(|k| {
                image.rgb(columns[k % TEXELS], rows[k / TEXELS]) * environment.scale
            });
            let mut tile = EnvironmentTile {
                cumulative: [0.0; EDGE * EDGE],
                texels,
            };
            let mut sum = 0.0f64;
            for k in 0..EDGE * EDGE {
                let (x, y) = (k % EDGE, k / EDGE);
                if left + x < width && top + y < height {
                    sum += f64::from(weight(top + y, &tile.corners(x, y)));
                }
                tile.cumulative[k] = sum as f32;
            }
            tile
        };
        let tiles: Vec<EnvironmentTile> = (0..across * down).into_par_iter().map(tile).collect();
        let totals: Vec<f32> = tiles.iter().map(EnvironmentTile::total).collect();
        let row_sums: Vec<f32> = totals
            .chunks_exact(across)
            .map(|row| row.iter().map(|&w| f64::from(w)).sum::<f64>() as f32)
            .collect();
        Some(EnvironmentTiles {
            width,
            height,
            across,
            tiles,
            rows: Alias::new(&row_sums)?,
            columns: AliasRows::new(&totals, across),
        })
    }

    /// Chooses a row of tiles by weight. Returns it and two numbers that are uniform given the
    /// choice. Prefetches the memory of [`EnvironmentTiles::choose_tile`].
    #[inline]
    pub(super) fn choose_row(&self, u: Vec2) -> (usize, Vec2) {
        let (row, u_y) = self.rows.sample_reusing(u.y);
        self.columns.prefetch(row, u.x);
        (row, Vec2::new(u.x, u_y))
    }

    /// Chooses a tile of the row by weight. Returns it and two numbers that are uniform given the
    /// choice. Prefetches the memory of [`EnvironmentTiles::choose_cell`].
    #[inline]
    pub(super) fn choose_tile(&self, row: usize, u: Vec2) -> (usize, Vec2) {
        let (column, u_x) = self.columns.sample_reusing(row, u.x);
        let tile = row * self.across + column;
        prefetch(&self.tiles[tile].cumulative);
        (tile, Vec2::new(u_x, u.y))
    }

    /// Chooses a cell of the tile by weight, and a uniform point in it. Prefetches the corners of
    /// the cell.
    #[inline]
    pub(super) fn choose_cell(&self, tile: usize, u: Vec2) -> CellPoint {
        let (x, y, within) = self.tiles[tile].choose(u);
        self.tiles[tile].prefetch_corners(x, y);
        CellPoint {
            column: tile % self.across * EDGE + x,
            row: tile / self.across * EDGE + y,
            within,
        }
    }

    /// Cells in the lanes of `lanes`, chosen by weight, and uniform points in them. The lanes take
    /// each stage in turn, so that a stage reads memory that the stage before has prefetched.
    #[inline(always)]
    pub(super) fn choose_cells<S: Width>(&self, u: Pair<S>, lanes: Mask<S>) -> S::Each<CellPoint> {
        let (s, bits) = (lanes.width(), lanes.bits());
        let (x, y) = (u.x.store(), u.y.store());
        let numbers = |i: usize| Vec2::new(x.as_ref()[i], y.as_ref()[i]);
        let mut at = s.each(|i| (0, numbers(i)));
        for i in set_bits(bits) {
            at.as_mut()[i] = self.choose_row(numbers(i));
        }
        for i in set_bits(bits) {
            let (row, u) = at.as_ref()[i];
            at.as_mut()[i] = self.choose_tile(row, u);
        }
        let mut points = s.each(|_| CellPoint::FIRST);
        for i in set_bits(bits) {
            let (tile, u) = at.as_ref()[i];
            points.as_mut()[i] = self.choose_cell(tile, u);
        }
        points
    }

    /// The texels at the corners of a cell.
    #[inline]
    pub(super) fn corners(&self, column: usize, row: usize) -> CellCorners {
        let tile = row / EDGE * self.across + column / EDGE;
        self.tiles[tile].corners(column % EDGE, row % EDGE)
    }
}

impl EnvironmentTile {
    fn total(&self) -> f32 {
        self.cumulative[EDGE * EDGE - 1]
    }

    #[inline]
    fn corners(&self, x: usize, y: usize) -> CellCorners {
        let first = y * TEXELS + x;
        let texels = &self.texels[first..first + TEXELS + 2];
        [texels[0], texels[1], texels[TEXELS], texels[TEXELS + 1]]
    }

    /// Prefetches the memory of [`EnvironmentTile::corners`].
    #[inline]
    fn prefetch_corners(&self, x: usize, y: usize) {
        let first = y * TEXELS + x;
        for i in [0, 1, TEXELS, TEXELS + 1] {
            prefetch(&self.texels[first + i]);
        }
    }

    /// Column and row of a cell in the tile, chosen by weight, and a uniform point in it.
    #[inline]
    fn choose(&self, u: Vec2) -> (usize, usize, Vec2) {
        let at = |i: usize| if i == 0 { 0.0 } else { self.cumulative[i - 1] };
        let ends = std::array::from_fn(|y| at((y + 1) * EDGE));
        let (y, within_y) = choose(0.0, ends, u.y);
        let ends = std::array::from_fn(|x| at(y * EDGE + x + 1));
        let (x, within_x) = choose(at(y * EDGE), ends, u.x);
        (x, y, Vec2::new(within_x, within_y))
    }
}

/// Inverts a piecewise linear cumulative distribution from `start` with the values `ends`: returns
/// the interval in which the fraction `u` of the total lies, and the position in it in [0, 1).
#[inline]
fn choose(start: f32, ends: [f32; EDGE], u: f32) -> (usize, f32) {
    let last = ends[EDGE - 1];
    let target = start + u * (last - start);
    // Rounding must not select an empty interval at the end.
    let is_passed = |end: f32| end <= target && end < last;
    let chosen: usize = ends.iter().map(|&end| usize::from(is_passed(end))).sum();
    let below = if chosen == 0 { start } else { ends[chosen - 1] };
    let rest = (target - below) / (ends[chosen] - below);
    (chosen, rest.min(ONE_MINUS_EPSILON))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Image;
    use crate::math::Mat3;

    #[test]
    fn cells_are_chosen_by_weight() {
        let (width, height) = (19, 14);
        let environment = Environment {
            image: Image {
                width,
                height,
                channels: 1,
                data: (0..width * height).map(|i| (i % 7) as f32).collect(),
            },
            scale: 1.0,
            world_from_emitter: Mat3::IDENTITY,
        };
        let weight = |row: usize, c: &CellCorners| {
            if c[0].r == 3.0 {
                0.0
            } else {
                c[0].r * (1.0 + row as f32)
            }
        };
        let tiles = EnvironmentTiles::new(&environment, weight).unwrap();
        let n = 1000;
        let mut counts = vec![0; width * height];
        let mut mean = Vec2::ZERO;
        for i in 0..n * n {
            let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
            let (row, u) = tiles.choose_row(u);
            let (tile, u) = tiles.choose_tile(row, u);
            let p = tiles.choose_cell(tile, u);
            assert!(p.within.cmpge(Vec2::ZERO).all() && p.within.cmplt(Vec2::ONE).all());
            counts[p.row * width + p.column] += 1;
            mean += p.within / (n * n) as f32;
        }
        let image = &environment.image;
        let cell = |column: usize, row: usize| {
            let texel = |x: usize, y: usize| image.rgb(x % width, y);
            let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| texel(column + x, row + y));
            assert_eq!(corners, tiles.corners(column, row));
            weight(row, &corners)
        };
        let cells = (0..width * (height - 1)).map(|i| cell(i % width, i / width));
        let weights: Vec<f32> = cells.collect();
        let total: f32 = weights.iter().sum();
        for (count, weight) in counts.iter().zip(&weights) {
            let share = *count as f32 / (n * n) as f32;
            assert!((share - weight / total).abs() < 3e-4 && (*weight > 0.0 || *count == 0));
        }
        assert!((mean - 0.5).abs().max_element() < 1e-2, "{mean}");
        assert!(EnvironmentTiles::new(&environment, |_, _| 0.0).is_none());
    }
}
