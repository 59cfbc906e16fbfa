//! The same bits for any number of threads; the same image at any scale.

use crate::common::{film, film_with, methods};
use manylight::film::{ErrorBars, Layer};
use manylight::integrators::ExtraLayers;
use manylight::math::{Affine3A, Vec3};
use manylight::testing::scenes::{Builder, glossy_box};

#[test]
fn one_two_and_five_threads_give_the_same_bits() {
    for kind in methods() {
        let render = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| {
                film(&glossy_box(24).build(), kind.clone(), 2, 7)
                    .image(Layer::Beauty)
                    .unwrap()
            })
        };
        let one = render(1);
        assert!(
            one == render(2) && one == render(5),
            "{kind:?} depends on the number of threads"
        );
    }
}

#[test]
fn a_picture_is_the_same_without_other_layers() {
    let scene = glossy_box(24).build();
    for kind in methods() {
        let film = |picture_only| {
            let extra = ExtraLayers {
                picture_only,
                ..ExtraLayers::default()
            };
            film_with(&scene, kind.clone(), extra, 4, 7)
        };
        let (alone, beside) = (film(true), film(false));
        assert!(alone.layers().len() <= beside.layers().len(), "{kind:?}");
        for layer in [Layer::Beauty, Layer::Emission, Layer::Alpha] {
            assert!(alone.image(layer) == beside.image(layer), "{kind:?}");
        }
        assert!(alone.alpha() == beside.alpha(), "{kind:?}");
        assert!(alone.variance() == beside.variance(), "{kind:?}");
        let bars = |film| ErrorBars::of_film(film).map(|bars| bars.pixels);
        assert!(bars(&alone) == bars(&beside), "{kind:?}");
    }
}

fn scaled(mut b: Builder, scale: f32) -> Builder {
    let s = Affine3A::from_scale(Vec3::splat(scale));
    for primitive in &mut b.desc.primitives {
        primitive.world_from_object = s * primitive.world_from_object;
    }
    let sensor = &mut b.desc.sensors[0];
    sensor.world_from_camera.translation *= scale;
    sensor.near_clip *= scale;
    sensor.far_clip *= scale;
    b
}

#[test]
fn any_unit_of_length_gives_the_same_picture() {
    for kind in methods() {
        let render = |scale| {
            film(&scaled(glossy_box(24), scale).build(), kind.clone(), 4, 7)
                .image(Layer::Beauty)
                .unwrap()
        };
        let meters = render(1.0);
        // Millimeters and more. A power of two keeps nearly every rounding, so that the images
        // agree almost everywhere. Where one differs, a path may take another decision; the more
        // light is left to directions, the more pixels have such a path.
        for scale in [1024.0, 1.0 / 64.0] {
            let scaled = render(scale);
            let differing = meters
                .data
                .iter()
                .zip(&scaled.data)
                .filter(|(a, b)| (*a - *b).abs() > 1e-3 * a.abs().max(0.1))
                .count();
            assert!(
                differing * 25 <= meters.data.len(),
                "{kind:?} at {scale}: {differing} of {} values differ",
                meters.data.len()
            );
        }
    }
}
