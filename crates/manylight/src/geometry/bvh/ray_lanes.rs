//! Sixteen rays in lanes, prepared for tests of boxes and triangles.
//!
//! The rays are of one [`class`], so that near planes and the axes of the shear are the same for all. Every lane has the operations of
//! [`BoxRay`] and [`Sheared`] in the same order, so that a ray has the same bits in a lane as alone.

use super::beam::Beam;
use super::node::WideNode;
use super::traverse::{self, BoxRay, FAR_MARGIN, ORIGIN_MARGIN};
use super::triangle_block::TriangleBlock;
use super::watertight::{Crossing, Sheared, Sides, axes_before, main_axis, shear_corner};
use crate::lanes::Lanes3;
use crate::math::Vec3;
use crate::simd::{LANES, NARROW, Sixteen};

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
    /// The rays with origins `o` and directions `d`, all of `class`. Unused lanes repeat a used one.
    #[inline(always)]
    pub(super) fn new<W: Sixteen>(w: W, class: usize, o: &Lanes3, d: &Lanes3) -> Self {
        let octant = class / 3;
        let axes = axes_before(class % 3);
        let one = w.splat(1.0);
        let (origin, direction) = (o.load(w), d.load(w));
        let largest = w.max(
            w.max(w.abs(direction[0]), w.abs(direction[1])),
            w.abs(direction[2]),
        );
        let tiny = w.max(
            w.mul(largest, w.splat(traverse::NEGLIGIBLE)),
            w.splat(f32::MIN_POSITIVE),
        );
        let store = |x: W::F| AlignedLanes(w.store(x));
        let mut scale = Lanes3::ZERO;
        for (scale, &direction) in scale.0.iter_mut().zip(&direction) {
            // As in `traverse::slab_reciprocal`.
            let size = w.max(w.abs(direction), tiny);
            *scale = w.store(w.div(one, w.mul_sign(size, direction)));
        }
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
        for (axis, &origin) in origin.iter().enumerate() {
            // As in `BoxRay::new`.
            let scale = w.load(&lanes.near_scale.0[axis]);
            let shift = w.mul(origin, scale);
            let margin = w.mul(w.abs(shift), w.splat(ORIGIN_MARGIN));
            lanes.near_shift.0[axis] = w.store(w.add(shift, margin));
            let far_margin = w.splat(FAR_MARGIN);
            lanes.far_scale.0[axis] = w.store(w.mul(scale, far_margin));
            lanes.far_shift.0[axis] = w.store(w.mul(w.sub(shift, margin), far_margin));
        }
        // As in `Sheared::new`.
        let reciprocal = w.div(one, direction[axes[2]]);
        lanes.reciprocal = store(reciprocal);
        for i in 0..2 {
            let reversed = w.mul_sign(direction[axes[i]], w.splat(-1.0));
            lanes.shear[i] = store(w.mul(reversed, reciprocal));
        }
        lanes
    }

    /// The word of [`WideNode::order`] for the rays.
    #[inline(always)]
    pub(super) fn order(&self, node: &WideNode) -> u32 {
        node.order[self.octant % node.order.len()]
    }

    /// Ray parameters of entry into child `lane` of the node, and the lanes that enter it before `reach`.
    #[inline(always)]
    pub(super) fn enter<W: Sixteen>(
        &self,
        w: W,
        node: &WideNode,
        lane: usize,
        reach: W::F,
    ) -> (W::F, u32) {
        // As in `BoxRay::cut`.
        let plane = |axis: usize, is_upper: usize| w.splat(node.bounds[axis + 3 * is_upper][lane]);
        let near = |axis: usize| {
            w.mul_sub(
                plane(axis, self.octant >> axis & 1),
                w.load(&self.near_scale.0[axis]),
                w.load(&self.near_shift.0[axis]),
            )
        };
        let far = |axis: usize| {
            w.mul_sub(
                plane(axis, !self.octant >> axis & 1),
                w.load(&self.far_scale.0[axis]),
                w.load(&self.far_shift.0[axis]),
            )
        };
        let enter = w.max(w.max(near(0), near(1)), w.max(near(2), w.splat(0.0)));
        let leave = w.min(w.min(far(0), far(1)), w.min(far(2), reach));
        (enter, w.bits(w.le(enter, leave)))
    }

    /// The test of triangle `place` of a block; `None` if it has none of `rays` inside.
    #[inline(always)]
    pub(super) fn cross<W: Sixteen>(
        &self,
        w: W,
        block: &TriangleBlock,
        place: usize,
        rays: u32,
        limit: W::F,
    ) -> Option<Crossing<W>> {
        let o = self.o.load(w);
        let shear = [w.load(&self.shear[0].0), w.load(&self.shear[1].0)];
        let corners = [
            shear_corner(w, self.point(w, &block.corners[0], place), o, shear),
            shear_corner(w, self.point(w, &block.corners[1], place), o, shear),
            shear_corner(w, self.point(w, &block.corners[2], place), o, shear),
        ];
        let sides = Sides::new(w, corners);
        // Not a closure, which would not be inlined.
        if w.bits(sides.inside) & rays == 0 {
            None
        } else {
            Some(sides.crossing(w, w.load(&self.reciprocal.0), limit))
        }
    }

    /// A corner of triangle `place` in all lanes, with permuted axes.
    #[inline(always)]
    fn point<W: Sixteen>(&self, w: W, corner: &[[f32; NARROW]; 3], place: usize) -> [W::F; 3] {
        [
            w.splat(corner[self.axes[0]][place]),
            w.splat(corner[self.axes[1]][place]),
            w.splat(corner[self.axes[2]][place]),
        ]
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
