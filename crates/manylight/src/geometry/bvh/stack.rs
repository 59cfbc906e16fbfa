//! Traversal stacks.
#![allow(
    unsafe_code,
    reason = "initializing two kilobytes per ray would cost more than many traversals"
)]

use super::build::MAX_DEPTH;
use crate::lanes::{Float, Word};
use crate::simd::{NARROW, Simd};
use std::mem::MaybeUninit;

/// Entries of a stack. Each level pops one entry and pushes at most eight; eight more leave room
/// for vector stores beyond the top.
const CAPACITY: usize = (NARROW - 1) * MAX_DEPTH + 1 + NARROW;

/// Subtrees to visit, with the ray parameters of entry. The first `len` entries are initialized.
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

    /// Pops entries until one with entry before `t_max`, and returns its subtree.
    #[inline(always)]
    pub(super) fn pop_before(&mut self, t_max: f32) -> Option<u32> {
        while let Some(top) = self.len.checked_sub(1) {
            self.len = top;
            // SAFETY: the length was at least one, and entries below it are initialized.
            let (word, near) = unsafe {
                (
                    self.children[top].assume_init(),
                    self.near[top].assume_init(),
                )
            };
            if near < t_max {
                return Some(word);
            }
        }
        None
    }

    /// The subtree on top.
    #[inline(always)]
    pub(super) fn top(&self) -> Option<u32> {
        let top = self.len.checked_sub(1)?;
        // SAFETY: the length is at least one, and entries below it are initialized.
        Some(unsafe { self.children[top].assume_init() })
    }

    /// Pushes the children with near <= far in the order `order` (three bits per place), except for
    /// the last, which is returned: this avoids a store and a load.
    #[inline(always)]
    pub(super) fn push_but_last<S: Simd>(
        &mut self,
        s: S,
        order: u32,
        children: &[u32; NARROW],
        (near, far): (Float<S>, Float<S>),
    ) -> Option<u32> {
        let met = near.le(far).bits();
        if met & met.wrapping_sub(1) == 0 {
            // At most one child, as in most nodes: no order needed.
            return (met != 0).then(|| children[met.trailing_zeros() as usize % NARROW]);
        }
        let span = (near.vector(), far.vector());
        let (words, entries) = (
            above(&mut self.children, self.len),
            above(&mut self.near, self.len),
        );
        let places = s.compress_ordered(order, children, span, words, entries);
        if places == 0 {
            return None;
        }
        let last = highest(places);
        self.len += places.count_ones() as usize - 1;
        Some(children[(order >> (3 * last)) as usize % NARROW])
    }
}

/// Subtrees to visit, in any order. The first `len` entries are initialized.
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

    #[inline(always)]
    pub(super) fn top(&self) -> Option<u32> {
        let top = self.len.checked_sub(1)?;
        // SAFETY: the length is at least one, and entries below it are initialized.
        Some(unsafe { self.words[top].assume_init() })
    }

    /// Pushes the words with set `bits`.
    #[inline(always)]
    pub(super) fn push<S: Simd>(&mut self, s: S, words: &[u32; NARROW], bits: u32) {
        let words = Word::load(s, words).compress(bits);
        above(&mut self.words, self.len).write_copy_of_slice(&words);
        self.len += (bits.count_ones() as usize).min(NARROW);
    }
}

/// The highest set bit of the low eight, one of which is set. Not by `ilog2`, which compiles to an
/// instruction that is slow on many processors.
#[inline(always)]
pub(super) fn highest(bits: u32) -> usize {
    const UNUSED: u32 = u32::BITS - NARROW as u32;
    NARROW - 1 - (bits << UNUSED).leading_zeros() as usize
}

/// The eight entries above the top.
#[inline(always)]
fn above<T>(entries: &mut [MaybeUninit<T>], top: usize) -> &mut [MaybeUninit<T>; NARROW] {
    entries[top..]
        .first_chunk_mut()
        .expect("invariant: the build bounds the depth")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::rng::Pcg;
    use crate::simd::{Instructions, Isa, SimdKernel};

    /// Identity: place `i` is lane `i`.
    const ORDER: u32 = 0o7654_3210;

    /// Pushes and pops at random. Each entry that comes back is compared with a list.
    struct Random;

    impl SimdKernel for Random {
        type Output = ();

        #[inline(always)]
        fn run<S: Simd>(self, s: S) {
            let mut rng = Pcg::new(4);
            let (mut stack, mut words) = (Stack::new(), WordStack::new());
            let (mut near_list, mut word_list) = (Vec::new(), Vec::new());
            for step in 0..2000 {
                let met = rng.next_u32() & 0xff;
                let children: [u32; NARROW] = std::array::from_fn(|i| 8 * step + i as u32);
                let near: [f32; NARROW] = std::array::from_fn(|_| rng.next_f32());
                let far = std::array::from_fn(|i| if met >> i & 1 == 1 { 2.0 } else { -1.0 });
                let lanes = (0..NARROW).filter(|i| met >> i & 1 == 1);
                let longest = near_list.len().max(word_list.len());
                if longest + NARROW <= CAPACITY {
                    let span = (Float::load(s, &near), Float::load(s, &far));
                    let next = stack.push_but_last(s, ORDER, &children, span);
                    near_list.extend(lanes.clone().map(|i| (children[i], near[i])));
                    assert_eq!(next, near_list.pop_if(|_| met != 0).map(|entry| entry.0));
                    words.push(s, &children, met);
                    word_list.extend(lanes.map(|i| children[i]));
                }
                assert_eq!(stack.top(), near_list.last().map(|entry| entry.0));
                assert_eq!(words.top(), word_list.last().copied());
                for _ in 0..rng.next_u32() % 6 {
                    let t_max = rng.next_f32();
                    let kept = near_list.iter().rposition(|entry| entry.1 < t_max);
                    let expected = kept.map(|last| near_list[last].0);
                    near_list.truncate(kept.unwrap_or(0));
                    assert_eq!(stack.pop_before(t_max), expected);
                    assert_eq!(words.pop(), word_list.pop());
                }
            }
        }
    }

    #[test]
    fn entries_come_back_in_every_instruction_set() {
        let sets = Instructions::available().into_iter();
        sets.filter_map(Isa::new).for_each(|isa| isa.run(Random));
    }
}
