//! Nodes with eight children.

use crate::math::{Aabb, Vec3};
use crate::simd::NARROW;

/// Flag of a child word. With it the other bits are the index of a leaf, without it that of a node. 0 means no child, as the root is
/// not a child.
pub(super) const LEAF: u32 = 1 << 31;

/// The boxes of up to eight children and references to them, in four cache lines.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct WideNode {
    /// Lower x, y, z and upper x, y, z of the children. Unused lanes have lower = +∞ and upper = -∞.
    pub(super) bounds: [[f32; NARROW]; 6],
    /// References to the children: see [`LEAF`].
    pub(super) children: [u32; NARROW],
    /// Low 24 bits of element `octant` (bit `a` set: component `a` of the direction is negative): the lanes of the children from far to near
    /// along directions of the octant, three bits each. High 8 bits of element `lane`: see [`WideNode::items_below`].
    pub(super) order: [u32; NARROW],
}

impl WideNode {
    /// Number of items below a child, rounded up to a power of two.
    #[inline(always)]
    pub(super) fn items_below(&self, lane: usize) -> f32 {
        (1u64 << (self.order[lane] >> 24)) as f32
    }

    #[inline(always)]
    pub(super) fn child_bounds(&self, lane: usize) -> Aabb {
        let b = &self.bounds;
        Aabb {
            min: Vec3::new(b[0][lane], b[1][lane], b[2][lane]),
            max: Vec3::new(b[3][lane], b[4][lane], b[5][lane]),
        }
    }
}

/// A node without children.
pub(super) fn empty_node() -> WideNode {
    let mut bounds = [[f32::INFINITY; NARROW]; 6];
    bounds[3..].fill([f32::NEG_INFINITY; NARROW]);
    WideNode {
        bounds,
        children: [0; NARROW],
        order: [0; NARROW],
    }
}

pub(super) fn set_child(node: &mut WideNode, lane: usize, bounds: Aabb) {
    for axis in 0..3 {
        node.bounds[axis][lane] = bounds.min[axis];
        node.bounds[axis + 3][lane] = bounds.max[axis];
    }
}

/// Sets the visiting orders of a node with `count` children: by the centers of their boxes along the diagonal of each octant.
pub(super) fn set_order(node: &mut WideNode, count: usize) {
    let center = |i: usize| {
        Vec3::from_array(std::array::from_fn(|a| {
            0.5 * node.bounds[a][i] + 0.5 * node.bounds[a + 3][i]
        }))
    };
    let centers: [Vec3; NARROW] = std::array::from_fn(center);
    node.order = std::array::from_fn(|octant| {
        let direction = Vec3::from_array(std::array::from_fn(|a| {
            if octant >> a & 1 == 0 { 1.0 } else { -1.0 }
        }));
        let distances = centers.map(|center| center.dot(direction));
        let mut lanes: [usize; NARROW] = std::array::from_fn(|i| i);
        lanes[..count].sort_by(|&i, &j| distances[j].total_cmp(&distances[i]));
        lanes
            .iter()
            .rev()
            .fold(0, |word, &lane| word << 3 | lane as u32)
    });
}
