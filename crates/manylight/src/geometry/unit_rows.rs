//! Segments from one point to many targets against a unit shape.
//!
//! Most segments miss. A conservative test of sixteen segments in `f32` against a ball or cylinder
//! around the shape comes first. The exact test in `f64` runs only for groups with a possible hit.

use super::analytic::UnitShape;
use super::block::BLOCK;
use crate::lanes::{LANES, LaneMask, Sixteen, Vector};
use crate::simd::{Simd, SimdKernel};
use glam::DVec3;

/// Margin for rounding in the distance of a segment from the shape, relative to the distance of its
/// ends. Several times the largest rounding error, which is a few epsilon.
const ROUNDING: f32 = 32.0 * f32::EPSILON;

/// Number of groups of [`LANES`] targets.
const GROUPS: usize = BLOCK / LANES;

/// Points in the space of a unit shape. Indices: group, axis, lane.
pub(super) struct UnitPoints {
    exact: [[[f64; LANES]; 3]; GROUPS],
    rounded: [[[f32; LANES]; 3]; GROUPS],
    /// Largest distance of a point from the origin, rounded to `f32`.
    farthest: f32,
}

impl UnitPoints {
    /// Up to [`BLOCK`] points; unused lanes are at the origin.
    pub(super) fn new(points: impl Iterator<Item = DVec3>) -> Self {
        let mut all = UnitPoints {
            exact: [[[0.0; LANES]; 3]; GROUPS],
            rounded: [[[0.0; LANES]; 3]; GROUPS],
            farthest: 0.0,
        };
        for (j, p) in points.enumerate() {
            for (axis, x) in p.to_array().into_iter().enumerate() {
                all.exact[j / LANES][axis][j % LANES] = x;
                all.rounded[j / LANES][axis][j % LANES] = x as f32;
            }
            all.farthest = all.farthest.max(p.as_vec3().length());
        }
        all
    }
}

/// Kernel: the segments from `origin` to the targets that a unit shape cuts, as a subset of the
/// bits of `open`.
pub(super) struct CutRow<'a> {
    pub(super) shape: UnitShape,
    pub(super) origin: DVec3,
    pub(super) targets: &'a UnitPoints,
    pub(super) open: u64,
}

impl SimdKernel for CutRow<'_> {
    type Output = u64;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> u64 {
        let s = s.wide();
        // One specialized loop per shape.
        match self.shape {
            UnitShape::Sphere => self.cut(s, UnitShape::Sphere),
            UnitShape::Disk => self.cut(s, UnitShape::Disk),
            UnitShape::Cylinder => self.cut(s, UnitShape::Cylinder),
        }
    }
}

impl CutRow<'_> {
    #[inline(always)]
    fn cut<S: Sixteen>(&self, s: S, shape: UnitShape) -> u64 {
        let mut cut = 0;
        for group in 0..GROUPS {
            let open = (self.open >> (group * LANES)) as LaneMask;
            if open != 0 && open & self.near(s, shape, group) != 0 {
                cut |= u64::from(self.cut_exactly(shape, group)) << (group * LANES);
            }
        }
        cut & self.open
    }

    /// The segments of a group that may cut the shape: a conservative test.
    #[inline(always)]
    fn near<S: Sixteen>(&self, s: S, shape: UnitShape, group: usize) -> LaneMask {
        let origin = self.origin.as_vec3();
        let margin = ROUNDING * (origin.length() + self.targets.farthest);
        let mut o = Vector::splat(s, origin);
        let mut to = Vector::load(s, &self.targets.rounded[group]);
        let between = |low: f32, high: f32| {
            let (lowest, highest) = (o.z.min(to.z), o.z.max(to.z));
            (highest.ge(low - margin) & lowest.le(high + margin)).bits() as LaneMask
        };
        let level = match shape {
            UnitShape::Sphere => LaneMask::MAX,
            UnitShape::Disk => between(0.0, 0.0),
            UnitShape::Cylinder => between(0.0, 1.0),
        };
        if shape == UnitShape::Cylinder {
            (o.z, to.z) = (o.z.same(0.0), o.z.same(0.0));
        }
        let d = to - o;
        let along = o.dot(d) / d.dot(d).max(f32::MIN_POSITIVE);
        let nearest = o + d * (0.0 - along).clamp(0.0, 1.0);
        let reach = (1.0 + margin) * (1.0 + margin);
        level & nearest.dot(nearest).le(reach).bits() as LaneMask
    }

    /// The segments of a group that the shape cuts. A plain loop that the compiler vectorizes.
    #[inline(always)]
    fn cut_exactly(&self, shape: UnitShape, group: usize) -> LaneMask {
        let [x, y, z] = &self.targets.exact[group];
        let mut cut = [0; LANES];
        for (j, cut) in cut.iter_mut().enumerate() {
            let target = DVec3::new(x[j], y[j], z[j]);
            let d = target - self.origin;
            let [near, far] = shape.meets(self.origin, d);
            let is_cut =
                shape.is_hit(self.origin, d, near, 1.0) | shape.is_hit(self.origin, d, far, 1.0);
            *cut = LaneMask::from(is_cut) << j;
        }
        cut.iter().fold(0, |bits, cut| bits | cut)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::rng::Pcg;
    use crate::simd::{Instructions, Isa};

    /// Kernel that tests all segments in `f64`.
    struct Exactly<'a>(CutRow<'a>);

    impl SimdKernel for Exactly<'_> {
        type Output = u64;

        #[inline(always)]
        fn run<S: Simd>(self, _: S) -> u64 {
            let all = (0..GROUPS)
                .map(|group| u64::from(self.0.cut_exactly(self.0.shape, group)) << (group * LANES));
            all.sum::<u64>() & self.0.open
        }
    }

    /// Segments at all distances that graze the shapes: the conservative test never excludes a
    /// segment that the exact test finds.
    #[test]
    fn the_conservative_test_misses_no_hit() {
        let mut random = Pcg::new(3);
        let mut number = || f64::from(random.next_f32()) * 2.0 - 1.0;
        let mut vector = || DVec3::new(number(), number(), number());
        for shape in [UnitShape::Sphere, UnitShape::Disk, UnitShape::Cylinder] {
            let mut some = [0; 2];
            for trial in 0..600 {
                let far = 10f64.powi(trial % 8);
                let origin = vector() * far;
                // Segments through points near the rim or the surface, and beyond them.
                let through = |v: DVec3| match shape {
                    UnitShape::Sphere => v.normalize(),
                    UnitShape::Disk => v.with_z(0.0).normalize(),
                    UnitShape::Cylinder => v.with_z(0.0).normalize().with_z(v.z.abs()),
                };
                let targets = (0..BLOCK).map(|j| {
                    let grazed = through(vector()) * (1.0 + 1e-4 * vector().x);
                    origin + (grazed - origin) * (0.9 + 0.2 * j as f64)
                });
                let targets = UnitPoints::new(targets);
                let row = CutRow {
                    shape,
                    origin,
                    targets: &targets,
                    open: u64::MAX,
                };
                for isa in Instructions::available().into_iter().filter_map(Isa::new) {
                    let exact = isa.run(Exactly(CutRow { ..row }));
                    let cut = isa.run(CutRow { ..row });
                    assert_eq!(cut, exact, "{shape:?} from {origin}");
                    some[0] += cut.count_ones();
                    some[1] += cut.count_zeros();
                }
            }
            assert!(some.iter().all(|&count| count > 1000), "{shape:?} {some:?}");
        }
    }
}
