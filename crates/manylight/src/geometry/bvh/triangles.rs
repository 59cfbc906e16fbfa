//! Blocks of eight triangles and the two tests for them.
//!
//! Nearest hits use the watertight test of Woop, Benthin and Wald ("Watertight Ray/Triangle Intersection", JCGT 2(1), 2013):
//! without contraction, the sign of an edge function is never wrong, and both neighbors accept zero.
//! Visibility uses edge volumes seen from the common origin, whose setup serves all rays of a packet. An edge enters as
//! (a - b) x (a + b), which loses less of far edges than a x b. The value is rounded where the ray passes a corner, so what
//! rounding can hide counts as inside: no ray slips through between neighbors.

use super::traverse::{AnyLeaves, Leaves, NearestLeaves};
use crate::geometry::Ray;
use crate::lanes::vectors::{abs3, add3, cross, dot, load3, sub3};
use crate::math::{Vec2, Vec3};
use crate::simd::{Floats, NARROW, Simd, set_bits};

/// Up to eight triangles. Unused lanes are degenerate, which no ray hits.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct TriangleBlock {
    /// Corner, axis, lane.
    pub(super) corners: [[[f32; NARROW]; 3]; 3],
    /// Index of the triangle in the list that the structure was built over.
    pub(super) ids: [u32; NARROW],
}

impl TriangleBlock {
    pub(super) fn new(ids: &[u32], triangles: &[[Vec3; 3]]) -> Self {
        let mut block = TriangleBlock {
            corners: [[[0.0; NARROW]; 3]; 3],
            ids: [0; NARROW],
        };
        for (lane, &id) in ids.iter().enumerate() {
            block.ids[lane] = id;
            for (corner, p) in triangles[id as usize].iter().enumerate() {
                for axis in 0..3 {
                    block.corners[corner][axis][lane] = p[axis];
                }
            }
        }
        block
    }
}

/// A hit on a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TriangleHit {
    /// In units of the ray's direction.
    pub(crate) t: f32,
    /// Index of the triangle.
    pub(crate) id: u32,
    /// Barycentric coordinates of the second and third corner.
    pub(crate) coordinates: Vec2,
}

/// Eight triangles at a time as one ray sees them: sheared so that it runs along z.
struct Sheared {
    /// The last of them the largest of the direction.
    axes: [usize; 3],
    o: [f32; 3],
    shear: [f32; 2],
    scale: f32,
}

/// What a ray makes of eight triangles.
struct Crossing<S: Simd> {
    /// Edge functions of the ray, opposite to each corner; barycentric coordinates times `det`.
    edges: [S::F; 3],
    /// Their sum.
    det: S::F,
    /// Distance times `det`, with the sign of `det` taken off: positive in front of the origin.
    height: S::F,
    /// Where the line passes inside, in front of the origin and before `t_max`.
    hit: S::M,
}

impl Sheared {
    #[inline(always)]
    fn new(o: Vec3, d: Vec3) -> Self {
        let size = d.abs();
        // Without branches: which axis it is cannot be predicted.
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
        // Two rounded products each: their difference has the right sign or is zero.
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
        // All zero where the triangle is degenerate or seen from its edge: not below itself.
        let farthest = s.mul(s.abs(det), s.splat(t_max));
        let between = s.and(s.lt(zero, height), s.lt(height, farthest));
        Crossing {
            edges: [u, v, w],
            det,
            height,
            hit: s.and(inside, between),
        }
    }

    /// The nearest hit among the triangles of a block, if there is one below `t_max`.
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

    /// Whether a triangle of a block lies before `t` = 1.
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

const NEXT: [usize; 3] = [1, 2, 0];

/// The nearest-hit test for one ray.
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

/// Calls a function for all hits of one ray.
pub(super) struct EachTriangle<'a, V> {
    blocks: &'a [TriangleBlock],
    ray: Sheared,
    visit: V,
    /// Whether the function asked for an end.
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
    /// Returns 0 for an end: nothing is nearer.
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

/// The volumes between an origin and the edges of eight triangles, and the triangles' planes.
pub(super) struct EdgeVolumes<V> {
    /// Normals of the planes through the origin and each edge.
    pub(super) edges: [[V; 3]; 3],
    /// For each edge what rounding may make of zero, for a direction whose largest component is 1.
    pub(super) tolerances: [V; 3],
    /// Normal of the triangle.
    pub(super) normal: [V; 3],
    /// Normal times the distance vector to the triangle.
    pub(super) height: V,
}

/// Directions of eight segments from one origin, or one for all lanes.
pub(super) struct SegmentDirections<V> {
    pub(super) d: [V; 3],
    /// The largest component.
    pub(super) size: V,
}

impl<V: Copy> EdgeVolumes<V> {
    #[inline(always)]
    pub(super) fn new<L: Floats<NARROW, F = V>>(s: L, block: &TriangleBlock, o: [V; 3]) -> Self {
        let [a, b, c] = [
            load3(s, &block.corners[0]),
            load3(s, &block.corners[1]),
            load3(s, &block.corners[2]),
        ];
        // Edges come from the corners themselves, not from the rounded differences to the origin.
        let [ab, bc, ca] = [sub3(s, a, b), sub3(s, b, c), sub3(s, c, a)];
        let [a, b, c] = [sub3(s, a, o), sub3(s, b, o), sub3(s, c, o)];
        let edges = [
            cross(s, ab, add3(s, a, b)),
            cross(s, bc, add3(s, b, c)),
            cross(s, ca, add3(s, c, a)),
        ];
        let normal = cross(s, ca, ab);
        let tolerances = [
            tolerance(s, edges[0]),
            tolerance(s, edges[1]),
            tolerance(s, edges[2]),
        ];
        EdgeVolumes {
            edges,
            tolerances,
            normal,
            height: dot(s, normal, a),
        }
    }

    /// Whether the segments hit the triangles, lane by lane.
    ///
    /// With edge values of one sign the line passes through; it meets the plane at `height / (normal · d)`, in (0, 1).
    #[inline(always)]
    pub(super) fn hit_by<const N: usize, L: Floats<N, F = V>>(
        &self,
        s: L,
        segments: &SegmentDirections<V>,
    ) -> L::M {
        let facing = dot(s, self.normal, segments.d);
        let [u, v, w] = [
            self.edge(s, 0, segments, facing),
            self.edge(s, 1, segments, facing),
            self.edge(s, 2, segments, facing),
        ];
        let zero = s.splat(0.0);
        let inside = s.le(zero, s.min(s.min(u, v), w));
        let height = s.mul_sign(self.height, facing);
        s.and(
            inside,
            s.and(s.lt(zero, height), s.lt(height, s.mul_sign(facing, facing))),
        )
    }

    #[inline(always)]
    fn edge<const N: usize, L: Floats<N, F = V>>(
        &self,
        s: L,
        edge: usize,
        segments: &SegmentDirections<V>,
        facing: V,
    ) -> V {
        let value = s.mul_sign(dot(s, self.edges[edge], segments.d), facing);
        s.mul_add(self.tolerances[edge], segments.size, value)
    }

    /// The triangles that a segment to somewhere in a box may hit: `middle` and `half` extent of the box of directions, and the
    /// largest component of any of them.
    #[inline(always)]
    pub(super) fn within<L: Floats<NARROW, F = V>>(
        &self,
        s: L,
        middle: [V; 3],
        half: [V; 3],
        size: V,
    ) -> u32 {
        let zero = s.splat(0.0);
        let reach = dot(s, abs3(s, self.normal), half);
        let facing = dot(s, self.normal, middle);
        let (least, greatest) = (s.sub(facing, reach), s.add(facing, reach));
        // Forwards is along the normal, through the plane from below.
        let mut forwards = s.and(s.lt(zero, self.height), s.lt(self.height, greatest));
        let mut backwards = s.and(s.lt(self.height, zero), s.lt(least, self.height));
        for edge in 0..3 {
            let n = self.edges[edge];
            let slack = s.mul(self.tolerances[edge], size);
            let reach = s.add(dot(s, abs3(s, n), half), slack);
            let value = dot(s, n, middle);
            forwards = s.and(forwards, s.le(zero, s.add(value, reach)));
            backwards = s.and(backwards, s.le(s.sub(value, reach), zero));
        }
        s.bits(s.or(forwards, backwards))
    }
}

#[inline(always)]
fn tolerance<const N: usize, L: Floats<N>>(s: L, n: [L::F; 3]) -> L::F {
    let [x, y, z] = abs3(s, n);
    s.mul(s.add(s.add(x, y), z), s.splat(ROUNDINGS))
}

/// What rounding may make of zero in an edge function, relative to its terms.
pub(super) const ROUNDINGS: f32 = 2.0 * f32::EPSILON;

/// The any-hit test for one segment.
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
