//! Moves subtrees of a binary tree to where they add less surface area.
//!
//! Source: Meister and Bittner, "Parallel Reinsertion for Bounding Volume Hierarchy Optimization", Computer Graphics Forum 37(2),
//! 2018. Searches run in parallel over an unchanged tree. Moves are then made one by one, the best first, and those are
//! left out whose surroundings have changed since the search.

use super::binary::{BinaryNode, half_area};
use crate::math::Aabb;
use rayon::prelude::*;

/// Which nodes move in one go.
struct Round {
    /// The largest nodes, as a share of all.
    share: f32,
    /// How far up the search for a new place goes.
    levels: usize,
}

/// What is wrong at the top is found in several rounds over few nodes. After that, one round over many nodes with a search
/// nearby is worth nearly as much as many rounds with a full one.
const ROUNDS: [Round; 10] = [
    Round::thorough(0.02),
    Round::thorough(0.02 / 3.0),
    Round::thorough(0.02 / 5.0),
    Round::thorough(0.02 / 7.0),
    Round::thorough(0.02 / 9.0),
    Round::thorough(0.02 / 11.0),
    Round::thorough(0.02 / 13.0),
    Round::thorough(0.02 / 15.0),
    Round::nearby(0.1),
    Round::nearby(0.03),
];

impl Round {
    const fn thorough(share: f32) -> Self {
        Round {
            share,
            levels: usize::MAX,
        }
    }

    const fn nearby(share: f32) -> Self {
        Round { share, levels: 10 }
    }
}

/// Makes the tree better. The root has place 0, siblings differ in the last bit of their places only. Large nodes must stand
/// before small ones by and large.
pub(super) fn reinsert(nodes: &mut [BinaryNode]) {
    /// Below this there is nothing that could move.
    const FEWEST: usize = 8;
    if nodes.len() < FEWEST {
        return;
    }
    let mut reinsertion = Reinsertion {
        parents: vec![0; nodes.len()],
        touched: vec![false; nodes.len()],
        nodes,
    };
    // From the end, so that the root comes after whatever fills place 1.
    for place in (0..reinsertion.nodes.len()).rev() {
        reinsertion.adopt(place);
    }
    for round in &ROUNDS {
        reinsertion.run(round);
    }
}

/// The node becomes the sibling of the one in the other place.
#[derive(Clone, Copy)]
struct Move {
    node: usize,
    beside: usize,
    /// Area that it saves.
    gain: f32,
}

/// The search for a new place.
struct ReinsertionSearch {
    moved: Aabb,
    /// Its area.
    least: f32,
    best: Move,
}

/// Children to be considered, and the area saved if their parent grows.
struct Below {
    budget: f32,
    children: [usize; 2],
}

impl ReinsertionSearch {
    /// Tries a place; what is below it, if that is promising.
    #[inline(always)]
    fn consider(&mut self, nodes: &[BinaryNode], place: usize, budget: f32) -> Option<Below> {
        let other = &nodes[place];
        let gain = budget - half_area(&other.bounds.union(self.moved));
        if gain > self.best.gain {
            (self.best.beside, self.best.gain) = (place, gain);
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
    parents: Vec<u32>,
    /// Places that a move of this round has changed.
    touched: Vec<bool>,
}

impl Reinsertion<'_> {
    fn run(&mut self, round: &Round) {
        let mut moves: Vec<Move> = self
            .largest(round.share)
            .par_iter()
            .filter_map(|&node| self.best_move(node as usize, round.levels))
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
            if around.iter().any(|&place| self.touched[place]) || self.is_below(beside, node) {
                continue;
            }
            for place in around {
                self.touched[place] = true;
            }
            self.relocate(node, beside);
        }
    }

    /// The largest nodes in the order of their places: neighbors have their surroundings in common.
    fn largest(&self, share: f32) -> Vec<u32> {
        // Looking among twice as many saves the sorting of all, and finds nearly the same.
        let count = ((self.nodes.len() as f32 * share) as usize).max(1);
        let end = (2 + 2 * count).min(self.nodes.len());
        let mut nodes: Vec<(f32, u32)> = (2..end)
            .map(|place| (self.nodes[place].half_area(), place as u32))
            .collect();
        if count < nodes.len() {
            nodes.select_nth_unstable_by(count, |a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
            nodes.truncate(count);
        }
        let mut places: Vec<u32> = nodes.into_iter().map(|(_, place)| place).collect();
        places.sort_unstable();
        places
    }

    /// The move of a node that saves most area, if any saves some.
    ///
    /// Without the node its parent vanishes and its other ancestors shrink. Where it comes back there is a new parent around it
    /// and its new sibling, and the ancestors of that grow, up to the first that they have in common. So the search goes up from
    /// the node, keeping the area `saved` below the common ancestor, and looks on the other side of each ancestor for
    /// the cheapest place. There, no new parent is smaller than the node, which bounds what a subtree can offer.
    fn best_move(&self, node: usize, levels: usize) -> Option<Move> {
        let mut search = ReinsertionSearch {
            moved: self.nodes[node].bounds,
            least: self.nodes[node].half_area(),
            best: Move {
                node,
                beside: 0,
                gain: 0.0,
            },
        };
        let mut pending: Vec<Below> = Vec::new();
        let (mut from, mut ancestor) = (node, self.parent(node));
        let mut saved = self.nodes[ancestor].half_area();
        // What the ancestor holds without the node.
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

    /// Moves a node; `beside` must not be below it.
    fn relocate(&mut self, node: usize, beside: usize) {
        let (sibling, parent) = (node ^ 1, self.parent(node));
        let old_neighbor = self.nodes[beside];
        // The sibling takes the parent's place, and leaves its own to the new one.
        self.nodes[parent] = self.nodes[sibling];
        self.nodes[sibling] = old_neighbor;
        self.nodes[beside] = BinaryNode::parent(old_neighbor.bounds, node & !1);
        for place in [parent, sibling, beside] {
            self.adopt(place);
        }
        self.refit(beside);
        self.refit(self.parent(parent));
    }

    fn parent(&self, place: usize) -> usize {
        self.parents[place] as usize
    }

    /// Tells the children in a place who their parent is.
    fn adopt(&mut self, place: usize) {
        for child in self.nodes[place].children().into_iter().flatten() {
            self.parents[child] = place as u32;
        }
    }

    fn is_below(&self, mut place: usize, ancestor: usize) -> bool {
        while place != 0 && place != ancestor {
            place = self.parent(place);
        }
        place == ancestor
    }

    /// Makes boxes fit from a place upwards, until one does already.
    fn refit(&mut self, mut place: usize) {
        while let Some([left, right]) = self.nodes[place].children() {
            let bounds = self.nodes[left].bounds.union(self.nodes[right].bounds);
            if bounds == self.nodes[place].bounds {
                return;
            }
            self.nodes[place].bounds = bounds;
            if place == 0 {
                return;
            }
            place = self.parent(place);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::sampling::{Sampler, Stream};

    /// Pairs of a leaf and the rest: the worst tree over boxes in random order.
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
        for (i, b) in boxes.iter().enumerate().take(count - 1) {
            nodes.push(BinaryNode::leaf(*b, i as u32));
            nodes.push(if i + 2 < count {
                BinaryNode::parent(rest(i + 1), 2 * i + 4)
            } else {
                BinaryNode::leaf(boxes[i + 1], i as u32 + 1)
            });
        }
        nodes
    }

    /// Checks the boxes, collects the items, adds up the area of all inner nodes.
    fn inspect(nodes: &[BinaryNode]) -> (Vec<u32>, f32) {
        let (mut items, mut area) = (Vec::new(), 0.0);
        let mut pending = vec![0];
        while let Some(place) = pending.pop() {
            let node = &nodes[place];
            items.extend(node.item());
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
