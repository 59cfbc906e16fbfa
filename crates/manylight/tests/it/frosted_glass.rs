//! Light through a specular and a rough interface.

use crate::common::film;
use manylight::color::Rgb;
use manylight::film::Layer;
use manylight::integrators::{ManyLight, MethodKind};
use manylight::math::Vec3;
use manylight::scene::Scene;
use manylight::testing::scenes::{Builder, diffuse, glass, rough_glass};
use manylight::testing::statistics::term_mean;

/// A lamp behind a clear pane behind a frosted one, each of a single interface.
fn panes() -> Scene {
    let mut b = Builder::new(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 30.0, 24);
    let frosted = b.material(rough_glass(0.4));
    b.rectangle(Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 2.0, frosted, None);
    let clear = b.material(glass());
    b.rectangle(Vec3::Z * -0.5, Vec3::X * 2.0, Vec3::Y * 2.0, clear, None);
    let black = b.material(diffuse(0.0, 0.0, 0.0));
    let lamp = b.area_light(Rgb::splat(5.0));
    b.rectangle(
        Vec3::Z * -1.0,
        Vec3::X * 0.8,
        Vec3::Y * 0.8,
        black,
        Some(lamp),
    );
    b.build()
}

#[test]
fn caustics_arrive_from_both_sides_of_frosted_glass() {
    let scene = panes();
    let mean = |kind, passes| term_mean(&film(&scene, kind, passes, 5), Layer::Caustics);
    let method = ManyLight {
        photon_paths: 60_000,
        light_count: 64,
        importon_paths: 1000,
        ..ManyLight::rich_vpl()
    };
    let truth = mean(MethodKind::Path, 2048);
    let ours = mean(MethodKind::ManyLight(method), 16);
    assert!(truth > 0.1, "{truth}");
    assert!(
        (ours / truth - 1.0).abs() < 0.02,
        "{ours} instead of {truth}"
    );
}
