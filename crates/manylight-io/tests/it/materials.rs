//! Materials: defaults, parameters and spectra. The numbers are those that Mitsuba 3.9.1 prints for
//! the same text.

use crate::{Files, load, load_version};
use manylight::bsdf::Material;
use manylight::bsdf::material::{ColorShift, ConstantRoughness, Distribution};
use manylight::color::Rgb;
use manylight::emitters::Emitter;
use manylight::texture::{ColorInput, FloatInput, Texture};

fn near(a: Rgb, b: [f32; 3]) -> bool {
    a.to_array()
        .iter()
        .zip(b)
        .all(|(a, b)| (a - b).abs() <= 1e-3 * b.abs().max(1.0))
}

/// The last material of a scene with the bsdf `xml`.
fn material(xml: &str) -> Material {
    load(xml).materials.last().unwrap().clone()
}

pub(crate) fn constant(input: &ColorInput) -> Rgb {
    match input {
        ColorInput::Constant(color) => *color,
        ColorInput::Texture(_) => panic!("expected a constant color, found a texture"),
    }
}

#[test]
fn defaults_of_materials_are_mitsubas() {
    let Material::Diffuse { reflectance } = material("<bsdf type='diffuse'/>") else {
        panic!()
    };
    assert_eq!(constant(&reflectance), Rgb::splat(0.5));
    let Material::Dielectric { eta, .. } = material("<bsdf type='dielectric'/>") else {
        panic!()
    };
    assert!((eta - 1.504_183_3).abs() < 1e-6);
    let Material::Plastic {
        eta,
        color_shift,
        roughness,
        ..
    } = material("<bsdf type='roughplastic'/>")
    else {
        panic!()
    };
    assert!((eta - 1.489_587_3).abs() < 1e-6);
    assert_eq!(color_shift, ColorShift::Linear);
    let default_roughness = ConstantRoughness {
        distribution: Distribution::Beckmann,
        alpha: 0.1,
    };
    assert_eq!(roughness, Some(default_roughness));
    let Material::Conductor {
        eta, k, roughness, ..
    } = material("<bsdf type='roughconductor'/>")
    else {
        panic!()
    };
    assert_eq!((constant(&eta), constant(&k)), (Rgb::BLACK, Rgb::WHITE));
    assert_eq!(roughness.unwrap().alpha_u, FloatInput::Constant(0.1));
    let copper = material("<bsdf type='conductor'><string name='material' value='Cu'/></bsdf>");
    let Material::Conductor { eta, .. } = copper else {
        panic!()
    };
    assert!(near(constant(&eta), [0.201_005, 0.923_75, 1.102_215]));
    let mask = material("<bsdf type='mask'><bsdf type='diffuse'/></bsdf>");
    assert!(matches!(
        mask,
        Material::Mask {
            opacity: FloatInput::Constant(0.5),
            ..
        }
    ));
}

#[test]
fn principled_takes_eta_or_specular() {
    let eta = |xml: &str| match material(&format!("<bsdf type='principled'>{xml}</bsdf>")) {
        Material::Principled(principled) => principled.eta,
        other => panic!("{other:?}"),
    };
    assert!((eta("") - 1.5).abs() < 1e-6);
    assert!((eta("<float name='specular' value='1'/>") - 1.788_788_5).abs() < 1e-5);
    assert_eq!(eta("<float name='specular' value='0'/>"), 1.0);
    assert_eq!(eta("<float name='eta' value='1.3'/>"), 1.3);
    assert_eq!(
        eta("<float name='eta' value='1'/><float name='spec_trans' value='0.5'/>"),
        1.001
    );
}

#[test]
fn spectra_of_emitters_and_surfaces_differ() {
    let radiance = |xml: &str| {
        let desc = load(&format!("<emitter type='constant'>{xml}</emitter>"));
        match desc.emitters.last() {
            Some(Emitter::Constant { radiance }) => *radiance,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(radiance(""), Rgb::WHITE);
    assert_eq!(
        radiance("<rgb name='radiance' value='5'/>"),
        Rgb::splat(5.0)
    );
    assert_eq!(
        radiance("<float name='radiance' value='5'/>"),
        Rgb::splat(5.0)
    );
    assert!(near(
        radiance("<spectrum name='radiance' value='5'/>"),
        [6.023_97, 4.741_455, 4.544_58]
    ));
    let light = "400:0, 500:8, 600:15.6, 700:18.4";
    assert!(near(
        radiance(&format!("<spectrum name='radiance' value='{light}'/>")),
        [20.710_8, 10.854_6, 2.771_15]
    ));
    let d65 = "<spectrum name='radiance' type='d65'><float name='scale' value='2'/></spectrum>";
    assert_eq!(radiance(d65), Rgb::splat(2.0));

    let reflectance = |xml: &str| match material(&format!("<bsdf type='diffuse'>{xml}</bsdf>")) {
        Material::Diffuse { reflectance } => constant(&reflectance),
        other => panic!("{other:?}"),
    };
    assert_eq!(
        reflectance("<spectrum name='reflectance' value='0.7'/>"),
        Rgb::splat(0.7)
    );
    assert_eq!(
        reflectance("<rgb name='reflectance' value='0.1 0.2, 0.3'/>"),
        Rgb::new(0.1, 0.2, 0.3)
    );
    let grey = "400:0.78, 500:0.78, 600:0.78, 700:0.78";
    let color = reflectance(&format!("<spectrum name='reflectance' value='{grey}'/>"));
    assert!(near(color, [0.776_367, 0.779_81, 0.776_029]));
}

#[test]
fn spectra_are_read_from_files() {
    let scene = crate::document(
        "3.0.0",
        "<bsdf type='diffuse'><spectrum name='reflectance' filename='grey.spd'/></bsdf>",
    );
    let desc = Files::new(
        &scene,
        &[(
            "grey.spd",
            "# grey\n400 0.78\n500 0.78\n600 0.78\n700 0.78\n",
        )],
    )
    .load()
    .desc;
    let Material::Diffuse { reflectance } = &desc.materials[0] else {
        panic!()
    };
    assert!(near(
        constant(reflectance),
        [0.776_367, 0.779_81, 0.776_029]
    ));
}

#[test]
fn shapes_without_bsdf_are_grey_or_black() {
    let desc = load(
        "<shape type='sphere'/><shape type='sphere'><emitter type='area'/></shape><shape type='sphere'/>",
    );
    let albedo = |index: usize| match &desc.materials[desc.primitives[index].material.index()] {
        Material::Diffuse { reflectance } => constant(reflectance),
        other => panic!("{other:?}"),
    };
    assert_eq!(albedo(0), Rgb::splat(0.5));
    assert_eq!(albedo(1), Rgb::BLACK);
    assert_eq!(desc.primitives[0].material, desc.primitives[2].material);
    let emitter = desc.primitives[1].emitter.unwrap();
    assert!(matches!(
        desc.emitters[emitter.index()],
        Emitter::Area { .. }
    ));
}

#[test]
fn two_sided_materials_have_one_or_two_parts() {
    let desc = load("<bsdf type='twosided'><bsdf type='diffuse'/><bsdf type='conductor'/></bsdf>");
    let Material::TwoSided { front, back } = desc.materials[2] else {
        panic!()
    };
    assert!(matches!(
        desc.materials[front.index()],
        Material::Diffuse { .. }
    ));
    assert!(matches!(
        desc.materials[back.index()],
        Material::Conductor { .. }
    ));
}

#[test]
fn old_and_new_conductors_have_different_defaults() {
    let desc = load_version(
        "0.5.0",
        "<bsdf type='conductor'><float name='extEta' value='2'/></bsdf>",
    );
    let Material::Conductor { eta, .. } = &desc.materials[0] else {
        panic!()
    };
    assert!(near(constant(eta), [0.100_502, 0.461_875, 0.551_108]));
}

#[test]
fn textured_indices_of_conductors_are_relative_to_the_outside() {
    let desc = load_version(
        "0.5.0",
        "<bsdf type='conductor'><texture name='eta' type='checkerboard'/><float name='k' value='3'/>\
         <float name='extEta' value='2'/></bsdf>",
    );
    let Material::Conductor {
        eta: ColorInput::Texture(eta),
        k,
        ..
    } = &desc.materials[0]
    else {
        panic!("{:?}", desc.materials)
    };
    assert_eq!(constant(k), Rgb::splat(1.5));
    assert!(matches!(
        desc.textures[eta.index()],
        Texture::Product { first: ColorInput::Texture(_), second: ColorInput::Constant(factor) }
            if factor == Rgb::splat(0.5)
    ));
}
