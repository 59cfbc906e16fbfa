//! Lanes that share a word: data that they share is read once, and broadcast.

use super::numbers::{Mask, Word};
use crate::simd::Width;

/// The distinct words of some lanes, each with the lanes that hold it.
pub struct Groups<S: Width> {
    words: Word<S>,
    each: S::Each<u32>,
    /// The lanes of groups still to come.
    left: u32,
}

impl<S: Width> Word<S> {
    /// The distinct words of the lanes `within`, each with the lanes there that hold it. For tables
    /// by index: a loop over the groups reads each entry once, and the lanes of `within` select it.
    #[inline(always)]
    pub fn groups(self, within: Mask<S>) -> Groups<S> {
        Groups {
            words: self,
            each: self.store(),
            left: within.bits(),
        }
    }
}

impl<S: Width> Iterator for Groups<S> {
    type Item = (u32, Mask<S>);

    #[inline(always)]
    fn next(&mut self) -> Option<(u32, Mask<S>)> {
        if self.left == 0 {
            return None;
        }
        let first = self.left.trailing_zeros() as usize % S::LANES;
        let word = self.each.as_ref()[first];
        let bits = self.words.equals(word).bits() & self.left;
        self.left &= !bits;
        Some((word, Mask::from_bits(self.words.width(), bits)))
    }
}
