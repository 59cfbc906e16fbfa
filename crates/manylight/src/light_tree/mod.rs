//! Binary trees over virtual lights: one over those that reflect, one over those on emitters, one over those beyond the scene. Every node bounds what is below it, and any of its lights may be drawn to stand for all.
//!
//! Source: Walter et al., "Lightcuts: A Scalable Approach to Illumination", SIGGRAPH 2005; here the lights of a cluster shine as they like, within
//! [`IntensityBound`].

mod bound;
mod build;
mod draw;
#[cfg(test)]
mod tests;

pub(crate) use bound::Sent;
pub use draw::Drawn;

use crate::ids::LightId;
use crate::math::{Aabb, Cone};
use crate::virtual_lights::IntensityBound;

/// See the module. Lights without flux are left out.
#[derive(Clone, Debug, Default)]
pub struct LightTree {
    /// From the root on: the first child of an inner node comes next, then all that is below that, then the second child.
    nodes: Vec<Node>,
}

/// One light, or the lights below two nodes.
#[derive(Clone, Debug)]
pub struct Node {
    /// Holds every point of its lights.
    pub bounds: Aabb,
    /// Holds the geometric normals of all its lights, on the side of which alone they shine; full if some shine on both sides.
    pub normals: Cone,
    /// Shadow rays end at most so far from these points, in m.
    pub offset: f32,
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
    /// Index of the root; `None` without lights.
    pub fn root(&self) -> Option<usize> {
        (!self.nodes.is_empty()).then_some(0)
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

    /// Every bound becomes that of all directions together.
    #[cfg(any(test, feature = "testing"))]
    pub fn forget_directions(&mut self) {
        for node in &mut self.nodes {
            node.intensity.forget_directions();
        }
    }

    /// Bytes for each light, where a share `glossy` of the inner nodes bounds what is not diffuse.
    pub fn bytes_per_light(glossy: f64) -> f64 {
        (2 * size_of::<Node>()) as f64 + glossy * IntensityBound::GLOSSY_BYTES as f64
    }
}
