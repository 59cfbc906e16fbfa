//! Direct samples against rays in uniform directions.

use super::*;
use crate::emitters::EnvironmentLobes;
use crate::geometry::{Ray, Segment};
use crate::sampling::warp;

/// Radiance along a ray from `p` along `wi`, and the density of sampling that direction.
fn found(
    world: &World,
    (p, n): (Vec3, Option<Vec3>),
    wi: Vec3,
    lobes: Option<&EnvironmentLobes>,
) -> (Rgb, f32) {
    match world.geometry.intersect(&Ray::new(p, wi)) {
        Some(hit) => {
            let y = world.geometry.surface_point(hit.at);
            let radiance = world
                .emitters
                .radiance(&world.geometry, &world.textures, &y, -wi);
            (radiance, world.emitters.pdf_direct(p, n, &y))
        }
        None => world.emitters.environment(n, wi, lobes),
    }
}

#[test]
fn direct_samples_and_uniform_rays_have_the_same_integral() {
    check_integrals(None);
}

#[test]
fn guided_samples_and_uniform_rays_have_the_same_integral() {
    let directions = [0.1, 0.3, 0.5, 0.7].map(|x| Vec3::new(x, 0.4, 0.8).normalize());
    let lobes = EnvironmentLobes::new(directions.into_iter());
    check_integrals(Some(&lobes.expect("four directions")));
}

fn check_integrals(lobes: Option<&EnvironmentLobes>) {
    for (name, world) in emissive_worlds() {
        for (p, n) in receivers() {
            let mut numbers = Sampler::new(11, 0, Stream::Test, 0);
            let test = |wi: Vec3| f64::from((1.0 + wi.x).powi(2) * (1.0 + 0.5 * wi.y));
            let (mut direct, mut direct2, mut uniform, mut uniform2) =
                (0.0f64, 0.0f64, 0.0f64, 0.0f64);
            let count = 30_000;
            for _ in 0..count {
                let (u_choice, u) = (numbers.next_1d(), numbers.next_2d());
                let sample = match lobes {
                    Some(lobes) => world.sample_guided((p, n), lobes, (u_choice, u)),
                    None => world.sample(p, n, u_choice, u),
                };
                if let Some(s) = sample.filter(|s| {
                    !world.geometry.occluded(&Segment {
                        from: p,
                        to: s.target,
                    })
                }) {
                    let value = f64::from(s.weight.g) * test(s.wi);
                    direct += value;
                    direct2 += value * value;
                    let (radiance, pdf) = found(&world, (p, n), s.wi, lobes);
                    // The ray may miss the border of the shape by rounding.
                    if !radiance.is_black() && s.pdf < 50.0 {
                        assert!(
                            (pdf / s.pdf - 1.0).abs() < 0.02,
                            "{name}: density {pdf} found, {} sampled",
                            s.pdf
                        );
                    }
                }
                let wi = warp::sphere(numbers.next_2d());
                let value =
                    f64::from(found(&world, (p, n), wi, lobes).0.g / warp::SPHERE_PDF) * test(wi);
                uniform += value;
                uniform2 += value * value;
            }
            let n_samples = f64::from(count);
            let (a, b) = (direct / n_samples, uniform / n_samples);
            let variance = (direct2 / n_samples - a * a + uniform2 / n_samples - b * b) / n_samples;
            assert!(
                (a - b).abs() < 5.0 * variance.sqrt() + 1e-6,
                "{name} at {p}: {a} direct, {b} by rays"
            );
        }
    }
}

#[test]
fn direct_densities_integrate_to_the_fraction_of_unoccluded_samples() {
    for (name, world) in emissive_worlds() {
        let (p, n) = receivers()[0];
        let side = 700;
        let mut integral = 0.0f64;
        for i in 0..side * side {
            let uv = Vec2::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5) / side as f32;
            let (radiance, pdf) =
                found(&world, (p, n), octahedral::direction_from_square(uv), None);
            if !radiance.is_black() {
                integral +=
                    f64::from(pdf * octahedral::solid_angle_density(uv)) / (side * side) as f64;
            }
        }
        let mut numbers = Sampler::new(12, 0, Stream::Test, 0);
        let count = 20_000;
        let seen = (0..count).filter(|_| {
            let (u_choice, u) = (numbers.next_1d(), numbers.next_2d());
            let sample = world.sample(p, n, u_choice, u);
            sample.is_some_and(|s| {
                !world.geometry.occluded(&Segment {
                    from: p,
                    to: s.target,
                })
            })
        });
        let share = seen.count() as f64 / f64::from(count);
        assert!(
            (integral - share).abs() < 0.02,
            "{name}: {integral} for {share}"
        );
    }
}

#[test]
fn an_empty_scene_has_no_light() {
    let world = world(vec![], vec![]);
    let mut numbers = Sampler::new(17, 0, Stream::Test, 0);
    assert!(emit(&world, &mut numbers).is_none());
    assert!(!world.emitters.has_environment());
    let sample = world.sample(Vec3::ZERO, None, 0.3, Vec2::splat(0.4));
    assert!(sample.is_none());
}
