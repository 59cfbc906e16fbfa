//! Materials and textures.

use super::*;
use manylight::bsdf::Material;
use manylight::bsdf::material::PrincipledMaterial;
use manylight::color::Rgb;
use manylight::emitters::Emitter;
use manylight::ids::MaterialId;
use manylight::math::Vec2;
use manylight::texture::{ColorInput, Filtering, FloatInput, Texture, TexturePoint, Wrap};

/// A PNG image of 8 bits, row by row, as a data URI.
pub(super) fn png(pixels: &[[u8; 4]], width: usize) -> String {
    let height = (pixels.len() / width) as u32;
    let image = image::RgbaImage::from_raw(width as u32, height, pixels.concat()).unwrap();
    let mut file = std::io::Cursor::new(Vec::new());
    image.write_to(&mut file, image::ImageFormat::Png).unwrap();
    data_uri("image/png", file.get_ref())
}

/// The triangle with this material, and one texture of 2 x 1 pixels.
pub(super) fn document(material: Value) -> Value {
    changed(&[
        ("/materials/0", material),
        ("/textures", json!([{ "source": 0, "sampler": 0 }])),
        (
            "/samplers",
            json!([{ "magFilter": 9728, "wrapS": 33071, "wrapT": 33648 }]),
        ),
        (
            "/images",
            json!([{ "uri": png(&[[255, 128, 64, 51], [0, 0, 255, 204]], 2) }]),
        ),
    ])
}

pub(super) fn material_of(desc: &SceneDesc, primitive: usize) -> &Material {
    &desc.materials[desc.primitives[primitive].material.index()]
}

pub(super) fn inner(desc: &SceneDesc, id: MaterialId) -> &Material {
    &desc.materials[id.index()]
}

/// The opaque part of a material.
pub(super) fn principled(desc: &SceneDesc) -> &PrincipledMaterial {
    let mut material = material_of(desc, 0);
    loop {
        material = match material {
            Material::TwoSided { front, .. } => inner(desc, *front),
            Material::NormalMap { inner: id, .. } | Material::Mask { inner: id, .. } => {
                inner(desc, *id)
            }
            Material::Blend { first, .. } | Material::Sum { first, .. } => inner(desc, *first),
            Material::Principled(principled) => return principled,
            other => panic!("{other:?}"),
        };
    }
}

pub(super) fn color_at(desc: &SceneDesc, input: ColorInput, u: f32) -> Rgb {
    input.eval(Vec2::new(u, 0.5), &desc.textures)
}

pub(super) fn close(found: Rgb, expected: [f32; 3]) -> bool {
    let pairs = found.to_array().into_iter().zip(expected);
    pairs.into_iter().all(|(a, b)| (a - b).abs() < 2e-3)
}

#[test]
fn defaults_are_white_metal() {
    let desc = load(&changed(&[
        ("/meshes/0/primitives/0/material", json!(0)),
        ("/materials/0", json!({})),
    ]));
    let p = principled(&desc);
    assert_eq!(p.base_color, ColorInput::Constant(Rgb::WHITE));
    assert_eq!(
        (p.metallic, p.roughness),
        (FloatInput::Constant(1.0), FloatInput::Constant(1.0))
    );
    assert!(p.layers.is_some() && (p.eta - 1.5).abs() < 1e-5);
}

#[test]
fn textures_are_decoded_by_their_use() {
    let desc = load(&document(json!({
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.5, 1, 1, 1],
            "baseColorTexture": { "index": 0 },
            "metallicFactor": 0.5,
            "metallicRoughnessTexture": { "index": 0 }
        }
    })));
    let p = principled(&desc);
    assert!(close(
        color_at(&desc, p.base_color, 0.25),
        [0.5, 0.2158, 0.0513]
    ));
    assert!(close(color_at(&desc, p.base_color, 0.75), [0.0, 0.0, 1.0]));
    let value = |input: FloatInput| input.eval(Vec2::new(0.25, 0.5), &desc.textures);
    assert!((value(p.roughness) - 128.0 / 255.0).abs() < 1e-3);
    assert!((value(p.metallic) - 0.5 * 64.0 / 255.0).abs() < 1e-3);
    let Texture::Bitmap(bitmap) = &desc.textures[0] else {
        panic!()
    };
    assert_eq!(
        (bitmap.filtering, bitmap.wrap),
        (Filtering::Nearest, [Wrap::Clamp, Wrap::Mirror])
    );
}

#[test]
fn texture_transforms_move_scale_and_turn() {
    let transform =
        json!({ "offset": [0.25, 0.5], "rotation": std::f64::consts::FRAC_PI_2, "scale": [2, 3] });
    let texture = json!({ "index": 0, "extensions": { "KHR_texture_transform": transform } });
    let desc = load(&document(
        json!({ "pbrMetallicRoughness": { "baseColorTexture": texture } }),
    ));
    let Texture::Transformed { uv_transform, .. } = &desc.textures[1] else {
        panic!()
    };
    // Counterclockwise where v points downwards: u becomes -v.
    let moved = uv_transform.transform_point2(Vec2::new(1.0, 10.0));
    assert!(moved.abs_diff_eq(Vec2::new(30.25, -1.5), 1e-4), "{moved}");
}

#[test]
fn alpha_modes() {
    let opacity = |mode: &str, u: f32| {
        let desc = load(&document(json!({
            "alphaMode": mode,
            "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 }, "baseColorFactor": [1, 1, 1, 0.75] }
        })));
        match material_of(&desc, 0) {
            Material::Mask { opacity, .. } => opacity.eval(Vec2::new(u, 0.5), &desc.textures),
            Material::TwoSided { .. } => 1.0,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(opacity("OPAQUE", 0.25), 1.0);
    assert_eq!([opacity("MASK", 0.25), opacity("MASK", 0.75)], [0.0, 1.0]);
    assert!((opacity("BLEND", 0.25) - 0.15).abs() < 1e-4);
    assert!((opacity("BLEND", 0.75) - 0.6).abs() < 1e-4);
}

#[test]
fn masks_compare_the_opacity_between_texels() {
    // Opacities of 0.2 at u = 0.25 and 0.8 at u = 0.75, times 0.75.
    let mut document = document(json!({
        "alphaMode": "MASK",
        "alphaCutoff": 0.3,
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 }, "baseColorFactor": [1, 1, 1, 0.75] }
    }));
    let opacities = |document: &Value| {
        let desc = load(document);
        let Material::Mask { opacity, .. } = material_of(&desc, 0) else {
            panic!("{:?}", material_of(&desc, 0))
        };
        [0.39, 0.45, 0.49, 0.51].map(|u| opacity.eval(Vec2::new(u, 0.5), &desc.textures))
    };
    assert_eq!(opacities(&document), [0.0, 0.0, 0.0, 1.0]);
    set(&mut document, "/samplers/0/magFilter", json!(9729));
    assert_eq!(opacities(&document), [0.0, 1.0, 1.0, 1.0]);
}

#[test]
fn masks_without_transparent_texels_are_left_out() {
    for (mode, alpha, cutoff) in [("BLEND", 255, 0.5), ("MASK", 128, 0.5), ("MASK", 255, 1.0)] {
        let mut document = document(json!({
            "alphaMode": mode,
            "alphaCutoff": cutoff,
            "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } }
        }));
        set(&mut document, "/samplers/0/magFilter", json!(9729));
        set(
            &mut document,
            "/images/0/uri",
            json!(png(&[[1, 2, 3, alpha]], 1)),
        );
        assert!(
            matches!(material_of(&load(&document), 0), Material::TwoSided { .. }),
            "{mode} {alpha} {cutoff}"
        );
    }
}

#[test]
fn vertex_colors_multiply_the_base_color() {
    let mut document = document(json!({
        "alphaMode": "BLEND",
        "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.5, 0.5, 1] }
    }));
    let colors = add_accessor(
        &mut document,
        &[255, 0, 0, 255, 0, 255, 0, 51, 0, 0, 255, 255],
        5121,
        3,
        "VEC4",
    );
    set(&mut document, "/accessors/4/normalized", json!(true));
    set(
        &mut document,
        "/meshes/0/primitives/0/attributes/COLOR_0",
        json!(colors),
    );
    let desc = load(&document);
    let at = |x: f32, y: f32| TexturePoint {
        coordinates: Vec2::new(x, y),
        ..TexturePoint::default()
    };
    let color = principled(&desc).base_color;
    assert!(close(
        color.eval(at(0.5, 0.25), &desc.textures),
        [0.125, 0.25, 0.125]
    ));
    let Material::Mask { opacity, .. } = material_of(&desc, 0) else {
        panic!()
    };
    assert!((opacity.eval(at(1.0, 0.0), &desc.textures) - 0.2).abs() < 1e-4);
}

#[test]
fn a_second_set_of_texture_coordinates() {
    let material = json!({
        "emissiveFactor": [1, 1, 1],
        "emissiveTexture": { "index": 0, "texCoord": 1 },
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } }
    });
    let mut document = document(material);
    let uvs = add_accessor(
        &mut document,
        &bytes_of(&[0.75, 0.5].repeat(3)),
        5126,
        3,
        "VEC2",
    );
    set(
        &mut document,
        "/meshes/0/primitives/0/attributes/TEXCOORD_1",
        json!(uvs),
    );
    let desc = load(&document);
    let Some(Emitter::Area { radiance }) = desc
        .emitters
        .iter()
        .find(|e| matches!(e, Emitter::Area { .. }))
    else {
        panic!()
    };
    let corner = TexturePoint {
        uv: Vec2::new(0.25, 0.5),
        ..TexturePoint::default()
    };
    assert!(close(
        radiance.eval(corner, &desc.textures),
        [0.0, 0.0, 1.0]
    ));
    assert!(close(
        principled(&desc).base_color.eval(corner, &desc.textures),
        [1.0, 0.2158, 0.0513]
    ));
}

#[test]
fn normal_maps_get_tangents() {
    let material = json!({ "normalTexture": { "index": 0, "scale": 0.5 } });
    let mut document = document(material);
    let desc = load(&document);
    // u grows along x in the triangle.
    assert!(
        mesh(&desc, 0)
            .tangents
            .iter()
            .all(|t| t.abs_diff_eq(manylight::math::Vec3::X, 1e-5))
    );
    let Material::NormalMap {
        scale: 0.5,
        inner: sides,
        ..
    } = material_of(&desc, 0)
    else {
        panic!()
    };
    assert!(matches!(inner(&desc, *sides), Material::TwoSided { .. }));

    let tangents = add_accessor(
        &mut document,
        &bytes_of(&[0.0, 1.0, 0.0, 1.0].repeat(3)),
        5126,
        3,
        "VEC4",
    );
    set(
        &mut document,
        "/meshes/0/primitives/0/attributes/TANGENT",
        json!(tangents),
    );
    assert_eq!(
        mesh(&load(&document), 0).tangents[0],
        manylight::math::Vec3::Y
    );
}

#[test]
fn emission_has_a_strength_and_two_sides() {
    let emissive = |double_sided: bool| {
        load(&document(json!({
            "doubleSided": double_sided,
            "emissiveFactor": [1, 0.5, 0],
            "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 4 } }
        })))
    };
    let desc = emissive(false);
    let emitter = desc.primitives[0].emitter.unwrap();
    let Emitter::Area { radiance } = &desc.emitters[emitter.index()] else {
        panic!()
    };
    assert_eq!(*radiance, ColorInput::Constant(Rgb::new(4.0, 2.0, 0.0)));
    assert_eq!(desc.primitives.len(), 1);
    // The open triangle has a back.
    let desc = emissive(true);
    assert_eq!(desc.primitives.len(), 2);
    assert!(mesh(&desc, 1).positions.iter().all(|p| p.z < 0.0));
}

#[test]
fn variants_choose_materials() {
    let mut document = document(json!({ "pbrMetallicRoughness": { "metallicFactor": 0.25 } }));
    set(
        &mut document,
        "/materials/1",
        json!({ "pbrMetallicRoughness": { "metallicFactor": 0.75 } }),
    );
    set(
        &mut document,
        "/extensions/KHR_materials_variants/variants",
        json!([{ "name": "old" }, { "name": "new" }]),
    );
    set(
        &mut document,
        "/meshes/0/primitives/0/extensions/KHR_materials_variants/mappings",
        json!([{ "material": 1, "variants": [1] }]),
    );
    let named = |name: Option<&str>| GltfOptions {
        variant: name.map(str::to_owned),
        ..GltfOptions::default()
    };
    for (name, metallic) in [(None, 0.25), (Some("old"), 0.25), (Some("new"), 0.75)] {
        let desc = load_with(&document, named(name));
        assert_eq!(principled(&desc).metallic, FloatInput::Constant(metallic));
    }
    let found = Folder::new(&document).problems_with(named(Some("now")));
    assert!(
        found[0].contains("the file has no material variant `now` did you mean `new`? variants of the file: old, new"),
        "{found:?}"
    );
}

#[test]
fn rough_glass_has_the_product_of_factor_and_texture() {
    let desc = load(&document(json!({
        "pbrMetallicRoughness": {
            "metallicFactor": 0,
            "roughnessFactor": 0.5,
            "metallicRoughnessTexture": { "index": 0 }
        },
        "extensions": {
            "KHR_materials_transmission": { "transmissionFactor": 1 },
            "KHR_materials_volume": { "thicknessFactor": 1 }
        }
    })));
    let Material::Dielectric {
        roughness: Some(roughness),
        ..
    } = material_of(&desc, 0)
    else {
        panic!()
    };
    for (u, stored) in [(0.25, 128.0), (0.75, 0.0)] {
        let alpha = roughness.alpha_u.eval(Vec2::new(u, 0.5), &desc.textures);
        let expected: f32 = stored / 255.0 * 0.5;
        assert!((alpha - expected * expected).abs() < 1e-3, "{alpha}");
    }
}

#[test]
fn transforms_of_one_image_share_its_pixels() {
    let texture = |i: usize| {
        let transform = json!({ "offset": [0.5, 0], "scale": [1 + i, 1] });
        json!({ "index": 0, "extensions": { "KHR_texture_transform": transform } })
    };
    let mut document = document(json!({
        "pbrMetallicRoughness": { "baseColorTexture": texture(0) }
    }));
    let primitive = document["meshes"][0]["primitives"][0].clone();
    for i in 0..50 {
        let material = json!({ "pbrMetallicRoughness": { "baseColorTexture": texture(i) } });
        set(&mut document, &format!("/materials/{i}"), material);
        let path = format!("/meshes/0/primitives/{i}");
        set(&mut document, &path, primitive.clone());
        set(&mut document, &format!("{path}/material"), json!(i));
    }
    let desc = load(&document);
    let is_bitmap = |texture: &&Texture| matches!(texture, Texture::Bitmap(_));
    assert_eq!(desc.textures.iter().filter(is_bitmap).count(), 1);
    assert_eq!(desc.textures.len(), 51);
    // u = 0.25 is moved to the second pixel, blue.
    let color = color_at(&desc, principled(&desc).base_color, 0.25);
    assert!(close(color, [0.0, 0.0, 1.0]), "{color:?}");
}
