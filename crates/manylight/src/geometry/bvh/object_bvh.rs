//! The hierarchy over objects with boxes, and the kernels that query it.

use super::build::WideTree;
use super::item_box::ItemBox;
use super::node::LEAF;
use super::shaft::Shaft;
use super::stack::WordStack;
use super::traverse::{self, AnyLeaves, BoxRay, Leaves, NearestLeaves};
use crate::geometry::Ray;
use crate::math::{Aabb, Vec3};
#[cfg(any(test, feature = "testing"))]
use crate::simd::Instructions;
use crate::simd::{Isa, Simd, SimdKernel};

/// A bounding volume hierarchy over objects with boxes, by index.
#[derive(Debug)]
pub(in crate::geometry) struct ObjectBvh {
    tree: WideTree,
    isa: Isa,
}

impl ObjectBvh {
    /// Builds the hierarchy. All boxes must be finite and not empty.
    pub(in crate::geometry) fn new(boxes: &[Aabb]) -> Self {
        let boxes = boxes.iter().zip(0..);
        let boxes = boxes
            .map(|(&bounds, index)| ItemBox::new(bounds, index))
            .collect();
        ObjectBvh {
            tree: WideTree::new(boxes, 1),
            isa: Isa::best(),
        }
    }

    /// Whether there is no object.
    pub(in crate::geometry) fn is_empty(&self) -> bool {
        self.tree.nodes.is_empty()
    }

    /// Instruction set of the kernels.
    pub(in crate::geometry) fn isa(&self) -> Isa {
        self.isa
    }

    /// Runs the kernels in this instruction set.
    ///
    /// # Panics
    /// If the machine lacks the instruction set.
    #[cfg(any(test, feature = "testing"))]
    pub(in crate::geometry) fn use_instructions(&mut self, instructions: Instructions) {
        self.isa = Isa::new(instructions).expect("the machine lacks these instructions");
    }

    /// Bounding box of all objects.
    pub(in crate::geometry) fn bounds(&self) -> Aabb {
        self.tree.bounds.unwrap_or(Aabb::EMPTY)
    }

    /// Calls `visit(index, t_max)` for objects along the ray. `visit` returns the ray parameter of
    /// a hit nearer than `t_max`, or `t_max`.
    pub(in crate::geometry) fn nearest(&self, ray: &Ray, visit: impl FnMut(usize, f32) -> f32) {
        if !self.is_empty() {
            self.isa.run(NearestObject {
                bvh: self,
                ray,
                visit,
            });
        }
    }

    /// Calls `visit` for the objects with boxes that meet a shaft until it returns true; returns
    /// whether it has.
    pub(in crate::geometry) fn visit_between(
        &self,
        shaft: &Shaft,
        visit: impl FnMut(usize) -> bool,
    ) -> bool {
        !self.is_empty()
            && self.isa.run(ObjectsBetween {
                tree: &self.tree,
                shaft,
                visit,
            })
    }

    /// Calls `visit` for the objects along the segment until it returns true; returns whether it
    /// has.
    pub(in crate::geometry) fn any(
        &self,
        from: Vec3,
        to: Vec3,
        visit: impl Fn(usize) -> bool,
    ) -> bool {
        !self.is_empty()
            && self.isa.run(AnyObject {
                bvh: self,
                from,
                d: to - from,
                visit,
            })
    }
}

/// Kernel of [`ObjectBvh::nearest`].
struct NearestObject<'a, V> {
    bvh: &'a ObjectBvh,
    ray: &'a Ray,
    visit: V,
}

impl<V: FnMut(usize, f32) -> f32> SimdKernel for NearestObject<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, s: S) {
        let (ray, nodes) = (self.ray, &self.bvh.tree.nodes);
        let slabs = BoxRay::new(ray.o, traverse::slab_reciprocal(ray.d));
        traverse::nearest(s, nodes, 0, &slabs, ray.t_max, &mut self);
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

/// Kernel of [`ObjectBvh::visit_between`].
struct ObjectsBetween<'a, V> {
    tree: &'a WideTree,
    shaft: &'a Shaft,
    visit: V,
}

impl<V: FnMut(usize) -> bool> SimdKernel for ObjectsBetween<'_, V> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(mut self, s: S) -> bool {
        let mut stack = WordStack::new();
        let mut next = Some(0);
        while let Some(word) = next {
            if word & LEAF == 0 {
                let node = &self.tree.nodes[word as usize];
                let (_, _, met) = self.shaft.cut(s, &node.bounds);
                stack.push(s, &node.children, met);
            } else {
                let leaf = (word & !LEAF) as usize;
                if (self.visit)(self.tree.items[leaf] as usize) {
                    return true;
                }
            }
            next = stack.pop();
        }
        false
    }
}

/// Kernel of [`ObjectBvh::any`].
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
        let slabs = BoxRay::new(self.from, traverse::slab_reciprocal(self.d));
        traverse::any(s, &self.bvh.tree.nodes, 0, &slabs, &self)
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
