//! Surfaces that light and that no ray meets, as PBRT's area lights with `alpha` 0.

use crate::common::film;
use crate::hidden_emitters::methods;
use manylight::color::Rgb;
use manylight::emitters::Emitter;
use manylight::integrators::{MethodKind, PhotonMap};
use manylight::math::Vec3;
use manylight::scene::Scene;
use manylight::testing::scenes::{Builder, diffuse};
use manylight::testing::statistics::channel_means;
use manylight::texture::ColorInput;
use std::f64::consts::PI;

/// Half edge of the lamp, at the height 1 over the floor.
const HALF_EDGE: f32 = 2.0;
const RADIANCE: f32 = 3.0;
const REFLECTANCE: f32 = 0.5;
/// Field of view of the camera in degrees, 10 above the floor.
const FOV: f32 = 4.0;

/// A floor under a lamp that faces it; the camera looks down at both.
fn floor_under(lamp: Emitter) -> Scene {
    let mut b = Builder::new(Vec3::Z * 10.0, Vec3::ZERO, FOV, 4);
    let white = b.material(diffuse(REFLECTANCE, REFLECTANCE, REFLECTANCE));
    b.rectangle(Vec3::ZERO, Vec3::X * 20.0, Vec3::Y * 20.0, white, None);
    let (lamp, black) = (b.emitter(lamp), b.material(diffuse(0.0, 0.0, 0.0)));
    let (x, y) = (Vec3::X * HALF_EDGE, Vec3::Y * HALF_EDGE);
    b.rectangle(Vec3::Z, y, x, black, Some(lamp));
    b.build()
}

/// Fraction of the hemisphere, weighted by the cosine, that a parallel rectangle at distance 1 with
/// the edges `a` and `b` fills over one of its corners.
fn form_factor(a: f64, b: f64) -> f64 {
    let term = |x: f64, y: f64| x / x.hypot(1.0) * (y / x.hypot(1.0)).atan();
    (term(a, b) + term(b, a)) / (2.0 * PI)
}

/// Mean radiance of the part of the floor that the camera sees.
fn expected() -> f64 {
    const STEPS: i32 = 32;
    let half = f64::from(HALF_EDGE);
    let seen = 10.0 * (f64::from(FOV) / 2.0).to_radians().tan();
    let at = |i: i32| ((f64::from(i) + 0.5) / f64::from(STEPS) * 2.0 - 1.0) * seen;
    let places = (0..STEPS * STEPS).map(|i| (at(i % STEPS), at(i / STEPS)));
    let fractions = places.flat_map(|(x, y)| {
        [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]
            .map(|(sx, sy)| form_factor(half + sx * x, half + sy * y))
    });
    let sum: f64 = fractions.sum();
    f64::from(RADIANCE * REFLECTANCE) * sum / f64::from(STEPS * STEPS)
}

fn with_photons(map: PhotonMap) -> PhotonMap {
    PhotonMap {
        photon_paths: 20_000,
        ..map
    }
}

#[test]
fn the_floor_is_seen_through_its_lamp_and_fully_lit() {
    let radiance = ColorInput::Constant(Rgb::splat(RADIANCE));
    let scene = floor_under(Emitter::InvisibleArea { radiance });
    let expected = expected();
    for (method, passes) in methods() {
        // A hundred photons lie too far apart for the picture: kernels would reach past the light.
        let (method, passes, bias) = match method {
            MethodKind::PhotonMap(map) => (MethodKind::PhotonMap(with_photons(map)), 8, 1e-2),
            other => (other, passes, 1e-3),
        };
        let (mean, error) = channel_means(&film(&scene, method.clone(), passes, 1))[0];
        assert!(
            (mean - expected).abs() < 4.0 * error + bias * expected,
            "{method:?}: {mean} +- {error} for {expected}"
        );
    }
    // A visible lamp hides the floor.
    let (method, passes) = methods()[0].clone();
    let scene = floor_under(Emitter::Area { radiance });
    assert_eq!(channel_means(&film(&scene, method, passes, 1))[0].0, 0.0);
}
