//! What the sums of a film give: images, their errors, coverage by id.

use super::batches::{BatchCounts, BatchMoments};
use super::coverage::{IdLayer, RankedIds};
use super::sequences::{Halves, MeanRatio};
use super::totals::TileTotals;
use super::{Film, Layer, TILE_SIZE};
use crate::image::Image;
use crate::math::UVec2;
use rayon::prelude::*;

/// Floor of the squared pixel value in the relative error, in units of the squared mean of the
/// image. A larger floor gives dark pixels less weight.
const DARK_FLOOR: f64 = 0.01;

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

    /// Variance of the mean of one layer over passes, per pixel and channel: the sample variance
    /// over passes, divided by their number. Treats passes as independent, but for films
    /// [`with_sequences`](Film::with_sequences), where it is reduced by a factor per tile and
    /// channel (`sequences`). Infinite with fewer than two passes. `None` if the film does not
    /// record the layer, or it is neither the beauty nor one of its terms.
    pub fn layer_variance(&self, layer: Layer) -> Option<Image> {
        let with_variance = &self.with_variance;
        let k = with_variance
            .iter()
            .position(|&l| self.layers[l] == layer)?;
        if self.passes() < 2 {
            return Some(self.collect(|_| |_| [f32::INFINITY; 3]));
        }
        Some(self.collect(|sums| {
            let factor = self.sequence_factor(&sums, k);
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

    /// Factor from [`Film::spread`] to the variance, per channel; 1 for independent passes, and for
    /// fewer than two.
    fn sequence_factor(&self, sums: &TileTotals, k: usize) -> [f64; 3] {
        if !self.has_sequences() || self.passes() < 2 {
            return [1.0; 3];
        }
        let halves = Halves::of(self.next_pass() - self.passes(), self.next_pass());
        let mut ratios = MeanRatio::default();
        for i in 0..sums.tile().count() {
            let sum = sums.sum(i * self.layers.len() + self.with_variance[k]);
            let difference = sums.half(i * self.with_variance.len() + k);
            ratios.add(halves.variance(sum, difference), self.spread(sums, i, k));
        }
        ratios.mean()
    }

    /// Variance of the mean of the beauty over each tile, per channel, from completed batches, with
    /// the factor of [`Film::layer_variance`]. All pixels of a tile hold the variance of that tile.
    /// Infinite with fewer than two completed batches.
    pub fn block_variance(&self) -> Image {
        let batches = self.batch_counts();
        self.collect(|sums| {
            let pixels = sums.tile().count() as f64;
            let of_sum = batches.variance_of_mean(&sums.moments());
            let factor = self.sequence_factor(&sums, 0);
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
        let of_sum = self.batch_counts().variance_of_mean(moments);
        let factor = self.image_factor();
        std::array::from_fn(|c| of_sum[c] * factor[c] / (pixels * pixels))
    }

    /// Variance of the beauty over its [`Film::spread`], in the mean over pixels; 1 for independent
    /// passes.
    fn image_factor(&self) -> [f64; 3] {
        if !self.has_sequences() || self.passes() < 2 {
            return [1.0; 3];
        }
        let (mut variance, mut spread) = ([0.0; 3], [0.0; 3]);
        for sums in self.tile_totals() {
            let factor = self.sequence_factor(&sums, 0);
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

    /// Estimated relative error of the beauty: the root of the mean over pixels and channels of
    /// `variance / (value² + 0.01 m²)` with `m` the mean of the image. Infinite with fewer than two
    /// passes.
    pub fn relative_error(&self) -> f32 {
        if self.passes() < 2 {
            return f32::INFINITY;
        }
        let (mean, variance) = (
            self.image(Layer::Beauty).unwrap_or_default(),
            self.variance(),
        );
        let count = mean.data.len().max(1) as f64;
        let m = mean.data.iter().map(|&v| f64::from(v)).sum::<f64>() / count;
        let sum: f64 = mean
            .data
            .iter()
            .zip(&variance.data)
            .map(|(&v, &var)| {
                f64::from(var) / (f64::from(v).powi(2) + DARK_FLOOR * m * m).max(f64::MIN_POSITIVE)
            })
            .sum();
        (sum / count).sqrt() as f32
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
