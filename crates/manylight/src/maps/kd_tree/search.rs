//! The walk from the root to all leaves that are near enough, nearest boxes first.

use super::lanes::{Lanes, WIDTH};
use super::tree::{Block, LEAF_BLOCKS, MAX_LEVELS, Tree};
use crate::math::Vec3;

/// What is done with the points found.
pub(super) trait Visit {
    /// Gets a block with the squared distances of its points, of which any may exceed `bound`; returns the bound on the
    /// squared distance from then on.
    fn block<L: Lanes>(&mut self, lanes: L, block: &Block, d2: L::F, bound: f32) -> f32;
}

/// A node on the way down, with the children that are still to be visited.
#[derive(Clone, Copy, Default)]
struct Pending {
    d2: [f32; WIDTH],
    children: u32,
    node: u32,
}

/// Shows `visit` every block that may hold points with a squared distance from `p` of at most `bound`, which is finite.
#[inline(always)]
pub(super) fn search<L: Lanes>(
    lanes: L,
    tree: &Tree,
    p: Vec3,
    mut bound: f32,
    visit: &mut impl Visit,
) {
    if tree.nodes.is_empty() {
        return;
    }
    let p = [lanes.splat(p.x), lanes.splat(p.y), lanes.splat(p.z)];
    let last = tree.levels.len() - 1;
    let mut path = [Pending::default(); MAX_LEVELS];
    let (mut level, mut node) = (0, 0);
    let mut d2 = tree.nodes[0].distances_squared(lanes, &p);
    let mut children = u32::MAX;
    loop {
        children &= lanes.le(d2, lanes.splat(bound));
        if level == last {
            while children != 0 {
                let lane = lanes.lowest(children, d2);
                children &= !(1 << lane);
                let first = (node as usize * WIDTH + lane as usize) * LEAF_BLOCKS;
                let end = (first + LEAF_BLOCKS).min(tree.blocks.len());
                for block in &tree.blocks[first..end] {
                    let d2 = block.distances_squared(lanes, &p);
                    bound = visit.block(lanes, block, d2, bound);
                }
                children &= lanes.le(d2, lanes.splat(bound));
            }
        } else if children != 0 {
            let lane = lanes.lowest(children, d2);
            path[level] = Pending {
                d2: lanes.store(d2),
                children: children & !(1 << lane),
                node,
            };
            level += 1;
            node = node * WIDTH as u32 + lane;
            d2 = tree.node(level, node).distances_squared(lanes, &p);
            children = u32::MAX;
            continue;
        }
        if level == 0 {
            return;
        }
        level -= 1;
        d2 = lanes.load(&path[level].d2);
        children = path[level].children;
        node = path[level].node;
    }
}
