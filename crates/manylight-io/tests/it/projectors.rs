//! Projectors, constant textures, and thin materials.

use crate::{Files, document, load, problems};
use manylight::bsdf::Material;
use manylight::color::Rgb;
use manylight::emitters::{Emitter, ProjectorTexture, SpotFalloff};
use manylight::math::{Vec2, Vec3};
use manylight::scene::SceneDesc;
use manylight::texture::{ColorInput, FloatInput};

fn projector(desc: &SceneDesc) -> (&Emitter, ProjectorTexture) {
    let spot = desc.emitters.last().unwrap();
    match spot {
        Emitter::Spot {
            projector: Some(projector),
            falloff: SpotFalloff::FlatIrradiance,
            ..
        } => (spot, *projector),
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_window_of_a_projector_follows_field_of_view_and_image() {
    // A picture of 3 x 2 pixels.
    let pfm = "PF\n3 2\n-1.0\n".to_owned() + &"\0".repeat(72);
    let image = "<texture type='bitmap' name='irradiance'><string name='filename' value='a.pfm'/></texture>";
    for (parameters, half) in [
        ("<float name='fov' value='90'/>", [1.0, 2.0 / 3.0]),
        (
            "<float name='fov' value='90'/><string name='fov_axis' value='smaller'/>",
            [1.5, 1.0],
        ),
        ("<string name='focal_length' value='50mm'/>", [0.36, 0.24]),
    ] {
        let content = format!("<emitter type='projector'>{parameters}{image}</emitter>");
        let desc = Files::new(&document("3.0.0", &content), &[("a.pfm", &pfm)])
            .load()
            .desc;
        let window = projector(&desc).1.window.unwrap();
        assert!(
            window.abs_diff_eq(Vec2::from(half), 1e-4),
            "{parameters}: {window}"
        );
    }
}

#[test]
fn a_projector_gives_the_irradiance_that_mitsuba_gives() {
    let desc = load(
        "<emitter type='projector'><float name='fov' value='60'/><float name='scale' value='2'/><rgb name='irradiance' value='3 2 1'/></emitter>",
    );
    let (spot, projector) = projector(&desc);
    assert_eq!(projector.axes, [Vec3::NEG_X, Vec3::NEG_Y]);
    let intensity = spot.point_intensity(&desc.textures, Vec3::Z);
    // Mitsuba 3.9.1 multiplies by π.
    for (found, expected) in intensity.to_array().into_iter().zip([6.0, 4.0, 2.0]) {
        assert!((found - expected * std::f32::consts::PI).abs() < 1e-4);
    }
}

#[test]
fn raw_constants_are_numbers_or_vectors_under_both_tags() {
    let desc = load(
        "<bsdf type='roughconductor'><spectrum type='rawconstant' name='specular_reflectance'><vector name='value' value='0.2 1.5 0.9'/></spectrum>\
         <texture type='rawconstant' name='alpha'><float name='value' value='0.3'/></texture></bsdf>",
    );
    let Some(Material::Conductor {
        specular_reflectance,
        roughness,
        ..
    }) = desc.materials.last()
    else {
        panic!("expected a conductor");
    };
    assert_eq!(
        *specular_reflectance,
        ColorInput::Constant(Rgb::new(0.2, 1.5, 0.9))
    );
    assert_eq!(roughness.unwrap().alpha_u, FloatInput::Constant(0.3));
    let found = problems(
        "3.0.0",
        "<bsdf type='diffuse'><texture type='rawconstant' name='reflectance'/></bsdf>",
    );
    assert_eq!(
        found,
        ["error 2:37 spectrum `rawconstant` needs the parameter `value`"]
    );
}

#[test]
fn thin_materials_have_the_defaults_of_mitsuba() {
    let desc = load(
        "<bsdf type='principledthin'><float name='diff_trans' value='1.5'/><float name='diffuse_transmittance_sampling_rate' value='2'/></bsdf>",
    );
    let Some(Material::PrincipledThin(thin)) = desc.materials.last() else {
        panic!("expected a thin material");
    };
    assert_eq!(thin.base_color, ColorInput::Constant(Rgb::splat(0.5)));
    assert_eq!(
        (thin.roughness, thin.eta),
        (FloatInput::Constant(0.5), FloatInput::Constant(1.5))
    );
    assert_eq!(
        (thin.spec_trans, thin.diff_trans),
        (FloatInput::Constant(0.0), FloatInput::Constant(1.5))
    );
    let found = problems(
        "3.0.0",
        "<bsdf type='twosided'><bsdf type='principledthin'/></bsdf>",
    );
    assert!(
        found[0].contains("transmits light and cannot be nested in `twosided`"),
        "{found:?}"
    );
}
