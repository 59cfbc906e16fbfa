//! Synthetic images for tests.

use super::image::ComparisonImage;

/// An image of 48 x 40 pixels with the values `rule(x, y)`.
pub(super) fn frame(rule: impl Fn(usize, usize) -> [f32; 3]) -> ComparisonImage {
    let (width, height) = (48, 40);
    let pixels = (0..width * height).map(|i| rule(i % width, i / width));
    ComparisonImage::from_rgb(width, height, pixels.collect())
}

fn lamp(x: usize, y: usize) -> bool {
    (21..26).contains(&x) && (11..14).contains(&y)
}

/// A color gradient with a bright lamp.
pub(super) fn ramp(x: usize, y: usize) -> [f32; 3] {
    let gain = if lamp(x, y) { 40.0 } else { 1.0 };
    [0.02 * x as f32 + 0.1, 0.02 * y as f32 + 0.05, 0.3].map(|v| v * gain)
}

/// [`ramp`] with bright pixels, a blue side and a darker lamp.
pub(super) fn ramp_and_spots(x: usize, y: usize) -> [f32; 3] {
    let spot = if (7 * x + 13 * y).is_multiple_of(11) {
        1.5
    } else {
        1.0
    };
    let (dim, gain) = if lamp(x, y) { (40.0, 30.0) } else { (1.0, 1.0) };
    let [r, g, b] = ramp(x, y).map(|v| v / dim * spot);
    let blue = if x > 30 { 0.1 } else { 0.0 };
    [r, g, b + blue].map(|v| v * gain)
}
