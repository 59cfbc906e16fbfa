//! The film: per-pixel sums over passes, and estimates of the variance of their means.
//!
//! A sample touches exactly one pixel, because filters are importance-sampled. Tiles are therefore independent, and any number of
//! threads gives the same bits. The values of a pass are kept apart until the pass is complete: a cancelled pass is discarded.
//!
//! Sums have two levels, so that parts of a render can be made apart and merged without a change of bits: a block of passes sums
//! from zero, and completed blocks are added in their order ([`blocks`]).

pub mod arrays;
mod batches;
pub mod blocks;
mod coverage;
mod description;
mod estimates;
pub mod filter;
mod layer;
mod planes;
mod sampler;
mod sums;
#[cfg(test)]
mod tests;
mod tile_samples;
mod tiles;
mod totals;

pub use coverage::{IdLayer, RankedIds};
pub use description::FilmDesc;
pub use filter::{Filter, FilterSampler, Window};
pub use layer::Layer;
pub use sampler::{FilmSample, FilmSampler};
pub use sums::PassSums;
pub use tile_samples::{TileSamples, shaded_pixels};
pub use tiles::{TILE_SIZE, Tile, Tiling};

use crate::color::Rgb;
use crate::math::UVec2;
use blocks::DEFAULT_BLOCK;
use coverage::IdSample;
use layer::Slots;
use rayon::prelude::*;
use std::num::NonZeroU32;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use sums::PixelShape;
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
    /// Passes of a block.
    block: NonZeroU32,
    /// Sums over the completed blocks. `None` before the first of them is followed by another pass.
    completed: Option<PassSums>,
    /// Sums over the passes of the current block.
    current: PassSums,
    /// Values of the current pass, by tile of the shifted grid of that pass.
    pass: Vec<Vec<Rgb>>,
    /// Ids of the current pass by the same tiles, sorted by pixel.
    pass_ids: Vec<Vec<IdSample>>,
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
        let shape = PixelShape::of(layers, id_layers);
        let current = PassSums::new(desc.crop_size, shape, 0);
        Film {
            desc,
            layers: layers.to_vec(),
            id_layers: id_layers.to_vec(),
            with_variance,
            block: DEFAULT_BLOCK,
            completed: None,
            current,
            pass: Vec::new(),
            pass_ids: Vec::new(),
        }
    }

    /// Memory of a film of `size` pixels with these layers, in bytes. It holds two `sums` if it has more passes than a block, else one.
    pub fn bytes_for(size: UVec2, layers: &[Layer], id_layers: &[IdLayer], sums: usize) -> u64 {
        let shape = PixelShape::of(layers, id_layers);
        let values = (shape.layers + shape.with_variance) * size_of::<[f64; 3]>()
            + shape.id_layers * coverage::BYTES_PER_PIXEL;
        let pass = layers.len() * size_of::<Rgb>();
        let per_pixel = sums * values + pass;
        (u64::from(size.x) * u64::from(size.y)).saturating_mul(per_pixel as u64)
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
        let completed = self.completed.as_ref().map_or(0, PassSums::count);
        completed + self.current.count()
    }

    /// Index of the pass that comes next.
    pub fn next_pass(&self) -> u32 {
        self.current.passes.end
    }

    fn shape(&self) -> PixelShape {
        PixelShape::of(&self.layers, &self.id_layers)
    }

    /// The tiles of a pass, moved up and left by `shift` pixels.
    fn grid(&self, tiling: Tiling) -> TileGrid {
        TileGrid::new(self.desc.crop_size, tiling)
    }

    /// Number of tiles of a pass with this tiling; see [`Film::add_tiled_pass`].
    pub fn tile_count(&self, tiling: Tiling) -> usize {
        self.grid(tiling).count()
    }

    /// Completes the current batch and begins a new one. Passes of one batch may share virtual lights; passes of different batches
    /// must be independent. The variance of means over many pixels is therefore estimated from batches, not from passes. A block
    /// ends with its last batch.
    pub fn begin_batch(&mut self) {
        self.current.complete_batch();
    }

    /// Number of completed batches.
    pub fn batches(&self) -> u32 {
        self.batch_counts().count()
    }

    /// Renders one pass: `shade` fills each tile, in parallel. Pixels with a non-finite value are left out of the sums and counted
    /// in `dropped`. If `cancel` becomes true before the last tile has begun, the pass is discarded and the result is `false`.
    pub fn add_pass(
        &mut self,
        cancel: &AtomicBool,
        dropped: &AtomicU64,
        shade: impl Fn(&mut TileSamples) + Sync,
    ) -> bool {
        self.add_tiled_pass(Tiling::UNSHIFTED, cancel, dropped, shade)
    }

    /// [`Film::add_pass`] with tiles of any size and offset.
    pub fn add_tiled_pass(
        &mut self,
        tiling: Tiling,
        cancel: &AtomicBool,
        dropped: &AtomicU64,
        shade: impl Fn(&mut TileSamples) + Sync,
    ) -> bool {
        let grid = self.grid(tiling);
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
        self.begin_block_if_complete();
        let (pass, pass_ids) = (&self.pass, &self.pass_ids);
        let id_count = self.id_layers.len();
        let emission = slots.of(Layer::Emission);
        let with_variance = &self.with_variance;
        self.current.tiles.par_iter_mut().for_each(|sums| {
            for (i, pixel) in sums.tile.pixels().enumerate() {
                let (tile, k) = grid.locate(pixel);
                let values = &pass[tile][k * stride..][..stride];
                if are_finite(values) {
                    sums.commit(i, values, emission, with_variance);
                    let coverage = &mut sums.coverage[i * id_count..][..id_count];
                    coverage::add_samples(&pass_ids[tile], k, coverage);
                } else {
                    dropped.fetch_add(1, Ordering::Relaxed);
                }
            }
        });
        self.current.passes.end += 1;
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

/// Whether all channels are finite. Without an early exit, so that the loop becomes vector instructions.
fn are_finite(values: &[Rgb]) -> bool {
    let channels: &[f32] = bytemuck::cast_slice(values);
    channels.iter().fold(true, |all, v| all & v.is_finite())
}
