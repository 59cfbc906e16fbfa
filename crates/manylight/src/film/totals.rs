//! Sums over all passes of a film: those of the completed blocks and of the current one, added
//! where they are read.

use super::batches::{BatchMoments, add};
use super::coverage::CoverageSums;
use super::sums::TileSums;
use super::tiles::Tile;
use std::borrow::Cow;

/// Sums of one tile over all passes.
#[derive(Clone, Copy, Debug)]
pub(super) struct TileTotals<'f> {
    /// Over completed blocks; `None` if there are none.
    pub(super) completed: Option<&'f TileSums>,
    pub(super) current: &'f TileSums,
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

    /// Difference of the halves with index `k`, by pixel and layer with a variance.
    #[inline]
    pub(super) fn half_difference(&self, k: usize) -> [f64; 3] {
        let current = self.current.halves[k].map(f64::from);
        self.completed.map_or(current, |blocks| {
            add(blocks.halves[k].map(f64::from), current)
        })
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
