//! Visibility between two groups of points, among surfaces of all kinds.

use super::analytic::Analytic;
use super::bvh::Shaft;
use super::level::SurfaceClass;
pub(super) use super::ray::BLOCK;
use super::surface_set::{Object, SurfaceSet};
use super::unit_rows::{CutRow, UnitPoints};
use super::{Geometry, Segment};
use crate::math::{Aabb, Vec3};
use crate::simd::{Isa, set_bits};

/// Time to test a block against an analytic shape, in rays through all objects. Any value from 16
/// to 64 costs less than 5 % more in rooms with 30 to 3000 spheres.
const RAYS_PER_ANALYTIC: u32 = 32;

/// The same for an instance. Any value from 40 to 80 costs less than 5 % more in rooms with 10 to
/// 100 instances of 20 000 triangles.
const RAYS_PER_INSTANCE: u32 = 64;

/// Both ends of the segments of a block.
#[derive(Clone, Copy)]
pub(super) struct SegmentEnds<'a> {
    pub(super) origins: &'a [Vec3],
    pub(super) targets: &'a [Vec3],
}

/// The segments in `wanted` that a surface of the class cuts; see [`Geometry::occluded_block`].
pub(super) fn cut_segments(
    geometry: &Geometry,
    class: SurfaceClass,
    ends: SegmentEnds,
    wanted: &[u64],
) -> [u64; BLOCK] {
    let mut cut = [0; BLOCK];
    cut[..wanted.len()].copy_from_slice(wanted);
    let query = BlockQuery { geometry, class };
    let open = query.open_in_set(geometry.world.surfaces(class), ends, cut);
    for (cut, open) in cut.iter_mut().zip(open) {
        *cut &= !open;
    }
    cut
}

/// The surfaces of one class, in the world and in instances.
struct BlockQuery<'a> {
    geometry: &'a Geometry,
    class: SurfaceClass,
}

impl BlockQuery<'_> {
    /// The segments in `open` that no surface of the set cuts.
    fn open_in_set(
        &self,
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
        if favors_rays(surfaces, &between, &open) {
            self.close_by_rays(surfaces, ends, &mut open);
            return open;
        }
        surfaces.visit_objects_between(&between, |object| {
            match object {
                Object::Analytic(primitive) => {
                    let placement = &self.geometry.placements[primitive.index()];
                    if let Some(shape) = placement.analytic() {
                        close_by_analytic(surfaces.isa(), shape, ends, &mut open);
                    }
                }
                Object::Instance(index) => open = self.open_in_instance(index, ends, open),
            }
            open == [0; BLOCK]
        });
        open
    }

    /// The segments in `open` that no surface of the instance cuts.
    fn open_in_instance(
        &self,
        index: usize,
        ends: SegmentEnds,
        open: [u64; BLOCK],
    ) -> [u64; BLOCK] {
        let instance = &self.geometry.instances[index];
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
        let group = self.geometry.groups[instance.group()].surfaces(self.class);
        self.open_in_set(group, ends, open)
    }

    /// Removes the segments from `open` that objects of the set cut, by a ray for each.
    fn close_by_rays(&self, surfaces: &SurfaceSet, ends: SegmentEnds, open: &mut [u64; BLOCK]) {
        for (open, &from) in open.iter_mut().zip(ends.origins) {
            for target in set_bits(*open) {
                let to = ends.targets[target];
                if self.is_cut_by_objects(surfaces, &Segment { from, to }) {
                    *open &= !(1 << target);
                }
            }
        }
    }

    fn is_cut_by_objects(&self, surfaces: &SurfaceSet, segment: &Segment) -> bool {
        match self.class {
            SurfaceClass::Opaque => self.geometry.any_object(surfaces, segment),
            SurfaceClass::Transparent => {
                self.geometry.visit_in_set(surfaces, segment, &mut |_| true)
            }
        }
    }
}

/// Removes the segments from `open` that the shape cuts. Bit `j` of element `i` is the segment from
/// `origins[i]` to `targets[j]`.
fn close_by_analytic(isa: Isa, shape: &Analytic, ends: SegmentEnds, open: &mut [u64; BLOCK]) {
    let unit = |p: Vec3| shape.unit_from_world.transform_point3(p.as_dvec3());
    let targets = UnitPoints::new(ends.targets.iter().map(|&p| unit(p)));
    for (&origin, open) in ends.origins.iter().zip(open) {
        if *open != 0 {
            *open &= !isa.run(CutRow {
                shape: shape.shape,
                origin: unit(origin),
                targets: &targets,
                open: *open,
            });
        }
    }
}

/// Whether rays along the open segments take less time than tests of the block against all objects
/// in the shaft.
fn favors_rays(surfaces: &SurfaceSet, between: &Shaft, open: &[u64; BLOCK]) -> bool {
    let segments: u32 = open.iter().map(|targets| targets.count_ones()).sum();
    let mut rays = 0;
    surfaces.visit_objects_between(between, |object| {
        rays += match object {
            Object::Analytic(_) => RAYS_PER_ANALYTIC,
            Object::Instance(_) => RAYS_PER_INSTANCE,
        };
        rays > segments
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::tests::placed;
    use crate::geometry::{Instance, Mesh, Primitive, Shape};
    use crate::math::Affine3A;
    use crate::sampling::rng::Pcg;

    /// Spheres, and instances of a cube and a sphere, at random places between the planes x = -1
    /// and x = 1.
    fn crowd(spheres: usize, instances: usize, transparent: bool) -> Geometry {
        let mut rng = Pcg::new(3);
        let mut place = || {
            let p = Vec3::from_array(std::array::from_fn(|_| 2.0 * rng.next_f32() - 1.0));
            Affine3A::from_scale_rotation_translation(Vec3::splat(0.1), Default::default(), p)
        };
        let ball = Shape::Sphere {
            center: Vec3::ZERO,
            radius: 1.0,
        };
        let primitive = |shape, world_from_object| Primitive {
            transparent,
            ..placed(shape, world_from_object)
        };
        let mut primitives: Vec<Primitive> = (0..spheres).map(|_| primitive(0, place())).collect();
        primitives.push(primitive(0, Affine3A::IDENTITY));
        primitives.push(primitive(1, Affine3A::from_translation(Vec3::X)));
        let instances = (0..instances)
            .map(|_| Instance {
                group: 0,
                world_from_group: place(),
            })
            .collect();
        let shapes = vec![ball, Shape::Mesh(Mesh::cube())];
        let group = spheres..spheres + 2;
        Geometry::build(shapes, primitives, vec![group], instances)
    }

    #[test]
    fn rays_serve_crowds_and_blocks_a_few_objects() {
        let mut rng = Pcg::new(4);
        let mut wall = |x: f32| -> Vec<Vec3> {
            let mut across = || rng.next_f32() - 0.5;
            (0..BLOCK)
                .map(|_| Vec3::new(x, across(), across()))
                .collect()
        };
        let (origins, targets) = (wall(-2.0), wall(2.0));
        let between = Shaft::new(
            Aabb::from_points(origins.iter().copied()),
            Aabb::from_points(targets.iter().copied()),
        );
        let all = [u64::MAX; BLOCK];
        for (spheres, instances, by_rays) in [(4, 4, false), (500, 0, true), (0, 300, true)] {
            for class in [SurfaceClass::Opaque, SurfaceClass::Transparent] {
                let transparent = matches!(class, SurfaceClass::Transparent);
                let geometry = crowd(spheres, instances, transparent);
                let surfaces = geometry.world.surfaces(class);
                assert_eq!(favors_rays(surfaces, &between, &all), by_rays);
                let ends = SegmentEnds {
                    origins: &origins,
                    targets: &targets,
                };
                let cut = cut_segments(&geometry, class, ends, &all);
                let query = BlockQuery {
                    geometry: &geometry,
                    class,
                };
                let (mut wrong, mut found) = (0, 0);
                for (cut, &from) in cut.iter().zip(&origins) {
                    for (j, &to) in targets.iter().enumerate() {
                        let single = query.is_cut_by_objects(surfaces, &Segment { from, to });
                        found += u32::from(single);
                        wrong += u32::from(single != (cut >> j & 1 == 1));
                    }
                }
                assert!(wrong <= 2, "{wrong} segments differ");
                assert!((1..4096).contains(&found), "{found}");
            }
        }
    }
}
