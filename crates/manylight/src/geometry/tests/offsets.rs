//! Robustness of rays that leave surfaces, and precision of large and distant shapes.

use super::*;
use crate::math::Mat3;
use crate::sampling::warp;
use std::f32::consts::PI;

/// The shape at several scales and positions, directly and through an instance; with the scale.
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

/// A point of the only primitive by area, through the instance if there is one.
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
    // A wall on a floor: a point close to the wall does not see the other side.
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
