//! Photons are emitted where they are needed: by lamps that light what is seen.

use crate::common::film;
use manylight::color::Rgb;
use manylight::emitters::EmissionGuide;
use manylight::film::{Film, Layer};
use manylight::geometry::Shape;
use manylight::integrators::{
    ExtraLayers, ManyLight, Method, MethodKind, PassContext, PhotonMap, Renderer,
};
use manylight::math::{Affine3A, UVec2, Vec2, Vec3};
use manylight::particles::{trace_photons, usable_by_virtual_lights};
use manylight::render::Stats;
use manylight::sampling::Pass;
use manylight::scene::Scene;
use manylight::testing::scenes::{Builder, diffuse, glass, glossy_box};
use std::sync::atomic::AtomicBool;

const SIZE: u32 = 32;
/// Lamps of the room next door.
const LAMPS: u32 = 60;
/// Passes of an estimate, each with another seed.
const SEEDS: u64 = 8;
/// Middle of the caustic below the ball.
const CAUSTIC: Vec3 = Vec3::new(-0.04, -1.0, 0.1);

/// A room with one lamp and a glass ball, and beside it a closed room with `lamps` brighter ones.
fn rooms(lamps: u32, elements: Elements) -> Scene {
    let mut b = Builder::new(
        Vec3::new(0.0, 0.5, 3.2),
        Vec3::new(0.0, -0.4, 0.0),
        45.0,
        SIZE,
    );
    let grey = b.material(diffuse(0.5, 0.5, 0.5));
    let clear = b.material(glass());
    let lamp = b.area_light(Rgb::new(40.0, 38.0, 34.0));
    let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
    let room = |c: Vec3, b: &mut Builder| {
        let faces = [(-x, y, z), (x, z, y), (-y, z, x), (y, x, z), (-z, x, y)];
        for (center, a, edge) in faces {
            b.rectangle(c + center, a, edge, grey, None);
        }
    };
    room(Vec3::ZERO, &mut b);
    b.rectangle(
        Vec3::new(0.45, 0.95, 0.1),
        x * 0.08,
        z * 0.08,
        grey,
        Some(lamp),
    );
    let ball = Shape::Sphere {
        center: Vec3::new(0.1, -0.45, 0.1),
        radius: 0.3,
    };
    b.place(ball, Affine3A::IDENTITY, clear, None);
    if lamps > 0 {
        let next_door = x * 3.0;
        room(next_door, &mut b);
        b.rectangle(next_door + z, y, x, grey, None);
        let shared = b.area_light(Rgb::new(100.0, 95.0, 85.0));
        for i in 0..lamps {
            let emitter = match elements {
                Elements::OfOneEmitter => shared,
                Elements::OfEmittersEach => b.area_light(Rgb::new(100.0, 95.0, 85.0)),
            };
            let center = Vec3::new(
                (i % 10) as f32 * 0.15 - 0.7,
                0.9,
                (i / 10) as f32 * 0.2 - 0.6,
            );
            b.rectangle(next_door + center, x * 0.05, z * 0.05, grey, Some(emitter));
        }
    }
    b.build()
}

/// Whether lamps are elements of one emitter.
#[derive(Clone, Copy)]
enum Elements {
    OfOneEmitter,
    OfEmittersEach,
}

/// A mean over seeds, and its standard error.
struct Mean {
    mean: f64,
    error: f64,
}

impl Mean {
    fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
        Mean {
            mean,
            error: (squares / (n * (n - 1.0))).sqrt(),
        }
    }
}

/// Mean luminance of the caustic's block in a film.
fn caustic(scene: &Scene, film: &Film) -> f64 {
    let seen = scene.sensor.connect(CAUSTIC, Vec2::splat(0.5)).unwrap();
    let middle = seen.film_position.floor().as_uvec2();
    let image = film.image(Layer::Beauty).unwrap();
    let block = (0..9).map(|i| middle + UVec2::new(i % 3, i / 3) - 1);
    let luminance = |at: UVec2| f64::from(image.rgb(at.x as usize, at.y as usize).luminance());
    block.map(luminance).sum::<f64>() / 9.0
}

/// A pass with photons by `guide`.
fn film_by(guide: &EmissionGuide, scene: &Scene, kind: &MethodKind, seed: u64) -> Film {
    let method = method(scene, kind);
    let mut film = Film::new(scene.sensor.desc().film.clone(), &method.layers());
    let (stats, never) = (Stats::default(), AtomicBool::new(false));
    let run = PassContext::of_picture(scene, Pass { seed, index: 0 }, guide, &stats, &never);
    assert!(Renderer::new(scene, method, 1).render_pass(&run, &mut film));
    film
}

/// The caustic over `SEEDS` passes with photons by `guide`.
fn caustics(guide: &EmissionGuide, scene: &Scene, kind: &MethodKind) -> Mean {
    let of_seed = |seed| caustic(scene, &film_by(guide, scene, kind, seed));
    let values: Vec<f64> = (0..SEEDS).map(of_seed).collect();
    Mean::of(&values)
}

fn method(scene: &Scene, kind: &MethodKind) -> Method {
    Method {
        kind: kind.clone(),
        limits: scene.limits,
        extra: ExtraLayers::default(),
    }
}

fn photon_map() -> MethodKind {
    MethodKind::PhotonMap(PhotonMap {
        photon_paths: 40_000,
        ..PhotonMap::progressive()
    })
}

fn rich_vpl() -> MethodKind {
    MethodKind::ManyLight(ManyLight {
        photon_paths: 40_000,
        light_count: 64,
        importon_paths: 4000,
        ..ManyLight::rich_vpl()
    })
}

#[test]
fn lamps_in_a_closed_room_do_not_take_the_photons_of_a_caustic() {
    let kind = photon_map();
    let alone = rooms(0, Elements::OfEmittersEach);
    let expected = caustics(&EmissionGuide::default(), &alone, &kind);
    for elements in [Elements::OfEmittersEach, Elements::OfOneEmitter] {
        let scene = rooms(LAMPS, elements);
        let by_power = caustics(&EmissionGuide::default(), &scene, &kind);
        let guide = method(&scene, &kind).emission_guide(&scene);
        let guided = caustics(&guide, &scene, &kind);
        let error = expected.error.hypot(guided.error);
        assert!(
            (guided.mean - expected.mean).abs() < 4.0 * error + 0.05 * expected.mean,
            "{} ± {} guided, {} ± {} alone",
            guided.mean,
            guided.error,
            expected.mean,
            expected.error
        );
        assert!(
            by_power.mean < 0.5 * guided.mean,
            "by power {} ± {}, guided {} ± {}",
            by_power.mean,
            by_power.error,
            guided.mean,
            guided.error
        );
    }
}

#[test]
fn the_choice_changes_no_expected_flux() {
    let scene = rooms(LAMPS, Elements::OfEmittersEach);
    let guide = method(&scene, &rich_vpl()).emission_guide(&scene);
    let flux = |guide: &EmissionGuide, is_next_door: bool, seed: u64| {
        let pass = Pass { seed, index: 0 };
        let paths = 20_000;
        let photons = trace_photons(
            &scene,
            guide,
            scene.limits,
            paths,
            pass,
            usable_by_virtual_lights,
        );
        let there = photons.iter().filter(|p| (p.p.x > 1.5) == is_next_door);
        there.map(|p| f64::from(p.flux.luminance())).sum::<f64>()
    };
    for is_next_door in [false, true] {
        let [by_power, guided] = [&EmissionGuide::default(), &guide].map(|guide| {
            let values: Vec<f64> = (0..12)
                .map(|seed| flux(guide, is_next_door, seed))
                .collect();
            Mean::of(&values)
        });
        let difference = (by_power.mean - guided.mean).abs();
        assert!(
            difference < 4.0 * by_power.error.hypot(guided.error),
            "{is_next_door}: {} and {}",
            by_power.mean,
            guided.mean
        );
    }
}

#[test]
fn a_scene_without_need_keeps_its_photons() {
    let scene = glossy_box(SIZE).build();
    let kind = photon_map();
    let guided = film(&scene, kind.clone(), 1, 3);
    let unguided = film_by(&EmissionGuide::default(), &scene, &kind, 3);
    assert_eq!(
        guided.image(Layer::Beauty).unwrap().data,
        unguided.image(Layer::Beauty).unwrap().data
    );
}

/// A corner under a lamp of half the edge `half`, 3 m above its floor.
fn corner(half: f32) -> Scene {
    let mut b = Builder::new(Vec3::splat(0.8), Vec3::new(-0.5, 0.2, -0.5), 60.0, SIZE);
    let grey = b.material(diffuse(0.5, 0.5, 0.5));
    let lamp = b.area_light(Rgb::WHITE);
    let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
    b.rectangle(Vec3::ZERO, z, x, grey, None);
    b.rectangle(y - z, x, y, grey, None);
    b.rectangle(y - x, y, z, grey, None);
    b.rectangle(y * 3.0, x * half, z * half, grey, Some(lamp));
    b.build()
}

#[test]
fn light_that_directions_find_and_photons_miss_is_reported() {
    let missed = |scene: &Scene| method(scene, &rich_vpl()).guided_emission(scene).missed;
    let vast = missed(&corner(300.0)).unwrap();
    assert_eq!(vast.emitter.index(), 0);
    assert!(vast.share == 1.0 && vast.carried < 0.1, "{vast:?}");
    for scene in [
        corner(0.5),
        glossy_box(SIZE).build(),
        rooms(LAMPS, Elements::OfEmittersEach),
        rooms(LAMPS, Elements::OfOneEmitter),
    ] {
        assert_eq!(missed(&scene), None);
    }
}
