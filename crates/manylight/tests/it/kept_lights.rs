//! Virtual lights that are made before a render, and kept as arrays.

use crate::common::{film_with, methods};
use manylight::arrays::{ArrayValues, FoundArray, InvalidArray};
use manylight::film::Film;
use manylight::film::blocks::DEFAULT_BLOCK;
use manylight::image::Image;
use manylight::integrators::{
    ExtraLayers, KeptLights, LightsContext, ManyLight, Method, MethodKind,
};
use manylight::math::{Affine3A, Vec3};
use manylight::render::{Budget, RenderJob, Stats, Walkthrough, make_lights, render};
use manylight::scene::{PathLimits, Scene};
use manylight::sensors::SensorDesc;
use manylight::testing::scenes::{Builder, glossy_box, grouped_box};
use manylight::testing::statistics::channel_means;
use std::collections::HashMap;
use std::sync::atomic::AtomicBool;

static NEVER: AtomicBool = AtomicBool::new(false);
const SIZE: u32 = 16;
const PASSES: u32 = 10;

fn job(scene: &Scene, kind: MethodKind, light_groups: usize) -> RenderJob<'_> {
    RenderJob {
        scene,
        method: Method {
            kind,
            limits: scene.limits,
            extra: ExtraLayers {
                light_groups,
                ..ExtraLayers::default()
            },
        },
        budget: Budget::passes(PASSES),
        seed: 3,
        frame: None,
        lights: None,
        block: DEFAULT_BLOCK,
        guide: None,
    }
}

/// A box with caustics, and with the sky in its open side.
fn open_box() -> Builder {
    let mut b = grouped_box(SIZE, None);
    b.desc.primitives.remove(5);
    b.emitter(manylight::emitters::Emitter::Environment(
        manylight::emitters::Environment {
            image: Image {
                data: (0..96).map(|i| (i % 7) as f32).collect(),
                ..Image::new(8, 4, 3)
            },
            scale: 1.0,
            world_from_emitter: manylight::math::Mat3::IDENTITY,
        },
    ));
    b
}

type Arrays = Vec<HashMap<String, FoundArray>>;

fn arrays_of(lights: &KeptLights) -> Arrays {
    let groups = lights.arrays().into_iter();
    let values = groups.map(|group| {
        let group = group.into_iter();
        group
            .map(|array| (array.name.clone(), (array.shape.clone(), array.values())))
            .collect()
    });
    values.collect()
}

fn lights_of<'s>(job: &RenderJob<'s>, arrays: &Arrays) -> Result<KeptLights<'s>, InvalidArray> {
    let cx = LightsContext {
        method: job.method.lights().unwrap().of_frames(Some(PASSES)),
        scene: job.scene,
        limits: job.method.limits,
        passes: PASSES,
        light_groups: job.method.extra.light_groups,
    };
    KeptLights::of_arrays(&cx, |group, name| {
        let found = arrays[group].get(name).cloned();
        found.ok_or_else(|| InvalidArray::new(name, "missing"))
    })
}

fn made<'s>(job: &RenderJob<'s>) -> KeptLights<'s> {
    make_lights(job, &Stats::default(), &NEVER).unwrap()
}

fn assert_same(a: &Film, b: &Film, which: &str) {
    for &layer in a.layers() {
        assert!(a.image(layer) == b.image(layer), "{which}: {layer:?}");
    }
}

#[test]
fn kept_lights_shade_with_the_bits_of_those_that_were_made() {
    let limited = Builder {
        desc: manylight::scene::SceneDesc {
            limits: PathLimits {
                max_depth: Some(5),
                ..PathLimits::default()
            },
            ..glossy_box(SIZE).desc
        },
    };
    let scenes = [
        (open_box().build(), false),
        (open_box().build(), true),
        (limited.build(), false),
    ];
    for (scene, has_groups) in &scenes {
        let groups = if *has_groups {
            scene.light_groups.count()
        } else {
            0
        };
        for kind in methods() {
            let job = job(scene, kind.clone(), groups);
            if job.method.lights().is_none() {
                assert!(make_lights(&job, &Stats::default(), &NEVER).is_none());
                continue;
            }
            let first = made(&job);
            assert_eq!(first.passes(), 16);
            let arrays = arrays_of(&first);
            let kept = lights_of(&job, &arrays).unwrap();
            assert_eq!(arrays_of(&kept), arrays, "{kind:?}");
            assert_eq!(kept.method(), first.method(), "{kind:?}");
            let pictures = [&first, &kept].map(|lights| {
                let stats = Stats::default();
                let job = RenderJob {
                    lights: Some(lights),
                    ..job.clone()
                };
                let film = render(&job, &stats, &NEVER, &mut ()).film;
                assert_eq!(Stats::get(&stats.photon_paths), 0, "{kind:?}");
                film
            });
            assert_same(&pictures[0], &pictures[1], &format!("{kind:?}"));
        }
    }
}

#[test]
fn a_walkthrough_by_kept_lights_has_the_bits_of_one_that_makes_them() {
    let mut scene = glossy_box(SIZE).build();
    let sensor = scene.sensor.desc().clone();
    let moved = |x: f32| SensorDesc {
        world_from_camera: Affine3A::from_translation(Vec3::X * x) * sensor.world_from_camera,
        ..sensor.clone()
    };
    scene.set_frames([-0.1, 0.1].map(moved).into()).unwrap();
    let kind = methods()
        .into_iter()
        .find(|kind| matches!(kind, MethodKind::ManyLight(_)));
    let job = RenderJob {
        frame: Some(0),
        ..job(&scene, kind.unwrap(), 0)
    };
    let lights = made(&job);
    let by_kept = RenderJob {
        lights: Some(&lights),
        ..job.clone()
    };
    let stats = [Stats::default(), Stats::default()];
    let mut walks = [
        Walkthrough::new(&job, &stats[0]),
        Walkthrough::new(&by_kept, &stats[1]),
    ];
    for index in 0..2 {
        let [a, b] = walks
            .each_mut()
            .map(|walk| walk.render(index, &NEVER, &mut ()).film);
        assert_same(&a, &b, &format!("frame {index}"));
    }
}

/// Lights that were placed for one camera give another one the right mean.
#[test]
fn lights_serve_another_camera() {
    let few = MethodKind::ManyLight(ManyLight {
        photon_paths: 20_000,
        light_count: 128,
        importon_paths: 2000,
        ..ManyLight::rich_vpl()
    });
    let first = glossy_box(SIZE).build();
    let mut second = glossy_box(SIZE);
    let turn =
        Affine3A::from_translation(Vec3::new(-0.3, 0.1, 0.8)) * Affine3A::from_rotation_y(2.4);
    second.desc.sensors[0].world_from_camera = turn;
    let second = second.build();
    let (mut kept, mut reference) = ([0.0f64; 3], [0.0f64; 3]);
    for seed in 0..6 {
        let made_for = RenderJob {
            seed,
            ..job(&first, few.clone(), 0)
        };
        let arrays = arrays_of(&made(&made_for));
        let job = RenderJob {
            seed,
            ..job(&second, few.clone(), 0)
        };
        let lights = lights_of(&job, &arrays).unwrap();
        let job = RenderJob {
            lights: Some(&lights),
            ..job
        };
        let film = render(&job, &Stats::default(), &NEVER, &mut ()).film;
        let path = film_with(&second, MethodKind::Path, ExtraLayers::default(), 300, seed);
        for c in 0..3 {
            kept[c] += channel_means(&film)[c].0;
            reference[c] += channel_means(&path)[c].0;
        }
    }
    for c in 0..3 {
        let ratio = kept[c] / reference[c];
        assert!((ratio - 1.0).abs() < 0.03, "channel {c}: {ratio}");
    }
}

#[test]
fn arrays_of_other_lights_are_refused() {
    let scene = open_box().build();
    let kind = methods()
        .into_iter()
        .find(|kind| matches!(kind, MethodKind::ManyLight(_)));
    let job = job(&scene, kind.unwrap(), 0);
    let good = arrays_of(&made(&job));
    let refused = |name: &str, change: &dyn Fn(&mut FoundArray)| {
        let mut arrays = good.clone();
        change(arrays[0].get_mut(name).unwrap());
        lights_of(&job, &arrays).unwrap_err().name
    };
    let word = |value: u32| {
        move |(_, values): &mut FoundArray| match values {
            ArrayValues::U32(words) => words[0] = value,
            other => panic!("{other:?}"),
        }
    };
    let number = |value: f32| {
        move |(_, values): &mut FoundArray| match values {
            ArrayValues::F32(numbers) => numbers[0] = value,
            other => panic!("{other:?}"),
        }
    };
    for name in [
        "lights.primitive",
        "lights.profile",
        "lights.group",
        "passes",
        "subsets",
        "effort",
        "cells.0.light",
    ] {
        assert_eq!(refused(name, &word(1 << 20)), name);
    }
    for camera_paths in [3, 32] {
        let change = |(_, values): &mut FoundArray| match values {
            ArrayValues::U32(words) => words[3] = camera_paths,
            other => panic!("{other:?}"),
        };
        assert_eq!(refused("effort", &change), "effort");
    }
    for name in ["lights.element", "lights.instance"] {
        assert_eq!(refused(name, &word(1 << 20)), "lights.primitive");
    }
    assert_eq!(refused("lights.p", &number(f32::NAN)), "lights.p");
    assert_eq!(
        refused("lights.flux", &number(f32::INFINITY)),
        "lights.flux"
    );
    assert_eq!(refused("ray_densities", &number(-1.0)), "ray_densities");
    assert_eq!(refused("caustics.primitive", &word(1 << 20)), "caustics.");
    assert_eq!(
        refused("cache.points.light", &word(1 << 20)),
        "cache.points."
    );
    assert_eq!(
        refused("cache.photons.depth", &word(1 << 20)),
        "cache.photons.depth"
    );
    let fewer = |(shape, values): &mut FoundArray| {
        shape[0] -= 1;
        match values {
            ArrayValues::U32(words) => words.truncate(shape.iter().product()),
            ArrayValues::F32(numbers) => numbers.truncate(shape.iter().product()),
            ArrayValues::F64(numbers) => numbers.truncate(shape.iter().product()),
        }
    };
    for name in [
        "lights.points",
        "tables.texels",
        "cells.0.spacing",
        "incident.wi",
    ] {
        assert!(
            refused(name, &fewer).starts_with(name.split('.').next().unwrap()),
            "{name}"
        );
    }
}
