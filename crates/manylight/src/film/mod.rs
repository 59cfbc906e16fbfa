//! The film: per-pixel sums over passes, and estimates of the variance of their means.
//!
//! A sample touches exactly one pixel, because filters are importance-sampled. Tiles are therefore independent, and any number of
//! threads gives the same bits. The values of a pass are kept apart until the pass is complete: a cancelled pass is discarded.

mod batches;
mod coverage;
mod description;
mod estimates;
pub mod filter;
mod layer;
mod planes;
mod sampler;
#[cfg(test)]
mod tests;
mod tile_samples;
mod tiles;

pub use coverage::{IdLayer, RankedIds};
pub use description::FilmDesc;
pub use filter::{Filter, FilterSampler, Window};
pub use layer::Layer;
pub use sampler::{FilmSample, FilmSampler};
pub use tile_samples::{TileSamples, shaded_pixels};
pub use tiles::{TILE_SIZE, Tile};

use crate::color::Rgb;
use crate::math::UVec2;
use batches::{BatchCounts, BatchMoments};
use coverage::{CoverageSums, IdSample};
use layer::Slots;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use tiles::TileGrid;

/// Per-pixel sums over passes. Stored tile by tile, so that threads write disjoint memory.
#[derive(Debug)]
pub struct Film {
    desc: FilmDesc,
    layers: Vec<Layer>,
    /// Recorded id layers.
    id_layers: Vec<IdLayer>,
    /// Indices in `layers` of those with a variance.
    with_variance: Vec<usize>,
    tiles: Vec<TileSums>,
    /// Values of the current pass, by tile of the shifted grid of that pass.
    pass: Vec<Vec<Rgb>>,
    /// Ids of the current pass by the same tiles, sorted by pixel.
    pass_ids: Vec<Vec<IdSample>>,
    passes: u32,
    /// Completed batches.
    batches: BatchCounts,
    /// Moments of sums over all pixels, over completed batches: of the beauty, and of the beauty without [`Layer::Emission`].
    image_moments: [BatchMoments; 2],
}

/// Sums of one tile of the unshifted grid.
#[derive(Debug)]
struct TileSums {
    tile: Tile,
    /// Sum over passes, by pixel and layer.
    sums: Vec<[f64; 3]>,
    /// Sum over passes of the square, by pixel and layer with a variance.
    squares: Vec<[f64; 3]>,
    /// Sum over passes, by pixel and id layer.
    coverage: Vec<CoverageSums>,
    /// Sums over pixels and the passes of the current batch: the beauty, and the beauty without [`Layer::Emission`].
    batch: [[f64; 3]; 2],
    /// Moments of the beauty's sum over pixels, over completed batches.
    moments: BatchMoments,
}

impl Film {
    /// An empty film for the crop window of `desc`.
    ///
    /// # Panics
    /// If the first of `layers` is not [`Layer::Beauty`].
    pub fn new(desc: FilmDesc, layers: &[Layer]) -> Self {
        Film::with_ids(desc, layers, &[])
    }

    /// [`Film::new`] with coverage by id.
    ///
    /// # Panics
    /// If the first of `layers` is not [`Layer::Beauty`].
    pub fn with_ids(desc: FilmDesc, layers: &[Layer], id_layers: &[IdLayer]) -> Self {
        assert_eq!(
            layers.first(),
            Some(&Layer::Beauty),
            "the first layer of a film must be the beauty"
        );
        let with_variance: Vec<usize> = (0..layers.len())
            .filter(|&l| layers[l].has_variance())
            .collect();
        let tiles = TileGrid::new(desc.crop_size, UVec2::ZERO)
            .tiles()
            .map(|tile| TileSums {
                tile,
                sums: vec![[0.0; 3]; tile.count() * layers.len()],
                squares: vec![[0.0; 3]; tile.count() * with_variance.len()],
                coverage: vec![CoverageSums::new(); tile.count() * id_layers.len()],
                batch: Default::default(),
                moments: BatchMoments::default(),
            })
            .collect();
        Film {
            desc,
            layers: layers.to_vec(),
            id_layers: id_layers.to_vec(),
            with_variance,
            tiles,
            pass: Vec::new(),
            pass_ids: Vec::new(),
            passes: 0,
            batches: BatchCounts::default(),
            image_moments: Default::default(),
        }
    }

    /// Memory of a film of `size` pixels with these layers, in bytes.
    pub fn bytes_for(size: UVec2, layers: &[Layer], id_layers: &[IdLayer]) -> usize {
        let layer = size_of::<Rgb>() + size_of::<[f64; 3]>();
        let with_variance = layers.iter().filter(|layer| layer.has_variance());
        let pixel = layers.len() * layer + with_variance.count() * size_of::<[f64; 3]>();
        let ids = id_layers.len() * coverage::BYTES_PER_PIXEL;
        (size.x * size.y) as usize * (pixel + ids)
    }

    /// Size, crop window and filter.
    pub fn desc(&self) -> &FilmDesc {
        &self.desc
    }

    /// Size of the rendered image in pixels: that of the crop window.
    pub fn image_size(&self) -> UVec2 {
        self.desc.crop_size
    }

    /// Recorded layers, the beauty first.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// Recorded id layers.
    pub fn id_layers(&self) -> &[IdLayer] {
        &self.id_layers
    }

    /// Number of complete passes.
    pub fn passes(&self) -> u32 {
        self.passes
    }

    /// The tiles of a pass, moved up and left by `shift` pixels.
    fn grid(&self, shift: UVec2) -> TileGrid {
        TileGrid::new(self.desc.crop_size, shift)
    }

    /// Number of tiles of a pass with this shift; see [`Film::add_shifted_pass`].
    pub fn tile_count(&self, shift: UVec2) -> usize {
        self.grid(shift).count()
    }

    /// Completes the current batch and begins a new one. Passes of one batch may share virtual lights; passes of different batches
    /// must be independent. The variance of means over many pixels is therefore estimated from batches, not from passes.
    pub fn begin_batch(&mut self) {
        let passes = self.passes - self.batches.passes();
        if passes == 0 {
            return;
        }
        self.batches.add(passes);
        let mut image = [[0.0; 3]; 2];
        for tile in &mut self.tiles {
            for (sum, part) in image.iter_mut().zip(tile.batch) {
                *sum = std::array::from_fn(|c| sum[c] + part[c]);
            }
            let [beauty, _] = std::mem::take(&mut tile.batch);
            tile.moments.add(passes, beauty);
        }
        for (moments, sum) in self.image_moments.iter_mut().zip(image) {
            moments.add(passes, sum);
        }
    }

    /// Number of completed batches.
    pub fn batches(&self) -> u32 {
        self.batches.count()
    }

    /// Renders one pass: `shade` fills each tile, in parallel. Pixels with a non-finite value are left out of the sums and counted
    /// in `dropped`. If `cancel` becomes true before the last tile has begun, the pass is discarded and the result is `false`.
    pub fn add_pass(
        &mut self,
        cancel: &AtomicBool,
        dropped: &AtomicU64,
        shade: impl Fn(&mut TileSamples) + Sync,
    ) -> bool {
        self.add_shifted_pass(UVec2::ZERO, cancel, dropped, shade)
    }

    /// [`Film::add_pass`] with tiles moved up and left by `shift` pixels, modulo [`TILE_SIZE`].
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
        self.pass_ids.resize_with(tiles.len(), Vec::new);
        let id_layers = self.id_layers.as_slice();
        let outputs = self.pass.par_iter_mut().zip(&mut self.pass_ids);
        let complete = tiles.par_iter().zip(outputs).map(|(&tile, (values, ids))| {
            if cancel.load(Ordering::Relaxed) {
                return false;
            }
            values.clear();
            values.resize(tile.count() * stride, Rgb::BLACK);
            ids.clear();
            shade(&mut TileSamples {
                tile,
                slots,
                stride,
                values,
                id_layers,
                ids,
            });
            ids.sort_by_key(|sample| sample.pixel);
            true
        });
        // A full reduction: `all` could skip tiles after the first `false`.
        if !complete.reduce(|| true, |a, b| a && b) {
            return false;
        }
        let (pass, pass_ids) = (&self.pass, &self.pass_ids);
        let id_count = id_layers.len();
        let emission = slots.of(Layer::Emission);
        let with_variance = &self.with_variance;
        self.tiles.par_iter_mut().for_each(|sums| {
            for (i, pixel) in sums.tile.pixels().enumerate() {
                let (tile, k) = grid.locate(pixel);
                let values = &pass[tile][k * stride..][..stride];
                if values.iter().all(|v| v.is_finite()) {
                    sums.commit(i, values, emission, with_variance);
                    let coverage = &mut sums.coverage[i * id_count..][..id_count];
                    coverage::add_samples(&pass_ids[tile], k, coverage);
                } else {
                    dropped.fetch_add(1, Ordering::Relaxed);
                }
            }
        });
        self.passes += 1;
        true
    }

    /// Adds a pass given as a whole image, for light tracing: `pixels` row by row, the beauty only.
    pub fn add_frame(&mut self, pixels: &[Rgb], dropped: &AtomicU64) {
        let width = self.image_size().x;
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
}

impl TileSums {
    /// Adds the values of one pass to pixel `i`, one per layer; `emission` is the index of [`Layer::Emission`], if recorded.
    fn commit(
        &mut self,
        i: usize,
        pixel: &[Rgb],
        emission: Option<usize>,
        with_variance: &[usize],
    ) {
        let emitted = emission.map_or(Rgb::BLACK, |l| pixel[l]);
        for (sum, value) in self.batch.iter_mut().zip([pixel[0], pixel[0] - emitted]) {
            let value = value.to_array().map(f64::from);
            *sum = std::array::from_fn(|c| sum[c] + value[c]);
        }
        for (l, value) in pixel.iter().enumerate() {
            for (c, v) in value.to_array().into_iter().enumerate() {
                self.sums[i * pixel.len() + l][c] += f64::from(v);
            }
        }
        for (k, &l) in with_variance.iter().enumerate() {
            for (c, v) in pixel[l].to_array().into_iter().enumerate() {
                self.squares[i * with_variance.len() + k][c] += f64::from(v) * f64::from(v);
            }
        }
    }
}
