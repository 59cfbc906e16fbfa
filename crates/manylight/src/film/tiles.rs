//! Tiles: the rectangles of pixels that are rendered together.

use crate::math::UVec2;

/// Edge of a tile in pixels. A tile has at most 64 of them: one bit each in the masks of visibility
/// blocks.
pub const TILE_SIZE: u32 = 8;

/// How a pass divides the crop window into tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tiling {
    /// Edge of a tile in pixels.
    pub edge: u32,
    /// Offset of the first tile to the left of and above the window, in pixels, modulo `edge`.
    pub shift: UVec2,
}

impl Tiling {
    /// Tiles of [`TILE_SIZE`], the first in the corner of the window.
    pub const UNSHIFTED: Tiling = Tiling {
        edge: TILE_SIZE,
        shift: UVec2::ZERO,
    };

    /// Tiles of camera paths that advance together, large so that most packets of one material are
    /// full.
    pub const OF_STREAMS: Tiling = Tiling {
        edge: 64,
        shift: UVec2::ZERO,
    };
}

/// A rectangle of pixels within the crop window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Upper left pixel.
    pub origin: UVec2,
    /// Width and height, each from 1 to the edge of its [`Tiling`].
    pub size: UVec2,
}

impl Tile {
    /// The pixels, row by row.
    pub fn pixels(self) -> impl Iterator<Item = UVec2> {
        (0..self.size.y)
            .flat_map(move |y| (0..self.size.x).map(move |x| self.origin + UVec2::new(x, y)))
    }

    /// Number of pixels.
    pub fn count(self) -> usize {
        (self.size.x * self.size.y) as usize
    }
}

/// The crop window divided into tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TileGrid {
    /// Size of the window in pixels.
    size: UVec2,
    /// Edge of a tile in pixels.
    edge: u32,
    /// Offset of the first tile to the left of and above the window, in pixels; less than the edge.
    shift: UVec2,
}

impl TileGrid {
    /// Tiles over a window of `size` pixels.
    pub(super) fn new(size: UVec2, tiling: Tiling) -> Self {
        let Tiling { edge, shift } = tiling;
        TileGrid {
            size,
            edge,
            shift: shift % edge,
        }
    }

    /// Number of tiles across and down.
    fn counts(self) -> UVec2 {
        let reach = self.size + self.shift + (self.edge - 1);
        reach / self.edge
    }

    /// Number of tiles.
    pub(super) fn count(self) -> usize {
        (self.counts().x * self.counts().y) as usize
    }

    /// The tiles, row by row.
    pub(super) fn tiles(self) -> impl Iterator<Item = Tile> {
        let counts = self.counts();
        (0..counts.y).flat_map(move |y| (0..counts.x).map(move |x| self.tile(UVec2::new(x, y))))
    }

    /// The tile in column `place.x`, row `place.y`.
    fn tile(self, place: UVec2) -> Tile {
        let start = place * self.edge;
        let origin = start.max(self.shift) - self.shift;
        let end = (start + self.edge - self.shift).min(self.size);
        Tile {
            origin,
            size: end - origin,
        }
    }

    /// Index of the tile that holds a pixel, and index of the pixel in that tile; both in row
    /// order.
    pub(super) fn locate(self, pixel: UVec2) -> (usize, usize) {
        let place = (pixel + self.shift) / self.edge;
        let tile = self.tile(place);
        let within = pixel - tile.origin;
        (
            (place.y * self.counts().x + place.x) as usize,
            (within.y * tile.size.x + within.x) as usize,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_is_in_one_tile() {
        for (size, edge, shift) in [
            (UVec2::new(19, 11), 8, UVec2::ZERO),
            (UVec2::new(19, 11), 8, UVec2::new(3, 7)),
            (UVec2::new(19, 11), 16, UVec2::new(3, 7)),
            (UVec2::new(16, 8), 8, UVec2::new(0, 5)),
            (UVec2::new(3, 2), 8, UVec2::new(6, 6)),
            (UVec2::new(1, 1), 8, UVec2::new(15, 7)),
        ] {
            let grid = TileGrid::new(size, Tiling { edge, shift });
            let tiles: Vec<Tile> = grid.tiles().collect();
            assert_eq!(tiles.len(), grid.count());
            let mut seen = 0;
            for (t, tile) in tiles.iter().enumerate() {
                assert!(tile.count() > 0 && tile.size.max_element() <= edge);
                for (i, pixel) in tile.pixels().enumerate() {
                    assert!(pixel.cmplt(size).all());
                    assert_eq!(grid.locate(pixel), (t, i), "{pixel} {shift}");
                    seen += 1;
                }
            }
            assert_eq!(seen, size.x * size.y);
        }
    }
}
