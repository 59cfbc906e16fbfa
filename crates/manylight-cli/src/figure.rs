//! Numbers as false colors, and dots on a grey picture.

use manylight::color::Rgb;
use manylight::math::{UVec2, Vec2};
use manylight_io::image::{ImageLayer, LayeredImage, linear_from_srgb};

/// Viridis at nine even steps, as sRGB: perceptually even, and in order for the color-blind. Source: Smith, van der Walt, Matplotlib.
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

/// Percentiles of what is not 0 between which colors change: beyond are single pixels.
const PERCENTILES: [f32; 2] = [0.01, 0.995];

/// A logarithmic scale of colors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    /// What is shown by the first color, as is all below but 0.
    pub(crate) low: f32,
    /// What is shown by the last color, as is all above.
    pub(crate) high: f32,
}

impl Scale {
    /// The scale for `values`; `None` if none is positive.
    pub(crate) fn of(values: &[f32]) -> Option<Scale> {
        let is_shown = |v: &f32| *v > 0.0 && v.is_finite();
        let mut shown: Vec<f32> = values.iter().copied().filter(is_shown).collect();
        shown.sort_unstable_by(f32::total_cmp);
        let last = shown.len().checked_sub(1)?;
        let [low, high] = PERCENTILES.map(|share| shown[(share * last as f32).round() as usize]);
        Some(Scale { low, high })
    }

    /// Linear color of a value; black for 0.
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
        // Even steps are even as they are stored, not as light.
        let [a, b] =
            [VIRIDIS[i], VIRIDIS[i + 1]].map(|[r, g, b]| Rgb::new(r.into(), g.into(), b.into()));
        (a.lerp(b, at - i as f32) / 255.0).map(linear_from_srgb)
    }
}

/// `values` by their colors on a scale, or black without one.
pub(crate) fn false_colors(size: UVec2, values: &[f32], scale: Option<Scale>) -> LayeredImage {
    let color = |&v: &f32| scale.map_or(Rgb::BLACK, |scale| scale.color(v));
    picture(size, &values.iter().map(color).collect::<Vec<_>>())
}

/// Brightness of a white surface that faces the viewer, so that dots stand out.
const GREY: f32 = 0.3;
/// Linear color of dots.
const DOT: Rgb = Rgb::new(1.0, 0.55, 0.03);
/// Radius of dots in parts of the film's diagonal, and at least in pixels.
const DOT_RADIUS: (f32, f32) = (0.0022, 0.8);
/// Width of the dark rim that keeps dots apart from each other and from bright surfaces, in parts of their radius; and how much it hides.
const RIM: (f32, f32) = (0.5, 0.7);

/// Grey surfaces, `shading` in [0, 1], with a dot at each of the `places` in pixels.
pub(crate) fn dots(size: UVec2, shading: &[f32], places: &[Vec2]) -> LayeredImage {
    let mut pixels: Vec<Rgb> = shading.iter().map(|&v| Rgb::splat(v * GREY)).collect();
    let radius = (size.as_vec2().length() * DOT_RADIUS.0).max(DOT_RADIUS.1);
    for &place in places {
        draw_disc(&mut pixels, size, place, radius * (1.0 + RIM.0), |under| {
            under * (1.0 - RIM.1)
        });
    }
    for &place in places {
        draw_disc(&mut pixels, size, place, radius, |_| DOT);
    }
    picture(size, &pixels)
}

/// Replaces what is under a disc by its `paint`, in part at its edge.
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
        metadata: Vec::new(),
    }
}

/// A layer of three channels.
pub(crate) fn rgb_layer(name: &str, pixels: &[Rgb]) -> ImageLayer {
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

/// A layer of one channel.
pub(crate) fn gray_layer(name: &str, values: Vec<f32>) -> ImageLayer {
    ImageLayer {
        name: name.into(),
        channels: vec![(full_name(name, "Y"), values)],
    }
}

fn full_name(layer: &str, channel: &str) -> String {
    match layer {
        "" => channel.into(),
        _ => format!("{layer}.{channel}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_leave_out_zeros_and_single_values() {
        assert_eq!(Scale::of(&[0.0, -1.0, f32::NAN]), None);
        let mut values: Vec<f32> = (1..=1000).map(|i| i as f32).collect();
        values.extend([0.0; 500]);
        values.push(1e9);
        let scale = Scale::of(&values).unwrap();
        assert!((scale.low - 11.0).abs() < 2.0 && (scale.high - 996.0).abs() < 2.0);
    }

    #[test]
    fn colors_grow_brighter_and_zero_is_black() {
        let scale = Scale {
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
            // No step is to be seen: 1 in 400 of a range that ends near 0.77.
            assert!(luminance - last < 0.02, "step {step}");
            last = luminance;
        }
        assert_eq!(scale.color(1e-9), scale.color(0.01));
        assert_eq!(scale.color(1e9), scale.color(100.0));
        let alone = Scale {
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
        assert!((red[0] - GREY).abs() < 1e-6);
    }
}
