//! Light outside of closed opaque bodies with interpolated normals.

use crate::common::{film, methods};
use manylight::bsdf::Material;
use manylight::color::Rgb;
use manylight::geometry::{Mesh, Shape};
use manylight::integrators::MethodKind;
use manylight::math::{Affine3A, Vec2, Vec3};
use manylight::scene::Scene;
use manylight::testing::scenes::{Builder, diffuse, rough_metal};
use manylight::testing::statistics::channel_means;
use std::f32::consts::PI;

/// A sphere of few triangles with the normals of a smooth one, closed along the seam.
fn coarse_ball() -> Mesh {
    let (columns, rows) = (12u32, 6u32);
    let direction = |row: u32, column: u32| {
        let theta = PI * row as f32 / rows as f32;
        let phi = 2.0 * PI * (column % columns) as f32 / columns as f32;
        let x = Vec2::from_angle(phi) * theta.sin();
        if row.is_multiple_of(rows) {
            return Vec3::Z * theta.cos();
        }
        Vec3::new(x.x, x.y, theta.cos())
    };
    let vertices = (0..=rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
    let normals: Vec<Vec3> = vertices
        .map(|(row, column)| direction(row, column))
        .collect();
    let at = |row: u32, column: u32| row * columns + column % columns;
    let mut triangles = Vec::new();
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        if row > 0 {
            triangles.push([at(row, column), at(row + 1, column), at(row, column + 1)]);
        }
        if row + 1 < rows {
            triangles.push([
                at(row, column + 1),
                at(row + 1, column),
                at(row + 1, column + 1),
            ]);
        }
    }
    Mesh {
        positions: normals.clone(),
        normals,
        tangents: Vec::new(),
        uvs: Vec::new(),
        triangles,
    }
}

/// A ball of a material on both of its sides between two lamps, seen from `eye`.
fn lit_ball(material: Material, eye: Vec3, target: Vec3) -> Scene {
    let mut b = Builder::new(eye, target, 90.0, 16);
    let one_sided = b.material(material);
    let both = b.material(Material::TwoSided {
        front: one_sided,
        back: one_sided,
    });
    b.place(Shape::Mesh(coarse_ball()), Affine3A::IDENTITY, both, None);
    let black = b.material(diffuse(0.0, 0.0, 0.0));
    let lamp = b.area_light(Rgb::splat(10.0));
    for side in [1.0, -1.0] {
        let (x, y) = (Vec3::X * 2.0, Vec3::Y * 2.0 * side);
        b.rectangle(Vec3::Z * -3.0 * side, x, y, black, Some(lamp));
    }
    b.build()
}

#[test]
fn no_light_enters_closed_bodies() {
    for material in [diffuse(0.8, 0.8, 0.8), rough_metal(0.3), rough_metal(0.02)] {
        let inside = lit_ball(material.clone(), Vec3::ZERO, Vec3::new(0.3, 0.8, 0.5));
        let outside = lit_ball(material.clone(), Vec3::X * 3.0, Vec3::ZERO);
        let lit = |kind: &MethodKind| !matches!(kind, MethodKind::Aov);
        for kind in methods().into_iter().filter(lit) {
            let means = |scene| channel_means(&film(scene, kind.clone(), 4, 3)).map(|c| c.0);
            assert_eq!(means(&inside), [0.0; 3], "{kind:?} of {material:?}");
            assert!(means(&outside)[1] > 0.05, "{kind:?} of {material:?}");
        }
    }
}
