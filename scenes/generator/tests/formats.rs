//! One generated scene in three formats: the pictures have the same means.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use glam::{DVec2, DVec3};
use manylight::film::{Film, FilmDesc, Filter, Layer};
use manylight::integrators::MethodKind;
use manylight::math::UVec2;
use manylight::render::{Budget, render_film};
use manylight::scene::{PathLimits, Scene as RenderScene};
use manylight_io::{LoadOptions, load_scene};
use manylight_scenes::build::{ball, boxed};
use manylight_scenes::files::{self, Format};
use manylight_scenes::material::{Material, Metal, Reflectance, coated, glass, matte, metal};
use manylight_scenes::mesh::Mesh;
use manylight_scenes::png::PngImage;
use manylight_scenes::pose::Pose;
use manylight_scenes::scene::{About, Camera, Scene, ShapeKind, SpotLight};
use std::path::Path;

/// Largest relative difference of the means of two formats, beside noise.
const TOLERANCE: f64 = 0.005;

/// A stage with a textured floor, a lamp and a colored spot, lit by what all formats can say. With
/// `coats`, a lacquered box and a glass ball stand on it, which glTF says differently.
fn stage(coats: bool) -> Scene {
    let about = About {
        title: "Stage",
        text: Vec::new(),
    };
    let camera = Camera {
        origin: DVec3::new(0.3, 1.2, 4.0),
        target: DVec3::new(0.0, 0.6, 0.0),
        fov_x: 50.0,
        size: [64, 48],
        max_depth: 5,
    };
    let mut scene = Scene::new(about, camera);
    scene.add_texture(
        "tiles",
        PngImage::from_colors([8, 4], |u, v| [0.1 + 0.8 * u, 0.5, 0.9 - 0.8 * v]),
    );
    let floor = scene.add_material("floor", Material::Diffuse(Reflectance::Texture("tiles")));
    let wall = scene.add_material("wall", matte([0.7, 0.6, 0.5]));
    let black = scene.add_material("black", matte([0.0; 3]));
    let copper = scene.add_material("copper", metal(Metal::Copper, 0.25));
    let corners = [(-2.0, 2.0), (2.0, 2.0), (2.0, -2.0), (-2.0, -2.0)];
    let ground = Mesh {
        positions: corners.map(|(x, z)| DVec3::new(x, 0.0, z)).to_vec(),
        normals: vec![DVec3::Y; 4],
        uvs: [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
            .map(DVec2::from)
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    scene.place_mesh("ground", ground, floor);
    let back = Pose::at(0.0, 1.5, -2.0).stretched(2.0, 1.5, 1.0);
    scene.place("back", ShapeKind::Rectangle, back, wall);
    let cube = scene.add_mesh("cube", boxed([-0.3, 0.0, -0.3], [0.3, 0.6, 0.3]));
    let box_material = if coats {
        scene.add_material("lacquer", coated([0.6, 0.1, 0.05], 0.2))
    } else {
        wall
    };
    for (i, turn) in [20.0, 70.0].into_iter().enumerate() {
        let pose = Pose::at(-0.9 + i as f64 * 1.6, 0.0, -0.4)
            .turned(turn)
            .scaled(1.2);
        scene.place(
            &format!("box_{i}"),
            ShapeKind::Mesh(cube),
            pose,
            box_material,
        );
    }
    let vase = scene.add_mesh("vase", ball(0.3, 32));
    let vase_pose = Pose::at(-0.1, 0.3, 0.4).stretched(1.0, 1.4, 1.0);
    scene.place("vase", ShapeKind::Mesh(vase), vase_pose, copper);
    if coats {
        let clear = scene.add_material("clear", glass());
        let pose = Pose::at(0.6, 0.25, 0.9).scaled(0.25);
        scene.place("ball", ShapeKind::Sphere, pose, clear);
    }
    let lamp = Pose::at(-0.8, 2.4, 0.6).tilted(90.0).scaled(0.4);
    scene.place_emitter("lamp", ShapeKind::Rectangle, lamp, black, [9.0, 7.0, 5.0]);
    scene.spots.push(SpotLight {
        origin: DVec3::new(1.5, 2.5, 1.5),
        target: DVec3::new(0.2, 0.0, 0.0),
        intensity: [2.0, 4.0, 8.0],
        cutoff: 35.0,
        // The formats' falloffs differ inside a cone of the same flux, so the edge is narrow.
        beam: 30.0,
    });
    scene
}

/// Mean of the picture of a file and its standard error, by path tracing.
fn picture(file: &Path) -> ([f64; 3], [f64; 3]) {
    let loaded = load_scene(file, &LoadOptions::default())
        .unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let mut desc = loaded.desc;
    // glTF says neither the size of the film nor the length of paths.
    let size = UVec2::new(64, 48);
    desc.sensors[0].film = FilmDesc {
        size,
        crop_offset: UVec2::ZERO,
        crop_size: size,
        filter: Filter::Box,
    };
    desc.limits = PathLimits {
        max_depth: Some(5),
        ..desc.limits
    };
    let scene = RenderScene::build(desc, 0).unwrap();
    let film = render_film(&scene, MethodKind::Path, Budget::passes(256), 3);
    mean(&film)
}

/// Mean of the pixels of a film, and its standard error.
fn mean(film: &Film) -> ([f64; 3], [f64; 3]) {
    let (image, variance) = (film.image(Layer::Beauty).unwrap(), film.variance());
    let count = (image.width * image.height) as f64;
    let (mut sum, mut sum_of_variances) = ([0.0; 3], [0.0; 3]);
    for (x, y) in (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y))) {
        for c in 0..3 {
            sum[c] += f64::from(image.pixel(x, y)[c]);
            sum_of_variances[c] += f64::from(variance.pixel(x, y)[c]);
        }
    }
    (
        sum.map(|sum| sum / count),
        sum_of_variances.map(|sum: f64| sum.sqrt() / count),
    )
}

/// The means of a scene in the three formats.
fn pictures(scene: &Scene) -> [([f64; 3], [f64; 3]); 3] {
    let folder = tempfile::tempdir().unwrap();
    let formats = [Format::Mitsuba, Format::Pbrt, Format::Gltf];
    files::write(scene, &formats, folder.path()).unwrap();
    ["scene.xml", "scene.pbrt", "scene.gltf"].map(|name| picture(&folder.path().join(name)))
}

/// Whether the means agree within `tolerance` and noise.
fn agree(a: &([f64; 3], [f64; 3]), b: &([f64; 3], [f64; 3]), tolerance: f64) -> bool {
    (0..3).all(|c| {
        let noise = a.1[c].hypot(b.1[c]);
        (a.0[c] - b.0[c]).abs() <= tolerance * a.0[c] + 3.0 * noise
    })
}

#[test]
fn what_all_formats_can_say_gives_the_same_picture() {
    let [mitsuba, pbrt, gltf] = pictures(&stage(false));
    assert!(mitsuba.0.iter().all(|mean| *mean > 0.05), "{mitsuba:?}");
    assert!(agree(&mitsuba, &pbrt, TOLERANCE), "{mitsuba:?} {pbrt:?}");
    assert!(agree(&mitsuba, &gltf, TOLERANCE), "{mitsuba:?} {gltf:?}");
    assert!(
        mitsuba
            .1
            .iter()
            .zip(mitsuba.0)
            .all(|(e, mean)| *e < 0.004 * mean),
        "{mitsuba:?}"
    );
}

#[test]
fn coats_and_glass_give_nearly_the_same_picture() {
    let [mitsuba, pbrt, gltf] = pictures(&stage(true));
    assert!(agree(&mitsuba, &pbrt, TOLERANCE), "{mitsuba:?} {pbrt:?}");
    // glTF has no coats over diffuse bases.
    assert!(agree(&mitsuba, &gltf, 0.02), "{mitsuba:?} {gltf:?}");
}
