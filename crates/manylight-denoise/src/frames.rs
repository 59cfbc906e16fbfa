//! Frames of a walkthrough, averaged with frames before and after them, so that their noise does
//! not flicker.
//!
//! The surface point of a pixel is looked up in other frames, unless they see another surface in
//! its place. With `x` the value of the pixel, `m` that of the point `k` frames before or after, or
//! the mean of both, `x̄` the mean of the frame, `d = x² + 0.01 x̄²`, and `G` a Gaussian mean:
//!
//! * `σ² = 3.56 exp G[ln ((a - 2b + c)² / 6d)]` is the relative variance of the noise that changes
//!   from frame to frame, with `a`, `b` and `c` the values in three successive frames. Noise that
//!   all frames share does not count. Neither does light that changes linearly. The mean is
//!   geometric, because noise varies slowly over the picture: edges, which are blurred where they
//!   are looked up, are few large values.
//! * `β² = max(0, G[(x - m)² / d - (1 + v) σ²])` is the squared relative bias of `m`: light that
//!   depends on the view. The variance of `m` is `vσ²`, with `v = 1` for one frame and 1/2 for two.
//! * The result is the mean of `x`, with the weight `1 / σ²`, and of each `m`, with the weight
//!   `1 / (vσ² + β²)`.

use manylight::color::Rgb;
use manylight::image::{DARK_FLOOR, Image};
use manylight::math::{Mat4, Vec2, Vec3, Vec4};
use rayon::prelude::*;

/// Frames before and after a frame that are averaged with it. Kitchen, 5 frames of 96x54, with an
/// arithmetic mean in `σ²`, flicker and relMSE: at 2 0.0276 and 0.0031, at 3 0.0247 and 0.0032, at 4
/// the same; frames as they are 0.082 and 0.0042.
pub const REACH: usize = 3;
/// Largest distance of the surfaces that two frames show at one point, in pixels. At 1 flicker is
/// 1.08 times as large, at 3 the relMSE 1.02 times (as above).
const TOLERANCE: f32 = 1.5;
/// Standard deviation of `G`, in pixels. 1.5 and 3 change flicker and relMSE by 2 % there.
const SMOOTHING: f32 = 2.0;
/// Mean of the squares of normal numbers over their geometric mean: 2 exp γ, with Euler's constant.
/// Own Kitchen, U-Shape and Garage and the shared living-room, 5 frames of 96x54, `rich-vpl` and path
/// tracing, denoised: at 2.5, 3.6 and 5 the flicker is 0.058, 0.055 and 0.054, and the relMSE 0.0078,
/// 0.0081 and 0.0084 (geometric means); frames as they are 0.113 and 0.0098; with an arithmetic mean
/// in the place of the geometric one 0.073 and 0.0103.
const MEAN_OVER_GEOMETRIC: f32 = 3.56;
/// Least `σ²`: keeps weights finite where nothing changes. It is far below what can be seen.
const MIN_VARIANCE: f32 = 1e-10;

/// A frame of a walkthrough.
#[derive(Clone, Debug)]
pub struct WalkFrame {
    width: usize,
    height: usize,
    /// Radiance by pixel.
    radiance: Vec<Rgb>,
    /// World positions of the first surfaces, by pixel.
    surfaces: Vec<Option<Vec3>>,
    /// From world space to pixels, homogeneous.
    pixels_from_world: Mat4,
    /// The mean of the radiance, over pixels and channels.
    mean: f32,
}

/// What a frame shows at the surface points of another one, by pixel of the latter. `None`: nothing
/// of them.
type Reprojected = Vec<Option<Rgb>>;

impl WalkFrame {
    /// A frame with this picture, of three channels. `surfaces` has the mean world position of the
    /// first surfaces in each pixel, row by row from the top. `pixels_from_world` maps homogeneous
    /// world positions to columns and rows of the picture: pixel centers are at halves.
    pub fn new(picture: &Image, surfaces: Vec<Option<Vec3>>, pixels_from_world: Mat4) -> Self {
        let color = |pixel: &[f32]| Rgb::new(pixel[0], pixel[1], pixel[2]);
        let radiance: Vec<Rgb> = picture.data.chunks_exact(3).map(color).collect();
        let finite = radiance.iter().filter(|v| v.is_finite());
        let sum: f64 = finite.map(|v| f64::from(v.mean())).sum();
        WalkFrame {
            width: picture.width,
            height: picture.height,
            mean: (sum / radiance.len().max(1) as f64) as f32,
            radiance,
            surfaces,
            pixels_from_world,
        }
    }

    /// What `other` shows at the surface points of this frame.
    fn reprojected(&self, other: &WalkFrame) -> Reprojected {
        let look_up = |(i, point): (usize, &Option<Vec3>)| {
            let point = (*point)?;
            let center = Vec2::new((i % self.width) as f32, (i / self.width) as f32) + 0.5;
            let (from, to) = (self.place_of(point)?, other.place_of(point)?);
            // The mean of the positions in a pixel is not seen at its center.
            let at = center + (to - from);
            let is_seen = other.contains(at) && other.shows(point, to);
            let value = is_seen.then(|| other.interpolated(at));
            value.filter(|value| value.is_finite())
        };
        let surfaces = self.surfaces.par_iter().enumerate();
        surfaces.map(look_up).collect()
    }

    /// Where the camera sees a world position, in pixels; `None` behind it.
    fn place_of(&self, point: Vec3) -> Option<Vec2> {
        let place = self.pixels_from_world * point.extend(1.0);
        (place.w > 0.0).then(|| place.truncate().truncate() / place.w)
    }

    /// Whether a place is in the picture, and not in the outer half of its border pixels.
    fn contains(&self, at: Vec2) -> bool {
        let last = Vec2::new(self.width as f32, self.height as f32) - 0.5;
        at.cmpge(Vec2::splat(0.5)).all() && at.cmple(last).all()
    }

    /// Whether the surface at the place `at` is that of `point`, which is seen there: not farther
    /// from it than [`TOLERANCE`].
    fn shows(&self, point: Vec3, at: Vec2) -> bool {
        let (corner, part) = cell(at);
        let position = |dx: isize, dy: isize| self.surfaces[self.index(corner, [dx, dy])];
        let row = |dy| Some(position(0, dy)?.lerp(position(1, dy)?, part.x));
        let Some((above, below)) = row(0).zip(row(1)) else {
            return false;
        };
        let matrix = self.pixels_from_world;
        let w = matrix.row(3).dot(point.extend(1.0));
        // Pixels per unit of length, along the rows of the picture.
        let gradient = (matrix.row(0) - at.x * matrix.row(3)).truncate() / w;
        let distance = above.lerp(below, part.y).distance(point);
        distance * gradient.length() < TOLERANCE
    }

    /// The index of the pixel `offset` from `corner`, or of the nearest one in the picture.
    fn index(&self, corner: [isize; 2], offset: [isize; 2]) -> usize {
        let x = corner[0]
            .saturating_add(offset[0])
            .clamp(0, self.width as isize - 1);
        let y = corner[1]
            .saturating_add(offset[1])
            .clamp(0, self.height as isize - 1);
        y as usize * self.width + x as usize
    }

    /// The radiance at a place of the picture by a Catmull-Rom spline, within the range of the four
    /// nearest pixels. Bilinear means blur: they have 1.25 times the flicker and 1.17 times the
    /// relMSE. Without the bounds flicker is 1.07 times as large.
    fn interpolated(&self, at: Vec2) -> Rgb {
        let (corner, part) = cell(at);
        let (columns, rows) = (catmull_rom(part.x), catmull_rom(part.y));
        let mut sum = Rgb::BLACK;
        let (mut least, mut most) = (Rgb::splat(f32::INFINITY), Rgb::splat(f32::NEG_INFINITY));
        for (j, row) in (-1..).zip(rows) {
            for (i, column) in (-1..).zip(columns) {
                let value = self.radiance[self.index(corner, [i, j])];
                sum += value * (row * column);
                if (0..=1).contains(&i) && (0..=1).contains(&j) {
                    least = least.zip(value, f32::min);
                    most = most.zip(value, f32::max);
                }
            }
        }
        sum.zip(least, f32::max).zip(most, f32::min)
    }

    /// Gaussian means over the pixels that have a value; `None` where there is none near.
    fn local_means(
        &self,
        value: impl Fn(usize) -> Option<f32>,
    ) -> impl Iterator<Item = Option<f32>> {
        let mut sums = Image::new(self.width, self.height, 2);
        for (i, sum) in sums.data.chunks_exact_mut(2).enumerate() {
            if let Some(value) = value(i) {
                sum.copy_from_slice(&[value, 1.0]);
            }
        }
        let sums = sums.smoothed(SMOOTHING).data;
        (0..self.radiance.len()).map(move |i| match sums[2 * i + 1] {
            weight if weight > 0.0 => Some(sums[2 * i] / weight),
            _ => None,
        })
    }

    /// The squared difference of pixel `i` relative to `d`: the mean over channels.
    fn relative_square(&self, i: usize, difference: Rgb) -> f32 {
        let floor = DARK_FLOOR * self.mean * self.mean;
        let relative = |difference: f32, x: f32| match x * x + floor {
            scale if scale > 0.0 => difference * difference / scale,
            _ => 0.0,
        };
        difference.zip(self.radiance[i], relative).mean()
    }
}

/// The picture of frame `index`, averaged with up to [`REACH`] frames before and after it. Frames
/// have the same size. Pixels without a surface, or with values that are not finite, stay.
pub fn steady(frames: &[WalkFrame], index: usize) -> Image {
    let frame = &frames[index];
    let first = index.saturating_sub(REACH);
    let last = (index + REACH).min(frames.len() - 1);
    // The place of the frame among those that are averaged.
    let here = index - first;
    let own = || (frame.radiance.iter()).map(|&v| Some(v).filter(|v| v.is_finite()));
    let shown: Vec<Reprojected> = (first..=last)
        .map(|other| match other == index {
            true => own().collect(),
            false => frame.reprojected(&frames[other]),
        })
        .collect();
    let variances = variances(frame, &shown);
    let mut sums: Vec<(Rgb, f32)> = (frame.radiance.iter().zip(&variances))
        .map(|(&x, variance)| (x / *variance, 1.0 / variance))
        .collect();
    for distance in 1..=REACH {
        let before = here.checked_sub(distance).and_then(|i| shown.get(i));
        let after = shown.get(here + distance);
        let mean = |i: usize| mean_of([before, after].map(|shown| shown?[i]));
        let excess = |i: usize| {
            let (m, v) = mean(i)?;
            let square = frame.relative_square(i, frame.radiance[i] - m);
            Some(square - (1.0 + v) * variances[i]).filter(|excess| excess.is_finite())
        };
        let biases = frame.local_means(excess);
        for ((i, (sum, weights)), bias) in sums.iter_mut().enumerate().zip(biases) {
            if let Some((m, v)) = mean(i) {
                let weight = 1.0 / (v * variances[i] + bias.unwrap_or(0.0).max(0.0));
                *sum += m * weight;
                *weights += weight;
            }
        }
    }
    let means = sums.into_iter().zip(&frame.radiance);
    Image {
        width: frame.width,
        height: frame.height,
        channels: 3,
        data: means
            .flat_map(|((sum, weights), own)| match own.is_finite() {
                true => (sum / weights).to_array(),
                false => own.to_array(),
            })
            .collect(),
    }
}

/// `σ²` by pixel.
fn variances(frame: &WalkFrame, shown: &[Reprojected]) -> Vec<f32> {
    let squares = |i: usize| {
        let squares = shown.windows(3).filter_map(|three| {
            let second_difference = three[0][i]? - three[1][i]? * 2.0 + three[2][i]?;
            Some(frame.relative_square(i, second_difference) / 6.0)
        });
        let (sum, count) = squares.fold((0.0, 0), |(sum, n), square| (sum + square, n + 1));
        (count > 0).then(|| (sum / count as f32).max(MIN_VARIANCE).ln())
    };
    let geometric_means = frame.local_means(squares);
    let variance =
        |mean: Option<f32>| mean.map_or(MIN_VARIANCE, |mean| MEAN_OVER_GEOMETRIC * mean.exp());
    geometric_means.map(variance).collect()
}

/// The mean of the values that are there, and its variance in units of theirs.
fn mean_of(values: [Option<Rgb>; 2]) -> Option<(Rgb, f32)> {
    match values {
        [Some(a), Some(b)] => Some(((a + b) * 0.5, 0.5)),
        [Some(value), None] | [None, Some(value)] => Some((value, 1.0)),
        [None, None] => None,
    }
}

/// The upper left of the four nearest pixels, and the place between their centers.
fn cell(at: Vec2) -> ([isize; 2], Vec2) {
    let at = at - 0.5;
    let corner = at.floor();
    ([corner.x as isize, corner.y as isize], at - corner)
}

/// Weights of four successive values for the place `t` between the second and the third.
fn catmull_rom(t: f32) -> [f32; 4] {
    let powers = Vec4::new(1.0, t, t * t, t * t * t);
    [
        Vec4::new(0.0, -0.5, 1.0, -0.5),
        Vec4::new(1.0, 0.0, -2.5, 1.5),
        Vec4::new(0.0, 0.5, 2.0, -1.5),
        Vec4::new(0.0, 0.0, -0.5, 0.5),
    ]
    .map(|row| row.dot(powers))
}

#[cfg(test)]
mod tests {
    use super::*;
    use manylight::sampling::rng::Pcg;

    const WIDTH: usize = 48;
    const HEIGHT: usize = 32;
    /// Pixels that the camera moves from frame to frame.
    const STEP: f32 = 1.3;

    /// A frame of a wall at `z = 0`, with parallel rays and a pixel as the unit of length.
    fn wall(frame: usize, radiance: impl Fn(Vec2, Vec3) -> f32) -> WalkFrame {
        seen(frame, radiance, |at| Some(at.extend(0.0)))
    }

    /// A frame with a surface at `surface` of a place on the wall. `radiance` is that of a pixel and
    /// a place on the wall.
    fn seen(
        frame: usize,
        radiance: impl Fn(Vec2, Vec3) -> f32,
        surface: impl Fn(Vec2) -> Option<Vec3>,
    ) -> WalkFrame {
        let shift = STEP * frame as f32;
        let mut picture = Image::new(WIDTH, HEIGHT, 3);
        let mut surfaces = Vec::new();
        for (i, pixel) in picture.data.chunks_exact_mut(3).enumerate() {
            let pixel_center = Vec2::new((i % WIDTH) as f32, (i / WIDTH) as f32) + 0.5;
            let place = pixel_center + Vec2::new(shift, 0.0);
            surfaces.push(surface(place));
            pixel.fill(radiance(pixel_center, place.extend(0.0)));
        }
        let pixels_from_world = Mat4::from_translation(Vec3::new(-shift, 0.0, 0.0));
        WalkFrame::new(&picture, surfaces, pixels_from_world)
    }

    fn texture(place: Vec3) -> f32 {
        1.0 + 0.3 * (place.x / 4.0).sin() + 0.2 * (place.y / 3.0).cos()
    }

    fn noise(frame: usize, at: Vec2) -> f32 {
        let key = (frame as u64) << 40 | (at.x as u64) << 20 | at.y as u64;
        Pcg::new(key).next_f32() - 0.5
    }

    fn value(image: &Image, x: usize, y: usize) -> f32 {
        image.pixel(x, y)[0]
    }

    /// Root of the mean squared difference of two frames to the wall, and the root of the mean
    /// squared change of this difference from one frame to the next.
    fn errors(images: [&Image; 2], frames: [usize; 2]) -> [f32; 2] {
        let [mut errors, mut changes] = [0.0f64; 2];
        let shift = STEP as usize;
        for y in 4..HEIGHT - 4 {
            for x in 8..WIDTH - 8 {
                let error = |k: usize, x: usize| {
                    let place = x as f32 + 0.5 + STEP * frames[k] as f32;
                    value(images[k], x, y) - texture(Vec3::new(place, y as f32 + 0.5, 0.0))
                };
                errors += f64::from(error(0, x).powi(2));
                changes += f64::from((error(1, x - shift) - error(0, x)).powi(2));
            }
        }
        let count = ((HEIGHT - 8) * (WIDTH - 16)) as f64;
        [errors, changes].map(|sum| (sum / count).sqrt() as f32)
    }

    #[test]
    fn noise_of_frames_is_averaged() {
        let frame = |k| wall(k, |pixel, place| texture(place) + 0.4 * noise(k, pixel));
        let frames: Vec<WalkFrame> = (0..11).map(frame).collect();
        let alone = |k: usize| {
            let data = frames[k].radiance.iter().flat_map(|v| v.to_array());
            Image {
                data: data.collect(),
                ..Image::new(WIDTH, HEIGHT, 3)
            }
        };
        let before = errors([&alone(5), &alone(6)], [5, 6]);
        let after = errors([&steady(&frames, 5), &steady(&frames, 6)], [5, 6]);
        println!("errors {before:?}, then {after:?}");
        assert!(after[0] < 0.5 * before[0], "{before:?} {after:?}");
        assert!(after[1] < 0.3 * before[1], "{before:?} {after:?}");
    }

    /// A reflection that stands still on the screen while the wall moves.
    #[test]
    fn light_that_depends_on_the_view_stays() {
        let spot = |pixel: Vec2| 3.0 * (-(pixel.x - 24.0).powi(2) / 8.0).exp();
        let radiance = |k| move |pixel: Vec2, _| 1.0 + spot(pixel) + 0.05 * noise(k, pixel);
        let frames: Vec<WalkFrame> = (0..7).map(|k| wall(k, radiance(k))).collect();
        let steady = steady(&frames, 3);
        for x in 16..32 {
            let mean = (4..28).map(|y| value(&steady, x, y)).sum::<f32>() / 24.0;
            let expected = 1.0 + spot(Vec2::new(x as f32 + 0.5, 0.0));
            // The mean of the seven frames differs by 1.4 at the peak of 4.
            assert!((mean - expected).abs() < 0.6, "{x}: {mean} {expected}");
        }
    }

    /// A dark board in front of the wall, which moves over it.
    #[test]
    fn surfaces_behind_others_are_left_out() {
        let frame = |k: usize| {
            let is_board = move |pixel: Vec2| (18.0..26.0).contains(&pixel.x);
            let radiance = move |pixel, place| match is_board(pixel) {
                true => 0.1,
                false => texture(place) + 0.01 * noise(k, pixel),
            };
            let surface = move |place: Vec2| {
                let is_board = is_board(place - Vec2::new(STEP * k as f32, 0.0));
                Some(place.extend(if is_board { 9.0 } else { 0.0 }))
            };
            seen(k, radiance, surface)
        };
        let frames: Vec<WalkFrame> = (0..7).map(frame).collect();
        let steady = steady(&frames, 3);
        for x in 8..40 {
            let place = x as f32 + 0.5 + STEP * 3.0;
            let expected = match (18..26).contains(&x) {
                true => 0.1,
                false => texture(Vec3::new(place, 16.5, 0.0)),
            };
            let found = value(&steady, x, 16);
            assert!((found - expected).abs() < 0.02, "{x}: {found} {expected}");
        }
    }

    #[test]
    fn pixels_without_surface_and_damaged_values_stay() {
        let radiance = |k| {
            move |pixel: Vec2, _| match pixel == Vec2::new(20.5, 10.5) {
                true => f32::NAN,
                false => k as f32,
            }
        };
        let surface = |place: Vec2| (place.y > 4.0).then_some(place.extend(0.0));
        let frames: Vec<WalkFrame> = (0..5).map(|k| seen(k, radiance(k), surface)).collect();
        let steady = steady(&frames, 2);
        assert_eq!(value(&steady, 20, 2), 2.0);
        assert!(value(&steady, 20, 10).is_nan());
        let others = steady.data.iter().filter(|v| !v.is_nan());
        assert!(others.clone().all(|v| v.is_finite()));
        assert_eq!(others.count(), 3 * (WIDTH * HEIGHT - 1));
    }

    #[test]
    fn one_frame_alone_stays() {
        let frame = wall(0, |pixel, place| texture(place) + noise(0, pixel));
        let steady = steady(std::slice::from_ref(&frame), 0);
        for (value, own) in steady.data.chunks_exact(3).zip(&frame.radiance) {
            assert!((value[0] - own.r).abs() < 1e-5);
        }
    }

    #[test]
    fn places_follow_a_camera_in_perspective() {
        // A camera at the origin that looks along +z, 90° wide.
        let half = WIDTH as f32 / 2.0;
        let rows = [
            Vec4::new(half, 0.0, half, 0.0),
            Vec4::new(0.0, half, HEIGHT as f32 / 2.0, 0.0),
            Vec4::Z,
            Vec4::Z,
        ];
        let matrix = Mat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose();
        let point = |x: f32, y: f32| Vec3::new((x - half) / half, (y - 16.0) / half, 1.0) * 5.0;
        let surfaces = (0..WIDTH * HEIGHT)
            .map(|i| Some(point((i % WIDTH) as f32 + 0.5, (i / WIDTH) as f32 + 0.5)))
            .collect();
        let frame = WalkFrame::new(&Image::new(WIDTH, HEIGHT, 3), surfaces, matrix);
        let place = point(30.2, 9.4);
        let at = frame.place_of(place).unwrap();
        assert!(at.distance(Vec2::new(30.2, 9.4)) < 1e-3, "{at}");
        // A pixel is 5/24 wide there.
        assert!(frame.contains(at) && frame.shows(place, at));
        assert!(frame.shows(place * 0.97, at));
        assert!(!frame.shows(place * 0.9, at));
        assert_eq!(frame.place_of(-place), None);
        assert!(!frame.contains(frame.place_of(point(-3.0, 9.4)).unwrap()));
    }
}
