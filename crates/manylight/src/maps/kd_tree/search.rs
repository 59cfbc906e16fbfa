//! The walk from the root to all leaves that are near enough, nearest boxes first.

use super::tree::{Block, LEAF_BLOCKS, MAX_LEVELS, Tree};
use crate::math::Vec3;
use crate::simd::{WIDE, Wide};

/// What is done with the points found.
pub(super) trait Visit {
    /// Gets a block with the squared distances of its points, of which any may exceed `bound`; returns the bound on the
    /// squared distance from then on.
    fn block<W: Wide>(&mut self, w: W, block: &Block, d2: W::F, bound: f32) -> f32;
}

/// A node on the way down, with the children that are still to be visited.
#[derive(Clone, Copy, Default)]
struct Pending {
    d2: [f32; WIDE],
    children: u32,
    node: u32,
}

/// Shows `visit` every block that may hold points with a squared distance from `p` of at most `bound`, which is finite.
#[inline(always)]
pub(super) fn search<W: Wide>(w: W, tree: &Tree, p: Vec3, mut bound: f32, visit: &mut impl Visit) {
    if tree.nodes.is_empty() {
        return;
    }
    let p = [w.splat(p.x), w.splat(p.y), w.splat(p.z)];
    let last = tree.levels.len() - 1;
    let mut path = [Pending::default(); MAX_LEVELS];
    let (mut level, mut node) = (0, 0);
    let mut d2 = tree.nodes[0].distances_squared(w, &p);
    let mut children = u32::MAX;
    loop {
        children &= w.bits(w.le(d2, w.splat(bound)));
        if level == last {
            while children != 0 {
                let lane = w.lowest(children, d2);
                children &= !(1 << lane);
                let first = (node as usize * WIDE + lane as usize) * LEAF_BLOCKS;
                let end = (first + LEAF_BLOCKS).min(tree.blocks.len());
                for block in &tree.blocks[first..end] {
                    let d2 = block.distances_squared(w, &p);
                    bound = visit.block(w, block, d2, bound);
                }
                children &= w.bits(w.le(d2, w.splat(bound)));
            }
        } else if children != 0 {
            let lane = w.lowest(children, d2);
            path[level] = Pending {
                d2: w.store(d2),
                children: children & !(1 << lane),
                node,
            };
            level += 1;
            node = node * WIDE as u32 + lane;
            d2 = tree.node(level, node).distances_squared(w, &p);
            children = u32::MAX;
            continue;
        }
        if level == 0 {
            return;
        }
        level -= 1;
        d2 = w.load(&path[level].d2);
        children = path[level].children;
        node = path[level].node;
    }
}
