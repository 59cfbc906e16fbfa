//! A tree over emitter elements, for the choice of one element among many for a receiver.
//!
//! Each node bounds the positions, normals and power of its elements. A traversal starts at the
//! root and chooses among the children in proportion to their importance, an estimate of the light
//! that they send to the receiver. Source: Conty Estevez and Kulla, "Importance Sampling of Many
//! Lights with Adaptive Tree Splitting", 2018. The tree is built with two children per node
//! (`binary.rs`), then collapsed to sixteen (`wide.rs`), one per SIMD lane.
//!
//! Deviations from the source: the receiver's normal never makes an importance 0, because shading
//! normals may face other directions; and the emitters' normals do so only beyond the whole range
//! of directions of emission. So every element that sends light to a receiver has a positive
//! probability.

mod binary;
mod importance;
mod wide;

use super::elements::ElementBounds;
use super::receivers::Receivers;
use crate::lanes::{Float, LANES, Lanes, Mask, Width, Word};
use crate::simd::{Isa, outlined, set_bits};
use binary::ClusterNode;
use importance::TreeReceivers;
use wide::{ChildLane, ChosenChild, ImportanceKernel, LEAF, WideEmitterNode, choose_by};

/// Children of a node per receiver in it, up to which the children are visited one by one, with the
/// receivers in lanes. Beyond, the receivers are visited one by one, with the children in lanes.
/// The importance of one child for all receivers costs about as much as that of all children for one
/// receiver, and the choice for one receiver as much again. With 1 and 4, path tracing takes 1.06
/// and 1.13 of the time in the Garage, 1.07 and 1.04 in the Disco.
const CHILDREN_PER_RECEIVER: usize = 2;

/// The tree. Elements are named by their index in the list from which it was built.
#[derive(Clone, Debug)]
pub(super) struct EmitterTree {
    /// The root first; empty without elements of positive power.
    nodes: Vec<WideEmitterNode>,
    /// The leaf of each element; `None` without power.
    leaf_of: Vec<Option<ChildLane>>,
    isa: Isa,
}

/// An element per lane.
pub(super) struct ChosenElements<S: Width> {
    /// Index of the element.
    pub(super) element: Word<S>,
    /// Probability of the choice.
    pub(super) pmf: Float<S>,
    /// The active lanes with an element that may emit towards the receiver.
    pub(super) found: Mask<S>,
}

impl EmitterTree {
    pub(super) fn new(elements: &[ElementBounds]) -> Self {
        let mut tree = EmitterTree {
            nodes: Vec::new(),
            leaf_of: vec![None; elements.len()],
            isa: Isa::best(),
        };
        let mut items: Vec<u32> = (0..elements.len() as u32)
            .filter(|&i| elements[i as usize].power.selection_weight() > 0.0)
            .collect();
        if !items.is_empty() {
            tree.add(&binary::build(elements, &mut items), 0, None);
        }
        tree
    }

    /// Adds a wide node for the node `root` of the binary tree, and the wide nodes below. Returns
    /// its index.
    fn add(&mut self, nodes: &[ClusterNode], root: usize, parent: Option<ChildLane>) -> u32 {
        let mut children = vec![root];
        while children.len() < LANES {
            // Opens the child with the largest power times radius: its importance is the least
            // accurate.
            let inaccuracy = |&i: &usize| nodes[children[i]].power * nodes[children[i]].radius;
            let inner = (0..children.len()).filter(|&i| !nodes[children[i]].is_leaf);
            let Some(opened) = inner.max_by(|a, b| inaccuracy(a).total_cmp(&inaccuracy(b))) else {
                break;
            };
            let first = nodes[children[opened]].content as usize;
            children[opened] = first;
            children.push(first + 1);
        }
        let index = self.nodes.len() as u32;
        self.nodes
            .push(WideEmitterNode::new(nodes, &children, parent));
        for (lane, &child) in children.iter().enumerate() {
            let at = ChildLane {
                node: index,
                lane: lane as u32,
            };
            if nodes[child].is_leaf {
                self.leaf_of[nodes[child].content as usize] = Some(at);
            } else {
                let below = self.add(nodes, child, Some(at));
                self.nodes[index as usize].content[lane] = below;
            }
        }
        index
    }

    pub(super) fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    outlined! {
        /// An element for each receiver, and the probability of the choice.
        pub(super) fn sample<S: Width>(
            tree: &EmitterTree, receivers: &Receivers<S>, u: Float<S>, active: Mask<S>,
        ) -> ChosenElements<S> { u.width() => tree.sample_inlined(receivers, u, active) }
    }

    #[inline(always)]
    fn sample_inlined<S: Width>(
        &self,
        receivers: &Receivers<S>,
        mut u: Float<S>,
        active: Mask<S>,
    ) -> ChosenElements<S> {
        let s = u.width();
        let mut at = Word::splat(s, 0);
        let mut chosen = ChosenElements {
            element: at,
            pmf: u.same(1.0),
            found: Mask::splat(s, false),
        };
        let Some(root) = self.nodes.first() else {
            return chosen;
        };
        if root.count == 1 {
            chosen.element = Word::splat(s, root.content[0] & !LEAF);
            chosen.found = active;
            return chosen;
        }
        let receivers = TreeReceivers::new(receivers);
        let mut left = active;
        while left.any() {
            let child = self.choose(&receivers, at, u, left);
            let found = left & child.probability.gt(0.0);
            let is_leaf = (child.content & LEAF).equals(LEAF);
            chosen.pmf = found.select(chosen.pmf * child.probability, chosen.pmf);
            chosen.found |= found & is_leaf;
            u = child.rest;
            at = left.select_words(child.content, at);
            left = found & !is_leaf;
        }
        chosen.element = at & !LEAF;
        chosen
    }

    /// A child of the node `at` for each receiver of `left`.
    #[inline(always)]
    fn choose<S: Width>(
        &self,
        receivers: &TreeReceivers<S>,
        at: Word<S>,
        u: Float<S>,
        left: Mask<S>,
    ) -> ChosenChild<S> {
        let mut all = ChosenChild {
            content: at,
            probability: u.same(0.0),
            rest: u,
        };
        let mut single = Singles::new(u.width());
        for (node, lanes) in at.groups(left) {
            let node = &self.nodes[node as usize];
            if visits_children(node, lanes) {
                all = ChosenChild::select(lanes, node.choose(receivers, u), all);
                continue;
            }
            let u = u.store();
            for lane in set_bits(lanes.bits()) {
                let importances = self.importances(node, receivers, lane);
                let choice = choose_by(&importances, u.as_ref()[lane]);
                let (child, probability, rest) = choice.unwrap_or((0, 0.0, 0.0));
                single.set(lane, node.content[child], probability, rest);
            }
        }
        ChosenChild::select(single.lanes(u.width()), single.load(u.width()), all)
    }

    /// Probability of choosing `element` with [`EmitterTree::sample`] for each receiver; 0 for
    /// receivers that are not active.
    #[inline(always)]
    pub(super) fn pmf<S: Width>(
        &self,
        receivers: &Receivers<S>,
        element: Word<S>,
        active: Mask<S>,
    ) -> Float<S> {
        let s = element.width();
        let (elements, bits) = (element.store(), active.bits());
        let leaves = s.each(|i| {
            let is_active = bits >> i & 1 != 0;
            is_active
                .then(|| self.leaf_of[elements.as_ref()[i] as usize])
                .flatten()
        });
        let leaf = |i: usize| leaves.as_ref()[i].unwrap_or(ChildLane { node: 0, lane: 0 });
        let mut node = Word::load(s, &s.each(|i| leaf(i).node));
        let mut child = Word::load(s, &s.each(|i| leaf(i).lane));
        let with_leaf = (0..S::LANES).filter(|&i| leaves.as_ref()[i].is_some());
        let mut left = Mask::from_bits(s, with_leaf.map(|i| 1 << i).sum());
        let mut pmf = left.select(1.0, 0.0);
        let receivers = TreeReceivers::new(receivers);
        while left.any() {
            let probability = self.probability(&receivers, node, child, left);
            pmf = left.select(pmf * probability, pmf);
            (node, child, left) = self.parents(node, left);
        }
        pmf
    }

    /// Probabilities of children of the nodes `at`, for each receiver of `left`.
    #[inline(always)]
    fn probability<S: Width>(
        &self,
        receivers: &TreeReceivers<S>,
        at: Word<S>,
        child: Word<S>,
        left: Mask<S>,
    ) -> Float<S> {
        let s = child.width();
        let mut all = Float::splat(s, 1.0);
        let mut single = Singles::new(s);
        for (node, lanes) in at.groups(left) {
            let node = &self.nodes[node as usize];
            if node.count == 1 {
                continue;
            }
            if visits_children(node, lanes) {
                all = lanes.select(node.probability(receivers, child), all);
                continue;
            }
            let child = child.store();
            for lane in set_bits(lanes.bits()) {
                let importances = self.importances(node, receivers, lane);
                let importance = importances[child.as_ref()[lane] as usize % LANES];
                let total: f32 = importances.iter().sum();
                let probability = if importance > 0.0 {
                    importance / total
                } else {
                    0.0
                };
                single.set(lane, 0, probability, 0.0);
            }
        }
        single.lanes(s).select(single.load(s).probability, all)
    }

    /// The nodes above, as which children the nodes are there, and the lanes with a node above.
    #[inline(always)]
    fn parents<S: Width>(&self, node: Word<S>, left: Mask<S>) -> (Word<S>, Word<S>, Mask<S>) {
        let s = node.width();
        let (mut above, mut child, mut with_parent) = (node, node, Mask::splat(s, false));
        for (node, lanes) in node.groups(left) {
            if let Some(parent) = self.nodes[node as usize].parent {
                above = lanes.select_words(Word::splat(s, parent.node), above);
                child = lanes.select_words(Word::splat(s, parent.lane), child);
                with_parent |= lanes;
            }
        }
        (above, child, with_parent)
    }

    /// The importance of each child of a node for the receiver in one lane.
    #[inline(always)]
    fn importances<S: Width>(
        &self,
        node: &WideEmitterNode,
        receivers: &TreeReceivers<S>,
        lane: usize,
    ) -> Lanes {
        let receiver = receivers.lane(lane);
        if S::LANES == 1 {
            return self.isa.run(ImportanceKernel { node, receiver });
        }
        let receivers = TreeReceivers::splat(receivers.min_cosine.width(), receiver);
        let children = node.children(receivers.min_cosine.width());
        let importances = children.importance(&receivers).store();
        let mut all = [0.0; LANES];
        all[..S::LANES].copy_from_slice(importances.as_ref());
        all
    }
}

/// Whether a node is visited child by child; see [`CHILDREN_PER_RECEIVER`].
#[inline(always)]
fn visits_children<S: Width>(node: &WideEmitterNode, receivers: Mask<S>) -> bool {
    node.count <= CHILDREN_PER_RECEIVER * receivers.bits().count_ones() as usize
}

/// Choices for single receivers.
struct Singles<S: Width> {
    content: S::Each<u32>,
    probability: S::Each<f32>,
    rest: S::Each<f32>,
    lanes: u32,
}

impl<S: Width> Singles<S> {
    #[inline(always)]
    fn new(s: S) -> Self {
        Singles {
            content: s.each(|_| 0),
            probability: s.each(|_| 0.0),
            rest: s.each(|_| 0.0),
            lanes: 0,
        }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, content: u32, probability: f32, rest: f32) {
        self.content.as_mut()[lane] = content;
        self.probability.as_mut()[lane] = probability;
        self.rest.as_mut()[lane] = rest;
        self.lanes |= 1 << lane;
    }

    #[inline(always)]
    fn lanes(&self, s: S) -> Mask<S> {
        Mask::from_bits(s, self.lanes)
    }

    #[inline(always)]
    fn load(&self, s: S) -> ChosenChild<S> {
        ChosenChild {
            content: Word::load(s, &self.content),
            probability: Float::load(s, &self.probability),
            rest: Float::load(s, &self.rest),
        }
    }
}
