//! Sums over all passes of a film: those of the completed blocks and of the current one, added where they are read.

use super::Film;
use super::batches::{BatchCounts, BatchMoments, add};
use super::coverage::CoverageSums;
use super::sums::TileSums;
use super::tiles::Tile;
use std::borrow::Cow;

/// Sums of one tile over all passes.
#[derive(Clone, Copy, Debug)]
pub(super) struct TileTotals<'f> {
    /// Over completed blocks; `None` if there are none.
    completed: Option<&'f TileSums>,
    current: &'f TileSums,
}

impl<'f> TileTotals<'f> {
    pub(super) fn tile(&self) -> Tile {
        self.current.tile
    }

    /// Sum of the values with index `k`, by pixel and layer.
    #[inline]
    pub(super) fn sum(&self, k: usize) -> [f64; 3] {
        let current = self.current.sums[k];
        self.completed
            .map_or(current, |blocks| add(blocks.sums[k], current))
    }

    /// Sum of the squares with index `k`, by pixel and layer with a variance.
    #[inline]
    pub(super) fn square(&self, k: usize) -> [f64; 3] {
        let current = self.current.squares[k];
        self.completed
            .map_or(current, |blocks| add(blocks.squares[k], current))
    }

    /// Coverage with index `k`, by pixel and id layer.
    pub(super) fn coverage(&self, k: usize) -> Cow<'f, CoverageSums> {
        let current = &self.current.coverage[k];
        let Some(blocks) = self.completed else {
            return Cow::Borrowed(current);
        };
        let mut total = blocks.coverage[k].clone();
        current
            .iter()
            .for_each(|&(id, weight)| total.add(id, weight));
        Cow::Owned(total)
    }

    pub(super) fn moments(&self) -> BatchMoments {
        let mut total = self
            .completed
            .map_or_else(BatchMoments::default, |blocks| blocks.moments);
        total.merge(&self.current.moments);
        total
    }
}

impl Film {
    /// The tiles of the unshifted grid, row by row.
    pub(super) fn tile_totals(&self) -> impl Iterator<Item = TileTotals<'_>> {
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
    pub(super) fn batch_counts(&self) -> BatchCounts {
        let mut total = self
            .completed
            .as_ref()
            .map_or_else(BatchCounts::default, |blocks| blocks.batches);
        total.merge(self.current.batches);
        total
    }

    /// Moments over completed batches of sums over pixels: of the beauty, and of the beauty without emission.
    pub(super) fn image_moments(&self) -> [BatchMoments; 2] {
        let completed = self.completed.as_ref();
        let mut total = completed.map_or_else(Default::default, |blocks| blocks.image_moments);
        for (total, current) in total.iter_mut().zip(&self.current.image_moments) {
            total.merge(current);
        }
        total
    }
}
