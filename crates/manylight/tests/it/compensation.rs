//! Clamping and its compensation add up to the path tracer, in corners and at contacts, with few
//! lights and a strong clamp.

use crate::common::film;
use manylight::bsdf::Material;
use manylight::color::Rgb;
use manylight::film::Layer;
use manylight::geometry::{Mesh, Shape};
use manylight::integrators::many_light::{ClampRule, Compensation, Resampling};
use manylight::integrators::{ManyLight, MethodKind};
use manylight::math::{Affine3A, Vec3};
use manylight::scene::Scene;
use manylight::testing::scenes::{Builder, diffuse, furnace, rough_metal};
use manylight::testing::statistics::term_mean;

/// A corner of bright walls with a plate of some material that nearly touches the floor.
fn corner(size: u32, plate: Material) -> Scene {
    let mut b = Builder::new(
        Vec3::new(0.9, 0.8, 0.9),
        Vec3::new(-1.0, -0.9, -1.0),
        60.0,
        size,
    );
    let white = b.material(diffuse(0.8, 0.8, 0.8));
    b.room([white; 6], None);
    let light = b.area_light(Rgb::splat(8.0));
    b.rectangle(
        Vec3::new(0.2, 0.97, 0.4),
        Vec3::X * 0.4,
        Vec3::Z * 0.4,
        white,
        Some(light),
    );
    let place = Affine3A::from_translation(Vec3::new(-0.55, -0.85, -0.5))
        * Affine3A::from_scale(Vec3::new(0.3, 0.08, 0.3));
    let plate = b.material(plate);
    b.place(Shape::Mesh(Mesh::cube()), place, plate, None);
    b.build()
}

/// 4 lights per pass. Groups of 8 passes have 8 times as many.
fn few_lights() -> ManyLight {
    ManyLight {
        photon_paths: 16_000,
        light_count: 4,
        importon_paths: 250,
        resampling: Resampling::New,
        ..ManyLight::rich_vpl()
    }
}

/// Mean of virtual lights and compensation.
fn mean(scene: &Scene, kind: MethodKind, passes: u32) -> f64 {
    term_mean(&film(scene, kind, passes, 5), Layer::VirtualLights)
}

/// The clamp removes much light, and compensation restores it up to `tolerance`.
fn assert_whole(scene: &Scene, truth_passes: u32, tolerance: f64) {
    let truth = mean(scene, MethodKind::Path, truth_passes);
    let ratio = |method| mean(scene, MethodKind::ManyLight(method), 256) / truth;
    let lossy = ManyLight {
        compensation: Compensation::None,
        ..few_lights()
    };
    let (without, with) = (ratio(lossy), ratio(few_lights()));
    assert!(without < 0.992, "the clamp removes little here: {without}");
    assert!(
        (with - 1.0).abs() < tolerance,
        "{with}, without compensation {without}"
    );
}

#[test]
fn no_light_is_lost_in_corners() {
    assert_whole(&corner(24, diffuse(0.8, 0.8, 0.8)), 2048, 4e-3);
}

/// Of the lamp light that low-roughness lobes reflect, directions and photons each account for a
/// part: the sum is complete.
#[test]
fn light_that_metal_reflects_nearby_is_not_lost() {
    assert_whole(&corner(24, rough_metal(0.1)), 4096, 6e-3);
}

/// A small lamp that a metal floor reflects to the foot of a wall: most of the light there is close
/// to what reflects it, in directions that only photons find.
fn metal_before_wall() -> Scene {
    let mut b = Builder::new(
        Vec3::new(0.0, 0.5, -1.5),
        Vec3::new(0.0, 0.15, 0.0),
        15.0,
        16,
    );
    let metal = b.material(rough_metal(0.1));
    b.rectangle(Vec3::Z * -0.5, Vec3::Z * 0.5, Vec3::X * 0.5, metal, None);
    let white = b.material(diffuse(0.8, 0.8, 0.8));
    let up = Vec3::Y * 0.5;
    b.rectangle(up, up, Vec3::X * 0.5, white, None);
    let black = b.material(diffuse(0.0, 0.0, 0.0));
    let lamp = b.area_light(Rgb::splat(500.0));
    b.rectangle(
        Vec3::new(0.0, 1.5, -1.5),
        Vec3::X * 0.05,
        Vec3::Z * 0.05,
        black,
        Some(lamp),
    );
    b.build()
}

/// Under a small limit of path length, photons after a reflection by metal still compensate
/// clamping.
#[test]
fn no_light_is_lost_at_the_limit_of_path_length() {
    let mut scene = metal_before_wall();
    scene.limits.max_depth = Some(3);
    assert_whole(&scene, 4096, 1e-2);
}

/// Without compensation, the lost light decreases with progressive refinement.
#[test]
fn refined_lights_lose_less() {
    let scene = corner(24, diffuse(0.8, 0.8, 0.8));
    let truth = mean(&scene, MethodKind::Path, 2048);
    let loss = |resampling| {
        let method = ManyLight {
            compensation: Compensation::None,
            resampling,
            ..few_lights()
        };
        1.0 - mean(&scene, MethodKind::ManyLight(method), 512) / truth
    };
    let (coarse, fine) = (loss(Resampling::New), loss(Resampling::Progressive));
    assert!(coarse > 0.008, "the clamp removes little here: {coarse}");
    assert!(fine < 0.7 * coarse, "{fine} of {coarse}");
}

/// Each kind of clamp removes other light, and compensation restores it.
#[test]
fn any_clamp_has_its_complement() {
    let scene = furnace(0.6, 16).build();
    let truth = mean(&scene, MethodKind::Path, 1024);
    for clamp in [ClampRule::Auto, ClampRule::Value(1.0)] {
        for method in [few_lights(), ManyLight::vpl(), ManyLight::vpl_importance()] {
            let method = ManyLight {
                photon_paths: 8000,
                light_count: 200,
                importon_paths: 2000,
                clamp,
                ..method
            };
            let ratio = mean(&scene, MethodKind::ManyLight(method), 32) / truth;
            assert!((ratio - 1.0).abs() < 1.5e-2, "{method:?}: {ratio}");
        }
    }
}
