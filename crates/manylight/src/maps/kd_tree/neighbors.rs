//! The K nearest: candidates are collected up to twice too many, then cut back.

use super::search::{Visit, search};
use super::tree::{Block, Tree};
use crate::math::Vec3;
use crate::simd::{Simd, SimdKernel, WIDE, Wide, set_bits};

/// Candidates around the K-th that are put in order one by one.
const CLOSE: usize = 2 * WIDE;
/// Guesses at the distance of the K-th; points on surfaces need three or four.
const MAX_GUESSES: usize = 12;

/// The answer to [`KdTree::nearest`](super::KdTree::nearest), and its working memory: make one per thread and use it again.
/// Searches in the same tree for points near each other help each other.
#[derive(Clone, Debug)]
pub struct Neighbors {
    k: usize,
    count: usize,
    /// Squared distances of the first `count` candidates, then room for two blocks.
    d2: Vec<f32>,
    index: Vec<u32>,
    close: Vec<u64>,
    radius_squared: f32,
    last: Option<Last>,
}

/// A search that found all that it was asked for.
#[derive(Clone, Copy, Debug)]
struct Last {
    tree: u64,
    p: Vec3,
    radius_squared: f32,
}

impl Last {
    /// A squared distance from `p` within which there are as many points as the last search found: its sphere lies inside.
    fn bound(&self, p: Vec3) -> f32 {
        let radius = (self.radius_squared.sqrt() + self.p.distance(p)) * (1.0 + 1e-5);
        radius * radius + f32::MIN_POSITIVE
    }
}

impl Neighbors {
    /// Keeps at most `k >= 1` neighbors.
    pub fn new(k: usize) -> Self {
        assert!(k >= 1, "at least one neighbor is asked for");
        let room = 2 * k + 4 * WIDE;
        Neighbors {
            k,
            count: 0,
            d2: vec![f32::INFINITY; room],
            index: vec![0; room],
            close: Vec::new(),
            radius_squared: 0.0,
            last: None,
        }
    }

    /// Index and squared distance of each neighbor, in no particular order.
    #[inline]
    pub fn iter(&self) -> impl Iterator<Item = (u32, f32)> + '_ {
        let found = self.index[..self.count].iter().zip(&self.d2[..self.count]);
        found.map(|(&index, &d2)| (index, d2))
    }

    /// Number of neighbors found.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether none was found.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Squared distance of the `k`-th neighbor, if there are as many; otherwise the square of the radius that was
    /// searched, or of the farthest neighbor if that was infinite.
    #[inline]
    pub fn radius_squared(&self) -> f32 {
        self.radius_squared
    }
}

/// Finds the nearest points of `tree` within `max_radius` of `p`.
pub(super) struct Nearest<'a> {
    pub(super) tree: &'a Tree,
    pub(super) p: Vec3,
    pub(super) max_radius: f32,
    pub(super) found: &'a mut Neighbors,
}

impl SimdKernel for Nearest<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let w = s.wide();
        let limit = (self.max_radius * self.max_radius).min(f32::MAX);
        let last = self.found.last.filter(|last| last.tree == self.tree.id);
        let bound = last.map_or(limit, |last| last.bound(self.p).min(limit));
        let mut collect = Collect {
            // The first bound is worth having early.
            enough: if bound < f32::MAX {
                2 * self.found.k
            } else {
                self.found.k
            } + WIDE,
            found: self.found,
        };
        collect.found.count = 0;
        search(w, self.tree, self.p, bound, &mut collect);
        let found = self.found;
        found.radius_squared = if found.count >= found.k {
            found.keep_nearest(w)
        } else if limit < f32::MAX {
            limit
        } else {
            found.highest(w)
        };
        found.last = (found.count == found.k).then_some(Last {
            tree: self.tree.id,
            p: self.p,
            radius_squared: found.radius_squared,
        });
    }
}

/// Collects candidates.
struct Collect<'a> {
    found: &'a mut Neighbors,
    /// So many candidates are cut back.
    enough: usize,
}

impl Visit for Collect<'_> {
    #[inline(always)]
    fn block<W: Wide>(&mut self, w: W, block: &Block, d2: W::F, bound: f32) -> f32 {
        let found = &mut *self.found;
        let near = w.bits(w.le(d2, w.splat(bound)));
        let place = found.count..found.count + WIDE;
        found.d2[place.clone()].copy_from_slice(&w.compress(near, d2));
        found.index[place].copy_from_slice(&w.compress_words(near, w.load_words(&block.index)));
        found.count += near.count_ones() as usize;
        if found.count < self.enough {
            return bound;
        }
        // From now on, cutting back only when twice too many have come costs constant time per candidate.
        self.enough = 2 * found.k + WIDE;
        found.keep_nearest(w)
    }
}

impl Neighbors {
    /// Drops all but the `k` nearest, of which there are at least as many, and returns the squared distance of the last.
    #[inline(always)]
    fn keep_nearest<W: Wide>(&mut self, w: W) -> f32 {
        if self.count == self.k {
            return self.highest(w);
        }
        let (last, last_index) = self.kth(w);
        let mut kept = 0;
        for start in (0..self.count).step_by(WIDE) {
            let (d2, index) = self.block(w, start);
            let limit = w.splat(last);
            let near = w.bits(w.le(d2, limit));
            let tied = near & w.bits(w.le(limit, d2));
            let dropped = set_bits(tied).filter(|&i| index[i] > last_index);
            let near = near & !dropped.fold(0, |mask, i| mask | 1 << i);
            // Never ahead of what has been read.
            self.d2[kept..kept + WIDE].copy_from_slice(&w.compress(near, d2));
            self.index[kept..kept + WIDE]
                .copy_from_slice(&w.compress_words(near, w.load_words(&index)));
            kept += near.count_ones() as usize;
        }
        self.count = self.k;
        last
    }

    /// Squared distance and index of the `k`-th of the candidates; equal distances are ordered by index.
    ///
    /// Narrows an interval of distances around it by counting. On surfaces the squared distances are spread evenly, so
    /// interpolation is good at guessing.
    #[inline(always)]
    fn kth<W: Wide>(&mut self, w: W) -> (f32, u32) {
        let k = self.k;
        // `below < k` candidates are at most at `low`, `within >= k` at most at `high`.
        let (mut low, mut below) = (-1.0f32, 0);
        let (mut high, mut within) = (self.highest(w), self.count);
        for _ in 0..MAX_GUESSES {
            if within - below <= CLOSE {
                break;
            }
            // The farther end is drawn near: a little past the goal.
            let (above, under) = (within - k, k - below);
            let goal = if above > under {
                under + (above / 8).min(WIDE / 2)
            } else {
                under - (under / 8).min(WIDE / 2)
            };
            let from = low.max(0.0);
            let guess = from + (high - from) * (goal as f32 / (within - below) as f32);
            let count = self.count_within(w, guess);
            if count >= k {
                (high, within) = (guess, count);
            } else {
                (low, below) = (guess, count);
            }
        }
        let mut close = std::mem::take(&mut self.close);
        close.clear();
        for start in (0..self.count).step_by(WIDE) {
            let (d2, index) = self.block(w, start);
            let near = w.bits(w.le(d2, w.splat(high))) & !w.bits(w.le(d2, w.splat(low)));
            let d2 = w.store(d2);
            close.extend(set_bits(near).map(|i| key(d2[i], index[i])));
        }
        let (_, &mut kth, _) = close.select_nth_unstable(k - below - 1);
        self.close = close;
        (f32::from_bits((kth >> 32) as u32), kth as u32)
    }

    /// Candidates at most at squared distance `bound`.
    #[inline(always)]
    fn count_within<W: Wide>(&self, w: W, bound: f32) -> usize {
        let bound = w.splat(bound);
        let mut count = 0;
        for start in (0..self.count).step_by(WIDE) {
            count += w.bits(w.le(self.block(w, start).0, bound)).count_ones();
        }
        count as usize
    }

    /// The highest squared distance of all candidates, 0 without any.
    #[inline(always)]
    fn highest<W: Wide>(&mut self, w: W) -> f32 {
        self.end_candidates();
        let mut highest = w.splat(0.0);
        for start in (0..self.count).step_by(WIDE) {
            highest = w.max(self.block(w, start).0, highest);
        }
        w.store(highest).into_iter().fold(0.0, f32::max)
    }

    /// Fills the last block of candidates up with what is in no interval.
    #[inline(always)]
    fn end_candidates(&mut self) {
        self.d2[self.count..self.count + WIDE].fill(f32::NAN);
    }

    /// Sixteen candidates.
    #[inline(always)]
    fn block<W: Wide>(&self, w: W, start: usize) -> (W::F, [u32; WIDE]) {
        let mut d2 = [0.0; WIDE];
        let mut index = [0; WIDE];
        d2.copy_from_slice(&self.d2[start..start + WIDE]);
        index.copy_from_slice(&self.index[start..start + WIDE]);
        (w.load(&d2), index)
    }
}

/// Bits of the squared distance above the index: integer order is distance order with ties by index.
#[inline(always)]
fn key(d2: f32, index: u32) -> u64 {
    u64::from(d2.to_bits()) << 32 | u64::from(index)
}
