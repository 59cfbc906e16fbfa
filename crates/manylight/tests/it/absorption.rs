//! Absorbing media inside of bodies.

use crate::common::film;
use manylight::bsdf::Material;
use manylight::color::Rgb;
use manylight::emitters::Emitter;
use manylight::ids::MaterialId;
use manylight::integrators::{ManyLight, MethodKind, PhotonMap};
use manylight::math::Vec3;
use manylight::scene::{MediumDesc, Scene};
use manylight::testing::scenes::{Builder, diffuse, glass};
use manylight::testing::statistics::channel_means;

/// Absorption coefficients in 1/m.
const ABSORPTION: Rgb = Rgb::new(0.0, 0.4, 1.5);

fn absorbing(b: &mut Builder, material: Material) -> MaterialId {
    let material = b.material(material);
    b.desc.media.push(MediumDesc {
        material,
        absorption: ABSORPTION,
    });
    material
}

/// The two sides of a slab of glass between z = 0 and z = 1, seen along the axis; around it an
/// environment of radiance 1.
fn slab(inside: Option<f32>) -> Scene {
    let mut b = Builder::new(Vec3::Z * 10.0, Vec3::ZERO, 0.5, 4);
    let glass = absorbing(&mut b, glass());
    let (x, y) = (Vec3::X * 20.0, Vec3::Y * 20.0);
    b.rectangle(Vec3::Z, x, y, glass, None);
    b.rectangle(Vec3::ZERO, y, x, glass, None);
    if let Some(z) = inside {
        let black = b.material(diffuse(0.0, 0.0, 0.0));
        let lamp = b.area_light(Rgb::splat(3.0));
        b.rectangle(Vec3::Z * z, x, y, black, Some(lamp));
    }
    b.emitter(Emitter::Constant {
        radiance: Rgb::WHITE,
    });
    b.build()
}

fn methods() -> [MethodKind; 3] {
    [
        MethodKind::Path,
        MethodKind::ManyLight(ManyLight {
            photon_paths: 100,
            importon_paths: 10,
            light_count: 4,
            ..ManyLight::rich_vpl()
        }),
        MethodKind::PhotonMap(PhotonMap {
            photon_paths: 100,
            ..PhotonMap::progressive()
        }),
    ]
}

fn check(name: &str, scene: &Scene, expected: [f64; 3]) {
    for method in methods() {
        let means = channel_means(&film(scene, method.clone(), 2000, 1));
        for ((mean, error), expected) in means.into_iter().zip(expected) {
            let allowed = 4.0 * error + 2e-3 * expected;
            assert!(
                (mean - expected).abs() < allowed,
                "{name}, {method:?}: {mean} +- {error} for {expected}"
            );
        }
    }
}

/// Reflectance of glass at normal incidence.
const R: f64 = 0.04;

#[test]
fn a_slab_transmits_what_its_medium_leaves() {
    let of_channel = |sigma: f32| {
        let passing = f64::from(-sigma).exp();
        // Reflected at once, or after any number of internal reflections: all see the environment.
        R + (1.0 - R) * (1.0 - R) * passing / (1.0 - R * passing)
    };
    check("slab", &slab(None), ABSORPTION.to_array().map(of_channel));
}

#[test]
fn what_lies_within_a_body_is_seen_through_its_medium() {
    // From the first side to the lamp at a depth of 0.75: the segment ends at another material.
    let of_channel = |sigma: f32| {
        let passing = f64::from(-0.75 * sigma).exp();
        R + (1.0 - R) * 3.0 * passing / 2.25
    };
    let expected = ABSORPTION.to_array().map(of_channel);
    check("lamp", &slab(Some(0.25)), expected);
}

#[test]
fn media_are_checked() {
    let valid = || {
        let mut b = Builder::new(Vec3::Z, Vec3::ZERO, 10.0, 4);
        absorbing(&mut b, glass());
        b.desc
    };
    assert!(Scene::build(valid(), 0).is_ok());
    for (material, absorption, expected) in [
        (7, Rgb::WHITE, "material 7"),
        (0, Rgb::new(0.0, -1.0, 0.0), "negative or not finite"),
        (0, Rgb::splat(f32::NAN), "negative or not finite"),
    ] {
        let mut desc = valid();
        desc.media[0] = MediumDesc {
            material: MaterialId(material),
            absorption,
        };
        let error = Scene::build(desc, 0).unwrap_err();
        assert!(error.message.contains(expected), "{}", error.message);
    }
}
