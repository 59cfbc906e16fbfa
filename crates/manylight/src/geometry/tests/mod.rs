//! Tests of geometry, and the shapes and transforms that they share.

mod areas;
mod mitsuba;
mod offsets;
mod points;
mod streams;
mod structures;

use super::*;
use crate::ids::{MaterialId, PrimitiveId, ShapeId};
use crate::math::{Affine3A, Vec2, Vec3};
use crate::sampling::rng::Pcg;
use glam::Quat;

pub(super) fn placed(shape: u32, world_from_object: Affine3A) -> Primitive {
    Primitive {
        shape: ShapeId(shape),
        world_from_object,
        flip_normals: false,
        material: MaterialId(0),
        emitter: None,
        transparent: false,
        invisible: false,
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

/// One group that holds the first primitive.
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

/// Random triangles around the origin; every fourth is a sliver.
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
