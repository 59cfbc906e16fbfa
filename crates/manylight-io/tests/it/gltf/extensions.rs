//! Extensions of materials.

use super::materials::{close, color_at, document, inner, material_of, principled};
use super::*;
use manylight::bsdf::Material;
use manylight::color::Rgb;
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

#[test]
fn glass_is_thin_without_a_volume() {
    let (desc, warnings) = extended(
        "KHR_materials_transmission",
        json!({ "transmissionFactor": 1 }),
        0.0,
    );
    assert!(warnings.is_empty(), "{warnings:?}");
    let Material::ThinDielectric {
        specular_transmittance,
        ..
    } = material_of(&desc, 0)
    else {
        panic!("{:?}", material_of(&desc, 0))
    };
    assert!(close(
        color_at(&desc, *specular_transmittance, 0.0),
        [0.25, 1.0, 1.0]
    ));

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
    assert!(folder.problems()[0].contains("absorption along paths in a volume is not simulated"));
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
    let FloatInput::Constant(gloss) = p.clearcoat_gloss else {
        panic!()
    };
    assert!((0.1 + (0.001 - 0.1) * gloss - 0.01).abs() < 1e-6);

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
        (
            "KHR_materials_iridescence",
            json!({ "iridescenceFactor": 1 }),
            "thin-film interference",
        ),
        (
            "KHR_materials_dispersion",
            json!({ "dispersion": 1 }),
            "dispersion",
        ),
        (
            "KHR_materials_diffuse_transmission",
            json!({ "diffuseTransmissionFactor": 1 }),
            "diffuse transmission",
        ),
        ("KHR_materials_unlit", json!({}), "unlit materials"),
        (
            "KHR_materials_specular",
            json!({ "specularColorFactor": [1, 0, 0] }),
            "replaced by its mean",
        ),
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
