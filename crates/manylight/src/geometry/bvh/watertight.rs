//! Single rays against blocks of triangles.
//!
//! The test is watertight: Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT
//! 2(1), 2013. Without contraction the sign of an edge function is never wrong, and both triangles
//! at an edge accept zero.

use super::traverse::{AnyLeaves, Leaves, NearestLeaves};
use super::triangle_block::{TriangleBlock, TriangleHit};
use crate::geometry::Ray;
use crate::lanes::{Float, Mask, Pair, Vector, Width};
use crate::math::{Vec2, Vec3};
use crate::simd::{NARROW, Simd, set_bits};

/// A ray and the shear that turns its direction into the z axis.
pub(super) struct Sheared {
    /// Permutation of the axes; the last is the largest component of the direction.
    pub(super) axes: [usize; 3],
    pub(super) o: [f32; 3],
    pub(super) shear: [f32; 2],
    pub(super) scale: f32,
}

/// Result of tests of rays against triangles, in lanes: a ray against eight triangles, or sixteen
/// rays against a triangle.
pub(super) struct Crossing<S: Width> {
    /// Edge functions opposite to each corner: barycentric coordinates times `det`.
    pub(super) edges: [Float<S>; 3],
    /// Sum of the edge functions.
    pub(super) det: Float<S>,
    /// Ray parameter times `|det|`: positive in front of the origin.
    height: Float<S>,
    /// Lanes with a hit at `0 < t < limit`.
    pub(super) hit: Mask<S>,
}

/// The axis of the largest component, the first of equal ones.
#[inline(always)]
pub(super) fn main_axis(d: Vec3) -> usize {
    let size = d.abs();
    // Without branches: they would be mispredicted often.
    let y = usize::from(size.y > size.x);
    if size.z > size[y] { 2 } else { y }
}

/// The axes in cyclic order, the last being `main`.
#[inline(always)]
pub(super) fn axes_before(main: usize) -> [usize; 3] {
    [NEXT[main], NEXT[NEXT[main]], main]
}

/// A corner relative to the ray, sheared.
#[inline(always)]
pub(super) fn shear_corner<S: Width>(corner: Vector<S>, o: Vector<S>, shear: Pair<S>) -> Vector<S> {
    let v = corner - o;
    Vector::new(shear.x.mul_add(v.z, v.x), shear.y.mul_add(v.z, v.y), v.z)
}

/// The lines of rays against sheared triangles: the first part of a [`Crossing`].
pub(super) struct Sides<S: Width> {
    edges: [Float<S>; 3],
    /// The z coordinates of the corners.
    z: [Float<S>; 3],
    /// Lanes where the line of the ray cuts the triangle.
    pub(super) inside: Mask<S>,
}

impl<S: Width> Sides<S> {
    /// The test of triangles with the sheared corners `a`, `b` and `c`.
    #[inline(always)]
    pub(super) fn new([a, b, c]: [Vector<S>; 3]) -> Self {
        // The difference of two rounded products has the exact sign or is zero.
        let edge = |p: Vector<S>, q: Vector<S>| p.x * q.y - p.y * q.x;
        let edges = [edge(c, b), edge(a, c), edge(b, a)];
        let least = edges[0].min(edges[1]).min(edges[2]);
        let most = edges[0].max(edges[1]).max(edges[2]);
        Sides {
            edges,
            z: [a.z, b.z, c.z],
            inside: least.ge(0.0) | most.le(0.0),
        }
    }

    /// The hits before `limit`. `scale` is the reciprocal of the ray's largest component.
    #[inline(always)]
    pub(super) fn crossing(self, scale: Float<S>, limit: Float<S>) -> Crossing<S> {
        let ([e0, e1, e2], [z0, z1, z2]) = (self.edges, self.z);
        let det = e0 + e1 + e2;
        let z = e0.mul_add(z0, e1.mul_add(z1, e2 * z2));
        let height = (z * scale).mul_sign(det);
        // For a degenerate or edge-on triangle all values are zero, and the strict comparisons
        // fail.
        let between = height.gt(0.0) & height.lt(det.abs() * limit);
        Crossing {
            edges: self.edges,
            det,
            height,
            hit: self.inside & between,
        }
    }
}

impl<S: Width> Crossing<S> {
    /// Ray parameters.
    #[inline(always)]
    pub(super) fn distances(&self) -> Float<S> {
        self.height / self.det.abs()
    }
}

impl Sheared {
    #[inline(always)]
    pub(super) fn new(o: Vec3, d: Vec3) -> Self {
        let axes = axes_before(main_axis(d));
        let scale = 1.0 / d[axes[2]];
        Sheared {
            axes,
            o: [o[axes[0]], o[axes[1]], o[axes[2]]],
            shear: [-d[axes[0]] * scale, -d[axes[1]] * scale],
            scale,
        }
    }

    #[inline(always)]
    fn cross<S: Simd>(&self, s: S, block: &TriangleBlock, limit: f32) -> Crossing<S> {
        self.crossing(self.sides(s, block), limit)
    }

    #[inline(always)]
    fn crossing<S: Simd>(&self, sides: Sides<S>, limit: f32) -> Crossing<S> {
        let s = sides.inside.width();
        sides.crossing(Float::splat(s, self.scale), Float::splat(s, limit))
    }

    #[inline(always)]
    fn sides<S: Simd>(&self, s: S, block: &TriangleBlock) -> Sides<S> {
        let o = Vector::splat(s, self.o.into());
        let shear = Pair::splat(s, self.shear.into());
        Sides::new([
            shear_corner(self.planes(s, &block.corners[0]), o, shear),
            shear_corner(self.planes(s, &block.corners[1]), o, shear),
            shear_corner(self.planes(s, &block.corners[2]), o, shear),
        ])
    }

    #[inline(always)]
    fn planes<S: Simd>(&self, s: S, corner: &[[f32; NARROW]; 3]) -> Vector<S> {
        Vector::new(
            Float::load(s, &corner[self.axes[0]]),
            Float::load(s, &corner[self.axes[1]]),
            Float::load(s, &corner[self.axes[2]]),
        )
    }

    /// Makes `best` the nearest hit with the triangles of a block, if it comes before `best`.
    #[inline(always)]
    pub(super) fn nearest<S: Simd>(&self, s: S, block: &TriangleBlock, best: &mut NearestHit) {
        let sides = self.sides(s, block);
        if sides.inside.none() {
            return;
        }
        let crossing = self.crossing(sides, best.reach());
        let bits = crossing.hit.bits();
        if bits == 0 {
            return;
        }
        let t = crossing.distances().store();
        for lane in set_bits(bits).map(|lane| lane % NARROW) {
            if best.yields_to(t[lane], block.ids[lane]) {
                *best = NearestHit {
                    t: t[lane],
                    id: Some(block.ids[lane]),
                    weights: crossing.weights(lane),
                };
            }
        }
    }

    /// Whether a triangle of a block is hit before parameter 1.
    #[inline(always)]
    pub(super) fn any<S: Simd>(&self, s: S, block: &TriangleBlock) -> bool {
        let sides = self.sides(s, block);
        !sides.inside.none() && self.crossing(sides, 1.0).hit.any()
    }
}

impl<S: Simd> Crossing<S> {
    /// The edge functions opposite to the second and third corner, and the sum of all three.
    #[inline(always)]
    fn weights(&self, lane: usize) -> [f32; 3] {
        let at = |x: Float<S>| x.store()[lane];
        [at(self.edges[1]), at(self.edges[2]), at(self.det)]
    }
}

/// Factor on the ray parameter of a hit that outweighs the rounding of the tests of boxes and
/// triangles: whatever may come before the hit, or at the same distance, is tested.
pub(super) const REACH_MARGIN: f32 = 1.0 + 16.0 * f32::EPSILON;

/// The nearest hit of a ray so far. Of hits at equal distances the one with the lowest index
/// counts, so that the order of the tests does not matter.
#[derive(Clone, Copy, Debug)]
pub(super) struct NearestHit {
    /// Ray parameter of the hit, or the bound of the ray.
    pub(super) t: f32,
    /// Index of the triangle; `None` before the first hit.
    pub(super) id: Option<u32>,
    /// Edge functions opposite to the second and third corner, and their sum with the first.
    pub(super) weights: [f32; 3],
}

impl NearestHit {
    #[inline(always)]
    pub(super) fn none(t_max: f32) -> Self {
        NearestHit {
            t: t_max,
            id: None,
            weights: [0.0; 3],
        }
    }

    /// Bound of the ray parameters of entry, for boxes and triangles that may have a nearer hit.
    #[inline(always)]
    pub(super) fn reach(&self) -> f32 {
        self.t * REACH_MARGIN
    }

    /// Whether a hit at `t` with triangle `id` replaces this one.
    #[inline(always)]
    pub(super) fn yields_to(&self, t: f32, id: u32) -> bool {
        t < self.t || (t == self.t && self.id.is_some_and(|own| id < own))
    }

    #[inline(always)]
    pub(super) fn hit(&self) -> Option<TriangleHit> {
        let [v, w, det] = self.weights;
        Some(TriangleHit {
            t: self.t,
            id: self.id?,
            coordinates: Vec2::new(v / det, w / det),
        })
    }
}

/// Cyclic successor of each axis.
const NEXT: [usize; 3] = [1, 2, 0];

/// Finds the nearest hit of a ray.
pub(super) struct NearestTriangle<'a> {
    blocks: &'a [TriangleBlock],
    ray: Sheared,
    pub(super) best: NearestHit,
}

impl<'a> NearestTriangle<'a> {
    #[inline(always)]
    pub(super) fn new(blocks: &'a [TriangleBlock], ray: Sheared, best: NearestHit) -> Self {
        NearestTriangle { blocks, ray, best }
    }
}

impl Leaves for NearestTriangle<'_> {
    type Leaf = TriangleBlock;

    #[inline(always)]
    fn all(&self) -> &[TriangleBlock] {
        self.blocks
    }
}

impl<S: Simd> NearestLeaves<S> for NearestTriangle<'_> {
    #[inline(always)]
    fn visit(&mut self, s: S, leaf: usize, _reach: f32) -> f32 {
        self.ray.nearest(s, &self.blocks[leaf], &mut self.best);
        self.best.reach()
    }
}

/// Calls a function for all hits of a ray.
pub(super) struct EachTriangle<'a, V> {
    blocks: &'a [TriangleBlock],
    ray: Sheared,
    visit: V,
    /// Whether the function has returned true, which ends the traversal.
    pub(super) ended: bool,
}

impl<'a, V> EachTriangle<'a, V> {
    #[inline(always)]
    pub(super) fn new(blocks: &'a [TriangleBlock], ray: &Ray, visit: V) -> Self {
        EachTriangle {
            blocks,
            ray: Sheared::new(ray.o, ray.d),
            visit,
            ended: false,
        }
    }
}

impl<V> Leaves for EachTriangle<'_, V> {
    type Leaf = TriangleBlock;

    #[inline(always)]
    fn all(&self) -> &[TriangleBlock] {
        self.blocks
    }
}

impl<S: Simd, V: FnMut(TriangleHit) -> bool> NearestLeaves<S> for EachTriangle<'_, V> {
    /// Returns 0 to end the traversal: no hit is nearer.
    #[inline(always)]
    fn visit(&mut self, s: S, leaf: usize, t_max: f32) -> f32 {
        let block = &self.blocks[leaf];
        let crossing = self.ray.cross(s, block, t_max);
        let bits = crossing.hit.bits();
        if bits == 0 {
            return t_max;
        }
        let t = crossing.distances().store();
        for lane in set_bits(bits) {
            let [v, w, det] = crossing.weights(lane);
            self.ended = (self.visit)(TriangleHit {
                t: t[lane],
                id: block.ids[lane],
                coordinates: Vec2::new(v / det, w / det),
            });
            if self.ended {
                return 0.0;
            }
        }
        t_max
    }
}

/// Finds whether a segment is blocked.
pub(super) struct AnyTriangle<'a> {
    blocks: &'a [TriangleBlock],
    segment: Sheared,
}

impl<'a> AnyTriangle<'a> {
    #[inline(always)]
    pub(super) fn new(blocks: &'a [TriangleBlock], o: Vec3, d: Vec3) -> Self {
        Self::sheared(blocks, Sheared::new(o, d))
    }

    #[inline(always)]
    pub(super) fn sheared(blocks: &'a [TriangleBlock], segment: Sheared) -> Self {
        AnyTriangle { blocks, segment }
    }
}

impl Leaves for AnyTriangle<'_> {
    type Leaf = TriangleBlock;

    #[inline(always)]
    fn all(&self) -> &[TriangleBlock] {
        self.blocks
    }
}

impl<S: Simd> AnyLeaves<S> for AnyTriangle<'_> {
    #[inline(always)]
    fn visit(&self, s: S, leaf: usize) -> bool {
        self.segment.any(s, &self.blocks[leaf])
    }
}
