//! The mean of virtual lights and path tracing, and the choice between them.

use crate::common::{film, film_with, mixed};
use manylight::film::{Film, IdLayer, Layer};
use manylight::image::Image;
use manylight::integrators::choice::FilterInput;
use manylight::integrators::{
    ChoicePrePass, ExtraLayers, ManyLight, MethodKind, Mixed, PassContext, PathWeights,
};
use manylight::render::Stats;
use manylight::sampling::Pass;
use manylight::scene::{LimitedScene, Scene};
use manylight::testing::scenes::glossy_box;
use manylight::testing::statistics::term_mean;
use std::sync::atomic::AtomicBool;

const TERMS: [Layer; 5] = [
    Layer::Emission,
    Layer::Direct,
    Layer::VirtualLights,
    Layer::Compensation,
    Layer::Caustics,
];

fn lights() -> ManyLight {
    ManyLight {
        photon_paths: 20_000,
        light_count: 200,
        importon_paths: 4000,
        ..ManyLight::rich_vpl()
    }
}

fn with_weight(weight: f32) -> MethodKind {
    MethodKind::Mixed(Mixed {
        weights: PathWeights {
            emission: weight,
            direct: weight,
            indirect: weight,
            caustics: weight,
        },
        ..mixed(lights())
    })
}

/// The mean of the image and its variance, in one channel.
fn mean(film: &Film) -> (f64, f64) {
    let image = film.image(Layer::Beauty).unwrap();
    let green = image.data.iter().skip(1).step_by(3).map(|&v| f64::from(v));
    let count = (image.width * image.height) as f64;
    (green.sum::<f64>() / count, film.mean_variance()[1])
}

#[test]
fn the_mean_is_that_of_both_methods() {
    let scene = glossy_box(24).build();
    let both = film(&scene, MethodKind::Mixed(mixed(lights())), 32, 5);
    for kind in [MethodKind::Path, MethodKind::ManyLight(lights())] {
        let passes = if kind == MethodKind::Path { 1024 } else { 32 };
        let single = film(&scene, kind.clone(), passes, 6);
        let ((a, var_a), (b, var_b)) = (mean(&both), mean(&single));
        let z = (a - b) / (var_a + var_b).sqrt();
        assert!(z.abs() < 4.0, "{kind:?}: {a} and {b}, z = {z}");
        for term in TERMS
            .into_iter()
            .filter(|&term| term != Layer::Compensation)
        {
            let (found, expected) = (term_mean(&both, term), term_mean(&single, term));
            assert!(
                (found - expected).abs() < 0.02 * b,
                "{kind:?}, {term:?}: {found} and {expected} of {b}"
            );
        }
    }
}

#[test]
fn the_terms_add_up() {
    let scene = glossy_box(24).build();
    let film = film(&scene, MethodKind::Mixed(mixed(lights())), 2, 5);
    let beauty = film.image(Layer::Beauty).unwrap();
    let terms = TERMS.map(|term| film.image(term).unwrap());
    for (i, &value) in beauty.data.iter().enumerate() {
        let sum: f32 = terms.iter().map(|term| term.data[i]).sum();
        assert!((value - sum).abs() <= 1e-4 * sum.abs(), "{value} and {sum}");
    }
}

/// Without path samples a pass is that of the virtual lights alone; the first surfaces are seen by
/// the paths of both.
#[test]
fn a_weight_of_zero_leaves_virtual_lights() {
    let scene = glossy_box(24).build();
    let lights = film(&scene, MethodKind::ManyLight(lights()), 2, 5);
    let none = film(&scene, with_weight(0.0), 2, 5);
    for term in TERMS {
        assert!(lights.image(term) == none.image(term), "{term:?}");
    }
    assert!(lights.image(Layer::Albedo) != none.image(Layer::Albedo));
    let all = film(&scene, with_weight(1.0), 2, 5);
    let compensation = all.image(Layer::Compensation).unwrap();
    assert!(compensation.data.iter().all(|&v| v == 0.0));
}

#[test]
fn first_surfaces_are_those_of_both_methods() {
    let scene = glossy_box(24).build();
    let extra = ExtraLayers {
        position: true,
        objects: true,
        materials: true,
        ..ExtraLayers::default()
    };
    let kinds = [MethodKind::Mixed(mixed(lights())), MethodKind::Path];
    let [both, path] = kinds.map(|kind| film_with(&scene, kind, extra, 256, 5));
    for layer in [Layer::Albedo, Layer::Normal, Layer::Position, Layer::Alpha] {
        let [a, b] = [&both, &path].map(|film| film.image(layer).unwrap());
        let differences = a
            .data
            .iter()
            .zip(&b.data)
            .map(|(a, b)| f64::from((a - b).abs()));
        let difference = differences.sum::<f64>() / a.data.len() as f64;
        assert!(difference < 0.01, "{layer:?}: {difference}");
    }
    for layer in [IdLayer::Object, IdLayer::Material] {
        let [a, b] = [&both, &path].map(|film| film.ranked_ids(layer).unwrap());
        for (pixel, (a, b)) in a.iter().zip(&b).enumerate() {
            let total: f32 = a.iter().map(|(_, weight)| weight).sum();
            assert!(total <= 1.0 + 1e-4, "pixel {pixel}: {total}");
            for (id, weight) in a {
                let other = b.iter().find(|(other, _)| other == id);
                let other = other.map_or(0.0, |(_, weight)| *weight);
                assert!(
                    (weight - other).abs() < 0.2,
                    "pixel {pixel}: {weight} and {other}"
                );
            }
        }
    }
}

fn pre_pass(scene: &Scene, seed: u64) -> ChoicePrePass {
    let (guide, stats, never) = (
        scene.infinite_light_guide(),
        Stats::default(),
        AtomicBool::new(false),
    );
    let run = PassContext::of_picture(scene, Pass { seed, index: 0 }, &guide, &stats, &never);
    ChoicePrePass::new(
        &lights(),
        LimitedScene {
            scene,
            limits: scene.limits,
        },
        &run,
    )
}

#[test]
fn the_choice_does_not_depend_on_threads() {
    let scene = glossy_box(24).build();
    let choice = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| pre_pass(&scene, 3).choice(None))
    };
    assert_eq!(choice(1), choice(5));
}

/// A filter that leaves the pictures leaves their errors, but for the factor of shared noise; one
/// that removes all noise leaves none.
#[test]
fn errors_are_those_of_the_filtered_pictures() {
    let scene = glossy_box(24).build();
    let pre_pass = pre_pass(&scene, 3);
    let noisy = pre_pass.choice(None).errors;
    assert!(
        !noisy.filtered && noisy.path > 0.0 && noisy.lights > 0.0,
        "{noisy:?}"
    );
    let same = |input: &FilterInput| Some(input.radiance.clone());
    let same = pre_pass.choice(Some(&same)).errors;
    assert!(same.filtered);
    // The filter's pictures have single precision.
    assert!((same.path / noisy.path - 1.0).abs() < 1e-6, "{same:?}");
    assert!(same.lights >= noisy.lights);
    let constant = |input: &FilterInput| {
        let Image { width, height, .. } = input.radiance;
        Some(Image::new(width, height, 3))
    };
    let none = pre_pass.choice(Some(&constant)).errors;
    assert_eq!((none.path, none.lights, none.mixed), (0.0, 0.0, 0.0));
    let failing = pre_pass.choice(Some(&|_: &FilterInput| None)).errors;
    assert_eq!(failing.path, noisy.path);
}
