//! Points on surfaces against Mitsuba 3's surface interactions, robustness of rays that leave surfaces, instances,
//! transparent surfaces and areas.

use super::*;
use crate::ids::{MaterialId, PrimitiveId, ShapeId};
use crate::math::{Affine3A, Mat3, Vec2, Vec3};
use crate::sampling::{rng::Pcg, warp};
use crate::simd::Instructions;
use glam::Quat;
use std::f32::consts::{PI, TAU};

fn placed(shape: u32, world_from_object: Affine3A) -> Primitive {
    Primitive {
        shape: ShapeId(shape),
        world_from_object,
        flip_normals: false,
        material: MaterialId(0),
        emitter: None,
        transparent: false,
    }
}

fn alone(shape: Shape, world_from_object: Affine3A) -> Geometry {
    Geometry::build(
        vec![shape],
        vec![placed(0, world_from_object)],
        vec![],
        vec![],
    )
}

fn flipped(shape: Shape, world_from_object: Affine3A) -> Geometry {
    let primitive = Primitive {
        flip_normals: true,
        ..placed(0, world_from_object)
    };
    Geometry::build(vec![shape], vec![primitive], vec![], vec![])
}

/// The first primitive is the first group.
#[allow(
    clippy::single_range_in_vec_init,
    reason = "one group is meant, not many numbers"
)]
fn one_group() -> Vec<std::ops::Range<usize>> {
    vec![0..1]
}

fn ball() -> Shape {
    Shape::Sphere {
        center: Vec3::new(0.3, -0.2, 0.1),
        radius: 0.8,
    }
}

fn pipe() -> Shape {
    Shape::Cylinder {
        p0: Vec3::new(0.3, -0.5, 0.2),
        p1: Vec3::new(1.0, 0.7, -0.4),
        radius: 0.6,
    }
}

fn turned() -> Affine3A {
    let axis = Vec3::new(2.0, 1.0, 2.0) / 3.0;
    Affine3A::from_rotation_translation(
        Quat::from_axis_angle(axis, 50f32.to_radians()),
        Vec3::new(1.0, -2.0, 0.5),
    )
}

fn enlarged() -> Affine3A {
    turned() * Affine3A::from_scale(Vec3::splat(1.5))
}

fn mirrored() -> Affine3A {
    turned() * Affine3A::from_scale(Vec3::new(-1.5, 1.5, 1.5))
}

/// p, geometric normal, shading normal, x of the shading frame, uv, dp_du, dp_dv.
type Expected = (
    [f32; 3],
    [f32; 3],
    [f32; 3],
    [f32; 3],
    [f32; 2],
    [f32; 3],
    [f32; 3],
);

/// Compares what is seen from (4, 3, 2) through `through`.
#[track_caller]
fn check(geometry: &Geometry, through: [f32; 3], expected: Expected) {
    let eye = Vec3::new(4.0, 3.0, 2.0);
    check_ray(
        geometry,
        &Ray::new(eye, (Vec3::from(through) - eye).normalize()),
        expected,
    );
}

#[track_caller]
fn check_ray(geometry: &Geometry, ray: &Ray, (p, ng, ns, s, uv, dp_du, dp_dv): Expected) {
    let hit = geometry.intersect(ray).expect("the ray hits");
    let x = geometry.surface_point(hit.at);
    let close = |name: &str, a: Vec3, b: [f32; 3]| {
        assert!((a - Vec3::from(b)).length() < 5e-5, "{name}: {a} {b:?}")
    };
    close("p", x.p, p);
    close("t", ray.at(hit.t), p);
    close("ng", x.ng, ng);
    close("ns", x.frame.n, ns);
    close("s", x.frame.s, s);
    close("uv", x.uv.extend(0.0), [uv[0], uv[1], 0.0]);
    close("dp_du", x.dp_du, dp_du);
    close("dp_dv", x.dp_dv, dp_dv);
}

#[test]
#[rustfmt::skip]
fn meshes_match_mitsuba() {
    let rectangle = || Shape::Mesh(Mesh::rectangle());
    let cube = || Shape::Mesh(Mesh::cube());
    let n = [0.414109, -0.431316, 0.801549];
    let back = [-0.414109, 0.431316, -0.801549];
    let s = [0.801549, 0.590077, -0.0965871];
    let mirrored_s = [-0.801549, -0.590077, 0.0965871];
    let (du, dv) = ([2.40465, 1.77023, -0.289761], [-1.29395, 2.04743, 1.77023]);
    let mirrored_du = [-2.40465, -1.77023, 0.289761];
    let (p, uv) = ([0.694976, -2.47038, 0.404471], [0.329057, 0.418055]);
    let target = [1.1, -1.8, 0.6];
    check(&alone(rectangle(), enlarged()), target, (p, n, n, s, uv, du, dv));
    // A reflection turns the triangles over, but not the normals that come with the vertices.
    let uv = [0.670944, 0.418054];
    check(&alone(rectangle(), mirrored()), target, (p, back, n, mirrored_s, uv, mirrored_du, dv));
    check(&flipped(rectangle(), mirrored()), target, (p, n, back, mirrored_s, uv, mirrored_du, dv));

    let (p, n) = ([2.02731, -0.799256, 0.830998], [0.801549, 0.590077, -0.0965871]);
    let back = [-0.801549, -0.590077, 0.0965871];
    let s = [-0.431316, 0.682478, 0.590077];
    let (du, dv) = ([-1.29395, 2.04743, 1.77023], [-1.24233, 1.29395, -2.40465]);
    let target = [1.3, -2.2, 0.4];
    check(&alone(cube(), enlarged()), target, (p, n, n, s, [0.690567, 0.44239], du, dv));
    let dv = [1.24233, -1.29395, 2.40465];
    check(&alone(cube(), mirrored()), target, (p, back, n, s, [0.690567, 0.55761], du, dv));
    check(&flipped(cube(), mirrored()), target, (p, n, back, s, [0.690567, 0.55761], du, dv));
}

#[test]
#[rustfmt::skip]
fn vertex_normals_and_uvs_are_optional_as_in_mitsuba() {
    let positions = vec![Vec3::ZERO, Vec3::new(1.0, 0.0, 0.2), Vec3::new(0.0, 1.0, 0.1)];
    let normals: Vec<Vec3> =
        [[0.1, 0.0, 1.0], [0.0, 0.2, 1.0], [-0.1, 0.1, 0.9]].map(|n| Vec3::from(n).normalize()).to_vec();
    let uvs = vec![Vec2::new(0.1, 0.8), Vec2::new(0.8, 0.7), Vec2::new(0.3, 0.1)];
    let mesh = |normals: &[Vec3], uvs: &[Vec2]| {
        let (positions, normals, uvs) = (positions.clone(), normals.to_vec(), uvs.to_vec());
        alone(Shape::Mesh(Mesh { positions, normals, uvs, triangles: vec![[0, 1, 2]] }), Affine3A::IDENTITY)
    };
    let ray = Ray::new(Vec3::new(0.25, 0.25, 3.0), Vec3::NEG_Z);
    let p = [0.25, 0.25, 0.075];
    let (ng, ns) = ([-0.19518, -0.09759, 0.9759], [0.0224718, 0.077022, 0.996776]);
    let (du, dv) = ([1.0, 0.0, 0.2], [0.0, 1.0, 0.1]);
    check_ray(&mesh(&[], &[]), &ray, (p, ng, ng, [0.980581, 0.0, 0.196116], [0.25, 0.25], du, dv));
    check_ray(&mesh(&normals, &[]), &ray, (p, ng, ns, [0.999628, -0.0171648, -0.0212098], [0.25, 0.25], du, dv));
    let (du, dv) = ([1.48936, -0.212766, 0.276596], [0.425532, -1.48936, -0.0638298]);
    check_ray(&mesh(&[], &uvs), &ray, (p, ng, ng, [0.973632, -0.13909, 0.180817], [0.325, 0.6], du, dv));
    check_ray(&mesh(&normals, &uvs), &ray, (p, ng, ns, [0.987589, -0.15673, -0.010154], [0.325, 0.6], du, dv));
    // Where uv is constant any tangent will do, and Mitsuba takes the frame of the normal.
    let frame = crate::math::Frame::from_normal(Vec3::from(ng));
    let (du, dv) = (frame.s.to_array(), frame.t.to_array());
    check_ray(&mesh(&[], &[Vec2::splat(0.5); 3]), &ray, (p, ng, ng, du, [0.5, 0.5], du, dv));
}

#[test]
#[rustfmt::skip]
fn analytic_shapes_match_mitsuba() {
    let n = [0.334393, 0.885384, 0.322919];
    check(&alone(ball(), enlarged()), [1.3, -2.2, 0.4], (
        [1.95348, -0.941445, 0.787248], n, n, [-0.849059, 0.134325, 0.510936], [0.112752, 0.495088],
        [-6.40099, 1.01266, 3.8519], [-1.54189, 1.67773, -3.00334],
    ));
    // Of all shapes only the sphere turns its normal inwards in a mirror.
    let (n, back) = ([-0.642106, -0.762781, -0.0765829], [0.642106, 0.762781, 0.0765829]);
    let (p, s, uv) = ([1.60134, -1.61964, 0.578573], [0.644438, -0.482966, -0.592826], [0.453368, 0.500545]);
    let (du, dv) = ([4.85894, -3.64147, -4.4698], [-1.5653, 1.6211, -3.02227]);
    check(&alone(ball(), mirrored()), [1.3, -2.2, 0.4], (p, n, n, s, uv, du, dv));
    check(&flipped(ball(), mirrored()), [1.3, -2.2, 0.4], (p, back, back, s, uv, du, dv));

    let n = [0.414109, -0.431316, 0.801549];
    let (p, s, du) = ([0.694977, -2.47038, 0.404472], [-0.536347, -0.827113, -0.167975], [-0.804521, -1.24067, -0.251963]);
    let target = [1.1, -1.8, 0.6];
    check(&alone(Shape::Disk, enlarged()), target, (p, n, n, s, [0.379136, 0.571144], du, [2.62786, -1.28762, -2.05052]));
    check(&alone(Shape::Disk, mirrored()), target, (p, n, n, s, [0.379136, 0.928856], du, [-2.62786, 1.28762, 2.05052]));

    let n = [0.264161, -0.0666574, 0.962172];
    check(&alone(pipe(), enlarged()), [1.6, -2.2, 1.1], (
        [1.91879, -1.50928, 1.21955], n, n, [0.954921, 0.15817, -0.251213], [0.812157, 0.414283],
        [5.39995, 0.894431, -1.42058], [-0.307441, 2.23622, 0.239328],
    ));
}

#[test]
#[rustfmt::skip]
fn instances_match_mitsuba() {
    let group = placed(0, Affine3A::from_scale(Vec3::new(1.0, 2.0, 1.0)));
    let instance = Instance { group: 0, world_from_group: mirrored() };
    let geometry = Geometry::build(vec![Shape::Mesh(Mesh::rectangle())], vec![group], one_group(), vec![instance]);
    let n = [0.414109, -0.431316, 0.801549];
    check(&geometry, [1.1, -1.8, 0.6], (
        [0.694975, -2.47039, 0.40447], n, n, [-0.801549, -0.590077, 0.0965871], [0.670943, 0.459027],
        [-2.40465, -1.77023, 0.289761], [-2.58789, 4.09487, 3.54046],
    ));
    assert_eq!(geometry.triangle_count(), 2);
}

struct Random(Pcg);

impl Random {
    fn number(&mut self) -> f32 {
        self.0.next_f32()
    }
    fn square(&mut self) -> Vec2 {
        Vec2::new(self.number(), self.number())
    }
    fn point(&mut self, half: f32) -> Vec3 {
        (Vec3::new(self.number(), self.number(), self.number()) * 2.0 - 1.0) * half
    }
}

/// Triangles of ordinary shape and slivers of all kinds around the origin.
fn soup(random: &mut Random, count: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..count {
        let center = random.point(1.0);
        let [a, b, c] = [random.point(0.3), random.point(0.3), random.point(0.3)];
        let c = if i.is_multiple_of(4) {
            a.lerp(b, 0.3) + c * 10f32.powf(-3.0 * random.number())
        } else {
            c
        };
        mesh.positions.extend([center + a, center + b, center + c]);
        mesh.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    mesh
}

/// Scenes that differ by scale and place, and through an instance.
fn variants(shape: &Shape) -> Vec<(f32, Geometry)> {
    let mut variants = Vec::new();
    for scale in [1e-3, 1.0, 100.0] {
        for shift in [Vec3::ZERO, Vec3::new(30.0, -500.0, 80.0) * scale] {
            let transform = Affine3A::from_translation(shift)
                * turned()
                * Affine3A::from_scale(Vec3::splat(scale));
            variants.push((scale, alone(shape.clone(), transform)));
            let instance = Instance {
                group: 0,
                world_from_group: transform,
            };
            let group = placed(0, turned());
            variants.push((
                scale,
                Geometry::build(
                    vec![shape.clone()],
                    vec![group],
                    one_group(),
                    vec![instance],
                ),
            ));
        }
    }
    variants
}

/// A random point of the only primitive, through the instance if there is one.
fn point_on(geometry: &Geometry, u: Vec2) -> SurfacePoint {
    let sample = geometry
        .sample_area(PrimitiveId(0), u)
        .expect("the shape has area");
    let through = if geometry.instances.is_empty() {
        SurfaceRef::NO_INSTANCE
    } else {
        0
    };
    geometry.surface_point(SurfaceRef {
        instance: through,
        ..sample.point.at
    })
}

#[test]
fn rays_never_hit_the_triangle_that_they_leave() {
    let mut random = Random(Pcg::new(1));
    let shape = Shape::Mesh(soup(&mut random, 200));
    for (scale, geometry) in variants(&shape) {
        for i in 0..3000usize {
            let x = point_on(&geometry, random.square());
            let mut w = warp::sphere(random.square());
            if i.is_multiple_of(3) {
                // Grazing.
                w = (w - x.ng * w.dot(x.ng) * 0.999).normalize();
            }
            let hit = geometry.intersect(&x.spawn(w));
            assert!(
                hit.is_none_or(|hit| hit.at.element != x.at.element),
                "scale {scale}: {x:?} {w} {hit:?}"
            );
            let y = geometry.surface_point(SurfaceRef {
                coordinates: warp::triangle(random.square()),
                ..x.at
            });
            // Along the triangle, to another point of it.
            let (from, to) = (x.offset_towards(x.ng), y.offset_towards(y.ng));
            let hit = geometry.intersect(&Ray {
                o: from,
                d: to - from,
                t_max: 1.0,
            });
            assert!(hit.is_none_or(|hit| hit.at.element != x.at.element));
        }
    }
}

#[test]
fn rays_that_leave_a_convex_shape_do_not_hit_it_and_inner_ones_do() {
    let mut random = Random(Pcg::new(2));
    for shape in [ball(), pipe(), Shape::Disk, Shape::Mesh(Mesh::cube())] {
        let closed = matches!(shape, Shape::Sphere { .. } | Shape::Mesh(_));
        for (scale, geometry) in variants(&shape) {
            for _ in 0..800 {
                let x = point_on(&geometry, random.square());
                let w = warp::sphere(random.square());
                let outside = w * w.dot(x.ng).signum();
                assert!(
                    geometry.intersect(&x.spawn(outside)).is_none(),
                    "{shape:?} {scale} {x:?} {outside}"
                );
                let segment = Segment {
                    from: x.offset_towards(outside),
                    to: x.p + outside * scale,
                };
                assert!(!geometry.occluded(&segment), "{shape:?} {scale}");
                if closed && outside.dot(x.ng) > 1e-3 {
                    let inner = geometry
                        .intersect(&x.spawn(-outside))
                        .expect("the shape is closed");
                    assert!(inner.t > 1e-5 * scale, "{shape:?} {scale} {inner:?}");
                }
            }
        }
    }
}

#[test]
fn offsets_are_small_and_scale_with_the_scene() {
    let mut random = Random(Pcg::new(3));
    for shape in [ball(), pipe(), Shape::Disk, Shape::Mesh(Mesh::cube())] {
        let geometry = alone(shape.clone(), turned());
        let large = alone(
            shape.clone(),
            Affine3A::from_scale(Vec3::splat(1024.0)) * turned(),
        );
        for _ in 0..100 {
            let u = random.square();
            let (x, y) = (point_on(&geometry, u), point_on(&large, u));
            assert!(x.offset > 0.0 && x.offset < 1e-5, "{}", x.offset);
            assert!((y.offset / x.offset / 1024.0 - 1.0).abs() < 1e-3);
        }
    }
}

#[test]
fn contacts_do_not_leak() {
    // A wall that stands on a floor: what is close to the wall on one side does not see the other side.
    let floor = placed(0, Affine3A::from_scale(Vec3::splat(10.0)));
    let upright = Mat3::from_rotation_y(PI / 2.0);
    let wall = placed(
        0,
        Affine3A::from_mat3_translation(upright, Vec3::new(0.0, 0.0, 1.0)),
    );
    let geometry = Geometry::build(
        vec![Shape::Mesh(Mesh::rectangle())],
        vec![floor, wall],
        vec![],
        vec![],
    );
    for distance in [1e-4, 1e-3, 0.1] {
        let look = |x: f32| {
            geometry
                .intersect(&Ray::new(Vec3::new(x, 0.3, 0.5), Vec3::NEG_Z))
                .unwrap()
        };
        let [near, far] = [-distance, 0.5].map(|x| geometry.surface_point(look(x).at));
        assert!(
            geometry.occluded(&near.segment_to(&far)) || near.p.x > 0.0,
            "{distance}"
        );
        assert!(geometry.occluded(&Segment {
            from: near.offset_towards(Vec3::Z),
            to: Vec3::new(0.5, 0.3, 0.01)
        }));
    }
}

#[test]
fn large_and_far_spheres_keep_their_precision() {
    let ground = alone(
        Shape::Sphere {
            center: Vec3::new(0.0, 0.0, -1e6),
            radius: 1e6,
        },
        Affine3A::IDENTITY,
    );
    let x = ground.surface_point(
        ground
            .intersect(&Ray::new(Vec3::new(1.0, 2.0, 3.0), Vec3::NEG_Z))
            .unwrap()
            .at,
    );
    assert!((x.p - Vec3::new(1.0, 2.0, 0.0)).length() < 1e-4, "{x:?}");
    assert!(
        ground
            .intersect(&x.spawn(Vec3::new(1.0, 0.0, 1e-3).normalize()))
            .is_none()
    );

    let ball = alone(
        Shape::Sphere {
            center: Vec3::ZERO,
            radius: 0.1,
        },
        Affine3A::IDENTITY,
    );
    let hit = ball
        .intersect(&Ray::new(Vec3::new(0.05, 0.0, 1e5), Vec3::NEG_Z))
        .unwrap();
    assert!((ball.surface_point(hit.at).p.truncate() - Vec2::new(0.05, 0.0)).length() < 1e-6);
    assert!(
        ball.intersect(&Ray::new(Vec3::new(0.101, 0.0, 1e5), Vec3::NEG_Z))
            .is_none()
    );
}

/// A room of everything: opaque and transparent meshes and analytic shapes, and instances of them.
fn mixed() -> Geometry {
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

/// The nearest hit by asking every primitive and instance on its own.
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
fn structures_agree_with_asking_one_by_one() {
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
fn packets_equal_single_segments() {
    let geometry = mixed();
    let mut random = Random(Pcg::new(6));
    for count in [0, 1, 8, 33, 64] {
        for _ in 0..20 {
            let from = random.point(3.0);
            let to: Vec<Vec3> = (0..count).map(|_| random.point(3.0)).collect();
            let single =
                |(i, &to): (usize, &Vec3)| u64::from(geometry.occluded(&Segment { from, to })) << i;
            assert_eq!(
                geometry.occluded_packet(from, &to),
                to.iter().enumerate().map(single).sum()
            );
        }
    }
}

#[test]
fn blocks_equal_single_segments() {
    let mut geometry = mixed();
    for instructions in Instructions::available() {
        geometry.use_instructions(instructions);
        hold_blocks_to_single_segments(&geometry);
    }
}

fn hold_blocks_to_single_segments(geometry: &Geometry) {
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

#[test]
fn areas_and_densities_agree() {
    let length = Vec3::new(0.7, 1.2, -0.6).length();
    let cases = [
        (Shape::Mesh(Mesh::rectangle()), 4.0),
        (Shape::Mesh(Mesh::cube()), 24.0),
        (ball(), 4.0 * PI * 0.64),
        (Shape::Disk, PI),
        (pipe(), TAU * 0.6 * length),
    ];
    for (shape, expected) in cases {
        let geometry = alone(shape.clone(), mirrored());
        let area = geometry.area(PrimitiveId(0));
        assert!(
            (area / (expected * 2.25) - 1.0).abs() < 1e-5,
            "{shape:?} {area}"
        );
        // Uniform points: their mean is the center of the area, which for these shapes is that of the box.
        let side = 64;
        let grid = (0..side * side)
            .map(|i| Vec2::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5) / side as f32);
        let mut mean = Vec3::ZERO;
        for u in grid {
            let sample = geometry.sample_area(PrimitiveId(0), u).unwrap();
            assert!((sample.pdf_area * area - 1.0).abs() < 1e-4);
            let seen = geometry
                .intersect(&Ray::new(
                    sample.point.p + sample.point.ng,
                    -sample.point.ng,
                ))
                .unwrap();
            assert!((seen.t - 1.0).abs() < 1e-4);
            mean += sample.point.p / (side * side) as f32;
        }
        assert!(
            (mean - geometry.bounds().center()).length() < 0.06,
            "{shape:?} {mean}"
        );
    }
    let empty = alone(Shape::Mesh(Mesh::default()), Affine3A::IDENTITY);
    assert!(
        empty
            .sample_area(PrimitiveId(0), Vec2::splat(0.5))
            .is_none()
            && empty.bounds().is_empty()
    );
    assert!(empty.intersect(&Ray::new(Vec3::ZERO, Vec3::Z)).is_none());
}

#[test]
fn an_ellipsoid_knows_its_area_and_density() {
    let geometry = alone(
        Shape::Sphere {
            center: Vec3::ZERO,
            radius: 1.0,
        },
        Affine3A::from_scale(Vec3::new(1.0, 1.0, 2.0)),
    );
    // Prolate spheroid with eccentricity e = √3/2: 2π (1 + 2/e asin e).
    let e = 0.75f32.sqrt();
    let expected = TAU * (1.0 + 2.0 / e * e.asin());
    assert!((geometry.area(PrimitiveId(0)) / expected - 1.0).abs() < 1e-3);
    let side = 100;
    let grid = (0..side * side)
        .map(|i| Vec2::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5) / side as f32);
    let sum: f32 = grid
        .map(|u| 1.0 / geometry.sample_area(PrimitiveId(0), u).unwrap().pdf_area)
        .sum();
    assert!((sum / (side * side) as f32 / expected - 1.0).abs() < 1e-3);
}
