//! The noise that neighbors share: interleaved lights make it independent.

use crate::common::film;
use manylight::film::{Film, Layer};
use manylight::integrators::{ManyLight, MethodKind};
use manylight::scene::Scene;
use manylight::testing::scenes::glossy_box;

const SIZE: u32 = 16;
const SEEDS: u64 = 24;

/// Luminance of a layer in the pixels of a film, row by row.
fn luminances(film: &Film, layer: Layer) -> Vec<f64> {
    let image = film.image(layer).unwrap();
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

/// Noise of virtual lights, and means of indirect light.
struct Measured {
    /// The variance of means of 2x2 pixels times 4, over that of pixels: 1 if neighbors are
    /// independent, 4 if they are equal.
    shared: f64,
    /// Sum over the pixels of indirect light, by seed.
    sums: Vec<Vec<f64>>,
}

impl Measured {
    /// Mean over seeds, and the variance of it.
    fn mean(&self) -> (f64, f64) {
        let n = self.sums.len() as f64;
        let mean = self.sums.iter().flatten().sum::<f64>() / n;
        (mean, variance(&self.sums) / n)
    }
}

fn measured(scene: &Scene, interleaving: u32) -> Measured {
    let method = MethodKind::ManyLight(ManyLight {
        light_count: 32,
        photon_paths: 20_000,
        importon_paths: 2000,
        interleaving,
        ..ManyLight::rich_vpl()
    });
    let films: Vec<Film> = (0..SEEDS)
        .map(|seed| film(scene, method.clone(), 1, seed))
        .collect();
    let of_layer =
        |layer| -> Vec<Vec<f64>> { films.iter().map(|film| luminances(film, layer)).collect() };
    let lights = of_layer(Layer::VirtualLights);
    let blocks: Vec<Vec<f64>> = lights.iter().map(|pixels| block_means(pixels)).collect();
    let compensation = of_layer(Layer::Compensation);
    let sums = lights.iter().zip(&compensation);
    let sums = sums.map(|(a, b)| vec![a.iter().chain(b).sum()]).collect();
    Measured {
        // Blocks are a quarter of the places.
        shared: 16.0 * variance(&blocks) / variance(&lights),
        sums,
    }
}

#[test]
fn interleaved_lights_make_the_noise_of_neighbors_independent() {
    let scene = glossy_box(SIZE).build();
    let same = measured(&scene, 1);
    let interleaved = measured(&scene, 2);
    assert!(same.shared > 1.2, "{}", same.shared);
    assert!(interleaved.shared < 0.8, "{}", interleaved.shared);
    let ((a, var_a), (b, var_b)) = (same.mean(), interleaved.mean());
    assert!((a - b).abs() < 3.0 * (var_a + var_b).sqrt(), "{a} and {b}");
    assert!((b / a - 1.0).abs() < 0.1, "{a} and {b}");
}
