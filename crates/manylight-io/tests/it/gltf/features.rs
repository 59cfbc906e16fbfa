//! Lights, cameras, environments, and what is ignored with a warning.

use super::*;
use manylight::color::Rgb;
use manylight::emitters::{Emitter, SpotFalloff};
use manylight::math::{UVec2, Vec3};
use manylight::scene::LightGroupNames;
use manylight::sensors::{FovAxis, Sensor, SensorKind};
use manylight_io::{EnvironmentSource, LightUnits};
use std::f32::consts::PI;

fn light(light: Value, generator: &str, units: Option<LightUnits>) -> Emitter {
    let document = changed(&[
        ("/extensions/KHR_lights_punctual/lights/0", light),
        ("/asset/generator", json!(generator)),
        // Turns -z to -x.
        ("/nodes/1/rotation", json!([0, 1, 0, 1])),
        ("/nodes/1/scale", json!([3, 3, 3])),
    ]);
    let options = GltfOptions {
        light_units: units,
        ..GltfOptions::default()
    };
    load_with(&document, options).emitters.remove(0)
}

#[test]
fn units_of_lights() {
    let blender = "Khronos glTF Blender I/O v4.3.47";
    let intensity = |kind: &str, generator: &str, units: Option<LightUnits>| {
        let json = json!({ "type": kind, "intensity": 683, "color": [1, 0.5, 0], "spot": {} });
        match light(json, generator, units) {
            Emitter::Point { intensity, .. } | Emitter::Spot { intensity, .. } => intensity,
            Emitter::Directional { irradiance, .. } => irradiance,
            other => panic!("{other:?}"),
        }
    };
    let color = |strength: f32| Rgb::new(1.0, 0.5, 0.0) * strength;
    for (kind, raw) in [
        ("point", 683.0 / (4.0 * PI)),
        ("spot", 683.0 / (4.0 * PI)),
        ("directional", 683.0),
    ] {
        assert_eq!(intensity(kind, "THREE.GLTFExporter", None), color(683.0));
        assert_eq!(intensity(kind, blender, None), color(1.0));
        assert_eq!(
            intensity(kind, blender, Some(LightUnits::Watt)),
            color(683.0)
        );
        assert_eq!(intensity(kind, "", Some(LightUnits::Lumen)), color(1.0));
        assert_eq!(intensity(kind, "", Some(LightUnits::Raw)), color(raw));
    }
}

#[test]
fn spots_have_an_axis_and_cones() {
    let json = json!({ "type": "spot", "spot": { "innerConeAngle": 0.25, "outerConeAngle": 0.5 } });
    let Emitter::Spot {
        direction,
        cutoff,
        beam_width,
        falloff,
        ..
    } = light(json.clone(), "", None)
    else {
        panic!()
    };
    assert!(direction.abs_diff_eq(Vec3::NEG_X, 1e-6), "{direction}");
    assert_eq!(
        (cutoff, beam_width, falloff),
        (0.5, 0.25, SpotFalloff::SmoothCosine)
    );
    // Half of the range of cosines, for a blend of 0.5.
    let Emitter::Spot { beam_width, .. } = light(json, "Blender", None) else {
        panic!()
    };
    assert!((beam_width.cos() - 0.5 * (1.0 + cutoff.cos())).abs() < 1e-5);
}

#[test]
fn cameras_look_along_minus_z() {
    let desc = load(&changed(&[
        ("/nodes/0/camera", json!(0)),
        ("/nodes/0/translation", json!([0, 0, 5])),
        ("/nodes/1/camera", json!(1)),
        (
            "/cameras",
            json!([
                { "type": "perspective", "perspective": { "yfov": 0.5, "aspectRatio": 2, "znear": 0.5, "zfar": 100 } },
                { "type": "orthographic", "orthographic": { "xmag": 3, "ymag": 6, "znear": 0, "zfar": 10 } }
            ]),
        ),
    ]));
    let [perspective, orthographic] = desc.sensors.as_slice() else {
        panic!()
    };
    assert_eq!(perspective.film.size, UVec2::new(1280, 640));
    let SensorKind::Perspective {
        fov,
        fov_axis: FovAxis::Y,
    } = perspective.kind
    else {
        panic!()
    };
    assert!((fov - 0.5f32.to_degrees()).abs() < 1e-4);
    let lens = manylight::math::Vec2::splat(0.5);
    // The upper right corner: to +x and +y.
    let ray = Sensor::new(perspective.clone()).ray(manylight::math::Vec2::new(1280.0, 0.0), lens);
    let expected = Vec3::new(2.0 * 0.25f32.tan(), 0.25f32.tan(), -1.0);
    assert!(ray.d.abs_diff_eq(expected.normalize(), 1e-4), "{}", ray.d);
    assert!((ray.o.z - 4.5).abs() < 1e-5);

    assert_eq!(orthographic.film.size, UVec2::new(640, 1280));
    let ray = Sensor::new(orthographic.clone()).ray(manylight::math::Vec2::new(640.0, 0.0), lens);
    assert!(
        ray.o.abs_diff_eq(Vec3::new(3.0, 6.0, 0.0), 1e-4) && ray.d.abs_diff_eq(Vec3::NEG_Z, 1e-6)
    );
    assert!((ray.t_max - 10.0).abs() < 1e-4);
}

#[test]
fn a_camera_shows_the_whole_scene_if_there_is_none() {
    for scale in [1e-3, 1.0, 1e4] {
        let desc = load(&changed(&[
            ("/nodes/0/scale", json!([scale, scale, scale])),
            ("/nodes/0/translation", json!([7.0 * scale, 0, 0])),
        ]));
        let sensor = Sensor::new(desc.sensors[0].clone());
        for corner in [Vec3::ZERO, Vec3::X, Vec3::Y] {
            let p = desc.primitives[0]
                .world_from_object
                .transform_point3(corner);
            assert!(
                sensor
                    .connect(p, manylight::math::Vec2::splat(0.5))
                    .is_some(),
                "{p}"
            );
        }
    }
}

fn without_light() -> Value {
    changed(&[("/scenes/0/nodes", json!([0]))])
}

#[test]
fn scenes_without_light_are_white() {
    let folder = Folder::new(&without_light());
    let found = folder.problems();
    assert!(
        matches!(found.as_slice(), [only] if only.contains("neither lights nor surfaces that emit one color")),
        "{found:?}"
    );
    let desc = load_scene(&folder.file, &LoadOptions::default())
        .unwrap()
        .desc;
    assert!(matches!(
        desc.emitters.as_slice(),
        [Emitter::Constant {
            radiance: Rgb::WHITE
        }]
    ));
}

#[test]
fn surfaces_that_emit_by_textures_do_not_count_as_lights() {
    let emissive = |texture: bool| {
        let mut document = without_light();
        set(
            &mut document,
            "/materials/0/emissiveFactor",
            json!([1, 1, 1]),
        );
        if texture {
            let image = json!([{ "uri": super::materials::png(&[[255, 255, 255, 255]], 1) }]);
            set(
                &mut document,
                "/materials/0/emissiveTexture",
                json!({ "index": 0 }),
            );
            set(&mut document, "/textures", json!([{ "source": 0 }]));
            set(&mut document, "/images", image);
        }
        Folder::new(&document)
    };
    let has_environment = |folder: &Folder| {
        let loaded = load_scene(&folder.file, &LoadOptions::default()).unwrap();
        let emitters = &loaded.desc.emitters;
        emitters
            .iter()
            .any(|e| matches!(e, Emitter::Constant { .. }))
    };
    let lamp = emissive(false);
    assert!(!has_environment(&lamp));
    assert!(lamp.problems()[0].contains("emitting surfaces alone light the scene"));
    assert!(has_environment(&emissive(true)));
}

#[test]
fn environments_are_centered_at_plus_x() {
    let options = |environment, scale| GltfOptions {
        environment: Some(environment),
        environment_scale: scale,
        ..GltfOptions::default()
    };
    let white = load_with(&without_light(), options(EnvironmentSource::White, 2.0));
    assert!(
        matches!(white.emitters[0], Emitter::Constant { radiance } if radiance == Rgb::splat(2.0))
    );

    // A gray ramp over eight columns: 0 to 7.
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("sky.pfm");
    let mut bytes = b"Pf\n8 2\n-1\n".to_vec();
    bytes.extend(bytes_of(
        &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0].repeat(2),
    ));
    std::fs::write(&file, bytes).unwrap();
    let mut desc = load_with(
        &without_light(),
        options(EnvironmentSource::File(file), 1.0),
    );
    // Nothing but the environment.
    desc.primitives.clear();
    let scene = manylight::scene::Scene::build(desc, 0).unwrap();
    let radiance = |w: Vec3| scene.emitters.environment(None, w, None).0.r;
    assert!(
        (radiance(Vec3::X) - 3.5).abs() < 0.1,
        "{}",
        radiance(Vec3::X)
    );
    assert!(
        (radiance(Vec3::Z) - 5.5).abs() < 0.1,
        "{}",
        radiance(Vec3::Z)
    );
    assert!((radiance(Vec3::NEG_Z) - 1.5).abs() < 0.1);

    let missing = EnvironmentSource::File("none.hdr".into());
    let found = Folder::new(&without_light()).problems_with(options(missing, 1.0));
    assert!(
        found
            .iter()
            .any(|p| p.contains("cannot use the environment none.hdr: the file does not exist")),
        "{found:?}"
    );
}

#[test]
fn ignored_features_are_named_once() {
    let document = changed(&[
        (
            "/animations",
            json!([{ "channels": [{ "target": { "node": 0, "path": "rotation" } }] }, {}]),
        ),
        (
            "/extensionsUsed",
            json!([
                "KHR_lights_punctual",
                "EXT_lights_image_based",
                "KHR_xmp_json_ld"
            ]),
        ),
        ("/nodes/0/scale", json!([1, 0, 1])),
    ]);
    let found = Folder::new(&document).problems();
    assert_eq!(found.len(), 3, "{found:?}");
    for expected in [
        "animations of objects are ignored",
        "`EXT_lights_image_based` is ignored",
        "a scale of 0",
    ] {
        assert!(
            found.iter().any(|problem| problem.contains(expected)),
            "{found:?}"
        );
    }
}

#[test]
fn objects_and_materials_have_names() {
    let named = changed(&[
        ("/nodes/0/name", json!("chair")),
        ("/materials/0/name", json!("oak")),
    ]);
    for (document, object, material) in [
        (named, "chair", "oak"),
        (triangle(), "mesh_0", "material_0"),
    ] {
        let scene = load(&document);
        let primitive = &scene.primitives[0];
        let found = &scene.material_names[primitive.material.index()];
        assert_eq!(
            (primitive.name.as_str(), found.as_str()),
            (object, material)
        );
    }
}

/// What a file of a program that rewrites others says of a lamp of these watts in Blender: its
/// radiant intensity here, and the warnings.
fn rewritten(intensity: f64) -> (f32, Vec<String>) {
    let document = changed(&[
        ("/asset/generator", json!("glTF-Transform v4.5.1")),
        (
            "/extensions/KHR_lights_punctual/lights/0",
            json!({ "type": "point", "intensity": intensity }),
        ),
    ]);
    let folder = Folder::new(&document);
    let desc = load_scene(&folder.file, &LoadOptions::default())
        .unwrap()
        .desc;
    let Emitter::Point { intensity, .. } = desc.emitters[0] else {
        panic!()
    };
    (intensity.g, folder.problems())
}

#[test]
fn blender_is_known_by_its_lamps_where_its_name_was_replaced() {
    let lamp = |watts: f64| watts * 683.0 / (4.0 * std::f64::consts::PI);
    let (intensity, warnings) = rewritten(lamp(40.0));
    assert!((intensity - 40.0 / (4.0 * PI)).abs() < 1e-4, "{intensity}");
    assert!(warnings.is_empty(), "{warnings:?}");
    // Round numbers are not those of Blender's exporter.
    let (intensity, warnings) = rewritten(2000.0);
    assert!((intensity - 2000.0).abs() < 1e-3);
    assert!(
        matches!(warnings.as_slice(), [only] if only.contains("--light-units lm")),
        "{warnings:?}"
    );
}

#[test]
fn emission_textures_of_large_meshes_are_scanned_once() {
    /// Squares of a row: 20,000 triangles.
    const SIDE: usize = 100;
    let mut document = super::materials::document(json!({
        "emissiveFactor": [1, 1, 1],
        "emissiveTexture": { "index": 0 }
    }));
    let image = super::materials::png(&vec![[255, 128, 64, 255]; 1024 * 1024], 1024);
    set(&mut document, "/images", json!([{ "uri": image }]));
    let corner = |x: usize, y: usize| [x as f32, y as f32];
    let squares = (0..SIDE * SIDE).map(|i| (i % SIDE, i / SIDE));
    let corners: Vec<[f32; 2]> = squares
        .flat_map(|(x, y)| {
            [(0, 0), (1, 0), (1, 1), (0, 0), (1, 1), (0, 1)].map(|(u, v)| corner(x + u, y + v))
        })
        .collect();
    let positions: Vec<f32> = corners.iter().flat_map(|[x, y]| [*x, *y, 0.0]).collect();
    let uvs: Vec<f32> = corners
        .as_flattened()
        .iter()
        .map(|v| v / SIDE as f32)
        .collect();
    let position = add_accessor(
        &mut document,
        &bytes_of(&positions),
        5126,
        corners.len(),
        "VEC3",
    );
    let uv = add_accessor(&mut document, &bytes_of(&uvs), 5126, corners.len(), "VEC2");
    let primitive =
        json!([{ "attributes": { "POSITION": position, "TEXCOORD_0": uv }, "material": 0 }]);
    set(&mut document, "/meshes/0/primitives", primitive);
    let folder = Folder::new(&document);
    let desc = load_scene(&folder.file, &LoadOptions::default())
        .unwrap()
        .desc;
    let start = std::time::Instant::now();
    manylight::scene::Scene::build(desc, 0).unwrap();
    // 2 · 10¹⁰ texels take minutes.
    assert!(start.elapsed().as_secs() < 30);
}

#[test]
fn nodes_name_light_groups() {
    let names = |changes: &[(&str, Value)]| {
        let mut all = vec![
            ("/materials/0/emissiveFactor", json!([1, 1, 1])),
            ("/nodes/0/name", json!("screen")),
            ("/nodes/1/name", json!("lamp")),
        ];
        all.extend_from_slice(changes);
        let options = GltfOptions {
            environment: Some(EnvironmentSource::White),
            ..GltfOptions::default()
        };
        let mut names = LightGroupNames::of(&load_with(&changed(&all), options)).0;
        names.dedup_by(|a, b| a.1 == b.1);
        names.into_iter().map(|(_, name)| name).collect::<Vec<_>>()
    };
    assert_eq!(names(&[]), ["screen", "lamp", "environment"]);
    let extras = [
        ("/nodes/0/extras", json!({ "light_group": "key" })),
        ("/nodes/1/extras", json!({ "lightgroup": "fill" })),
    ];
    assert_eq!(names(&extras), ["key", "fill", "environment"]);
    // Anything may stand in extras.
    let others = [
        ("/nodes/0/extras", json!([1, 2])),
        ("/nodes/1/extras", json!({ "lightgroup": 7 })),
    ];
    assert_eq!(names(&others), ["screen", "lamp", "environment"]);
}
