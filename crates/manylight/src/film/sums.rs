//! Sums over a run of passes, which can be added to those of the passes before.

use super::batches::{BatchCounts, BatchMoments, add};
use super::coverage::{CoverageSums, IdLayer};
use super::halves::{Half, HalfCounts};
use super::layer::Layer;
use super::tiles::{Tile, TileGrid, Tiling};
use crate::color::Rgb;
use crate::math::UVec2;
use crate::simd::array;
use rayon::prelude::*;
use std::ops::Range;

/// Sums over consecutive passes, per pixel and per tile of the unshifted grid.
#[derive(Clone, Debug, PartialEq)]
pub struct PassSums {
    /// The passes.
    pub(super) passes: Range<u32>,
    /// How many of them are in each half.
    pub(super) half_counts: HalfCounts,
    /// Completed batches.
    pub(super) batches: BatchCounts,
    /// Moments of sums over all pixels, over completed batches: of the beauty, and of the beauty
    /// without [`Layer::Emission`].
    pub(super) image_moments: [BatchMoments; 2],
    pub(super) tiles: Vec<TileSums>,
}

/// Sums of one tile.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TileSums {
    pub(super) tile: Tile,
    /// Sum over passes, by pixel and layer.
    pub(super) sums: Vec<[f64; 3]>,
    /// Sum over passes of the square, by pixel and layer with a variance.
    pub(super) squares: Vec<[f64; 3]>,
    /// Sum over the passes of the first half less that over the second, by pixel and layer with a
    /// variance.
    pub(super) halves: Vec<[f32; 3]>,
    /// Sum over passes, by pixel and id layer.
    pub(super) coverage: Vec<CoverageSums>,
    /// Sums over pixels and the passes of the current batch: the beauty, and the beauty without
    /// emission.
    pub(super) batch: [[f64; 3]; 2],
    /// Moments of the beauty's sum over pixels, over completed batches.
    pub(super) moments: BatchMoments,
}

/// What a pixel holds: numbers of layers, of layers with a variance, and of id layers.
#[derive(Clone, Copy, Debug)]
pub(super) struct PixelShape {
    pub(super) layers: usize,
    pub(super) with_variance: usize,
    pub(super) id_layers: usize,
}

impl PixelShape {
    pub(super) fn of(layers: &[Layer], id_layers: &[IdLayer]) -> Self {
        PixelShape {
            layers: layers.len(),
            with_variance: layers.iter().filter(|layer| layer.has_variance()).count(),
            id_layers: id_layers.len(),
        }
    }
}

impl PassSums {
    /// Sums over no pass; the first will be `first`.
    pub(super) fn new(size: UVec2, shape: PixelShape, first: u32) -> Self {
        let tiles = TileGrid::new(size, Tiling::UNSHIFTED).tiles();
        PassSums {
            passes: first..first,
            half_counts: HalfCounts::default(),
            batches: BatchCounts::default(),
            image_moments: Default::default(),
            tiles: tiles.map(|tile| TileSums::new(tile, shape)).collect(),
        }
    }

    /// The passes.
    pub fn passes(&self) -> Range<u32> {
        self.passes.clone()
    }

    /// Number of passes.
    pub(super) fn count(&self) -> u32 {
        self.passes.len() as u32
    }

    /// Adds the sums over the passes that follow. Their batches must be complete.
    pub(super) fn append(&mut self, next: &PassSums) {
        debug_assert_eq!(self.passes.end, next.passes.start);
        self.passes.end = next.passes.end;
        self.half_counts.add(next.half_counts);
        self.batches.merge(next.batches);
        for (moments, next) in self.image_moments.iter_mut().zip(&next.image_moments) {
            moments.merge(next);
        }
        let tiles = self.tiles.par_iter_mut().zip(&next.tiles);
        tiles.for_each(|(tile, next)| tile.append(next));
    }

    /// Completes the current batch; see [`Film::begin_batch`](super::Film::begin_batch).
    pub(super) fn complete_batch(&mut self) {
        let passes = self.count() - self.batches.passes();
        if passes == 0 {
            return;
        }
        self.batches.add(passes);
        let mut image = [[0.0; 3]; 2];
        for tile in &mut self.tiles {
            for (sum, part) in image.iter_mut().zip(tile.batch) {
                *sum = add(*sum, part);
            }
            let [beauty, _] = std::mem::take(&mut tile.batch);
            tile.moments.add(passes, beauty);
        }
        for (moments, sum) in self.image_moments.iter_mut().zip(image) {
            moments.add(passes, sum);
        }
    }
}

impl TileSums {
    fn new(tile: Tile, shape: PixelShape) -> Self {
        TileSums {
            tile,
            sums: vec![[0.0; 3]; tile.count() * shape.layers],
            squares: vec![[0.0; 3]; tile.count() * shape.with_variance],
            halves: vec![[0.0; 3]; tile.count() * shape.with_variance],
            coverage: vec![CoverageSums::new(); tile.count() * shape.id_layers],
            batch: Default::default(),
            moments: BatchMoments::default(),
        }
    }

    fn append(&mut self, next: &TileSums) {
        add_all(&mut self.sums, &next.sums);
        add_all(&mut self.squares, &next.squares);
        for (half, next) in
            (self.halves.as_flattened_mut().iter_mut()).zip(next.halves.as_flattened())
        {
            *half += next;
        }
        for (sums, next) in self.coverage.iter_mut().zip(&next.coverage) {
            next.iter().for_each(|&(id, weight)| sums.add(id, weight));
        }
        self.moments.merge(&next.moments);
    }

    /// Adds the values of one pass to pixel `i`, one per layer; `emission` is the index of the
    /// emission, if recorded; `half` is that of the pass.
    #[inline]
    pub(super) fn commit(
        &mut self,
        i: usize,
        pixel: &[Rgb],
        emission: Option<usize>,
        with_variance: &[usize],
        half: Half,
    ) {
        let emitted = emission.map_or(Rgb::BLACK, |l| pixel[l]);
        for (sum, value) in self.batch.iter_mut().zip([pixel[0], pixel[0] - emitted]) {
            let value = value.to_array();
            *sum = add(*sum, array(|c| f64::from(value[c])));
        }
        // Flat slices, of which loops become vector instructions.
        let sums = &mut self.sums[i * pixel.len()..][..pixel.len()];
        let values: &[f32] = bytemuck::cast_slice(pixel);
        for (sum, &value) in sums.as_flattened_mut().iter_mut().zip(values) {
            *sum += f64::from(value);
        }
        let squares = &mut self.squares[i * with_variance.len()..][..with_variance.len()];
        let halves = &mut self.halves[i * with_variance.len()..][..with_variance.len()];
        let sign = half.sign();
        for ((square, difference), &l) in squares.iter_mut().zip(halves).zip(with_variance) {
            for (c, v) in pixel[l].to_array().into_iter().enumerate() {
                square[c] += f64::from(v) * f64::from(v);
                difference[c] += sign * v;
            }
        }
    }
}

fn add_all(sums: &mut [[f64; 3]], terms: &[[f64; 3]]) {
    for (sum, term) in sums.iter_mut().zip(terms) {
        *sum = add(*sum, *term);
    }
}
