//! Queries of a mixed scene against single primitives, and blocks against single segments.

use super::*;
use crate::simd::Instructions;
use std::f32::consts::TAU;

/// A scene with opaque and transparent meshes and analytic shapes, and instances of them.
pub(super) fn mixed() -> Geometry {
    let mut random = Random(Pcg::new(4));
    let shapes = vec![
        Shape::Mesh(soup(&mut random, 60)),
        ball(),
        Shape::Disk,
        pipe(),
        Shape::Mesh(Mesh::cube()),
    ];
    let mut place = |i: usize| {
        let turn = Quat::from_axis_angle(random.point(1.0).normalize(), random.number() * TAU);
        let transform = Affine3A::from_scale_rotation_translation(
            Vec3::splat(0.2 + 0.3 * random.number()),
            turn,
            random.point(2.0),
        );
        Primitive {
            transparent: i.is_multiple_of(3),
            ..placed((i % 5) as u32, transform)
        }
    };
    let primitives: Vec<Primitive> = (0..42).map(&mut place).collect();
    let instances = (0..12)
        .map(|i| Instance {
            group: i % 2,
            world_from_group: place(0).world_from_object,
        })
        .collect();
    Geometry::build(shapes, primitives, vec![20..30, 30..42], instances)
}

/// The nearest hit among single primitives and instances, each in a scene of one primitive.
fn one_by_one(geometry: &Geometry, ray: &Ray, transparent: bool) -> Option<Hit> {
    let parts = geometry
        .primitives()
        .iter()
        .enumerate()
        .filter(|(_, p)| p.transparent == transparent);
    let mut best: Option<Hit> = None;
    let mut keep = |hit: Hit| best = Some(best.filter(|b| b.t <= hit.t).unwrap_or(hit));
    for (i, primitive) in parts {
        let single = Geometry::build(
            geometry.shapes().to_vec(),
            vec![primitive.clone()],
            vec![],
            vec![],
        );
        let name = |hit: Hit, instance| Hit {
            at: SurfaceRef {
                primitive: PrimitiveId::from(i),
                instance,
                ..hit.at
            },
            ..hit
        };
        if i < 20 {
            single
                .intersect(ray)
                .into_iter()
                .for_each(|hit| keep(name(hit, SurfaceRef::NO_INSTANCE)));
        }
        let group = if i < 20 { 2 } else { usize::from(i >= 30) };
        for (index, instance) in geometry
            .instances
            .iter()
            .enumerate()
            .filter(|(_, p)| p.group() == group)
        {
            let local = instance.ray_in_group(ray);
            single
                .intersect(&local)
                .into_iter()
                .for_each(|hit| keep(name(hit, index as u32)));
        }
    }
    best
}

fn nearest_transparent(geometry: &Geometry, ray: &Ray) -> Option<Hit> {
    let mut best: Option<Hit> = None;
    let segment = Segment {
        from: ray.o,
        to: ray.o + ray.d * ray.t_max,
    };
    geometry.visit_transparent(&segment, |hit| {
        if best.is_none_or(|best| hit.t < best.t) {
            best = Some(hit);
        }
        false
    });
    best
}

#[test]
fn hierarchies_agree_with_single_primitives() {
    let geometry = mixed();
    let mut random = Random(Pcg::new(5));
    let element = |hit: Hit| (hit.at.primitive, hit.at.element, hit.at.instance);
    assert!(geometry.has_transparent());
    for _ in 0..60 {
        let o = random.point(3.0);
        let ray = Ray {
            t_max: 4.0,
            ..Ray::new(o, (random.point(1.5) - o).normalize())
        };
        let opaque = one_by_one(&geometry, &ray, false);
        let transparent = one_by_one(&geometry, &ray, true);
        assert_eq!(
            nearest_transparent(&geometry, &ray).map(element),
            transparent.map(element)
        );
        let nearest = match (opaque, transparent) {
            (Some(a), Some(b)) => Some(if b.t < a.t { b } else { a }),
            (a, b) => a.or(b),
        };
        assert_eq!(
            geometry.intersect(&ray).map(|hit| hit.at),
            nearest.map(|hit| hit.at)
        );
        assert_eq!(
            geometry.occluded(&Segment {
                from: ray.o,
                to: ray.at(4.0)
            }),
            opaque.is_some()
        );
        if let Some(hit) = nearest {
            let x = geometry.surface_point(hit.at);
            assert!((x.p - ray.at(hit.t)).length() < 1e-4, "{hit:?}");
            assert!(geometry.bounds().distance_squared(x.p) == 0.0);
        }
    }
}

#[test]
fn blocks_equal_single_segments() {
    let mut geometry = mixed();
    for instructions in Instructions::available() {
        geometry.use_instructions(instructions);
        compare_blocks_with_single_segments(&geometry);
    }
}

fn compare_blocks_with_single_segments(geometry: &Geometry) {
    let mut random = Random(Pcg::new(7));
    let (mut crossings, mut grazing) = (0, 0);
    for (origins, targets) in [(0, 0), (1, 64), (64, 1), (33, 17), (64, 64)] {
        for _ in 0..5 {
            let from: Vec<Vec3> = (0..origins).map(|_| random.point(3.0)).collect();
            let to: Vec<Vec3> = (0..targets).map(|_| random.point(3.0)).collect();
            let wanted: Vec<u64> = (0..origins)
                .map(|i| (u64::MAX >> i) & (((1u128 << targets) - 1) as u64))
                .collect();
            let blocked = geometry.occluded_block(&from, &to, &wanted);
            let crossing = geometry.crossing_block(&from, &to, &wanted);
            for (i, &from) in from.iter().enumerate() {
                let single = |(j, &to): (usize, &Vec3)| {
                    u64::from(geometry.occluded(&Segment { from, to })) << j
                };
                let all: u64 = to.iter().enumerate().map(single).sum();
                grazing += (blocked[i] ^ (all & wanted[i])).count_ones();
                let transparent = |&to: &Vec3| {
                    let mut any = false;
                    geometry.visit_transparent(&Segment { from, to }, |_| {
                        any = true;
                        any
                    });
                    any
                };
                let single = |(j, to): (usize, &Vec3)| u64::from(transparent(to)) << j;
                let all: u64 = to.iter().enumerate().map(single).sum();
                grazing += (crossing[i] ^ (all & wanted[i])).count_ones();
                crossings += crossing[i].count_ones();
            }
            assert!(blocked[origins..].iter().all(|&targets| targets == 0));
        }
    }
    assert!(crossings > 100, "{crossings}");
    assert!(grazing <= 2, "{grazing}");
}
