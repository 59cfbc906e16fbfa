//! Sixteen rays in lanes, prepared for tests of boxes and triangles.
//!
//! The rays are of one [`class`], so that near planes and the axes of the shear are the same for all. Every lane has the operations of
//! [`BoxRay`] and [`Sheared`] in the same order, so that a ray has the same bits in a lane as alone.

use super::beam::Beam;
use super::node::WideNode;
use super::traverse::{self, BoxRay, FAR_MARGIN, ORIGIN_MARGIN};
use super::triangle_block::TriangleBlock;
use super::watertight::{Crossing, Sheared, Sides, axes_before, main_axis, shear_corner};
use crate::math::Vec3;
use crate::simd::{NARROW, WIDE, Wide};

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
pub(super) struct Lanes(pub(super) [f32; WIDE]);

impl Lanes {
    pub(super) const ZERO: Self = Lanes([0.0; WIDE]);
}

#[inline(always)]
fn load3<W: Wide>(w: W, lanes: &[Lanes; 3]) -> [W::F; 3] {
    [
        w.load(&lanes[0].0),
        w.load(&lanes[1].0),
        w.load(&lanes[2].0),
    ]
}

/// Sixteen rays of one class.
pub(super) struct RayLanes {
    /// The region around the rays.
    pub(super) beam: Beam,
    octant: usize,
    axes: [usize; 3],
    /// See [`BoxRay`].
    near_scale: [Lanes; 3],
    near_shift: [Lanes; 3],
    far_scale: [Lanes; 3],
    far_shift: [Lanes; 3],
    /// See [`Sheared`].
    o: [Lanes; 3],
    shear: [Lanes; 2],
    reciprocal: Lanes,
}

impl RayLanes {
    /// The rays with origins `o` and directions `d`, all of `class`. Unused lanes repeat a used one.
    #[inline(always)]
    pub(super) fn new<W: Wide>(w: W, class: usize, o: &[Lanes; 3], d: &[Lanes; 3]) -> Self {
        let octant = class / 3;
        let axes = axes_before(class % 3);
        let one = w.splat(1.0);
        let (origin, direction) = (load3(w, o), load3(w, d));
        let largest = w.max(
            w.max(w.abs(direction[0]), w.abs(direction[1])),
            w.abs(direction[2]),
        );
        let tiny = w.max(
            w.mul(largest, w.splat(traverse::NEGLIGIBLE)),
            w.splat(f32::MIN_POSITIVE),
        );
        let store = |x: W::F| Lanes(w.store(x));
        let mut scale = [Lanes::ZERO; 3];
        for axis in 0..3 {
            // As in `traverse::slab_reciprocal`.
            let size = w.max(w.abs(direction[axis]), tiny);
            scale[axis] = store(w.div(one, w.mul_sign(size, direction[axis])));
        }
        let mut lanes = RayLanes {
            beam: Beam::new(octant, o, &scale),
            octant,
            axes,
            near_scale: scale,
            near_shift: [Lanes::ZERO; 3],
            far_scale: [Lanes::ZERO; 3],
            far_shift: [Lanes::ZERO; 3],
            o: [o[axes[0]], o[axes[1]], o[axes[2]]],
            shear: [Lanes::ZERO; 2],
            reciprocal: Lanes::ZERO,
        };
        for (axis, &origin) in origin.iter().enumerate() {
            // As in `BoxRay::new`.
            let scale = w.load(&lanes.near_scale[axis].0);
            let shift = w.mul(origin, scale);
            let margin = w.mul(w.abs(shift), w.splat(ORIGIN_MARGIN));
            lanes.near_shift[axis] = store(w.add(shift, margin));
            let far_margin = w.splat(FAR_MARGIN);
            lanes.far_scale[axis] = store(w.mul(scale, far_margin));
            lanes.far_shift[axis] = store(w.mul(w.sub(shift, margin), far_margin));
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
    pub(super) fn enter<W: Wide>(
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
                w.load(&self.near_scale[axis].0),
                w.load(&self.near_shift[axis].0),
            )
        };
        let far = |axis: usize| {
            w.mul_sub(
                plane(axis, !self.octant >> axis & 1),
                w.load(&self.far_scale[axis].0),
                w.load(&self.far_shift[axis].0),
            )
        };
        let enter = w.max(w.max(near(0), near(1)), w.max(near(2), w.splat(0.0)));
        let leave = w.min(w.min(far(0), far(1)), w.min(far(2), reach));
        (enter, w.bits(w.le(enter, leave)))
    }

    /// The test of triangle `place` of a block; `None` if it has none of `rays` inside.
    #[inline(always)]
    pub(super) fn cross<W: Wide>(
        &self,
        w: W,
        block: &TriangleBlock,
        place: usize,
        rays: u32,
        limit: W::F,
    ) -> Option<Crossing<WIDE, W>> {
        let o = load3(w, &self.o);
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
    fn point<W: Wide>(&self, w: W, corner: &[[f32; NARROW]; 3], place: usize) -> [W::F; 3] {
        [
            w.splat(corner[self.axes[0]][place]),
            w.splat(corner[self.axes[1]][place]),
            w.splat(corner[self.axes[2]][place]),
        ]
    }

    /// The ray of one lane.
    #[inline(always)]
    pub(super) fn single(&self, lane: usize) -> (BoxRay, Sheared) {
        let at = |lanes: &[Lanes; 3]| [lanes[0].0[lane], lanes[1].0[lane], lanes[2].0[lane]];
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
            o: [self.o[0].0[lane], self.o[1].0[lane], self.o[2].0[lane]],
            shear: [self.shear[0].0[lane], self.shear[1].0[lane]],
            scale: self.reciprocal.0[lane],
        }
    }
}
