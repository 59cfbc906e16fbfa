//! Nodes of the light tree.

use crate::ids::LightId;
use crate::math::{Aabb, Cone};
use crate::virtual_lights::IntensityBound;

/// A leaf with one light, or an inner node with two children.
#[derive(Clone, Debug)]
pub struct LightNode {
    /// Bounding box of the positions and points of the lights.
    pub bounds: Aabb,
    /// Bounding cone of the geometric normals on the lit sides; full if a light emits on both
    /// sides.
    pub normals: Cone,
    /// Largest distance in m by which shadow rays to the points end before the surface.
    pub offset: f32,
    /// Luminance of the flux of the lights, in W.
    pub flux: f32,
    /// Bound of the radiant intensity of the lights of an inner node; set for a leaf by
    /// [`LightTree::bound_lights`](super::LightTree::bound_lights) only.
    pub(super) intensity: IntensityBound,
    pub(super) content: NodeContent,
}

impl LightNode {
    /// The node of a tree that begins at index `root`.
    pub(super) fn moved(mut self, root: u32) -> Self {
        if let NodeContent::Nodes { second } = &mut self.content {
            *second += root;
        }
        self
    }
}

#[derive(Clone, Copy, Debug)]
pub(super) enum NodeContent {
    Light(LightId),
    /// The first child is the next node.
    Nodes {
        second: u32,
    },
}
