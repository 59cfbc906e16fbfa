//! Binary bounding volume hierarchies.

use super::item_box::{Bounds, ItemBox};
use super::split::{Split, split, split_evenly};
use crate::math::Aabb;
use crate::simd::Isa;
use rayon::prelude::*;
use std::collections::VecDeque;
use std::ops::Range;

/// A node of a binary tree: a leaf with adjacent items, or an inner node with two adjacent
/// children.
#[derive(Clone, Copy, Debug, bytemuck::Zeroable)]
pub(super) struct BinaryNode {
    pub(super) bounds: Aabb,
    /// Index of the first child, or first item of a leaf.
    first: u32,
    /// Number of items of a leaf, 0 for an inner node.
    count: u32,
}

impl BinaryNode {
    pub(super) fn leaf(bounds: Aabb, items: Range<u32>) -> Self {
        BinaryNode {
            bounds,
            first: items.start,
            count: items.end - items.start,
        }
    }

    pub(super) fn parent(bounds: Aabb, first_child: usize) -> Self {
        BinaryNode {
            bounds,
            first: first_child as u32,
            count: 0,
        }
    }

    /// The node with its children moved by `shift` places.
    fn shifted(mut self, shift: u32) -> Self {
        self.first += if self.count == 0 { shift } else { 0 };
        self
    }

    /// The items of a leaf; none for an inner node.
    #[inline(always)]
    pub(super) fn items(&self) -> Range<usize> {
        let first = self.first as usize;
        first..first + self.count as usize
    }

    #[inline(always)]
    pub(super) fn children(&self) -> Option<[usize; 2]> {
        (self.count == 0).then_some([self.first as usize, self.first as usize + 1])
    }

    #[inline(always)]
    pub(super) fn half_area(&self) -> f32 {
        half_area(&self.bounds)
    }
}

/// Half the surface area of a box that is not empty.
#[inline(always)]
pub(super) fn half_area(b: &Aabb) -> f32 {
    let d = b.max - b.min;
    d.x * d.y + d.y * d.z + d.z * d.x
}

/// Number of items of a subtree that is built without parallel tasks: a third of a millisecond,
/// hundreds of times the cost of a task. A million triangles make about 500 tasks; half or twice as
/// many would still balance tens of threads.
const GRAIN: usize = 1 << 11;

/// Depth from which items are divided evenly, which bounds the effort for items of very different
/// sizes. Scenes stay far below.
const BALANCED_DEPTH: usize = 64;

/// A tree over at least one item, for wide nodes with up to `max_leaf` items per leaf. Its leaves
/// hold up to half as many: runs of `items`, which are reordered. The root has index 0, index 1 is
/// unused: the indices of siblings differ in the last bit only.
///
/// Built top-down by binned divisions ([`split`]).
pub(super) fn binary_tree(items: &mut [ItemBox], max_leaf: usize) -> Vec<BinaryNode> {
    let growth = Growth {
        isa: Isa::best(),
        max_leaf,
    };
    let bounds = Bounds::of(items);
    assemble(growth.grow(items, 0, bounds, 0))
}

/// A subtree.
enum Grown {
    Divided(Bounds, Box<[Grown; 2]>),
    /// The nodes of a whole subtree, with indices as in [`binary_tree`].
    Nodes(Vec<BinaryNode>),
}

struct Growth {
    isa: Isa,
    max_leaf: usize,
}

impl Growth {
    /// The subtree over `items`, the first of which has index `first`.
    fn grow(&self, items: &mut [ItemBox], first: usize, bounds: Bounds, depth: usize) -> Grown {
        if items.len() <= GRAIN {
            let mut nodes = vec![self.leaf(items, first, bounds); 2];
            self.grow_below(&mut nodes, 0, (items, first), bounds, depth);
            return Grown::Nodes(nodes);
        }
        let split = self.split(items, depth);
        let middle = first + split.count;
        let (left, right) = items.split_at_mut(split.count);
        let [left_bounds, right_bounds] = split.bounds;
        let (left, right) = rayon::join(
            || self.grow(left, first, left_bounds, depth + 1),
            || self.grow(right, middle, right_bounds, depth + 1),
        );
        Grown::Divided(bounds, Box::new([left, right]))
    }

    fn split(&self, items: &mut [ItemBox], depth: usize) -> Split {
        if depth < BALANCED_DEPTH {
            split(self.isa, items, self.max_leaf)
        } else {
            split_evenly(items)
        }
    }

    fn leaf(&self, items: &[ItemBox], first: usize, bounds: Bounds) -> BinaryNode {
        let first = first as u32;
        BinaryNode::leaf(bounds.into(), first..first + items.len() as u32)
    }

    /// Sets the node `slot` and appends those below it.
    fn grow_below(
        &self,
        nodes: &mut Vec<BinaryNode>,
        slot: usize,
        (items, first): (&mut [ItemBox], usize),
        bounds: Bounds,
        depth: usize,
    ) {
        if items.len() <= self.max_leaf.div_ceil(2) {
            nodes[slot] = self.leaf(items, first, bounds);
            return;
        }
        let split = self.split(items, depth);
        let child = nodes.len();
        nodes[slot] = BinaryNode::parent(bounds.into(), child);
        nodes.extend([nodes[slot]; 2]);
        let middle = first + split.count;
        let (left, right) = items.split_at_mut(split.count);
        let [left_bounds, right_bounds] = split.bounds;
        self.grow_below(nodes, child, (left, first), left_bounds, depth + 1);
        self.grow_below(nodes, child + 1, (right, middle), right_bounds, depth + 1);
    }
}

/// Puts the nodes of all subtrees in one list: first the divided ones, level by level.
fn assemble(root: Grown) -> Vec<BinaryNode> {
    let root = match root {
        Grown::Nodes(nodes) => return nodes,
        divided => divided,
    };
    let mut top = vec![BinaryNode::leaf(Aabb::EMPTY, 0..0); 2];
    let mut parts = Vec::new();
    let mut queue = VecDeque::from([(0, root)]);
    while let Some((slot, grown)) = queue.pop_front() {
        match grown {
            Grown::Nodes(nodes) => parts.push((slot, nodes)),
            Grown::Divided(bounds, halves) => {
                let child = top.len();
                top[slot] = BinaryNode::parent(bounds.into(), child);
                top.extend([top[slot]; 2]);
                queue.extend((child..).zip(*halves));
            }
        }
    }
    let below: usize = parts.iter().map(|(_, part)| part.len() - 2).sum();
    let mut nodes: Vec<BinaryNode> = bytemuck::zeroed_vec(top.len() + below);
    let mut end = top.len();
    let (upper, mut rest) = nodes.split_at_mut(end);
    let mut copies = Vec::new();
    for (slot, part) in parts {
        let shift = end as u32 - 2;
        top[slot] = part[0].shifted(shift);
        end += part.len() - 2;
        let (place, next) = rest.split_at_mut(part.len() - 2);
        rest = next;
        copies.push((place, part, shift));
    }
    upper.copy_from_slice(&top);
    copies.into_par_iter().for_each(|(place, part, shift)| {
        for (node, copy) in place.iter_mut().zip(part.into_iter().skip(2)) {
            *node = copy.shifted(shift);
        }
    });
    nodes
}
