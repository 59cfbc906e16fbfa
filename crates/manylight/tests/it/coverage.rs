//! Alpha, positions and mattes of objects and materials: against areas that are known, by every
//! method with camera paths.

use crate::common::{film_with, mixed};
use manylight::bsdf::Material;
use manylight::color::Rgb;
use manylight::emitters::Emitter;
use manylight::film::{Film, Filter, IdLayer, Layer};
use manylight::integrators::{ExtraLayers, ManyLight, MethodKind, PhotonMap};
use manylight::math::{UVec2, Vec3};
use manylight::scene::{PathLimits, Scene};
use manylight::testing::scenes::{Builder, diffuse};
use manylight::texture::FloatInput;

const SIZE: u32 = 8;

fn methods() -> [(MethodKind, u32); 5] {
    let few = ManyLight {
        photon_paths: 100,
        importon_paths: 10,
        light_count: 4,
        ..ManyLight::rich_vpl()
    };
    let photons = PhotonMap {
        photon_paths: 100,
        ..PhotonMap::progressive()
    };
    [
        (MethodKind::Path, 256),
        (MethodKind::ManyLight(few), 64),
        (MethodKind::Mixed(mixed(few)), 64),
        (MethodKind::PhotonMap(photons), 64),
        (MethodKind::Aov, 256),
    ]
}

/// The camera at z = 10 looks at the square [-1, 1]² of the plane z = 0, which fills the film. Its
/// right half has a sheet of opacity 0.25, its upper half an opaque emitter behind, at z = 0.
fn sheets() -> Builder {
    let fov = 2.0 * (0.1_f32).atan().to_degrees();
    let mut b = Builder::new(Vec3::Z * 10.0, Vec3::ZERO, fov, SIZE);
    let wall = b.material(diffuse(0.5, 0.5, 0.5));
    let leaf = b.material(diffuse(0.1, 0.6, 0.1));
    let mask = b.material(Material::Mask {
        opacity: FloatInput::Constant(0.25),
        inner: leaf,
    });
    b.desc.material_names = ["wall", "leaf"].map(str::to_owned).into();
    let lamp = b.area_light(Rgb::WHITE);
    let (x, y) = (Vec3::X, Vec3::Y);
    // The camera sees +x on the right: it looks along -z.
    b.rectangle(x * 2.0 + Vec3::Z * 1e-3, x * 2.0, y * 4.0, mask, None);
    b.rectangle(y * 2.0, x * 4.0, y * 2.0, wall, Some(lamp));
    b.desc.primitives[0].name = "sheet".into();
    b.desc.primitives[1].name = "panel".into();
    b
}

fn all_layers() -> ExtraLayers {
    ExtraLayers {
        position: true,
        objects: true,
        materials: true,
        ..ExtraLayers::default()
    }
}

fn render(scene: &Scene, kind: MethodKind, passes: u32) -> Film {
    film_with(scene, kind, all_layers(), passes, 3)
}

/// Mean coverage of a quadrant by a name; quadrants are upper left, upper right, lower left, lower
/// right.
fn coverage(film: &Film, scene: &Scene, layer: IdLayer, name: &str, quadrant: usize) -> f32 {
    let id = scene.names.names(layer).iter().position(|n| n == name);
    let id = id.expect("the name belongs to the scene") as u32;
    let ranked = film.ranked_ids(layer).unwrap();
    mean(quadrant, |i| {
        let found = ranked[i].iter().find(|(other, _)| *other == id);
        found.map_or(0.0, |(_, coverage)| *coverage)
    })
}

/// Mean over the pixels of a quadrant.
fn mean(quadrant: usize, value: impl Fn(usize) -> f32) -> f32 {
    let half = (SIZE / 2) as usize;
    let (first_row, first_column) = (quadrant / 2 * half, quadrant % 2 * half);
    let pixels = (0..half * half).map(|i| {
        let (row, column) = (first_row + i / half, first_column + i % half);
        value(row * SIZE as usize + column)
    });
    pixels.sum::<f32>() / (half * half) as f32
}

#[track_caller]
fn assert_near(found: f32, expected: f32, what: &str) {
    // 16 pixels with at least 64 samples each: a fraction of 1/4 has a standard deviation of 0.014.
    let tolerance = if expected == 0.0 || expected == 1.0 {
        1e-5
    } else {
        0.06
    };
    assert!(
        (found - expected).abs() < tolerance,
        "{what}: {found}, expected {expected}"
    );
}

#[test]
fn every_method_finds_the_covered_fractions() {
    let scene = sheets().build();
    for (kind, passes) in methods() {
        let film = render(&scene, kind.clone(), passes);
        let alpha = film.alpha().unwrap();
        for (quadrant, [sheet, panel]) in [[0.0, 1.0], [0.25, 0.75], [0.0, 0.0], [0.25, 0.0]]
            .into_iter()
            .enumerate()
        {
            let what = |name: &str| format!("{kind:?} {name} in quadrant {quadrant}");
            assert_near(
                mean(quadrant, |i| alpha.data[i]),
                sheet + panel,
                &what("alpha"),
            );
            let of = |layer, name| coverage(&film, &scene, layer, name, quadrant);
            assert_near(of(IdLayer::Object, "sheet"), sheet, &what("sheet"));
            assert_near(of(IdLayer::Object, "panel"), panel, &what("panel"));
            assert_near(of(IdLayer::Material, "leaf"), sheet, &what("leaf"));
            assert_near(of(IdLayer::Material, "wall"), panel, &what("wall"));
        }
        for ranked in film.ranked_ids(IdLayer::Object).unwrap() {
            let sum: f32 = ranked.iter().map(|(_, coverage)| coverage).sum();
            assert!(sum <= 1.0 + 1e-6, "{kind:?}: {sum}");
            assert!(
                ranked.is_sorted_by(|a, b| a.1 >= b.1),
                "{kind:?}: {ranked:?}"
            );
        }
    }
}

#[test]
fn positions_are_those_of_the_pixels() {
    let scene = sheets().build();
    for (kind, passes) in methods() {
        let position = render(&scene, kind.clone(), passes)
            .image(Layer::Position)
            .unwrap();
        // Third row and column: the panel alone.
        let at = |c: usize| position.data[(2 * SIZE as usize + 2) * 3 + c];
        let pixel = 2.0 / SIZE as f32;
        let expected = Vec3::new(-1.0 + 2.5 * pixel, 1.0 - 2.5 * pixel, 0.0);
        let found = Vec3::new(at(0), at(1), at(2));
        assert!(
            found.distance(expected) < 0.1 * pixel,
            "{kind:?}: {found}, expected {expected}"
        );
    }
}

#[test]
fn a_visible_environment_is_opaque() {
    for (hide_emitters, [above, below]) in [(false, [1.0, 1.0]), (true, [0.0, 0.0])] {
        let mut b = sheets();
        b.emitter(Emitter::Constant {
            radiance: Rgb::splat(0.5),
        });
        b.desc.limits.hide_emitters = hide_emitters;
        let scene = b.build();
        for (kind, passes) in methods() {
            let film = render(&scene, kind.clone(), passes);
            let alpha = film.alpha().unwrap();
            let what = format!("{kind:?}, hidden: {hide_emitters}");
            assert_near(mean(0, |i| alpha.data[i]), above, &what);
            assert_near(mean(2, |i| alpha.data[i]), below, &what);
            // The environment belongs to no object.
            assert_near(
                coverage(&film, &scene, IdLayer::Object, "panel", 2),
                0.0,
                &what,
            );
        }
    }
}

#[test]
fn coverage_does_not_depend_on_the_longest_path() {
    let mut b = sheets();
    for max_depth in [1, 2] {
        b.desc.limits = PathLimits {
            max_depth: Some(max_depth),
            ..PathLimits::default()
        };
        let scene = b.clone().build();
        for kind in [MethodKind::Path, MethodKind::Aov] {
            let film = render(&scene, kind.clone(), 256);
            let alpha = film.alpha().unwrap();
            assert_near(
                mean(0, |i| alpha.data[i]),
                1.0,
                &format!("{kind:?} {max_depth}"),
            );
            // With one segment, no path gets behind the sheet.
            let behind = if max_depth == 1 { 0.0 } else { 0.75 };
            let found = mean(1, |i| alpha.data[i]);
            assert_near(found, 0.25 + behind, &format!("{kind:?} {max_depth}"));
        }
    }
}

#[test]
fn alpha_follows_filters_with_negative_lobes() {
    let mut b = sheets();
    let sensor = &mut b.desc.sensors[0].film;
    sensor.filter = Filter::Mitchell { b: 0.2, c: 0.6 };
    sensor.crop_size = UVec2::new(4, SIZE);
    // The left half: only the emitter of radiance 1, so that the image is the coverage. The sheet
    // is not in view.
    b.desc.primitives.remove(0);
    let scene = b.build();
    let film = render(&scene, MethodKind::Path, 2048);
    let (alpha, image) = (film.alpha().unwrap(), film.image(Layer::Emission).unwrap());
    for row in 0..SIZE as usize {
        let of_row = |data: &[f32], channels: usize| {
            (0..4).map(|x| data[(row * 4 + x) * channels]).sum::<f32>() / 4.0
        };
        let (covered, light) = (of_row(&alpha.data, 1), of_row(&image.data, 3));
        match row {
            0 | 1 => assert_near(covered, 1.0, "covered row"),
            6 | 7 => assert_near(covered, 0.0, "empty row"),
            _ => {
                let error = (covered - light.clamp(0.0, 1.0)).abs();
                assert!(error < 0.02, "row {row}: alpha {covered}, light {light}");
            }
        }
    }
}
