//! Divisions of items in two by the surface area heuristic over bins.
//!
//! Source: Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", Symposium on
//! Interactive Ray Tracing, 2007. Large lists are cut into chunks, which are processed in parallel.
//! The chunks do not depend on the number of threads, and minima, maxima and counts do not depend
//! on the order of their operands.

use super::item_box::{Bounds, ItemBox};
use super::join_chunks::join_chunks;
use crate::simd::{Isa, Simd, SimdKernel};
use rayon::prelude::*;

/// Number of items from which on a division runs in parallel: four chunks, so that there is work to
/// share. Shorter lists are divided at once, while other tasks divide others.
const LARGE: usize = 4 * CHUNK;

/// Number of items of a chunk: half a megabyte. With 2^12 to 2^17 items, the third-party kitchen
/// (10^6 triangles) is built in 1.65 to 1.76 s, within the spread of the runs.
const CHUNK: usize = 1 << 14;

/// A division: the first `count` items, and the rest.
pub(super) struct Split {
    pub(super) count: usize,
    pub(super) bounds: [Bounds; 2],
}

/// Divides at least two items where the expected cost of rays is least, and reorders them. A test
/// of up to `max_leaf` items has the same cost. Items with the same center are divided evenly. All
/// instruction sets give the same division.
pub(super) fn split(isa: Isa, items: &mut [ItemBox], max_leaf: usize) -> Split {
    let found = if items.len() < LARGE {
        isa.run(SmallSplit {
            items: &mut *items,
            max_leaf,
        })
    } else {
        split_large(isa, items, max_leaf)
    };
    found.unwrap_or_else(|| halves(items))
}

/// Kernel of [`split`] for short lists.
struct SmallSplit<'a> {
    items: &'a mut [ItemBox],
    max_leaf: usize,
}

impl SimdKernel for SmallSplit<'_> {
    type Output = Option<Split>;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Option<Split> {
        // Few bins make short lists cheap. Four of them for up to eight items raise the expected
        // cost of rays by 0.2 % (living-room) and 0.9 % (garage). Bins along all axes instead of
        // the longest would lower it by up to 2 % after reinsertion, and triple the work.
        match self.items.len() {
            0..=8 => self.divide::<4>(),
            9..32 => self.divide::<8>(),
            _ => self.divide::<16>(),
        }
    }
}

impl SmallSplit<'_> {
    #[inline(always)]
    fn divide<const BINS: usize>(self) -> Option<Split> {
        let binning = Binning::<BINS>::new(center_bounds(self.items))?;
        let bins = Bins::of(&binning, self.items);
        let border = bins.best(self.max_leaf)?;
        let bounds = bins.bounds_beside(border);
        let count = partition(self.items, &binning, border);
        Some(Split { count, bounds })
    }
}

/// [`split`] for long lists, in parallel.
fn split_large(isa: Isa, items: &mut [ItemBox], max_leaf: usize) -> Option<Split> {
    let chunks = items.par_chunks(CHUNK);
    let bounds = chunks.map(|chunk| isa.run(CenterBounds(chunk)));
    let centers = bounds.reduce(|| Bounds::EMPTY, Bounds::union);
    let binning = &Binning::<16>::new(centers)?;
    let chunks = items.par_chunks(CHUNK);
    let parts = chunks.map(|items| isa.run(Fill { binning, items }));
    let bins = parts.reduce(|| Bins::EMPTY, Bins::merge);
    let border = bins.best(max_leaf)?;
    let chunks = items.par_chunks_mut(CHUNK);
    let counts = chunks.map(|items| {
        isa.run(Partition {
            items,
            binning,
            border,
        })
    });
    let counts: Vec<usize> = counts.collect();
    let count = join_chunks(items, CHUNK, &counts);
    let bounds = bins.bounds_beside(border);
    Some(Split { count, bounds })
}

/// Kernel of [`center_bounds`].
struct CenterBounds<'a>(&'a [ItemBox]);

impl SimdKernel for CenterBounds<'_> {
    type Output = Bounds;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Bounds {
        center_bounds(self.0)
    }
}

/// Kernel of [`Bins::of`].
struct Fill<'a, const BINS: usize> {
    binning: &'a Binning<BINS>,
    items: &'a [ItemBox],
}

impl<const BINS: usize> SimdKernel for Fill<'_, BINS> {
    type Output = Bins<BINS>;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Bins<BINS> {
        Bins::of(self.binning, self.items)
    }
}

/// Kernel of [`partition`].
struct Partition<'a, const BINS: usize> {
    items: &'a mut [ItemBox],
    binning: &'a Binning<BINS>,
    border: usize,
}

impl<const BINS: usize> SimdKernel for Partition<'_, BINS> {
    type Output = usize;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> usize {
        partition(self.items, self.binning, self.border)
    }
}

/// Divides items evenly along the longest axis of their centers.
pub(super) fn split_evenly(items: &mut [ItemBox]) -> Split {
    let axis = longest_axis(center_bounds(items));
    items.select_nth_unstable_by(items.len() / 2, |a, b| {
        let [p, q] = [a, b].map(|item| item.twice_center_along(axis));
        p.total_cmp(&q).then(a.item().cmp(&b.item()))
    });
    halves(items)
}

/// The first half and the rest.
fn halves(items: &[ItemBox]) -> Split {
    let count = items.len() / 2;
    let (left, right) = items.split_at(count);
    Split {
        count,
        bounds: [Bounds::of(left), Bounds::of(right)],
    }
}

/// Bounding box of twice the centers.
#[inline(always)]
fn center_bounds(items: &[ItemBox]) -> Bounds {
    let include = |bounds: Bounds, item: &ItemBox| bounds.include(item.twice_center());
    items.iter().fold(Bounds::EMPTY, include)
}

#[inline(always)]
fn longest_axis(bounds: Bounds) -> usize {
    let d = bounds.upper - bounds.lower;
    match (d.x >= d.y, d.x >= d.z, d.y >= d.z) {
        (true, true, _) => 0,
        (_, _, true) => 1,
        _ => 2,
    }
}

/// Bins of equal width along an axis.
struct Binning<const BINS: usize> {
    axis: usize,
    /// Twice the center of the first bin.
    origin: f32,
    /// Reciprocal of twice the width of a bin.
    scale: f32,
}

impl<const BINS: usize> Binning<BINS> {
    /// Bins along the longest axis: the first is centered at the lowest center, the last at the
    /// highest. `None` if all centers are equal.
    #[inline(always)]
    fn new(centers: Bounds) -> Option<Self> {
        let axis = longest_axis(centers);
        let Bounds { lower, upper } = centers;
        let (origin, width) = (lower[axis], upper[axis] - lower[axis]);
        let scale = (BINS - 1) as f32 / width;
        (width > 0.0 && scale.is_finite()).then_some(Binning {
            axis,
            origin,
            scale,
        })
    }

    #[inline(always)]
    fn bin(&self, item: &ItemBox) -> usize {
        /// Added to a number from 0 to 2^22, it leaves the nearest integer in the low bits.
        const ROUND: f32 = (1 << 23) as f32;
        let place = (item.twice_center_along(self.axis) - self.origin) * self.scale;
        (place + ROUND).to_bits() as usize % BINS
    }
}

/// The contents of bins.
struct Bins<const BINS: usize> {
    bounds: [Bounds; BINS],
    counts: [u32; BINS],
}

impl<const BINS: usize> Bins<BINS> {
    const EMPTY: Self = Bins {
        bounds: [Bounds::EMPTY; BINS],
        counts: [0; BINS],
    };

    #[inline(always)]
    fn of(binning: &Binning<BINS>, items: &[ItemBox]) -> Self {
        /// Number of bins with which two sets are filled in turns.
        const MANY: usize = 16;
        let mut bins = Self::EMPTY;
        let mut rest = items;
        if BINS >= MANY {
            // Neighbors often fall into the same bin, and would wait for one another.
            let (pairs, last) = items.as_chunks();
            let mut others = Self::EMPTY;
            for [a, b] in pairs {
                bins.add(binning, a);
                others.add(binning, b);
            }
            bins = bins.merge(others);
            rest = last;
        }
        rest.iter().for_each(|item| bins.add(binning, item));
        bins
    }

    #[inline(always)]
    fn add(&mut self, binning: &Binning<BINS>, item: &ItemBox) {
        let bin = binning.bin(item);
        self.bounds[bin] = self.bounds[bin].with(item);
        self.counts[bin] += 1;
    }

    #[inline(always)]
    fn merge(mut self, other: Self) -> Self {
        for bin in 0..BINS {
            self.bounds[bin] = self.bounds[bin].union(other.bounds[bin]);
            self.counts[bin] += other.counts[bin];
        }
        self
    }

    /// The bounds of the items in the bins before `border`, and of the rest.
    #[inline(always)]
    fn bounds_beside(&self, border: usize) -> [Bounds; 2] {
        let (left, right) = self.bounds.split_at(border);
        [left, right].map(|bins| bins.iter().copied().fold(Bounds::EMPTY, Bounds::union))
    }

    /// Number of bins on the left side of the cheapest division; `None` if one side is always
    /// empty, or areas overflow.
    #[inline(always)]
    fn best(&self, max_leaf: usize) -> Option<usize> {
        let leaves = |count: u32| (count as usize).div_ceil(max_leaf) as f32;
        let mut right = [0.0; BINS];
        let (mut bounds, mut count) = (Bounds::EMPTY, 0);
        for bin in (1..BINS).rev() {
            bounds = bounds.union(self.bounds[bin]);
            count += self.counts[bin];
            right[bin] = bounds.half_area() * leaves(count);
        }
        let (mut bounds, mut count) = (Bounds::EMPTY, 0);
        let (mut best, mut least) = (None, f32::INFINITY);
        for (bin, right) in right.iter().enumerate().skip(1) {
            bounds = bounds.union(self.bounds[bin - 1]);
            count += self.counts[bin - 1];
            // NaN if a side is empty.
            let cost = bounds.half_area() * leaves(count) + right;
            if cost < least {
                (best, least) = (Some(bin), cost);
            }
        }
        best
    }
}

/// Moves the items of the bins before `border` to the front; returns their number.
#[inline(always)]
fn partition<const BINS: usize>(
    items: &mut [ItemBox],
    binning: &Binning<BINS>,
    border: usize,
) -> usize {
    let mut count = 0;
    for i in 0..items.len() {
        // Without a branch, which would be mispredicted often.
        let item = items[i];
        items.swap(i, count);
        count += usize::from(binning.bin(&item) < border);
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Aabb, Vec3};
    use crate::sampling::rng::Pcg;
    use crate::simd::Instructions;

    /// Boxes of various sizes; a fifth of them coincide.
    fn boxes(count: u32) -> Vec<ItemBox> {
        let mut random = Pcg::new(u64::from(count));
        let mut next = || Vec3::from_array(std::array::from_fn(|_| random.next_f32()));
        (0..count)
            .map(|item| {
                let min = if item % 5 == 0 {
                    Vec3::ONE
                } else {
                    3.0 * next()
                };
                let max = min + if item % 5 == 0 { 0.1 } else { 1.0 } * next();
                ItemBox::new(Aabb { min, max }, item)
            })
            .collect()
    }

    fn items(boxes: &[ItemBox]) -> Vec<u32> {
        let mut items: Vec<u32> = boxes.iter().map(ItemBox::item).collect();
        items.sort_unstable();
        items
    }

    /// The numbers of a division.
    fn numbers(split: &Split) -> (usize, [Aabb; 2]) {
        (split.count, split.bounds.map(Aabb::from))
    }

    #[test]
    fn all_instruction_sets_divide_alike() {
        for count in [2, 5, 8, 9, 31, 32, 1000, LARGE as u32 + 5000] {
            let all = boxes(count);
            let mut results = Instructions::available().into_iter().map(|instructions| {
                let mut boxes = all.clone();
                let isa = Isa::new(instructions).unwrap();
                let split = split(isa, &mut boxes, 8);
                let parts = [&boxes[..split.count], &boxes[split.count..]];
                assert!(parts.iter().all(|part| !part.is_empty()));
                for (part, bounds) in parts.into_iter().zip(split.bounds) {
                    assert_eq!(Aabb::from(bounds), Bounds::of(part).into());
                }
                assert!(items(&boxes).into_iter().eq(0..count));
                let order: Vec<u32> = boxes.iter().map(ItemBox::item).collect();
                (order, numbers(&split))
            });
            let first = results.next().unwrap();
            assert!(results.all(|result| result == first), "{count} boxes");
        }
    }

    #[test]
    fn chunks_do_not_change_a_division() {
        let all = boxes(3 * LARGE as u32 + 123);
        let (mut short, mut long) = (all.clone(), all);
        let one = SmallSplit {
            items: &mut short,
            max_leaf: 8,
        };
        let one = Isa::best().run(one).unwrap();
        let chunks = split(Isa::best(), &mut long, 8);
        assert_eq!(numbers(&chunks), numbers(&one));
        assert_eq!(items(&long[..one.count]), items(&short[..one.count]));
        assert_eq!(items(&long[one.count..]), items(&short[one.count..]));
    }

    #[test]
    fn the_even_division_follows_the_longest_axis() {
        let mut boxes = boxes(1001);
        let axis = longest_axis(center_bounds(&boxes));
        let split = split_evenly(&mut boxes);
        let along = |item: &ItemBox| item.twice_center_along(axis);
        let (left, right) = boxes.split_at(split.count);
        let greatest = left.iter().map(along).fold(f32::NEG_INFINITY, f32::max);
        assert_eq!(split.count, 500);
        assert!(right.iter().all(|item| along(item) >= greatest));
        assert_eq!(Aabb::from(split.bounds[0]), Bounds::of(left).into());
    }

    #[test]
    fn coincident_items_are_halved() {
        for count in [2, 7, 100, LARGE + 1] {
            let bounds = Aabb {
                min: Vec3::ZERO,
                max: Vec3::ONE,
            };
            let mut boxes = vec![ItemBox::new(bounds, 0); count];
            assert_eq!(split(Isa::best(), &mut boxes, 8).count, count / 2);
            assert_eq!(split_evenly(&mut boxes).count, count / 2);
        }
    }
}
