//! The acceleration structures: eight-wide bounding volume hierarchies over triangles and over other objects.
//!
//! [`binary`] and [`reinsert`] make a binary tree, [`build`] widens it, [`triangles`] holds the leaves of meshes and their tests, [`traverse`] walks single rays and
//! [`packet`] up to 64 with a common origin, [`tile`] up to 64 x 64 between two groups of points. All kernels are written
//! over [`simd`](crate::simd), and run in the best instruction set that the machine has.

mod binary;
mod build;
mod packet;
mod reinsert;
mod rows;
mod shaft;
mod stack;
#[cfg(test)]
mod tests;
mod tile;
mod traverse;
mod triangles;

pub(super) use shaft::Shaft;
pub(super) use triangles::TriangleHit;

use super::Ray;
use crate::math::{Aabb, Vec3};
#[cfg(any(test, feature = "testing"))]
use crate::simd::Instructions;
use crate::simd::{Isa, NARROW, Simd, SimdKernel};
use build::{LEAF, WideNode, WideTree};
use packet::{EMPTY_STACK, Packet, RAYS, Targets};
use rayon::prelude::*;
use stack::WordStack;
use tile::{SIDE, VisibilityTile};
use traverse::{AnyLeaves, Leaves, NearestLeaves};
use triangles::{AnyTriangle, EachTriangle, NearestTriangle, TriangleBlock};

/// A hierarchy over triangles.
#[derive(Debug)]
pub(super) struct TriangleBvh {
    tree: WideTree,
    blocks: Vec<TriangleBlock>,
    isa: Isa,
}

impl TriangleBvh {
    /// Builds over the triangles given by their corners. Degenerate and non-finite ones are left out.
    pub(super) fn new(triangles: &[[Vec3; 3]]) -> Self {
        let ids: Vec<u32> = (0..triangles.len() as u32)
            .into_par_iter()
            .filter(|&id| can_be_hit(&triangles[id as usize]))
            .collect();
        let boxes: Vec<Aabb> = ids
            .par_iter()
            .map(|&id| Aabb::from_points(triangles[id as usize]))
            .collect();
        let mut tree = WideTree::new(&boxes, NARROW);
        let blocks = tree
            .leaves
            .par_windows(2)
            .map(|leaf| {
                let items = &tree.items[leaf[0] as usize..leaf[1] as usize];
                let mut lanes = [0; NARROW];
                for (lane, &item) in lanes.iter_mut().zip(items) {
                    *lane = ids[item as usize];
                }
                TriangleBlock::new(&lanes[..items.len()], triangles)
            })
            .collect();
        // The blocks hold what the leaves named.
        (tree.items, tree.leaves) = (Vec::new(), Vec::new());
        TriangleBvh {
            tree,
            blocks,
            isa: Isa::best(),
        }
    }

    /// Whether no triangle can be hit.
    pub(super) fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    /// Restricts the kernels to these instructions.
    ///
    /// # Panics
    /// If the machine lacks them.
    #[cfg(any(test, feature = "testing"))]
    pub(super) fn use_instructions(&mut self, instructions: Instructions) {
        self.isa = Isa::new(instructions).expect("the machine lacks these instructions");
    }

    /// Box around all triangles.
    pub(super) fn bounds(&self) -> Aabb {
        self.tree.bounds.unwrap_or(Aabb::EMPTY)
    }

    /// Bytes used.
    pub(super) fn bytes(&self) -> usize {
        self.tree.bytes() + size_of_val(&*self.blocks)
    }

    /// The nearest triangle with `0 < t < ray.t_max`.
    #[inline]
    pub(super) fn nearest(&self, ray: &Ray) -> Option<TriangleHit> {
        if self.is_empty() {
            None
        } else {
            self.isa.run(NearestQuery { bvh: self, ray })
        }
    }

    /// Calls `visit` for all triangles with `0 < t < ray.t_max` until it returns true; returns whether it did.
    pub(super) fn visit(&self, ray: &Ray, visit: impl FnMut(TriangleHit) -> bool) -> bool {
        !self.is_empty()
            && self.isa.run(EachQuery {
                bvh: self,
                ray,
                visit,
            })
    }

    /// Whether a triangle cuts the open segment.
    #[inline]
    pub(super) fn any(&self, from: Vec3, to: Vec3) -> bool {
        !self.is_empty()
            && self.isa.run(AnyQuery {
                bvh: self,
                from,
                d: to - from,
            })
    }

    /// [`TriangleBvh::any`] for up to 64 targets: bit `i` is the answer for `to[i]`.
    #[inline]
    pub(super) fn any_packet(&self, from: Vec3, to: &[Vec3]) -> u64 {
        if self.is_empty() || to.is_empty() {
            0
        } else {
            self.isa.run(PacketQuery {
                bvh: self,
                from,
                to,
            })
        }
    }

    /// The segments between `points` and `lights` (up to 64 each) that no triangle cuts: for each point those of its mask in
    /// `wanted`, which has no bits beyond the lights.
    pub(super) fn open_in_tile(
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

    fn parts(&self) -> (&[WideNode], &[TriangleBlock]) {
        (&self.tree.nodes, &self.blocks)
    }
}

fn can_be_hit([a, b, c]: &[Vec3; 3]) -> bool {
    let normal = (b.as_dvec3() - a.as_dvec3()).cross(c.as_dvec3() - a.as_dvec3());
    a.is_finite() && b.is_finite() && c.is_finite() && normal.length_squared() > 0.0
}

struct NearestQuery<'a> {
    bvh: &'a TriangleBvh,
    ray: &'a Ray,
}

impl SimdKernel for NearestQuery<'_> {
    type Output = Option<TriangleHit>;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Self::Output {
        let mut leaves = NearestTriangle::new(&self.bvh.blocks, self.ray);
        traverse::nearest(s, &self.bvh.tree.nodes, self.ray, &mut leaves);
        leaves.best
    }
}

struct EachQuery<'a, V> {
    bvh: &'a TriangleBvh,
    ray: &'a Ray,
    visit: V,
}

impl<V: FnMut(TriangleHit) -> bool> SimdKernel for EachQuery<'_, V> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> bool {
        let mut leaves = EachTriangle::new(&self.bvh.blocks, self.ray, self.visit);
        traverse::nearest(s, &self.bvh.tree.nodes, self.ray, &mut leaves);
        leaves.ended
    }
}

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
        let scale = traverse::slab_reciprocal(self.d);
        traverse::any(s, &self.bvh.tree.nodes, 0, self.from, scale, &leaves)
    }
}

struct PacketQuery<'a> {
    bvh: &'a TriangleBvh,
    from: Vec3,
    to: &'a [Vec3],
}

impl SimdKernel for PacketQuery<'_> {
    type Output = u64;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> u64 {
        let rays = u64::MAX >> (RAYS - self.to.len());
        let targets = Targets::new(self.to);
        let mut packet = Packet::new(s, self.bvh.parts(), self.from, &targets, rays);
        let mut stack = EMPTY_STACK;
        packet.trace(s, &mut stack, 0, rays);
        rays & !packet.open
    }
}

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

/// A hierarchy over anything with a box.
#[derive(Debug)]
pub(super) struct ObjectBvh {
    tree: WideTree,
    isa: Isa,
}

impl ObjectBvh {
    /// Builds over finite boxes.
    pub(super) fn new(boxes: &[Aabb]) -> Self {
        ObjectBvh {
            tree: WideTree::new(boxes, 1),
            isa: Isa::best(),
        }
    }

    /// Whether there is no object.
    pub(super) fn is_empty(&self) -> bool {
        self.tree.nodes.is_empty()
    }

    /// What the kernels are compiled for.
    pub(super) fn isa(&self) -> Isa {
        self.isa
    }

    /// Restricts the kernels to these instructions.
    ///
    /// # Panics
    /// If the machine lacks them.
    #[cfg(any(test, feature = "testing"))]
    pub(super) fn use_instructions(&mut self, instructions: Instructions) {
        self.isa = Isa::new(instructions).expect("the machine lacks these instructions");
    }

    /// Box around all objects.
    pub(super) fn bounds(&self) -> Aabb {
        self.tree.bounds.unwrap_or(Aabb::EMPTY)
    }

    /// Calls `visit` for the objects along the ray with their index and the distance that still counts. It notes a nearer
    /// hit if there is one, and returns its distance, or the one that it was given.
    pub(super) fn nearest(&self, ray: &Ray, visit: impl FnMut(usize, f32) -> f32) {
        if !self.is_empty() {
            self.isa.run(NearestObject {
                bvh: self,
                ray,
                visit,
            });
        }
    }

    /// Calls `visit` for the objects whose boxes meet a shaft.
    pub(super) fn visit_between(&self, shaft: &Shaft, visit: impl FnMut(usize)) {
        if !self.is_empty() {
            self.isa.run(ObjectsBetween {
                tree: &self.tree,
                shaft,
                visit,
            });
        }
    }

    /// Calls `visit` for the objects along the segment until it returns true; returns whether it did.
    pub(super) fn any(&self, from: Vec3, to: Vec3, visit: impl Fn(usize) -> bool) -> bool {
        !self.is_empty()
            && self.isa.run(AnyObject {
                bvh: self,
                from,
                d: to - from,
                visit,
            })
    }
}

struct NearestObject<'a, V> {
    bvh: &'a ObjectBvh,
    ray: &'a Ray,
    visit: V,
}

impl<V: FnMut(usize, f32) -> f32> SimdKernel for NearestObject<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, s: S) {
        let ray = self.ray;
        traverse::nearest(s, &self.bvh.tree.nodes, ray, &mut self);
    }
}

impl<V> Leaves for NearestObject<'_, V> {
    type Leaf = u32;

    #[inline(always)]
    fn all(&self) -> &[u32] {
        &self.bvh.tree.items
    }
}

impl<V: FnMut(usize, f32) -> f32, S: Simd> NearestLeaves<S> for NearestObject<'_, V> {
    #[inline(always)]
    fn visit(&mut self, _s: S, leaf: usize, t_max: f32) -> f32 {
        (self.visit)(self.bvh.tree.items[leaf] as usize, t_max)
    }
}

struct ObjectsBetween<'a, V> {
    tree: &'a WideTree,
    shaft: &'a Shaft,
    visit: V,
}

impl<V: FnMut(usize)> SimdKernel for ObjectsBetween<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, s: S) {
        let mut stack = WordStack::new();
        let mut next = Some(0);
        while let Some(word) = next {
            if word & LEAF == 0 {
                let node = &self.tree.nodes[word as usize];
                let (_, _, met) = self.shaft.cut(s, &node.bounds);
                stack.push(s, &node.children, met);
            } else {
                let leaf = (word & !LEAF) as usize;
                (self.visit)(self.tree.items[leaf] as usize);
            }
            next = stack.pop();
        }
    }
}

struct AnyObject<'a, V> {
    bvh: &'a ObjectBvh,
    from: Vec3,
    d: Vec3,
    visit: V,
}

impl<V: Fn(usize) -> bool> SimdKernel for AnyObject<'_, V> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> bool {
        let scale = traverse::slab_reciprocal(self.d);
        traverse::any(s, &self.bvh.tree.nodes, 0, self.from, scale, &self)
    }
}

impl<V> Leaves for AnyObject<'_, V> {
    type Leaf = u32;

    #[inline(always)]
    fn all(&self) -> &[u32] {
        &self.bvh.tree.items
    }
}

impl<V: Fn(usize) -> bool, S: Simd> AnyLeaves<S> for AnyObject<'_, V> {
    #[inline(always)]
    fn visit(&self, _s: S, leaf: usize) -> bool {
        (self.visit)(self.bvh.tree.items[leaf] as usize)
    }
}
