//! The samples of one pass in one tile.

use super::layer::Slots;
use super::{Layer, Tile};
use crate::color::Rgb;

/// The samples of one pass in one tile: one value per pixel and recorded layer.
#[derive(Debug)]
pub struct TileSamples<'f> {
    pub(super) tile: Tile,
    pub(super) slots: Slots,
    /// Number of recorded layers. The values of one pixel are adjacent, in layer order.
    pub(super) stride: usize,
    pub(super) values: &'f mut [Rgb],
}

/// The values that `shade` gives the layers of a tile outside of any film: those of one pixel are adjacent, in the order of
/// `layers`.
pub fn shaded_tile(tile: Tile, layers: &[Layer], shade: impl FnOnce(&mut TileSamples)) -> Vec<Rgb> {
    let mut values = vec![Rgb::BLACK; tile.count() * layers.len()];
    shade(&mut TileSamples {
        tile,
        slots: Slots::new(layers),
        stride: layers.len(),
        values: &mut values,
    });
    values
}

impl TileSamples<'_> {
    /// The pixels to fill.
    pub fn tile(&self) -> Tile {
        self.tile
    }

    /// Whether the film records this layer.
    pub fn records(&self, layer: Layer) -> bool {
        self.slots.of(layer).is_some()
    }

    /// Adds `value` to a layer of pixel `index` of the tile, in row order. A term of the path partition is added to the beauty
    /// too. Layers that the film does not record are ignored.
    #[inline]
    pub fn add(&mut self, index: usize, layer: Layer, value: Rgb) {
        let pixel = &mut self.values[index * self.stride..][..self.stride];
        if layer.is_term() {
            pixel[0] += value;
        }
        if let Some(slot) = self.slots.of(layer) {
            pixel[slot] += value;
        }
    }
}
