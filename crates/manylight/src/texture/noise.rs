//! Gradient noise, and sums of its octaves.
//!
//! Source of the noise: Perlin, "Improving Noise", SIGGRAPH 2002. The sums are those of pbrt-v4
//! with all octaves, which it fades out where they are smaller than a pixel.

use crate::math::Vec3;
use crate::simd::array;

/// Factor of the frequency from one octave to the next: not 2, so that the lattices of octaves do
/// not coincide.
const LACUNARITY: f32 = 1.99;

/// A permutation of 0 to 255: the one of Perlin's reference implementation.
const PERMUTATION: [u8; 256] = [
    151, 160, 137, 91, 90, 15, 131, 13, 201, 95, 96, 53, 194, 233, 7, 225, 140, 36, 103, 30, 69,
    142, 8, 99, 37, 240, 21, 10, 23, 190, 6, 148, 247, 120, 234, 75, 0, 26, 197, 62, 94, 252, 219,
    203, 117, 35, 11, 32, 57, 177, 33, 88, 237, 149, 56, 87, 174, 20, 125, 136, 171, 168, 68, 175,
    74, 165, 71, 134, 139, 48, 27, 166, 77, 146, 158, 231, 83, 111, 229, 122, 60, 211, 133, 230,
    220, 105, 92, 41, 55, 46, 245, 40, 244, 102, 143, 54, 65, 25, 63, 161, 1, 216, 80, 73, 209, 76,
    132, 187, 208, 89, 18, 169, 200, 196, 135, 130, 116, 188, 159, 86, 164, 100, 109, 198, 173,
    186, 3, 64, 52, 217, 226, 250, 124, 123, 5, 202, 38, 147, 118, 126, 255, 82, 85, 212, 207, 206,
    59, 227, 47, 16, 58, 17, 182, 189, 28, 42, 223, 183, 170, 213, 119, 248, 152, 2, 44, 154, 163,
    70, 221, 153, 101, 155, 167, 43, 172, 9, 129, 22, 39, 253, 19, 98, 108, 110, 79, 113, 224, 232,
    178, 185, 112, 104, 218, 246, 97, 228, 251, 34, 242, 193, 238, 210, 144, 12, 191, 179, 162,
    241, 81, 51, 145, 235, 249, 14, 239, 107, 49, 192, 214, 31, 181, 199, 106, 157, 184, 84, 204,
    176, 115, 121, 50, 45, 127, 4, 150, 254, 138, 236, 205, 93, 222, 114, 67, 29, 24, 72, 243, 141,
    128, 195, 78, 66, 215, 61, 156, 180,
];

/// Noise of period 256 in [-1, 1]; 0 at points with integer coordinates.
pub(super) fn noise(p: Vec3) -> f32 {
    let cell = p.floor();
    let d = p - cell;
    let lattice = cell.to_array().map(|c| c.rem_euclid(256.0) as usize);
    let corner = |i: usize| {
        let offset = [i & 1, i >> 1 & 1, i >> 2];
        let at = array(|axis| lattice[axis] + offset[axis]);
        let from = d - Vec3::from_array(array(|axis| offset[axis] as f32));
        gradient_product(hash(at), from)
    };
    let w = d.to_array().map(fade);
    let lerp = |t: f32, a: f32, b: f32| a + t * (b - a);
    let along_x = |i: usize| lerp(w[0], corner(i), corner(i + 1));
    let along_y = |i: usize| lerp(w[1], along_x(i), along_x(i + 2));
    lerp(w[2], along_y(0), along_y(4))
}

/// The sum of `octaves` octaves of noise, each with `roughness` times the amplitude of the one
/// before.
pub(super) fn fractal(p: Vec3, roughness: f32, octaves: u32) -> f32 {
    sum_octaves(p, roughness, octaves, |v| v)
}

/// The same of absolute values of noise.
pub(super) fn turbulence(p: Vec3, roughness: f32, octaves: u32) -> f32 {
    sum_octaves(p, roughness, octaves, f32::abs)
}

/// Upper bound of the absolute value of a sum of octaves.
pub(super) fn amplitude(roughness: f32, octaves: u32) -> f32 {
    (0..octaves).map(|i| roughness.abs().powi(i as i32)).sum()
}

fn sum_octaves(p: Vec3, roughness: f32, octaves: u32, value: impl Fn(f32) -> f32) -> f32 {
    let (mut sum, mut frequency, mut amplitude) = (0.0, 1.0, 1.0);
    for _ in 0..octaves {
        sum += amplitude * value(noise(p * frequency));
        frequency *= LACUNARITY;
        amplitude *= roughness;
    }
    sum
}

/// A number of a lattice point.
fn hash(at: [usize; 3]) -> u8 {
    at.into_iter().fold(0, |hash, coordinate| {
        PERMUTATION[(usize::from(hash) + coordinate) & 255]
    })
}

/// The product of `d` and one of the 12 directions from the center of a cube to its edges, four of
/// them twice.
fn gradient_product(hash: u8, d: Vec3) -> f32 {
    let h = hash & 15;
    let u = if h < 8 || h == 12 || h == 13 {
        d.x
    } else {
        d.y
    };
    let v = if h < 4 || h == 12 || h == 13 {
        d.y
    } else {
        d.z
    };
    let signed = |v: f32, is_negative: bool| if is_negative { -v } else { v };
    signed(u, h & 1 != 0) + signed(v, h & 2 != 0)
}

/// Weight of the upper end: 6t⁵ - 15t⁴ + 10t³.
fn fade(t: f32) -> f32 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_zero_on_the_lattice_bounded_and_continuous() {
        let mut extremes = [0.0f32; 2];
        for i in 0..20_000 {
            let p = Vec3::new(0.137, 0.311, 0.0731) * i as f32 - 700.0;
            let v = noise(p);
            assert!(v.abs() <= 1.0, "{v}");
            let step = (noise(p + Vec3::splat(1e-3)) - v).abs();
            assert!(step < 0.02, "{step} at {p}");
            extremes = [extremes[0].min(v), extremes[1].max(v)];
        }
        assert!(extremes[0] < -0.6 && extremes[1] > 0.6, "{extremes:?}");
        for p in [Vec3::ZERO, Vec3::new(3.0, -7.0, 255.0), Vec3::splat(256.0)] {
            assert_eq!(noise(p), 0.0);
        }
        let p = Vec3::new(0.3, 1.7, -2.4);
        assert!((noise(p) - noise(p + 256.0)).abs() < 1e-4);
    }

    /// Values of the formulas by hand: at the center of a cell all weights are 1/2 and the offsets
    /// are ±1/2.
    #[test]
    fn the_center_of_a_cell_averages_its_corners() {
        let mean: f32 = (0..8)
            .map(|i| {
                let offset = [i & 1, i >> 1 & 1, i >> 2];
                let from = 0.5 - Vec3::from_array(offset.map(|o| o as f32));
                gradient_product(hash(offset), from) / 8.0
            })
            .sum();
        assert!((noise(Vec3::splat(0.5)) - mean).abs() < 1e-6);
        assert_eq!(hash([0, 0, 0]), PERMUTATION[usize::from(PERMUTATION[151])]);
    }

    #[test]
    fn octaves_add_up() {
        let p = Vec3::new(0.37, 5.2, -1.1);
        let expected = noise(p) + 0.4 * noise(p * 1.99);
        assert!((fractal(p, 0.4, 2) - expected).abs() < 1e-6);
        let expected = noise(p).abs() + 0.4 * noise(p * 1.99).abs();
        assert!((turbulence(p, 0.4, 2) - expected).abs() < 1e-6);
        assert!((amplitude(0.5, 3) - 1.75).abs() < 1e-6);
    }
}
