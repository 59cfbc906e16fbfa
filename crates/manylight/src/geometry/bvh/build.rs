//! Construction of the tree of eight-wide nodes from boxes.
//!
//! Subtrees are written in parallel. The division into subtrees does not depend on the number of
//! threads.

use super::binary::{BinaryNode, binary_tree};
use super::collapse::{Children, CollapsePlan};
use super::item_box::{Bounds, ItemBox};
use super::node::{LEAF, WideNode, empty_node, set_child, set_order, sort_children};
use super::reinsert::reinsert;
use crate::math::Aabb;
use crate::simd::NARROW;
use rayon::prelude::*;

/// Largest number of levels of nodes. Determines the size of the traversal stacks.
pub(super) const MAX_DEPTH: usize = 36;

/// Depth from which subtrees are split evenly by number of items: the eleven levels below hold 2^33
/// items.
const BALANCED_DEPTH: usize = MAX_DEPTH - 11;

/// A tree of wide nodes over a list of items.
#[derive(Debug, Default)]
pub(super) struct WideTree {
    /// The root comes first. Empty without items.
    pub(super) nodes: Vec<WideNode>,
    /// The items in leaf order.
    pub(super) items: Vec<u32>,
    /// Leaf `i` holds `items[leaves[i]..leaves[i + 1]]`.
    pub(super) leaves: Vec<u32>,
    /// Bounding box of all items.
    pub(super) bounds: Option<Aabb>,
}

impl WideTree {
    /// Builds a tree with at most `max_leaf` items per leaf. All boxes must be finite and not
    /// empty. They are reordered.
    pub(super) fn new(mut boxes: Vec<ItemBox>, max_leaf: usize) -> Self {
        if boxes.is_empty() {
            return WideTree::default();
        }
        let mut binary = binary_tree(&mut boxes, max_leaf);
        reinsert(&mut binary);
        let emitter = TreeWriter {
            binary: &binary,
            plan: CollapsePlan::new(&binary, max_leaf),
            boxes: &boxes,
            max_leaf,
        };
        let mut tree = emitter.tree();
        tree.leaves.push(tree.items.len() as u32);
        tree.note_items_below();
        tree.nodes.par_iter_mut().for_each(sort_children);
        tree.nodes.par_iter_mut().for_each(end_unused_lanes);
        tree.bounds = Some(binary[0].bounds);
        tree
    }

    /// Begins a leaf, which holds the items appended next; returns its child word.
    fn begin_leaf(&mut self) -> u32 {
        self.leaves.push(self.items.len() as u32);
        LEAF | (self.leaves.len() - 1) as u32
    }

    /// Makes room for subtrees that are appended.
    fn reserve(&mut self, parts: &[WideTree]) {
        let sum = |count: fn(&WideTree) -> usize| parts.iter().map(count).sum();
        self.nodes.reserve(sum(|part| part.nodes.len()));
        self.leaves.reserve(sum(|part| part.leaves.len()) + 1);
        self.items.reserve(sum(|part| part.items.len()));
    }

    /// Appends a subtree; returns the new index of its root.
    fn append(&mut self, mut part: WideTree) -> u32 {
        let (nodes, leaves) = (self.nodes.len() as u32, self.leaves.len() as u32);
        let items = self.items.len() as u32;
        for word in part.nodes.iter_mut().flat_map(|node| &mut node.children) {
            *word += match *word {
                0 => 0,
                leaf if leaf & LEAF != 0 => leaves,
                _ => nodes,
            };
        }
        self.nodes.append(&mut part.nodes);
        self.leaves
            .extend(part.leaves.iter().map(|first| first + items));
        self.items.append(&mut part.items);
        nodes
    }

    /// Stores the number of items below each child, for [`WideNode::items_below`]. Children come
    /// after their parents, so that one pass from the end suffices.
    fn note_items_below(&mut self) {
        let mut counts = vec![0u32; self.nodes.len()];
        for index in (0..self.nodes.len()).rev() {
            for lane in 0..NARROW {
                let word = self.nodes[index].children[lane];
                let place = (word & !LEAF) as usize;
                let count = match word {
                    0 => continue,
                    _ if word & LEAF != 0 => self.leaves[place + 1] - self.leaves[place],
                    _ => counts[place],
                };
                self.nodes[index].order[lane] |= count.next_power_of_two().trailing_zeros() << 24;
                counts[index] = counts[index].saturating_add(count);
            }
        }
    }

    /// Memory of the nodes in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.nodes)
    }
}

/// Refers unused lanes to the first leaf. A ray with numbers that are not finite meets all boxes,
/// even empty ones: with the root in their lanes, it would never end.
fn end_unused_lanes(node: &mut WideNode) {
    for word in node.children.iter_mut().filter(|word| **word == 0) {
        *word = LEAF;
    }
}

/// Writes the wide nodes of a collapsed binary tree.
struct TreeWriter<'a> {
    binary: &'a [BinaryNode],
    plan: CollapsePlan,
    boxes: &'a [ItemBox],
    max_leaf: usize,
}

/// Depth of the wide nodes below which subtrees are written in parallel: up to 8³ tasks.
const CUT_DEPTH: usize = 3;

/// The reference in the upper part of the tree to a subtree that is written separately.
struct Cut {
    /// Index of the parent node.
    slot: usize,
    /// Lane of the child in it.
    lane: usize,
    /// Binary node of the subtree's root.
    root: usize,
}

impl TreeWriter<'_> {
    fn tree(&self) -> WideTree {
        let mut tree = WideTree::default();
        // The root is a node even over a single leaf, which saves traversal a special case.
        let children = if self.binary[0].children().is_none() {
            let mut root = Children::default();
            root.push(0);
            root
        } else {
            self.plan.children(self.binary, 0)
        };
        let mut cuts = Vec::new();
        tree.nodes.push(empty_node());
        self.fill_node(&mut tree, 0, &children, 1, &mut cuts);
        let parts: Vec<WideTree> = cuts.par_iter().map(|cut| self.part(cut)).collect();
        tree.reserve(&parts);
        for (cut, part) in cuts.iter().zip(parts) {
            let root = tree.append(part);
            tree.nodes[cut.slot].children[cut.lane] = root;
        }
        tree
    }

    fn part(&self, cut: &Cut) -> WideTree {
        let mut part = WideTree::default();
        let children = self.plan.children(self.binary, cut.root);
        part.nodes.push(empty_node());
        self.fill_node(&mut part, 0, &children, CUT_DEPTH + 1, &mut Vec::new());
        part
    }

    fn fill_node(
        &self,
        tree: &mut WideTree,
        slot: usize,
        children: &Children,
        depth: usize,
        cuts: &mut Vec<Cut>,
    ) {
        let mut node = empty_node();
        for (lane, child) in children.iter().enumerate() {
            set_child(&mut node, lane, self.binary[child].bounds);
        }
        set_order(&mut node, children.len());
        // Siblings are adjacent: allocate all of them before any is filled.
        for (lane, child) in children.iter().enumerate() {
            node.children[lane] = if self.plan.at(child).is_leaf() {
                self.add_leaf(tree, child)
            } else if depth == CUT_DEPTH {
                let root = child;
                cuts.push(Cut { slot, lane, root });
                0
            } else {
                tree.nodes.push(empty_node());
                (tree.nodes.len() - 1) as u32
            };
        }
        for (lane, child) in children.iter().enumerate() {
            let word = node.children[lane];
            if word == 0 || word & LEAF != 0 {
                continue;
            }
            if depth < BALANCED_DEPTH {
                let grandchildren = self.plan.children(self.binary, child);
                self.fill_node(tree, word as usize, &grandchildren, depth + 1, cuts);
            } else {
                let boxes = self.boxes_below(child);
                self.fill_balanced(tree, word as usize, &boxes);
            }
        }
        tree.nodes[slot] = node;
    }

    /// Splits items evenly by number, to bound the depth of pathological trees over coincident or
    /// nested items.
    fn fill_balanced(&self, tree: &mut WideTree, slot: usize, items: &[ItemBox]) {
        let mut node = empty_node();
        let chunk = items.len().div_ceil(NARROW).max(self.max_leaf);
        let mut count = 0;
        for (lane, part) in items.chunks(chunk).enumerate() {
            set_child(&mut node, lane, Bounds::of(part).into());
            count = lane + 1;
            node.children[lane] = if part.len() <= self.max_leaf {
                let word = tree.begin_leaf();
                tree.items.extend(part.iter().map(ItemBox::item));
                word
            } else {
                tree.nodes.push(empty_node());
                let child = tree.nodes.len() - 1;
                self.fill_balanced(tree, child, part);
                child as u32
            };
        }
        set_order(&mut node, count);
        tree.nodes[slot] = node;
    }

    fn add_leaf(&self, tree: &mut WideTree, index: usize) -> u32 {
        let word = tree.begin_leaf();
        self.add_items(index, &mut tree.items);
        word
    }

    /// Appends the items of a node that becomes a leaf.
    fn add_items(&self, index: usize, items: &mut Vec<u32>) {
        let node = &self.binary[index];
        match node.children() {
            // At most as deep as a leaf has items.
            Some(children) => {
                for child in children {
                    self.add_items(child, items);
                }
            }
            None => items.extend(self.boxes[node.items()].iter().map(ItemBox::item)),
        }
    }

    /// The boxes of the items below a node.
    fn boxes_below(&self, index: usize) -> Vec<ItemBox> {
        let (mut boxes, mut pending) = (Vec::new(), vec![index]);
        while let Some(index) = pending.pop() {
            let node = &self.binary[index];
            match node.children() {
                Some(children) => pending.extend(children),
                None => boxes.extend_from_slice(&self.boxes[node.items()]),
            }
        }
        boxes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    #[test]
    fn the_balanced_split_holds_every_item() {
        let place = |i: u32| Aabb::from_point(Vec3::splat(i as f32));
        let boxes: Vec<ItemBox> = (0..1000).map(|i| ItemBox::new(place(i), i)).collect();
        let binary = [BinaryNode::leaf(Bounds::of(&boxes).into(), 0..1000)];
        let writer = TreeWriter {
            binary: &binary,
            plan: CollapsePlan::new(&binary, 3),
            boxes: &boxes,
            max_leaf: 3,
        };
        let mut tree = WideTree::default();
        tree.nodes.push(empty_node());
        writer.fill_balanced(&mut tree, 0, &boxes);
        assert!(tree.items.iter().copied().eq(0..1000));
        tree.leaves.push(1000);
        assert!(tree.leaves.windows(2).all(|leaf| leaf[1] - leaf[0] <= 3));
        // Eight boxes per node, from the root with its 125 items per child.
        for (lane, first) in (0..1000).step_by(125).enumerate() {
            let expected = place(first).union(place(first + 124));
            assert_eq!(tree.nodes[0].child_bounds(lane), expected);
        }
    }
}
