//! A picture of the surroundings in tiles: the choice of a cell and the texels around it come from the same few lines of memory.
//!
//! Pictures are larger than caches, and the places that samples ask for are random. So an alias table over tiles, small enough
//! to stay near, names one tile; all the rest is in there, and can be asked for before it is needed.

use super::environment::Environment;
use crate::color::Rgb;
use crate::math::Vec2;
use crate::math::prefetch::prefetch;
use crate::sampling::alias::{Alias, AliasRows};
use rayon::prelude::*;

/// Cells along the edge of a tile. A cell is the rectangle between four texel centers.
const EDGE: usize = 4;
/// Texels along the edge of a tile.
const TEXELS: usize = EDGE + 1;

/// See the module.
#[derive(Clone, Debug)]
pub(super) struct Tiles {
    /// Cells in a row: as many as columns of the picture.
    pub(super) width: usize,
    /// Rows of cells: one less than rows of the picture.
    pub(super) height: usize,
    across: usize,
    tiles: Vec<Tile>,
    /// Over rows of tiles.
    rows: Alias,
    /// Over the tiles of each row.
    columns: AliasRows,
}

#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Tile {
    /// Weight of the cells up to each, row by row.
    running: [f32; EDGE * EDGE],
    /// Row by row.
    texels: [Rgb; TEXELS * TEXELS],
}

/// A point between four texel centers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) column: usize,
    pub(super) row: usize,
    /// In [0, 1]².
    pub(super) within: Vec2,
}

/// The texels at (0,0), (1,0), (0,1), (1,1) of a cell.
pub(super) type Corners = [Rgb; 4];

impl Tiles {
    /// Cells are chosen in proportion to `weight(row, corners)`. `None` if none is positive.
    pub(super) fn new(
        environment: &Environment,
        weight: impl Fn(usize, &Corners) -> f32 + Sync,
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
            let mut tile = Tile {
                running: [0.0; EDGE * EDGE],
                texels,
            };
            let mut sum = 0.0f64;
            for k in 0..EDGE * EDGE {
                let (x, y) = (k % EDGE, k / EDGE);
                if left + x < width && top + y < height {
                    sum += f64::from(weight(top + y, &tile.corners(x, y)));
                }
                tile.running[k] = sum as f32;
            }
            tile
        };
        let tiles: Vec<Tile> = (0..across * down).into_par_iter().map(tile).collect();
        let totals: Vec<f32> = tiles.iter().map(Tile::total).collect();
        let row_sums: Vec<f32> = totals
            .chunks_exact(across)
            .map(|row| row.iter().map(|&w| f64::from(w)).sum::<f64>() as f32)
            .collect();
        Some(Tiles {
            width,
            height,
            across,
            tiles,
            rows: Alias::new(&row_sums)?,
            columns: AliasRows::new(&totals, across),
        })
    }

    /// A row of tiles in proportion to its weight, and what is left of `u`. Asks for the memory that [`Tiles::choose_tile`] will read.
    #[inline]
    pub(super) fn choose_row(&self, u: Vec2) -> (usize, Vec2) {
        let (row, u_y) = self.rows.sample_reusing(u.y);
        self.columns.prefetch(row, u.x);
        (row, Vec2::new(u.x, u_y))
    }

    /// A tile of the row in proportion to its weight, and what is left of `u`. Asks for the memory that [`Tiles::choose_cell`]
    /// will read.
    #[inline]
    pub(super) fn choose_tile(&self, row: usize, u: Vec2) -> (usize, Vec2) {
        let (column, u_x) = self.columns.sample_reusing(row, u.x);
        let tile = row * self.across + column;
        prefetch(&self.tiles[tile].running);
        (tile, Vec2::new(u_x, u.y))
    }

    /// A cell of the tile in proportion to its weight, and a uniform point in it. Asks for the memory of its corners.
    #[inline]
    pub(super) fn choose_cell(&self, tile: usize, u: Vec2) -> Place {
        let (x, y, within) = self.tiles[tile].choose(u);
        self.tiles[tile].prefetch_corners(x, y);
        Place {
            column: tile % self.across * EDGE + x,
            row: tile / self.across * EDGE + y,
            within,
        }
    }

    /// The texels around a cell.
    #[inline]
    pub(super) fn corners(&self, column: usize, row: usize) -> Corners {
        let tile = row / EDGE * self.across + column / EDGE;
        self.tiles[tile].corners(column % EDGE, row % EDGE)
    }
}

impl Tile {
    fn total(&self) -> f32 {
        self.running[EDGE * EDGE - 1]
    }

    #[inline]
    fn corners(&self, x: usize, y: usize) -> Corners {
        let first = y * TEXELS + x;
        let texels = &self.texels[first..first + TEXELS + 2];
        [texels[0], texels[1], texels[TEXELS], texels[TEXELS + 1]]
    }

    /// Asks for the memory that [`Tile::corners`] will read.
    #[inline]
    fn prefetch_corners(&self, x: usize, y: usize) {
        let first = y * TEXELS + x;
        for i in [0, 1, TEXELS, TEXELS + 1] {
            prefetch(&self.texels[first + i]);
        }
    }

    /// Column and row of a cell, and where in it.
    #[inline]
    fn choose(&self, u: Vec2) -> (usize, usize, Vec2) {
        let at = |i: usize| if i == 0 { 0.0 } else { self.running[i - 1] };
        let ends = std::array::from_fn(|y| at((y + 1) * EDGE));
        let (y, within_y) = choose(0.0, ends, u.y);
        let ends = std::array::from_fn(|x| at(y * EDGE + x + 1));
        let (x, within_x) = choose(at(y * EDGE), ends, u.x);
        (x, y, Vec2::new(within_x, within_y))
    }
}

/// Among intervals from `start` to and between the `ends`, the one that the fraction `u` falls into, and where in it, in [0, 1).
#[inline]
fn choose(start: f32, ends: [f32; EDGE], u: f32) -> (usize, f32) {
    const LARGEST: f32 = 1.0 - f32::EPSILON / 2.0;
    let last = ends[EDGE - 1];
    let target = start + u * (last - start);
    // Empty intervals at the end are never entered, whatever the rounding.
    let is_passed = |end: f32| end <= target && end < last;
    let chosen: usize = ends.iter().map(|&end| usize::from(is_passed(end))).sum();
    let below = if chosen == 0 { start } else { ends[chosen - 1] };
    let rest = (target - below) / (ends[chosen] - below);
    (chosen, rest.min(LARGEST))
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
        let weight = |row: usize, c: &Corners| {
            if c[0].r == 3.0 {
                0.0
            } else {
                c[0].r * (1.0 + row as f32)
            }
        };
        let tiles = Tiles::new(&environment, weight).unwrap();
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
        assert!(Tiles::new(&environment, |_, _| 0.0).is_none());
    }
}
