//! Pictures with something in them.

use super::Frame;
use super::frame::Correlation;

/// A frame of 48 x 40 pixels by a rule.
pub(super) fn frame(rule: impl Fn(usize, usize) -> [f32; 3]) -> Frame {
    let (width, height) = (48, 40);
    let pixels = (0..width * height).map(|i| rule(i % width, i / width));
    Frame {
        width,
        height,
        rgb: pixels.collect(),
        variance: None,
        correlation: Correlation::None,
        emission: None,
    }
}

fn lamp(x: usize, y: usize) -> bool {
    (21..26).contains(&x) && (11..14).contains(&y)
}

/// Colors that change slowly, and a bright lamp.
pub(super) fn ramp(x: usize, y: usize) -> [f32; 3] {
    let shine = if lamp(x, y) { 40.0 } else { 1.0 };
    [0.02 * x as f32 + 0.1, 0.02 * y as f32 + 0.05, 0.3].map(|v| v * shine)
}

/// The same with bright pixels, a blue side, and a darker lamp.
pub(super) fn ramp_and_spots(x: usize, y: usize) -> [f32; 3] {
    let spot = if (7 * x + 13 * y).is_multiple_of(11) {
        1.5
    } else {
        1.0
    };
    let (dim, shine) = if lamp(x, y) { (40.0, 30.0) } else { (1.0, 1.0) };
    let [r, g, b] = ramp(x, y).map(|v| v / dim * spot);
    let blue = if x > 30 { 0.1 } else { 0.0 };
    [r, g, b + blue].map(|v| v * shine)
}
