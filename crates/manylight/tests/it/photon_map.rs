//! The bias of photon maps, and its convergence.

use crate::common::film;
use manylight::color::Rgb;
use manylight::film::{Film, Layer};
use manylight::integrators::{MethodKind, PhotonMap};
use manylight::math::Vec3;
use manylight::scene::Scene;
use manylight::testing::scenes::{Builder, diffuse, glossy_box};
use manylight::testing::statistics::layer_mean;

/// A floor under a small lamp, with a screen between them that shadows half of the floor, seen from
/// above.
fn floor_in_half_shadow() -> Scene {
    let mut b = Builder::new(Vec3::new(0.0, 4.0, -0.1), Vec3::ZERO, 22.0, 48);
    let grey = b.material(diffuse(0.5, 0.5, 0.5));
    let black = b.material(diffuse(0.0, 0.0, 0.0));
    b.rectangle(Vec3::ZERO, Vec3::Z, Vec3::X, grey, None);
    let lamp = b.area_light(Rgb::splat(400.0));
    b.rectangle(
        Vec3::new(0.0, 1.0, 1.5),
        Vec3::X * 0.05,
        Vec3::new(0.0, -0.03, 0.03),
        black,
        Some(lamp),
    );
    b.rectangle(
        Vec3::new(-0.55, 0.3, 1.05),
        Vec3::X * 0.5,
        Vec3::Y * 0.3,
        black,
        None,
    );
    b.build()
}

/// Relative root mean square difference of the beauty.
fn relative_difference(a: &Film, truth: &Film) -> f64 {
    let (a, truth) = (
        a.image(Layer::Beauty).unwrap(),
        truth.image(Layer::Beauty).unwrap(),
    );
    let pairs = || a.data.iter().zip(&truth.data);
    let (squares, whole) = pairs().fold((0.0, 0.0), |(squares, whole), (&x, &t)| {
        let (x, t) = (f64::from(x), f64::from(t));
        (squares + (x - t) * (x - t), whole + t * t)
    });
    (squares / whole).sqrt()
}

fn photon_map(method: PhotonMap, photon_paths: u32) -> MethodKind {
    MethodKind::PhotonMap(PhotonMap {
        photon_paths,
        ..method
    })
}

/// The mean is right, at the edges of the floor as well. The edge of the shadow is blurred, less so
/// with more photons.
#[test]
fn the_direct_photon_map_blurs_and_keeps_the_mean() {
    let scene = floor_in_half_shadow();
    let truth = film(&scene, MethodKind::Path, 1024, 11);
    let blur = [20_000, 320_000].map(|paths| {
        let film = film(&scene, photon_map(PhotonMap::direct(), paths), 8, 5);
        let ratio = layer_mean(&film, Layer::Beauty) / layer_mean(&truth, Layer::Beauty);
        assert!(
            (ratio - 1.0).abs() < 0.02,
            "{paths} paths: ratio of means {ratio}"
        );
        relative_difference(&film, &truth)
    });
    assert!(blur[0] < 0.2, "{blur:?}");
    assert!(blur[1] < 0.6 * blur[0], "{blur:?}");
}

/// Squared errors by blur and by noise both fall with the number n of passes, by about n^(-1/3).
#[test]
fn the_progressive_photon_map_converges() {
    let scene = glossy_box(32).build();
    let truth = film(&scene, MethodKind::Path, 4096, 11);
    let error = [2, 64].map(|passes| {
        let kind = photon_map(PhotonMap::progressive(), 5000);
        relative_difference(&film(&scene, kind, passes, 5), &truth)
    });
    assert!(error[1] < 0.4 * error[0], "{error:?}");
}
