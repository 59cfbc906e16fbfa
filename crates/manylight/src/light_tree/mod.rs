//! A binary tree over virtual lights. Every node bounds what is below it, and any of its lights may be drawn to stand for all.
//!
//! Source: Walter et al., "Lightcuts: A Scalable Approach to Illumination", SIGGRAPH 2005; here the lights of a cluster shine as they like, within
//! [`IntensityBound`].

mod bound;
mod build;
mod draw;
#[cfg(test)]
mod tests;

pub use draw::Drawn;

use crate::ids::LightId;
use crate::math::Aabb;
use crate::virtual_lights::IntensityBound;

/// See the module. Empty where no light has flux.
#[derive(Clone, Debug, Default)]
pub struct LightTree {
    /// The root first. The first child of an inner node comes next, then all that is below that, then the second child.
    nodes: Vec<Node>,
}

/// One light, or the lights below two nodes.
#[derive(Clone, Debug)]
pub struct Node {
    /// Holds every point of its lights.
    pub bounds: Aabb,
    /// Luminance of the flux of its lights, in W.
    pub flux: f32,
    /// What its lights shine; nothing for a leaf, which needs no bound.
    intensity: IntensityBound,
    content: Content,
}

#[derive(Clone, Copy, Debug)]
enum Content {
    Light(LightId),
    /// The first child comes next.
    Nodes {
        second: u32,
    },
}

impl LightTree {
    /// The root, if there is a light.
    pub fn root(&self) -> Option<&Node> {
        self.nodes.first()
    }

    /// All nodes; see [`LightTree::children`].
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The indices of the children of the node with the given index, unless that is a leaf.
    #[inline]
    pub fn children(&self, node: usize) -> Option<[usize; 2]> {
        match self.nodes[node].content {
            Content::Light(_) => None,
            Content::Nodes { second } => Some([node + 1, second as usize]),
        }
    }

    /// Bytes for each light, where a share `glossy` of the inner nodes bounds what is not diffuse.
    pub fn bytes_per_light(glossy: f64) -> f64 {
        (2 * size_of::<Node>()) as f64 + glossy * IntensityBound::GLOSSY_BYTES as f64
    }
}
