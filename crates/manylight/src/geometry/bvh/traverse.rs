//! Traversal with single rays: nearest hit, front to back, and any hit with early termination.

use super::node::{LEAF, WideNode};
use super::stack::{Stack, WordStack, highest};
use crate::lanes::{Float, Vector, Width};
use crate::math::Vec3;
use crate::math::prefetch::prefetch_at;
use crate::simd::{NARROW, Simd};

/// The leaves of a tree in memory, for prefetching.
pub(super) trait Leaves {
    /// Element that a visit of a leaf reads first.
    type Leaf;
    /// All elements, one per leaf.
    fn all(&self) -> &[Self::Leaf];
}

/// Prefetches the node or leaf that is visited after the current leaf.
#[inline(always)]
fn prefetch_next(nodes: &[WideNode], leaves: &impl Leaves, next: Option<u32>) {
    if let Some(word) = next {
        let leaf = (leaves.all().as_ptr()).wrapping_add((word & !LEAF) as usize);
        let node = nodes.as_ptr().wrapping_add(word as usize).cast();
        // Without a branch: it would be mispredicted often.
        prefetch_at(
            if word & LEAF == 0 { node } else { leaf.cast() },
            size_of::<WideNode>(),
        );
    }
}

/// Leaves that are tested for the nearest hit.
pub(super) trait NearestLeaves<S: Simd>: Leaves {
    /// Records hits in the leaf. `reach` is the bound of the parameters at which the ray enters
    /// boxes; returns the new one.
    fn visit(&mut self, s: S, leaf: usize, reach: f32) -> f32;
}

/// Leaves that are tested for any hit.
pub(super) trait AnyLeaves<S: Simd>: Leaves {
    /// Whether the ray hits something in the leaf.
    fn visit(&self, s: S, leaf: usize) -> bool;
}

/// Factor on the exit parameter that outweighs the rounding of a slab test.
/// Source: Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013.
pub(super) const FAR_MARGIN: f32 = 1.0 + 8.0 * f32::EPSILON;

/// Margin for the rounding of `o / d` in a slab test, relative to it. At most half of it is needed.
pub(super) const ORIGIN_MARGIN: f32 = 4.0 * f32::EPSILON;

/// Smallest magnitude of a direction's component in slab tests, relative to the largest component.
/// Far below rounding.
pub(super) const NEGLIGIBLE: f32 = 1e-12;

/// Reciprocal of a direction for slab tests. Components below [`NEGLIGIBLE`] are raised to it, so
/// that the result is finite.
#[inline(always)]
pub(super) fn slab_reciprocal(d: Vec3) -> Vec3 {
    let tiny = (d.abs().max_element() * NEGLIGIBLE).max(f32::MIN_POSITIVE);
    let reciprocal = |x: f32| 1.0 / if x.abs() < tiny { tiny.copysign(x) } else { x };
    Vec3::new(reciprocal(d.x), reciprocal(d.y), reciprocal(d.z))
}

/// [`slab_reciprocal`] in lanes.
#[inline(always)]
pub(super) fn slab_reciprocals<S: Width>(d: Vector<S>) -> Vector<S> {
    let size = d.abs();
    let tiny = (size.max_component() * NEGLIGIBLE).max(f32::MIN_POSITIVE);
    Vector::new(
        1.0 / size.x.max(tiny).mul_sign(d.x),
        1.0 / size.y.max(tiny).mul_sign(d.y),
        1.0 / size.z.max(tiny).mul_sign(d.z),
    )
}

/// The octant of a direction: bit `a` is set if component `a` is negative.
#[inline(always)]
pub(super) fn octant(d: Vec3) -> usize {
    let negative = |x: f32| usize::from(x.is_sign_negative());
    negative(d.x) | negative(d.y) << 1 | negative(d.z) << 2
}

/// A ray prepared for slab tests `t = b / d - o / d`, one fused operation per plane. The rounding
/// of `o / d` has the effect of a moved origin, by one unit in the last place; near and far planes
/// are moved apart by more.
pub(super) struct BoxRay {
    pub(super) near_scale: [f32; 3],
    pub(super) near_shift: [f32; 3],
    /// With the factor [`FAR_MARGIN`], like the shift.
    pub(super) far_scale: [f32; 3],
    pub(super) far_shift: [f32; 3],
    /// Bit `a` is set if component `a` of the direction is negative.
    pub(super) octant: usize,
}

impl BoxRay {
    /// A ray from `o`; `scale` is the [`slab_reciprocal`] of its direction.
    #[inline(always)]
    pub(super) fn new(o: Vec3, scale: Vec3) -> Self {
        let shift = o * scale;
        let margin = shift.abs() * ORIGIN_MARGIN;
        BoxRay {
            near_scale: scale.to_array(),
            near_shift: (shift + margin).to_array(),
            far_scale: (scale * FAR_MARGIN).to_array(),
            far_shift: ((shift - margin) * FAR_MARGIN).to_array(),
            octant: octant(scale),
        }
    }

    /// The word of [`WideNode::order`] for this ray.
    #[inline(always)]
    fn order(&self, node: &WideNode) -> u32 {
        node.order[self.octant % NARROW]
    }

    /// Ray parameters of entry into the children, and of exit or `t_max`. The ray meets the
    /// children with entry <= exit.
    #[inline(always)]
    fn cut<S: Simd>(&self, s: S, node: &WideNode, t_max: f32) -> (Float<S>, Float<S>) {
        // The planes are lower x, y, z, upper x, y, z.
        let near = |axis: usize| {
            let plane = Float::load(s, &node.bounds[axis + 3 * (self.octant >> axis & 1)]);
            plane.mul_sub(self.near_scale[axis], self.near_shift[axis])
        };
        let far = |axis: usize| {
            let plane = Float::load(s, &node.bounds[axis + 3 * (!self.octant >> axis & 1)]);
            plane.mul_sub(self.far_scale[axis], self.far_shift[axis])
        };
        let enter = near(0).max(near(1)).max(near(2).max(0.0));
        let leave = far(0).min(far(1)).min(far(2).min(t_max));
        (enter, leave)
    }

    /// The children that the ray meets before parameter 1, as bits.
    #[inline(always)]
    fn meets<S: Simd>(&self, s: S, node: &WideNode) -> u32 {
        let (near, far) = self.cut(s, node, 1.0);
        near.le(far).bits()
    }
}

/// Visits the leaves below the child word `root` that the ray enters before `reach`, approximately
/// front to back.
#[inline(always)]
pub(super) fn nearest<S: Simd>(
    s: S,
    nodes: &[WideNode],
    root: u32,
    slabs: &BoxRay,
    mut reach: f32,
    leaves: &mut impl NearestLeaves<S>,
) {
    let mut stack = Stack::new();
    let mut word = root;
    loop {
        if word & LEAF == 0 {
            let node = &nodes[word as usize];
            let span = slabs.cut(s, node, reach);
            let order = slabs.order(node);
            if let Some(next) = stack.push_but_last(s, order, &node.children, span) {
                word = next;
                continue;
            }
        } else {
            prefetch_next(nodes, leaves, stack.top());
            reach = leaves.visit(s, (word & !LEAF) as usize, reach);
        }
        let Some(next) = stack.pop_before(reach) else {
            return;
        };
        word = next;
    }
}

/// Whether a segment hits a leaf below the child word `root`.
#[inline(always)]
pub(super) fn any<S: Simd>(
    s: S,
    nodes: &[WideNode],
    root: u32,
    slabs: &BoxRay,
    leaves: &impl AnyLeaves<S>,
) -> bool {
    let mut stack = WordStack::new();
    let mut word = root;
    loop {
        if word & LEAF == 0 {
            let node = &nodes[word as usize];
            let bits = slabs.meets(s, node);
            if bits != 0 {
                let last = highest(bits);
                word = node.children[last % NARROW];
                stack.push(s, &node.children, bits ^ 1 << last);
                continue;
            }
        } else {
            prefetch_next(nodes, leaves, stack.top());
            if leaves.visit(s, (word & !LEAF) as usize) {
                return true;
            }
        }
        let Some(next) = stack.pop() else {
            return false;
        };
        word = next;
    }
}
