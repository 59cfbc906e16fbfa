//! Extensions of materials.

use super::materials::{close, color_at, document, inner, material_of, principled};
use super::*;
use manylight::bsdf::material::Roughness;
use manylight::bsdf::{Lobes, Material};
use manylight::color::Rgb;
use manylight::geometry::Ray;
use manylight::math::{Vec2, Vec3};
use manylight::scene::Scene;
use manylight::texture::{ColorInput, FloatInput};

/// The material with this extension, and whether it loads without a warning.
fn extended(name: &str, extension: Value, roughness: f32) -> (SceneDesc, Vec<String>) {
    let document = document(json!({
        "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": roughness, "baseColorFactor": [0.25, 1, 1, 1] },
        "extensions": { name: extension }
    }));
    let folder = Folder::new(&document);
    let loaded = load_scene(&folder.file, &LoadOptions::default()).unwrap();
    (loaded.desc, folder.problems())
}

/// A scene with a pane, which has the tint of its base color, and the roughness of the pane.
fn pane(roughness: f32) -> (SceneDesc, Option<Roughness>) {
    let transmission = json!({ "transmissionFactor": 1 });
    let (desc, warnings) = extended("KHR_materials_transmission", transmission, roughness);
    assert!(warnings.is_empty(), "{warnings:?}");
    let Material::ThinDielectric {
        specular_transmittance,
        roughness,
        ..
    } = *material_of(&desc, 0)
    else {
        panic!("{:?}", material_of(&desc, 0))
    };
    let tint = color_at(&desc, specular_transmittance, 0.0);
    assert!(close(tint, [0.25, 1.0, 1.0]), "{tint:?}");
    (desc, roughness)
}

#[test]
fn rough_panes_are_thin_and_keep_all_light() {
    let (desc, roughness) = pane(0.3);
    let roughness = roughness.unwrap();
    let alpha = FloatInput::Constant(0.3 * 0.3);
    assert_eq!((roughness.alpha_u, roughness.alpha_v), (alpha, alpha));
    // Light from the front and from the back.
    let scene = Scene::build(desc, 0).unwrap();
    let z = Vec3::new(0.2, 0.2, 1.0);
    let (_, x) = scene.intersect(&Ray::new(z, Vec3::NEG_Z)).unwrap();
    let [front, back] = [0.8f32, -0.8].map(|z| {
        let w = Vec3::new(0.6, 0.0, z);
        scene.bsdf(&x).albedo(w, Lobes::ALL)
    });
    for (front, back) in front.to_array().into_iter().zip(back.to_array()) {
        assert!((front - back).abs() < 2e-3, "{front} {back}");
    }
    assert!(
        front.g > 0.97 && front.g < 1.003 && front.r < 0.4,
        "{front:?}"
    );
}

#[test]
fn glass_is_thin_without_a_volume() {
    assert_eq!(pane(0.0).1, None);

    let document = document(json!({
        "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0, "baseColorFactor": [0.25, 1, 1, 1] },
        "extensions": {
            "KHR_materials_ior": { "ior": 1.4 },
            "KHR_materials_transmission": { "transmissionFactor": 0.5 },
            "KHR_materials_volume": { "thicknessFactor": 2, "attenuationColor": [1, 0.5, 1], "attenuationDistance": 1 }
        }
    }));
    let folder = Folder::new(&document);
    let desc = load_scene(&folder.file, &LoadOptions::default())
        .unwrap()
        .desc;
    assert!(
        folder.problems()[0]
            .contains("absorption along paths in a volume whose surface is not closed")
    );
    let Material::Blend {
        weight: FloatInput::Constant(0.5),
        second,
        ..
    } = material_of(&desc, 0)
    else {
        panic!()
    };
    let Material::Dielectric {
        eta,
        specular_transmittance,
        roughness: None,
        ..
    } = inner(&desc, *second)
    else {
        panic!()
    };
    assert!((eta - 1.4).abs() < 1e-6);
    // Half of the tint at each side: the roots of 0.25 and of 0.5².
    assert!(close(
        color_at(&desc, *specular_transmittance, 0.0),
        [0.5, 0.5, 1.0]
    ));
}

#[test]
fn lobes_of_extensions() {
    let (desc, _) = extended(
        "KHR_materials_clearcoat",
        json!({ "clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.1 }),
        0.5,
    );
    let p = principled(&desc);
    assert_eq!(p.clearcoat, FloatInput::Constant(0.5));
    assert_eq!(
        p.layers.map(|layers| layers.coat_roughness),
        Some(FloatInput::Constant(0.1))
    );

    let (desc, _) = extended("KHR_materials_ior", json!({ "ior": 1.33 }), 0.5);
    assert!((principled(&desc).eta - 1.33).abs() < 1e-5);
    let (desc, _) = extended(
        "KHR_materials_specular",
        json!({ "specularFactor": 0.25 }),
        0.5,
    );
    assert!((principled(&desc).eta - 1.2222).abs() < 1e-4);

    // alpha = 0.25 across, and 0.25 + 0.75 · 0.2² along the tangent.
    let (desc, warnings) = extended(
        "KHR_materials_anisotropy",
        json!({ "anisotropyStrength": 0.2 }),
        0.5,
    );
    assert!(warnings.is_empty(), "{warnings:?}");
    let p = principled(&desc);
    let (FloatInput::Constant(r), FloatInput::Constant(a)) = (p.roughness, p.anisotropic) else {
        panic!()
    };
    let aspect = (1.0 - 0.9 * a).sqrt();
    assert!((r * r / aspect - 0.28).abs() < 1e-4 && (r * r * aspect - 0.25).abs() < 1e-4);

    for (name, extension, expected) in [
        (
            "KHR_materials_sheen",
            json!({ "sheenColorFactor": [1, 1, 1] }),
            "sheen is approximated",
        ),
        ("KHR_materials_unlit", json!({}), "unlit materials"),
    ] {
        let (_, warnings) = extended(name, extension, 0.5);
        assert!(
            matches!(warnings.as_slice(), [only] if only.contains(expected)),
            "{warnings:?}"
        );
    }
}

#[test]
fn specular_glossiness_is_converted() {
    let (desc, warnings) = extended(
        "KHR_materials_pbrSpecularGlossiness",
        json!({ "diffuseFactor": [0.1, 0.2, 0.3, 1], "specularFactor": [0.05, 0.05, 0.05], "glossinessFactor": 0.75 }),
        0.5,
    );
    assert!(
        matches!(warnings.as_slice(), [only] if only.contains("KHR_materials_pbrSpecularGlossiness")),
        "{warnings:?}"
    );
    let p = principled(&desc);
    assert_eq!(p.base_color, ColorInput::Constant(Rgb::new(0.1, 0.2, 0.3)));
    assert_eq!(
        (p.roughness, p.metallic),
        (FloatInput::Constant(0.25), FloatInput::Constant(0.0))
    );
    assert!((((p.eta - 1.0) / (p.eta + 1.0)).powi(2) - 0.05).abs() < 1e-5);
}

#[test]
fn metadata_does_not_warn_and_may_be_required() {
    for name in ["FB_ngon_encoding", "KHR_animation_pointer"] {
        load(&changed(&[
            ("/extensionsUsed/1", json!(name)),
            ("/extensionsRequired", json!([name])),
        ]));
    }
    let unknown = changed(&[("/extensionsRequired", json!(["KHR_materials_transmissive"]))]);
    let found = Folder::new(&unknown).problems();
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(!found[0].contains("did you mean"), "{found:?}");
}

#[test]
fn webp_images_are_read() {
    let image = image::RgbaImage::from_raw(1, 1, vec![255, 128, 0, 255]).unwrap();
    let mut file = std::io::Cursor::new(Vec::new());
    image.write_to(&mut file, image::ImageFormat::WebP).unwrap();
    let mut document = super::materials::document(json!({
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } }
    }));
    let texture = json!([{ "extensions": { "EXT_texture_webp": { "source": 0 } } }]);
    for (path, value) in [
        ("/textures", texture),
        ("/extensionsRequired", json!(["EXT_texture_webp"])),
        (
            "/images",
            json!([{ "uri": data_uri("image/webp", file.get_ref()) }]),
        ),
    ] {
        set(&mut document, path, value);
    }
    let desc = load(&document);
    let color = color_at(&desc, principled(&desc).base_color, 0.5);
    assert!(close(color, [1.0, 0.2158, 0.0]), "{color:?}");
    // A file that ends early is one error of its image.
    let cut = data_uri("image/webp", &file.get_ref()[..20]);
    set(&mut document, "/images", json!([{ "uri": cut }]));
    let found = Folder::new(&document).problems();
    assert!(
        matches!(found.as_slice(), [only] if only.contains("/images/0: embedded image: the image cannot be decoded")),
        "{found:?}"
    );
}

/// Reflected fraction of the flux of light from the direction with the cosine `cos` to the normal.
fn albedo(desc: SceneDesc, cos: f32) -> Rgb {
    use manylight::bsdf::Lobes;
    use manylight::geometry::Ray;
    use manylight::math::Vec3;
    use manylight::scene::Scene;
    use std::f32::consts::{FRAC_PI_2, TAU};
    const STEPS: [usize; 2] = [400, 400];
    let scene = Scene::build(desc, 0).unwrap();
    let ray = Ray::new(Vec3::new(0.2, 0.2, 1.0), Vec3::NEG_Z);
    let (_, x) = scene.intersect(&ray).unwrap();
    let bsdf = scene.bsdf(&x);
    let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let cell = FRAC_PI_2 / STEPS[0] as f32 * TAU / STEPS[1] as f32;
    let steps = (0..STEPS[0] * STEPS[1]).map(|i| (i / STEPS[1], i % STEPS[1]));
    let value = |(i, j): (usize, usize)| {
        let theta = (i as f32 + 0.5) * FRAC_PI_2 / STEPS[0] as f32;
        let phi = (j as f32 + 0.5) * TAU / STEPS[1] as f32;
        let wi = Vec3::new(
            theta.sin() * phi.cos(),
            theta.sin() * phi.sin(),
            theta.cos(),
        );
        bsdf.f_cos_wi(wi, wo, Lobes::ALL) * (theta.sin() * cell)
    };
    steps.map(value).sum()
}

/// Fresnel's equations for an interface of index 1.5.
pub(super) fn fresnel(cos: f32) -> f32 {
    let t = (1.0 - (1.0 - cos * cos) / 2.25).sqrt();
    let (s, p) = (
        (cos - 1.5 * t) / (cos + 1.5 * t),
        (t - 1.5 * cos) / (t + 1.5 * cos),
    );
    0.5 * (s * s + p * p)
}

fn coated(base: f32) -> SceneDesc {
    let folder = Folder::new(&document(json!({
        "pbrMetallicRoughness": { "metallicFactor": 0, "baseColorFactor": [base, base, base, 1] },
        "extensions": {
            "KHR_materials_specular": { "specularFactor": 0 },
            "KHR_materials_clearcoat": { "clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.2 }
        }
    })));
    let loaded = load_scene(&folder.file, &LoadOptions::default()).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    loaded.desc
}

#[test]
fn clear_coats_are_fresnel_interfaces_over_the_base() {
    for cos in [1.0, 0.7, 0.4] {
        let (found, expected) = (albedo(coated(0.0), cos).g, fresnel(cos));
        assert!(
            (found / expected - 1.0).abs() < 0.05,
            "{cos}: {found} for {expected}"
        );
        // What is below loses the light that the coat reflects, on both ways.
        let below = albedo(coated(0.8), cos).g - found;
        // 0.908: one minus the reflectance for diffuse light.
        let expected = 0.8 * (1.0 - expected) * 0.908;
        assert!(
            (below / expected - 1.0).abs() < 0.02,
            "{cos}: {below} for {expected}"
        );
    }
}

#[test]
fn textures_of_lobes_are_factors() {
    let texture = json!({ "index": 0 });
    let (desc, warnings) = extended(
        "KHR_materials_clearcoat",
        json!({
            "clearcoatFactor": 0.5, "clearcoatTexture": texture,
            "clearcoatRoughnessFactor": 0.5, "clearcoatRoughnessTexture": texture
        }),
        0.5,
    );
    assert!(warnings.is_empty(), "{warnings:?}");
    let p = principled(&desc);
    let value = |input: FloatInput| input.eval(Vec2::new(0.25, 0.5), &desc.textures);
    assert!((value(p.clearcoat) - 0.5).abs() < 1e-3);
    let roughness = p.layers.unwrap().coat_roughness;
    assert!((value(roughness) - 0.5 * 128.0 / 255.0).abs() < 1e-3);

    // The tint of the reflectance at normal incidence; opacity is 0.2.
    let (desc, warnings) = extended(
        "KHR_materials_specular",
        json!({ "specularColorFactor": [1, 0.5, 0], "specularTexture": texture, "specularColorTexture": texture }),
        0.5,
    );
    assert!(warnings.is_empty(), "{warnings:?}");
    let p = principled(&desc);
    assert!((p.eta - 1.5).abs() < 1e-5);
    let tint = color_at(&desc, p.layers.unwrap().specular_tint, 0.25);
    assert!(close(tint, [0.2, 0.2 * 0.5 * 0.2158, 0.0]), "{tint:?}");

    // Anisotropy with the same numbers as textures.
    let strength = |texture: bool| {
        let mut extension = json!({ "anisotropyStrength": 0.8 });
        if texture {
            extension["anisotropyTexture"] = json!({ "index": 0 });
        }
        let (desc, _) = extended("KHR_materials_anisotropy", extension, 0.5);
        let p = principled(&desc).clone();
        let at = |input: FloatInput| input.eval(Vec2::new(0.25, 0.5), &desc.textures);
        (at(p.roughness), at(p.anisotropic))
    };
    // Blue is 64 / 255.
    let (r, a) = strength(true);
    let along = 0.25 + 0.75 * (0.8f32 * 64.0 / 255.0).powi(2);
    let aspect = (1.0 - 0.9 * a).sqrt();
    assert!((r * r / aspect - along).abs() < 2e-3, "{r} {a}");
    assert!((r * r * aspect - 0.25).abs() < 2e-3, "{r} {a}");
}

#[test]
fn tints_of_the_dielectric_are_those_of_normal_incidence() {
    let (desc, _) = extended(
        "KHR_materials_specular",
        json!({ "specularColorFactor": [4, 1, 0] }),
        0.3,
    );
    let mut black = desc;
    let desc_principled = black
        .materials
        .iter_mut()
        .find_map(|material| match material {
            Material::Principled(p) => Some(p),
            _ => None,
        });
    desc_principled.unwrap().base_color = ColorInput::Constant(Rgb::BLACK);
    let found = albedo(black, 1.0);
    assert!((found.r / 0.16 - 1.0).abs() < 0.05, "{found:?}");
    assert!((found.g / 0.04 - 1.0).abs() < 0.05, "{found:?}");
    assert!(found.b < 0.002, "{found:?}");
}

#[test]
fn the_thickness_of_volumes_has_the_scale_of_its_node() {
    let mut document = document(json!({
        "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0 },
        "extensions": {
            "KHR_materials_transmission": { "transmissionFactor": 1 },
            "KHR_materials_volume": { "thicknessFactor": 1, "attenuationColor": [0.25, 1, 1], "attenuationDistance": 1 }
        }
    }));
    set(
        &mut document,
        "/nodes/2",
        json!({ "mesh": 0, "scale": [2, 2, 2] }),
    );
    set(&mut document, "/scenes/0/nodes", json!([0, 1, 2]));
    let folder = Folder::new(&document);
    let desc = load_scene(&folder.file, &LoadOptions::default())
        .unwrap()
        .desc;
    // The root of the transmittance at each side.
    for (primitive, expected) in [(0, 0.5), (1, 0.25)] {
        let Material::Dielectric {
            specular_transmittance,
            ..
        } = material_of(&desc, primitive)
        else {
            panic!()
        };
        let color = color_at(&desc, *specular_transmittance, 0.5);
        assert!(close(color, [expected, 1.0, 1.0]), "{color:?}");
    }
}
