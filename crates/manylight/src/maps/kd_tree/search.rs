//! Traversal from the root to all leaves within a bound, nearest boxes first.

use super::index::{KdBlock, KdIndex, LEAF_BLOCKS, MAX_LEVELS};
use crate::math::Vec3;
use crate::simd::{LANES, Sixteen};

/// Processes the points found.
pub(super) trait KdVisitor {
    /// Receives a block and the squared distances of its points, some of which may exceed `bound`; returns the new bound of the squared distance.
    fn block<W: Sixteen>(&mut self, w: W, block: &KdBlock, d2: W::F, bound: f32) -> f32;
}

/// An ancestor of the current node, with the children still to visit as a mask of lanes.
#[derive(Clone, Copy, Default)]
struct PendingNode {
    d2: [f32; LANES],
    children: u32,
    node: u32,
}

/// Calls `visit` with every block that may have points within the squared distance `bound`, finite, from `p`.
#[inline(always)]
pub(super) fn search<W: Sixteen>(
    w: W,
    tree: &KdIndex,
    p: Vec3,
    mut bound: f32,
    visit: &mut impl KdVisitor,
) {
    if tree.nodes.is_empty() {
        return;
    }
    let p = [w.splat(p.x), w.splat(p.y), w.splat(p.z)];
    let last = tree.levels.len() - 1;
    let mut path = [PendingNode::default(); MAX_LEVELS];
    let (mut level, mut node) = (0, 0);
    let mut d2 = tree.nodes[0].distances_squared(w, &p);
    let mut children = u32::MAX;
    loop {
        children &= w.bits(w.le(d2, w.splat(bound)));
        if level == last {
            while children != 0 {
                let lane = w.lowest(children, d2);
                children &= !(1 << lane);
                let first = (node as usize * LANES + lane as usize) * LEAF_BLOCKS;
                let end = (first + LEAF_BLOCKS).min(tree.blocks.len());
                for block in &tree.blocks[first..end] {
                    let d2 = block.distances_squared(w, &p);
                    bound = visit.block(w, block, d2, bound);
                }
                children &= w.bits(w.le(d2, w.splat(bound)));
            }
        } else if children != 0 {
            let lane = w.lowest(children, d2);
            path[level] = PendingNode {
                d2: w.store(d2),
                children: children & !(1 << lane),
                node,
            };
            level += 1;
            node = node * LANES as u32 + lane;
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
