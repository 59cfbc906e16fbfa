//! Caustics that low-roughness lobes reflect: their shape on the film, and their energy, by photons
//! and by directions.

use crate::common::film;
use manylight::color::Rgb;
use manylight::emitters::Emitter;
use manylight::film::{Film, Layer};
use manylight::integrators::{ManyLight, MethodKind};
use manylight::math::Vec3;
use manylight::scene::Scene;
use manylight::testing::scenes::{Builder, diffuse, rough_metal};
use manylight::texture::ColorInput;

/// Pixels along an edge of the pictures.
const SIZE: usize = 48;

/// A floor of rough metal in front of a mirror. The camera sees a part of the floor 0.2 m wide.
fn floor_before_a_mirror(alpha: f32) -> Builder {
    let eye = Vec3::new(0.0, 0.3, -0.9);
    let mut b = Builder::new(eye, Vec3::ZERO, 12.0, SIZE as u32);
    let floor = b.material(rough_metal(alpha));
    let mirror = b.material(rough_metal(0.001));
    b.rectangle(Vec3::ZERO, Vec3::X * 4.0, Vec3::Z * -4.0, floor, None);
    let (center, right) = (Vec3::new(0.0, 2.0, 1.0), Vec3::X * -2.0);
    b.rectangle(center, right, Vec3::Y * 2.0, mirror, None);
    b
}

/// The floor with a narrow upright lamp that shines towards the mirror: the streak on the floor is
/// narrower than 72 pixels.
fn with_lamp(alpha: f32, emitter: impl Fn(ColorInput) -> Emitter) -> Scene {
    let mut b = floor_before_a_mirror(alpha);
    let black = b.material(diffuse(0.0, 0.0, 0.0));
    let lamp = b.emitter(emitter(ColorInput::Constant(Rgb::splat(20.0))));
    let (center, right) = (Vec3::new(0.0, 1.0, -1.0), Vec3::X * 0.05);
    b.rectangle(center, right, Vec3::Y * 0.5, black, Some(lamp));
    b.build()
}

fn few_lights() -> MethodKind {
    MethodKind::ManyLight(ManyLight {
        photon_paths: 200_000,
        light_count: 16,
        importon_paths: 1000,
        ..ManyLight::rich_vpl()
    })
}

/// Sums of the caustics over the columns of a film.
fn columns(film: &Film) -> Vec<f64> {
    let image = film.image(Layer::Caustics).expect("a term");
    let mut sums = vec![0.0; SIZE];
    for (i, &value) in image.data.iter().enumerate() {
        sums[i / 3 % SIZE] += f64::from(value);
    }
    sums
}

/// Energy of the caustics of `scene` relative to that of `truth`.
fn energy(scene: &Scene, truth: &Scene) -> f64 {
    let sum = |film| columns(&film).iter().sum::<f64>();
    let total = sum(film(truth, MethodKind::Path, 1024, 5));
    assert!(total > 0.0);
    sum(film(scene, few_lights(), 8, 5)) / total
}

#[test]
fn reflections_of_caustics_are_as_sharp_as_by_path_tracing() {
    let scene = with_lamp(0.1, |radiance| Emitter::Area { radiance });
    let truth = columns(&film(&scene, MethodKind::Path, 1024, 5));
    let ours = columns(&film(&scene, few_lights(), 8, 5));
    let total: f64 = truth.iter().sum();
    assert!(total > 0.0);
    let ratio = ours.iter().sum::<f64>() / total;
    assert!((ratio - 1.0).abs() < 0.03, "energy {ratio}");
    let difference: f64 = truth.iter().zip(&ours).map(|(a, b)| (a - b).abs()).sum();
    let relative = difference / total;
    assert!(relative < 0.1, "{relative}: {truth:?} {ours:?}");
}

#[test]
fn photons_carry_light_that_no_direction_finds() {
    // The light of the visible lamp, which path tracing finds, reaches the same part of the floor.
    // Few photons lie there, which the allowance is for.
    let hidden = with_lamp(0.4, |radiance| Emitter::InvisibleArea { radiance });
    let visible = with_lamp(0.4, |radiance| Emitter::Area { radiance });
    let ratio = energy(&hidden, &visible);
    assert!((ratio - 1.0).abs() < 0.2, "{ratio}");
}

#[test]
fn the_sky_in_a_mirror_has_its_light_once() {
    let mut b = floor_before_a_mirror(0.1);
    b.emitter(Emitter::Constant {
        radiance: Rgb::new(0.5, 1.0, 2.0),
    });
    let scene = b.build();
    let ratio = energy(&scene, &scene);
    assert!((ratio - 1.0).abs() < 0.03, "{ratio}");
}
