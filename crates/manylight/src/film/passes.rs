//! The film: sums over passes by blocks.

use super::blocks::{BLOCK_STEP, DEFAULT_BLOCK};
use super::coverage::{self, IdLayer, IdSample};
use super::halves::{Half, HalfCounts};
use super::layer::{Layer, Slots};
use super::sums::{PassSums, PixelShape};
use super::tile_samples::TileBuffers;
use super::tiles::TileGrid;
use super::{FilmDesc, Tile, TileSamples, Tiling};
use crate::color::Rgb;
use crate::math::UVec2;
use rayon::prelude::*;
use std::num::NonZeroU32;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Per-pixel sums over passes. Stored tile by tile, so that threads write disjoint memory.
#[derive(Debug)]
pub struct Film {
    pub(super) desc: FilmDesc,
    pub(super) layers: Vec<Layer>,
    /// Recorded id layers.
    pub(super) id_layers: Vec<IdLayer>,
    /// Indices in `layers` of those with a variance.
    pub(super) with_variance: Vec<usize>,
    /// What a pixel holds.
    shape: PixelShape,
    /// Passes of a block.
    block: NonZeroU32,
    /// The half of the passes that come next.
    half: Half,
    /// Sums over the completed blocks. `None` before the first of them is followed by another pass.
    pub(super) completed: Option<PassSums>,
    /// Sums over the passes of the current block.
    pub(super) current: PassSums,
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
            shape,
            block: DEFAULT_BLOCK,
            half: Half::default(),
            completed: None,
            current,
            pass: Vec::new(),
            pass_ids: Vec::new(),
        }
    }

    /// A film with blocks of `block` passes, of which `first` will be the next. `first` is the
    /// first pass of a block.
    ///
    /// # Panics
    /// If the first of `layers` is not [`Layer::Beauty`], `block` is no multiple of [`BLOCK_STEP`],
    /// or `first` is no multiple of `block`.
    pub fn with_blocks(
        desc: FilmDesc,
        layers: &[Layer],
        id_layers: &[IdLayer],
        block: NonZeroU32,
        first: u32,
    ) -> Self {
        assert!(
            block.get().is_multiple_of(BLOCK_STEP),
            "a block of {block} passes splits sets of lights"
        );
        assert!(
            first.is_multiple_of(block.get()),
            "pass {first} is not the first of a block of {block}"
        );
        let mut film = Film::with_ids(desc, layers, id_layers);
        film.block = block;
        film.current.passes = first..first;
        film
    }

    /// Memory of a film of `size` pixels with these layers, in bytes. It holds two `sums` if it has
    /// more passes than a block, else one.
    pub fn bytes_for(size: UVec2, layers: &[Layer], id_layers: &[IdLayer], sums: usize) -> u64 {
        let shape = PixelShape::of(layers, id_layers);
        let values = (shape.layers + shape.with_variance) * size_of::<[f64; 3]>()
            + shape.with_variance * size_of::<[f32; 3]>()
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

    /// Number of light groups that the film records; 0 for none.
    pub fn light_groups(&self) -> usize {
        Slots::new(&self.layers).groups()
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

    pub(super) fn shape(&self) -> PixelShape {
        self.shape
    }

    /// The tiles of a pass.
    fn grid(&self, tiling: Tiling) -> TileGrid {
        TileGrid::new(self.desc.crop_size, tiling)
    }

    /// Number of tiles of a pass with this tiling; see [`Film::add_tiled_pass`].
    pub fn tile_count(&self, tiling: Tiling) -> usize {
        self.grid(tiling).count()
    }

    /// Completes the current batch and begins a new one. Passes of one batch may share virtual
    /// lights; passes of different batches must be independent. The variance of means over many
    /// pixels is therefore estimated from batches, not from passes. A block ends with its last
    /// batch.
    pub fn begin_batch(&mut self) {
        self.current.complete_batch();
    }

    /// The half of the passes that come next. Passes that share virtual lights, or continue one
    /// sequence of samples, belong to one half.
    pub fn set_half(&mut self, half: Half) {
        self.half = half;
    }

    /// Numbers of complete passes of both halves.
    pub fn half_counts(&self) -> HalfCounts {
        let mut counts = self.current.half_counts;
        if let Some(blocks) = &self.completed {
            counts.add(blocks.half_counts);
        }
        counts
    }

    /// Renders one pass: `shade` fills each tile, in parallel. Pixels with a non-finite value are
    /// left out of the sums and counted in `dropped`. If `cancel` becomes true before the last tile
    /// has begun, the pass is discarded and the result is `false`.
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
            let buffers = TileBuffers {
                values,
                ids: &mut *ids,
            };
            let layers = (slots, stride);
            shade(&mut TileSamples::new(tile, layers, id_layers, buffers));
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
        let half = self.half;
        self.current.tiles.par_iter_mut().for_each(|sums| {
            for (i, pixel) in sums.tile.pixels().enumerate() {
                let (tile, k) = grid.locate(pixel);
                let values = &pass[tile][k * stride..][..stride];
                if are_finite(values) {
                    sums.commit(i, values, emission, with_variance, half);
                    let coverage = &mut sums.coverage[i * id_count..][..id_count];
                    coverage::add_samples(&pass_ids[tile], k, coverage);
                } else {
                    dropped.fetch_add(1, Ordering::Relaxed);
                }
            }
        });
        self.current.passes.end += 1;
        self.current.half_counts.0[half.index()] += 1;
        true
    }

    /// Adds a pass given as whole images, for light tracing: the `pixels` of the beauty row by row,
    /// and those of the layers of light groups, if any.
    pub fn add_frame(&mut self, pixels: &[Rgb], groups: &[Vec<Rgb>], dropped: &AtomicU64) {
        let width = self.image_size().x;
        self.add_pass(&AtomicBool::new(false), dropped, |samples| {
            for (i, pixel) in samples.tile().pixels().enumerate() {
                let place = (pixel.y * width + pixel.x) as usize;
                samples.add(i, Layer::Beauty, pixels[place]);
                for (layer, pixels) in Layer::of_light_groups(groups.len()).zip(groups) {
                    samples.add(i, layer, pixels[place]);
                }
            }
        });
    }

    /// Passes of a block.
    pub fn block(&self) -> NonZeroU32 {
        self.block
    }

    /// Sums over the completed blocks; `None` if no pass follows the first block.
    pub fn completed(&self) -> Option<&PassSums> {
        self.completed.as_ref()
    }

    /// Sums over the passes of the last block, which may be complete.
    pub fn current(&self) -> &PassSums {
        &self.current
    }

    /// The last block, of a film that has no other.
    ///
    /// # Panics
    /// If the film has several blocks.
    pub fn into_block(mut self) -> PassSums {
        assert!(self.completed.is_none(), "the film has several blocks");
        self.current.complete_batch();
        self.current
    }

    /// Continues with the next block, made by a film with the same layers.
    ///
    /// # Panics
    /// If the current block is neither empty nor complete, or `block` does not follow it.
    pub fn append(&mut self, block: PassSums) {
        assert_eq!(
            block.passes.start,
            self.next_pass(),
            "blocks must follow each other"
        );
        if self.current.count() > 0 {
            assert_eq!(
                self.current.count(),
                self.block.get(),
                "the current block is incomplete"
            );
            self.begin_block_if_complete();
        }
        self.current = block;
    }

    /// Restores the state that [`Film::completed`] and [`Film::current`] gave.
    ///
    /// # Panics
    /// If they do not follow each other.
    pub fn restore(&mut self, completed: Option<PassSums>, current: PassSums) {
        let end = completed
            .as_ref()
            .map_or(current.passes.start, |blocks| blocks.passes.end);
        assert_eq!(end, current.passes.start, "blocks must follow each other");
        self.completed = completed;
        self.current = current;
    }

    /// Adds the current block to the completed ones, if it is complete.
    fn begin_block_if_complete(&mut self) {
        if self.current.count() < self.block.get() {
            return;
        }
        self.current.complete_batch();
        let next = PassSums::new(self.desc.crop_size, self.shape(), self.next_pass());
        let block = std::mem::replace(&mut self.current, next);
        match &mut self.completed {
            Some(blocks) => blocks.append(&block),
            None => self.completed = Some(block),
        }
    }
}

/// Whether all channels are finite. Without an early exit, so that the loop becomes vector
/// instructions.
fn are_finite(values: &[Rgb]) -> bool {
    let channels: &[f32] = bytemuck::cast_slice(values);
    channels.iter().fold(true, |all, v| all & v.is_finite())
}
