//! A kd-tree over particles: nearest neighbors and everything within a radius.
//!
//! [`tree`] builds the index, [`search`] walks it, [`neighbors`] picks the K nearest. All kernels are written over
//! [`simd`](crate::simd), and run in the best instruction set that the machine has. Costs 16 bytes per particle for positions and indices and
//! about 2 for the boxes.
//!
//! All answers are functions of the points alone, the same to the bit for any thread count and instruction set: ties are
//! broken by index.

mod neighbors;
mod search;
#[cfg(test)]
mod tests;
mod tree;

pub use neighbors::Neighbors;

use crate::math::Vec3;
use crate::particles::{Importon, Photon};
use crate::simd::{Simd, SimdKernel, Wide, set_bits};
use neighbors::Nearest;
use rayon::prelude::*;
use search::{Visit, search};
use tree::{Block, Tree};

/// Something that has a place.
pub trait Located {
    /// Where it is; must be finite.
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
    tree: Tree,
}

impl<T: Located + Sync> KdTree<T> {
    /// Builds the tree in parallel. Items keep their indices.
    pub fn build(items: Vec<T>) -> Self {
        let tree = Tree::build(items.len(), |i| items[i].position());
        KdTree { items, tree }
    }

    /// Builds the tree in parallel and puts the items in the order of its leaves, which their indices then count: whoever
    /// reads all neighbors finds them close together in memory.
    pub fn build_ordered(items: Vec<T>) -> Self
    where
        T: Copy + Send,
    {
        let mut tree = Tree::build(items.len(), |i| items[i].position());
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

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    /// Bytes of particles and tree.
    pub fn bytes(&self) -> usize {
        size_of_val(self.items.as_slice()) + self.tree.bytes()
    }

    /// Takes the particles out.
    pub fn into_items(self) -> Vec<T> {
        self.items
    }

    /// Finds the nearest particles within `max_radius` (which may be infinite) of `p`, as many as `found` keeps.
    #[inline]
    pub fn nearest(&self, p: Vec3, max_radius: f32, found: &mut Neighbors) {
        self.tree.isa.run(Nearest {
            tree: &self.tree,
            p,
            max_radius,
            found,
        });
    }

    /// Calls `visit` with index and squared distance of every particle within `radius` of `p`.
    #[inline]
    pub fn within(&self, p: Vec3, radius: f32, mut visit: impl FnMut(u32, f32)) {
        self.tree.isa.run(Search {
            tree: &self.tree,
            p,
            bound: radius * radius,
            visit: |index, d2, bound| {
                visit(index, d2);
                bound
            },
        });
    }

    /// The particle with the lowest cost, and that cost. `cost` gets index and squared distance; it must return no less
    /// than the squared distance, or `None` for a particle that must not be taken. Costs above `max_cost` do not count.
    #[inline]
    pub fn cheapest(
        &self,
        p: Vec3,
        max_cost: f32,
        mut cost: impl FnMut(u32, f32) -> Option<f32>,
    ) -> Option<(u32, f32)> {
        let mut best: Option<(u32, f32)> = None;
        self.tree.isa.run(Search {
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
}

/// Calls `visit` with index, squared distance and bound of every point within the bound, which becomes what `visit` returns.
struct Search<'a, V> {
    tree: &'a Tree,
    p: Vec3,
    bound: f32,
    visit: V,
}

impl<V: FnMut(u32, f32, f32) -> f32> SimdKernel for Search<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let bound = self.bound.min(f32::MAX);
        search(
            s.wide(),
            self.tree,
            self.p,
            bound,
            &mut EachPoint(self.visit),
        );
    }
}

struct EachPoint<V>(V);

impl<V: FnMut(u32, f32, f32) -> f32> Visit for EachPoint<V> {
    #[inline(always)]
    fn block<W: Wide>(&mut self, w: W, block: &Block, d2: W::F, mut bound: f32) -> f32 {
        let near = w.bits(w.le(d2, w.splat(bound)));
        if near != 0 {
            let d2 = w.store(d2);
            for i in set_bits(near) {
                bound = (self.0)(block.index[i], d2[i], bound);
            }
        }
        bound
    }
}
