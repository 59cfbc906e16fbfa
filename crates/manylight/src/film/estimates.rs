//! Images and their errors from the sums of a film.

use super::batches::BatchMoments;
use super::totals::TileTotals;
use super::{Film, Layer};
use crate::image::Image;

/// Floor of the squared pixel value in the relative error, in units of the squared mean of the image. A larger floor
/// gives dark pixels less weight.
const DARK_FLOOR: f64 = 0.01;

impl Film {
    /// Mean of one layer over passes, three channels; `None` if the film does not record the layer.
    pub fn image(&self, layer: Layer) -> Option<Image> {
        let l = self.layers.iter().position(|&x| x == layer)?;
        let n = f64::from(self.passes().max(1));
        Some(self.collect(|sums, i| sums.sum(i * self.layers.len() + l).map(|v| (v / n) as f32)))
    }

    /// Fraction of each pixel that the picture covers, in [0, 1], one channel; `None` if the film does not record [`Layer::Alpha`].
    ///
    /// With `w` the weight of a sample by the reconstruction filter, its mean being 1, and `c` its covered fraction, the
    /// estimate is `E[w c] - E[c] (E[w] - 1)`. The second term is a control variate: pixels that are covered as a whole are
    /// exactly 1 for filters with negative lobes too.
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

    /// Variance of the mean of one layer over passes, per pixel and channel: the sample variance over passes, divided by their number.
    /// Treats passes as independent. Infinite with fewer than two passes. `None` if the film does not record the layer, or
    /// it is neither the beauty nor one of its terms.
    pub fn layer_variance(&self, layer: Layer) -> Option<Image> {
        let with_variance = &self.with_variance;
        let k = with_variance
            .iter()
            .position(|&l| self.layers[l] == layer)?;
        let l = with_variance[k];
        let n = f64::from(self.passes());
        Some(self.collect(|sums, i| {
            let sum = sums.sum(i * self.layers.len() + l);
            let squares = sums.square(i * with_variance.len() + k);
            std::array::from_fn(|c| {
                if self.passes() < 2 {
                    return f32::INFINITY;
                }
                let mean = sum[c] / n;
                let square = squares[c] / n;
                ((square - mean * mean).max(0.0) / (n - 1.0)) as f32
            })
        }))
    }

    /// Variance of the mean of the beauty over each tile, per channel, from completed batches. All pixels of a tile hold the
    /// variance of that tile. Infinite with fewer than two completed batches.
    pub fn block_variance(&self) -> Image {
        let batches = self.batch_counts();
        self.collect(|sums, _| {
            let pixels = sums.tile().count() as f64;
            let of_sum = batches.variance_of_mean(&sums.moments());
            of_sum.map(|v| (v / (pixels * pixels)) as f32)
        })
    }

    /// Variance of the mean of the beauty over the image, per channel, from completed batches. Infinite with fewer than two.
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
        of_sum.map(|v| v / (pixels * pixels))
    }

    /// Estimated relative error of the beauty: the root of the mean over pixels and channels of `variance / (value² + 0.01 m²)`
    /// with `m` the mean of the image. Infinite with fewer than two passes.
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

    fn collect(&self, value: impl Fn(&TileTotals, usize) -> [f32; 3]) -> Image {
        let size = self.image_size();
        let mut image = Image::new(size.x as usize, size.y as usize, 3);
        for sums in self.tile_totals() {
            for (i, pixel) in sums.tile().pixels().enumerate() {
                let start = (pixel.y as usize * image.width + pixel.x as usize) * 3;
                image.data[start..start + 3].copy_from_slice(&value(&sums, i));
            }
        }
        image
    }
}
