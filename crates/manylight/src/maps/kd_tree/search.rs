//! Traversal from the root to all leaves within a bound, nearest boxes first.

use super::index::{KdBlock, KdIndex, LEAF_BLOCKS, MAX_LEVELS};
use crate::lanes::{Float, LANES, Sixteen, Vector};
use crate::math::Vec3;

/// Processes the points found.
pub(super) trait KdVisitor {
    /// Receives a block and the squared distances of its points, some of which may exceed `bound`;
    /// returns the new bound of the squared distance.
    fn block<S: Sixteen>(&mut self, block: &KdBlock, d2: Float<S>, bound: f32) -> f32;
}

/// An ancestor of the current node, with the children still to visit as a mask of lanes.
#[derive(Clone, Copy, Default)]
struct PendingNode {
    d2: [f32; LANES],
    children: u32,
    node: u32,
}

/// Calls `visit` with every block that may have points within the squared distance `bound`, finite,
/// from `p`.
#[inline(always)]
pub(super) fn search<S: Sixteen>(
    s: S,
    tree: &KdIndex,
    p: Vec3,
    mut bound: f32,
    visit: &mut impl KdVisitor,
) {
    if tree.nodes.is_empty() {
        return;
    }
    let p = Vector::splat(s, p);
    let last = tree.levels.len() - 1;
    let mut path = [PendingNode::default(); MAX_LEVELS];
    let (mut level, mut node) = (0, 0);
    let mut d2 = tree.nodes[0].distances_squared(p);
    let mut children = u32::MAX;
    loop {
        children &= d2.le(bound).bits();
        if level == last {
            while children != 0 {
                let lane = d2.lowest(children);
                children &= !(1 << lane);
                let first = (node as usize * LANES + lane) * LEAF_BLOCKS;
                let end = (first + LEAF_BLOCKS).min(tree.blocks.len());
                for block in &tree.blocks[first..end] {
                    bound = visit.block(block, block.distances_squared(p), bound);
                }
                children &= d2.le(bound).bits();
            }
        } else if children != 0 {
            let lane = d2.lowest(children);
            path[level] = PendingNode {
                d2: d2.store(),
                children: children & !(1 << lane),
                node,
            };
            level += 1;
            node = node * LANES as u32 + lane as u32;
            d2 = tree.node(level, node).distances_squared(p);
            children = u32::MAX;
            continue;
        }
        if level == 0 {
            return;
        }
        level -= 1;
        d2 = Float::load(s, &path[level].d2);
        children = path[level].children;
        node = path[level].node;
    }
}
