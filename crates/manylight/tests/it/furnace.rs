//! Closed rooms whose answer is known: radiance 1 / (1 - albedo) everywhere.

use crate::common::film;
use manylight::film::Layer;
use manylight::integrators::{ManyLight, MethodKind};
use manylight::testing::scenes::furnace;
use manylight::testing::statistics::layer_mean;

const RHO: f32 = 0.6;

fn check(kind: MethodKind, passes: u32, tolerance: f64) {
    let film = film(&furnace(RHO, 32).build(), kind.clone(), passes, 1);
    let expected = 1.0 / (1.0 - f64::from(RHO));
    let mean = layer_mean(&film, Layer::Beauty);
    assert!(
        (mean / expected - 1.0).abs() < tolerance,
        "{kind:?}: mean {mean}, expected {expected}"
    );
}

#[test]
fn path_tracer() {
    check(MethodKind::Path, 64, 5e-3);
}

#[test]
fn light_tracer() {
    check(MethodKind::LightTracer, 256, 5e-3);
}

#[test]
fn rich_vpl() {
    check(
        MethodKind::ManyLight(ManyLight {
            photon_paths: 20_000,
            light_count: 400,
            ..ManyLight::rich_vpl()
        }),
        4,
        5e-3,
    );
}

#[test]
fn vpl() {
    // Unclamped, so unbiased; the lights are many because the singularity makes them noisy.
    let clamp = manylight::integrators::many_light::ClampRule::None;
    let vpl = ManyLight {
        photon_paths: 20_000,
        light_count: 2000,
        clamp,
        ..ManyLight::vpl()
    };
    check(MethodKind::ManyLight(vpl), 8, 2e-2);
}
