//! A node of the wide tree: its children, and the choice among them for receivers in lanes.

use super::binary::ClusterNode;
use super::importance::{ChildBounds, MIN_RADIUS2, TreeReceivers};
use crate::lanes::{Float, LANES, Lanes, Lanes3, Mask, Vector, Width, Word};
use crate::math::Vec3;
use crate::math::float::ONE_MINUS_EPSILON;
use crate::simd::{Simd, SimdKernel};

/// Marks the index of an element in [`WideEmitterNode::content`].
pub(super) const LEAF: u32 = 1 << 31;

/// A child, as a lane of a wide node.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChildLane {
    /// Index of the wide node.
    pub(super) node: u32,
    pub(super) lane: u32,
}

/// The children of a node of the wide tree, one per lane. Unused lanes have no power.
#[derive(Clone, Debug)]
pub(super) struct WideEmitterNode {
    center: Lanes3,
    radius: Lanes,
    axis: Lanes3,
    cos_normals: Lanes,
    sin_normals: Lanes,
    cos_emission: Lanes,
    power: Lanes,
    /// Importance inside of the bounding sphere.
    inside: Lanes,
    /// Index of the child's wide node; of a leaf [`LEAF`] plus the index of the element.
    pub(super) content: [u32; LANES],
    /// Number of children.
    pub(super) count: usize,
    /// This node as a child; `None` for the root.
    pub(super) parent: Option<ChildLane>,
}

/// A child chosen per lane.
pub(super) struct ChosenChild<S: Width> {
    /// See [`WideEmitterNode::content`].
    pub(super) content: Word<S>,
    /// Not above 0 if no child emits towards the receiver.
    pub(super) probability: Float<S>,
    /// A number that is uniform in [0, 1) given the choice.
    pub(super) rest: Float<S>,
}

/// The importance of each child of a node for one receiver: its position, its normal or zero, and
/// its least cosine.
pub(super) struct ImportanceKernel<'a> {
    pub(super) node: &'a WideEmitterNode,
    pub(super) receiver: (Vec3, Vec3, f32),
}

impl SimdKernel for ImportanceKernel<'_> {
    type Output = Lanes;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Lanes {
        let s = s.wide();
        let receivers = TreeReceivers::splat(s, self.receiver);
        self.node.children(s).importance(&receivers).store()
    }
}

impl WideEmitterNode {
    /// The node with the children `children` of the binary tree.
    pub(super) fn new(
        nodes: &[ClusterNode],
        children: &[usize],
        parent: Option<ChildLane>,
    ) -> Self {
        let mut wide = WideEmitterNode {
            center: Lanes3::ZERO,
            radius: [0.0; LANES],
            axis: Lanes3::ZERO,
            cos_normals: [1.0; LANES],
            sin_normals: [0.0; LANES],
            cos_emission: [1.0; LANES],
            power: [0.0; LANES],
            inside: [0.0; LANES],
            content: [0; LANES],
            count: children.len(),
            parent,
        };
        for (lane, &child) in children.iter().enumerate() {
            let node = &nodes[child];
            wide.center.set(lane, node.center);
            wide.radius[lane] = node.radius;
            wide.axis.set(lane, node.axis);
            wide.cos_normals[lane] = node.cos_normals;
            wide.sin_normals[lane] = node.sin_normals;
            wide.cos_emission[lane] = node.cos_emission;
            wide.power[lane] = node.power;
            wide.inside[lane] = node.power / (node.radius * node.radius).max(MIN_RADIUS2);
            if node.is_leaf {
                wide.content[lane] = LEAF | node.content;
            }
        }
        wide
    }

    /// Child `i` in lane `i`.
    #[inline(always)]
    pub(super) fn children<S: Width>(&self, s: S) -> ChildBounds<S> {
        ChildBounds {
            center: each3(s, &self.center),
            radius: each(s, &self.radius),
            axis: each3(s, &self.axis),
            cos_normals: each(s, &self.cos_normals),
            sin_normals: each(s, &self.sin_normals),
            cos_emission: each(s, &self.cos_emission),
            power: each(s, &self.power),
            inside: each(s, &self.inside),
        }
    }

    /// Child `k` in all lanes.
    #[inline(always)]
    fn child<S: Width>(&self, s: S, k: usize) -> ChildBounds<S> {
        ChildBounds {
            center: Vector::splat(s, self.center.vec(k)),
            radius: Float::splat(s, self.radius[k]),
            axis: Vector::splat(s, self.axis.vec(k)),
            cos_normals: Float::splat(s, self.cos_normals[k]),
            sin_normals: Float::splat(s, self.sin_normals[k]),
            cos_emission: Float::splat(s, self.cos_emission[k]),
            power: Float::splat(s, self.power[k]),
            inside: Float::splat(s, self.inside[k]),
        }
    }

    /// The importances of the children, and their sum.
    #[inline(always)]
    fn importances<S: Width>(&self, receivers: &TreeReceivers<S>) -> ([Float<S>; LANES], Float<S>) {
        let s = receivers.min_cosine.width();
        let mut importances = [Float::splat(s, 0.0); LANES];
        let mut total = Float::splat(s, 0.0);
        for (k, importance) in importances.iter_mut().enumerate().take(self.count) {
            *importance = self.child(s, k).importance(receivers);
            total += *importance;
        }
        (importances, total)
    }

    /// A child for the receiver in each lane, in proportion to importance.
    #[inline(always)]
    pub(super) fn choose<S: Width>(
        &self,
        receivers: &TreeReceivers<S>,
        u: Float<S>,
    ) -> ChosenChild<S> {
        let s = u.width();
        let (importances, total) = self.importances(receivers);
        let target = u * total;
        let (mut end, mut before, mut importance) = (u.same(0.0), u.same(0.0), u.same(0.0));
        let mut content = Word::splat(s, 0);
        let mut is_open = Mask::splat(s, true);
        for (&of_child, &at) in importances.iter().zip(&self.content).take(self.count) {
            let start = end;
            end += of_child;
            // Rounding must not select a child without importance.
            let is_passed = end.le(target) & end.lt(total);
            let is_here = is_open & !is_passed;
            is_open = is_open & is_passed;
            before = is_here.select(start, before);
            importance = is_here.select(of_child, importance);
            content = is_here.select_words(Word::splat(s, at), content);
        }
        ChosenChild {
            content,
            probability: importance / total,
            rest: ((target - before) / importance).clamp(0.0, ONE_MINUS_EPSILON),
        }
    }

    /// The probability with which [`WideEmitterNode::choose`] chooses child `child` for the
    /// receiver in each lane.
    #[inline(always)]
    pub(super) fn probability<S: Width>(
        &self,
        receivers: &TreeReceivers<S>,
        child: Word<S>,
    ) -> Float<S> {
        let (importances, total) = self.importances(receivers);
        let mut importance = total.same(0.0);
        for (k, &of_child) in importances.iter().enumerate().take(self.count) {
            importance = child.equals(k as u32).select(of_child, importance);
        }
        importance.gt(0.0).select(importance / total, 0.0)
    }
}

#[inline(always)]
fn each<S: Width>(s: S, x: &Lanes) -> Float<S> {
    Float::from_fn(s, |i| x[i])
}

#[inline(always)]
fn each3<S: Width>(s: S, v: &Lanes3) -> Vector<S> {
    Vector::new(each(s, &v.0[0]), each(s, &v.0[1]), each(s, &v.0[2]))
}

impl<S: Width> ChosenChild<S> {
    /// `a` in the lanes of `m`, `b` elsewhere.
    #[inline(always)]
    pub(super) fn select(m: Mask<S>, a: Self, b: Self) -> Self {
        ChosenChild {
            content: m.select_words(a.content, b.content),
            probability: m.select(a.probability, b.probability),
            rest: m.select(a.rest, b.rest),
        }
    }
}

/// As [`WideEmitterNode::choose`], for one receiver, by the importances of all children: the child,
/// its probability, and the rest.
#[inline(always)]
pub(super) fn choose_by(importances: &Lanes, u: f32) -> Option<(usize, f32, f32)> {
    let mut ends = [0.0; LANES];
    let mut total = 0.0;
    for (end, importance) in ends.iter_mut().zip(importances) {
        total += importance;
        *end = total;
    }
    if total <= 0.0 {
        return None;
    }
    let target = u * total;
    let mut chosen = 0;
    for end in &ends {
        chosen += u32::from((*end <= target) & (*end < total));
    }
    let chosen = chosen as usize % LANES;
    let importance = importances[chosen];
    let before = if chosen == 0 { 0.0 } else { ends[chosen - 1] };
    let rest = ((target - before) / importance).clamp(0.0, ONE_MINUS_EPSILON);
    Some((chosen, importance / total, rest))
}
