//! Absorbing media inside of bodies.

use crate::common::film;
use manylight::bsdf::Material;
use manylight::color::Rgb;
use manylight::emitters::Emitter;
use manylight::geometry::{Mesh, Shape};
use manylight::ids::MaterialId;
use manylight::integrators::{ManyLight, MethodKind, PhotonMap};
use manylight::math::{Affine3A, Vec3};
use manylight::scene::{MediumDesc, Scene};
use manylight::testing::scenes::{Builder, diffuse, glass};
use manylight::testing::statistics::channel_means;
use manylight::texture::ColorInput;

/// Absorption coefficients in 1/m.
const ABSORPTION: Rgb = Rgb::new(0.0, 0.4, 1.5);

fn absorbing(b: &mut Builder, material: Material, absorption: Rgb) -> MaterialId {
    let material = b.material(material);
    b.desc.media.push(MediumDesc {
        material,
        absorption,
    });
    material
}

/// The two sides of a slab of glass between z = 0 and z = 1, seen along the axis; around it an
/// environment of radiance 1.
fn slab(inside: Option<f32>) -> Scene {
    let mut b = Builder::new(Vec3::Z * 10.0, Vec3::ZERO, 0.5, 4);
    let glass = absorbing(&mut b, glass(), ABSORPTION);
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

/// A floor, a wall and a lamp within a body whose interface refracts nothing.
fn room_within_a_body(bubble: bool) -> Scene {
    let mut b = Builder::new(
        Vec3::new(-1.5, 0.0, 1.5),
        Vec3::new(0.5, 0.0, -1.0),
        20.0,
        4,
    );
    let white = ColorInput::Constant(Rgb::WHITE);
    let unseen = Material::Dielectric {
        eta: 1.0,
        specular_reflectance: white,
        specular_transmittance: white,
        roughness: None,
    };
    let cube = || Shape::Mesh(Mesh::cube());
    let body = absorbing(&mut b, unseen.clone(), Rgb::new(0.05, 0.1, 0.3));
    b.place(cube(), Affine3A::from_scale(Vec3::splat(3.0)), body, None);
    if bubble {
        // Around everything: nothing absorbs.
        let empty = b.material(unseen);
        b.place(cube(), Affine3A::from_scale(Vec3::splat(2.9)), empty, None);
    }
    let (x, y, z) = (Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::Z * 2.0);
    let floor = b.material(diffuse(0.5, 0.5, 0.5));
    b.rectangle(-Vec3::Z, x, y, floor, None);
    let wall = b.material(diffuse(0.8, 0.8, 0.8));
    b.rectangle(Vec3::new(2.0, 0.0, 1.0), z, y, wall, None);
    let black = b.material(diffuse(0.0, 0.0, 0.0));
    let lamp = b.area_light(Rgb::splat(10.0));
    b.rectangle(z, y * 0.25, x * 0.25, black, Some(lamp));
    b.build()
}

#[test]
fn light_between_points_within_a_body_is_absorbed() {
    // Mitsuba 3.9.1, `volpath` with a homogeneous medium of albedo 0 and a `null` interface;
    // relative standard errors of 4e-4. Without the medium 0.17070.
    let expected = [0.12301, 0.08878, 0.02441];
    check_many_lights("room", &room_within_a_body(false), expected);
    check_many_lights("bubble", &room_within_a_body(true), [0.17070; 3]);
}

/// As [`check`], with enough virtual lights for what surfaces send to each other.
fn check_many_lights(name: &str, scene: &Scene, expected: [f64; 3]) {
    let lights = ManyLight {
        photon_paths: 1000,
        importon_paths: 10,
        light_count: 128,
        ..ManyLight::rich_vpl()
    };
    let lightcuts = ManyLight {
        photon_paths: 1000,
        importon_paths: 10,
        light_count: 128,
        ..ManyLight::rich_lightcuts()
    };
    // Cuts have an error of their own.
    for (method, passes, tolerance) in [
        (MethodKind::Path, 2000, 3e-3),
        (MethodKind::ManyLight(lights), 200, 5e-3),
        (MethodKind::ManyLight(lightcuts), 200, 1e-2),
    ] {
        let means = channel_means(&film(scene, method.clone(), passes, 1));
        for ((mean, error), expected) in means.into_iter().zip(expected) {
            let allowed = 4.0 * error + tolerance * expected;
            assert!(
                (mean - expected).abs() < allowed,
                "{name}, {method:?}: {mean} +- {error} for {expected}"
            );
        }
    }
}

#[test]
fn media_are_checked() {
    let valid = || {
        let mut b = Builder::new(Vec3::Z, Vec3::ZERO, 10.0, 4);
        absorbing(&mut b, glass(), ABSORPTION);
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
