//! Error bars: intervals that hold the true values of a picture with a probability of 95 %.
//!
//! A bar is 1.96 standard errors `s` wide. They are smoothed relative to the values of the picture,
//! so that a lamp does not count on what is beside it. With `d = x² + 0.01 m²`, `m` the mean of the
//! picture, and `G` a Gaussian mean:
//!
//! * As rendered, `s² = d G[v / d]`, where `v` is the variance of the pixel or block. A variance
//!   from few passes is as noisy as the value, and low where the value is low by chance: therefore
//!   it is smoothed. So is the `x` in `d`, as `G[√x]²`, in which rare bright samples count little.
//! * Filtered, `s² = 2 d G[√(v / d)]²`. With `a` and `b` the filtered halves of `n_a` and `n_b` of
//!   the `n` passes, and `y = (n_a a + n_b b) / n`, `v = n_a n_b / n² (a - b)² + c (x - y)²`. The
//!   first term estimates the variance of `y`. The second term estimates the squared bias of the
//!   filter. The bias falls as passes are added, and `y` comes from half as many passes as `x`.
//! * Blocks of filtered pictures have `s² = d G[v / d]`. One pair of halves is too few for the
//!   variance of a block. The first term of `v` is its variance as rendered, times the ratio of
//!   filtered to rendered noise in a wider neighborhood.

use super::{Film, Layer, TILE_SIZE};
use crate::image::{DARK_FLOOR, Image};

/// Half-width of a normal interval that holds 95 %, in standard deviations.
const NORMAL_95: f32 = 1.96;
/// Standard deviation of the smoothing of variances of pixels, in pixels. With none, 27 to 86 % of
/// pixels are inside the bars, with this 92 to 96 %, and with 1 84 to 95 % (eight scenes, 16 passes
/// of `path`, as are the figures below).
const SMOOTHING: f32 = 1.5;
/// Standard deviation of the smoothing of the values in `d`, in pixels. The stated error is 0.8 to
/// 1.4 times the true one. At 1.5 pixels it is 0.7 to 1.2 times, and unsmoothed 0.1 to 0.8 times.
const VALUE_SMOOTHING: f32 = 2.0;
/// Standard deviation of the smoothing of variances and values of blocks, in tiles. 94 to 96 % of
/// blocks are inside the bars; without smoothing of values 78 to 96 %.
const TILE_SMOOTHING: f32 = 1.0;
/// Standard deviation of the smoothing of squared differences of filtered halves, which have one
/// degree of freedom, in pixels. At 3 the standard errors that hold 95 % vary by 13 % over scenes,
/// with this by 7 %.
const FILTERED_SMOOTHING: f32 = 2.0;
/// Ratio of the mean square of errors to their squared mean. Normal errors have π/2, by which the
/// stated error of `rich-vpl` is 0.80 to 0.98 times the true one.
const TAIL_FACTOR: f32 = 2.0;
/// Standard deviation of the means from which the ratio of filtered to rendered noise is taken, in
/// tiles. At 2 the standard errors that hold 95 % vary by 11 %, at 5 by 9 % (`rich-vpl`).
const RATIO_SMOOTHING: f32 = 5.0;
/// Factor `c` of `(x - y)²`: that of a bias that falls as `n^-0.77`. With 1, 2 and 4 `path` needs
/// 1.05, 0.98 and 0.91 times the standard errors of `rich-vpl` to hold 95 %.
const BIAS_FACTOR: f32 = 2.0;
/// Margin of the upper bound. Stated errors are at least 0.87 times the true ones in the mean over
/// seeds (eight scenes, `path`, as rendered and filtered).
const MODEL_FACTOR: f32 = 1.15;
/// Quantile of a normal distribution below which 95 % lie.
const ONE_SIDED_95: f64 = 1.645;

/// Half-widths of intervals at 95 % around the values of a picture, per channel.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorBars {
    /// Of the pixels.
    pub pixels: Image,
    /// Of the means over tiles. All pixels of a tile hold its value.
    pub blocks: Image,
    /// The error of the whole picture.
    pub stated: StatedError,
}

/// Errors of a picture relative to its values: root mean squares over all channels of `s² / d`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StatedError {
    /// Of pixels.
    pub pixels: f32,
    /// Of means over tiles.
    pub blocks: f32,
    /// Upper bound of `pixels`, with a confidence of 95 %: as if tiles were drawn at random, with a
    /// margin for the model.
    pub at_most: f32,
    /// The part of the squared error in the hundredth of the tiles with the largest; 0 for fewer
    /// than a hundred tiles.
    pub concentration: f32,
}

impl ErrorBars {
    /// Those of the beauty of `film`; `None` if its variances are not known: before two batches of
    /// passes.
    pub fn of_film(film: &Film) -> Option<Self> {
        let (image, of_tiles) = (film.image(Layer::Beauty)?, tile_variance(film)?);
        let values = squared_values(&typical_values(film, &image));
        let pixels = quotient(&film.variance(), &values).smoothed(SMOOTHING);
        let tile_values = squared_values(&tiles_of(&image).smoothed(TILE_SMOOTHING));
        let tiles = quotient(&of_tiles, &tile_values).smoothed(TILE_SMOOTHING);
        Some(ErrorBars {
            pixels: bars(&pixels, &values),
            blocks: to_pixels(&bars(&tiles, &tile_values), film),
            stated: StatedError::new(&pixels, &tiles),
        })
    }

    /// Those of the filtered picture `image` of `film`, with the filtered images of both halves of
    /// its passes; `None` if its variances are not known, or one half has no passes.
    pub fn of_filtered(film: &Film, image: &Image, halves: [&Image; 2]) -> Option<Self> {
        let counts = film.half_counts();
        let of_tiles = tile_variance(film).filter(|_| counts.are_both())?;
        // Both terms of `v`, relative to `d`.
        let [first, second] = counts.shares();
        let relative_terms = |image: &Image, values: &Image, [a, b]: [&Image; 2]| {
            let noise = combined(a, b, |a, b| first * second * (a - b) * (a - b));
            let mean = combined(a, b, |a, b| first * a + second * b);
            let bias = combined(image, &mean, |x, y| BIAS_FACTOR * (x - y) * (x - y));
            [noise, bias].map(|term| quotient(&term, values))
        };
        let values = squared_values(image);
        let [noise, bias] = relative_terms(image, &values, halves);
        let errors = combined(&noise, &bias, |noise, bias| (noise + bias).sqrt());
        let errors = errors.smoothed(FILTERED_SMOOTHING);
        let pixels = combined(&errors, &errors, |a, b| TAIL_FACTOR * a * b);

        let tile_image = tiles_of(image);
        let tile_values = squared_values(&tile_image);
        let tile_halves = halves.map(tiles_of);
        let [noise, bias] = relative_terms(&tile_image, &tile_values, tile_halves.each_ref());
        let rendered = quotient(&of_tiles, &tile_values);
        let left = quotient(
            &noise.smoothed(RATIO_SMOOTHING),
            &rendered.smoothed(RATIO_SMOOTHING),
        );
        let noise = combined(&rendered.smoothed(TILE_SMOOTHING), &left, |v, left| {
            v * left
        });
        let bias = bias.smoothed(TILE_SMOOTHING);
        let tiles = combined(&noise, &bias, |noise, bias| noise + bias);
        Some(ErrorBars {
            pixels: bars(&pixels, &values),
            blocks: to_pixels(&bars(&tiles, &tile_values), film),
            stated: StatedError::new(&pixels, &tiles),
        })
    }
}

impl StatedError {
    /// From `s² / d` of pixels and of tiles.
    fn new(pixels: &Image, tiles: &Image) -> Self {
        let by_tile = tiles_of(pixels);
        let mut squares: Vec<f64> = by_tile.data.chunks_exact(3).map(mean).collect();
        squares.sort_by(f64::total_cmp);
        let count = squares.len() as f64;
        let sum: f64 = squares.iter().sum();
        let mean_square = sum / count;
        let spread = |square: &f64| (square - mean_square).powi(2);
        let deviation = (squares.iter().map(spread).sum::<f64>() / count).sqrt();
        let largest = squares.len() / 100;
        let in_largest: f64 = squares.iter().rev().take(largest).sum();
        StatedError {
            pixels: mean_square.sqrt() as f32,
            blocks: mean(&tiles.data).sqrt() as f32,
            at_most: MODEL_FACTOR
                * (mean_square + ONE_SIDED_95 * deviation / count.sqrt()).sqrt() as f32,
            concentration: (in_largest / sum.max(f64::MIN_POSITIVE)) as f32,
        }
    }
}

/// Variances of the means over tiles, a pixel for each; `None` if they are not known.
fn tile_variance(film: &Film) -> Option<Image> {
    let tiles = tiles_of(&film.block_variance());
    let is_known = film.passes() >= 2 && tiles.data.iter().all(|v| v.is_finite());
    is_known.then_some(tiles)
}

/// Error bars from squared relative standard errors.
fn bars(relative: &Image, values: &Image) -> Image {
    combined(relative, values, |relative, value| {
        NORMAL_95 * (relative * value).max(0.0).sqrt()
    })
}

/// `x` without its noise: what is emitted, and the smoothed rest.
fn typical_values(film: &Film, image: &Image) -> Image {
    let emission = film.image(Layer::Emission);
    let emission = emission.unwrap_or_else(|| Image::new(image.width, image.height, 3));
    let roots = combined(image, &emission, |x, emitted| (x - emitted).max(0.0).sqrt());
    let roots = roots.smoothed(VALUE_SMOOTHING);
    combined(&roots, &emission, |root, emitted| root * root + emitted)
}

/// `d` of each value; 1 in a black image.
fn squared_values(image: &Image) -> Image {
    let mean = mean(&image.data) as f32;
    let floor = DARK_FLOOR * mean * mean;
    let floor = if floor > 0.0 { floor } else { 1.0 };
    combined(image, image, |x, _| x * x + floor)
}

fn mean(values: &[f32]) -> f64 {
    values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len().max(1) as f64
}

/// 0 where the divisor is 0.
fn quotient(a: &Image, b: &Image) -> Image {
    combined(a, b, |a, b| if b > 0.0 { a / b } else { 0.0 })
}

fn combined(a: &Image, b: &Image, value: impl Fn(f32, f32) -> f32) -> Image {
    let both = a.data.iter().zip(&b.data);
    Image {
        data: both.map(|(&a, &b)| value(a, b)).collect(),
        ..*a
    }
}

/// Means over tiles, a pixel for each.
fn tiles_of(image: &Image) -> Image {
    let edge = TILE_SIZE as usize;
    let (width, height) = (image.width.div_ceil(edge), image.height.div_ceil(edge));
    let mut tiles = Image::new(width, height, image.channels);
    let mut counts = vec![0.0; width * height];
    for y in 0..image.height {
        for x in 0..image.width {
            let tile = y / edge * width + x / edge;
            counts[tile] += 1.0;
            let sums = &mut tiles.data[tile * image.channels..][..image.channels];
            for (sum, value) in sums.iter_mut().zip(image.pixel(x, y)) {
                *sum += value;
            }
        }
    }
    for (sums, count) in tiles.data.chunks_exact_mut(image.channels).zip(counts) {
        sums.iter_mut().for_each(|sum| *sum /= count);
    }
    tiles
}

/// Copies the value of each tile of `film` to its pixels.
fn to_pixels(tiles: &Image, film: &Film) -> Image {
    let size = film.image_size().as_usizevec2();
    let edge = TILE_SIZE as usize;
    let mut image = Image::new(size.x, size.y, tiles.channels);
    for (i, pixel) in image.data.chunks_exact_mut(tiles.channels).enumerate() {
        pixel.copy_from_slice(tiles.pixel(i % size.x / edge, i / size.x / edge));
    }
    image
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::film::{FilmDesc, Filter, Half};
    use crate::math::UVec2;
    use crate::sampling::rng::Pcg;
    use std::sync::atomic::{AtomicBool, AtomicU64};

    const SIZE: UVec2 = UVec2::new(45, 38);

    fn truth(pixel: UVec2) -> f32 {
        1.0 + 0.02 * pixel.x as f32
    }

    /// Passes of skewed noise, in which a batch of `batch` passes has `shared` noise in all pixels
    /// of a tile.
    fn film(seed: u64, passes: u32, batch: u32, shared: f32) -> Film {
        let desc = FilmDesc {
            size: SIZE,
            crop_offset: UVec2::ZERO,
            crop_size: SIZE,
            filter: Filter::Box,
        };
        let mut film = Film::new(desc, &[Layer::Beauty, Layer::Direct]);
        for pass in 0..passes {
            if pass % batch == 0 {
                film.begin_batch();
            }
            film.set_half(Half::of_set(pass / batch));
            let never = AtomicBool::new(false);
            film.add_pass(&never, &AtomicU64::new(0), |samples| {
                let corner = samples.tile().pixels().next().unwrap();
                let tile = u64::from(corner.y) << 32 | u64::from(corner.x);
                let mut of_batch = Pcg::new(seed ^ tile ^ u64::from(pass / batch) << 16);
                let mut of_pass = Pcg::new(!seed ^ tile ^ u64::from(pass) << 16);
                let common = shared * (of_batch.next_f32() - 0.5);
                for (i, pixel) in samples.tile().pixels().enumerate() {
                    let noise = -(1.0 - of_pass.next_f32()).ln() - 1.0;
                    let value = truth(pixel) + 0.5 * noise + common;
                    samples.add(i, Layer::Direct, Rgb::splat(value));
                }
            });
        }
        film.begin_batch();
        film
    }

    /// Fractions of the pixels and of the tiles of `image` with the truth within `bars`.
    fn coverage(image: &Image, bars: &ErrorBars) -> [f64; 2] {
        let size = SIZE.as_usizevec2();
        let mut expected = Image::new(size.x, size.y, 3);
        for (i, pixel) in expected.data.chunks_exact_mut(3).enumerate() {
            pixel.fill(truth(UVec2::new((i % size.x) as u32, (i / size.x) as u32)));
        }
        let inside = |image: &Image, expected: &Image, bars: &Image| {
            let errors = image.data.iter().zip(&expected.data).map(|(x, r)| x - r);
            let inside = errors.zip(&bars.data).filter(|(e, bar)| e.abs() <= **bar);
            inside.count() as f64 / image.data.len() as f64
        };
        let [tiles, expected_tiles, bars_of_tiles] = [image, &expected, &bars.blocks].map(tiles_of);
        [
            inside(image, &expected, &bars.pixels),
            inside(&tiles, &expected_tiles, &bars_of_tiles),
        ]
    }

    /// Mean coverage over films of different seeds.
    fn mean_coverage(bars: impl Fn(u64) -> (Image, ErrorBars)) -> [f64; 2] {
        let seeds = 40;
        let mut sum = [0.0; 2];
        for seed in 0..seeds {
            let (image, bars) = bars(seed);
            for (sum, share) in sum.iter_mut().zip(coverage(&image, &bars)) {
                *sum += share / seeds as f64;
            }
        }
        sum
    }

    #[test]
    fn intervals_hold_the_truth_in_95_of_100_cases() {
        for (batch, shared) in [(1, 0.0), (1, 1.0), (4, 1.0)] {
            let [pixels, blocks] = mean_coverage(|seed| {
                let film = film(seed, 32, batch, shared);
                let bars = ErrorBars::of_film(&film).unwrap();
                (film.image(Layer::Beauty).unwrap(), bars)
            });
            println!("batches of {batch}, shared {shared}: {pixels:.3} {blocks:.3}");
            assert!((0.93..0.97).contains(&pixels), "{pixels}");
            assert!((0.92..0.98).contains(&blocks), "{blocks}");
        }
    }

    /// A filter that leaves a fifth of the noise, and darkens by a part of the noise that it gets.
    #[test]
    fn intervals_of_filtered_pictures_know_noise_and_bias() {
        for bias in [0.0, 0.4] {
            let [pixels, blocks] = mean_coverage(|seed| {
                let film = film(seed, 32, 1, 0.3);
                let filter = |image: Image, passes: u32| {
                    let smooth = image.smoothed(1.0);
                    let loss = bias * (passes as f32).powf(-0.77);
                    combined(&smooth, &smooth, |v, _| v - loss)
                };
                let image = filter(film.image(Layer::Beauty).unwrap(), 32);
                let halves = Half::BOTH
                    .map(|half| filter(film.half_image(Layer::Beauty, half).unwrap(), 16));
                let bars = ErrorBars::of_filtered(&film, &image, halves.each_ref()).unwrap();
                (image, bars)
            });
            println!("bias {bias}: {pixels:.3} {blocks:.3}");
            assert!((0.90..0.995).contains(&pixels), "{pixels}");
            assert!((0.88..0.995).contains(&blocks), "{blocks}");
        }
    }

    #[test]
    fn the_stated_error_is_the_true_one() {
        let mut within = 0;
        for seed in 0..40 {
            let film = film(seed, 16, 1, 0.0);
            let stated = ErrorBars::of_film(&film).unwrap().stated;
            let image = film.image(Layer::Beauty).unwrap();
            let values = squared_values(&image);
            let mut sum = 0.0;
            for (i, pixel) in image.data.chunks_exact(3).enumerate() {
                let x = (i % SIZE.x as usize) as u32;
                let error = f64::from(pixel[0] - truth(UVec2::new(x, 0)));
                sum += error * error / f64::from(values.data[3 * i]);
            }
            let actual = (sum / f64::from(SIZE.x * SIZE.y)).sqrt() as f32;
            assert!(
                (stated.pixels / actual - 1.0).abs() < 0.15,
                "{stated:?} {actual}"
            );
            assert!(stated.blocks < 0.25 * stated.pixels, "independent pixels");
            within += usize::from(actual <= stated.at_most);
        }
        println!("{within} of 40 are at most what is stated");
        assert!(within >= 34, "{within}");
    }

    #[test]
    fn rare_bright_light_is_known() {
        let mut relative = Image::new(80, 80, 3);
        relative.data.fill(0.01);
        let concentration = |relative: &Image| StatedError::new(relative, relative).concentration;
        assert!((concentration(&relative) - 0.01).abs() < 1e-3);
        relative.data[3 * (80 * 20 + 30)..][..3].fill(1000.0);
        assert!(concentration(&relative) > 0.9);
    }

    /// A filter may leave noise where the picture has none.
    #[test]
    fn a_picture_without_noise_has_finite_bars() {
        let desc = film(1, 1, 1, 0.0).desc().clone();
        let mut black = Film::new(desc, &[Layer::Beauty]);
        for pass in 0..4 {
            black.begin_batch();
            black.set_half(Half::of_set(pass));
            black.add_pass(&AtomicBool::new(false), &AtomicU64::new(0), |_| {});
        }
        black.begin_batch();
        let image = black.image(Layer::Beauty).unwrap();
        let noisy = combined(&image, &image, |_, _| 1e-3);
        for bars in [
            ErrorBars::of_film(&black),
            ErrorBars::of_filtered(&black, &image, [&image, &noisy]),
        ] {
            let ErrorBars {
                pixels,
                blocks,
                stated,
            } = bars.unwrap();
            let all = pixels.data.iter().chain(&blocks.data);
            assert!(all.copied().all(f32::is_finite));
            assert!(
                stated.pixels.is_finite() && stated.at_most.is_finite(),
                "{stated:?}"
            );
        }
    }

    #[test]
    fn unknown_variances_have_no_bars() {
        for (passes, batch) in [(1, 1), (8, 8)] {
            let film = film(1, passes, batch, 0.1);
            assert_eq!(ErrorBars::of_film(&film), None);
            let image = film.image(Layer::Beauty).unwrap();
            assert_eq!(
                ErrorBars::of_filtered(&film, &image, [&image, &image]),
                None
            );
        }
    }
}
