//! Bidirectional lightcuts against the path tracer.

use crate::common::film;
use manylight::bsdf::Material;
use manylight::color::Rgb;
use manylight::film::{Film, Layer};
use manylight::geometry::{Mesh, Shape};
use manylight::integrators::{ManyLight, MethodKind};
use manylight::math::{Affine3A, Vec3};
use manylight::scene::Scene;
use manylight::testing::scenes::{Builder, diffuse, rough_metal};
use manylight::testing::statistics::term_mean;

/// A box with a red and a green wall, a lamp under its ceiling, and two blocks.
fn cornell_box(size: u32, block: Material) -> Scene {
    let mut b = Builder::new(Vec3::new(0.0, 0.0, -0.98), Vec3::Z, 80.0, size);
    let white = b.material(diffuse(0.7, 0.7, 0.7));
    let (red, green) = (
        b.material(diffuse(0.6, 0.1, 0.1)),
        b.material(diffuse(0.1, 0.5, 0.1)),
    );
    b.room([red, green, white, white, white, white], None);
    let lamp = b.area_light(Rgb::splat(6.0));
    b.rectangle(
        Vec3::new(0.0, 0.97, 0.2),
        Vec3::X * 0.3,
        Vec3::Z * 0.3,
        white,
        Some(lamp),
    );
    let block = b.material(block);
    for (center, size) in [
        (Vec3::new(-0.4, -0.5, 0.4), Vec3::new(0.25, 0.5, 0.25)),
        (Vec3::new(0.4, -0.75, -0.1), Vec3::splat(0.25)),
    ] {
        let place = Affine3A::from_translation(center) * Affine3A::from_scale(size);
        b.place(Shape::Mesh(Mesh::cube()), place, block, None);
    }
    b.build()
}

fn few_lights() -> MethodKind {
    MethodKind::ManyLight(ManyLight {
        photon_paths: 8000,
        light_count: 100,
        importon_paths: 1000,
        ..ManyLight::bidirectional_lightcuts()
    })
}

/// Mean of a term over renders, and its standard error.
fn mean_of_renders(renders: &[Film], term: Layer) -> (f64, f64) {
    let means: Vec<f64> = renders.iter().map(|film| term_mean(film, term)).collect();
    let n = means.len() as f64;
    let mean = means.iter().sum::<f64>() / n;
    let squares: f64 = means.iter().map(|x| (x - mean).powi(2)).sum();
    (mean, (squares / (n * (n - 1.0))).sqrt())
}

/// Every term of the image agrees within four standard errors, which are small.
fn assert_agreement(scene: &Scene) {
    let path: Vec<Film> = (0..8)
        .map(|seed| film(scene, MethodKind::Path, 128, 100 + seed))
        .collect();
    let cuts: Vec<Film> = (0..16)
        .map(|seed| film(scene, few_lights(), 4, 200 + seed))
        .collect();
    for term in [Layer::Direct, Layer::VirtualLights] {
        let (truth, truth_error) = mean_of_renders(&path, term);
        let (mean, error) = mean_of_renders(&cuts, term);
        let z = (mean - truth) / error.hypot(truth_error);
        assert!(z.abs() < 4.0, "{term:?}: {mean} and {truth}, z {z}");
        assert!(error < 0.02 * truth, "{error} of {truth}");
    }
}

#[test]
fn a_diffuse_box_has_the_mean_of_the_path_tracer() {
    assert_agreement(&cornell_box(24, diffuse(0.7, 0.7, 0.7)));
}

#[test]
fn a_box_with_metal_has_the_mean_of_the_path_tracer() {
    assert_agreement(&cornell_box(24, rough_metal(0.3)));
}
