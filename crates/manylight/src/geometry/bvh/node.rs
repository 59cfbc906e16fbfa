//! Nodes with eight children.

use super::binary::half_area;
use crate::math::{Aabb, Vec3, Vec4};
use crate::simd::NARROW;

/// Flag of a child word. With it the other bits are the index of a leaf, without it that of a node.
/// While a tree is built, 0 means no child, as the root is not a child.
pub(super) const LEAF: u32 = 1 << 31;

/// The boxes of up to eight children and references to them, in four cache lines.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct WideNode {
    /// Lower x, y, z and upper x, y, z of the children. Unused lanes have lower = +∞ and upper =
    /// -∞.
    pub(super) bounds: [[f32; NARROW]; 6],
    /// References to the children: see [`LEAF`].
    pub(super) children: [u32; NARROW],
    /// Low 24 bits of element `octant` (bit `a` set: component `a` of the direction is negative):
    /// the lanes of the children from far to near along directions of the octant, three bits each.
    /// High 8 bits of element `lane`: see [`WideNode::items_below`].
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

/// Sets the visiting orders of a node with `count` children: by the centers of their boxes along
/// the diagonal of each octant.
pub(super) fn set_order(node: &mut WideNode, count: usize) {
    // Vectors hold the octants 0 to 3. Along the opposite ones the order is reversed.
    let signs = [
        Vec4::new(1.0, -1.0, 1.0, -1.0),
        Vec4::new(1.0, 1.0, -1.0, -1.0),
        Vec4::ONE,
    ];
    let distances: [Vec4; NARROW] = std::array::from_fn(|lane| {
        let along = |axis: usize| {
            let b = &node.bounds;
            signs[axis] * (0.5 * b[axis][lane] + 0.5 * b[axis + 3][lane])
        };
        along(0) + along(1) + along(2)
    });
    // The place of a lane is the number of farther lanes. Its weight in the word is 8 to the power
    // of the place, which is exact, as are sums below 2^24.
    let base = Vec4::splat(NARROW as f32);
    let mut weights = [Vec4::ONE; NARROW];
    for j in 0..count {
        for i in 0..j {
            let is_farther = distances[i].cmpge(distances[j]);
            weights[j] *= Vec4::select(is_farther, base, Vec4::ONE);
            weights[i] *= Vec4::select(is_farther, Vec4::ONE, base);
        }
    }
    let (mut words, mut reversed) = (Vec4::ZERO, Vec4::ZERO);
    let last = (NARROW as f32).powi(count.max(1) as i32 - 1);
    for (lane, &weight) in weights[..count].iter().enumerate() {
        words += lane as f32 * weight;
        reversed += lane as f32 * (last / weight);
    }
    let unused = (count..NARROW).fold(0, |word, lane| word | (lane as u32) << (3 * lane));
    for octant in 0..NARROW / 2 {
        node.order[octant] = words[octant] as u32 | unused;
        node.order[NARROW - 1 - octant] = reversed[octant] as u32 | unused;
    }
}

/// Sorts the children such that an occluded ray that visits the last lanes first probably meets an
/// occluder early: by surface area of the box per effort, which is the number of items. Up to eight
/// items are tested together.
pub(super) fn sort_children(node: &mut WideNode) {
    let count = node.children.iter().take_while(|&&word| word != 0).count();
    let value: [f32; NARROW] = std::array::from_fn(|lane| {
        half_area(&node.child_bounds(lane)) / node.items_below(lane).max(NARROW as f32)
    });
    let mut lanes: [usize; NARROW] = std::array::from_fn(|lane| lane);
    lanes[..count].sort_by(|&i, &j| value[i].total_cmp(&value[j]));
    let old = node.clone();
    let mut place_of = [0; NARROW];
    for (place, &lane) in lanes.iter().enumerate() {
        place_of[lane] = place as u32;
        node.children[place] = old.children[lane];
        for (plane, old) in node.bounds.iter_mut().zip(&old.bounds) {
            plane[place] = old[lane];
        }
    }
    node.order = std::array::from_fn(|i| {
        let lanes_in_order = (0..NARROW).fold(0, |word, k| {
            let lane = old.order[i] >> (3 * k) & 7;
            word | place_of[lane as usize] << (3 * k)
        });
        lanes_in_order | old.order[lanes[i]] & 0xff00_0000
    });
}
