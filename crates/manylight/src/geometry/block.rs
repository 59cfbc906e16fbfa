//! Visibility between two groups of points, among surfaces of all kinds.

use super::Geometry;
use super::Shaft;
use super::level::SurfaceClass;
use super::surface_set::{Object, SurfaceSet};
use crate::math::{Aabb, Vec3};

/// Largest number of origins, and of targets, in a block: the bits of a mask.
pub const BLOCK: usize = 64;

/// Both ends of the segments of a block.
#[derive(Clone, Copy)]
struct SegmentEnds<'a> {
    origins: &'a [Vec3],
    targets: &'a [Vec3],
}

impl Geometry {
    /// Visibility between up to [`BLOCK`] origins and up to [`BLOCK`] targets.
    ///
    /// `wanted[i]` has one bit per target and one element per origin. Bit `j` of element `i` of the result is set if bit `j` of `wanted[i]`
    /// is set and an opaque surface lies between `origins[i]` and `targets[j]`. Fastest if both groups are compact and neighbors
    /// in space are neighbors in the lists. Equal to single calls of [`Geometry::occluded`], except for segments that graze an edge.
    pub fn occluded_block(
        &self,
        origins: &[Vec3],
        targets: &[Vec3],
        wanted: &[u64],
    ) -> [u64; BLOCK] {
        self.cut_block(SurfaceClass::Opaque, origins, targets, wanted)
    }

    /// [`Geometry::occluded_block`] for transparent surfaces: the segments that cross at least one.
    pub fn crossing_block(
        &self,
        origins: &[Vec3],
        targets: &[Vec3],
        wanted: &[u64],
    ) -> [u64; BLOCK] {
        self.cut_block(SurfaceClass::Transparent, origins, targets, wanted)
    }

    fn cut_block(
        &self,
        class: SurfaceClass,
        origins: &[Vec3],
        targets: &[Vec3],
        wanted: &[u64],
    ) -> [u64; BLOCK] {
        let mut cut = [0; BLOCK];
        cut[..wanted.len()].copy_from_slice(wanted);
        let ends = SegmentEnds { origins, targets };
        let open = self.open_in_set(class, self.world.surfaces(class), ends, cut);
        for (cut, open) in cut.iter_mut().zip(open) {
            *cut &= !open;
        }
        cut
    }

    /// The segments in `open` that no surface of the set cuts.
    fn open_in_set(
        &self,
        class: SurfaceClass,
        surfaces: &SurfaceSet,
        ends: SegmentEnds,
        open: [u64; BLOCK],
    ) -> [u64; BLOCK] {
        let rows = ends.origins.len();
        let mut open = surfaces.open_of_triangles(ends.origins, ends.targets, &open[..rows]);
        if !surfaces.has_objects() || open == [0; BLOCK] {
            return open;
        }
        let between = Shaft::new(
            Aabb::from_points(ends.origins.iter().copied()),
            Aabb::from_points(ends.targets.iter().copied()),
        );
        surfaces.visit_objects_between(&between, |object| match object {
            Object::Analytic(primitive) => {
                if let Some(shape) = self.placements[primitive.index()].analytic() {
                    shape.cut_block(surfaces.isa(), ends.origins, ends.targets, &mut open);
                }
            }
            Object::Instance(index) => {
                let instance = &self.instances[index];
                let in_group = |points: &[Vec3]| {
                    let mut moved = [Vec3::ZERO; BLOCK];
                    for (moved, &p) in moved.iter_mut().zip(points) {
                        *moved = instance.point_in_group(p);
                    }
                    moved
                };
                let (origins, targets) = (in_group(ends.origins), in_group(ends.targets));
                let ends = SegmentEnds {
                    origins: &origins[..ends.origins.len()],
                    targets: &targets[..ends.targets.len()],
                };
                let group = self.groups[instance.group()].surfaces(class);
                open = self.open_in_set(class, group, ends, open);
            }
        });
        open
    }
}
