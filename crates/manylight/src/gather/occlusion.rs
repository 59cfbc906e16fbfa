//! Boxes that one flat surface hides from all points of a group: their lights need no shadow rays.

use super::points::Batch;
use crate::geometry::{Occluder, Ray};
use crate::lanes::{Sixteen, Vector};
use crate::math::{Aabb, Vec3};
use crate::scene::Scene;

/// Surfaces that are tried first: those that have hidden a box most recently. At 4 and 16 (a pass
/// of 4096 lights at 72x40, 3 seeds; Glossy Room, Kitchen): the same picture.
const RECENT: usize = 8;
/// Least sine of the angle between a segment and a surface that hides it: at smaller angles, a
/// segment may pass between the triangles of the surface. At 0.005 and 0.02 (a pass of 4096 lights
/// at 72x40, 3 seeds; Glossy Room, Kitchen): pictures differ by at most 0.1 % (RMS).
const GRAZING: f32 = 0.01;
/// Distance from a surface, in offsets of shadow rays, within which a point lies on it. At 2 and 8
/// (a pass of 4096 lights at 72x40, 3 seeds; Glossy Room, Kitchen): relMSE 0 and 0 %.
const OFFSETS: f32 = 4.0;

/// Surfaces that hide boxes from the points of some batches.
pub(super) struct Occluders<'a> {
    scene: &'a Scene,
    batches: &'a [Batch<'a, 'a>],
    /// The most recent first.
    recent: Vec<Occluder>,
    /// Distance from a surface within which a point lies on it, in m.
    margin: f32,
}

impl<'a> Occluders<'a> {
    pub(super) fn new(scene: &'a Scene, batches: &'a [Batch<'a, 'a>]) -> Self {
        let offset = |batch: &Batch| {
            let points = 0..batch.members.len();
            let offsets = points.map(|i| batch.origins[0][i].distance(batch.p.vec(i)));
            offsets.fold(0.0, f32::max)
        };
        Occluders {
            scene,
            batches,
            recent: Vec::with_capacity(RECENT + 1),
            margin: OFFSETS * batches.iter().map(offset).fold(0.0, f32::max),
        }
    }

    /// Whether a recent surface, or the one that a ray to `target` meets, hides all of the box
    /// `bounds` from all points.
    #[inline(always)]
    pub(super) fn hide<S: Sixteen>(&mut self, s: S, bounds: &Aabb, target: Vec3) -> bool {
        let corners = bounds.corners();
        for k in 0..self.recent.len() {
            if self.hides(s, &self.recent[k], &corners) {
                self.recent[..=k].rotate_right(1);
                return true;
            }
        }
        let Some(occluder) = self.surface_towards(target) else {
            return false;
        };
        if !self.hides(s, &occluder, &corners) {
            return false;
        }
        self.recent.insert(0, occluder);
        self.recent.truncate(RECENT);
        true
    }

    /// The surface that a ray from one of the points to `target` meets.
    fn surface_towards(&self, target: Vec3) -> Option<Occluder> {
        let batch = &self.batches[0];
        let to = target - batch.p.vec(0);
        let side = usize::from(to.dot(batch.ng.vec(0)) < 0.0);
        let o = batch.origins[side][0];
        let ray = Ray {
            o,
            d: target - o,
            t_max: 1.0,
        };
        let geometry = &self.scene.geometry;
        Occluder::at(geometry, geometry.intersect(&ray)?.at)
    }

    /// Whether `occluder` lies between each point and the box with these corners. A convex surface
    /// that meets the segments to all corners meets those to all points of the box.
    #[inline(always)]
    fn hides<S: Sixteen>(&self, s: S, occluder: &Occluder, corners: &[Vec3; 8]) -> bool {
        let n = Vector::splat(s, occluder.n);
        for &corner in corners {
            let beyond = occluder.n.dot(corner) - occluder.offset;
            if beyond.abs() <= self.margin {
                return false;
            }
            for batch in self.batches {
                let p = batch.p.vectors(s);
                let to = batch.towards(s, corner);
                let before = n.dot(p) - occluder.offset;
                let across = before - beyond;
                let at = p + to * (before / across);
                let opposite = before.mul_sign(before.same(-beyond));
                let mut hidden = opposite.gt(self.margin);
                let least = to.length_squared() * (GRAZING * GRAZING);
                hidden = hidden & (across * across).gt(least);
                for (inwards, least) in occluder.edges {
                    let inside = Vector::splat(s, inwards).dot(at);
                    hidden = hidden & inside.ge(least + self.margin);
                }
                // Unused lanes repeat a point.
                if !hidden.all() {
                    return false;
                }
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{PASS, points};
    use super::*;
    use crate::gather::points::BATCHES;
    use crate::geometry::Segment;
    use crate::sampling::Stream;
    use crate::simd::{self, Isa, Simd};
    use crate::testing::scenes::{diffuse, glossy_box};

    /// Finds the boxes that are hidden from each group of points.
    struct Hide<'a> {
        scene: &'a Scene,
        groups: &'a [&'a [Batch<'a, 'a>]],
        boxes: &'a [Aabb],
    }

    impl simd::SimdKernel for Hide<'_> {
        type Output = Vec<(usize, usize)>;

        #[inline(always)]
        fn run<I: Simd>(self, isa: I) -> Self::Output {
            let mut hidden = Vec::new();
            for (g, &batches) in self.groups.iter().enumerate() {
                let mut occluders = Occluders::new(self.scene, batches);
                for (k, bounds) in self.boxes.iter().enumerate() {
                    if occluders.hide(isa.wide(), bounds, bounds.center()) {
                        hidden.push((g, k));
                    }
                }
            }
            hidden
        }
    }

    #[test]
    fn what_is_hidden_is_seen_from_no_point() {
        let mut b = glossy_box(24);
        let wall = b.material(diffuse(0.5, 0.5, 0.5));
        b.rectangle(
            Vec3::new(0.1, 0.0, 0.1),
            Vec3::new(0.8, 0.0, 0.3),
            Vec3::Y * 0.9,
            wall,
            None,
        );
        let scene = b.build();
        let points = points(&scene, false);
        let batches = Batch::all(&points);
        let groups: Vec<&[Batch]> = batches.chunks(BATCHES).collect();
        let mut sampler = PASS.sampler(Stream::Test, 0);
        let mut in_room = |size: f32| {
            let [x, y, z] = std::array::from_fn(|_| (2.0 * sampler.next_1d() - 1.0) * size);
            Vec3::new(x, y, z)
        };
        let boxes: Vec<Aabb> = (0..4000)
            .map(|_| {
                let center = in_room(0.95);
                Aabb::from_points([center + in_room(0.03), center + in_room(0.03)])
            })
            .collect();
        let hidden = Isa::best().run(Hide {
            scene: &scene,
            groups: &groups,
            boxes: &boxes,
        });
        assert!(hidden.len() > 1000, "only {} are hidden", hidden.len());
        for (g, k) in hidden {
            let bounds = &boxes[k];
            for batch in groups[g] {
                for i in 0..batch.members.len() {
                    let u = Vec3::from(std::array::from_fn(|_| sampler.next_1d()));
                    let to = bounds.min + u * bounds.extent();
                    let side = usize::from((to - batch.p.vec(i)).dot(batch.ng.vec(i)) < 0.0);
                    let from = batch.origins[side][i];
                    let segment = Segment { from, to };
                    assert!(
                        scene.geometry.occluded(&segment),
                        "{segment:?} in {bounds:?}"
                    );
                }
            }
        }
    }
}
