//! Surfaces that emit and are not opaque, and the two sides of surfaces.

use super::materials::{document, png};
use super::*;
use manylight::bsdf::Lobes;
use manylight::color::Rgb;
use manylight::emitters::Emitter;
use manylight::geometry::Ray;
use manylight::math::Vec3;
use manylight::scene::Scene;

/// The radiance that is emitted towards the start of a ray, past all surfaces that let light pass.
fn seen(scene: &Scene, from: Vec3, towards: Vec3) -> Rgb {
    let (mut sum, mut through) = (Rgb::BLACK, Rgb::WHITE);
    let mut ray = Ray::new(from, towards);
    for _ in 0..16 {
        let Some((_, x)) = scene.intersect(&ray) else {
            break;
        };
        let (geometry, textures) = (&scene.geometry, &scene.textures);
        sum += through * scene.emitters.radiance(geometry, textures, &x, -towards);
        through *= scene.bsdf(&x).transmittance(towards);
        ray = x.spawn(towards);
    }
    sum
}

/// A triangle that emits red, before one that emits blue on both sides, and after another.
fn between_blue(material: Value, attributes: Option<[f32; 4]>) -> Scene {
    let mut document = document(material);
    let blue = json!({
        "emissiveFactor": [0, 0, 1],
        "doubleSided": true,
        "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1] }
    });
    set(&mut document, "/materials/1", blue);
    let mesh = document["meshes"][0].clone();
    set(&mut document, "/meshes/1", mesh);
    set(&mut document, "/meshes/1/primitives/0/material", json!(1));
    for (node, z) in [(2, -1), (3, 1)] {
        let placed = json!({ "mesh": 1, "translation": [0, 0, z] });
        set(&mut document, &format!("/nodes/{node}"), placed);
    }
    set(&mut document, "/scenes/0/nodes", json!([0, 2, 3]));
    if let Some(color) = attributes {
        let accessor = add_accessor(&mut document, &bytes_of(&color.repeat(3)), 5126, 3, "VEC4");
        let path = "/meshes/0/primitives/0/attributes/COLOR_0";
        set(&mut document, path, json!(accessor));
    }
    let folder = Folder::new(&document);
    let desc = load_scene(&folder.file, &LoadOptions::default())
        .unwrap()
        .desc;
    Scene::build(desc, 0).unwrap()
}

/// What is seen of the middle triangle from its front and from its back, at the texel `u`.
fn both_sides(scene: &Scene, u: f32) -> [[f32; 3]; 2] {
    [1.0, -1.0].map(|side: f32| {
        let from = Vec3::new(u, 0.1, 0.5 * side);
        let color = seen(scene, from, Vec3::new(0.0, 0.0, -side));
        color.to_array().map(|v| (v * 1000.0).round() / 1000.0)
    })
}

#[test]
fn opacity_scales_emission_and_passes_the_rest_once() {
    let factor = json!({ "baseColorFactor": [0, 0, 0, 0.25] });
    for (double_sided, back) in [(false, [0.0, 0.0, 0.75]), (true, [0.25, 0.0, 0.75])] {
        let scene = between_blue(
            json!({
                "alphaMode": "BLEND",
                "doubleSided": double_sided,
                "emissiveFactor": [1, 0, 0],
                "pbrMetallicRoughness": factor
            }),
            None,
        );
        assert_eq!(both_sides(&scene, 0.2), [[0.25, 0.0, 0.75], back]);
        let sent = |emitter: &Emitter| matches!(emitter, Emitter::Area { radiance } if *radiance == manylight::texture::ColorInput::Constant(Rgb::new(0.25, 0.0, 0.0)));
        assert!(scene.emitters.descriptions().iter().any(sent));
    }
    // Unlit, with the opacity of vertices.
    let unlit = json!({
        "alphaMode": "BLEND",
        "extensions": { "KHR_materials_unlit": {} },
        "pbrMetallicRoughness": { "baseColorFactor": [1, 0, 0, 1] }
    });
    let scene = between_blue(unlit, Some([1.0, 1.0, 1.0, 0.5]));
    assert_eq!(both_sides(&scene, 0.2), [[0.5, 0.0, 0.5]; 2]);
    // An opacity of 0 leaves no emitter.
    let invisible = json!({
        "alphaMode": "BLEND",
        "emissiveFactor": [1, 0, 0],
        "pbrMetallicRoughness": { "baseColorFactor": [1, 0, 0, 0] }
    });
    let scene = between_blue(invisible, None);
    assert_eq!(both_sides(&scene, 0.2), [[0.0, 0.0, 1.0]; 2]);
}

#[test]
fn cut_out_texels_do_not_emit() {
    // Opacities of 0.2 and 0.8.
    let texture = json!({ "baseColorTexture": { "index": 0 }, "baseColorFactor": [0, 0, 0, 1] });
    let mask = json!({
        "alphaMode": "MASK",
        "doubleSided": true,
        "emissiveFactor": [1, 0, 0],
        "pbrMetallicRoughness": texture
    });
    let (red, blue) = ([[1.0, 0.0, 0.0]; 2], [[0.0, 0.0, 1.0]; 2]);
    let scene = between_blue(mask.clone(), None);
    assert_eq!(
        (both_sides(&scene, 0.2), both_sides(&scene, 0.7)),
        (blue, red)
    );
    // The opacity of the vertices is a factor before the comparison: 0.8 · 0.5 < 0.5.
    let scene = between_blue(mask, Some([1.0, 1.0, 1.0, 0.5]));
    assert_eq!(
        (both_sides(&scene, 0.2), both_sides(&scene, 0.7)),
        (blue, blue)
    );
}

#[test]
fn a_masked_lamp_of_one_color_lights_its_scene_alone() {
    let texture = json!({ "baseColorTexture": { "index": 0 }, "baseColorFactor": [0, 0, 0, 1] });
    for (by_texture, expected) in [
        (false, "emitting surfaces alone"),
        (true, "white environment"),
    ] {
        let mut mask = json!({
            "alphaMode": "MASK",
            "emissiveFactor": [1, 0, 0],
            "pbrMetallicRoughness": texture
        });
        if by_texture {
            set(&mut mask, "/emissiveTexture", json!({ "index": 0 }));
        }
        let mut document = document(mask);
        // Without the light of the document.
        set(&mut document, "/nodes", json!([{ "mesh": 0 }]));
        set(&mut document, "/scenes/0/nodes", json!([0]));
        let found = Folder::new(&document).problems();
        assert!(
            found.iter().any(|text| text.contains(expected)),
            "{found:?}"
        );
    }
}

/// Light of a normal-mapped triangle towards the viewer on the `side` of the z axis, from a
/// direction that is tilted by `x`.
fn reflected(document: &Value, side: f32, x: f32) -> f32 {
    reflected_from(document, Vec3::new(x, 0.0, side))
}

/// The same, from the direction `from`.
fn reflected_from(document: &Value, from: Vec3) -> f32 {
    let side = 1.0f32.copysign(from.z);
    let folder = Folder::new(document);
    let desc = load_scene(&folder.file, &LoadOptions::default())
        .unwrap()
        .desc;
    let scene = Scene::build(desc, 0).unwrap();
    let ray = Ray::new(Vec3::new(0.2, 0.2, side), Vec3::new(0.0, 0.0, -side));
    let (_, at) = scene.intersect(&ray).unwrap();
    let wo = Vec3::new(0.0, 0.0, side);
    let bsdf = scene.bsdf(&at);
    bsdf.f_cos_wi(from.normalize(), wo, Lobes::ALL).g
}

#[test]
fn tangents_say_to_which_side_normals_are_bent() {
    // A normal that is bent along the bitangent, n x t times w. The texture coordinates alone would
    // have it along y for all of the tangents along x.
    let mut document = document(json!({
        "normalTexture": { "index": 0 },
        "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 1 }
    }));
    let image = json!([{ "uri": png(&[[128, 204, 231, 255]; 2], 2) }]);
    set(&mut document, "/images", image);
    let up = |document: &Value, side: f32| {
        let [up, down] = [0.5, -0.5].map(|y| reflected_from(document, Vec3::new(0.0, y, side)));
        assert!((up / down).max(down / up) > 1.5, "{up} {down}");
        up > down
    };
    let by_texture = up(&document, 1.0);
    for w in [1.0, -1.0] {
        let tangent = bytes_of(&[1.0, 0.0, 0.0, w].repeat(3));
        let accessor = add_accessor(&mut document, &tangent, 5126, 3, "VEC4");
        let path = "/meshes/0/primitives/0/attributes/TANGENT";
        set(&mut document, path, json!(accessor));
        assert_eq!(up(&document, 1.0), w > 0.0);
        // All of the normal is reversed on the back.
        assert_eq!(up(&document, -1.0), w < 0.0);
        // Mirrors turn the bitangent with the surface.
        for (scale, side, turns) in [([-1, 1, 1], 1.0, false), ([1, -1, 1], 1.0, true)] {
            set(&mut document, "/nodes/0/scale", json!(scale));
            set(&mut document, "/nodes/0/translation", json!([0, 0, 0]));
            let mut seen = document.clone();
            // The triangle stays where it is seen.
            let moved = scale.map(|s| if s < 0 { 0.4 } else { 0.0 });
            set(&mut seen, "/nodes/0/translation", json!(moved));
            assert_eq!(up(&seen, side), (w > 0.0) != turns, "{scale:?} {w}");
        }
        set(&mut document, "/nodes/0/scale", json!([1, 1, 1]));
        // The second surface of one that emits is the back of the first.
        set(&mut document, "/materials/0/doubleSided", json!(true));
        set(
            &mut document,
            "/materials/0/emissiveFactor",
            json!([1, 1, 1]),
        );
        assert_eq!(up(&document, -1.0), w < 0.0);
        set(
            &mut document,
            "/materials/0/emissiveFactor",
            json!([0, 0, 0]),
        );
    }
    assert!(by_texture);
}

#[test]
fn all_of_the_normal_is_reversed_on_the_back() {
    // A normal that is tilted towards +x: seen from behind, the surface leans to -x.
    let mut document = document(json!({
        "normalTexture": { "index": 0 },
        "doubleSided": true,
        "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 1 }
    }));
    let image = json!([{ "uri": png(&[[204, 128, 231, 255]; 2], 2) }]);
    set(&mut document, "/images", image);
    let front = [0.5, -0.5].map(|x| reflected(&document, 1.0, x));
    let back = [0.5, -0.5].map(|x| reflected(&document, -1.0, x));
    assert!(front[0] > 1.5 * front[1], "{front:?}");
    assert!(back[1] > 1.5 * back[0], "{back:?}");
    assert!(
        (front[0] - back[1]).abs() < 1e-3 * front[0],
        "{front:?} {back:?}"
    );
    // A node that is mirrored along the normal shows the same front from the other side.
    set(&mut document, "/nodes/0/scale", json!([1, 1, -1]));
    let mirrored = [0.5, -0.5].map(|x| reflected(&document, -1.0, x));
    assert!(
        (mirrored[0] - front[0]).abs() < 1e-3 * front[0],
        "{mirrored:?}"
    );
    // The second surface of one that emits on both sides is the back of the first.
    set(&mut document, "/nodes/0/scale", json!([1, 1, 1]));
    set(
        &mut document,
        "/materials/0/emissiveFactor",
        json!([1, 1, 1]),
    );
    let second = [0.5, -0.5].map(|x| reflected(&document, -1.0, x));
    assert!(
        (second[1] - back[1]).abs() < 1e-3 * back[1],
        "{second:?} {back:?}"
    );
}
