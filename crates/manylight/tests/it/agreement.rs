//! The many-light methods and progressive photon mapping against the path tracer, term by term.

use crate::common::film;
use manylight::bsdf::Material;
use manylight::color::Rgb;
use manylight::emitters::Emitter;
use manylight::film::{Film, Layer};
use manylight::geometry::Shape;
use manylight::integrators::many_light::{
    ClampRule, Compensation, EmissionKind, FluxRule, GlossyForm, Kernel, Placement,
};
use manylight::integrators::{ManyLight, MethodKind, PhotonMap};
use manylight::math::{Affine3A, Vec3};
use manylight::scene::{MediumDesc, Scene};
use manylight::testing::scenes::{
    Builder, diffuse, glass, glossy_box, rough_glass, rough_metal, rough_plastic,
};
use manylight::testing::statistics::{layer_mean, term_mean};

const TERMS: [Layer; 4] = [
    Layer::Emission,
    Layer::Direct,
    Layer::VirtualLights,
    Layer::Caustics,
];

fn reference(scene: &Scene) -> Film {
    film(scene, MethodKind::Path, 1024, 11)
}

fn rich() -> MethodKind {
    MethodKind::ManyLight(ManyLight {
        photon_paths: 40_000,
        light_count: 600,
        importon_paths: 4000,
        ..ManyLight::rich_vpl()
    })
}

fn photon_map(photon_paths: u32) -> MethodKind {
    MethodKind::PhotonMap(PhotonMap {
        photon_paths,
        ..PhotonMap::progressive()
    })
}

/// Tolerance of the emission layer, relative to the mean of the beauty: the lamp covers few pixels,
/// so that few passes have noise there.
const EMISSION_TOLERANCE: f64 = 0.06;

/// Asserts that each term differs by at most `tolerance` times the mean of the beauty.
fn check(scene: &Scene, method: MethodKind, passes: u32, tolerance: f64) {
    let (truth, ours) = (reference(scene), film(scene, method, passes, 5));
    let beauty = layer_mean(&truth, Layer::Beauty);
    for layer in TERMS {
        let (a, b) = (term_mean(&truth, layer), term_mean(&ours, layer));
        let tolerance = if layer == Layer::Emission {
            EMISSION_TOLERANCE
        } else {
            tolerance
        };
        assert!(
            (a - b).abs() < tolerance * beauty,
            "{layer:?}: path {a}, ours {b}, beauty {beauty}"
        );
    }
}

#[test]
fn rich_vpl_in_a_glossy_room() {
    check(&glossy_box(32).build(), rich(), 8, 1e-2);
}

/// The sky through a slit in the ceiling: directions are sampled from the surfaces, emitter samples
/// from the sky and from the guide.
fn room_under_a_window() -> Scene {
    let mut b = Builder::new(
        Vec3::new(0.0, 0.1, -0.98),
        Vec3::new(0.0, -0.15, 1.0),
        70.0,
        32,
    );
    let (white, open) = (
        b.material(diffuse(0.7, 0.6, 0.5)),
        b.material(Material::Null),
    );
    let floor = b.material(rough_plastic(0.2, Rgb::splat(0.3)));
    b.room([white, white, floor, open, white, white], None);
    for side in [-1.0, 1.0] {
        b.rectangle(
            Vec3::new(side * 0.55, 0.99, 0.0),
            Vec3::X * 0.45,
            Vec3::Z,
            white,
            None,
        );
    }
    b.emitter(Emitter::Constant {
        radiance: Rgb::new(1.0, 2.0, 4.0),
    });
    b.build()
}

#[test]
fn rich_vpl_under_a_window() {
    check(&room_under_a_window(), rich(), 8, 1e-2);
}

/// Mirrors, glass and near-delta metal: all rows of the path partition occur.
fn room_with_specular_objects() -> Scene {
    let mut b = glossy_box(32);
    let (ball, mirror) = (b.material(glass()), b.material(rough_metal(0.03)));
    let sphere = |center, radius| Shape::Sphere { center, radius };
    b.place(
        sphere(Vec3::new(0.1, -0.6, -0.2), 0.25),
        Affine3A::IDENTITY,
        ball,
        None,
    );
    b.place(
        sphere(Vec3::new(0.5, 0.2, 0.4), 0.3),
        Affine3A::IDENTITY,
        mirror,
        None,
    );
    b.build()
}

#[test]
fn rich_vpl_with_specular_objects() {
    check(&room_with_specular_objects(), rich(), 12, 1.5e-2);
}

/// A ball of colored glass with something white in it.
fn room_with_an_absorbing_ball() -> Scene {
    let mut b = glossy_box(32);
    let ball = b.material(glass());
    let white = b.material(diffuse(0.8, 0.8, 0.8));
    b.desc.media.push(MediumDesc {
        material: ball,
        absorption: Rgb::new(0.2, 2.0, 4.0),
    });
    let center = Vec3::new(0.1, -0.45, -0.1);
    for (radius, material) in [(0.4, ball), (0.15, white)] {
        let shape = Shape::Sphere { center, radius };
        b.place(shape, Affine3A::IDENTITY, material, None);
    }
    b.build()
}

#[test]
fn rich_vpl_with_an_absorbing_ball() {
    check(&room_with_an_absorbing_ball(), rich(), 12, 1.5e-2);
}

/// A metal floor before a mirror: specular chains see lit walls in the mirror, and photons estimate
/// the reflected lamp.
fn mirror_over_a_glossy_floor() -> Scene {
    let mut b = Builder::new(
        Vec3::new(0.0, 0.1, -0.98),
        Vec3::new(0.0, -0.3, 1.0),
        75.0,
        32,
    );
    let (wall, red) = (
        b.material(diffuse(0.6, 0.6, 0.6)),
        b.material(diffuse(0.6, 0.1, 0.08)),
    );
    let (floor, mirror) = (b.material(rough_metal(0.25)), b.material(rough_metal(0.03)));
    b.room([red, wall, floor, wall, wall, mirror], None);
    let lamp = b.area_light(Rgb::splat(6.0));
    b.rectangle(
        Vec3::new(0.3, 0.98, -0.3),
        Vec3::X * 0.3,
        Vec3::Z * 0.3,
        wall,
        Some(lamp),
    );
    b.build()
}

#[test]
fn rich_vpl_with_a_mirror_over_a_glossy_floor() {
    check(&mirror_over_a_glossy_floor(), rich(), 12, 1e-2);
}

/// Photons account for the light that the floor sees in the mirror, where they are dense, and
/// directions for the rest.
#[test]
fn rich_vpl_with_dense_photons_in_a_mirror_over_a_glossy_floor() {
    for photon_paths in [4000, 300_000] {
        let method = MethodKind::ManyLight(ManyLight {
            photon_paths,
            light_count: 600,
            importon_paths: 4000,
            ..ManyLight::rich_vpl()
        });
        check(&mirror_over_a_glossy_floor(), method, 24, 1e-2);
    }
}

fn room_lit_through_frosted_glass() -> Scene {
    let mut b = Builder::new(
        Vec3::new(0.0, 0.6, -0.98),
        Vec3::new(0.0, 0.4, 1.0),
        75.0,
        32,
    );
    let wall = b.material(diffuse(0.6, 0.6, 0.6));
    let glass = b.material(rough_glass(0.3));
    b.room([wall; 6], None);
    // All light comes from below the pane; importons arrive from above.
    b.rectangle(Vec3::ZERO, Vec3::Z, Vec3::X, glass, None);
    let lamp = b.area_light(Rgb::splat(6.0));
    b.rectangle(
        Vec3::new(0.3, -0.98, -0.3),
        Vec3::Z * 0.3,
        Vec3::X * 0.3,
        wall,
        Some(lamp),
    );
    b.build()
}

#[test]
fn rich_vpl_lit_through_frosted_glass() {
    check(&room_lit_through_frosted_glass(), rich(), 12, 1.5e-2);
}

#[test]
fn importance_placed_vpls_unclamped() {
    let clamp = ClampRule::None;
    let vpl = ManyLight {
        photon_paths: 20_000,
        light_count: 2000,
        importon_paths: 4000,
        clamp,
        ..ManyLight::vpl_importance()
    };
    let vpl = MethodKind::ManyLight(vpl);
    check(&glossy_box(32).build(), vpl, 16, 2e-2);
}

#[test]
fn photon_map_in_a_glossy_room() {
    check(&glossy_box(32).build(), photon_map(20_000), 32, 7e-3);
}

#[test]
fn photon_map_under_a_window() {
    // Few photons pass through the slit.
    check(&room_under_a_window(), photon_map(100_000), 16, 1e-2);
}

#[test]
fn photon_map_with_specular_objects() {
    check(&room_with_specular_objects(), photon_map(20_000), 24, 1e-2);
}

/// High-roughness lobes that transmit gather from both sides.
#[test]
fn photon_map_through_frosted_glass() {
    check(
        &room_lit_through_frosted_glass(),
        photon_map(20_000),
        24,
        1e-2,
    );
}

#[test]
fn the_terms_sum_to_the_beauty() {
    let direct = MethodKind::PhotonMap(PhotonMap {
        photon_paths: 20_000,
        ..PhotonMap::direct()
    });
    for kind in [rich(), photon_map(20_000), direct] {
        let film = film(&glossy_box(16).build(), kind, 2, 3);
        let beauty = film.image(Layer::Beauty).unwrap();
        let terms = TERMS.iter().chain(&[Layer::Compensation]);
        let terms: Vec<_> = terms.filter_map(|&term| film.image(term)).collect();
        for i in 0..beauty.data.len() {
            let sum: f32 = terms.iter().map(|image| image.data[i]).sum();
            assert!(
                (sum - beauty.data[i]).abs() <= 1e-4 * beauty.data[i].max(1.0),
                "{sum} and {}",
                beauty.data[i]
            );
        }
    }
}

/// Every value of every axis, in a room where each has a small bias: within the bias that the
/// documentation states.
#[test]
fn all_axes_give_nearly_the_same_room() {
    let scene = glossy_box(32).build();
    let rich = ManyLight {
        photon_paths: 20_000,
        light_count: 400,
        importon_paths: 4000,
        ..ManyLight::rich_vpl()
    };
    let sphere = ManyLight {
        kernel: Kernel::Sphere,
        clamp: ClampRule::None,
        compensation: Compensation::None,
        ..rich
    };
    let single = EmissionKind::Single;
    let relaxed = Placement::Relaxed;
    let density = FluxRule::Density;
    for (method, tolerance) in [
        (
            ManyLight {
                placement: relaxed,
                ..rich
            },
            1.5e-2,
        ),
        (
            ManyLight {
                flux: density,
                ..rich
            },
            2e-2,
        ),
        (
            ManyLight {
                emission: single,
                ..rich
            },
            2e-2,
        ),
        (
            ManyLight {
                emission: EmissionKind::Rich(GlossyForm::Lobes { count: 5 }),
                ..rich
            },
            1.5e-2,
        ),
        (sphere, 3e-2),
        (
            ManyLight {
                emission: single,
                flux: density,
                ..sphere
            },
            3e-2,
        ),
    ] {
        check(&scene, MethodKind::ManyLight(method), 12, tolerance);
    }
}

#[test]
#[should_panic(expected = "spheres with cuts")]
fn contradictory_settings_start_no_render() {
    let scene = glossy_box(8).build();
    let settings = ManyLight {
        kernel: Kernel::Sphere,
        ..ManyLight::rich_lightcuts()
    };
    film(&scene, MethodKind::ManyLight(settings), 1, 0);
}
