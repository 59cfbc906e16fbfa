//! The parts of the picture that are rendered at once.

use crate::math::UVec2;

/// Edge of a tile in pixels.
pub const TILE_SIZE: u32 = 8;

/// A rectangle of pixels within the crop window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Upper left pixel.
    pub origin: UVec2,
    /// At most [`TILE_SIZE`] squared.
    pub size: UVec2,
}

impl Tile {
    /// The pixels, row by row.
    pub fn pixels(self) -> impl Iterator<Item = UVec2> {
        (0..self.size.y)
            .flat_map(move |y| (0..self.size.x).map(move |x| self.origin + UVec2::new(x, y)))
    }

    /// How many there are.
    pub fn count(self) -> usize {
        (self.size.x * self.size.y) as usize
    }
}

/// The crop window divided into tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TileGrid {
    /// Of the window.
    size: UVec2,
    /// How far the first tile begins left of and above the window; less than [`TILE_SIZE`].
    shift: UVec2,
}

impl TileGrid {
    /// For a window of `size` pixels, moved up and to the left by so many pixels, which count modulo [`TILE_SIZE`].
    pub(super) fn new(size: UVec2, shift: UVec2) -> Self {
        TileGrid {
            size,
            shift: shift % TILE_SIZE,
        }
    }

    /// Tiles across and down.
    fn counts(self) -> UVec2 {
        let reach = self.size + self.shift + (TILE_SIZE - 1);
        reach / TILE_SIZE
    }

    /// How many tiles there are.
    pub(super) fn count(self) -> usize {
        (self.counts().x * self.counts().y) as usize
    }

    /// The tiles, row by row.
    pub(super) fn tiles(self) -> impl Iterator<Item = Tile> {
        let counts = self.counts();
        (0..counts.y).flat_map(move |y| (0..counts.x).map(move |x| self.tile(UVec2::new(x, y))))
    }

    /// The one so many tiles across and down.
    fn tile(self, place: UVec2) -> Tile {
        let start = place * TILE_SIZE;
        let origin = start.max(self.shift) - self.shift;
        let end = (start + TILE_SIZE - self.shift).min(self.size);
        Tile {
            origin,
            size: end - origin,
        }
    }

    /// The tile of a pixel, and which of its pixels that is; both count row by row.
    pub(super) fn locate(self, pixel: UVec2) -> (usize, usize) {
        let place = (pixel + self.shift) / TILE_SIZE;
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
        for (size, shift) in [
            (UVec2::new(19, 11), UVec2::ZERO),
            (UVec2::new(19, 11), UVec2::new(3, 7)),
            (UVec2::new(16, 8), UVec2::new(0, 5)),
            (UVec2::new(3, 2), UVec2::new(6, 6)),
            (UVec2::new(1, 1), UVec2::new(15, 7)),
        ] {
            let grid = TileGrid::new(size, shift);
            let tiles: Vec<Tile> = grid.tiles().collect();
            assert_eq!(tiles.len(), grid.count());
            let mut seen = 0;
            for (t, tile) in tiles.iter().enumerate() {
                assert!(tile.count() > 0 && tile.size.max_element() <= TILE_SIZE);
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
