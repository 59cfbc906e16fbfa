//! The hierarchy over triangles, and the kernels that query it.

use super::build::WideTree;
use super::item_box::{CornerRows, ItemBox};
use super::stream::{self, LaneHits};
use super::tile::{SIDE, VisibilityTile};
use super::traverse::{self, BoxRay};
use super::triangle_block::{TreeParts, TriangleBlock, TriangleHit};
use super::watertight::{AnyTriangle, EachTriangle, NearestHit, NearestTriangle, Sheared};
use crate::geometry::{Ray, Segment};
use crate::math::prefetch::prefetch;
use crate::math::{Aabb, Vec3, Vec4};
#[cfg(any(test, feature = "testing"))]
use crate::simd::Instructions;
use crate::simd::{Isa, NARROW, Simd, SimdKernel};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// A bounding volume hierarchy over triangles.
#[derive(Debug)]
pub(in crate::geometry) struct TriangleBvh {
    tree: WideTree,
    blocks: Vec<TriangleBlock>,
    pub(super) isa: Isa,
}

impl TriangleBvh {
    /// Builds the hierarchy over the triangles with these ids. Degenerate and non-finite ones are
    /// left out.
    pub(in crate::geometry) fn new<'a>(
        ids: &[u32],
        corners: impl Fn(u32) -> &'a CornerRows + Sync,
    ) -> Self {
        /// Number of triangles from which on tasks are worth their overhead.
        const GRAIN: usize = 1 << 10;
        /// Triangles between those that are read and those that are fetched into the cache. Without
        /// fetching, the leaves take 1.5 times as long in kitchen and 1.6 times in staircase2.
        const AHEAD: usize = 32;
        let some_left_out = AtomicBool::new(false);
        let mut boxes: Vec<ItemBox> = ids
            .par_iter()
            .with_min_len(GRAIN)
            .map(|&id| {
                let rows = corners(id);
                if can_be_hit(rows) {
                    return ItemBox::around(rows, id);
                }
                some_left_out.store(true, Ordering::Relaxed);
                ItemBox::around(rows, NONE)
            })
            .collect();
        if some_left_out.into_inner() {
            boxes.retain(|item| item.item() != NONE);
        }
        let mut tree = WideTree::new(boxes, NARROW);
        let isa = Isa::best();
        let blocks = tree
            .leaves
            .par_windows(2)
            .with_min_len(GRAIN)
            .map(|leaf| {
                let (first, end) = (leaf[0] as usize, leaf[1] as usize);
                let ahead = (end + AHEAD).min(tree.items.len());
                for &id in &tree.items[ahead..(ahead + end - first).min(tree.items.len())] {
                    prefetch(corners(id));
                }
                isa.run(BlockOf {
                    ids: &tree.items[first..end],
                    corners: &corners,
                })
            })
            .collect();
        // The blocks replace the leaves.
        (tree.items, tree.leaves) = (Vec::new(), Vec::new());
        TriangleBvh { tree, blocks, isa }
    }

    /// Whether no triangle can be hit.
    pub(in crate::geometry) fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    /// Runs the kernels in this instruction set.
    ///
    /// # Panics
    /// If the machine lacks the instruction set.
    #[cfg(any(test, feature = "testing"))]
    pub(in crate::geometry) fn use_instructions(&mut self, instructions: Instructions) {
        self.isa = Isa::new(instructions).expect("the machine lacks these instructions");
    }

    /// Bounding box of all triangles.
    pub(in crate::geometry) fn bounds(&self) -> Aabb {
        self.tree.bounds.unwrap_or(Aabb::EMPTY)
    }

    /// Memory in bytes.
    pub(in crate::geometry) fn bytes(&self) -> usize {
        self.tree.bytes() + size_of_val(&*self.blocks)
    }

    /// The nearest hit with `0 < t < ray.t_max`.
    #[inline]
    pub(in crate::geometry) fn nearest(&self, ray: &Ray) -> Option<TriangleHit> {
        if self.is_empty() {
            None
        } else {
            self.isa.run(NearestQuery { bvh: self, ray })
        }
    }

    /// Calls `visit` for all hits with `0 < t < ray.t_max` until it returns true; returns whether
    /// it has.
    pub(in crate::geometry) fn visit(
        &self,
        ray: &Ray,
        visit: impl FnMut(TriangleHit) -> bool,
    ) -> bool {
        !self.is_empty()
            && self.isa.run(EachQuery {
                bvh: self,
                ray,
                visit,
            })
    }

    /// Whether a triangle cuts the open segment.
    #[inline]
    pub(in crate::geometry) fn any(&self, from: Vec3, to: Vec3) -> bool {
        !self.is_empty()
            && self.isa.run(AnyQuery {
                bvh: self,
                from,
                d: to - from,
            })
    }

    /// [`TriangleBvh::nearest`] for each ray: calls `found` with the indices of up to sixteen rays
    /// and their hits, in any order.
    pub(in crate::geometry) fn nearest_stream(
        &self,
        rays: &[Ray],
        found: impl FnMut(&[u32], &LaneHits),
    ) {
        if !self.is_empty() {
            self.isa.run(NearestStream {
                bvh: self,
                rays,
                found,
            });
        }
    }

    /// [`TriangleBvh::any`] for each segment: element `i` of `blocked` becomes the answer for
    /// `segments[i]`.
    pub(in crate::geometry) fn any_stream(&self, segments: &[Segment], blocked: &mut [bool]) {
        if !self.is_empty() {
            self.isa.run(AnyStream {
                bvh: self,
                segments,
                blocked,
            });
        }
    }

    /// The segments between `points` and `lights`, up to 64 each, that no triangle cuts: for each
    /// point a subset of its mask in `wanted`. The masks have no bits beyond the lights.
    pub(in crate::geometry) fn open_in_tile(
        &self,
        points: &[Vec3],
        lights: &[Vec3],
        wanted: &[u64],
    ) -> [u64; SIDE] {
        let mut open = [0; SIDE];
        open[..wanted.len()].copy_from_slice(wanted);
        if !self.is_empty() && wanted.iter().any(|&lights| lights != 0) {
            open = self.isa.run(TileQuery {
                bvh: self,
                points,
                lights,
                wanted,
            });
        }
        open
    }

    pub(super) fn parts(&self) -> TreeParts<'_> {
        TreeParts {
            nodes: &self.tree.nodes,
            blocks: &self.blocks,
        }
    }
}

/// Index of triangles that are left out.
const NONE: u32 = u32::MAX;

/// Whether the corners are finite and not on a line.
fn can_be_hit(corners: &CornerRows) -> bool {
    /// Square of the sine of an angle that rounding in `f32` cannot hide.
    const CLEAR: f32 = 1e-10;
    let [a, b, c] = *corners;
    let (a, b, c) = (
        Vec4::from_array(a),
        Vec4::from_array(b),
        Vec4::from_array(c),
    );
    let (a, b, c) = (a.truncate(), b.truncate(), c.truncate());
    let (ab, ac) = (b - a, c - a);
    let normal = ab.cross(ac).length_squared();
    // False for numbers that are not finite, and if a square over- or underflows.
    if normal > CLEAR * (ab.length_squared() * ac.length_squared()) && normal < f32::INFINITY {
        return true;
    }
    let (ab, ac) = (b.as_dvec3() - a.as_dvec3(), c.as_dvec3() - a.as_dvec3());
    let are_finite = a.is_finite() && b.is_finite() && c.is_finite();
    are_finite && ab.cross(ac).length_squared() > 0.0
}

/// Kernel of the leaves of [`TriangleBvh::new`].
struct BlockOf<'b, F> {
    ids: &'b [u32],
    corners: &'b F,
}

impl<'a, F: Fn(u32) -> &'a CornerRows> SimdKernel for BlockOf<'_, F> {
    type Output = TriangleBlock;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> TriangleBlock {
        TriangleBlock::new(s, self.ids, self.corners)
    }
}

/// Kernel of [`TriangleBvh::nearest`].
struct NearestQuery<'a> {
    bvh: &'a TriangleBvh,
    ray: &'a Ray,
}

impl SimdKernel for NearestQuery<'_> {
    type Output = Option<TriangleHit>;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Self::Output {
        let (Ray { o, d, t_max }, nodes) = (*self.ray, &self.bvh.tree.nodes);
        let best = NearestHit::none(t_max);
        let mut leaves = NearestTriangle::new(&self.bvh.blocks, Sheared::new(o, d), best);
        let slabs = BoxRay::new(o, traverse::slab_reciprocal(d));
        traverse::nearest(s, nodes, 0, &slabs, best.reach(), &mut leaves);
        leaves.best.hit()
    }
}

/// Kernel of [`TriangleBvh::visit`].
struct EachQuery<'a, V> {
    bvh: &'a TriangleBvh,
    ray: &'a Ray,
    visit: V,
}

impl<V: FnMut(TriangleHit) -> bool> SimdKernel for EachQuery<'_, V> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> bool {
        let (ray, nodes) = (self.ray, &self.bvh.tree.nodes);
        let mut leaves = EachTriangle::new(&self.bvh.blocks, ray, self.visit);
        let slabs = BoxRay::new(ray.o, traverse::slab_reciprocal(ray.d));
        traverse::nearest(s, nodes, 0, &slabs, ray.t_max, &mut leaves);
        leaves.ended
    }
}

/// Kernel of [`TriangleBvh::any`].
struct AnyQuery<'a> {
    bvh: &'a TriangleBvh,
    from: Vec3,
    d: Vec3,
}

impl SimdKernel for AnyQuery<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> bool {
        let leaves = AnyTriangle::new(&self.bvh.blocks, self.from, self.d);
        let slabs = BoxRay::new(self.from, traverse::slab_reciprocal(self.d));
        traverse::any(s, &self.bvh.tree.nodes, 0, &slabs, &leaves)
    }
}

/// Kernel of [`TriangleBvh::nearest_stream`].
struct NearestStream<'a, F> {
    bvh: &'a TriangleBvh,
    rays: &'a [Ray],
    found: F,
}

impl<F: FnMut(&[u32], &LaneHits)> SimdKernel for NearestStream<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        stream::nearest_stream(s, self.bvh.parts(), self.rays, self.found);
    }
}

/// Kernel of [`TriangleBvh::any_stream`].
struct AnyStream<'a> {
    bvh: &'a TriangleBvh,
    segments: &'a [Segment],
    blocked: &'a mut [bool],
}

impl SimdKernel for AnyStream<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        stream::any_stream(s, self.bvh.parts(), self.segments, self.blocked);
    }
}

/// Kernel of [`TriangleBvh::open_in_tile`].
struct TileQuery<'a> {
    bvh: &'a TriangleBvh,
    points: &'a [Vec3],
    lights: &'a [Vec3],
    wanted: &'a [u64],
}

impl SimdKernel for TileQuery<'_> {
    type Output = [u64; SIDE];

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> [u64; SIDE] {
        VisibilityTile::new(s, self.bvh.parts(), (self.points, self.lights), self.wanted).trace(s)
    }
}
