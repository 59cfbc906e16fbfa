//! The samples of one pass in one tile.

use super::coverage::{IdLayer, IdSample};
use super::layer::Slots;
use super::tiles::{TileGrid, Tiling};
use super::{Layer, Tile};
use crate::color::Rgb;
use crate::math::UVec2;
use rayon::prelude::*;

/// The samples of one pass in one tile: one value per pixel and recorded layer.
#[derive(Debug)]
pub struct TileSamples<'f> {
    pub(super) tile: Tile,
    pub(super) slots: Slots,
    /// Number of recorded layers. The values of one pixel are adjacent, in layer order.
    pub(super) stride: usize,
    pub(super) values: &'f mut [Rgb],
    pub(super) id_layers: &'f [IdLayer],
    pub(super) ids: &'f mut Vec<IdSample>,
}

/// The values that `shade` gives the layers of `size` pixels outside of any film: pixels in row
/// order, those of one pixel adjacent in the order of `layers`.
pub fn shaded_pixels(
    size: UVec2,
    tiling: Tiling,
    layers: &[Layer],
    shade: impl Fn(&mut TileSamples) + Sync,
) -> Vec<Rgb> {
    let tiles: Vec<Tile> = TileGrid::new(size, tiling).tiles().collect();
    let shaded = |&tile: &Tile| {
        let mut values = vec![Rgb::BLACK; tile.count() * layers.len()];
        shade(&mut TileSamples {
            tile,
            slots: Slots::new(layers),
            stride: layers.len(),
            values: &mut values,
            id_layers: &[],
            ids: &mut Vec::new(),
        });
        values
    };
    let shaded: Vec<Vec<Rgb>> = tiles.par_iter().map(shaded).collect();
    let mut all = vec![Rgb::BLACK; (size.x * size.y) as usize * layers.len()];
    for (tile, values) in tiles.iter().zip(&shaded) {
        for (pixel, values) in tile.pixels().zip(values.chunks(layers.len())) {
            let index = (pixel.y * size.x + pixel.x) as usize;
            all[index * layers.len()..][..layers.len()].copy_from_slice(values);
        }
    }
    all
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

    /// Adds `value` to a layer of pixel `index` of the tile, in row order. A term of the path
    /// partition is added to the beauty too. Layers that the film does not record are ignored.
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

    /// Whether the film records ids.
    #[inline]
    pub fn records_ids(&self) -> bool {
        !self.id_layers.is_empty()
    }

    /// Adds the id of a surface that covers the fraction `weight` of the sample of pixel `index`.
    /// The fractions of one sample and layer must not exceed 1 in sum. Layers that the film does
    /// not record are ignored.
    pub fn add_id(&mut self, index: usize, layer: IdLayer, id: u32, weight: f32) {
        if let Some(layer) = self.id_layers.iter().position(|&other| other == layer) {
            self.ids.push(IdSample {
                pixel: index as u32,
                layer: layer as u32,
                id,
                weight,
            });
        }
    }
}
