//! Walkthroughs: frames that share photons and virtual lights.

use crate::common::{film, methods};
use manylight::film::blocks::DEFAULT_BLOCK;
use manylight::film::{Film, Layer};
use manylight::integrators::{ExtraLayers, ManyLight, Method, MethodKind};
use manylight::math::{Affine3A, Vec3};
use manylight::render::{Budget, RenderJob, Stats, Walkthrough, render};
use manylight::scene::Scene;
use manylight::sensors::SensorDesc;
use manylight::testing::scenes::glossy_box;
use std::sync::atomic::AtomicBool;

static NEVER: AtomicBool = AtomicBool::new(false);
const SIZE: u32 = 16;

/// Cameras that move to the side, and stand still from frame 1 to 2.
fn cameras(scene: &Scene) -> Vec<SensorDesc> {
    let sensor = scene.sensor.desc();
    let moved = |x: f32| SensorDesc {
        world_from_camera: Affine3A::from_translation(Vec3::X * x) * sensor.world_from_camera,
        ..sensor.clone()
    };
    [-0.1, 0.0, 0.0, 0.2].map(moved).into()
}

fn scene_with_frames() -> Scene {
    let mut scene = glossy_box(SIZE).build();
    let cameras = cameras(&scene);
    scene.set_frames(cameras).unwrap();
    scene
}

fn job(scene: &Scene, kind: MethodKind, passes: u32, seed: u64) -> RenderJob<'_> {
    RenderJob {
        scene,
        method: Method {
            kind,
            limits: scene.limits,
            extra: ExtraLayers::default(),
        },
        budget: Budget::passes(passes),
        seed,
        frame: Some(0),
        lights: None,
        block: DEFAULT_BLOCK,
        guide: None,
    }
}

fn few_lights() -> MethodKind {
    MethodKind::ManyLight(ManyLight {
        photon_paths: 4000,
        importon_paths: 1000,
        light_count: 64,
        ..ManyLight::rich_vpl()
    })
}

fn pixels(film: &Film, layer: Layer) -> Vec<f64> {
    let image = film.image(layer).unwrap();
    image.data.iter().map(|&v| f64::from(v)).collect()
}

#[test]
fn a_frame_alone_has_the_bits_of_the_walkthrough() {
    let scene = scene_with_frames();
    let stats = Stats::default();
    for kind in methods() {
        let job = job(&scene, kind.clone(), 10, 3);
        let mut walkthrough = Walkthrough::new(&job, &stats);
        for index in [2, 0, 3] {
            let shared = walkthrough.render(index, &NEVER, &mut ()).film;
            let alone = RenderJob {
                frame: Some(index),
                ..job.clone()
            };
            let alone = render(&alone, &Stats::default(), &NEVER, &mut ()).film;
            for &layer in shared.layers() {
                let same = shared.image(layer) == alone.image(layer);
                assert!(same, "{kind:?}: frame {index}, {layer:?}");
            }
        }
    }
}

#[test]
fn lights_are_made_once() {
    let scene = scene_with_frames();
    let job = job(&scene, few_lights(), 8, 3);
    let lights_of = |frames: &[u32]| {
        let stats = Stats::default();
        let mut walkthrough = Walkthrough::new(&job, &stats);
        for &index in frames {
            walkthrough.render(index, &NEVER, &mut ());
        }
        (Stats::get(&stats.lights), Stats::get(&stats.photon_paths))
    };
    let of_one = lights_of(&[0]);
    assert!(of_one.0 > 0 && of_one.1 == 8 * 4000);
    assert_eq!(lights_of(&[0, 1, 2, 3]), of_one);
}

/// The noise of virtual lights that pixels share lasts where the camera stands still; that of single
/// pixels changes.
#[test]
fn shared_noise_of_lights_lasts_and_noise_of_pixels_changes() {
    let scene = scene_with_frames();
    // So few that their noise is larger than that of camera paths.
    let kind = MethodKind::ManyLight(ManyLight {
        photon_paths: 256,
        importon_paths: 256,
        light_count: 4,
        ..ManyLight::rich_vpl()
    });
    let stats = Stats::default();
    let indirect = |film: &Film| pixels(film, Layer::VirtualLights).iter().sum::<f64>();
    let (mut lasting, mut independent) = (0.0, 0.0);
    for seed in 0..24 {
        let frame = |seed: u64, index: u32| {
            let job = job(&scene, kind.clone(), 8, seed);
            Walkthrough::new(&job, &stats)
                .render(index, &NEVER, &mut ())
                .film
        };
        let (a, b, other) = (frame(seed, 1), frame(seed, 2), frame(seed + 100, 1));
        assert!(pixels(&a, Layer::Direct) != pixels(&b, Layer::Direct));
        lasting += (indirect(&a) - indirect(&b)).powi(2);
        independent += (indirect(&a) - indirect(&other)).powi(2);
    }
    assert!(lasting < 0.25 * independent, "{lasting} of {independent}");
}

/// The mean of a frame is that of a render by its camera.
#[test]
fn frames_have_the_mean_of_path_tracing() {
    let scene = scene_with_frames();
    let mut moved = glossy_box(SIZE).build();
    moved.set_sensor(cameras(&scene)[3].clone()).unwrap();
    let sum = |film: &Film| pixels(film, Layer::Beauty).iter().sum::<f64>();
    let stats = Stats::default();
    let of_seed = |seed: u64| {
        let job = job(&scene, few_lights(), 8, seed);
        sum(&Walkthrough::new(&job, &stats)
            .render(3, &NEVER, &mut ())
            .film)
    };
    let sums: Vec<f64> = (0..24).map(of_seed).collect();
    let n = sums.len() as f64;
    let mean = sums.iter().sum::<f64>() / n;
    let variance = sums.iter().map(|sum| (sum - mean).powi(2)).sum::<f64>() / (n * (n - 1.0));
    let paths: Vec<f64> = (0..8)
        .map(|seed| sum(&film(&moved, MethodKind::Path, 1024, seed)))
        .collect();
    let expected = paths.iter().sum::<f64>() / 8.0;
    let of_paths = paths
        .iter()
        .map(|sum| (sum - expected).powi(2))
        .sum::<f64>()
        / 56.0;
    // Cells and kernels may be off by a hundredth.
    let tolerance = 4.0 * (variance + of_paths).sqrt() + 0.01 * expected;
    assert!((mean - expected).abs() < tolerance, "{mean} for {expected}");
}

#[test]
fn a_wrong_camera_is_named_and_changes_nothing() {
    let mut scene = scene_with_frames();
    let mut wrong = cameras(&scene);
    wrong[2].world_from_camera.translation.x = f32::NAN;
    let (index, error) = scene.set_frames(wrong).unwrap_err();
    assert_eq!((index, scene.frames().len()), (2, 4), "{}", error.message);
}
