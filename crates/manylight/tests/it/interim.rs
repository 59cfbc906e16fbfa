//! The interim maps: importance, irradiance, and the positions of lights.

use manylight::color::Rgb;
use manylight::emitters::EmissionGuide;
use manylight::integrators::many_light::Placement;
use manylight::integrators::{InterimMaps, ManyLight, PassContext, PlacedLight};
use manylight::math::{UVec2, Vec2, Vec3};
use manylight::render::Stats;
use manylight::sampling::Pass;
use manylight::scene::Scene;
use manylight::testing::scenes::{Builder, diffuse, glossy_box};
use std::sync::atomic::AtomicBool;

const SIZE: u32 = 48;

fn maps(scene: &Scene, method: ManyLight) -> InterimMaps {
    let (guide, stats, never) = (
        scene.infinite_light_guide(),
        Stats::default(),
        AtomicBool::new(false),
    );
    let run = PassContext::of_picture(scene, Pass { seed: 5, index: 0 }, &guide, &stats, &never);
    method.interim_maps(scene, scene.limits, &run).unwrap()
}

fn small(placement: Placement) -> ManyLight {
    ManyLight {
        light_count: 300,
        photon_paths: 40_000,
        importon_paths: 10_000,
        placement,
        ..ManyLight::rich_vpl()
    }
}

/// A floor and a wall that face each other, and before them a plate that faces away from both.
fn floor_wall_and_plate() -> Scene {
    let mut b = Builder::new(
        Vec3::new(0.0, 2.5, 3.0),
        Vec3::new(0.0, 0.3, 0.0),
        50.0,
        SIZE,
    );
    let grey = b.material(diffuse(0.5, 0.5, 0.5));
    let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
    b.rectangle(Vec3::ZERO, z, x, grey, None);
    b.rectangle(y - z, x, y, grey, None);
    b.rectangle(Vec3::new(-0.8, 0.5, 1.2), x * 0.4, y * 0.4, grey, None);
    let light = b.area_light(Rgb::splat(10.0));
    b.rectangle(
        Vec3::new(0.0, 4.0, 1.5),
        x * 0.5,
        z * 0.5,
        grey,
        Some(light),
    );
    b.build()
}

/// Position of the surface that a pixel sees, and its normal towards the camera.
fn seen_at(scene: &Scene, film_position: Vec2) -> Option<(Vec3, Vec3)> {
    let ray = scene.sensor.ray(film_position, Vec2::splat(0.5));
    let (_, x) = scene.intersect(&ray)?;
    Some((x.p, x.normal_towards(-ray.d)))
}

#[test]
fn importance_arrives_where_what_is_seen_looks() {
    let scene = floor_wall_and_plate();
    let maps = maps(&scene, small(Placement::Importance));
    let [mut near, mut far, mut plate] = [const { Vec::new() }; 3];
    let mut nothing = Vec::new();
    for i in 0..SIZE * SIZE {
        let film_position = UVec2::new(i % SIZE, i / SIZE).as_vec2() + 0.5;
        let importance = maps.importance[i as usize];
        match seen_at(&scene, film_position) {
            None => nothing.push(i as usize),
            Some((p, _)) if p.z > 1.1 => plate.push(importance),
            Some((p, n)) if n.y > 0.9 && p.z < -0.7 => near.push(importance),
            Some((p, n)) if n.y > 0.9 && p.z > 0.5 => far.push(importance),
            Some(_) => {}
        }
    }
    let mean = |values: &[f32]| values.iter().sum::<f32>() / values.len() as f32;
    assert!(near.len() > 20 && far.len() > 20 && plate.len() > 20 && nothing.len() > 20);
    assert!(plate.iter().all(|&v| v == 0.0), "{plate:?}");
    // By the wall, half of the directions from the floor meet it; a metre off, far fewer.
    assert!(
        mean(&near) > 2.0 * mean(&far),
        "{} {}",
        mean(&near),
        mean(&far)
    );
    assert!(mean(&far) > 0.0);
    for i in nothing {
        let all = (maps.importance[i], maps.irradiance[i], maps.shading[i]);
        assert_eq!(all, (0.0, Rgb::BLACK, 0.0));
    }
    let products = maps.importance.iter().zip(&maps.irradiance);
    for ((importance, irradiance), product) in products.zip(&maps.product) {
        assert_eq!(*product, importance * irradiance.luminance());
    }
}

#[test]
fn irradiance_is_that_of_the_lamp() {
    let scene = floor_wall_and_plate();
    let maps = maps(&scene, small(Placement::Importance));
    let middle = scene.sensor.connect(Vec3::ZERO, Vec2::splat(0.5)).unwrap();
    let at = middle.film_position.floor().as_uvec2();
    // L A cos² / d² of a lamp of 1 m² that is 4 m above and 1.5 m before, and some light reflected
    // by the wall.
    let d2 = 4.0f32 * 4.0 + 1.5 * 1.5;
    let direct = 10.0 * 16.0 / (d2 * d2);
    let found = maps.irradiance[(at.y * SIZE + at.x) as usize].g;
    assert!(
        (1.0..1.5).contains(&(found / direct)),
        "{found} of {direct}"
    );
}

#[test]
fn lights_are_as_many_as_asked_and_shown_where_they_are_seen() {
    let scene = floor_wall_and_plate();
    for placement in [Placement::Uniform, Placement::Importance] {
        let maps = maps(&scene, small(placement));
        assert!(maps.placed.len().abs_diff(300) <= 1);
        assert_eq!(maps.placed.len(), maps.relaxed.len());
        let mut shown = 0;
        for light in maps.placed.iter().chain(&maps.relaxed) {
            let Some(film_position) = light.film_position else {
                continue;
            };
            shown += 1;
            let (p, n) = seen_at(&scene, film_position).unwrap();
            assert!(
                p.distance(light.p) < 1e-3 && n.dot(light.n) > 0.9,
                "{light:?}"
            );
        }
        // Some are behind the plate, on its back, or out of the film.
        assert!((200..600).contains(&shown), "{placement:?}: {shown}");
    }
    // No light of the floor by the wall is behind the plate: the camera sees all of them.
    let maps = maps(&scene, small(Placement::Importance));
    let by_wall = |l: &&PlacedLight| l.p.y == 0.0 && l.n.y > 0.5 && l.p.z < -0.3 && l.p.x > 0.2;
    let by_wall: Vec<_> = maps.placed.iter().filter(by_wall).collect();
    assert!(by_wall.len() > 5 && by_wall.iter().all(|l| l.film_position.is_some()));
}

/// Mean distance from a light to the nearest light with a similar normal, in m.
fn spacing(lights: &[PlacedLight]) -> f32 {
    let nearest = |a: &PlacedLight| {
        let alike = lights.iter().filter(|b| a.n.dot(b.n) > 0.9);
        let distances = alike.map(|b| a.p.distance(b.p));
        distances.filter(|&d| d > 0.0).fold(f32::INFINITY, f32::min)
    };
    let distances = lights.iter().map(nearest).filter(|d| d.is_finite());
    distances.sum::<f32>() / lights.len() as f32
}

#[test]
fn relaxed_lights_are_more_evenly_spread() {
    let scene = floor_wall_and_plate();
    let [uniform, important, relaxed] = [
        Placement::Uniform,
        Placement::Importance,
        Placement::Relaxed,
    ]
    .map(|placement| maps(&scene, small(placement)));
    for maps in [&uniform, &important] {
        let (before, after) = (spacing(&maps.placed), spacing(&maps.relaxed));
        assert!(after > 1.1 * before, "{after} after {before}");
    }
    // The map of relaxed lights is made for every placement.
    assert!(relaxed.placed == important.placed && relaxed.relaxed == important.relaxed);
}

#[test]
fn one_and_two_threads_give_the_same_bits() {
    let made = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        pool.install(|| maps(&glossy_box(SIZE).build(), small(Placement::Importance)))
    };
    assert!(made(1) == made(2));
}

#[test]
fn a_cancelled_pass_leaves_nothing() {
    let scene = glossy_box(8).build();
    let (guide, stats) = (EmissionGuide::default(), Stats::default());
    let cancelled = AtomicBool::new(true);
    let run = PassContext::of_picture(
        &scene,
        Pass { seed: 5, index: 0 },
        &guide,
        &stats,
        &cancelled,
    );
    let method = small(Placement::Importance);
    assert!(method.interim_maps(&scene, scene.limits, &run).is_none());
}
