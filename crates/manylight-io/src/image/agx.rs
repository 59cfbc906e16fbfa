//! The AgX view of Blender as a formula.
//!
//! The steps and the curve are those that the AgX of Troy Sobotka and its development by Zijun Eary
//! Zhou describe: an inset of the gamut, a sigmoid over 16.5 stops in each channel, a partial
//! return to the hue before the sigmoid, an outset, and a compensation of negative channels.
//! Blender applies them as a table of 57 samples per axis. The matrices and the mixture of hues
//! here are a least-squares fit to the colors that Blender 5.0's configuration gives, by
//! `docs/measurements/pictures/agx_fit.py`. The difference is largest in almost black channels of
//! saturated colors, where Blender interpolates between few samples.

/// Middle gray, the pivot of the curve.
const GRAY: f32 = 0.18;
/// Stops below and above middle gray that the curve spans.
const STOPS: [f32; 2] = [10.0, 6.5];
/// Slope of the curve at middle gray, by its normalized axes, and exponent of its ends.
const SLOPE: f32 = 2.4;
const EXPONENT: f32 = 1.5;
/// Exponent of the encoding in which the curve is defined.
const ENCODING: f32 = 2.4;
/// From linear Rec. 709 to the channels of the curve. Fitted.
const INSET: [[f32; 3]; 3] = [
    [0.5580, 0.3598, 0.0822],
    [0.1399, 0.7545, 0.1056],
    [0.0877, 0.1755, 0.7368],
];
/// From the channels of the curve to linear Rec. 709. Fitted.
const OUTSET: [[f32; 3]; 3] = [
    [1.9121, -0.7951, -0.1170],
    [-0.2938, 1.3174, -0.0236],
    [-0.1582, -0.2338, 1.3920],
];
/// Part of the hue before the curve in the result. Fitted.
const HUE_KEPT: f32 = 0.57;
/// Luminance of linear Rec. 709.
const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Linear Rec. 709 in and out. Negative values are set to 0 first.
pub(super) fn agx(color: [f32; 3]) -> [f32; 3] {
    let inset = product(
        &INSET,
        color.map(|v| if v > 0.0 { v.min(1e30) } else { 0.0 }),
    );
    let curved = inset.map(curve);
    let mixed = with_mixed_hue(inset, curved);
    without_negatives(product(&OUTSET, mixed))
}

fn product(matrix: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    matrix.map(|row| dot(row, v))
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn largest(v: [f32; 3]) -> f32 {
    v[0].max(v[1]).max(v[2])
}

fn smallest(v: [f32; 3]) -> f32 {
    v[0].min(v[1]).min(v[2])
}

/// The sigmoid of one linear channel, linear again.
fn curve(v: f32) -> f32 {
    let [below, above] = STOPS;
    let (x0, y0) = (below / (below + above), GRAY.powf(1.0 / ENCODING));
    let stops = (v / GRAY).max(f32::MIN_POSITIVE).log2();
    let x = ((stops + below) / (below + above)).clamp(0.0, 1.0) - x0;
    // Each half ends at the corner of the unit square.
    let (reach, rise) = if x < 0.0 {
        (x0, y0)
    } else {
        (1.0 - x0, 1.0 - y0)
    };
    let line = SLOPE * reach;
    let scale = line / ((line / rise).powf(EXPONENT) - 1.0).powf(1.0 / EXPONENT);
    let t = SLOPE * x.abs() / scale;
    let bent = scale * t / (1.0 + t.powf(EXPONENT)).powf(1.0 / EXPONENT);
    let y = y0 + bent.copysign(x);
    y.clamp(0.0, 1.0).powf(ENCODING)
}

/// `curved` with the hue turned towards that of `inset`, by the hue of the HSV hexagon.
fn with_mixed_hue(inset: [f32; 3], curved: [f32; 3]) -> [f32; 3] {
    let (low, high) = (smallest(curved), largest(curved));
    let (Some(before), Some(after)) = (hue(inset), hue(curved)) else {
        return curved;
    };
    let turn = (before - after + 3.0).rem_euclid(6.0) - 3.0;
    let hue = after + HUE_KEPT * turn;
    // Piecewise linear in the hue; red, green and blue have their peaks at 0, 2 and 4.
    [5.0, 3.0, 1.0].map(|offset| {
        let k = (offset + hue).rem_euclid(6.0);
        high - (high - low) * k.min(4.0 - k).clamp(0.0, 1.0)
    })
}

/// Hue in sixths of a turn; `None` for gray.
fn hue([r, g, b]: [f32; 3]) -> Option<f32> {
    let high = largest([r, g, b]);
    let range = high - smallest([r, g, b]);
    if range <= 0.0 {
        return None;
    }
    Some(if high == r {
        (g - b) / range
    } else if high == g {
        2.0 + (b - r) / range
    } else {
        4.0 + (r - g) / range
    })
}

/// Adds gray until no channel is negative, and scales the color back to its brightness: luminance
/// plus what the complementary color lacks to gray.
fn without_negatives(color: [f32; 3]) -> [f32; 3] {
    let low = smallest(color);
    if low >= 0.0 {
        return color;
    }
    let brightness = |c: [f32; 3]| {
        let complement = c.map(|v| largest(c) - v);
        largest(complement) - dot(LUMINANCE, complement) + dot(LUMINANCE, c)
    };
    let raised = color.map(|v| v - low);
    let (wanted, found) = (brightness(color).max(0.0), brightness(raised));
    let scale = if found > wanted { wanted / found } else { 1.0 };
    raised.map(|v| v * scale)
}

#[cfg(test)]
mod tests {
    use super::super::view::{DisplayTransform, View};

    #[test]
    fn colors_are_those_of_blender() {
        // sRGB values of the view AgX of the display sRGB in Blender 5.0.1, by OpenColorIO 2.5.
        let expected = [
            ([0.001, 0.001, 0.001], ([0.0033, 0.0033, 0.0033], 0.001)),
            ([0.18, 0.18, 0.18], ([0.4613, 0.4613, 0.4613], 0.001)),
            ([2.0, 2.0, 2.0], ([0.8518, 0.8518, 0.8518], 0.001)),
            ([1.0, 0.2, 0.05], ([0.8234, 0.4913, 0.3294], 0.002)),
            ([0.05, 0.4, 0.1], ([0.3208, 0.6154, 0.3588], 0.002)),
            ([4.0, 3.0, 1.0], ([0.92, 0.8818, 0.8031], 0.002)),
            ([10.0, 0.0, 0.0], ([1.0, 0.7435, 0.7083], 0.002)),
            ([0.3, 0.5, 0.9], ([0.5942, 0.6738, 0.7644], 0.002)),
            ([0.6, 0.05, 0.4], ([0.7235, 0.3622, 0.628], 0.004)),
            ([100.0, 100.0, 100.0], ([1.0, 1.0, 1.0], 1e-06)),
            ([0.02, 0.02, 0.3], ([0.0605, 0.2185, 0.5808], 0.03)),
        ];
        let agx = DisplayTransform {
            exposure_ev: 0.0,
            view: View::Agx,
        };
        for (color, (srgb, tolerance)) in expected {
            let found = agx.srgb(color);
            for c in 0..3 {
                let error = (found[c] - srgb[c]).abs();
                assert!(error < tolerance, "{color:?}: {found:?}, expected {srgb:?}");
            }
        }
    }

    #[test]
    fn any_value_has_a_color() {
        let agx = DisplayTransform {
            exposure_ev: 2.0,
            view: View::Agx,
        };
        for v in [
            0.0,
            -1.0,
            f32::MIN_POSITIVE,
            f32::MAX,
            f32::INFINITY,
            f32::NAN,
        ] {
            for color in [[v; 3], [v, 0.5, 0.1], [0.0, v, 0.0]] {
                let srgb = agx.srgb(color);
                assert!(
                    srgb.iter().all(|s| (0.0..=1.0).contains(s)),
                    "{color:?}: {srgb:?}"
                );
            }
        }
    }
}
