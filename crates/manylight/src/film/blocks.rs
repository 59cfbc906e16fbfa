//! Blocks of passes: the units of which shares of a render consist.
//!
//! A block sums its passes from zero, and completed blocks are added in their order. A sum of
//! floating-point numbers depends on its order: with blocks, a render in one run, a render that was
//! resumed, and one that is merged from parts all add the same numbers in the same order.

use std::num::NonZeroU32;
use std::ops::Range;

/// Passes of a block by default: the passes of a render by default.
pub const DEFAULT_BLOCK: NonZeroU32 = NonZeroU32::new(16).unwrap();
/// A block has a multiple of this number of passes, so that sets of virtual lights, which several
/// passes share, end with a block.
pub const BLOCK_STEP: u32 = 8;

/// Number of blocks of `size` passes in a render of `passes` passes.
pub fn block_count(passes: u32, size: NonZeroU32) -> u32 {
    passes.div_ceil(size.get())
}

/// The passes of block `block`, each block having `size`, in a render of `passes` passes, which may
/// end inside of it.
pub fn passes_of_block(block: u32, size: NonZeroU32, passes: u32) -> Range<u32> {
    let start = block.saturating_mul(size.get());
    start..start.saturating_add(size.get()).min(passes)
}
