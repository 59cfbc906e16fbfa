//! Sixteen rays in lanes, prepared for tests of boxes and triangles.
//!
//! The rays are of one [`class`], so that near planes and the axes of the shear are the same for
//! all. Every lane has the operations of [`BoxRay`] and [`Sheared`] in the same order, so that a
//! ray has the same bits in a lane as alone.

use super::beam::Beam;
use super::node::WideNode;
use super::traverse::{self, BoxRay, FAR_MARGIN, ORIGIN_MARGIN, slab_reciprocals};
use super::triangle_block::TriangleBlock;
use super::watertight::{Crossing, Sheared, Sides, axes_before, main_axis, shear_corner};
use crate::lanes::{Float, LANES, Lanes3, Pair, Sixteen, Vector};
use crate::math::Vec3;
use crate::simd::NARROW;

/// Number of classes of directions.
pub(super) const CLASSES: usize = 24;

/// Class of a direction: its octant and the axis of its largest component.
#[inline(always)]
pub(super) fn class(d: Vec3) -> usize {
    3 * traverse::octant(d) + main_axis(d)
}

/// One value per lane, aligned for loads of whole vectors.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(super) struct AlignedLanes(pub(super) [f32; LANES]);

impl AlignedLanes {
    pub(super) const ZERO: Self = AlignedLanes([0.0; LANES]);

    #[inline(always)]
    pub(super) fn load<S: Sixteen>(&self, s: S) -> Float<S> {
        Float::load(s, &self.0)
    }

    #[inline(always)]
    pub(super) fn of<S: Sixteen>(x: Float<S>) -> Self {
        AlignedLanes(x.store())
    }
}

/// Sixteen rays of one class.
pub(super) struct RayLanes {
    /// The region around the rays.
    pub(super) beam: Beam,
    octant: usize,
    axes: [usize; 3],
    /// See [`BoxRay`].
    near_scale: Lanes3,
    near_shift: Lanes3,
    far_scale: Lanes3,
    far_shift: Lanes3,
    /// See [`Sheared`].
    o: Lanes3,
    shear: [AlignedLanes; 2],
    reciprocal: AlignedLanes,
}

impl RayLanes {
    /// The rays with origins `o` and directions `d`, all of `class`. Unused lanes repeat a used
    /// one.
    #[inline(always)]
    pub(super) fn new<S: Sixteen>(s: S, class: usize, o: &Lanes3, d: &Lanes3) -> Self {
        let octant = class / 3;
        let axes = axes_before(class % 3);
        let direction = Vector::load(s, &d.0);
        let scale = Lanes3(slab_reciprocals(direction).store());
        let mut lanes = RayLanes {
            beam: Beam::new(octant, o, &scale),
            octant,
            axes,
            near_scale: scale,
            near_shift: Lanes3::ZERO,
            far_scale: Lanes3::ZERO,
            far_shift: Lanes3::ZERO,
            o: Lanes3([o.0[axes[0]], o.0[axes[1]], o.0[axes[2]]]),
            shear: [AlignedLanes::ZERO; 2],
            reciprocal: AlignedLanes::ZERO,
        };
        for axis in 0..3 {
            // As in `BoxRay::new`.
            let scale = Float::load(s, &scale.0[axis]);
            let shift = Float::load(s, &o.0[axis]) * scale;
            let margin = shift.abs() * ORIGIN_MARGIN;
            lanes.near_shift.0[axis] = (shift + margin).store();
            lanes.far_scale.0[axis] = (scale * FAR_MARGIN).store();
            lanes.far_shift.0[axis] = ((shift - margin) * FAR_MARGIN).store();
        }
        // As in `Sheared::new`.
        let direction = direction.to_array();
        let reciprocal = 1.0 / direction[axes[2]];
        lanes.reciprocal = AlignedLanes::of(reciprocal);
        for i in 0..2 {
            lanes.shear[i] = AlignedLanes::of(-direction[axes[i]] * reciprocal);
        }
        lanes
    }

    /// The word of [`WideNode::order`] for the rays.
    #[inline(always)]
    pub(super) fn order(&self, node: &WideNode) -> u32 {
        node.order[self.octant % node.order.len()]
    }

    /// Ray parameters of entry into child `lane` of the node, and the lanes that enter it before
    /// `reach`.
    #[inline(always)]
    pub(super) fn enter<S: Sixteen>(
        &self,
        node: &WideNode,
        lane: usize,
        reach: Float<S>,
    ) -> (Float<S>, u32) {
        let s = reach.width();
        // As in `BoxRay::cut`.
        let plane =
            |axis: usize, is_upper: usize| Float::splat(s, node.bounds[axis + 3 * is_upper][lane]);
        let near = |axis: usize| {
            plane(axis, self.octant >> axis & 1).mul_sub(
                Float::load(s, &self.near_scale.0[axis]),
                Float::load(s, &self.near_shift.0[axis]),
            )
        };
        let far = |axis: usize| {
            plane(axis, !self.octant >> axis & 1).mul_sub(
                Float::load(s, &self.far_scale.0[axis]),
                Float::load(s, &self.far_shift.0[axis]),
            )
        };
        let enter = near(0).max(near(1)).max(near(2).max(0.0));
        let leave = far(0).min(far(1)).min(far(2).min(reach));
        (enter, enter.le(leave).bits())
    }

    /// The test of triangle `place` of a block; `None` if it has none of `rays` inside.
    #[inline(always)]
    pub(super) fn cross<S: Sixteen>(
        &self,
        block: &TriangleBlock,
        place: usize,
        rays: u32,
        limit: Float<S>,
    ) -> Option<Crossing<S>> {
        let s = limit.width();
        let o = Vector::load(s, &self.o.0);
        let shear = Pair::new(self.shear[0].load(s), self.shear[1].load(s));
        let sides = Sides::new([
            shear_corner(self.point(s, &block.corners[0], place), o, shear),
            shear_corner(self.point(s, &block.corners[1], place), o, shear),
            shear_corner(self.point(s, &block.corners[2], place), o, shear),
        ]);
        // Not a closure, which would not be inlined.
        if sides.inside.bits() & rays == 0 {
            None
        } else {
            Some(sides.crossing(self.reciprocal.load(s), limit))
        }
    }

    /// A corner of triangle `place` in all lanes, with permuted axes.
    #[inline(always)]
    fn point<S: Sixteen>(&self, s: S, corner: &[[f32; NARROW]; 3], place: usize) -> Vector<S> {
        let [x, y, z] = self.axes;
        let at = Vec3::new(corner[x][place], corner[y][place], corner[z][place]);
        Vector::splat(s, at)
    }

    /// The ray of one lane.
    #[inline(always)]
    pub(super) fn single(&self, lane: usize) -> (BoxRay, Sheared) {
        let at = |lanes: &Lanes3| lanes.vec(lane).to_array();
        let slabs = BoxRay {
            near_scale: at(&self.near_scale),
            near_shift: at(&self.near_shift),
            far_scale: at(&self.far_scale),
            far_shift: at(&self.far_shift),
            octant: self.octant,
        };
        (slabs, self.sheared(lane))
    }

    /// The shear of the ray of one lane.
    #[inline(always)]
    pub(super) fn sheared(&self, lane: usize) -> Sheared {
        Sheared {
            axes: self.axes,
            o: self.o.vec(lane).to_array(),
            shear: [self.shear[0].0[lane], self.shear[1].0[lane]],
            scale: self.reciprocal.0[lane],
        }
    }
}
