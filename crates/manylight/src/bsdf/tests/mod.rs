//! Tests of scattering functions; this file holds what several of them use.

mod bounds;
mod cases;
mod lanes;
mod mitsuba;
mod packets;
mod sampling;
mod values;

use super::{Bsdf, BsdfNumbers, Lobes, Material, Materials};
use crate::color::Rgb;
use crate::math::{Cone, Frame, Vec2, Vec3};
use crate::sampling::{Sampler, Stream, warp};
use cases::{Case, cases, diffuse, float, white_pane};
use std::f32::consts::PI;

fn numbers(sampler: &mut Sampler) -> BsdfNumbers {
    BsdfNumbers {
        lobe: sampler.next_1d(),
        direction: sampler.next_2d(),
    }
}

fn sampler(index: u64) -> Sampler {
    Sampler::new(7, 0, Stream::Test, index)
}

/// A direction on the whole sphere.
fn direction(sampler: &mut Sampler) -> Vec3 {
    warp::sphere(sampler.next_2d())
}

/// Geometric normals: the shading normal, and one 20 degrees off.
fn normals() -> [Vec3; 2] {
    let tilted = Vec3::new(0.3, -0.17, 0.94).normalize();
    [Vec3::Z, tilted]
}

/// The sets of classes that differ for a surface.
fn masks(bsdf: &Bsdf) -> Vec<Lobes> {
    let all = [
        Lobes::DIFFUSE,
        Lobes::GLOSSY,
        Lobes::NEAR_DELTA,
        Lobes::DELTA,
        Lobes::NON_SPECULAR,
        Lobes::ALL,
    ];
    let mut list: Vec<Lobes> = Vec::new();
    for mask in all {
        let present = mask.and(bsdf.lobes());
        if present != Lobes::NONE && !list.iter().any(|l| l.and(bsdf.lobes()) == present) {
            list.push(mask);
        }
    }
    list
}

fn assert_close(a: f32, b: f32, relative: f32, what: &str) {
    assert!(
        (a - b).abs() <= relative * a.abs().max(b.abs()) + 1e-6,
        "{what}: {a} vs {b}"
    );
}

/// ∫ f |wo·ng| dwo by the midpoint rule over the angles of wo.
fn quadrature(bsdf: &Bsdf, wi: Vec3, lobes: Lobes) -> Rgb {
    let n = 180;
    let step = PI / n as f32;
    let mut sum = Rgb::BLACK;
    for k in 0..2 * n * n {
        let (sin, cos) = (((k / (2 * n)) as f32 + 0.5) * step).sin_cos();
        let (sin_phi, cos_phi) = (((k % (2 * n)) as f32 + 0.5) * step).sin_cos();
        let wo = Vec3::new(sin * cos_phi, sin * sin_phi, cos);
        sum += bsdf.f_cos_wo(wi, wo, lobes) * sin;
    }
    sum * (step * step)
}

/// A cone of any half-angle, large ones less often, and a direction in it.
fn cone_with_direction(sampler: &mut Sampler) -> (Cone, Vec3) {
    let axis = direction(sampler);
    let half_angle = PI * sampler.next_1d().powi(3);
    // Towards the border of the cone, where violations would be most frequent.
    let from_axis = half_angle * sampler.next_1d().sqrt();
    let turn = 2.0 * PI * sampler.next_1d();
    let frame = Frame::from_normal(axis);
    let across = Vec3::new(turn.cos(), turn.sin(), 0.0) * from_axis.sin();
    let w = frame
        .to_world(across + Vec3::Z * from_axis.cos())
        .normalize();
    (Cone { axis, half_angle }, w)
}
