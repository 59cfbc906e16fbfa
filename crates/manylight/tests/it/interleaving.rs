//! The noise that neighbors share: interleaved lights make it independent.

use crate::common::film;
use manylight::film::{Film, Layer};
use manylight::integrators::{ManyLight, MethodKind};
use manylight::scene::Scene;
use manylight::testing::scenes::glossy_box;

const SIZE: u32 = 16;
const SEEDS: u64 = 24;

/// Luminance of virtual lights in the pixels of a film, row by row.
fn luminances(film: &Film) -> Vec<f64> {
    let image = film.image(Layer::VirtualLights).unwrap();
    let places = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
    places
        .map(|(x, y)| f64::from(image.rgb(x, y).luminance()))
        .collect()
}

/// The means of blocks of 2x2 pixels.
fn block_means(pixels: &[f64]) -> Vec<f64> {
    let edge = SIZE as usize;
    let blocks = (0..edge * edge / 4).map(|i| (i % (edge / 2) * 2, i / (edge / 2) * 2));
    blocks
        .map(|(x, y)| {
            let at = |dx, dy| pixels[(y + dy) * edge + x + dx];
            (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)) / 4.0
        })
        .collect()
}

/// The sum over places of the variance of values, each given for every seed.
fn variance(of_seeds: &[Vec<f64>]) -> f64 {
    let n = of_seeds.len() as f64;
    let places = 0..of_seeds[0].len();
    places
        .map(|i| {
            let mean = of_seeds.iter().map(|values| values[i]).sum::<f64>() / n;
            let squares = of_seeds.iter().map(|values| (values[i] - mean).powi(2));
            squares.sum::<f64>() / (n - 1.0)
        })
        .sum()
}

/// The variance of means of 2x2 pixels times 4, over that of pixels (1 if neighbors are independent,
/// 4 if they are equal), and the mean of the picture.
fn shared_noise(scene: &Scene, interleaving: u32, passes: u32) -> (f64, f64) {
    let method = MethodKind::ManyLight(ManyLight {
        light_count: 32,
        photon_paths: 20_000,
        importon_paths: 2000,
        interleaving,
        ..ManyLight::rich_vpl()
    });
    let pixels: Vec<Vec<f64>> = (0..SEEDS)
        .map(|seed| luminances(&film(scene, method.clone(), passes, seed)))
        .collect();
    let blocks: Vec<Vec<f64>> = pixels.iter().map(|pixels| block_means(pixels)).collect();
    let mean = pixels.iter().flatten().sum::<f64>() / (pixels.len() * pixels[0].len()) as f64;
    // Sums over places: a block has a quarter of the places, which the factor 4 on the mean undoes.
    let ratio = 16.0 * variance(&blocks) / variance(&pixels);
    (ratio, mean)
}

#[test]
fn interleaved_lights_make_the_noise_of_neighbors_independent() {
    let scene = glossy_box(SIZE).build();
    for passes in [1, 2] {
        let (shared, mean) = shared_noise(&scene, 1, passes);
        let (independent, interleaved_mean) = shared_noise(&scene, 2, passes);
        println!("{passes} passes: {shared} {independent}, means {mean} {interleaved_mean}");
        assert!(shared > 2.5, "{shared}");
        assert!(independent < 1.6, "{independent}");
        assert!((interleaved_mean / mean - 1.0).abs() < 0.03);
    }
}
