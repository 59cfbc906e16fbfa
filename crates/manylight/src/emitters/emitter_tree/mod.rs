//! A tree over emitter elements, for the choice of one element among many for a receiver.
//!
//! Each node bounds the positions, normals and power of its elements. A traversal starts at the root and chooses among the
//! children in proportion to their importance, an estimate of the light that they send to the receiver.
//! Source: Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", 2018.
//! The tree is built with two children per node (`binary.rs`), then collapsed to sixteen (`wide.rs`), one per SIMD lane.
//!
//! Deviations from the source: the receiver's normal never makes an importance 0, because shading normals may face other
//! directions; and the emitters' normals do so only beyond the whole range of directions of emission. So every element that sends
//! light to a receiver has a positive probability.

mod binary;
mod wide;

use super::elements::ElementBounds;
use super::selection_weight::SelectionWeight;
use crate::lanes::LANES;
use crate::math::Vec3;
use crate::simd::Isa;
use binary::ClusterNode;
use wide::{ChildLane, ImportanceKernel, WideEmitterNode};

/// The tree. Elements are named by their index in the list from which it was built.
#[derive(Clone, Debug)]
pub(super) struct EmitterTree {
    /// The root first; empty without elements of positive power.
    nodes: Vec<WideEmitterNode>,
    /// The leaf of each element; `None` without power.
    leaf_of: Vec<Option<ChildLane>>,
    isa: Isa,
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

    /// Adds a wide node for the node `root` of the binary tree, and the wide nodes below. Returns its index.
    fn add(&mut self, nodes: &[ClusterNode], root: usize, parent: Option<ChildLane>) -> u32 {
        let mut children = vec![root];
        while children.len() < LANES {
            // Opens the child with the largest power times radius: its importance is the least accurate.
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

    /// An element for the receiver `p` with normal `n`, and the probability of the choice. `None` if no element emits towards `p`.
    pub(super) fn sample(&self, p: Vec3, n: Option<Vec3>, mut u: f32) -> Option<(usize, f32)> {
        let mut node = self.nodes.first()?;
        if node.count == 1 {
            return Some((node.content[0] as usize, 1.0));
        }
        let mut pmf = 1.0;
        loop {
            let importances = self.isa.run(ImportanceKernel { node, p, n });
            let (lane, probability, rest) = choose(&importances[..node.count], u)?;
            pmf *= probability;
            if node.is_leaf[lane] {
                return Some((node.content[lane] as usize, pmf));
            }
            u = rest;
            node = &self.nodes[node.content[lane] as usize];
        }
    }

    /// Probability of choosing `element` with [`EmitterTree::sample`].
    pub(super) fn pmf(&self, p: Vec3, n: Option<Vec3>, element: usize) -> f32 {
        let mut pmf = 1.0;
        let mut child = self.leaf_of[element];
        if child.is_none() {
            return 0.0;
        }
        while let Some(ChildLane { node: index, lane }) = child {
            let node = &self.nodes[index as usize];
            if node.count > 1 {
                let importances = self.isa.run(ImportanceKernel { node, p, n });
                let importance = importances[lane as usize];
                if importance <= 0.0 {
                    return 0.0;
                }
                pmf *= importance / importances[..node.count].iter().sum::<f32>();
            }
            child = node.parent;
        }
        pmf
    }
}

/// An index in proportion to its weight, its probability, and a number that is uniform in [0, 1) given the choice. `None` if all
/// weights are 0.
#[inline]
fn choose(weights: &[f32], u: f32) -> Option<(usize, f32, f32)> {
    const LARGEST: f32 = 1.0 - f32::EPSILON * 0.5;
    let mut ends = [0.0; LANES];
    let mut total = 0.0;
    for (end, weight) in ends.iter_mut().zip(weights) {
        total += weight;
        *end = total;
    }
    if total <= 0.0 {
        return None;
    }
    let target = u * total;
    // Rounding must not select an item of weight 0.
    let is_passed = |end: f32| end <= target && end < total;
    let chosen: usize = ends[..weights.len()]
        .iter()
        .map(|&end| usize::from(is_passed(end)))
        .sum();
    let weight = weights[chosen];
    let before = if chosen == 0 { 0.0 } else { ends[chosen - 1] };
    let rest = ((target - before) / weight).clamp(0.0, LARGEST);
    Some((chosen, weight / total, rest))
}
