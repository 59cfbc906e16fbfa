//! Single rays against blocks of triangles.
//!
//! The test is watertight: Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013. Without contraction the sign
//! of an edge function is never wrong, and both triangles at an edge accept zero.

use super::traverse::{AnyLeaves, Leaves, NearestLeaves};
use super::triangle_block::{TriangleBlock, TriangleHit};
use crate::geometry::Ray;
use crate::math::{Vec2, Vec3};
use crate::simd::{NARROW, Simd, set_bits};

/// A ray and the shear that turns its direction into the z axis.
struct Sheared {
    /// Permutation of the axes; the last is the largest component of the direction.
    axes: [usize; 3],
    o: [f32; 3],
    shear: [f32; 2],
    scale: f32,
}

/// Result of the test of a ray against eight triangles.
struct Crossing<S: Simd> {
    /// Edge functions opposite to each corner: barycentric coordinates times `det`.
    edges: [S::F; 3],
    /// Sum of the edge functions.
    det: S::F,
    /// Ray parameter times `|det|`: positive in front of the origin.
    height: S::F,
    /// Lanes with a hit at `0 < t < t_max`.
    hit: S::M,
}

impl Sheared {
    #[inline(always)]
    fn new(o: Vec3, d: Vec3) -> Self {
        let size = d.abs();
        // Without branches: they would be mispredicted often.
        let y = usize::from(size.y > size.x);
        let z = if size.z > size[y] { 2 } else { y };
        let axes = [NEXT[z], NEXT[NEXT[z]], z];
        let scale = 1.0 / d[z];
        Sheared {
            axes,
            o: axes.map(|axis| o[axis]),
            shear: [-d[axes[0]] * scale, -d[axes[1]] * scale],
            scale,
        }
    }

    #[inline(always)]
    fn corner<S: Simd>(&self, s: S, corner: &[[f32; NARROW]; 3]) -> [S::F; 3] {
        let relative = |i: usize| {
            let plane = s.load(&corner[self.axes[i]]);
            s.sub(plane, s.splat(self.o[i]))
        };
        let z = relative(2);
        [
            s.mul_add(s.splat(self.shear[0]), z, relative(0)),
            s.mul_add(s.splat(self.shear[1]), z, relative(1)),
            z,
        ]
    }

    #[inline(always)]
    fn cross<S: Simd>(&self, s: S, block: &TriangleBlock, t_max: f32) -> Crossing<S> {
        let a = self.corner(s, &block.corners[0]);
        let b = self.corner(s, &block.corners[1]);
        let c = self.corner(s, &block.corners[2]);
        // The difference of two rounded products has the exact sign or is zero.
        let edge = |p: [S::F; 3], q: [S::F; 3]| s.sub(s.mul(p[0], q[1]), s.mul(p[1], q[0]));
        let (u, v, w) = (edge(c, b), edge(a, c), edge(b, a));
        let det = s.add(s.add(u, v), w);
        let zero = s.splat(0.0);
        let inside = s.or(
            s.le(zero, s.min(s.min(u, v), w)),
            s.le(s.max(s.max(u, v), w), zero),
        );
        let z = s.mul_add(u, a[2], s.mul_add(v, b[2], s.mul(w, c[2])));
        let height = s.mul_sign(s.mul(z, s.splat(self.scale)), det);
        // For a degenerate or edge-on triangle all values are zero, and the strict comparisons fail.
        let farthest = s.mul(s.abs(det), s.splat(t_max));
        let between = s.and(s.lt(zero, height), s.lt(height, farthest));
        Crossing {
            edges: [u, v, w],
            det,
            height,
            hit: s.and(inside, between),
        }
    }

    /// The nearest hit with the triangles of a block at `t < t_max`.
    #[inline(always)]
    fn nearest<S: Simd>(&self, s: S, block: &TriangleBlock, t_max: f32) -> Option<TriangleHit> {
        let crossing = self.cross(s, block, t_max);
        let mut bits = s.bits(crossing.hit);
        if bits == 0 {
            return None;
        }
        let t = crossing.distances(s);
        let mut lane = bits.trailing_zeros() as usize % NARROW;
        bits &= bits - 1;
        while bits != 0 {
            let other = bits.trailing_zeros() as usize % NARROW;
            lane = if t[other] < t[lane] { other } else { lane };
            bits &= bits - 1;
        }
        if t[lane] >= t_max {
            return None;
        }
        Some(TriangleHit {
            t: t[lane],
            id: block.ids[lane],
            coordinates: crossing.coordinates(s, lane),
        })
    }

    /// Whether a triangle of a block is hit before parameter 1.
    #[inline(always)]
    fn any<S: Simd>(&self, s: S, block: &TriangleBlock) -> bool {
        s.bits(self.cross(s, block, 1.0).hit) != 0
    }
}

impl<S: Simd> Crossing<S> {
    #[inline(always)]
    fn distances(&self, s: S) -> [f32; NARROW] {
        s.store(s.div(self.height, s.abs(self.det)))
    }

    /// The barycentric coordinates of the second and third corner.
    #[inline(always)]
    fn coordinates(&self, s: S, lane: usize) -> Vec2 {
        let [_, v, w] = self.edges;
        let (v, w, det) = (s.store(v)[lane], s.store(w)[lane], s.store(self.det)[lane]);
        Vec2::new(v / det, w / det)
    }
}

/// Cyclic successor of each axis.
const NEXT: [usize; 3] = [1, 2, 0];

/// Finds the nearest hit of a ray.
pub(super) struct NearestTriangle<'a> {
    blocks: &'a [TriangleBlock],
    ray: Sheared,
    pub(super) best: Option<TriangleHit>,
}

impl<'a> NearestTriangle<'a> {
    #[inline(always)]
    pub(super) fn new(blocks: &'a [TriangleBlock], ray: &Ray) -> Self {
        NearestTriangle {
            blocks,
            ray: Sheared::new(ray.o, ray.d),
            best: None,
        }
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
    fn visit(&mut self, s: S, leaf: usize, t_max: f32) -> f32 {
        match self.ray.nearest(s, &self.blocks[leaf], t_max) {
            Some(hit) => {
                self.best = Some(hit);
                hit.t
            }
            None => t_max,
        }
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
        let t = crossing.distances(s);
        for lane in set_bits(bits) {
            self.ended = (self.visit)(TriangleHit {
                t: t[lane],
                id: block.ids[lane],
                coordinates: crossing.coordinates(s, lane),
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
        AnyTriangle {
            blocks,
            segment: Sheared::new(o, d),
        }
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
