//! The index of a [`KdTree`](super::KdTree): points in blocks of sixteen under a tree of boxes with
//! sixteen children per node.
//!
//! All leaves are full, and every node except the last of its level has all its children, so that
//! positions in memory follow from counting. Nodes store the tight boxes of their children:
//! particles lie on surfaces, where boxes prune better than splitting planes.

use crate::lanes::{Float, LANES, Sixteen, Vector, Width};
use crate::math::{Aabb, Vec3};
use crate::simd::Isa;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// Number of blocks in a leaf.
pub(super) const LEAF_BLOCKS: usize = 1;
/// Number of points in a leaf.
const LEAF: usize = LEAF_BLOCKS * LANES;
/// Largest number of levels of nodes, sufficient for 2^32 points.
pub(super) const MAX_LEVELS: usize = 8;
/// Number of points below which a range is sorted by one thread.
const SEQUENTIAL: usize = 16_384;

/// Sixteen points; the last block is filled with points at infinity.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct KdBlock {
    position: [[f32; LANES]; 3],
    pub(super) index: [u32; LANES],
}

impl KdBlock {
    /// A block without items.
    const EMPTY: KdBlock = KdBlock {
        position: [[f32::INFINITY; LANES]; 3],
        index: [u32::MAX; LANES],
    };

    fn of(entries: &[KdEntry]) -> Self {
        let mut block = KdBlock::EMPTY;
        for (i, e) in entries.iter().enumerate() {
            for axis in 0..3 {
                block.position[axis][i] = e.p[axis];
            }
            block.index[i] = e.index;
        }
        block
    }

    /// Bounding box of the points.
    fn bounds(&self) -> Aabb {
        let count = self.index.iter().filter(|&&i| i != u32::MAX).count();
        let [x, y, z] = &self.position;
        Aabb::from_points((0..count).map(|i| Vec3::new(x[i], y[i], z[i])))
    }

    /// Squared distances of the points from `p`.
    #[inline(always)]
    pub(super) fn distances_squared<S: Sixteen>(&self, p: Vector<S>) -> Float<S> {
        length_squared(Vector::load(p.x.width(), &self.position) - p)
    }
}

/// The bounding boxes of sixteen children.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct KdNode {
    min: [[f32; LANES]; 3],
    max: [[f32; LANES]; 3],
}

impl KdNode {
    fn of(children: impl Iterator<Item = Aabb>) -> Self {
        let mut node = KdNode {
            min: [[f32::INFINITY; LANES]; 3],
            max: [[f32::NEG_INFINITY; LANES]; 3],
        };
        for (i, child) in children.enumerate() {
            for axis in 0..3 {
                node.min[axis][i] = child.min[axis];
                node.max[axis][i] = child.max[axis];
            }
        }
        node
    }

    /// Bounding box of all children.
    fn bounds(&self) -> Aabb {
        let lowest = |x: &[f32; LANES]| x.iter().copied().fold(f32::INFINITY, f32::min);
        let highest = |x: &[f32; LANES]| x.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        Aabb {
            min: Vec3::from(self.min.each_ref().map(lowest)),
            max: Vec3::from(self.max.each_ref().map(highest)),
        }
    }

    /// Squared distances of the boxes from `p`, infinite for missing children.
    ///
    /// Rounded like the distances of points, so that rounding never prunes a point.
    #[inline(always)]
    pub(super) fn distances_squared<S: Sixteen>(&self, p: Vector<S>) -> Float<S> {
        let s = p.x.width();
        let below = Vector::load(s, &self.min) - p;
        let above = p - Vector::load(s, &self.max);
        length_squared(below.max(above).max(Vector::splat(s, Vec3::ZERO)))
    }
}

/// Rounded alike in all instruction sets, without fused operations.
#[inline(always)]
fn length_squared<S: Width>(v: Vector<S>) -> Float<S> {
    v.x.squared() + v.y.squared() + v.z.squared()
}

/// A point during construction.
#[derive(Clone, Copy)]
struct KdEntry {
    p: [f32; 3],
    index: u32,
}

/// An index over points.
#[derive(Clone, Debug)]
pub(super) struct KdIndex {
    /// Blocks, leaf by leaf.
    pub(super) blocks: Vec<KdBlock>,
    /// Nodes level by level from the root; child `c` of node `n` of a level is node, or leaf,
    /// `16 n + c` of the next level.
    pub(super) nodes: Vec<KdNode>,
    /// Index in `nodes` of the first node of each level; the children of the last level are the
    /// leaves.
    pub(super) levels: Vec<u32>,
    /// Instruction set of the searches.
    pub(super) isa: Isa,
    /// Number of the tree; only clones share it.
    pub(super) id: u64,
}

impl KdIndex {
    /// Builds in parallel; `position(i)` must be finite.
    pub(super) fn build(count: usize, position: impl Fn(usize) -> Vec3 + Sync) -> Self {
        assert!(count < u32::MAX as usize, "indices have 32 bits");
        let mut entries: Vec<KdEntry> = (0..count)
            .into_par_iter()
            .map(|i| KdEntry {
                p: position(i).to_array(),
                index: i as u32,
            })
            .collect();
        arrange(&mut entries);
        KdIndex::over(&entries)
    }

    /// The index of points in the order of its leaves, as [`KdIndex::renumber`] leaves them. Another
    /// order is right, but slow.
    pub(super) fn of_ordered(count: usize, position: impl Fn(usize) -> Vec3) -> Self {
        assert!(count < u32::MAX as usize, "indices have 32 bits");
        let entry = |i: usize| KdEntry {
            p: position(i).to_array(),
            index: i as u32,
        };
        KdIndex::over(&(0..count).map(entry).collect::<Vec<KdEntry>>())
    }

    /// The index over points in the order of the leaves.
    fn over(entries: &[KdEntry]) -> Self {
        let blocks: Vec<KdBlock> = entries.par_chunks(LANES).map(KdBlock::of).collect();
        let (nodes, levels) = nodes_over(&blocks);
        static TREES: AtomicU64 = AtomicU64::new(0);
        KdIndex {
            blocks,
            nodes,
            levels,
            isa: Isa::best(),
            id: TREES.fetch_add(1, Ordering::Relaxed),
        }
    }

    /// The node with the given index in its level.
    #[inline(always)]
    pub(super) fn node(&self, level: usize, index: u32) -> &KdNode {
        &self.nodes[(self.levels[level] + index) as usize]
    }

    /// Renumbers the points in the order of the leaves; returns the old index of each.
    pub(super) fn renumber(&mut self) -> Vec<u32> {
        let mut old = Vec::with_capacity(self.blocks.len() * LANES);
        for index in self.blocks.iter_mut().flat_map(|block| &mut block.index) {
            if *index != u32::MAX {
                old.push(std::mem::replace(index, old.len() as u32));
            }
        }
        old
    }

    /// Bytes of points and boxes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.blocks.as_slice()) + size_of_val(self.nodes.as_slice())
    }
}

/// Sorts the points so that leaves, and groups of 16, 256, ... leaves, are compact: recursive
/// splits along the longest edge of the bounding box, as near to the middle as full groups allow.
fn arrange(entries: &mut [KdEntry]) {
    if entries.len() <= LEAF {
        return;
    }
    let mut group = LEAF;
    while group * LANES < entries.len() {
        group *= LANES;
    }
    let middle = group * (entries.len().div_ceil(group) / 2);
    match longest_axis(entries) {
        0 => select::<0>(entries, middle),
        1 => select::<1>(entries, middle),
        _ => select::<2>(entries, middle),
    }
    let many = entries.len() >= SEQUENTIAL;
    let (left, right) = entries.split_at_mut(middle);
    if many {
        rayon::join(|| arrange(left), || arrange(right));
    } else {
        arrange(left);
        arrange(right);
    }
}

/// Moves the `middle` points that are lowest along an axis to the front.
fn select<const AXIS: usize>(entries: &mut [KdEntry], middle: usize) {
    entries.select_nth_unstable_by(middle, |a, b| {
        // Finite coordinates have an order.
        a.p[AXIS]
            .partial_cmp(&b.p[AXIS])
            .unwrap_or(std::cmp::Ordering::Equal)
    });
}

fn longest_axis(entries: &[KdEntry]) -> usize {
    let (mut min, mut max) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for e in entries {
        for axis in 0..3 {
            min[axis] = if e.p[axis] < min[axis] {
                e.p[axis]
            } else {
                min[axis]
            };
            max[axis] = if e.p[axis] > max[axis] {
                e.p[axis]
            } else {
                max[axis]
            };
        }
    }
    (Vec3::from(max) - Vec3::from(min)).max_position()
}

/// The nodes over the leaves, level by level from the root, and the index of the first node of each
/// level.
fn nodes_over(blocks: &[KdBlock]) -> (Vec<KdNode>, Vec<u32>) {
    let leaf_bounds = |leaf: &[KdBlock]| leaf.iter().map(KdBlock::bounds).reduce(Aabb::union);
    let mut levels: Vec<Vec<KdNode>> = vec![
        blocks
            .par_chunks(LEAF_BLOCKS * LANES)
            .map(|leaves| KdNode::of(leaves.chunks(LEAF_BLOCKS).filter_map(leaf_bounds)))
            .collect(),
    ];
    while let Some(below) = levels.last().filter(|level| level.len() > 1) {
        let above = below
            .par_chunks(LANES)
            .map(|children| KdNode::of(children.iter().map(KdNode::bounds)))
            .collect();
        levels.push(above);
    }
    levels.reverse();
    let starts = levels
        .iter()
        .scan(0, |start, level| {
            let own = *start;
            *start += level.len() as u32;
            Some(own)
        })
        .collect();
    (levels.concat(), starts)
}
