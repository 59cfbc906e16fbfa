//! Means, variances and cancelled passes of a small film.

use super::*;
use crate::color::Rgb;
use crate::math::UVec2;
use std::sync::atomic::{AtomicBool, AtomicU64};

fn film() -> Film {
    let size = UVec2::new(19, 11);
    let desc = FilmDesc {
        size,
        crop_offset: UVec2::ZERO,
        crop_size: size,
        filter: Filter::Box,
    };
    Film::new(desc, &[Layer::Beauty, Layer::Direct, Layer::Depth])
}

fn add(film: &mut Film, value: impl Fn(UVec2) -> f32 + Sync, cancel: bool) -> u64 {
    let dropped = AtomicU64::new(0);
    // Tiles may lie elsewhere in each pass.
    let shift = UVec2::new(5, 3) * film.passes();
    film.add_tiled_pass(
        Tiling {
            shift,
            ..Tiling::UNSHIFTED
        },
        &AtomicBool::new(cancel),
        &dropped,
        |samples| {
            for (i, pixel) in samples.tile().pixels().enumerate() {
                samples.add(i, Layer::Direct, Rgb::splat(value(pixel)));
                samples.add(i, Layer::Depth, Rgb::splat(1.0));
            }
        },
    );
    dropped.into_inner()
}

#[test]
fn mean_and_variance_of_the_mean() {
    let mut film = film();
    assert!(film.variance().data.iter().all(|v| v.is_infinite()));
    for k in 0..4 {
        add(
            &mut film,
            |p| p.x as f32 + 100.0 * p.y as f32 + k as f32,
            false,
        );
    }
    let image = film.image(Layer::Beauty).unwrap();
    assert_eq!(image.pixel(7, 9), &[908.5; 3]);
    assert_eq!(film.image(Layer::Direct).unwrap(), image);
    assert_eq!(film.image(Layer::Depth).unwrap().pixel(0, 0), &[1.0; 3]);
    assert!(film.image(Layer::Caustics).is_none());
    // The beauty has one term.
    assert_eq!(film.layer_variance(Layer::Direct), Some(film.variance()));
    assert!(film.layer_variance(Layer::Depth).is_none());
    assert!(film.layer_variance(Layer::Caustics).is_none());
    // Values 0, 1, 2, 3 about their mean: sample variance 5/3, of the mean 5/12.
    assert!(
        film.variance()
            .data
            .iter()
            .all(|v| (v - 5.0 / 12.0).abs() < 1e-4)
    );
}

#[test]
fn means_over_pixels_vary_from_batch_to_batch() {
    let mut film = film();
    let noise = |p: UVec2| {
        if (p.x + p.y).is_multiple_of(2) {
            1.0
        } else {
            -1.0
        }
    };
    for light in [0.0, 1.0, 2.0, 3.0] {
        film.begin_batch();
        // The common value of all pixels changes by batch; the noise of single pixels cancels over
        // pairs of pixels and of passes.
        add(&mut film, |p| 5.0 + light + noise(p), false);
        add(&mut film, |p| 5.0 + light - noise(p), false);
    }
    assert_eq!(film.batches(), 3);
    film.begin_batch();
    assert_eq!(film.batches(), 4);
    let expected = 5.0 / 12.0;
    let blocks = film.block_variance();
    assert!(
        blocks
            .data
            .iter()
            .all(|v| (v - expected as f32).abs() < 1e-5)
    );
    for v in film.mean_variance() {
        assert!((v - expected).abs() < 1e-9, "{v}");
    }
    assert_eq!(film.mean_variance(), film.mean_variance_without_emission());
}

#[test]
fn one_batch_gives_no_variance() {
    let mut film = film();
    film.begin_batch();
    for _ in 0..2 {
        assert_eq!(film.batches(), 0);
        assert!(film.block_variance().data.iter().all(|v| v.is_infinite()));
        add(&mut film, |_| 1.0, false);
    }
    film.begin_batch();
    film.begin_batch();
    assert_eq!(film.batches(), 1);
    assert!(film.mean_variance()[0].is_infinite());
}

#[test]
fn a_cancelled_pass_leaves_no_trace() {
    let mut film = film();
    add(&mut film, |_| 1.0, false);
    add(&mut film, |_| 100.0, true);
    assert_eq!(film.passes(), 1);
    assert_eq!(film.image(Layer::Beauty).unwrap().pixel(3, 3), &[1.0; 3]);
}

#[test]
fn non_finite_pixels_are_dropped_and_counted() {
    let mut film = film();
    let dropped = add(&mut film, |p| if p.x == 2 { f32::NAN } else { 1.0 }, false);
    assert_eq!(dropped, 11);
    assert_eq!(film.image(Layer::Beauty).unwrap().pixel(2, 0), &[0.0; 3]);
}

#[test]
fn planes_are_the_channels_of_images() {
    let size = UVec2::new(37, 13);
    let desc = FilmDesc {
        size,
        crop_offset: UVec2::ZERO,
        crop_size: size,
        filter: Filter::Box,
    };
    let mut film = Film::new(desc, &[Layer::Beauty, Layer::Direct, Layer::Depth]);
    for pass in 1..4 {
        film.add_pass(&AtomicBool::new(false), &AtomicU64::new(0), |samples| {
            for (i, pixel) in samples.tile().pixels().enumerate() {
                let place = (100 * pixel.y + pixel.x) as f32;
                samples.add(i, Layer::Direct, Rgb::new(place, pass as f32, 0.1));
                samples.add(i, Layer::Depth, Rgb::splat(place / pass as f32));
            }
        });
    }
    let channels = [(0, 1), (1, 0), (2, 2), (1, 1)];
    for (plane, (layer, channel)) in film.planes(&channels).into_iter().zip(channels) {
        let image = film.image(film.layers()[layer]).unwrap();
        let values = image.data.chunks_exact(3).map(|pixel| pixel[channel]);
        assert!(plane.into_iter().eq(values), "{layer} {channel}");
    }
}
