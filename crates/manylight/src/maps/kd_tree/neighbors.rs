//! The K nearest neighbors: up to about 2 K candidates are collected, then reduced to the K nearest
//! by counting.

use super::index::{KdBlock, KdIndex};
use super::search::{KdVisitor, search};
use crate::lanes::{Float, LANES, Sixteen, Word};
use crate::math::Vec3;
use crate::simd::{Simd, SimdKernel, set_bits};

/// Number of candidates around the K-th below which they are sorted instead of counted.
const SORTED: usize = 2 * LANES;
/// Largest number of guesses of the distance of the K-th candidate; points on surfaces need three
/// or four.
const MAX_GUESSES: usize = 12;

/// Result and working memory of [`KdTree::nearest`](super::KdTree::nearest). Reuse one per thread:
/// in the same tree, a search near the last one begins with a tight bound.
#[derive(Clone, Debug)]
pub struct Neighbors {
    k: usize,
    count: usize,
    /// Squared distances of `count` candidates, followed by space for two blocks.
    d2: Vec<f32>,
    /// Indices of the candidates.
    index: Vec<u32>,
    /// Memory for [`key`]s.
    keys: Vec<u64>,
    radius_squared: f32,
    last: Option<LastSearch>,
}

/// The last search, if it found K neighbors.
#[derive(Clone, Copy, Debug)]
struct LastSearch {
    tree: u64,
    p: Vec3,
    radius_squared: f32,
}

impl LastSearch {
    /// A squared distance from `p` within which there are at least K points: that sphere contains
    /// the one of the last search.
    fn bound(&self, p: Vec3) -> f32 {
        let radius = (self.radius_squared.sqrt() + self.p.distance(p)) * (1.0 + 1e-5);
        radius * radius + f32::MIN_POSITIVE
    }
}

impl Neighbors {
    /// Keeps at most `k >= 1` neighbors.
    pub fn new(k: usize) -> Self {
        assert!(k >= 1, "k must be at least 1");
        let room = 2 * k + 4 * LANES;
        Neighbors {
            k,
            count: 0,
            d2: vec![f32::INFINITY; room],
            index: vec![0; room],
            keys: Vec::new(),
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

    /// Whether no neighbor was found.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Squared distance of the K-th neighbor, in m². With fewer neighbors, the square of the search
    /// radius; with an infinite one, the squared distance of the farthest neighbor.
    #[inline]
    pub fn radius_squared(&self) -> f32 {
        self.radius_squared
    }
}

/// Finds the K nearest points of `tree` within `max_radius` of `p`.
pub(super) struct NeighborQuery<'a> {
    pub(super) tree: &'a KdIndex,
    pub(super) p: Vec3,
    pub(super) max_radius: f32,
    pub(super) found: &'a mut Neighbors,
}

impl SimdKernel for NeighborQuery<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let s = s.wide();
        let limit = (self.max_radius * self.max_radius).min(f32::MAX);
        let last = self.found.last.filter(|last| last.tree == self.tree.id);
        let bound = last.map_or(limit, |last| last.bound(self.p).min(limit));
        let mut collect = CandidateCollector {
            // Without a bound, reduce early to get one.
            limit: if bound < f32::MAX {
                2 * self.found.k
            } else {
                self.found.k
            } + LANES,
            found: self.found,
        };
        collect.found.count = 0;
        search(s, self.tree, self.p, bound, &mut collect);
        let found = self.found;
        found.radius_squared = if found.count >= found.k {
            found.keep_nearest(s)
        } else if limit < f32::MAX {
            limit
        } else {
            found.highest(s)
        };
        found.last = (found.count == found.k).then_some(LastSearch {
            tree: self.tree.id,
            p: self.p,
            radius_squared: found.radius_squared,
        });
    }
}

/// Collects candidates and reduces them when there are too many.
struct CandidateCollector<'a> {
    found: &'a mut Neighbors,
    /// Number of candidates at which they are reduced to K.
    limit: usize,
}

impl KdVisitor for CandidateCollector<'_> {
    #[inline(always)]
    fn block<S: Sixteen>(&mut self, block: &KdBlock, d2: Float<S>, bound: f32) -> f32 {
        let (s, found) = (d2.width(), &mut *self.found);
        let near = d2.le(bound).bits();
        let place = found.count..found.count + LANES;
        found.d2[place.clone()].copy_from_slice(&d2.compress(near));
        found.index[place].copy_from_slice(&Word::load(s, &block.index).compress(near));
        found.count += near.count_ones() as usize;
        if found.count < self.limit {
            return bound;
        }
        // Reducing 2 K candidates costs constant time per candidate.
        self.limit = 2 * found.k + LANES;
        found.keep_nearest(s)
    }
}

impl Neighbors {
    /// Keeps the K nearest of at least K candidates, and returns the squared distance of the K-th.
    #[inline(always)]
    fn keep_nearest<S: Sixteen>(&mut self, s: S) -> f32 {
        if self.count == self.k {
            return self.highest(s);
        }
        let (last, last_index) = self.kth(s);
        let mut kept = 0;
        for start in (0..self.count).step_by(LANES) {
            let (d2, index) = self.block(s, start);
            let near = d2.le(last).bits();
            let tied = near & d2.ge(last).bits();
            let dropped = set_bits(tied).filter(|&i| index[i] > last_index);
            let near = near & !dropped.fold(0, |mask, i| mask | 1 << i);
            // Writes never pass the position that has been read.
            self.d2[kept..kept + LANES].copy_from_slice(&d2.compress(near));
            self.index[kept..kept + LANES].copy_from_slice(&Word::load(s, &index).compress(near));
            kept += near.count_ones() as usize;
        }
        self.count = self.k;
        last
    }

    /// Squared distance and index of the K-th candidate; equal distances are ordered by index.
    ///
    /// Narrows an interval of squared distances around it by counting, with linear interpolation
    /// for the next guess: on surfaces squared distances are uniformly distributed.
    #[inline(always)]
    fn kth<S: Sixteen>(&mut self, s: S) -> (f32, u32) {
        let k = self.k;
        // Invariant: `below < k` candidates have squared distances up to `low`, `within >= k` up to
        // `high`.
        let (mut low, mut below) = (-1.0f32, 0);
        let (mut high, mut within) = (self.highest(s), self.count);
        for _ in 0..MAX_GUESSES {
            if within - below <= SORTED {
                break;
            }
            // Aims a little past the K-th, so that the farther end of the interval moves.
            let (above, under) = (within - k, k - below);
            let goal = if above > under {
                under + (above / 8).min(LANES / 2)
            } else {
                under - (under / 8).min(LANES / 2)
            };
            let from = low.max(0.0);
            let guess = from + (high - from) * (goal as f32 / (within - below) as f32);
            let count = self.count_within(s, guess);
            if count >= k {
                (high, within) = (guess, count);
            } else {
                (low, below) = (guess, count);
            }
        }
        let mut keys = std::mem::take(&mut self.keys);
        keys.clear();
        for start in (0..self.count).step_by(LANES) {
            let (d2, index) = self.block(s, start);
            let near = d2.le(high).bits() & !d2.le(low).bits();
            let d2 = d2.store();
            keys.extend(set_bits(near).map(|i| key(d2[i], index[i])));
        }
        let (_, &mut kth, _) = keys.select_nth_unstable(k - below - 1);
        self.keys = keys;
        (f32::from_bits((kth >> 32) as u32), kth as u32)
    }

    /// Number of candidates with squared distances up to `bound`.
    #[inline(always)]
    fn count_within<S: Sixteen>(&self, s: S, bound: f32) -> usize {
        let mut count = 0;
        for start in (0..self.count).step_by(LANES) {
            count += self.block(s, start).0.le(bound).bits().count_ones();
        }
        count as usize
    }

    /// The largest squared distance of the candidates; 0 without candidates.
    #[inline(always)]
    fn highest<S: Sixteen>(&mut self, s: S) -> f32 {
        self.end_candidates();
        let mut highest = Float::splat(s, 0.0);
        for start in (0..self.count).step_by(LANES) {
            highest = self.block(s, start).0.max(highest);
        }
        highest.store().into_iter().fold(0.0, f32::max)
    }

    /// Fills the last block of candidates with NaN, which is in no interval.
    #[inline(always)]
    fn end_candidates(&mut self) {
        self.d2[self.count..self.count + LANES].fill(f32::NAN);
    }

    /// The block of candidates from index `start`.
    #[inline(always)]
    fn block<S: Sixteen>(&self, s: S, start: usize) -> (Float<S>, [u32; LANES]) {
        let mut d2 = [0.0; LANES];
        let mut index = [0; LANES];
        d2.copy_from_slice(&self.d2[start..start + LANES]);
        index.copy_from_slice(&self.index[start..start + LANES]);
        (Float::load(s, &d2), index)
    }
}

/// The bits of the squared distance followed by the index: integers ordered by distance, ties by
/// index.
#[inline(always)]
fn key(d2: f32, index: u32) -> u64 {
    u64::from(d2.to_bits()) << 32 | u64::from(index)
}
