//! Areas, and densities of points sampled by area.

use super::*;
use std::f32::consts::{PI, TAU};

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
        // The mean of uniform points is the centroid, which for these shapes is the center of the
        // box.
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
fn area_and_density_of_an_ellipsoid() {
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
