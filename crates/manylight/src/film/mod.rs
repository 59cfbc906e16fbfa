//! Where samples end up: per-pixel sums over passes, with the variance of their mean, and that of means over tiles and the picture.
//!
//! A sample touches exactly one pixel (filters are importance-sampled), so tiles never overlap and any thread count gives
//! the same bits. A pass is kept aside until it is complete: a cancelled pass leaves no trace.

mod batches;
pub mod filter;
mod sampler;
mod tiles;

use batches::{BatchCounts, BatchMoments};
pub use filter::{Filter, FilterSampler, Window};
pub use sampler::{FilmSample, FilmSampler};
use tiles::TileGrid;
pub use tiles::{TILE_SIZE, Tile};

use crate::color::Rgb;
use crate::image::Image;
use crate::math::UVec2;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Size and filter of a film, as a file describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmDesc {
    /// Full size in pixels.
    pub size: UVec2,
    /// Upper left corner of the part that is rendered, in pixels.
    pub crop_offset: UVec2,
    /// Size of the part that is rendered, in pixels; `crop_offset + crop_size <= size`.
    pub crop_size: UVec2,
    /// Reconstruction filter.
    pub filter: Filter,
}

impl FilmDesc {
    /// A whole film of another size.
    pub fn with_size(&self, size: UVec2) -> Self {
        FilmDesc {
            size,
            crop_offset: UVec2::ZERO,
            crop_size: size,
            ..self.clone()
        }
    }
}

/// What a film records. The terms of the path partition sum to the beauty.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Layer {
    /// The picture.
    Beauty,
    /// Emitters seen directly or along specular chains.
    Emission,
    /// Light from emitters at the first vertex with a smooth lobe.
    Direct,
    /// Light from virtual lights there.
    VirtualLights,
    /// Light from photons whose last event was specular.
    Caustics,
    /// Albedo of the first surface.
    Albedo,
    /// Shading normal of the first surface, world space.
    Normal,
    /// Distance to the first surface along the ray, in the scene's unit; 0 where there is none.
    Depth,
    /// How many lights and clusters the sums over lights of a sample are made of.
    CutSize,
    /// By how much any of these clusters may be off, at most, in radiance; the whole radiance where nothing is known.
    CutBound,
}

impl Layer {
    /// Name in files; the beauty has none.
    pub fn name(self) -> &'static str {
        match self {
            Layer::Beauty => "",
            Layer::Emission => "emission",
            Layer::Direct => "direct",
            Layer::VirtualLights => "virtual_lights",
            Layer::Caustics => "caustics",
            Layer::Albedo => "albedo",
            Layer::Normal => "normal",
            Layer::Depth => "depth",
            Layer::CutSize => "cut_size",
            Layer::CutBound => "cut_bound",
        }
    }

    /// Terms of the path partition: added to the beauty as they are added to their own layer.
    pub fn is_term(self) -> bool {
        matches!(
            self,
            Layer::Emission | Layer::Direct | Layer::VirtualLights | Layer::Caustics
        )
    }
}

/// Where each layer stands among those that a film records.
#[derive(Clone, Copy, Debug)]
struct Slots([u8; LAYERS]);

/// Number of layers that there are.
const LAYERS: usize = Layer::CutBound as usize + 1;

impl Slots {
    /// Not recorded.
    const NONE: u8 = u8::MAX;

    fn new(layers: &[Layer]) -> Self {
        let mut slots = [Slots::NONE; LAYERS];
        for (slot, &layer) in layers.iter().enumerate() {
            slots[layer as usize] = slot as u8;
        }
        Slots(slots)
    }

    #[inline]
    fn of(self, layer: Layer) -> Option<usize> {
        let slot = self.0[layer as usize];
        (slot != Slots::NONE).then_some(slot.into())
    }
}

/// One pass of one tile: one value per pixel and layer.
#[derive(Debug)]
pub struct TileSamples<'f> {
    tile: Tile,
    slots: Slots,
    /// The values of one pixel, layer by layer, stand together.
    stride: usize,
    values: &'f mut [Rgb],
}

impl TileSamples<'_> {
    /// The pixels to fill.
    pub fn tile(&self) -> Tile {
        self.tile
    }

    /// Whether the film records this layer.
    pub fn keeps(&self, layer: Layer) -> bool {
        self.slots.of(layer).is_some()
    }

    /// Adds to a pixel of the tile (`index` counts row by row). A term of the partition is added to the beauty too.
    /// Layers that the film does not keep are ignored.
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

/// Sums over passes. Stored tile by tile, so that threads write disjoint slices.
#[derive(Debug)]
pub struct Film {
    desc: FilmDesc,
    layers: Vec<Layer>,
    tiles: Vec<TileSums>,
    /// The values of the pass under way, tile by tile of its own grid.
    pass: Vec<Vec<Rgb>>,
    passes: u32,
    /// Batches that are over, and what is known from them about the picture: the whole, and all but what emitters show of themselves.
    batches: BatchCounts,
    picture: [BatchMoments; 2],
}

#[derive(Debug)]
struct TileSums {
    tile: Tile,
    sums: Vec<[f64; 3]>,
    squares: Vec<[f64; 3]>,
    /// Of the batch under way, over pixels: the beauty, and all of it but the emission.
    batch: [[f64; 3]; 2],
    /// Of the beauty over the batches before.
    moments: BatchMoments,
}

impl Film {
    /// An empty film for the crop window of `desc`. `layers` must begin with [`Layer::Beauty`].
    pub fn new(desc: FilmDesc, layers: &[Layer]) -> Self {
        assert_eq!(
            layers.first(),
            Some(&Layer::Beauty),
            "invariant: every film records the beauty, first"
        );
        let tiles = TileGrid::new(desc.crop_size, UVec2::ZERO)
            .tiles()
            .map(|tile| TileSums {
                tile,
                sums: vec![[0.0; 3]; tile.count() * layers.len()],
                squares: vec![[0.0; 3]; tile.count()],
                batch: Default::default(),
                moments: BatchMoments::default(),
            })
            .collect();
        Film {
            desc,
            layers: layers.to_vec(),
            tiles,
            pass: Vec::new(),
            passes: 0,
            batches: BatchCounts::default(),
            picture: Default::default(),
        }
    }

    /// Bytes of a film for `size` pixels.
    pub fn bytes_for(size: UVec2, layers: &[Layer]) -> usize {
        let layer = size_of::<Rgb>() + size_of::<[f64; 3]>();
        let pixel = layers.len() * layer + size_of::<[f64; 3]>();
        (size.x * size.y) as usize * pixel
    }

    /// Size and filter.
    pub fn desc(&self) -> &FilmDesc {
        &self.desc
    }

    /// Size of the picture in pixels.
    pub fn picture_size(&self) -> UVec2 {
        self.desc.crop_size
    }

    /// Recorded layers, beauty first.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// Complete passes so far.
    pub fn passes(&self) -> u32 {
        self.passes
    }

    /// The tiles of a pass, moved up and to the left by so many pixels.
    fn grid(&self, shift: UVec2) -> TileGrid {
        TileGrid::new(self.desc.crop_size, shift)
    }

    /// How many tiles a pass has that moves them so: see [`Film::add_shifted_pass`].
    pub fn tile_count(&self, shift: UVec2) -> usize {
        self.grid(shift).count()
    }

    /// Says that the passes that follow are independent of those before: they make a batch. Passes of one batch may have lights in common,
    /// so that only the spread over batches tells how far means over many pixels may be off.
    pub fn begin_batch(&mut self) {
        let passes = self.passes - self.batches.passes();
        if passes == 0 {
            return;
        }
        self.batches.add(passes);
        let mut picture = [[0.0; 3]; 2];
        for tile in &mut self.tiles {
            for (sum, part) in picture.iter_mut().zip(tile.batch) {
                *sum = std::array::from_fn(|c| sum[c] + part[c]);
            }
            let [beauty, _] = std::mem::take(&mut tile.batch);
            tile.moments.add(passes, beauty);
        }
        for (moments, sum) in self.picture.iter_mut().zip(picture) {
            moments.add(passes, sum);
        }
    }

    /// Number of batches that are over.
    pub fn batches(&self) -> u32 {
        self.batches.count()
    }

    /// Renders one pass: `shade` fills each tile, in parallel. Pixels with a non-finite value are dropped and counted in
    /// `dropped`. When `cancel` turns true before the last tile is done, the pass is discarded and the result is `false`.
    pub fn add_pass(
        &mut self,
        cancel: &AtomicBool,
        dropped: &AtomicU64,
        shade: impl Fn(&mut TileSamples) + Sync,
    ) -> bool {
        self.add_shifted_pass(UVec2::ZERO, cancel, dropped, shade)
    }

    /// [`Film::add_pass`] with tiles that are moved up and to the left by so many pixels, modulo [`TILE_SIZE`].
    pub fn add_shifted_pass(
        &mut self,
        shift: UVec2,
        cancel: &AtomicBool,
        dropped: &AtomicU64,
        shade: impl Fn(&mut TileSamples) + Sync,
    ) -> bool {
        let grid = self.grid(shift);
        let (slots, stride) = (Slots::new(&self.layers), self.layers.len());
        let tiles: Vec<Tile> = grid.tiles().collect();
        self.pass.resize_with(tiles.len(), Vec::new);
        let complete = tiles.par_iter().zip(&mut self.pass).map(|(&tile, values)| {
            if cancel.load(Ordering::Relaxed) {
                return false;
            }
            values.clear();
            values.resize(tile.count() * stride, Rgb::BLACK);
            shade(&mut TileSamples {
                tile,
                slots,
                stride,
                values,
            });
            true
        });
        // A full reduction rather than `all`, which could skip tiles after the first `false`.
        if !complete.reduce(|| true, |a, b| a && b) {
            return false;
        }
        let pass = &self.pass;
        let emission = slots.of(Layer::Emission);
        self.tiles.par_iter_mut().for_each(|sums| {
            for (i, pixel) in sums.tile.pixels().enumerate() {
                let (tile, k) = grid.locate(pixel);
                let values = &pass[tile][k * stride..][..stride];
                if values.iter().all(|v| v.is_finite()) {
                    sums.commit(i, values, emission);
                } else {
                    dropped.fetch_add(1, Ordering::Relaxed);
                }
            }
        });
        self.passes += 1;
        true
    }

    /// Adds a pass that was made as a whole picture (light tracing): `pixels` row by row, beauty only.
    pub fn add_frame(&mut self, pixels: &[Rgb], dropped: &AtomicU64) {
        let width = self.picture_size().x;
        self.add_pass(&AtomicBool::new(false), dropped, |samples| {
            for (i, pixel) in samples.tile().pixels().enumerate() {
                samples.add(
                    i,
                    Layer::Beauty,
                    pixels[(pixel.y * width + pixel.x) as usize],
                );
            }
        });
    }

    /// Mean over passes of one layer, three channels; `None` if the film does not record it.
    pub fn image(&self, layer: Layer) -> Option<Image> {
        let l = self.layers.iter().position(|&x| x == layer)?;
        let n = f64::from(self.passes.max(1));
        Some(self.collect(|sums, i| sums.sums[i * self.layers.len() + l].map(|v| (v / n) as f32)))
    }

    /// Variance of the mean of the beauty, per pixel and channel, from the spread over passes: as if these were independent of each other.
    /// Infinite with fewer than two passes: nothing is known then.
    pub fn variance(&self) -> Image {
        let n = f64::from(self.passes);
        self.collect(|sums, i| {
            std::array::from_fn(|c| {
                if self.passes < 2 {
                    return f32::INFINITY;
                }
                let mean = sums.sums[i * self.layers.len()][c] / n;
                ((sums.squares[i][c] / n - mean * mean).max(0.0) / (n - 1.0)) as f32
            })
        })
    }

    /// Variance of the mean of the beauty over each tile, per channel, from the spread over batches that are over: the same in all of its
    /// pixels. Infinite with fewer than two of them.
    pub fn block_variance(&self) -> Image {
        self.collect(|sums, _| {
            let pixels = sums.tile.count() as f64;
            let of_sum = self.batches.variance_of_mean(&sums.moments);
            of_sum.map(|v| (v / (pixels * pixels)) as f32)
        })
    }

    /// The same for the mean over the picture.
    pub fn mean_variance(&self) -> [f64; 3] {
        self.variance_over_picture(&self.picture[0])
    }

    /// The same without the light of emitters seen directly or along specular chains.
    pub fn mean_variance_without_emission(&self) -> [f64; 3] {
        self.variance_over_picture(&self.picture[1])
    }

    fn variance_over_picture(&self, moments: &BatchMoments) -> [f64; 3] {
        let size = self.picture_size().as_dvec2();
        let pixels = size.x * size.y;
        let of_sum = self.batches.variance_of_mean(moments);
        of_sum.map(|v| v / (pixels * pixels))
    }

    /// Estimated relative error of the beauty: the root of the mean over pixels and channels of
    /// `variance / (value² + 0.01 m²)`, `m` the mean of the picture. Infinite with fewer than two passes.
    pub fn relative_error(&self) -> f32 {
        if self.passes < 2 {
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
                f64::from(var) / (f64::from(v).powi(2) + 0.01 * m * m).max(f64::MIN_POSITIVE)
            })
            .sum();
        (sum / count).sqrt() as f32
    }

    fn collect(&self, value: impl Fn(&TileSums, usize) -> [f32; 3]) -> Image {
        let size = self.picture_size();
        let mut image = Image::new(size.x as usize, size.y as usize, 3);
        for sums in &self.tiles {
            for (i, pixel) in sums.tile.pixels().enumerate() {
                let start = (pixel.y as usize * image.width + pixel.x as usize) * 3;
                image.data[start..start + 3].copy_from_slice(&value(sums, i));
            }
        }
        image
    }
}

impl TileSums {
    /// Adds what a pass has for pixel `i`, layer by layer; `emission` is the place of that layer.
    fn commit(&mut self, i: usize, pixel: &[Rgb], emission: Option<usize>) {
        let shown = emission.map_or(Rgb::BLACK, |l| pixel[l]);
        for (sum, value) in self.batch.iter_mut().zip([pixel[0], pixel[0] - shown]) {
            let value = value.to_array().map(f64::from);
            *sum = std::array::from_fn(|c| sum[c] + value[c]);
        }
        for (l, value) in pixel.iter().enumerate() {
            for (c, v) in value.to_array().into_iter().enumerate() {
                self.sums[i * pixel.len() + l][c] += f64::from(v);
                if l == 0 {
                    self.squares[i][c] += f64::from(v) * f64::from(v);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn film() -> Film {
        let size = UVec2::new(19, 11);
        let desc = FilmDesc {
            size,
            crop_offset: UVec2::ZERO,
            crop_size: size,
            filter: Filter::Box,
        };
        Film::new(desc, &[Layer::Beauty, Layer::Direct, Layer::Depth])
    }

    fn add(film: &mut Film, value: impl Fn(UVec2) -> f32 + Sync, cancel: bool) -> u64 {
        let dropped = AtomicU64::new(0);
        // Tiles may lie elsewhere in each pass.
        let shift = UVec2::new(5, 3) * film.passes();
        film.add_shifted_pass(shift, &AtomicBool::new(cancel), &dropped, |samples| {
            for (i, pixel) in samples.tile().pixels().enumerate() {
                samples.add(i, Layer::Direct, Rgb::splat(value(pixel)));
                samples.add(i, Layer::Depth, Rgb::splat(1.0));
            }
        });
        dropped.into_inner()
    }

    #[test]
    fn mean_and_variance_of_the_mean() {
        let mut film = film();
        assert!(film.variance().data.iter().all(|v| v.is_infinite()));
        for k in 0..4 {
            add(
                &mut film,
                |p| p.x as f32 + 100.0 * p.y as f32 + k as f32,
                false,
            );
        }
        let image = film.image(Layer::Beauty).unwrap();
        assert_eq!(image.pixel(7, 9), &[908.5; 3]);
        assert_eq!(film.image(Layer::Direct).unwrap(), image);
        assert_eq!(film.image(Layer::Depth).unwrap().pixel(0, 0), &[1.0; 3]);
        assert!(film.image(Layer::Caustics).is_none());
        // Values 0, 1, 2, 3 about their mean: sample variance 5/3, of the mean 5/12.
        assert!(
            film.variance()
                .data
                .iter()
                .all(|v| (v - 5.0 / 12.0).abs() < 1e-4)
        );
    }

    #[test]
    fn means_over_pixels_vary_from_batch_to_batch() {
        let mut film = film();
        let noise = |p: UVec2| {
            if (p.x + p.y).is_multiple_of(2) {
                1.0
            } else {
                -1.0
            }
        };
        for light in [0.0, 1.0, 2.0, 3.0] {
            film.begin_batch();
            // What pixels have in common stays for a batch; their own cancels, in pairs of pixels and in pairs of passes.
            add(&mut film, |p| 5.0 + light + noise(p), false);
            add(&mut film, |p| 5.0 + light - noise(p), false);
        }
        assert_eq!(film.batches(), 3);
        film.begin_batch();
        assert_eq!(film.batches(), 4);
        let expected = 5.0 / 12.0;
        let blocks = film.block_variance();
        assert!(
            blocks
                .data
                .iter()
                .all(|v| (v - expected as f32).abs() < 1e-5)
        );
        for v in film.mean_variance() {
            assert!((v - expected).abs() < 1e-9, "{v}");
        }
        assert_eq!(film.mean_variance(), film.mean_variance_without_emission());
    }

    #[test]
    fn nothing_is_known_of_one_batch() {
        let mut film = film();
        film.begin_batch();
        for _ in 0..2 {
            assert_eq!(film.batches(), 0);
            assert!(film.block_variance().data.iter().all(|v| v.is_infinite()));
            add(&mut film, |_| 1.0, false);
        }
        film.begin_batch();
        film.begin_batch();
        assert_eq!(film.batches(), 1);
        assert!(film.mean_variance()[0].is_infinite());
    }

    #[test]
    fn a_cancelled_pass_leaves_no_trace() {
        let mut film = film();
        add(&mut film, |_| 1.0, false);
        add(&mut film, |_| 100.0, true);
        assert_eq!(film.passes(), 1);
        assert_eq!(film.image(Layer::Beauty).unwrap().pixel(3, 3), &[1.0; 3]);
    }

    #[test]
    fn non_finite_pixels_are_dropped_and_counted() {
        let mut film = film();
        let dropped = add(&mut film, |p| if p.x == 2 { f32::NAN } else { 1.0 }, false);
        assert_eq!(dropped, 11);
        assert_eq!(film.image(Layer::Beauty).unwrap().pixel(2, 0), &[0.0; 3]);
    }
}
