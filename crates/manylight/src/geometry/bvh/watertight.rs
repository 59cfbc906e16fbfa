//! Single rays against blocks of triangles.
//!
//! The test is watertight: Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013. Without contraction the sign
//! of an edge function is never wrong, and both triangles at an edge accept zero.

use super::traverse::{AnyLeaves, Leaves, NearestLeaves};
use super::triangle_block::{TriangleBlock, TriangleHit};
use crate::geometry::Ray;
use crate::math::{Vec2, Vec3};
use crate::simd::{NARROW, Simd, Width, set_bits};

/// A ray and the shear that turns its direction into the z axis.
pub(super) struct Sheared {
    /// Permutation of the axes; the last is the largest component of the direction.
    pub(super) axes: [usize; 3],
    pub(super) o: [f32; 3],
    pub(super) shear: [f32; 2],
    pub(super) scale: f32,
}

/// Result of tests of rays against triangles, in lanes: a ray against eight triangles, or sixteen rays against a triangle.
pub(super) struct Crossing<V: Width> {
    /// Edge functions opposite to each corner: barycentric coordinates times `det`.
    pub(super) edges: [V::F; 3],
    /// Sum of the edge functions.
    pub(super) det: V::F,
    /// Ray parameter times `|det|`: positive in front of the origin.
    pub(super) height: V::F,
    /// Lanes with a hit at `0 < t < limit`.
    pub(super) hit: V::M,
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
pub(super) fn shear_corner<V: Width>(
    v: V,
    corner: [V::F; 3],
    o: [V::F; 3],
    shear: [V::F; 2],
) -> [V::F; 3] {
    let z = v.sub(corner[2], o[2]);
    [
        v.mul_add(shear[0], z, v.sub(corner[0], o[0])),
        v.mul_add(shear[1], z, v.sub(corner[1], o[1])),
        z,
    ]
}

/// The lines of rays against sheared triangles: the first part of a [`Crossing`].
pub(super) struct Sides<V: Width> {
    edges: [V::F; 3],
    /// The z coordinates of the corners.
    z: [V::F; 3],
    /// Lanes where the line of the ray cuts the triangle.
    pub(super) inside: V::M,
}

impl<V: Width> Sides<V> {
    /// The test of triangles with the sheared corners `a`, `b` and `c`.
    #[inline(always)]
    pub(super) fn new(v: V, [a, b, c]: [[V::F; 3]; 3]) -> Self {
        // The difference of two rounded products has the exact sign or is zero.
        let edge = |p: [V::F; 3], q: [V::F; 3]| v.sub(v.mul(p[0], q[1]), v.mul(p[1], q[0]));
        let edges = [edge(c, b), edge(a, c), edge(b, a)];
        let zero = v.splat(0.0);
        let least = v.min(v.min(edges[0], edges[1]), edges[2]);
        let most = v.max(v.max(edges[0], edges[1]), edges[2]);
        Sides {
            edges,
            z: [a[2], b[2], c[2]],
            inside: v.or(v.le(zero, least), v.le(most, zero)),
        }
    }

    /// The hits before `limit`. `scale` is the reciprocal of the ray's largest component.
    #[inline(always)]
    pub(super) fn crossing(self, v: V, scale: V::F, limit: V::F) -> Crossing<V> {
        let ([e0, e1, e2], [z0, z1, z2]) = (self.edges, self.z);
        let det = v.add(v.add(e0, e1), e2);
        let z = v.mul_add(e0, z0, v.mul_add(e1, z1, v.mul(e2, z2)));
        let height = v.mul_sign(v.mul(z, scale), det);
        // For a degenerate or edge-on triangle all values are zero, and the strict comparisons fail.
        let farthest = v.mul(v.abs(det), limit);
        let between = v.and(v.lt(v.splat(0.0), height), v.lt(height, farthest));
        Crossing {
            edges: self.edges,
            det,
            height,
            hit: v.and(self.inside, between),
        }
    }
}

impl<V: Width> Crossing<V> {
    /// Ray parameters.
    #[inline(always)]
    pub(super) fn distances(&self, v: V) -> V::F {
        v.div(self.height, v.abs(self.det))
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
        let sides = self.sides(s, block);
        sides.crossing(s, s.splat(self.scale), s.splat(limit))
    }

    #[inline(always)]
    fn sides<S: Simd>(&self, s: S, block: &TriangleBlock) -> Sides<S> {
        let o = [s.splat(self.o[0]), s.splat(self.o[1]), s.splat(self.o[2])];
        let shear = [s.splat(self.shear[0]), s.splat(self.shear[1])];
        let corners = [
            shear_corner(s, self.planes(s, &block.corners[0]), o, shear),
            shear_corner(s, self.planes(s, &block.corners[1]), o, shear),
            shear_corner(s, self.planes(s, &block.corners[2]), o, shear),
        ];
        Sides::new(s, corners)
    }

    #[inline(always)]
    fn planes<S: Simd>(&self, s: S, corner: &[[f32; NARROW]; 3]) -> [S::F; 3] {
        [
            s.load(&corner[self.axes[0]]),
            s.load(&corner[self.axes[1]]),
            s.load(&corner[self.axes[2]]),
        ]
    }

    /// Makes `best` the nearest hit with the triangles of a block, if it comes before `best`.
    #[inline(always)]
    pub(super) fn nearest<S: Simd>(&self, s: S, block: &TriangleBlock, best: &mut NearestHit) {
        let sides = self.sides(s, block);
        if s.bits(sides.inside) == 0 {
            return;
        }
        let crossing = sides.crossing(s, s.splat(self.scale), s.splat(best.reach()));
        let bits = s.bits(crossing.hit);
        if bits == 0 {
            return;
        }
        let t = s.store(crossing.distances(s));
        for lane in set_bits(bits).map(|lane| lane % NARROW) {
            if best.yields_to(t[lane], block.ids[lane]) {
                *best = NearestHit {
                    t: t[lane],
                    id: Some(block.ids[lane]),
                    weights: crossing.weights(s, lane),
                };
            }
        }
    }

    /// Whether a triangle of a block is hit before parameter 1.
    #[inline(always)]
    pub(super) fn any<S: Simd>(&self, s: S, block: &TriangleBlock) -> bool {
        let sides = self.sides(s, block);
        if s.bits(sides.inside) == 0 {
            return false;
        }
        let crossing = sides.crossing(s, s.splat(self.scale), s.splat(1.0));
        s.bits(crossing.hit) != 0
    }
}

impl<S: Simd> Crossing<S> {
    /// The edge functions opposite to the second and third corner, and the sum of all three.
    #[inline(always)]
    fn weights(&self, s: S, lane: usize) -> [f32; 3] {
        let at = |x: S::F| s.store(x)[lane];
        [at(self.edges[1]), at(self.edges[2]), at(self.det)]
    }
}

/// Factor on the ray parameter of a hit that outweighs the rounding of the tests of boxes and triangles: whatever may come before the
/// hit, or at the same distance, is tested.
pub(super) const REACH_MARGIN: f32 = 1.0 + 16.0 * f32::EPSILON;

/// The nearest hit of a ray so far. Of hits at equal distances the one with the lowest index counts, so that the order of
/// the tests does not matter.
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
        let bits = s.bits(crossing.hit);
        if bits == 0 {
            return t_max;
        }
        let t = s.store(crossing.distances(s));
        for lane in set_bits(bits) {
            let [v, w, det] = crossing.weights(s, lane);
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
