//! HDR-FLIP: how much somebody sees who alternates between two pictures, pixel by pixel in [0, 1].
//!
//! Source: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, "FLIP: A Difference Evaluator for Alternating Images", HPG
//! 2020; for linear values that no screen shows at once: Andersson, Nilsson, Shirley, Akenine-Möller, "Visualizing Errors in Rendered
//! High Dynamic Range Images", Eurographics 2021 short papers. Constants are theirs.

use super::Frame;
use super::planes::{Planes, convolve, normalized, shown};
use std::f32::consts::PI;

/// 0.7 m before a screen that is 0.7 m and 3840 pixels wide.
const PIXELS_PER_DEGREE: f32 = 3840.0 * PI / 180.0;

/// Exponent of color differences.
const Q_COLOR: f32 = 0.7;
/// Color differences of the first share of the largest take the second share of the range.
const P_COLOR: f32 = 0.4;
const P_TARGET: f32 = 0.95;
/// Exponent of feature differences, and the width of features in degrees.
const Q_FEATURE: f32 = 0.5;
const FEATURE_WIDTH: f32 = 0.082;

/// How well people see contrast, by channel of opponent colors: sums of Gaussians `a √(π/b) exp(-π² x² / b)`, x in degrees.
const SENSITIVITY: [&[(f32, f32)]; 3] = [
    &[(1.0, 0.0047)],
    &[(1.0, 0.0053)],
    &[(34.1, 0.04), (13.5, 0.025)],
];
/// The largest `b` of them.
const WIDEST: f32 = 0.04;

/// Luminances of the tone curve `(k0 x² + k1 x + k2) / (k3 x² + k4 x + k5)`: ACES as fitted by Narkowicz, exposed as in the source.
const TONE: [f32; 6] = [0.36 * 2.51, 0.6 * 0.03, 0.0, 0.36 * 2.43, 0.6 * 0.59, 0.14];
/// Exposures go from where the brightest pixel becomes this bright to where the median does.
const BRIGHT: f32 = 0.85;
/// No median counts as darker.
const DARKEST: f32 = f32::EPSILON;

/// The map of a picture against its reference, which decides about exposures; what is not finite counts as black.
pub(crate) fn flip(image: &Frame, reference: &Frame) -> Vec<f32> {
    let mut most = vec![0.0f32; reference.rgb.len()];
    for exposure in exposures(reference) {
        let screen = |frame: &Frame| {
            let toned = |v: [f32; 3]| v.map(|v| tone(shown(v) * exposure.exp2()).clamp(0.0, 1.0));
            let pixels = frame.rgb.iter().map(|&v| opponent(toned(v)));
            Planes::new(frame.width, pixels)
        };
        let map = of_shown(&screen(image), &screen(reference));
        for (most, seen) in most.iter_mut().zip(map) {
            *most = most.max(seen);
        }
    }
    most
}

/// In stops.
fn exposures(reference: &Frame) -> Vec<f32> {
    let mut luminances: Vec<f32> = (reference.rgb.iter())
        .map(|&v| xyz(v.map(shown))[1])
        .collect();
    if luminances.is_empty() {
        return Vec::new();
    }
    let half = luminances.len() / 2;
    let (_, median, above) = luminances.select_nth_unstable_by(half, f32::total_cmp);
    let brightest = above.iter().copied().fold(*median, f32::max).max(DARKEST);
    let [k0, k1, k2, k3, k4, k5] = TONE;
    let (a, b, c) = (k0 - BRIGHT * k3, k1 - BRIGHT * k4, k2 - BRIGHT * k5);
    let middle = -b / (2.0 * a);
    let shown_bright = middle + (middle * middle - c / a).sqrt();
    let first = (shown_bright / brightest).log2();
    let last = (shown_bright / median.max(DARKEST)).log2();
    let count = (last - first).ceil().max(2.0);
    let step = (last - first) / (count - 1.0);
    (0..count as u32).map(|k| first + k as f32 * step).collect()
}

fn tone(x: f32) -> f32 {
    let [k0, k1, k2, k3, k4, k5] = TONE;
    ((k0 * x + k1) * x + k2) / ((k3 * x + k4) * x + k5)
}

/// FLIP of pictures that a screen can show, in opponent colors.
fn of_shown(image: &Planes, reference: &Planes) -> Vec<f32> {
    let color = color_differences(image, reference);
    let feature = feature_differences(image, reference);
    let both = color.iter().zip(feature);
    both.map(|(color, feature)| color.powf(1.0 - feature))
        .collect()
}

fn color_differences(image: &Planes, reference: &Planes) -> Vec<f32> {
    let seen = |planes: &Planes| -> Vec<[f32; 3]> {
        let filtered = as_seen(planes);
        let clipped = filtered
            .pixels()
            .map(|v| rgb_of_opponent(v).map(|v| v.clamp(0.0, 1.0)));
        clipped.map(|v| hunt(lab(v))).collect()
    };
    let far = |a: [f32; 3], b: [f32; 3]| distance(a, b).powf(Q_COLOR);
    let largest = far(hunt(lab([0.0, 1.0, 0.0])), hunt(lab([0.0, 0.0, 1.0])));
    let knee = P_COLOR * largest;
    let share = |d: f32| match d < knee {
        true => d * P_TARGET / knee,
        false => P_TARGET + (d - knee) / (largest - knee) * (1.0 - P_TARGET),
    };
    let (image, reference) = (seen(image), seen(reference));
    let pairs = image.into_iter().zip(reference);
    pairs.map(|(x, r)| share(far(x, r))).collect()
}

/// What is left of a picture seen from afar.
fn as_seen(planes: &Planes) -> Planes {
    let radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as i32;
    let gaussian = |b: f32| -> Vec<f32> {
        let x = |i: i32| i as f32 / PIXELS_PER_DEGREE;
        (-radius..=radius)
            .map(|i| (-(PI * x(i)).powi(2) / b).exp())
            .collect()
    };
    let channel = |c: usize| {
        let weight = |&(a, b): &(f32, f32)| {
            let whole: f32 = gaussian(b).iter().sum();
            a * (PI / b).sqrt() * whole * whole
        };
        let total: f32 = SENSITIVITY[c].iter().map(weight).sum();
        let mut seen = vec![0.0; planes.channel(c).len()];
        for term in SENSITIVITY[c] {
            let kernel = normalized(gaussian(term.1));
            let filtered = convolve(planes.channel(c), planes.width, &kernel, &kernel);
            for (seen, v) in seen.iter_mut().zip(filtered) {
                *seen += weight(term) / total * v;
            }
        }
        seen
    };
    Planes {
        width: planes.width,
        channels: std::array::from_fn(channel),
    }
}

/// Where edges and points are in one and not in the other.
fn feature_differences(image: &Planes, reference: &Planes) -> Vec<f32> {
    let (x, r) = (features(image), features(reference));
    let pairs = x.into_iter().zip(r);
    let difference = |(x, r): ([f32; 2], [f32; 2])| {
        let most = (x[0] - r[0]).abs().max((x[1] - r[1]).abs());
        (most / 2f32.sqrt()).powf(Q_FEATURE).clamp(0.0, 1.0)
    };
    pairs.map(difference).collect()
}

/// Edges and points, by first and second derivatives of the achromatic channel under a Gaussian.
fn features(planes: &Planes) -> Vec<[f32; 2]> {
    let sigma = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    let radius = (3.0 * sigma).ceil() as i32;
    let kernel = |of: &dyn Fn(f32) -> f32| -> Vec<f32> {
        let gaussian = |x: f32| (-x * x / (2.0 * sigma * sigma)).exp();
        let x = (-radius..=radius).map(|i| i as f32);
        x.map(|x| of(x) * gaussian(x)).collect()
    };
    let smooth = kernel(&|_| 1.0);
    let whole: f32 = smooth.iter().sum();
    // All positive weights of a kernel in the plane add up to 1, all negative ones to -1.
    let first = balanced(kernel(&|x| -x), whole);
    let second = balanced(kernel(&|x| x * x / (sigma * sigma) - 1.0), whole);
    let achromatic: Vec<f32> = (planes.channel(0).iter())
        .map(|y| (y + 16.0) / 116.0)
        .collect();
    let norm = |derivative: &[f32]| -> Vec<f32> {
        let along_x = convolve(&achromatic, planes.width, derivative, &smooth);
        let along_y = convolve(&achromatic, planes.width, &smooth, derivative);
        let both = along_x.iter().zip(along_y);
        both.map(|(x, y)| x.hypot(y)).collect()
    };
    let (edges, points) = (norm(&first), norm(&second));
    edges.into_iter().zip(points).map(|(e, p)| [e, p]).collect()
}

fn balanced(mut kernel: Vec<f32>, across: f32) -> Vec<f32> {
    let sum = |sign: f32| kernel.iter().map(|k| (sign * k).max(0.0)).sum::<f32>() * across;
    let (positive, negative) = (sum(1.0), sum(-1.0));
    for k in &mut kernel {
        *k /= if *k > 0.0 { positive } else { negative };
    }
    kernel
}

/// From linear Rec. 709 values.
const XYZ: [[f32; 3]; 3] = [
    [0.412_386_56, 0.357_591_5, 0.180_450_49],
    [0.212_636_82, 0.715_182_98, 0.072_180_2],
    [0.019_330_62, 0.119_197_16, 0.950_372_6],
];

fn xyz(rgb: [f32; 3]) -> [f32; 3] {
    XYZ.map(|row| row[0] * rgb[0] + row[1] * rgb[1] + row[2] * rgb[2])
}

/// Its inverse.
fn rgb_of_xyz([x, y, z]: [f32; 3]) -> [f32; 3] {
    let [r, g, b] = XYZ;
    let cross = |a: [f32; 3], b: [f32; 3]| {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    };
    let (gb, br, rg) = (cross(g, b), cross(b, r), cross(r, g));
    let determinant = r[0] * gb[0] + r[1] * gb[1] + r[2] * gb[2];
    std::array::from_fn(|c| (gb[c] * x + br[c] * y + rg[c] * z) / determinant)
}

/// XYZ of white, by which others are divided.
fn white() -> [f32; 3] {
    xyz([1.0; 3])
}

/// YCxCz: a luminance and two color differences that are linear in light.
fn opponent(rgb: [f32; 3]) -> [f32; 3] {
    let (v, w) = (xyz(rgb), white());
    let [x, y, z] = std::array::from_fn(|c| v[c] / w[c]);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn rgb_of_opponent([y, cx, cz]: [f32; 3]) -> [f32; 3] {
    let y = (y + 16.0) / 116.0;
    let (x, z) = (y + cx / 500.0, y - cz / 200.0);
    let w = white();
    rgb_of_xyz([x * w[0], y * w[1], z * w[2]])
}

/// CIE L*a*b*.
fn lab(rgb: [f32; 3]) -> [f32; 3] {
    const DELTA: f32 = 6.0 / 29.0;
    let f = |t: f32| match t > DELTA.powi(3) {
        true => t.cbrt(),
        false => t / (3.0 * DELTA * DELTA) + 4.0 / 29.0,
    };
    let (v, w) = (xyz(rgb), white());
    let [x, y, z] = std::array::from_fn(|c| f(v[c] / w[c]));
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Dark colors look less colorful.
fn hunt([l, a, b]: [f32; 3]) -> [f32; 3] {
    [l, 0.01 * l * a, 0.01 * l * b]
}

/// HyAB.
fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

#[cfg(test)]
mod tests {
    use super::super::testing::{frame, ramp, ramp_and_spots};
    use super::*;

    fn mean(map: &[f32]) -> f64 {
        map.iter().map(|&v| f64::from(v)).sum::<f64>() / map.len() as f64
    }

    /// Figures of the package `flip-evaluator` 1.7, by the authors.
    #[test]
    fn what_the_authors_program_says() {
        let (image, reference) = (frame(ramp_and_spots), frame(ramp));
        let exposures = exposures(&reference);
        assert_eq!(exposures.len(), 6);
        assert!((exposures[0] + 2.807_857_5).abs() < 1e-4, "{exposures:?}");
        assert!((exposures[5] - 2.196_820_5).abs() < 1e-4, "{exposures:?}");
        let map = flip(&image, &reference);
        assert!((mean(&map) - 0.156_966_91).abs() < 1e-4, "{}", mean(&map));
        let of_pixels = [
            ((0, 0), 0.282_701_55),
            ((23, 12), 0.166_202_25),
            ((40, 30), 0.274_399_82),
            ((11, 0), 0.178_903_82),
            ((5, 5), 0.045_573_976),
        ];
        for ((x, y), seen) in of_pixels {
            let own = map[y * reference.width + x];
            assert!((own - seen).abs() < 1e-3, "{own} at {x}, {y}: {seen}");
        }
    }

    #[test]
    fn equal_pictures_have_none() {
        assert_eq!(mean(&flip(&frame(ramp), &frame(ramp))), 0.0);
        let black = frame(|_, _| [0.0; 3]);
        assert_eq!(mean(&flip(&black, &black)), 0.0);
        let broken = frame(|x, _| [if x == 7 { f32::NAN } else { 0.5 }; 3]);
        assert!(
            flip(&broken, &frame(ramp))
                .iter()
                .all(|v| (0.0..=1.0).contains(v))
        );
    }

    #[test]
    fn colors_go_there_and_back() {
        for rgb in [[0.2, 0.5, 0.9], [1.0, 0.0, 0.3]] {
            let back = rgb_of_opponent(opponent(rgb));
            assert!((0..3).all(|c| (back[c] - rgb[c]).abs() < 1e-5), "{back:?}");
        }
    }
}
