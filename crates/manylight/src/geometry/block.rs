//! Visibility between two groups of points, through surfaces of all kinds.

use super::Shaft;
use super::surface_set::{Object, SurfaceSet};
use super::world::{Class, Geometry};
use crate::math::{Aabb, Vec3};

/// Most origins and most targets of a block.
pub const BLOCK: usize = 64;

/// The two groups.
#[derive(Clone, Copy)]
struct SegmentEnds<'a> {
    origins: &'a [Vec3],
    targets: &'a [Vec3],
}

impl Geometry {
    /// Visibility between up to 64 origins and up to 64 targets: bit `j` of element `i` is set when bit `j` of `wanted[i]` is and an
    /// opaque surface lies between `origins[i]` and `targets[j]`. As many `wanted` as origins. Fast where both ends are compact and
    /// neighbors stand side by side. Equal to single [`Geometry::occluded`] calls but for segments that graze an edge.
    pub fn occluded_block(
        &self,
        origins: &[Vec3],
        targets: &[Vec3],
        wanted: &[u64],
    ) -> [u64; BLOCK] {
        self.cut_block(Class::Opaque, origins, targets, wanted)
    }

    /// The same for surfaces that let light straight through: the segments on which there is one.
    pub fn crossing_block(
        &self,
        origins: &[Vec3],
        targets: &[Vec3],
        wanted: &[u64],
    ) -> [u64; BLOCK] {
        self.cut_block(Class::Transparent, origins, targets, wanted)
    }

    fn cut_block(
        &self,
        class: Class,
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

    /// Those of the segments in `open` that nothing in the surfaces cuts.
    fn open_in_set(
        &self,
        class: Class,
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
