//! The points, or the lights, of a visibility tile in groups of sixteen.

use crate::geometry::bvh::shaft::middle_and_half;
use crate::lanes::{LANES, Sixteen, Vector};
use crate::math::{Aabb, Vec3, Vec3A};

/// Largest number of points, and of lights, in a tile.
pub(in crate::geometry::bvh) const SIDE: usize = 64;

/// Number of groups of [`LANES`] among [`SIDE`].
pub(super) const GROUPS: usize = SIDE / LANES;

/// The points, or the lights, of a tile.
pub(super) struct EndGroups {
    /// Indices: group, axis, lane. Unused lanes repeat a used point of the group.
    pub(super) p: [[[f32; LANES]; 3]; GROUPS],
    /// Bounding box of the used points of each group.
    pub(super) bounds: [Aabb; GROUPS],
    /// Bounding box of all used points.
    pub(super) all: Aabb,
}

impl EndGroups {
    #[inline(always)]
    pub(super) fn new(points: &[Vec3], used: u64) -> Self {
        let any = points[used.trailing_zeros() as usize % SIDE];
        let mut ends = EndGroups {
            p: [[[0.0; LANES]; 3]; GROUPS],
            bounds: [Aabb::EMPTY; GROUPS],
            all: Aabb::EMPTY,
        };
        for group in 0..GROUPS {
            let used = used >> (LANES * group) & 0xffff;
            let members = &points[(LANES * group).min(points.len())..];
            let some = if used == 0 {
                any
            } else {
                members[used.trailing_zeros() as usize % LANES]
            };
            let (mut min, mut max) = (Vec3A::from(some), Vec3A::from(some));
            for lane in 0..LANES {
                let member = members.get(lane).filter(|_| used >> lane & 1 == 1);
                let p = member.copied().unwrap_or(some);
                (min, max) = (min.min(p.into()), max.max(p.into()));
                let [x, y, z] = &mut ends.p[group];
                (x[lane], y[lane], z[lane]) = (p.x, p.y, p.z);
            }
            ends.bounds[group] = Aabb {
                min: min.into(),
                max: max.into(),
            };
            ends.all = ends.all.union(ends.bounds[group]);
        }
        ends
    }

    /// Mean half extents of the groups.
    pub(super) fn mean_half(&self) -> Vec3 {
        let sum = |sum: Vec3, b: &Aabb| sum + b.extent();
        self.bounds.iter().fold(Vec3::ZERO, sum) * (0.5 / GROUPS as f32)
    }

    #[inline(always)]
    pub(super) fn move_by<S: Sixteen>(&mut self, s: S, by: Vec3) {
        for group in &mut self.p {
            *group = (Vector::load(s, group) + Vector::splat(s, by)).store();
        }
    }
}

/// Centers and half extents of boxes, in lanes.
pub(super) struct Boxes<const N: usize> {
    pub(super) middle: [[f32; N]; 3],
    pub(super) half: [[f32; N]; 3],
}

/// The boxes of the groups `group(lane)`, relative to `origin`.
pub(super) fn boxes(
    ends: &EndGroups,
    origin: Vec3,
    group: impl Fn(usize) -> usize,
) -> Boxes<LANES> {
    let mut boxes = Boxes {
        middle: [[0.0; LANES]; 3],
        half: [[0.0; LANES]; 3],
    };
    for lane in 0..LANES {
        let (middle, half) = middle_and_half(&ends.bounds[group(lane)]);
        let middle = middle - origin;
        for axis in 0..3 {
            boxes.middle[axis][lane] = middle[axis];
            boxes.half[axis][lane] = half[axis];
        }
    }
    boxes
}
