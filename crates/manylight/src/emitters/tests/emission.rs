//! Photons against powers and direct light, guided and unguided.

use super::*;
use crate::geometry::{Ray, Segment};
use crate::sampling::warp;

#[test]
fn emitted_flux_is_the_power() {
    for (name, world) in emissive_worlds() {
        let mut numbers = Sampler::new(13, 0, Stream::Test, 0);
        let count = 20_000;
        let flux: f64 = (0..count)
            .filter_map(|_| emit(&world, &mut numbers))
            .map(|s| f64::from(s.flux.g))
            .sum();
        let power: f32 = (0..world.emitters.descriptions().len())
            .map(|i| world.emitters.power(EmitterId::from(i)).g)
            .sum();
        // Textured power is a mean over a grid.
        assert!(
            (flux / f64::from(count) / f64::from(power) - 1.0).abs() < 0.03,
            "{name}"
        );
    }
}

/// Flux through the square of half-width `half` around `center` in a plane z = const from above or
/// below, by photons and by direct light: mean and variance of the mean of each.
fn flux_through(world: &World, center: Vec3, half: f32, count: u32) -> [(f64, f64); 2] {
    let mut numbers = Sampler::new(14, 0, Stream::Test, 0);
    let mut sums = [[0.0f64; 2]; 2];
    for _ in 0..count {
        let photon = emit(world, &mut numbers).map_or(0.0, |s| {
            let t = (center.z - s.ray.o.z) / s.ray.d.z;
            let q = (s.ray.at(t) - center).truncate().abs();
            let arrives = t > 0.0
                && q.max_element() < half
                && world
                    .geometry
                    .intersect(&Ray { t_max: t, ..s.ray })
                    .is_none();
            if arrives { f64::from(s.flux.g) } else { 0.0 }
        });
        let p = center + ((numbers.next_2d() * 2.0 - Vec2::ONE) * half).extend(0.0);
        let (u_choice, u) = (numbers.next_1d(), numbers.next_2d());
        let direct = world.sample(p, None, u_choice, u);
        let direct = direct.map_or(0.0, |s| {
            let blocked = world.geometry.occluded(&Segment {
                from: p,
                to: s.target,
            });
            if blocked {
                0.0
            } else {
                f64::from(s.weight.g * s.wi.z.abs() * 4.0 * half * half)
            }
        });
        for (sum, value) in sums.iter_mut().zip([photon, direct]) {
            sum[0] += value;
            sum[1] += value * value;
        }
    }
    let n = f64::from(count);
    sums.map(|[sum, squares]| (sum / n, (squares / n - (sum / n).powi(2)) / n))
}

fn check_flux(name: &str, [(a, variance_a), (b, variance_b)]: [(f64, f64); 2]) {
    let deviation = (variance_a + variance_b).sqrt();
    assert!(
        (a - b).abs() < 5.0 * deviation,
        "{name}: {a} by photons, {b} by direct light, deviation {deviation}"
    );
    assert!(deviation < 0.1 * b, "{name}: too noisy to tell");
}

#[test]
fn photons_and_direct_light_give_the_same_flux() {
    let others = vec![
        Emitter::Point {
            position: Vec3::new(0.4, 0.3, 1.4),
            intensity: Rgb::splat(0.7),
        },
        Emitter::Spot {
            position: Vec3::new(-0.5, 0.2, 1.2),
            direction: Vec3::new(0.3, 0.0, -1.0).normalize(),
            intensity: Rgb::splat(2.0),
            cutoff: 0.8,
            beam_width: 0.3,
            falloff: SpotFalloff::LinearAngle,
            projector: None,
        },
        Emitter::Spot {
            position: Vec3::new(0.2, 0.5, 1.3),
            direction: Vec3::new(-0.1, 0.0, -1.0).normalize(),
            intensity: Rgb::splat(1.5),
            cutoff: 0.7,
            beam_width: 0.4,
            falloff: SpotFalloff::SmoothCosine,
            projector: Some(projector()),
        },
        Emitter::Spot {
            position: Vec3::new(0.1, -0.3, 1.1),
            direction: Vec3::NEG_Z,
            intensity: Rgb::splat(0.8),
            cutoff: 0.9,
            beam_width: 0.9,
            falloff: SpotFalloff::FlatIrradiance,
            projector: Some(ProjectorTexture {
                axes: [Vec3::X, Vec3::NEG_Y],
                window: Some(Vec2::new(0.9, 0.4)),
                ..projector()
            }),
        },
        infinite_emitters().swap_remove(1),
    ];
    let floor = || {
        Placed::new(
            Shape::Mesh(Mesh::rectangle()),
            Affine3A::from_translation(-Vec3::Z),
        )
        .dark()
    };
    let pointwise = world(vec![floor()], others);
    let infinite = world(vec![floor()], infinite_emitters());
    let worlds = emissive_worlds()
        .into_iter()
        .chain([("points", pointwise), ("infinite lights", infinite)]);
    for (name, world) in worlds {
        check_flux(
            name,
            flux_through(&world, Vec3::new(0.1, 0.0, 0.2), 0.5, 60_000),
        );
    }
}

/// A closed box with a small window, lit from outside.
fn room() -> World {
    let cube = Shape::Mesh(Mesh::cube());
    let wall = |center: Vec3, half: Vec3| {
        let transform = Affine3A::from_translation(center) * Affine3A::from_scale(half);
        Placed::new(cube.clone(), transform).dark()
    };
    let slabs = vec![
        wall(Vec3::new(0.0, 0.0, -1.1), Vec3::new(1.2, 1.2, 0.1)),
        wall(Vec3::new(0.0, 0.0, 1.1), Vec3::new(1.2, 1.2, 0.1)),
        wall(Vec3::new(-1.1, 0.0, 0.0), Vec3::new(0.1, 1.2, 1.0)),
        wall(Vec3::new(1.1, -0.7, 0.0), Vec3::new(0.1, 0.5, 1.0)),
        wall(Vec3::new(1.1, 0.7, 0.0), Vec3::new(0.1, 0.5, 1.0)),
        wall(Vec3::new(0.0, -1.1, 0.0), Vec3::new(1.0, 0.1, 1.0)),
        wall(Vec3::new(0.0, 1.1, 0.0), Vec3::new(1.0, 0.1, 1.0)),
        // Ground outside makes the bounding sphere large.
        wall(Vec3::new(0.0, 0.0, -1.3), Vec3::new(8.0, 8.0, 0.1)),
    ];
    let mut others = infinite_emitters();
    others[1] = Emitter::Directional {
        direction: Vec3::new(-0.8, 0.05, -0.5).normalize(),
        irradiance: Rgb::splat(2.0),
    };
    world(slabs, others)
}

/// Fraction of photons that get inside, and the flux through the middle of the room.
fn photons_inside(world: &World) -> f64 {
    let mut numbers = Sampler::new(15, 0, Stream::Test, 0);
    let count = 20_000;
    let inside = (0..count)
        .filter_map(|_| emit(world, &mut numbers))
        .filter(|s| {
            world
                .geometry
                .intersect(&s.ray)
                .is_some_and(|hit| s.ray.at(hit.t).abs().max_element() < 1.01)
        });
    inside.count() as f64 / f64::from(count)
}

#[test]
fn the_guide_brings_photons_through_windows_and_changes_no_flux() {
    let mut world = room();
    let before = photons_inside(&world);
    let mut numbers = Sampler::new(16, 0, Stream::Test, 0);
    let rays: Vec<Ray> = (0..4000)
        .map(|_| Ray::new(Vec3::ZERO, warp::sphere(numbers.next_2d())))
        .collect();
    world.guide = EmissionGuide::new(&world.emitters, &world.geometry, || rays, |_| false);
    let after = photons_inside(&world);
    assert!(
        after > 100.0 * before && after > 0.1,
        "{before} of the photons before, {after} after"
    );
    let flux = flux_through(&world, Vec3::new(0.3, 0.0, -0.5), 0.5, 60_000);
    check_flux("room", flux);
}

#[test]
fn ray_densities_are_those_of_photons() {
    // Over photons of one emitter, the sum of the inverse of their density is the measure of the
    // rays: π A of a lamp, and 4π times the cross-section of the scene of a sky.
    let lamp = Placed::new(
        Shape::Mesh(Mesh::rectangle()),
        Affine3A::from_scale(Vec3::splat(0.5)),
    );
    let World {
        geometry,
        textures,
        emitters,
        guide,
    } = world(vec![lamp], infinite_emitters()[..1].to_vec());
    let powers = [0, 1].map(|i| emitters.power(EmitterId::from(i)).g);
    let radiances = [2.0, 0.3];
    let cells = guide.cells(&emitters);
    let uneven = guide.clone().with_shares(&cells, &[0.9, 0.1]);
    let count = 40_000;
    for guide in [guide, uneven] {
        let densities = RayDensities::new(&guide, &emitters, count);
        let mut numbers = Sampler::new(16, 0, Stream::Test, 0);
        let mut measures = [0.0f64; 2];
        for _ in 0..count {
            let u = numbers.next_emission();
            let Some(sample) = guide.sample(&emitters, &geometry, &textures, u) else {
                continue;
            };
            let density = densities.of_sample(&emitters, (&geometry, &textures), &sample);
            measures[sample.emitter.index()] += f64::from(1.0 / density);
        }
        for ((measure, power), radiance) in measures.iter().zip(powers).zip(radiances) {
            let ratio = measure / f64::from(power / radiance);
            assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
        }
    }
}

#[test]
fn emitters_that_no_ray_finds_have_infinite_densities() {
    let point = Emitter::Point {
        position: Vec3::Z,
        intensity: Rgb::WHITE,
    };
    let radiance = ColorInput::Constant(Rgb::WHITE);
    let hidden = [
        point,
        infinite_emitters()[1].clone(),
        Emitter::InvisibleArea { radiance },
    ];
    let world = world(Vec::new(), hidden.to_vec());
    let densities = RayDensities::new(&world.guide, &world.emitters, 10);
    for (i, emitter) in hidden.iter().enumerate() {
        let density = densities.at(Some(EmitterId::from(i)), Rgb::WHITE);
        assert!(density.is_infinite(), "{emitter:?}");
    }
}
