//! Collapse of a binary tree: which of its nodes become eight-wide nodes and which become leaves.
//!
//! Dynamic programming over the surface area heuristic: Ylitie et al., "Efficient Incoherent Ray
//! Traversal on GPUs Through Compressed Wide BVHs", HPG 2017, section 3.1. The cost of a leaf does
//! not depend on its number of items, since eight are tested together. Disjoint subtrees are solved
//! in parallel; their choice does not depend on the number of threads.

use super::binary::BinaryNode;
use crate::simd::NARROW;
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::atomic::{AtomicU32, Ordering};

/// Cost of testing a leaf, in units of the cost of testing a node. Larger values add nodes to save
/// leaf tests.
const LEAF_COST: f32 = 1.2;

/// Number of nodes of a tree that is solved without parallel tasks.
const SMALL: usize = 1 << 11;

/// For each binary node the cheapest representation by up to `i` wide subtrees, for `i` = 1 to 8.
/// The elements are words of [`Choices`]; atomic, because threads write to disjoint sets of nodes.
pub(super) struct CollapsePlan(Vec<AtomicU32>);

/// The choices at a binary node, packed in one word.
#[derive(Clone, Copy)]
pub(super) struct Choices(u32);

/// Costs of a subtree, for the choices of its parent.
#[derive(Clone, Copy)]
struct Priced {
    /// Element `i - 1`: least cost of up to `i` wide subtrees.
    cost: [f32; NARROW],
    /// Number of items in the subtree.
    items: u32,
    /// Number of binary leaves in the subtree, up to eight.
    leaves: usize,
}

impl Choices {
    /// Of `i` subtrees the left child gets `share[i - 1]`. Bit `i - 1` of `fewer` is set if `i - 1`
    /// subtrees cost no more than `i`; bit 0 is set if the node becomes a leaf.
    fn new(share: [u32; NARROW], fewer: u32) -> Self {
        // `share[0]` is not stored: one subtree is not divided.
        let shares = (1..NARROW).fold(0, |word, i| word | share[i] << (3 * i + 5));
        Choices(shares | fewer)
    }

    /// Whether the node becomes a leaf.
    pub(super) fn is_leaf(self) -> bool {
        self.0 & 1 != 0
    }

    /// Whether `slots - 1` subtrees cost no more than `slots`.
    fn takes_fewer(self, slots: usize) -> bool {
        self.0 >> (slots - 1) & 1 != 0
    }

    /// Number of subtrees of the left child, of `slots`.
    fn share(self, slots: usize) -> usize {
        (self.0 >> (3 * slots + 2) & 7) as usize
    }
}

/// Up to eight binary nodes.
#[derive(Default)]
pub(super) struct Children {
    nodes: [u32; NARROW],
    count: usize,
}

impl Children {
    pub(super) fn push(&mut self, node: usize) {
        self.nodes[self.count] = node as u32;
        self.count += 1;
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = usize> {
        self.nodes[..self.count].iter().map(|&node| node as usize)
    }

    pub(super) fn len(&self) -> usize {
        self.count
    }
}

impl CollapsePlan {
    /// The plan for a tree with at most `max_leaf` items per leaf.
    pub(super) fn new(binary: &[BinaryNode], max_leaf: usize) -> Self {
        let leaf = Choices::new([0; NARROW], u32::from(u8::MAX));
        let words = binary.iter().map(|_| AtomicU32::new(leaf.0));
        let plan = CollapsePlan(words.collect());
        if binary.len() < SMALL {
            plan.price(binary, 0, max_leaf, |_| None);
            return plan;
        }
        let below: HashMap<usize, Priced> = subtrees(binary)
            .into_par_iter()
            .map(|root| (root, plan.price(binary, root, max_leaf, |_| None)))
            .collect();
        plan.price(binary, 0, max_leaf, |index| below.get(&index).copied());
        plan
    }

    /// Makes the choices at all nodes below `root`, down to nodes with `known` costs.
    fn price(
        &self,
        binary: &[BinaryNode],
        root: usize,
        max_leaf: usize,
        known: impl Fn(usize) -> Option<Priced>,
    ) -> Priced {
        // Preorder: node, right subtree, left subtree. Reversed, both children come directly before
        // their parent.
        let (mut order, mut pending) = (Vec::new(), vec![root]);
        while let Some(index) = pending.pop() {
            order.push(index);
            let children = binary[index].children().into_iter().flatten();
            pending.extend(children.filter(|_| known(index).is_none()));
        }
        let mut priced: Vec<Priced> = Vec::new();
        for index in order.into_iter().rev() {
            let node = &binary[index];
            let price = if let Some(price) = known(index) {
                price
            } else if node.children().is_none() {
                Priced {
                    cost: [node.half_area() * LEAF_COST; NARROW],
                    items: node.items().len() as u32,
                    leaves: 1,
                }
            } else {
                let [.., left, right] = &priced[..] else {
                    unreachable!("invariant: children come before their parent")
                };
                let (price, choices) = choose(node, left, right, max_leaf);
                self.0[index].store(choices.0, Ordering::Relaxed);
                priced.truncate(priced.len() - 2);
                price
            };
            priced.push(price);
        }
        priced[0]
    }

    pub(super) fn at(&self, index: usize) -> Choices {
        Choices(self.0[index].load(Ordering::Relaxed))
    }

    /// The binary nodes that become the children of the wide node at the inner binary node `index`.
    pub(super) fn children(&self, binary: &[BinaryNode], index: usize) -> Children {
        let mut children = Children::default();
        self.add_children(binary, index, NARROW, &mut children);
        children
    }

    /// Adds the children below an inner node that represent it with up to `slots` subtrees.
    fn add_children(
        &self,
        binary: &[BinaryNode],
        index: usize,
        slots: usize,
        children: &mut Children,
    ) {
        for (node, mut slots) in self.halves(binary, index, slots) {
            while slots > 1 && self.at(node).takes_fewer(slots) {
                slots -= 1;
            }
            if slots == 1 {
                children.push(node);
            } else {
                self.add_children(binary, node, slots, children);
            }
        }
    }

    /// Both children of an inner node, with their numbers of subtrees.
    fn halves(&self, binary: &[BinaryNode], index: usize, slots: usize) -> [(usize, usize); 2] {
        let share = self.at(index).share(slots);
        let [left, right] = binary[index]
            .children()
            .expect("invariant: only inner nodes take several slots");
        [(left, share), (right, slots - share)]
    }
}

/// Costs and choices of an inner node from the costs of its children.
fn choose(node: &BinaryNode, left: &Priced, right: &Priced, max_leaf: usize) -> (Priced, Choices) {
    let (area, items) = (node.half_area(), left.items.saturating_add(right.items));
    let mut cost = [f32::INFINITY; NARROW];
    // With as many subtrees as leaves, or more, each side gets enough. The loops find the other
    // shares.
    let mut share = std::array::from_fn(|i| left.leaves.min(i) as u32);
    let mut fewer = 0;
    for k in 1..NARROW.min(left.leaves + 1) {
        for i in k..NARROW.min(k + right.leaves) {
            let c = left.cost[k - 1] + right.cost[i - k];
            if c < cost[i] {
                (cost[i], share[i]) = (c, k as u32);
            }
        }
    }
    // One subtree: a wide node over the best eight, or a leaf.
    cost[0] = area + cost.iter().copied().fold(f32::INFINITY, f32::min);
    if items as usize <= max_leaf && area * LEAF_COST <= cost[0] {
        cost[0] = area * LEAF_COST;
        fewer |= 1;
    }
    for i in 1..NARROW {
        if cost[i - 1] <= cost[i] {
            cost[i] = cost[i - 1];
            fewer |= 1 << i;
        }
    }
    let leaves = NARROW.min(left.leaves + right.leaves);
    let priced = Priced {
        cost,
        items,
        leaves,
    };
    (priced, Choices::new(share, fewer))
}

/// Roots of disjoint subtrees that together hold all leaves: the parallel tasks.
fn subtrees(binary: &[BinaryNode]) -> Vec<usize> {
    /// Number of tasks at which the division ends: many per thread, so that uneven ones balance.
    const ENOUGH: usize = 1024;
    /// Largest number of divided levels. Bounds the effort for trees that degenerate to lists.
    const LEVELS: usize = 16;
    let mut level = vec![0];
    for _ in 0..LEVELS {
        if level.len() >= ENOUGH {
            break;
        }
        let below = level.iter().flat_map(|&index| {
            let [left, right] = binary[index].children().unwrap_or([index; 2]);
            left..=right
        });
        level = below.collect();
    }
    level
}
