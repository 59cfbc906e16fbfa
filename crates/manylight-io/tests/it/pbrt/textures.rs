//! Textures by position, and lights with a map of intensities.

use super::{PbrtFiles, load};
use manylight::emitters::Emitter;
use manylight::math::{Vec2, Vec3};
use manylight::scene::{Scene, SceneDesc};
use manylight::texture::{Texture, TexturePoint};

/// The number that texture `index` has at `p` and `uv`.
fn value(desc: &SceneDesc, index: usize, p: Vec3, uv: Vec2) -> f32 {
    let point = TexturePoint {
        p,
        uv,
        ..TexturePoint::default()
    };
    desc.textures[index].eval_float(point, &desc.textures)
}

#[test]
fn patterns_lie_in_the_space_in_which_they_are_defined() {
    let named = ["fbm", "wrinkled", "windy", "marble"];
    for class in named {
        let kind = if class == "marble" {
            "spectrum"
        } else {
            "float"
        };
        let texture = |transform: &str| {
            load(&format!(
                "AttributeBegin {transform} Texture \"t\" \"{kind}\" \"{class}\" AttributeEnd"
            ))
        };
        let (plain, moved) = (texture(""), texture("Translate 1 2 3 Scale 2 2 2"));
        let p = Vec3::new(0.3, 0.7, -1.6);
        let expected = value(&plain, 0, p, Vec2::ZERO);
        let found = value(&moved, 0, p * 2.0 + Vec3::new(1.0, 2.0, 3.0), Vec2::ZERO);
        assert!(
            (found - expected).abs() < 1e-4,
            "{class}: {found} for {expected}"
        );
        assert_ne!(expected, value(&plain, 0, p + 0.4, Vec2::ZERO));
    }
}

#[test]
fn octaves_scale_and_variation_are_read() {
    let desc = load(
        "Texture \"a\" \"float\" \"fbm\" \"integer octaves\" 1 \"float roughness\" 0.25\n\
         Texture \"b\" \"float\" \"fbm\" \"integer octaves\" 2 \"float roughness\" 0.25\n\
         Texture \"c\" \"spectrum\" \"marble\" \"float scale\" 2 \"float variation\" 0\n\
         Texture \"d\" \"spectrum\" \"marble\" \"float variation\" 0",
    );
    let at = |index, p| value(&desc, index, p, Vec2::ZERO);
    let p = Vec3::new(0.3, 0.7, -1.6);
    let expected = at(0, p) + 0.25 * at(0, p * 1.99);
    assert!((at(1, p) - expected).abs() < 1e-5);
    assert!((at(2, p) - at(3, p * 2.0)).abs() < 1e-5);
}

#[test]
fn mappings_by_position_give_texture_coordinates() {
    let board = |mapping: &str| {
        load(&format!(
            "Translate 0 0 1 Texture \"t\" \"float\" \"checkerboard\" \"float tex1\" 1 \"float tex2\" 0 {mapping}"
        ))
    };
    let planar = board(
        "\"string mapping\" \"planar\" \"vector3 v1\" [ 0 0 1 ] \"vector3 v2\" [ 0 1 0 ] \"float udelta\" 0.5",
    );
    let at = |z: f32, y: f32| {
        let last = planar.textures.len() - 1;
        value(&planar, last, Vec3::new(5.0, y, z), Vec2::splat(9.1))
    };
    // u = z - 1 + 0.5, v = y.
    assert_eq!(
        [at(1.2, 0.3), at(1.7, 0.3), at(1.7, 1.3), at(0.2, 0.3)],
        [1.0, 0.0, 1.0, 0.0]
    );
    let uv = board("\"string mapping\" \"uv\" \"float uscale\" 2");
    assert_eq!(value(&uv, 0, Vec3::ZERO, Vec2::new(0.7, 0.3)), 0.0);
    let solid = load(
        "Texture \"t\" \"float\" \"checkerboard\" \"integer dimension\" 3 \"float tex1\" 1 \"float tex2\" 0",
    );
    let at = |p| value(&solid, 0, p, Vec2::ZERO);
    assert_eq!(
        [at(Vec3::splat(0.5)), at(Vec3::new(1.5, 0.5, 0.5))],
        [1.0, 0.0]
    );
}

#[test]
fn patterns_serve_as_bumps_roughness_and_weights() {
    let desc = load(
        "Texture \"waves\" \"float\" \"windy\" Texture \"rough\" \"float\" \"wrinkled\"\n\
         MakeNamedMaterial \"x\" \"string type\" \"diffuse\" \"texture displacement\" \"waves\"\n\
         MakeNamedMaterial \"y\" \"string type\" \"conductor\" \"texture roughness\" \"rough\"\n\
         Texture \"dots\" \"float\" \"dots\" \"float uscale\" 8\n\
         Material \"mix\" \"string materials\" [ \"x\" \"y\" ] \"texture amount\" \"dots\" Shape \"sphere\"",
    );
    let p = Vec3::new(0.3, 0.7, -1.6);
    let root = desc
        .textures
        .iter()
        .position(|t| matches!(t, Texture::Power { .. }))
        .expect("alpha is the root of the roughness");
    let alpha = value(&desc, root, p, Vec2::ZERO);
    assert!((alpha - value(&desc, 1, p, Vec2::ZERO).sqrt()).abs() < 1e-6);
    Scene::build(desc, 0).unwrap();
}

/// The upper half of the map's sphere (its +z) emits twice as much as the lower half. It lies
/// towards +y of the light.
#[test]
fn goniometric_lights_have_their_axis_along_y() {
    let n = 32;
    let mut image = format!("Pf\n{n} {n}\n-1\n").into_bytes();
    let mut sum = 0.0;
    for i in 0..n * n {
        let (x, y) = ((i % n) as f32 + 0.5, (i / n) as f32 + 0.5);
        let distance = (2.0 * x / n as f32 - 1.0).abs() + (2.0 * y / n as f32 - 1.0).abs();
        let value: f32 = if distance < 1.0 { 2.0 } else { 1.0 };
        image.extend(value.to_le_bytes());
        sum += value;
    }
    let mean = sum / (n * n) as f32;
    let scene = |more: &str| {
        let text = format!(
            "Camera \"perspective\" WorldBegin Translate 1 2 3 Rotate 90 1 0 0\n\
             LightSource \"goniometric\" \"rgb I\" [ 1 2 3 ] \"string filename\" \"lamp.pfm\" {more}"
        );
        let loaded = PbrtFiles::new(text.as_bytes(), &[("lamp.pfm", &image)]).load();
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        loaded.desc
    };
    let desc = scene("");
    let Emitter::Goniometric { position, .. } = desc.emitters[0] else {
        panic!("{:?}", desc.emitters)
    };
    assert_eq!(position, Vec3::new(1.0, 2.0, 3.0));
    // The rotation turns +y to +z.
    let towards = |desc: &SceneDesc, w| desc.emitters[0].point_intensity(&desc.textures, w).r;
    let (up, down) = (
        towards(&desc, Vec3::Z),
        towards(&desc, Vec3::new(0.3, 0.2, -1.0).normalize()),
    );
    assert!(
        (up - 2.0).abs() < 0.02 && (down - 1.0).abs() < 0.02,
        "{up} {down}"
    );
    let bright = scene("\"float power\" 100");
    let factor = towards(&bright, Vec3::Z) / up;
    // 100 lm over 4π times the mean of the map.
    let expected = 100.0 / (4.0 * std::f32::consts::PI * mean);
    assert!(
        (factor / expected - 1.0).abs() < 1e-3,
        "{factor} for {expected}"
    );
}

#[test]
fn goniometric_lights_without_a_map_have_their_power() {
    let intensity = |power: &str| {
        let desc = load(&format!(
            "LightSource \"goniometric\" \"rgb I\" [ 1 2 3 ] {power}"
        ));
        match desc.emitters.last() {
            Some(Emitter::Point { intensity, .. }) => *intensity,
            other => panic!("{other:?}"),
        }
    };
    let plain = intensity("");
    for none in ["-1", "0"] {
        assert_eq!(intensity(&format!("\"float power\" {none}")), plain);
    }
    let factor = intensity("\"float power\" 100").g / plain.g;
    assert!((factor * 4.0 * std::f32::consts::PI - 100.0).abs() < 1e-3);
}
