//! Reinsertion: moves subtrees of a binary tree to positions where they add less surface area.
//!
//! Source: Meister and Bittner, "Parallel Reinsertion for Bounding Volume Hierarchy Optimization",
//! Computer Graphics Forum 37(2),
//! 2018. Searches run in parallel over an unchanged tree. The moves are then made one by one, the
//!       best first; a move is skipped if an earlier one has changed the nodes around it.

use super::binary::{BinaryNode, half_area};
use crate::math::Aabb;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU32, Ordering};

/// One round of parallel searches and moves.
struct SearchRound {
    /// Fraction of the nodes, the largest ones, for which a new position is searched.
    share: f32,
    /// Number of levels that the search goes up from the node.
    levels: usize,
}

/// Schedule of the rounds. Several rounds with few nodes and a full search repair the top of the
/// tree. After them a round with many nodes and a local search gains nearly as much as many rounds
/// with a full search.
///
/// The expected cost of rays falls by 13 % (staircase2), 12 % (living-room), 27 % (kitchen) and 17
/// % (garage), in a fifth of the time of a build. With first shares of 0.02 instead of 0.05 it is 3
/// % higher in garage, with a nearby share of 0.25 another 1 % lower; that takes as long as all
/// other rounds.
const ROUNDS: [&[SearchRound]; 2] = [
    &[
        SearchRound::thorough(0.05),
        SearchRound::thorough(0.05 / 3.0),
        SearchRound::thorough(0.05 / 5.0),
        SearchRound::thorough(0.05 / 7.0),
        SearchRound::thorough(0.05 / 9.0),
        SearchRound::thorough(0.05 / 11.0),
        SearchRound::thorough(0.05 / 13.0),
        SearchRound::thorough(0.05 / 15.0),
    ],
    &[SearchRound::nearby(0.1)],
];

impl SearchRound {
    const fn thorough(share: f32) -> Self {
        SearchRound {
            share,
            levels: usize::MAX,
        }
    }

    const fn nearby(share: f32) -> Self {
        SearchRound { share, levels: 10 }
    }
}

/// Reduces the total surface area of the inner nodes. The root has index 0, index 1 is unused: the
/// indices of siblings differ in the last bit only.
pub(super) fn reinsert(nodes: &mut [BinaryNode]) {
    /// Smallest number of nodes of a tree in which a node can move.
    const FEWEST: usize = 8;
    if nodes.len() < FEWEST {
        return;
    }
    let mut reinsertion = Reinsertion {
        parents: (0..nodes.len().div_ceil(2))
            .map(|_| AtomicU32::new(0))
            .collect(),
        touched: vec![false; nodes.len()],
        nodes,
    };
    let all = 0..reinsertion.nodes.len();
    let all = all.into_par_iter().with_min_len(CHUNK);
    // The node beside the root is unused.
    all.filter(|&index| index != 1)
        .for_each(|index| reinsertion.adopt(index));
    let all = largest(reinsertion.nodes, LARGEST_SHARE);
    for rounds in ROUNDS {
        let mut candidates = all.clone();
        for round in rounds {
            reinsertion.run(round, &mut candidates);
        }
    }
}

/// Largest share of any round.
const LARGEST_SHARE: f32 = 0.1;

/// Number of nodes of a task.
const CHUNK: usize = 1 << 12;

/// Number of searches of a task.
const GRAIN: usize = 64;

/// Indices of the largest nodes, ascending: at least `share` of all.
fn largest(nodes: &[BinaryNode], share: f32) -> Vec<u32> {
    /// Number of classes of nodes by area: eight per factor of two.
    const CLASSES: usize = 1 << 11;
    if nodes.len() < CHUNK {
        return (2..nodes.len() as u32).collect();
    }
    let class = |node: &BinaryNode| (node.half_area().to_bits() >> 20) as usize % CLASSES;
    let chunks = nodes.par_chunks(CHUNK);
    let count = |chunk: &[BinaryNode]| {
        let mut counts = vec![0u32; CLASSES];
        for node in chunk {
            counts[class(node)] += 1;
        }
        counts
    };
    let add = |mut a: Vec<u32>, b: Vec<u32>| {
        a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        a
    };
    let counts = chunks.map(count).reduce(|| vec![0; CLASSES], add);
    let mut missing = (nodes.len() as f32 * share) as u32;
    let mut least = CLASSES;
    while least > 0 && missing > 0 {
        least -= 1;
        missing = missing.saturating_sub(counts[least]);
    }
    let is_large = |&index: &u32| class(&nodes[index as usize]) >= least;
    (2..nodes.len() as u32)
        .into_par_iter()
        .with_min_len(CHUNK)
        .filter(is_large)
        .collect()
}

/// Removes all candidates but the `count` largest. Their indices stay in ascending order: neighbors
/// in the list share memory during the search.
fn keep_largest(nodes: &[BinaryNode], candidates: &mut Vec<u32>, count: usize) {
    if count >= candidates.len() {
        return;
    }
    let area = |&index: &u32| nodes[index as usize].half_area();
    let mut areas: Vec<(f32, u32)> = candidates.iter().map(|c| (area(c), *c)).collect();
    areas.select_nth_unstable_by(count, |a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    areas.truncate(count);
    candidates.clear();
    candidates.extend(areas.into_iter().map(|(_, index)| index));
    candidates.sort_unstable();
}

/// A reinsertion: `node` becomes the sibling of `beside`.
#[derive(Clone, Copy)]
struct Move {
    node: usize,
    beside: usize,
    /// Saved area.
    gain: f32,
}

/// The search for the best new position of a node.
struct ReinsertionSearch {
    /// Box of the node.
    moved: Aabb,
    /// Half the area of that box, a lower bound for the area of the new parent.
    least: f32,
    best: Move,
}

/// Children to be searched, and the area saved if their parent grows to hold the node.
struct Below {
    budget: f32,
    children: [usize; 2],
}

impl ReinsertionSearch {
    /// Evaluates a position; returns its children if they may be better.
    #[inline(always)]
    fn consider(&mut self, nodes: &[BinaryNode], index: usize, budget: f32) -> Option<Below> {
        let other = &nodes[index];
        let gain = budget - half_area(&other.bounds.union(self.moved));
        if gain > self.best.gain {
            (self.best.beside, self.best.gain) = (index, gain);
        }
        let budget = gain + other.half_area();
        let children = other.children().filter(|_| self.can_gain(budget))?;
        Some(Below { budget, children })
    }

    #[inline(always)]
    fn can_gain(&self, budget: f32) -> bool {
        budget - self.least > self.best.gain
    }
}

struct Reinsertion<'a> {
    nodes: &'a mut [BinaryNode],
    /// By pair of siblings; atomic, because threads write to disjoint pairs.
    parents: Vec<AtomicU32>,
    /// Nodes that a move of this round has changed.
    touched: Vec<bool>,
}

impl Reinsertion<'_> {
    fn run(&mut self, round: &SearchRound, candidates: &mut Vec<u32>) {
        let count = (self.nodes.len() as f32 * round.share) as usize;
        if count == 0 {
            return;
        }
        keep_largest(self.nodes, candidates, count);
        let mut moves: Vec<Move> = candidates
            .par_iter()
            .with_min_len(GRAIN)
            .map_init(Vec::new, |pending, &node| {
                self.best_move(node as usize, round.levels, pending)
            })
            .flatten_iter()
            .collect();
        let order = |a: &Move, b: &Move| b.gain.total_cmp(&a.gain).then(a.node.cmp(&b.node));
        moves.par_sort_unstable_by(order);
        self.touched.fill(false);
        for Move { node, beside, .. } in moves {
            let around = [
                node,
                node ^ 1,
                self.parent(node),
                beside,
                self.parent(beside),
            ];
            if around.iter().any(|&index| self.touched[index]) || self.is_below(beside, node) {
                continue;
            }
            for index in around {
                self.touched[index] = true;
            }
            self.relocate(node, beside);
        }
    }

    /// The move of a node that saves most area; `None` if no move saves area.
    ///
    /// Removal deletes the parent and shrinks the other ancestors. Insertion adds a parent of the
    /// node and its new sibling, and enlarges the ancestors of the sibling up to the common
    /// ancestor. The search goes up from the node. It keeps the area `saved` below the common
    /// ancestor, and searches the other side of each ancestor for the cheapest position. A new
    /// parent is at least as large as the node, which bounds the gain in a subtree.
    fn best_move(&self, node: usize, levels: usize, pending: &mut Vec<Below>) -> Option<Move> {
        let mut search = ReinsertionSearch {
            moved: self.nodes[node].bounds,
            least: self.nodes[node].half_area(),
            best: Move {
                node,
                beside: 0,
                gain: 0.0,
            },
        };
        let (mut from, mut ancestor) = (node, self.parent(node));
        let mut saved = self.nodes[ancestor].half_area();
        // Box of the ancestor without the node.
        let mut rest = self.nodes[node ^ 1].bounds;
        for _ in 0..levels {
            pending.extend(search.consider(self.nodes, from ^ 1, saved));
            while let Some(Below { budget, children }) = pending.pop() {
                if !search.can_gain(budget) {
                    continue;
                }
                let [left, right] = children.map(|c| search.consider(self.nodes, c, budget));
                let budget = |below: &Option<Below>| below.as_ref().map(|b| b.budget);
                let worse_first = if budget(&left) < budget(&right) {
                    [left, right]
                } else {
                    [right, left]
                };
                pending.extend(worse_first.into_iter().flatten());
            }
            if ancestor == 0 {
                break;
            }
            if from != node {
                rest = rest.union(self.nodes[from ^ 1].bounds);
                saved += self.nodes[ancestor].half_area() - half_area(&rest);
            }
            (from, ancestor) = (ancestor, self.parent(ancestor));
        }
        (search.best.beside != 0).then_some(search.best)
    }

    /// Moves `node`; `beside` must not be in its subtree.
    fn relocate(&mut self, node: usize, beside: usize) {
        let (sibling, parent) = (node ^ 1, self.parent(node));
        let old_neighbor = self.nodes[beside];
        // The sibling replaces the parent; `beside` replaces the sibling.
        self.nodes[parent] = self.nodes[sibling];
        self.nodes[sibling] = old_neighbor;
        self.nodes[beside] = BinaryNode::parent(old_neighbor.bounds, node & !1);
        for index in [parent, sibling, beside] {
            self.adopt(index);
        }
        self.refit(beside);
        self.refit(self.parent(parent));
    }

    fn parent(&self, index: usize) -> usize {
        self.parents[index / 2].load(Ordering::Relaxed) as usize
    }

    /// Updates the parent of the children of a node.
    fn adopt(&self, index: usize) {
        if let Some([child, _]) = self.nodes[index].children() {
            self.parents[child / 2].store(index as u32, Ordering::Relaxed);
        }
    }

    fn is_below(&self, mut index: usize, ancestor: usize) -> bool {
        while index != 0 && index != ancestor {
            index = self.parent(index);
        }
        index == ancestor
    }

    /// Recomputes boxes from a node upwards, until one does not change.
    fn refit(&mut self, mut index: usize) {
        while let Some([left, right]) = self.nodes[index].children() {
            let bounds = self.nodes[left].bounds.union(self.nodes[right].bounds);
            if bounds == self.nodes[index].bounds {
                return;
            }
            self.nodes[index].bounds = bounds;
            if index == 0 {
                return;
            }
            index = self.parent(index);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::sampling::{Sampler, Stream};

    /// A tree of pairs of a leaf and the rest, over boxes in random order: the worst tree.
    fn list(count: usize) -> Vec<BinaryNode> {
        let mut numbers = Sampler::new(1, 0, Stream::Test, 0);
        let boxes: Vec<Aabb> = (0..count)
            .map(|_| {
                let [x, y, z] = std::array::from_fn(|_| numbers.next_1d());
                let min = Vec3::new(x, y, z);
                Aabb {
                    min,
                    max: min + 0.01,
                }
            })
            .collect();
        let rest = |from: usize| {
            boxes[from..]
                .iter()
                .fold(Aabb::EMPTY, |all, b| all.union(*b))
        };
        let mut nodes = vec![BinaryNode::parent(rest(0), 2); 2];
        let leaf = |i: usize| BinaryNode::leaf(boxes[i], i as u32..i as u32 + 1);
        for i in 0..count - 1 {
            nodes.push(leaf(i));
            nodes.push(if i + 2 < count {
                BinaryNode::parent(rest(i + 1), 2 * i + 4)
            } else {
                leaf(i + 1)
            });
        }
        nodes
    }

    /// Checks the boxes; returns all items and the total half area of the inner nodes.
    fn inspect(nodes: &[BinaryNode]) -> (Vec<u32>, f32) {
        let (mut items, mut area) = (Vec::new(), 0.0);
        let mut pending = vec![0];
        while let Some(index) = pending.pop() {
            let node = &nodes[index];
            items.extend(node.items().map(|item| item as u32));
            if let Some([left, right]) = node.children() {
                area += node.half_area();
                assert_eq!(node.bounds, nodes[left].bounds.union(nodes[right].bounds));
                pending.extend([left, right]);
            }
        }
        items.sort_unstable();
        (items, area)
    }

    #[test]
    fn a_bad_tree_becomes_better_and_keeps_its_items() {
        let mut nodes = list(2000);
        let (items, before) = inspect(&nodes);
        for _ in 0..10 {
            reinsert(&mut nodes);
        }
        let (items_after, after) = inspect(&nodes);
        assert_eq!(items, (0..2000).collect::<Vec<u32>>());
        assert_eq!(items_after, items);
        assert!(after < 0.9 * before, "{before} to {after}");
    }
}
