//! A kd-tree over particles: the K nearest neighbors, all within a radius, and the cheapest by a
//! metric.
//!
//! `index` builds the tree, `search` traverses it, `neighbors` selects the K nearest. All kernels
//! use sixteen lanes of the best instruction set of the machine. Memory: 16 bytes per particle for
//! position and index, and about 2 for the boxes.
//!
//! Results depend on the points only, bit for bit, for any number of threads and instruction set:
//! ties are broken by index.

mod index;
mod neighbors;
mod search;
#[cfg(test)]
mod tests;

pub use neighbors::Neighbors;

use crate::lanes::{Float, Sixteen};
use crate::math::Vec3;
use crate::particles::{Importon, Photon};
use crate::simd::{Simd, SimdKernel, set_bits};
use index::{KdBlock, KdIndex};
use neighbors::NeighborQuery;
use rayon::prelude::*;
use search::{KdVisitor, search};

/// A particle with a position.
pub trait Located {
    /// Position; must be finite.
    fn position(&self) -> Vec3;
}

impl Located for Vec3 {
    #[inline]
    fn position(&self) -> Vec3 {
        *self
    }
}

impl Located for Photon {
    #[inline]
    fn position(&self) -> Vec3 {
        self.p
    }
}

impl Located for Importon {
    #[inline]
    fn position(&self) -> Vec3 {
        self.p
    }
}

/// Particles with an index over their positions.
#[derive(Clone, Debug)]
pub struct KdTree<T> {
    items: Vec<T>,
    tree: KdIndex,
}

impl<T: Located + Sync> KdTree<T> {
    /// Builds the tree in parallel. Items keep their indices.
    pub fn build(items: Vec<T>) -> Self {
        let tree = KdIndex::build(items.len(), |i| items[i].position());
        KdTree { items, tree }
    }

    /// The tree of items in the order of [`KdTree::build_ordered`], bit for bit: nothing is sorted.
    pub fn of_ordered(items: Vec<T>) -> Self {
        let tree = KdIndex::of_ordered(items.len(), |i| items[i].position());
        KdTree { items, tree }
    }

    /// Builds the tree in parallel and sorts the items, with their indices, in the order of its
    /// leaves, so that neighbors in space are neighbors in memory.
    pub fn build_ordered(items: Vec<T>) -> Self
    where
        T: Copy + Send,
    {
        let mut tree = KdIndex::build(items.len(), |i| items[i].position());
        let items = tree
            .renumber()
            .into_par_iter()
            .map(|i| items[i as usize])
            .collect();
        KdTree { items, tree }
    }
}

impl<T> KdTree<T> {
    /// The particles, in the order of their indices.
    pub fn items(&self) -> &[T] {
        &self.items
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// Whether there are no particles.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    /// Bytes of the particles and the tree.
    pub fn bytes(&self) -> usize {
        size_of_val(self.items.as_slice()) + self.tree.bytes()
    }

    /// The particles, in the order of their indices, without the tree.
    pub fn into_items(self) -> Vec<T> {
        self.items
    }

    /// Finds the K nearest particles within `max_radius` of `p`, in m and possibly infinite; K is
    /// the size of `found`.
    #[inline]
    pub fn nearest(&self, p: Vec3, max_radius: f32, found: &mut Neighbors) {
        self.tree.isa.run(NeighborQuery {
            tree: &self.tree,
            p,
            max_radius,
            found,
        });
    }

    /// Calls `visit` with index and squared distance of every particle within `radius` of `p`.
    #[inline]
    pub fn within(&self, p: Vec3, radius: f32, mut visit: impl FnMut(u32, f32)) {
        self.tree.isa.run(BoundedQuery {
            tree: &self.tree,
            p,
            bound: radius * radius,
            visit: |index, d2, bound| {
                visit(index, d2);
                bound
            },
        });
    }

    /// Index and cost of the particle with the lowest cost, at most `max_cost`. `cost` receives
    /// index and squared distance; it returns at least the squared distance, or `None` for a
    /// particle to exclude.
    #[inline]
    pub fn cheapest(
        &self,
        p: Vec3,
        max_cost: f32,
        mut cost: impl FnMut(u32, f32) -> Option<f32>,
    ) -> Option<(u32, f32)> {
        let mut best: Option<(u32, f32)> = None;
        self.tree.isa.run(BoundedQuery {
            tree: &self.tree,
            p,
            bound: max_cost,
            visit: |index, d2, bound| {
                let Some(c) = cost(index, d2).filter(|&c| c <= bound) else {
                    return bound;
                };
                if best.is_none_or(|(b, cost)| c < cost || (c == cost && index < b)) {
                    best = Some((index, c));
                }
                c
            },
        });
        best
    }

    /// [`KdTree::cheapest`] with costs up to `max_cost(nearest, its squared distance)`, for costs of
    /// which that of the nearest particle is usually the lowest: it bounds the search.
    #[inline]
    pub fn cheapest_around(
        &self,
        p: Vec3,
        max_cost: impl FnOnce(u32, f32) -> f32,
        cost: impl Fn(u32) -> Option<f32>,
    ) -> Option<(u32, f32)> {
        let (nearest, d2) = self.cheapest(p, f32::INFINITY, |_, d2| Some(d2))?;
        let max_cost = max_cost(nearest, d2);
        let bound = cost(nearest).map_or(max_cost, |c| c.min(max_cost));
        self.cheapest(p, bound, |k, _| cost(k))
    }
}

/// Calls `visit` with index, squared distance and current bound for every point with a squared
/// distance within the bound; `visit` returns the new bound.
struct BoundedQuery<'a, V> {
    tree: &'a KdIndex,
    p: Vec3,
    bound: f32,
    visit: V,
}

impl<V: FnMut(u32, f32, f32) -> f32> SimdKernel for BoundedQuery<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let bound = self.bound.min(f32::MAX);
        search(
            s.wide(),
            self.tree,
            self.p,
            bound,
            &mut PointVisitor(self.visit),
        );
    }
}

/// Calls a function for each point of a block within the bound.
struct PointVisitor<V>(V);

impl<V: FnMut(u32, f32, f32) -> f32> KdVisitor for PointVisitor<V> {
    #[inline(always)]
    fn block<S: Sixteen>(&mut self, block: &KdBlock, d2: Float<S>, mut bound: f32) -> f32 {
        let near = d2.le(bound).bits();
        if near != 0 {
            let d2 = d2.store();
            for i in set_bits(near) {
                bound = (self.0)(block.index[i], d2[i], bound);
            }
        }
        bound
    }
}
