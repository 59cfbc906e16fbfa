//! Environment maps against Mitsuba 3.9.1, and their sampler against its density.

use super::*;
use crate::emitters::infinite::EnvironmentSampler;
use crate::lanes::{Mask, One, Pair, Vector};

/// A sampled direction.
fn sample(sampler: &EnvironmentSampler, u: Vec2) -> Vec3 {
    let sample = EnvironmentSampler::sample(sampler, Pair::from(u), Mask::splat(One, true));
    sample.wi.into()
}

/// Radiance and density of a direction.
fn look_up(sampler: &EnvironmentSampler, wi: Vec3) -> (Rgb, f32) {
    let seen = EnvironmentSampler::look_up(sampler, Vector::from(wi));
    (seen.radiance.into(), seen.pdf.get())
}

#[test]
fn environment_lookups_match_mitsuba() {
    let mut environment = Environment {
        image: picture(),
        scale: 1.5,
        world_from_emitter: Mat3::IDENTITY,
    };
    let upright = [
        (
            [0.618984, -0.7751, 0.126804],
            [0.954825, 0.511041, 0.769253],
        ),
        (
            [-0.749577, -0.597593, -0.284634],
            [0.945529, 0.422132, 1.121876],
        ),
        (
            [-0.914149, -0.104961, -0.391554],
            [0.727529, 0.694093, 0.961904],
        ),
        (
            [-0.587884, 0.724993, -0.358857],
            [0.551554, 1.007036, 0.589688],
        ),
        ([0.0, 1.0, 0.0], [0.503906, 0.621094, 0.738281]),
        ([0.0001, 0.0, -1.0], [0.668016, 0.785203, 0.902391]),
    ];
    let rotated = [
        (
            [-0.090628, 0.267923, 0.959168],
            [0.951603, 0.438022, 0.840337],
        ),
        (
            [-0.252895, -0.22845, 0.940136],
            [0.71637, 0.560864, 0.950745],
        ),
        ([0.651207, 0.10269, 0.75192], [0.747354, 0.894906, 0.445967]),
        ([0.0, 1.0, 0.0], [0.476208, 0.923307, 0.710583]),
    ];
    let check = |environment: &Environment, cases: &[([f32; 3], [f32; 3])]| {
        for &(w, value) in cases {
            let sampler = EnvironmentSampler::new(environment).unwrap();
            let difference = look_up(&sampler, Vec3::from(w)).0 - Rgb::from(value);
            assert!(
                difference.map(f32::abs).max_channel() < 1e-4,
                "at {w:?}: off by {difference:?}"
            );
        }
    };
    check(&environment, &upright);
    environment.world_from_emitter = rotation();
    check(&environment, &rotated);
}

#[test]
fn environment_samples_follow_their_density() {
    let environment = Environment {
        image: picture(),
        scale: 1.5,
        world_from_emitter: rotation(),
    };
    let sampler = EnvironmentSampler::new(&environment).unwrap();
    check_directions(
        200_000,
        |u| Some(sample(&sampler, u)),
        |w| look_up(&sampler, w).1,
    );
}

#[test]
fn a_small_sun_is_sampled_well() {
    let mut image = Image::new(64, 32, 3);
    image.data.fill(0.1);
    image.data[(9 * 64 + 20) * 3..][..3].fill(2e4);
    let environment = Environment {
        image,
        scale: 1.0,
        world_from_emitter: rotation(),
    };
    let sampler = EnvironmentSampler::new(&environment).unwrap();
    let mut numbers = Sampler::new(5, 0, Stream::Test, 0);
    let total = sampler.total().g;
    for _ in 0..5000 {
        let wi = sample(&sampler, numbers.next_2d());
        let (radiance, pdf) = look_up(&sampler, wi);
        let weight = radiance.g / pdf;
        assert!(
            (0.6..1.5).contains(&(weight / total)),
            "weight {weight} for {total}"
        );
    }
}

#[test]
fn environment_maps_without_extent_or_light_are_harmless() {
    for (width, height) in [(1, 1), (1, 5), (5, 1), (4, 2)] {
        let mut image = Image::new(width, height, 3);
        let black = Environment {
            image: image.clone(),
            scale: 1.0,
            world_from_emitter: Mat3::IDENTITY,
        };
        assert!(EnvironmentSampler::new(&black).is_none());
        image.data.fill(2.0);
        let bright = Environment {
            image,
            scale: 1.0,
            world_from_emitter: Mat3::IDENTITY,
        };
        let sampler = EnvironmentSampler::new(&bright).unwrap();
        assert!((sampler.total().r - 8.0 * PI).abs() < 1e-3);
        check_directions(
            20_000,
            |u| Some(sample(&sampler, u)),
            |w| look_up(&sampler, w).1,
        );
    }
}
