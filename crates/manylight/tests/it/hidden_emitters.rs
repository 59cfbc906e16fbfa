//! Emitters that the camera must not see, by Mitsuba's rule (radiances measured with Mitsuba
//! 3.9.1's `path`): they are not there up to the first other surface, and are seen behind it; the
//! environment is seen after the first scattering event.

use crate::common::film;
use manylight::bsdf::Material;
use manylight::color::Rgb;
use manylight::emitters::Emitter;
use manylight::film::Layer;
use manylight::integrators::{ManyLight, MethodKind, PhotonMap};
use manylight::math::Vec3;
use manylight::scene::{PathLimits, Scene};
use manylight::testing::scenes::{Builder, diffuse};
use manylight::testing::statistics::channel_means;
use manylight::texture::{ColorInput, FloatInput};

/// The camera at z = 10 looks down the axis to 0; `emitters` and `sheets` are heights of black
/// emitters of radiance 3 and of sheets of the given material.
fn tower(emitters: &[f32], sheets: &[(f32, Material)], max_depth: Option<u32>) -> Builder {
    let mut b = Builder::new(Vec3::Z * 10.0, Vec3::ZERO, 10.0, 4);
    let lamp = b.area_light(Rgb::splat(3.0));
    let black = b.material(diffuse(0.0, 0.0, 0.0));
    for &z in emitters {
        b.rectangle(Vec3::Z * z, Vec3::X * 5.0, Vec3::Y * 5.0, black, Some(lamp));
    }
    for (z, material) in sheets {
        let mut material = material.clone();
        if let Material::Mask { inner, .. } = &mut material {
            *inner = black;
        }
        let material = b.material(material);
        b.rectangle(Vec3::Z * *z, Vec3::X * 20.0, Vec3::Y * 20.0, material, None);
    }
    b.emitter(Emitter::Constant {
        radiance: Rgb::splat(0.5),
    });
    b.desc.limits = PathLimits {
        max_depth,
        hide_emitters: true,
        ..PathLimits::default()
    };
    b
}

fn thin_glass() -> Material {
    let white = ColorInput::Constant(Rgb::WHITE);
    Material::ThinDielectric {
        eta: 1.5046 / 1.000277,
        specular_reflectance: white,
        specular_transmittance: white,
        roughness: None,
    }
}

/// Half there; what there is of it is black.
fn half() -> Material {
    Material::Mask {
        opacity: FloatInput::Constant(0.5),
        inner: manylight::ids::MaterialId(0),
    }
}

pub(crate) fn methods() -> [(MethodKind, u32); 5] {
    let few = ManyLight {
        photon_paths: 100,
        importon_paths: 10,
        light_count: 4,
        ..ManyLight::rich_vpl()
    };
    let photons = |method: PhotonMap| {
        MethodKind::PhotonMap(PhotonMap {
            photon_paths: 100,
            ..method
        })
    };
    [
        (MethodKind::Path, 128),
        (MethodKind::ManyLight(few), 16),
        (photons(PhotonMap::progressive()), 128),
        (photons(PhotonMap::direct()), 128),
        (MethodKind::LightTracer, 512),
    ]
}

fn check(name: &str, scene: &Scene, expected: f64) {
    for (kind, passes) in methods() {
        // The light tracer has neither the environment nor delta reflection.
        if kind == MethodKind::LightTracer && name.contains("glass") {
            continue;
        }
        let (mean, error) = channel_means(&film(scene, kind.clone(), passes, 1))[0];
        let allowed = 4.0 * error + 1e-3 * expected + 1e-6;
        assert!(
            (mean - expected).abs() < allowed,
            "{name}, {kind:?}: {mean} +- {error} for {expected}"
        );
    }
}

#[test]
fn emitters_hide_up_to_the_first_other_surface() {
    check("an emitter alone", &tower(&[0.0], &[], None).build(), 0.0);
    check(
        "behind nothing",
        &tower(&[0.0], &[(5.0, Material::Null)], None).build(),
        3.0,
    );
    check(
        "behind half a sheet",
        &tower(&[0.0], &[(5.0, half())], None).build(),
        1.5,
    );
    check(
        "before and behind nothing",
        &tower(&[8.0, 0.0], &[(5.0, Material::Null)], Some(2)).build(),
        3.0,
    );
    check(
        "too deep",
        &tower(&[8.0, 0.0], &[(5.0, Material::Null)], Some(1)).build(),
        0.0,
    );
    check(
        "environment behind a null surface",
        &tower(&[], &[(5.0, Material::Null)], None).build(),
        0.0,
    );
    check(
        "thin glass",
        &tower(&[0.0], &[(5.0, thin_glass())], None).build(),
        2.8074,
    );
}

#[test]
fn what_lies_behind_hidden_emitters_is_seen() {
    let wall = (-5.0, diffuse(0.5, 0.5, 0.5));
    let lit = tower(&[0.0, 1.0], &[wall], None);
    let mut bare = lit.clone();
    bare.desc.limits.hide_emitters = false;
    let film = film(&lit.build(), MethodKind::Path, 1024, 1);
    let depth = film.image(Layer::Depth).unwrap();
    assert!(
        depth.data.iter().all(|d| (15.0..15.1).contains(d)),
        "{:?}",
        depth.data
    );
    let (mean, error) = channel_means(&film)[0];
    // Mitsuba: 0.11427, of the constant environment around the emitters' edges.
    assert!(
        (mean - 0.1143).abs() < 4.0 * error + 3e-4,
        "{mean} +- {error}"
    );
    let hidden = crate::common::film(&bare.build(), MethodKind::Path, 4, 1);
    assert_eq!(channel_means(&hidden)[0].0, 3.0);
}
