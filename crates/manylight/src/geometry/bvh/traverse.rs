//! Walks of one ray through a tree: nearest hit in order, and any hit with early out.

use super::build::{LEAF, Node};
use super::stack::{Stack, WordStack};
use crate::geometry::Ray;
use crate::math::Vec3;
use crate::simd::{NARROW, Simd};

/// Tests a leaf for the nearest hit.
pub(super) trait NearestLeaves<S: Simd> {
    /// Notes the nearest hit below `t_max` in the leaf, and returns its distance, or `t_max` without one.
    fn visit(&mut self, s: S, leaf: usize, t_max: f32) -> f32;
}

/// Tests a leaf for any hit.
pub(super) trait AnyLeaves<S: Simd> {
    /// Whether the ray hits something in the leaf.
    fn visit(&self, s: S, leaf: usize) -> bool;
}

/// Factor on the far distance that outweighs the roundings of a slab test.
/// Source: Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013.
pub(super) const FAR_MARGIN: f32 = 1.0 + 8.0 * f32::EPSILON;

/// Components smaller than this, relative to the largest, count as this: far below rounding.
pub(super) const NEGLIGIBLE: f32 = 1e-12;

/// Reciprocal of a direction for slab tests: finite, with zeros replaced by something far below rounding.
#[inline(always)]
pub(super) fn slab_reciprocal(d: Vec3) -> Vec3 {
    let tiny = (d.abs().max_element() * NEGLIGIBLE).max(f32::MIN_POSITIVE);
    let reciprocal = |x: f32| 1.0 / if x.abs() < tiny { tiny.copysign(x) } else { x };
    Vec3::new(reciprocal(d.x), reciprocal(d.y), reciprocal(d.z))
}

/// A ray prepared for slab tests `t = b / d - o / d`, one fused operation per plane. The rounding of `o / d` is as if
/// the origin moved by an ulp; the near and the far planes are moved apart by more than that.
struct BoxRay<S: Simd> {
    near_scale: [S::F; 3],
    near_shift: [S::F; 3],
    far_scale: [S::F; 3],
    far_shift: [S::F; 3],
    near_plane: [usize; 3],
    octant: usize,
}

impl<S: Simd> BoxRay<S> {
    #[inline(always)]
    fn new(s: S, o: Vec3, scale: Vec3) -> Self {
        let shift = o * scale;
        let margin = shift.abs() * (2.0 * f32::EPSILON);
        let (near_shift, far_shift) = (shift + margin, (shift - margin) * FAR_MARGIN);
        let splat = |v: Vec3| [s.splat(v.x), s.splat(v.y), s.splat(v.z)];
        let negative = |x: f32| usize::from(x.is_sign_negative());
        let signs = [negative(scale.x), negative(scale.y), negative(scale.z)];
        BoxRay {
            near_scale: splat(scale),
            near_shift: splat(near_shift),
            far_scale: splat(scale * FAR_MARGIN),
            far_shift: splat(far_shift),
            near_plane: [3 * signs[0], 1 + 3 * signs[1], 2 + 3 * signs[2]],
            octant: signs[0] | signs[1] << 1 | signs[2] << 2,
        }
    }

    /// Where the ray enters the children, and where it leaves them or `t_max` ends it; it meets those with near <= far.
    #[inline(always)]
    fn cut(&self, s: S, node: &Node, t_max: f32) -> (S::F, S::F) {
        let near = |axis: usize| {
            let plane = s.load(&node.bounds[self.near_plane[axis]]);
            s.mul_sub(plane, self.near_scale[axis], self.near_shift[axis])
        };
        let far = |axis: usize| {
            // The other plane of the axis: the six are lower x, y, z, upper x, y, z.
            let plane = s.load(&node.bounds[2 * axis + 3 - self.near_plane[axis]]);
            s.mul_sub(plane, self.far_scale[axis], self.far_shift[axis])
        };
        let enter = s.max(s.max(near(0), near(1)), s.max(near(2), s.splat(0.0)));
        let leave = s.min(s.min(far(0), far(1)), s.min(far(2), s.splat(t_max)));
        (enter, leave)
    }

    /// The children that the ray meets before `t` = 1, as bits.
    #[inline(always)]
    fn meets(&self, s: S, node: &Node) -> u32 {
        let (near, far) = self.cut(s, node, 1.0);
        s.bits(s.le(near, far))
    }
}

/// Visits the leaves that the ray may hit, nearest first as far as the boxes tell.
#[inline(always)]
pub(super) fn nearest<S: Simd>(
    s: S,
    nodes: &[Node],
    ray: &Ray,
    leaves: &mut impl NearestLeaves<S>,
) {
    let slabs = BoxRay::new(s, ray.o, slab_reciprocal(ray.d));
    let mut stack = Stack::new();
    let mut t_max = ray.t_max;
    let mut word = 0;
    loop {
        if word & LEAF == 0 {
            let node = &nodes[word as usize];
            let span = slabs.cut(s, node, t_max);
            stack.push(s, node.order[slabs.octant], &node.children, span);
        } else {
            t_max = leaves.visit(s, (word & !LEAF) as usize, t_max);
        }
        loop {
            let Some((next, near)) = stack.pop() else {
                return;
            };
            if near < t_max {
                word = next;
                break;
            }
        }
    }
}

/// Whether the segment from `o` on hits a leaf below the child word `root`; `scale` is the [`slab_reciprocal`] of its direction.
#[inline(always)]
pub(super) fn any<S: Simd>(
    s: S,
    nodes: &[Node],
    root: u32,
    o: Vec3,
    scale: Vec3,
    leaves: &impl AnyLeaves<S>,
) -> bool {
    let slabs = BoxRay::new(s, o, scale);
    let mut stack = WordStack::new();
    let mut word = root;
    loop {
        if word & LEAF == 0 {
            let node = &nodes[word as usize];
            let bits = slabs.meets(s, node);
            if bits != 0 {
                word = node.children[bits.trailing_zeros() as usize % NARROW];
                stack.push(s, &node.children, bits & (bits - 1));
                continue;
            }
        } else if leaves.visit(s, (word & !LEAF) as usize) {
            return true;
        }
        let Some(next) = stack.pop() else {
            return false;
        };
        word = next;
    }
}
