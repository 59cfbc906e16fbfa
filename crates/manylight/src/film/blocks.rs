//! Blocks of passes: the units of which shares of a render consist.
//!
//! A block sums its passes from zero, and completed blocks are added in their order. A sum of floating-point numbers depends on its
//! order: with blocks, a render in one run, a render that was resumed, and one that is merged from parts all add the same
//! numbers in the same order.

use super::sums::PassSums;
use super::{Film, FilmDesc, IdLayer, Layer};
use std::num::NonZeroU32;
use std::ops::Range;

/// Passes of a block by default: the passes of a render by default.
pub const DEFAULT_BLOCK: NonZeroU32 = NonZeroU32::new(16).unwrap();
/// A block has a multiple of this number of passes: sets of virtual lights, which up to eight passes share, end with a block.
pub const BLOCK_STEP: u32 = 8;

/// Number of blocks of `size` passes in a render of `passes` passes.
pub fn block_count(passes: u32, size: NonZeroU32) -> u32 {
    passes.div_ceil(size.get())
}

/// The passes of block `block`, each block having `size`, in a render of `passes` passes, which may end inside of it.
pub fn passes_of_block(block: u32, size: NonZeroU32, passes: u32) -> Range<u32> {
    let start = block.saturating_mul(size.get());
    start..start.saturating_add(size.get()).min(passes)
}

impl Film {
    /// A film with blocks of `block` passes, of which `first` will be the next. `first` is the first pass of a block.
    ///
    /// # Panics
    /// If the first of `layers` is not [`Layer::Beauty`], `block` is no multiple of [`BLOCK_STEP`], or `first` none of `block`.
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
    pub(super) fn begin_block_if_complete(&mut self) {
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
