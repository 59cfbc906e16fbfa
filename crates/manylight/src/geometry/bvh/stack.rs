//! The traversal stack.
#![allow(
    unsafe_code,
    reason = "clearing two kilobytes per ray would cost more than some rays do"
)]

use super::build::MAX_DEPTH;
use super::simd::{LANES, Simd};
use std::mem::MaybeUninit;

/// Each level pops one entry and pushes at most eight; the rest is room for whole-vector stores beyond the top.
const CAPACITY: usize = (LANES - 1) * MAX_DEPTH + 1 + LANES;

/// Subtrees still to visit, with the distance at which the ray enters them. The first `len` entries are initialized.
pub(super) struct Stack {
    len: usize,
    children: [MaybeUninit<u32>; CAPACITY],
    near: [MaybeUninit<f32>; CAPACITY],
}

impl Stack {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Stack {
            len: 0,
            children: [MaybeUninit::uninit(); CAPACITY],
            near: [MaybeUninit::uninit(); CAPACITY],
        }
    }

    #[inline(always)]
    pub(super) fn push(&mut self, child: u32, near: f32) {
        self.children[self.len].write(child);
        self.near[self.len].write(near);
        self.len += 1;
    }

    #[inline(always)]
    pub(super) fn pop(&mut self) -> Option<(u32, f32)> {
        self.len = self.len.checked_sub(1)?;
        // SAFETY: `len` was at least one, and entries below `len` are initialized.
        unsafe {
            Some((
                self.children[self.len].assume_init(),
                self.near[self.len].assume_init(),
            ))
        }
    }

    /// The eight entries above the top.
    #[inline(always)]
    pub(super) fn spare(
        &mut self,
    ) -> (
        &mut [MaybeUninit<u32>; LANES],
        &mut [MaybeUninit<f32>; LANES],
    ) {
        let children = self.children[self.len..]
            .first_chunk_mut()
            .expect("invariant: the build bounds the depth");
        let near = self.near[self.len..]
            .first_chunk_mut()
            .expect("invariant: the build bounds the depth");
        (children, near)
    }

    /// Adds `count` of the entries above the top.
    ///
    /// # Safety
    /// They were written through [`Stack::spare`] since the last change, and `count` is at most eight.
    #[inline(always)]
    pub(super) unsafe fn grow(&mut self, count: usize) {
        self.len += count;
    }
}

/// Subtrees still to visit, in any order. The first `len` entries are initialized.
pub(super) struct WordStack {
    len: usize,
    words: [MaybeUninit<u32>; CAPACITY],
}

impl WordStack {
    #[inline(always)]
    pub(super) fn new() -> Self {
        WordStack {
            len: 0,
            words: [MaybeUninit::uninit(); CAPACITY],
        }
    }

    #[inline(always)]
    pub(super) fn pop(&mut self) -> Option<u32> {
        self.len = self.len.checked_sub(1)?;
        // SAFETY: `len` was at least one, and entries below `len` are initialized.
        unsafe { Some(self.words[self.len].assume_init()) }
    }

    /// Adds the words whose bits are set.
    #[inline(always)]
    pub(super) fn push<S: Simd>(&mut self, s: S, words: &[u32; LANES], bits: u32) {
        let spare = self.words[self.len..]
            .first_chunk_mut()
            .expect("invariant: the build bounds the depth");
        s.compact(words, bits, spare);
        self.len += bits.count_ones() as usize;
    }
}
