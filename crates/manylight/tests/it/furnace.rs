//! Closed rooms with a known answer: radiance 1 / (1 - albedo) everywhere.

use crate::common::film;
use manylight::film::Layer;
use manylight::integrators::{ManyLight, MethodKind, PhotonMap};
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
    // Without a clamp, the lights are unbiased; many of them, since the singularity makes them
    // noisy.
    let clamp = manylight::integrators::many_light::ClampRule::None;
    let vpl = ManyLight {
        photon_paths: 20_000,
        light_count: 2000,
        clamp,
        ..ManyLight::vpl()
    };
    check(MethodKind::ManyLight(vpl), 8, 2e-2);
}

fn photon_maps() -> [MethodKind; 2] {
    [PhotonMap::progressive(), PhotonMap::direct()].map(|method| {
        MethodKind::PhotonMap(PhotonMap {
            photon_paths: 20_000,
            ..method
        })
    })
}

#[test]
fn photon_maps_keep_the_light_of_a_closed_room() {
    for kind in photon_maps() {
        check(kind, 16, 5e-3);
    }
}

/// With paths of at most `d` segments the radiance is the first `d` terms of the geometric series.
#[test]
fn photon_maps_keep_to_the_depth_limit() {
    for kind in photon_maps() {
        for depth in 1..=4 {
            let mut room = furnace(RHO, 24);
            room.desc.limits.max_depth = Some(depth);
            let film = film(&room.build(), kind.clone(), 8, 1);
            let mean = layer_mean(&film, Layer::Beauty);
            let expected: f64 = (0..depth).map(|k| f64::from(RHO).powi(k as i32)).sum();
            assert!(
                (mean / expected - 1.0).abs() < 1e-2,
                "{kind:?} to depth {depth}: mean {mean}, expected {expected}"
            );
        }
    }
}
