//! What the sums of a film give: images, their errors, coverage by id.

use super::batches::{BatchCounts, BatchMoments};
use super::coverage::{IdLayer, RankedIds};
use super::halves::{Half, MeanRatio};
use super::totals::TileTotals;
use super::{Film, Layer, TILE_SIZE, Tile};
use crate::image::Image;
use crate::math::UVec2;
use rayon::prelude::*;

impl Film {
    /// Number of completed batches.
    pub fn batches(&self) -> u32 {
        self.batch_counts().count()
    }

    /// Mean of one layer over passes, three channels; `None` if the film does not record the layer.
    pub fn image(&self, layer: Layer) -> Option<Image> {
        let l = self.layers.iter().position(|&x| x == layer)?;
        let n = f64::from(self.passes().max(1));
        Some(
            self.collect(|sums| {
                move |i| sums.sum(i * self.layers.len() + l).map(|v| (v / n) as f32)
            }),
        )
    }

    /// Means over passes of channels of the recorded layers. A channel is given by the index of its
    /// layer in [`Film::layers`] and 0, 1 or 2; its plane has a value per pixel, row by row from
    /// the top. The values are those of [`Film::image`], but the film is read once for all
    /// channels, in parallel.
    ///
    /// # Panics
    /// If an index is too large.
    pub fn planes(&self, channels: &[(usize, usize)]) -> Vec<Vec<f32>> {
        let size = self.image_size().as_usizevec2();
        let mut planes = vec![vec![0.0; size.x * size.y]; channels.len()];
        // The parts of all planes that a row of tiles fills.
        let edge = TILE_SIZE as usize;
        let mut bands: Vec<Vec<&mut [f32]>> = Vec::new();
        bands.resize_with(size.y.div_ceil(edge), Vec::new);
        for plane in &mut planes {
            for (band, part) in bands.iter_mut().zip(plane.chunks_mut(edge * size.x)) {
                band.push(part);
            }
        }
        let stride = self.layers.len();
        let passes = f64::from(self.passes().max(1));
        let tiles: Vec<TileTotals> = self.tile_totals().collect();
        let rows = tiles.par_chunks(size.x.div_ceil(edge));
        rows.zip(bands).for_each(|(tiles, mut band)| {
            for sums in tiles {
                for (i, pixel) in sums.tile().pixels().enumerate() {
                    let place = pixel.y as usize % edge * size.x + pixel.x as usize;
                    for (part, &(layer, channel)) in band.iter_mut().zip(channels) {
                        let value = sums.sum(i * stride + layer)[channel];
                        part[place] = (value / passes) as f32;
                    }
                }
            }
        });
        planes
    }

    /// The ids that cover each pixel, pixels in row order; `None` if the film does not record
    /// `layer`. Equal fractions are in the order of their ids. Samples are distributed by the
    /// absolute value of the reconstruction filter and count equally.
    pub fn ranked_ids(&self, layer: IdLayer) -> Option<Vec<RankedIds>> {
        let k = self.id_layers.iter().position(|&other| other == layer)?;
        let n = f64::from(self.passes().max(1));
        let UVec2 {
            x: width,
            y: height,
        } = self.image_size();
        let mut all = vec![RankedIds::new(); width as usize * height as usize];
        for sums in self.tile_totals() {
            for (i, pixel) in sums.tile().pixels().enumerate() {
                let sums = sums.coverage(i * self.id_layers.len() + k);
                let mut ranked: RankedIds = sums
                    .iter()
                    .map(|&(id, sum)| (id, (sum / n) as f32))
                    .collect();
                ranked.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
                all[(pixel.y * width + pixel.x) as usize] = ranked;
            }
        }
        Some(all)
    }

    /// Fraction of each pixel that the picture covers, in [0, 1], one channel; `None` if the film
    /// does not record [`Layer::Alpha`].
    ///
    /// With `w` the weight of a sample by the reconstruction filter, its mean being 1, and `c` its
    /// covered fraction, the estimate is `E[w c] - E[c] (E[w] - 1)`. The second term is a control
    /// variate: pixels that are covered as a whole are exactly 1 for filters with negative lobes
    /// too.
    pub fn alpha(&self) -> Option<Image> {
        let raw = self.image(Layer::Alpha)?;
        let alpha = |raw: &[f32]| (raw[0] - raw[1] * (raw[2] - 1.0)).clamp(0.0, 1.0);
        Some(Image {
            channels: 1,
            data: raw.data.chunks_exact(3).map(alpha).collect(),
            ..raw
        })
    }

    /// [`Film::layer_variance`] of the beauty.
    pub fn variance(&self) -> Image {
        self.layer_variance(Layer::Beauty).unwrap_or_default()
    }

    /// Mean of one layer over the passes of one half, three channels; black without such passes.
    /// `None` if the film does not record the layer, or no variance of it.
    pub fn half_image(&self, layer: Layer, half: Half) -> Option<Image> {
        let k = self.variance_index(layer)?;
        let n = f64::from(self.half_counts().of(half).max(1));
        let (stride, with_variance) = (self.layers.len(), self.with_variance.len());
        let l = self.with_variance[k];
        let sign = f64::from(half.sign());
        Some(self.collect(|sums| {
            move |i| {
                let sum = sums.sum(i * stride + l);
                let difference = sums.half_difference(i * with_variance + k);
                std::array::from_fn(|c| ((sum[c] + sign * difference[c]) / (2.0 * n)) as f32)
            }
        }))
    }

    /// Index of `layer` among the layers with a variance.
    fn variance_index(&self, layer: Layer) -> Option<usize> {
        let with_variance = &self.with_variance;
        with_variance.iter().position(|&l| self.layers[l] == layer)
    }

    /// Variance of the mean of one layer over passes, per pixel and channel: the sample variance
    /// over passes, divided by their number, times a factor per tile and channel for passes that
    /// depend on each other ([`Half`]). Infinite with fewer than two passes. `None` if the film
    /// does not record the layer, or it is neither the beauty nor one of its terms.
    pub fn layer_variance(&self, layer: Layer) -> Option<Image> {
        let k = self.variance_index(layer)?;
        if self.passes() < 2 {
            return Some(self.collect(|_| |_| [f32::INFINITY; 3]));
        }
        let factors = self.half_factors(k);
        Some(self.collect(|sums| {
            let factor = factors[self.tile_index(sums.tile())];
            move |i| {
                let spread = self.spread(&sums, i, k);
                std::array::from_fn(|c| (spread[c] * factor[c]) as f32)
            }
        }))
    }

    /// Variance of the mean of the layer with variance `k` over passes in pixel `i`, were the
    /// passes independent.
    fn spread(&self, sums: &TileTotals, i: usize, k: usize) -> [f64; 3] {
        let n = f64::from(self.passes());
        let sum = sums.sum(i * self.layers.len() + self.with_variance[k]);
        let squares = sums.square(i * self.with_variance.len() + k);
        std::array::from_fn(|c| {
            let mean = sum[c] / n;
            (squares[c] / n - mean * mean).max(0.0) / (n - 1.0)
        })
    }

    /// Factors from [`Film::spread`] to the variance, by tile and channel: from a tile and those
    /// around it. 1 if one half has no passes.
    fn half_factors(&self, k: usize) -> Vec<[f64; 3]> {
        let counts = self.half_counts();
        let tiles: Vec<TileTotals> = self.tile_totals().collect();
        if !counts.are_both() {
            return vec![[1.0; 3]; tiles.len()];
        }
        let of_tile = |sums: &TileTotals| {
            let mut ratios = MeanRatio::default();
            for i in 0..sums.tile().count() {
                let sum = sums.sum(i * self.layers.len() + self.with_variance[k]);
                let difference = sums.half_difference(i * self.with_variance.len() + k);
                ratios.add(counts.variance(sum, difference), self.spread(sums, i, k));
            }
            ratios
        };
        let ratios: Vec<MeanRatio> = tiles.par_iter().map(of_tile).collect();
        let columns = self.tile_columns();
        let rows = ratios.len() / columns;
        let around = |at: usize, end: usize| at.saturating_sub(1)..(at + 2).min(end);
        let factor = |tile: usize| {
            let mut all = MeanRatio::default();
            for y in around(tile / columns, rows) {
                for x in around(tile % columns, columns) {
                    all.merge(&ratios[y * columns + x]);
                }
            }
            all.mean()
        };
        (0..ratios.len()).map(factor).collect()
    }

    /// Number of tiles of the unshifted grid in a row.
    fn tile_columns(&self) -> usize {
        self.image_size().x.div_ceil(TILE_SIZE) as usize
    }

    /// Index of a tile of the unshifted grid.
    fn tile_index(&self, tile: Tile) -> usize {
        let at = (tile.origin / TILE_SIZE).as_usizevec2();
        at.y * self.tile_columns() + at.x
    }

    /// Variance of the mean of the beauty over each tile, per channel, from completed batches;
    /// those of single passes are corrected by the factor of [`Film::layer_variance`]. All pixels
    /// of a tile hold the variance of that tile. Infinite with fewer than two completed batches.
    pub fn block_variance(&self) -> Image {
        let batches = self.batch_counts();
        let factors = batches.are_single_passes().then(|| self.half_factors(0));
        self.collect(|sums| {
            let pixels = sums.tile().count() as f64;
            let of_sum = batches.variance_of_mean(&sums.moments());
            let factor = (factors.as_ref())
                .map_or([1.0; 3], |factors| factors[self.tile_index(sums.tile())]);
            let variance =
                std::array::from_fn(|c| (of_sum[c] * factor[c] / (pixels * pixels)) as f32);
            move |_| variance
        })
    }

    /// Variance of the mean of the beauty over the image, per channel, from completed batches.
    /// Infinite with fewer than two.
    pub fn mean_variance(&self) -> [f64; 3] {
        let [beauty, _] = self.image_moments();
        self.variance_of_image_mean(&beauty)
    }

    /// [`Film::mean_variance`] of the beauty without [`Layer::Emission`].
    pub fn mean_variance_without_emission(&self) -> [f64; 3] {
        let [_, without_emission] = self.image_moments();
        self.variance_of_image_mean(&without_emission)
    }

    fn variance_of_image_mean(&self, moments: &BatchMoments) -> [f64; 3] {
        let size = self.image_size().as_dvec2();
        let pixels = size.x * size.y;
        let batches = self.batch_counts();
        let of_sum = batches.variance_of_mean(moments);
        let factor = match batches.are_single_passes() {
            true => self.image_factor(),
            false => [1.0; 3],
        };
        std::array::from_fn(|c| of_sum[c] * factor[c] / (pixels * pixels))
    }

    /// Variance of the beauty over its [`Film::spread`], in the mean over pixels.
    fn image_factor(&self) -> [f64; 3] {
        let (mut variance, mut spread) = ([0.0; 3], [0.0; 3]);
        let factors = self.half_factors(0);
        for (sums, factor) in self.tile_totals().zip(factors) {
            for i in 0..sums.tile().count() {
                let of_pixel = self.spread(&sums, i, 0);
                for c in 0..3 {
                    spread[c] += of_pixel[c];
                    variance[c] += of_pixel[c] * factor[c];
                }
            }
        }
        std::array::from_fn(|c| match spread[c] > 0.0 {
            true => variance[c] / spread[c],
            false => 1.0,
        })
    }

    /// An image whose pixel `i` of a tile is `value(tile)(i)`.
    fn collect<'f, P: Fn(usize) -> [f32; 3]>(
        &'f self,
        value: impl Fn(TileTotals<'f>) -> P,
    ) -> Image {
        let size = self.image_size();
        let mut image = Image::new(size.x as usize, size.y as usize, 3);
        for sums in self.tile_totals() {
            let value = value(sums);
            for (i, pixel) in sums.tile().pixels().enumerate() {
                let start = (pixel.y as usize * image.width + pixel.x as usize) * 3;
                image.data[start..start + 3].copy_from_slice(&value(i));
            }
        }
        image
    }

    /// The tiles of the unshifted grid, row by row.
    fn tile_totals(&self) -> impl Iterator<Item = TileTotals<'_>> {
        self.current
            .tiles
            .iter()
            .enumerate()
            .map(|(t, current)| TileTotals {
                completed: self.completed.as_ref().map(|blocks| &blocks.tiles[t]),
                current,
            })
    }

    /// Completed batches.
    fn batch_counts(&self) -> BatchCounts {
        let mut total = self
            .completed
            .as_ref()
            .map_or_else(BatchCounts::default, |blocks| blocks.batches);
        total.merge(self.current.batches);
        total
    }

    /// Moments over completed batches of sums over pixels: of the beauty, and of the beauty without
    /// emission.
    fn image_moments(&self) -> [BatchMoments; 2] {
        let completed = self.completed.as_ref();
        let mut total = completed.map_or_else(Default::default, |blocks| blocks.image_moments);
        for (total, current) in total.iter_mut().zip(&self.current.image_moments) {
            total.merge(current);
        }
        total
    }
}
