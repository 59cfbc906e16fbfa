//! Binary bounding volume hierarchies over boxes.

use super::reinsert::reinsert;
use crate::math::Aabb;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use rayon::prelude::*;

/// A node of a binary tree: a leaf with one item, or an inner node with two adjacent children.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinaryNode {
    pub(super) bounds: Aabb,
    /// Index of the first child, or item of a leaf.
    first: u32,
    is_leaf: bool,
}

impl BinaryNode {
    pub(super) fn leaf(bounds: Aabb, item: u32) -> Self {
        BinaryNode {
            bounds,
            first: item,
            is_leaf: true,
        }
    }

    pub(super) fn parent(bounds: Aabb, first_child: usize) -> Self {
        BinaryNode {
            bounds,
            first: first_child as u32,
            is_leaf: false,
        }
    }

    pub(super) fn item(&self) -> Option<u32> {
        self.is_leaf.then_some(self.first)
    }

    #[inline(always)]
    pub(super) fn children(&self) -> Option<[usize; 2]> {
        (!self.is_leaf).then_some([self.first as usize, self.first as usize + 1])
    }

    #[inline(always)]
    pub(super) fn half_area(&self) -> f32 {
        half_area(&self.bounds)
    }
}

/// Half the surface area of a box that is not empty.
#[inline(always)]
pub(super) fn half_area(b: &Aabb) -> f32 {
    let d = b.max - b.min;
    d.x * d.y + d.y * d.z + d.z * d.x
}

/// A tree with one item per leaf. The root has index 0, index 1 is unused: the indices of siblings differ in the last bit only.
///
/// Built bottom-up by Meister and Bittner, "Parallel Locally-Ordered Clustering for Bounding Volume Hierarchy Construction",
/// TVCG 24(3), 2018, then improved by [`reinsert`].
pub(super) fn binary_tree(boxes: &[Aabb]) -> Vec<BinaryNode> {
    let boxes: Vec<obvhs::aabb::Aabb> = boxes
        .par_iter()
        .map(|b| obvhs::aabb::Aabb::new(b.min.to_vec3a(), b.max.to_vec3a()))
        .collect();
    /// Iterations of the clustering with a search distance of 1 before the medium one. The value of obvhs for its medium builds.
    const SEARCH_DEPTH_THRESHOLD: usize = 3;
    let indices = (0..boxes.len() as u32).collect();
    let clustered = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::Medium,
        &boxes,
        indices,
        SortPrecision::U64,
        SEARCH_DEPTH_THRESHOLD,
    );
    let convert = |index: usize| {
        let node = &clustered.nodes[index];
        let bounds = Aabb {
            min: node.aabb().min.into(),
            max: node.aabb().max.into(),
        };
        let first = node.first_index as usize;
        if node.is_leaf() {
            BinaryNode::leaf(bounds, clustered.primitive_indices[first])
        } else {
            BinaryNode::parent(bounds, first + 1)
        }
    };
    let mut nodes: Vec<BinaryNode> = (0..=clustered.nodes.len())
        .into_par_iter()
        .map(|place| convert(place.saturating_sub(1)))
        .collect();
    reinsert(&mut nodes);
    nodes
}
