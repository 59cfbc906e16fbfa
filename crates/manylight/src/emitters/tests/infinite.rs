//! Infinite lights: directions against their density, and photons over the bounding sphere.

use super::*;
use crate::emitters::infinite::InfiniteEmissionNumbers;
use crate::lanes::{Mask, One, Vector};
use crate::math::Aabb;

fn sphere() -> BoundingSphere {
    BoundingSphere::new(Aabb {
        min: Vec3::new(-1.0, 0.0, 2.0),
        max: Vec3::new(2.0, 1.0, 4.0),
    })
}

#[test]
fn infinite_light_directions_follow_their_density() {
    let emitters = infinite_emitters();
    let lights = InfiniteLights::new(&emitters, sphere());
    for n in [None, Some(Vec3::new(0.2, 0.9, -0.3).normalize())] {
        let receiver = Receivers::from((Vec3::ZERO, n));
        let mut choice = Sampler::new(4, 0, Stream::Test, 1);
        check_directions(
            200_000,
            |u| {
                let numbers = (choice.next_1d().into(), u.into());
                let sample = lights.sample(&receiver, numbers, Mask::splat(One, true));
                sample.is_parallel.none().then_some(sample.wi.into())
            },
            |w| lights.look_up(&receiver, Vector::from(w)).1.get(),
        );
    }
}

#[test]
fn infinite_light_emission_crosses_the_sphere_evenly() {
    let emitters = infinite_emitters();
    let lights = InfiniteLights::new(&emitters, sphere());
    let BoundingSphere { center, radius } = sphere();
    let mut numbers = Sampler::new(6, 0, Stream::Test, 0);
    for (emitter, power) in lights.powers() {
        let n = 40_000;
        let (mut flux, mut inner) = (0.0f64, 0.0f64);
        for _ in 0..n {
            let u = InfiniteEmissionNumbers {
                position: numbers.next_2d(),
                direction: numbers.next_2d(),
                guide: 0.5,
            };
            let (ray, sample_flux) = lights.emit(emitter, None, u).unwrap();
            let to_center = center - ray.o;
            let along = to_center.dot(ray.d);
            let miss = (to_center - ray.d * along).length();
            assert!(along > 0.0 && to_center.length() > 0.999 * radius && miss < 1.001 * radius);
            flux += f64::from(sample_flux.g) / f64::from(n);
            inner += f64::from(u8::from(miss < 0.5 * radius)) / f64::from(n);
        }
        assert!(
            (flux / f64::from(power.g) - 1.0).abs() < 0.02,
            "{emitter:?}: {flux} for {power:?}"
        );
        assert!((inner - 0.25).abs() < 0.015, "{emitter:?}: {inner}");
    }
}

#[test]
fn bounding_spheres_never_vanish() {
    for bounds in [
        Aabb::EMPTY,
        Aabb::from_points([Vec3::ZERO]),
        Aabb::from_points([Vec3::splat(1e4)]),
    ] {
        assert!(BoundingSphere::new(bounds).radius > 0.0);
    }
}
