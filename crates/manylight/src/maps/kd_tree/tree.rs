//! The index: points in blocks of sixteen under a sixteen-wide tree of boxes.
//!
//! The leaves are full runs of blocks, and every node but the last of its level has all its children, so that places follow
//! from counting. Nodes keep the tight boxes of their children: particles lie on surfaces, where boxes prune far better than
//! splitting planes.

use crate::math::{Aabb, Vec3};
use crate::simd::{Isa, WIDE, Wide};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// Blocks in a leaf.
pub(super) const LEAF_BLOCKS: usize = 1;
/// Points in a leaf.
const LEAF: usize = LEAF_BLOCKS * WIDE;
/// Levels of nodes that 2^32 points need at most.
pub(super) const MAX_LEVELS: usize = 8;
/// Points below which a range is arranged by one thread.
const SEQUENTIAL: usize = 16_384;

/// Sixteen points; the last blocks are filled up with points infinitely far away.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Block {
    position: [[f32; WIDE]; 3],
    pub(super) index: [u32; WIDE],
}

impl Block {
    const EMPTY: Block = Block {
        position: [[f32::INFINITY; WIDE]; 3],
        index: [u32::MAX; WIDE],
    };

    fn of(entries: &[Entry]) -> Self {
        let mut block = Block::EMPTY;
        for (i, e) in entries.iter().enumerate() {
            for axis in 0..3 {
                block.position[axis][i] = e.p[axis];
            }
            block.index[i] = e.index;
        }
        block
    }

    /// Box around the points.
    fn bounds(&self) -> Aabb {
        let count = self.index.iter().filter(|&&i| i != u32::MAX).count();
        let [x, y, z] = &self.position;
        Aabb::from_points((0..count).map(|i| Vec3::new(x[i], y[i], z[i])))
    }

    /// Squared distances of the points from `p`.
    #[inline(always)]
    pub(super) fn distances_squared<W: Wide>(&self, w: W, p: &[W::F; 3]) -> W::F {
        let [x, y, z] = &self.position;
        length_squared(
            w,
            w.sub(w.load(x), p[0]),
            w.sub(w.load(y), p[1]),
            w.sub(w.load(z), p[2]),
        )
    }
}

/// The boxes of sixteen children.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Node {
    min: [[f32; WIDE]; 3],
    max: [[f32; WIDE]; 3],
}

impl Node {
    fn of(children: impl Iterator<Item = Aabb>) -> Self {
        let mut node = Node {
            min: [[f32::INFINITY; WIDE]; 3],
            max: [[f32::NEG_INFINITY; WIDE]; 3],
        };
        for (i, child) in children.enumerate() {
            for axis in 0..3 {
                node.min[axis][i] = child.min[axis];
                node.max[axis][i] = child.max[axis];
            }
        }
        node
    }

    /// Box around all children.
    fn bounds(&self) -> Aabb {
        let lowest = |x: &[f32; WIDE]| x.iter().copied().fold(f32::INFINITY, f32::min);
        let highest = |x: &[f32; WIDE]| x.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        Aabb {
            min: Vec3::from(self.min.each_ref().map(lowest)),
            max: Vec3::from(self.max.each_ref().map(highest)),
        }
    }

    /// Squared distances of the boxes from `p`, infinite where there is no child.
    ///
    /// The same sums of the same rounded differences as for points, so rounding never prunes a point.
    #[inline(always)]
    pub(super) fn distances_squared<W: Wide>(&self, w: W, p: &[W::F; 3]) -> W::F {
        length_squared(
            w,
            self.step(w, p, 0),
            self.step(w, p, 1),
            self.step(w, p, 2),
        )
    }

    /// Distances along an axis.
    #[inline(always)]
    fn step<W: Wide>(&self, w: W, p: &[W::F; 3], axis: usize) -> W::F {
        let below = w.sub(w.load(&self.min[axis]), p[axis]);
        let above = w.sub(p[axis], w.load(&self.max[axis]));
        w.max(w.max(below, above), w.splat(0.0))
    }
}

#[inline(always)]
fn length_squared<W: Wide>(w: W, x: W::F, y: W::F, z: W::F) -> W::F {
    let (x, y, z) = (w.mul(x, x), w.mul(y, y), w.mul(z, z));
    w.add(w.add(x, y), z)
}

/// A point on its way into a leaf.
#[derive(Clone, Copy)]
struct Entry {
    p: [f32; 3],
    index: u32,
}

/// An index over points.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    /// Blocks of each leaf one after the other.
    pub(super) blocks: Vec<Block>,
    /// Level after level from the root; child `c` of the `n`-th node of a level is the `16 n + c`-th of the next, or leaf.
    pub(super) nodes: Vec<Node>,
    /// Where each level begins in `nodes`; the children of the last are the leaves.
    pub(super) levels: Vec<u32>,
    pub(super) isa: Isa,
    /// No two trees of different points have the same.
    pub(super) id: u64,
}

impl Tree {
    /// Builds in parallel; `position(i)` must be finite.
    pub(super) fn build(count: usize, position: impl Fn(usize) -> Vec3 + Sync) -> Self {
        assert!(count < u32::MAX as usize, "indices have 32 bits");
        let mut entries: Vec<Entry> = (0..count)
            .into_par_iter()
            .map(|i| Entry {
                p: position(i).to_array(),
                index: i as u32,
            })
            .collect();
        arrange(&mut entries);
        let blocks: Vec<Block> = entries.par_chunks(WIDE).map(Block::of).collect();
        drop(entries);
        let (nodes, levels) = nodes_over(&blocks);
        static TREES: AtomicU64 = AtomicU64::new(0);
        Tree {
            blocks,
            nodes,
            levels,
            isa: Isa::best(),
            id: TREES.fetch_add(1, Ordering::Relaxed),
        }
    }

    /// A node by its place in its level.
    #[inline(always)]
    pub(super) fn node(&self, level: usize, place: u32) -> &Node {
        &self.nodes[(self.levels[level] + place) as usize]
    }

    /// Makes indices count the points in the order of the leaves; returns what they were.
    pub(super) fn renumber(&mut self) -> Vec<u32> {
        let mut old = Vec::with_capacity(self.blocks.len() * WIDE);
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

/// Orders the points such that the leaves, and the groups of 16, 256, ... leaves, are compact runs: splits along the
/// longest edge of the box, as near to the middle as full groups allow.
fn arrange(entries: &mut [Entry]) {
    if entries.len() <= LEAF {
        return;
    }
    let mut group = LEAF;
    while group * WIDE < entries.len() {
        group *= WIDE;
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

fn select<const AXIS: usize>(entries: &mut [Entry], middle: usize) {
    entries.select_nth_unstable_by(middle, |a, b| {
        // Finite coordinates have an order.
        a.p[AXIS]
            .partial_cmp(&b.p[AXIS])
            .unwrap_or(std::cmp::Ordering::Equal)
    });
}

fn longest_axis(entries: &[Entry]) -> usize {
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

/// The boxes over the leaves, level by level.
fn nodes_over(blocks: &[Block]) -> (Vec<Node>, Vec<u32>) {
    let leaf_bounds = |leaf: &[Block]| leaf.iter().map(Block::bounds).reduce(Aabb::union);
    let mut levels: Vec<Vec<Node>> = vec![
        blocks
            .par_chunks(LEAF_BLOCKS * WIDE)
            .map(|leaves| Node::of(leaves.chunks(LEAF_BLOCKS).filter_map(leaf_bounds)))
            .collect(),
    ];
    while let Some(below) = levels.last().filter(|level| level.len() > 1) {
        let above = below
            .par_chunks(WIDE)
            .map(|children| Node::of(children.iter().map(Node::bounds)))
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
