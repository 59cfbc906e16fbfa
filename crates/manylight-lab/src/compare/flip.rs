//! HDR-FLIP: per-pixel difference in [0, 1] that an observer perceives when alternating between two
//! images.
//!
//! Source: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, "FLIP: A Difference
//! Evaluator for Alternating Images", HPG 2020; for linear values of high dynamic range: Andersson,
//! Nilsson, Shirley, Akenine-Möller, "Visualizing Errors in Rendered High Dynamic Range Images",
//! Eurographics 2021 short papers. All constants are from these papers.

use super::image::ComparisonImage;
use super::planes::{ColorPlanes, convolve, displayable, normalized};
use std::f32::consts::PI;

/// Pixels per degree of the visual field: an observer at 0.7 m from a screen of 0.7 m and 3840
/// pixels width.
const PIXELS_PER_DEGREE: f32 = 3840.0 * PI / 180.0;

/// Exponent q_c of color differences.
const COLOR_EXPONENT: f32 = 0.7;
/// Fraction p_c of the largest color difference at which the mapping to [0, 1] changes its slope.
const COLOR_KNEE: f32 = 0.4;
/// Value p_t of the mapping at this difference.
const COLOR_KNEE_VALUE: f32 = 0.95;
/// Exponent q_f of feature differences.
const FEATURE_EXPONENT: f32 = 0.5;
/// Width w of detected features in degrees.
const FEATURE_WIDTH: f32 = 0.082;

/// Contrast sensitivity of each opponent color channel: pairs (a, b) of the sum of Gaussians `a
/// √(π/b) exp(-π² x² / b)`, x in degrees.
const CONTRAST_SENSITIVITY: [&[(f32, f32)]; 3] = [
    &[(1.0, 0.0047)],
    &[(1.0, 0.0053)],
    &[(34.1, 0.04), (13.5, 0.025)],
];
/// The largest `b` in [`CONTRAST_SENSITIVITY`]; it determines the size of the filter kernels.
const LARGEST_B: f32 = 0.04;

/// Coefficients of the tone curve `(k0 x² + k1 x + k2) / (k3 x² + k4 x + k5)`: the ACES fit by
/// Narkowicz with the exposure of the source.
const TONE_CURVE: [f32; 6] = [0.36 * 2.51, 0.6 * 0.03, 0.0, 0.36 * 2.43, 0.6 * 0.59, 0.14];
/// Tone-mapped luminance that the largest luminance has at the first exposure, and the median at
/// the last.
const TONE_TARGET: f32 = 0.85;
/// Lower bound of the median and of the largest luminance.
const MIN_LUMINANCE: f32 = f32::EPSILON;

/// HDR-FLIP of each pixel, row by row: the maximum of FLIP over exposures that are chosen from the
/// reference. Values that are not finite count as black. Both images have the same size.
pub fn flip_map(image: &ComparisonImage, reference: &ComparisonImage) -> Vec<f32> {
    let mut most = vec![0.0f32; reference.rgb.len()];
    for exposure in exposures(reference) {
        let screen = |image: &ComparisonImage| {
            let toned =
                |v: [f32; 3]| v.map(|v| tone(displayable(v) * exposure.exp2()).clamp(0.0, 1.0));
            let pixels = image.rgb.iter().map(|&v| opponent(toned(v)));
            ColorPlanes::new(image.width, pixels)
        };
        let map = ldr_flip(&screen(image), &screen(reference));
        for (most, seen) in most.iter_mut().zip(map) {
            *most = most.max(seen);
        }
    }
    most
}

/// Exposures in stops, in even steps.
fn exposures(reference: &ComparisonImage) -> Vec<f32> {
    let mut luminances: Vec<f32> = (reference.rgb.iter())
        .map(|&v| xyz(v.map(displayable))[1])
        .collect();
    if luminances.is_empty() {
        return Vec::new();
    }
    let half = luminances.len() / 2;
    let (_, median, above) = luminances.select_nth_unstable_by(half, f32::total_cmp);
    let brightest = above
        .iter()
        .copied()
        .fold(*median, f32::max)
        .max(MIN_LUMINANCE);
    let [k0, k1, k2, k3, k4, k5] = TONE_CURVE;
    let (a, b, c) = (
        k0 - TONE_TARGET * k3,
        k1 - TONE_TARGET * k4,
        k2 - TONE_TARGET * k5,
    );
    let middle = -b / (2.0 * a);
    let at_target = middle + (middle * middle - c / a).sqrt();
    let first = (at_target / brightest).log2();
    let last = (at_target / median.max(MIN_LUMINANCE)).log2();
    let count = (last - first).ceil().max(2.0);
    let step = (last - first) / (count - 1.0);
    (0..count as u32).map(|k| first + k as f32 * step).collect()
}

/// The tone curve.
fn tone(x: f32) -> f32 {
    let [k0, k1, k2, k3, k4, k5] = TONE_CURVE;
    ((k0 * x + k1) * x + k2) / ((k3 * x + k4) * x + k5)
}

/// FLIP of images of low dynamic range, given in opponent colors.
fn ldr_flip(image: &ColorPlanes, reference: &ColorPlanes) -> Vec<f32> {
    let color = color_differences(image, reference);
    let feature = feature_differences(image, reference);
    let both = color.iter().zip(feature);
    both.map(|(color, feature)| color.powf(1.0 - feature))
        .collect()
}

/// Color difference of each pixel in [0, 1].
fn color_differences(image: &ColorPlanes, reference: &ColorPlanes) -> Vec<f32> {
    let seen = |planes: &ColorPlanes| -> Vec<[f32; 3]> {
        let filtered = filter_by_contrast_sensitivity(planes);
        let clipped = filtered
            .pixels()
            .map(|v| rgb_of_opponent(v).map(|v| v.clamp(0.0, 1.0)));
        clipped.map(|v| hunt(lab(v))).collect()
    };
    let far = |a: [f32; 3], b: [f32; 3]| distance(a, b).powf(COLOR_EXPONENT);
    let largest = far(hunt(lab([0.0, 1.0, 0.0])), hunt(lab([0.0, 0.0, 1.0])));
    let knee = COLOR_KNEE * largest;
    let share = |d: f32| match d < knee {
        true => d * COLOR_KNEE_VALUE / knee,
        false => COLOR_KNEE_VALUE + (d - knee) / (largest - knee) * (1.0 - COLOR_KNEE_VALUE),
    };
    let (image, reference) = (seen(image), seen(reference));
    let pairs = image.into_iter().zip(reference);
    pairs.map(|(x, r)| share(far(x, r))).collect()
}

/// Filters each channel by the contrast sensitivity function: details too fine for the observer
/// vanish.
fn filter_by_contrast_sensitivity(planes: &ColorPlanes) -> ColorPlanes {
    let radius = (3.0 * (LARGEST_B / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as i32;
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
        let total: f32 = CONTRAST_SENSITIVITY[c].iter().map(weight).sum();
        let mut seen = vec![0.0; planes.channel(c).len()];
        for term in CONTRAST_SENSITIVITY[c] {
            let kernel = normalized(gaussian(term.1));
            let filtered = convolve(planes.channel(c), planes.width, &kernel, &kernel);
            for (seen, v) in seen.iter_mut().zip(filtered) {
                *seen += weight(term) / total * v;
            }
        }
        seen
    };
    ColorPlanes {
        width: planes.width,
        channels: std::array::from_fn(channel),
    }
}

/// Feature difference of each pixel in [0, 1]: edges and points that only one of the images has.
fn feature_differences(image: &ColorPlanes, reference: &ColorPlanes) -> Vec<f32> {
    let (x, r) = (features(image), features(reference));
    let pairs = x.into_iter().zip(r);
    let difference = |(x, r): ([f32; 2], [f32; 2])| {
        let most = (x[0] - r[0]).abs().max((x[1] - r[1]).abs());
        (most / 2f32.sqrt()).powf(FEATURE_EXPONENT).clamp(0.0, 1.0)
    };
    pairs.map(difference).collect()
}

/// Strength of edges and points: norms of first and second derivatives of the achromatic channel
/// under a Gaussian.
fn features(planes: &ColorPlanes) -> Vec<[f32; 2]> {
    let sigma = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    let radius = (3.0 * sigma).ceil() as i32;
    let kernel = |of: &dyn Fn(f32) -> f32| -> Vec<f32> {
        let gaussian = |x: f32| (-x * x / (2.0 * sigma * sigma)).exp();
        let x = (-radius..=radius).map(|i| i as f32);
        x.map(|x| of(x) * gaussian(x)).collect()
    };
    let smooth = kernel(&|_| 1.0);
    let whole: f32 = smooth.iter().sum();
    // In two dimensions, the positive weights of a kernel sum to 1 and the negative ones to -1.
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

/// `kernel` with positive and negative weights scaled separately to sums of 1 and -1; `across` is
/// the sum of the kernel in the other dimension.
fn balanced(mut kernel: Vec<f32>, across: f32) -> Vec<f32> {
    let sum = |sign: f32| kernel.iter().map(|k| (sign * k).max(0.0)).sum::<f32>() * across;
    let (positive, negative) = (sum(1.0), sum(-1.0));
    for k in &mut kernel {
        *k /= if *k > 0.0 { positive } else { negative };
    }
    kernel
}

/// Matrix from linear Rec. 709 RGB to XYZ.
const XYZ: [[f32; 3]; 3] = [
    [0.412_386_56, 0.357_591_5, 0.180_450_49],
    [0.212_636_82, 0.715_182_98, 0.072_180_2],
    [0.019_330_62, 0.119_197_16, 0.950_372_6],
];

fn xyz(rgb: [f32; 3]) -> [f32; 3] {
    XYZ.map(|row| row[0] * rgb[0] + row[1] * rgb[1] + row[2] * rgb[2])
}

/// Inverse of [`xyz`].
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

/// XYZ of the reference white.
fn white() -> [f32; 3] {
    xyz([1.0; 3])
}

/// YCxCz of linear RGB: a luminance and two color differences that are linear in radiance.
fn opponent(rgb: [f32; 3]) -> [f32; 3] {
    let (v, w) = (xyz(rgb), white());
    let [x, y, z] = std::array::from_fn(|c| v[c] / w[c]);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Inverse of [`opponent`].
fn rgb_of_opponent([y, cx, cz]: [f32; 3]) -> [f32; 3] {
    let y = (y + 16.0) / 116.0;
    let (x, z) = (y + cx / 500.0, y - cz / 200.0);
    let w = white();
    rgb_of_xyz([x * w[0], y * w[1], z * w[2]])
}

/// CIE L*a*b* of linear RGB.
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

/// Hunt effect: colorfulness decreases with lightness.
fn hunt([l, a, b]: [f32; 3]) -> [f32; 3] {
    [l, 0.01 * l * a, 0.01 * l * b]
}

/// HyAB distance in L*a*b*.
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

    /// Values of the authors' package `flip-evaluator` 1.7.
    #[test]
    fn values_of_the_program_of_the_authors() {
        let (image, reference) = (frame(ramp_and_spots), frame(ramp));
        let exposures = exposures(&reference);
        assert_eq!(exposures.len(), 6);
        assert!((exposures[0] + 2.807_857_5).abs() < 1e-4, "{exposures:?}");
        assert!((exposures[5] - 2.196_820_5).abs() < 1e-4, "{exposures:?}");
        let map = flip_map(&image, &reference);
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
        assert_eq!(mean(&flip_map(&frame(ramp), &frame(ramp))), 0.0);
        let black = frame(|_, _| [0.0; 3]);
        assert_eq!(mean(&flip_map(&black, &black)), 0.0);
        let broken = frame(|x, _| [if x == 7 { f32::NAN } else { 0.5 }; 3]);
        assert!(
            flip_map(&broken, &frame(ramp))
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
