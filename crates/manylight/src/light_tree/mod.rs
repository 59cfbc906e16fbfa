//! The light tree: a binary tree over virtual lights, for lightcuts. Every node bounds the lights
//! below it, and one of these may be drawn to represent the node.
//!
//! Source: Walter et al., "Lightcuts: A Scalable Approach to Illumination", SIGGRAPH 2005; here
//! with lights of any radiant intensity, bounded by [`IntensityBound`].

mod bound;
mod build;
mod draw;
mod node;
#[cfg(test)]
mod tests;

pub(crate) use bound::ReflectedBounds;
pub use draw::DrawnLight;
pub(crate) use draw::Receiver;
pub use node::LightNode;

use crate::ids::LightId;
use crate::virtual_lights::{IntensityBound, VirtualLights};
use node::NodeContent;
use rayon::prelude::*;

/// A binary tree over the virtual lights that have flux, or one for each light group.
#[derive(Clone, Debug, Default)]
pub struct LightTree {
    /// Indices of the roots: one, or one for each light group.
    roots: Vec<usize>,
    /// In depth-first order: an inner node is followed by its first child with all descendants,
    /// then by its second child.
    nodes: Vec<LightNode>,
}

impl LightTree {
    /// The tree over the lights with flux for which `is_used` is true.
    pub fn new(set: &VirtualLights, is_used: impl Fn(LightId) -> bool) -> Self {
        let mut tree = LightTree::default();
        tree.add(set, is_used);
        tree
    }

    /// A tree for each of `groups` light groups, or one for all lights if there are none.
    pub fn of_groups(set: &VirtualLights, groups: usize) -> Self {
        let mut tree = LightTree::default();
        if groups == 0 {
            tree.add(set, |_| true);
        }
        for group in 0..groups {
            tree.add(set, |id| set.lights()[id.index()].group.index() == group);
        }
        tree
    }

    /// Adds a tree over the lights with flux for which `is_used` is true.
    fn add(&mut self, set: &VirtualLights, is_used: impl Fn(LightId) -> bool) {
        let root = self.nodes.len();
        let nodes = build::nodes(set, is_used).into_iter();
        self.nodes.extend(nodes.map(|node| node.moved(root as u32)));
        self.roots.extend((self.nodes.len() > root).then_some(root));
    }

    /// Indices of the roots; none without lights.
    pub fn roots(&self) -> &[usize] {
        &self.roots
    }

    /// All nodes; see [`LightTree::children`].
    pub fn nodes(&self) -> &[LightNode] {
        &self.nodes
    }

    /// Indices of the children of the given node; `None` for a leaf.
    #[inline]
    pub fn children(&self, node: usize) -> Option<[usize; 2]> {
        match self.nodes[node].content {
            NodeContent::Light(_) => None,
            NodeContent::Nodes { second } => Some([node + 1, second as usize]),
        }
    }

    /// Sets the bounds of leaves, for receivers that are clusters.
    pub fn bound_lights(&mut self, lights: &VirtualLights) {
        self.nodes.par_iter_mut().for_each(|node| {
            if let NodeContent::Light(id) = node.content {
                node.intensity = IntensityBound::of(lights, id);
            }
        });
    }

    /// Expected bytes per light, with this number of bounds per light that are not diffuse: at most
    /// one for inner nodes, and one more with [`LightTree::bound_lights`].
    pub fn bytes_per_light(glossy_bounds: f64) -> f64 {
        (2 * size_of::<LightNode>()) as f64 + glossy_bounds * IntensityBound::GLOSSY_BYTES as f64
    }
}
