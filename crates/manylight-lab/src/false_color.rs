//! Maps of numbers in false colors, and dots on a shaded gray image.

use manylight::color::Rgb;
use manylight::math::{UVec2, Vec2};
use manylight_io::image::{ImageLayer, LayeredImage, full_name, linear_from_srgb};

/// The Viridis color map at nine even steps, in sRGB. It is perceptually uniform, also with color
/// vision deficiency. Source: Smith, van der Walt, Matplotlib.
const VIRIDIS: [[u8; 3]; 9] = [
    [68, 1, 84],
    [71, 45, 123],
    [59, 82, 139],
    [44, 114, 142],
    [33, 145, 140],
    [40, 174, 128],
    [94, 201, 98],
    [173, 220, 48],
    [253, 231, 37],
];

/// Percentiles of the positive values at the ends of the color scale. They exclude outliers of
/// single pixels; closer percentiles give more contrast and saturate more pixels.
const SCALE_PERCENTILES: [f32; 2] = [0.01, 0.995];

/// A logarithmic color scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorScale {
    /// Value of the first color; smaller positive values have it too.
    pub low: f32,
    /// Value of the last color; larger values have it too.
    pub high: f32,
}

impl ColorScale {
    /// The scale for `values`, from the 1st to the 99.5th percentile of the positive ones; `None`
    /// if none is positive.
    pub fn of(values: &[f32]) -> Option<ColorScale> {
        let is_shown = |v: &f32| *v > 0.0 && v.is_finite();
        let mut shown: Vec<f32> = values.iter().copied().filter(is_shown).collect();
        shown.sort_unstable_by(f32::total_cmp);
        let last = shown.len().checked_sub(1)?;
        let [low, high] =
            SCALE_PERCENTILES.map(|share| shown[(share * last as f32).round() as usize]);
        Some(ColorScale { low, high })
    }

    /// Linear color of a value; black for NaN, zero and negative values.
    fn color(self, value: f32) -> Rgb {
        if value.is_nan() || value <= 0.0 {
            return Rgb::BLACK;
        }
        let range = (self.high / self.low).ln();
        let t = match range > 0.0 {
            true => ((value / self.low).ln() / range).clamp(0.0, 1.0),
            false => 0.5,
        };
        let at = t * (VIRIDIS.len() - 1) as f32;
        let i = (at as usize).min(VIRIDIS.len() - 2);
        // The steps of the color map are even in sRGB, not in linear values.
        let [a, b] =
            [VIRIDIS[i], VIRIDIS[i + 1]].map(|[r, g, b]| Rgb::new(r.into(), g.into(), b.into()));
        (a.lerp(b, at - i as f32) / 255.0).map(linear_from_srgb)
    }
}

/// An image of `values`, one per pixel, on a color scale; black without a scale.
pub fn false_colors(size: UVec2, values: &[f32], scale: Option<ColorScale>) -> LayeredImage {
    let color = |&v: &f32| scale.map_or(Rgb::BLACK, |scale| scale.color(v));
    picture(size, &values.iter().map(color).collect::<Vec<_>>())
}

/// Linear value of a white surface facing the camera; dark enough for contrast with the dots. Not
/// measured.
const WHITE_LEVEL: f32 = 0.3;
/// Linear color of the dots.
const DOT_COLOR: Rgb = Rgb::new(1.0, 0.55, 0.03);
/// Radius of a dot in units of the image diagonal: 2.2 pixels at 800x600.
const DOT_RADIUS: f32 = 0.0022;
/// Smallest radius of a dot in pixels.
const MIN_DOT_RADIUS: f32 = 0.8;
/// Width of the dark rim around a dot in units of its radius. The rim separates dots from each
/// other and from bright surfaces.
const RIM_WIDTH: f32 = 0.5;
/// Opacity of the rim.
const RIM_OPACITY: f32 = 0.7;

/// A gray image of `shading`, one value in [0, 1] per pixel, with a dot at each of the `places`, in
/// pixels from the upper left corner.
pub fn dots(size: UVec2, shading: &[f32], places: &[Vec2]) -> LayeredImage {
    let mut pixels: Vec<Rgb> = shading
        .iter()
        .map(|&v| Rgb::splat(v * WHITE_LEVEL))
        .collect();
    let radius = (size.as_vec2().length() * DOT_RADIUS).max(MIN_DOT_RADIUS);
    for &place in places {
        draw_disc(
            &mut pixels,
            size,
            place,
            radius * (1.0 + RIM_WIDTH),
            |under| under * (1.0 - RIM_OPACITY),
        );
    }
    for &place in places {
        draw_disc(&mut pixels, size, place, radius, |_| DOT_COLOR);
    }
    picture(size, &pixels)
}

/// Replaces the pixels under a disc by `paint` of their values, with antialiased edges.
fn draw_disc(
    pixels: &mut [Rgb],
    size: UVec2,
    center: Vec2,
    radius: f32,
    paint: impl Fn(Rgb) -> Rgb,
) {
    let reach = Vec2::splat(radius + 1.0);
    let first = (center - reach).floor().max(Vec2::ZERO).as_uvec2();
    let end = (center + reach).ceil().as_uvec2().min(size);
    for y in first.y..end.y {
        for x in first.x..end.x {
            let pixel = &mut pixels[(y * size.x + x) as usize];
            let distance = center.distance(UVec2::new(x, y).as_vec2() + 0.5);
            let coverage = (radius + 0.5 - distance).clamp(0.0, 1.0);
            *pixel = pixel.lerp(paint(*pixel), coverage);
        }
    }
}

fn picture(size: UVec2, pixels: &[Rgb]) -> LayeredImage {
    LayeredImage {
        width: size.x as usize,
        height: size.y as usize,
        layers: vec![rgb_layer("", pixels)],
        ..LayeredImage::default()
    }
}

/// A layer with the channels R, G and B.
pub fn rgb_layer(name: &str, pixels: &[Rgb]) -> ImageLayer {
    let channel = |c: usize| pixels.iter().map(|rgb| rgb.to_array()[c]).collect();
    ImageLayer {
        name: name.into(),
        channels: vec![
            (full_name(name, "R"), channel(0)),
            (full_name(name, "G"), channel(1)),
            (full_name(name, "B"), channel(2)),
        ],
    }
}

/// A layer with the channel Y.
pub fn gray_layer(name: &str, values: Vec<f32>) -> ImageLayer {
    ImageLayer {
        name: name.into(),
        channels: vec![(full_name(name, "Y"), values)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_leave_out_zeros_and_single_values() {
        assert_eq!(ColorScale::of(&[0.0, -1.0, f32::NAN]), None);
        let mut values: Vec<f32> = (1..=1000).map(|i| i as f32).collect();
        values.extend([0.0; 500]);
        values.push(1e9);
        let scale = ColorScale::of(&values).unwrap();
        assert!((scale.low - 11.0).abs() < 2.0 && (scale.high - 996.0).abs() < 2.0);
    }

    #[test]
    fn colors_grow_brighter_and_zero_is_black() {
        let scale = ColorScale {
            low: 0.01,
            high: 100.0,
        };
        assert_eq!(scale.color(0.0), Rgb::BLACK);
        let mut last = 0.0;
        for step in 0..=400 {
            let luminance = scale
                .color(10f32.powf(step as f32 / 100.0 - 2.0))
                .luminance();
            assert!(luminance > last, "step {step}");
            // No visible steps: 400 steps up to a luminance near 0.77.
            assert!(luminance - last < 0.02, "step {step}");
            last = luminance;
        }
        assert_eq!(scale.color(1e-9), scale.color(0.01));
        assert_eq!(scale.color(1e9), scale.color(100.0));
        let alone = ColorScale {
            low: 1.0,
            high: 1.0,
        };
        assert!(alone.color(1.0).is_finite());
    }

    #[test]
    fn dots_stand_where_they_should_even_at_edges() {
        let size = UVec2::new(40, 30);
        let places = [Vec2::new(10.5, 20.5), Vec2::new(39.9, 0.1)];
        let picture = dots(size, &[1.0; 1200], &places);
        let [red, blue] = ["R", "B"].map(|name| picture.channel(name).unwrap());
        let is_dot = |i: &usize| red[*i] > 0.9 && blue[*i] < 0.1;
        let found: Vec<usize> = (0..1200).filter(is_dot).collect();
        assert!(
            found.contains(&(20 * 40 + 10)) && found.len() < 10,
            "{found:?}"
        );
        assert!(red[39] > 0.5, "{}", red[39]);
        assert!((red[0] - WHITE_LEVEL).abs() < 1e-6);
    }
}
