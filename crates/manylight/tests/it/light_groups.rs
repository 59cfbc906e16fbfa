//! The layers of light groups: they sum to the beauty, and each is what a render with its emitters
//! alone gives.

use crate::common::{film, film_with, methods, methods_with_cuts, mixed, with_small_tables};
use manylight::color::Rgb;
use manylight::emitters::{Emitter, Environment};
use manylight::film::{Film, Layer};
use manylight::image::Image;
use manylight::integrators::{ExtraLayers, ManyLight, MethodKind, PhotonMap};
use manylight::math::{Mat3, Vec3};
use manylight::scene::Scene;
use manylight::testing::scenes::{Builder, GROUPS, diffuse, grouped_box};

/// Edge of the picture, and of the blocks that are compared, in pixels.
const SIZE: u32 = 16;
const BLOCK: usize = 8;
/// Independent renders, and passes of each.
const SEEDS: u64 = 12;
const PASSES: u32 = 4;

fn grouped(scene: &Scene, kind: MethodKind, passes: u32, seed: u64) -> Film {
    let extra = ExtraLayers {
        light_groups: scene.light_groups.count(),
        ..ExtraLayers::default()
    };
    film_with(scene, kind, extra, passes, seed)
}

fn layers_of_groups(film: &Film) -> Vec<Image> {
    (film.layers().iter())
        .filter(|layer| matches!(layer, Layer::LightGroup(_)))
        .map(|&layer| film.image(layer).unwrap())
        .collect()
}

#[test]
fn the_groups_sum_to_the_beauty() {
    let scene = grouped_box(SIZE, None).build();
    assert_eq!(scene.light_groups.names(), GROUPS);
    for kind in methods().into_iter().chain(methods_with_cuts()) {
        if kind == MethodKind::Aov {
            continue;
        }
        let film = grouped(&scene, kind.clone(), 3, 5);
        let (beauty, groups) = (film.image(Layer::Beauty).unwrap(), layers_of_groups(&film));
        assert_eq!(groups.len(), GROUPS.len());
        for (i, &value) in beauty.data.iter().enumerate() {
            let sum: f32 = groups.iter().map(|group| group.data[i]).sum();
            let error = (value - sum).abs();
            assert!(error <= 1e-4 * value.abs(), "{kind:?}: {value} and {sum}");
        }
        for group in &groups {
            assert!(group.data.iter().any(|&v| v > 0.0), "{kind:?}");
        }
    }
}

/// Means over blocks of pixels, all channels together.
fn block_means(image: &Image) -> Vec<f64> {
    let columns = image.width / BLOCK;
    let mut sums = vec![0.0; columns * (image.height / BLOCK)];
    for y in 0..image.height {
        for x in 0..image.width {
            let values = image.pixel(x, y).iter().map(|&v| f64::from(v));
            sums[y / BLOCK * columns + x / BLOCK] += values.sum::<f64>();
        }
    }
    sums
}

/// The mean over renders, and the variance of the mean, of each value.
fn mean_and_variance(renders: &[Vec<f64>]) -> Vec<(f64, f64)> {
    let n = renders.len() as f64;
    let of = |k: usize| {
        let values = || renders.iter().map(move |render| render[k]);
        let mean = values().sum::<f64>() / n;
        let squares: f64 = values().map(|v| (v - mean).powi(2)).sum();
        (mean, squares / (n * (n - 1.0)))
    };
    (0..renders[0].len()).map(of).collect()
}

/// Asserts that the groups of `scene` are what the scenes `alone` give, by independent renders.
fn assert_groups_are_alone(kind: &MethodKind, scene: &Scene, alone: &[Scene]) {
    let films: Vec<Film> = (0..SEEDS)
        .map(|seed| grouped(scene, kind.clone(), PASSES, seed))
        .collect();
    let (mut squares, mut count, mut worst) = (0.0, 0, 0.0f64);
    for (g, scene) in alone.iter().enumerate() {
        let of_group = films
            .iter()
            .map(|film| block_means(&layers_of_groups(film)[g]));
        let found = mean_and_variance(&of_group.collect::<Vec<_>>());
        let alone = (0..SEEDS).map(|seed| {
            let film = film(scene, kind.clone(), PASSES, 1000 + seed);
            block_means(&film.image(Layer::Beauty).unwrap())
        });
        let expected = mean_and_variance(&alone.collect::<Vec<_>>());
        for ((a, var_a), (b, var_b)) in found.into_iter().zip(expected) {
            let z = (a - b) / (var_a + var_b).sqrt();
            squares += z * z;
            count += 1;
            worst = worst.max(z.abs());
        }
    }
    let rms = (squares / f64::from(count)).sqrt();
    // A t distribution with at least 11 degrees of freedom.
    assert!(rms < 1.8 && worst < 5.0, "{kind:?}: z = {rms} and {worst}");
}

fn few(method: ManyLight) -> ManyLight {
    ManyLight {
        photon_paths: 20_000,
        light_count: 200,
        importon_paths: 4000,
        ..with_small_tables(method)
    }
}

#[test]
fn each_group_is_what_its_emitters_alone_give() {
    let scene = grouped_box(SIZE, None).build();
    let alone = GROUPS.map(|group| grouped_box(SIZE, Some(group)).build());
    let few_photons = |method: PhotonMap| {
        MethodKind::PhotonMap(PhotonMap {
            photon_paths: 20_000,
            ..method
        })
    };
    let kinds = [
        MethodKind::Path,
        MethodKind::LightTracer,
        MethodKind::ManyLight(few(ManyLight::rich_vpl())),
        MethodKind::ManyLight(few(ManyLight::rich_lightcuts())),
        MethodKind::ManyLight(few(ManyLight::bidirectional_lightcuts())),
        MethodKind::ManyLight(few(ManyLight::rich_vsl())),
        MethodKind::Mixed(mixed(few(ManyLight::rich_vpl()))),
        few_photons(PhotonMap::progressive()),
        few_photons(PhotonMap::direct()),
    ];
    for kind in kinds {
        assert_groups_are_alone(&kind, &scene, &alone);
    }
}

/// A floor under two environments and parallel light, which are three groups. Without `lit`, all
/// shine.
fn outdoors(lit: Option<usize>) -> Scene {
    let mut b = Builder::new(Vec3::new(0.0, 1.0, 3.0), Vec3::ZERO, 60.0, SIZE);
    let floor = b.material(diffuse(0.6, 0.5, 0.4));
    b.rectangle(Vec3::ZERO, Vec3::Z * 2.0, Vec3::X * 2.0, floor, None);
    b.rectangle(Vec3::Z * -0.5, Vec3::X * 0.5, Vec3::Y * 0.7, floor, None);
    let factor = |group: usize| match lit {
        Some(lit) if lit != group => 0.0,
        _ => 1.0,
    };
    let mut image = Image::new(8, 4, 3);
    for (i, texel) in image.data.iter_mut().enumerate() {
        *texel = 0.1 + (i % 7) as f32;
    }
    b.emitter(Emitter::Environment(Environment {
        image,
        scale: factor(0),
        world_from_emitter: Mat3::IDENTITY,
    }));
    b.emitter(Emitter::Constant {
        radiance: Rgb::new(0.5, 1.0, 2.0) * factor(1),
    });
    b.emitter(Emitter::Directional {
        direction: Vec3::new(0.3, -1.0, -0.2).normalize(),
        irradiance: Rgb::new(3.0, 2.0, 1.0) * factor(2),
    });
    b.desc.emitter_groups = ["sky", "haze", "sun"].map(str::to_owned).to_vec();
    b.build()
}

#[test]
fn environments_of_several_groups_are_told_apart() {
    let scene = outdoors(None);
    let alone = [0, 1, 2].map(|group| outdoors(Some(group)));
    for kind in [
        MethodKind::Path,
        MethodKind::ManyLight(few(ManyLight::rich_vpl())),
    ] {
        assert_groups_are_alone(&kind, &scene, &alone);
    }
}

#[test]
#[should_panic(expected = "2 light groups of 3")]
fn groups_that_are_not_those_of_the_scene_are_refused() {
    let scene = grouped_box(SIZE, None).build();
    let extra = ExtraLayers {
        light_groups: 2,
        ..ExtraLayers::default()
    };
    film_with(&scene, MethodKind::Path, extra, 1, 0);
}
