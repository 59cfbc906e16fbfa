//! The samples of one pass in one tile.

use super::coverage::{IdLayer, IdSample};
use super::layer::{LAYERS, Slots};
use super::tiles::{TileGrid, Tiling};
use super::{Layer, Tile};
use crate::color::Rgb;
use crate::ids::LightGroup;
use crate::math::UVec2;
use rayon::prelude::*;

/// The samples of one pass in one tile: one value per pixel and recorded layer.
#[derive(Debug)]
pub struct TileSamples<'f> {
    pub(super) tile: Tile,
    pub(super) slots: Slots,
    /// By layer: factor of its values in the layers of light groups.
    group_weights: [f32; LAYERS],
    /// Number of recorded layers. The values of one pixel are adjacent, in layer order.
    pub(super) stride: usize,
    pub(super) values: &'f mut [Rgb],
    pub(super) id_layers: &'f [IdLayer],
    pub(super) ids: &'f mut Vec<IdSample>,
}

/// Memory for the samples of a tile.
pub(super) struct TileBuffers<'f> {
    pub(super) values: &'f mut Vec<Rgb>,
    pub(super) ids: &'f mut Vec<IdSample>,
}

/// Samples of pixels that belong to no film.
#[derive(Clone, Debug)]
pub struct ShadedPixels {
    /// Number of columns and rows.
    pub size: UVec2,
    /// The layers.
    pub layers: Vec<Layer>,
    /// Pixels in row order; the values of one pixel are adjacent, in layer order.
    pub values: Vec<Rgb>,
    /// Sums of weights by pixel, layer and id, sorted by pixel.
    ids: Vec<IdSample>,
}

/// What `shade` gives the layers of `size` pixels, tile by tile.
pub fn shaded_pixels(
    size: UVec2,
    tiling: Tiling,
    (layers, id_layers): (&[Layer], &[IdLayer]),
    shade: impl Fn(&mut TileSamples) + Sync,
) -> ShadedPixels {
    let tiles: Vec<Tile> = TileGrid::new(size, tiling).tiles().collect();
    let shaded = |&tile: &Tile| {
        let (mut values, mut ids) = (Vec::new(), Vec::new());
        let buffers = TileBuffers {
            values: &mut values,
            ids: &mut ids,
        };
        let slots = (Slots::new(layers), layers.len());
        shade(&mut TileSamples::new(tile, slots, id_layers, buffers));
        (values, summed(ids))
    };
    let shaded: Vec<(Vec<Rgb>, Vec<IdSample>)> = tiles.par_iter().map(shaded).collect();
    let stride = layers.len();
    let mut all = vec![Rgb::BLACK; (size.x * size.y) as usize * stride];
    let mut all_ids = Vec::new();
    for (tile, (values, ids)) in tiles.iter().zip(&shaded) {
        let place = |pixel: UVec2| pixel.y * size.x + pixel.x;
        let places: Vec<u32> = tile.pixels().map(place).collect();
        for (&place, values) in places.iter().zip(values.chunks(stride)) {
            all[place as usize * stride..][..stride].copy_from_slice(values);
        }
        all_ids.extend(ids.iter().map(|sample| IdSample {
            pixel: places[sample.pixel as usize],
            ..*sample
        }));
    }
    all_ids.sort_by_key(|sample| sample.pixel);
    ShadedPixels {
        size,
        layers: layers.to_vec(),
        values: all,
        ids: all_ids,
    }
}

/// Samples of the same pixel, layer and id as one, by pixel. The order of those of one pixel is
/// that of their first appearance.
fn summed(mut samples: Vec<IdSample>) -> Vec<IdSample> {
    samples.sort_by_key(|sample| sample.pixel);
    let mut sums: Vec<IdSample> = Vec::new();
    let mut start = 0;
    for sample in samples {
        if sums
            .get(start)
            .is_none_or(|first| first.pixel != sample.pixel)
        {
            start = sums.len();
        }
        let is_same = |sum: &&mut IdSample| (sum.layer, sum.id) == (sample.layer, sample.id);
        match sums[start..].iter_mut().find(is_same) {
            Some(sum) => sum.weight += sample.weight,
            None => sums.push(sample),
        }
    }
    sums
}

impl<'f> TileSamples<'f> {
    /// Black samples, in layers given by their indices and their number.
    pub(super) fn new(
        tile: Tile,
        (slots, stride): (Slots, usize),
        id_layers: &'f [IdLayer],
        buffers: TileBuffers<'f>,
    ) -> Self {
        let TileBuffers { values, ids } = buffers;
        values.clear();
        values.resize(tile.count() * stride, Rgb::BLACK);
        ids.clear();
        TileSamples {
            tile,
            slots,
            group_weights: [1.0; LAYERS],
            stride,
            values,
            id_layers,
            ids,
        }
    }
}

impl TileSamples<'_> {
    /// The pixels to fill.
    pub fn tile(&self) -> Tile {
        self.tile
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

    /// Number of light groups that the film records; 0 for none.
    #[inline]
    pub fn light_groups(&self) -> usize {
        self.slots.groups()
    }

    /// [`TileSamples::add`] of light from emitters of `group`, which is added to the layer of that
    /// group too.
    #[inline]
    pub fn add_light(&mut self, index: usize, layer: Layer, group: LightGroup, value: Rgb) {
        self.add(index, layer, value);
        if let Some(slot) = self.slots.of_group(group) {
            let weight = self.group_weights[layer.index()];
            self.values[index * self.stride + slot] += value * weight;
        }
    }

    /// From now on, [`TileSamples::add_light`] adds values to the layers of light groups with the
    /// factor `weight(layer)`: for samples that [`TileSamples::mix`] will weigh.
    pub fn weigh_light_groups(&mut self, weight: impl Fn(Layer) -> f32) {
        self.group_weights = Layer::ALL.map(weight);
    }

    /// Replaces the value `x` of each layer by `(1 - w) x + w y`, with `w = weight(layer)`. `other`
    /// contains sums over `samples` samples, and `y` is their mean. For ids, `w` is `id_weight`. The
    /// beauty becomes the sum of its terms, and light groups the sum `x + y` of values that are
    /// weighted before: [`TileSamples::weigh_light_groups`].
    ///
    /// # Panics
    /// If `other` has other layers.
    pub fn mix(
        &mut self,
        other: &ShadedPixels,
        samples: u32,
        weight: impl Fn(Layer) -> f32,
        id_weight: f32,
    ) {
        assert_eq!(other.layers.len(), self.stride, "layers differ");
        let per_sample = 1.0 / samples.max(1) as f32;
        for sample in &mut *self.ids {
            sample.weight *= 1.0 - id_weight;
        }
        for (i, pixel) in self.tile.pixels().enumerate() {
            let place = pixel.y * other.size.x + pixel.x;
            let values = &mut self.values[i * self.stride..][..self.stride];
            let others = &other.values[place as usize * self.stride..][..self.stride];
            let mut beauty = Rgb::BLACK;
            for ((x, &y), &layer) in values.iter_mut().zip(others).zip(&other.layers) {
                if let Layer::LightGroup(_) = layer {
                    *x += y * per_sample;
                    continue;
                }
                let w = weight(layer);
                *x = *x * (1.0 - w) + y * (w * per_sample);
                if layer.is_term() {
                    beauty += *x;
                }
            }
            values[0] = beauty;
            let first = other.ids.partition_point(|sample| sample.pixel < place);
            let ids = other.ids[first..].iter().take_while(|s| s.pixel == place);
            self.ids.extend(ids.map(|sample| IdSample {
                pixel: i as u32,
                weight: sample.weight * id_weight * per_sample,
                ..*sample
            }));
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
