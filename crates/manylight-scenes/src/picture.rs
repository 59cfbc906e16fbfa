//! Pictures for textures, and their PNG files.

use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::io::{self, Write};

/// What the numbers of a picture mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// Three channels of color, sRGB-encoded.
    Color,
    /// One channel of plain numbers, 255 is one.
    Weight,
}

/// A picture with 8 bits for each channel, rows from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels across and down.
    pub size: [u32; 2],
    /// What its numbers mean.
    pub meaning: Meaning,
    /// Samples, row by row.
    pub samples: Vec<u8>,
}

impl Picture {
    /// A picture of weights; `weight` is asked for the middle of each pixel, u to the right and v down, both from 0 to 1.
    pub fn of_weights(size: [u32; 2], weight: impl Fn(f64, f64) -> f64) -> Picture {
        let samples = middles(size).map(|(u, v)| byte(weight(u, v))).collect();
        Picture {
            size,
            meaning: Meaning::Weight,
            samples,
        }
    }

    /// A picture of linear colors, stored sRGB-encoded; `color` is asked as for weights.
    pub fn of_colors(size: [u32; 2], color: impl Fn(f64, f64) -> [f64; 3]) -> Picture {
        let samples = middles(size)
            .flat_map(|(u, v)| color(u, v).map(|c| byte(srgb(c))))
            .collect();
        Picture {
            size,
            meaning: Meaning::Color,
            samples,
        }
    }

    /// The bytes of a PNG file.
    pub fn encode(&self) -> io::Result<Vec<u8>> {
        let (color_type, channels) = match self.meaning {
            Meaning::Color => (2, 3),
            Meaning::Weight => (0, 1),
        };
        let mut head = Vec::new();
        head.extend(self.size[0].to_be_bytes());
        head.extend(self.size[1].to_be_bytes());
        head.extend([8, color_type, 0, 0, 0]);

        let row = self.size[0] as usize * channels;
        let mut deflated = ZlibEncoder::new(Vec::new(), Compression::best());
        for line in self.samples.chunks(row) {
            let left = |i: usize| if i < channels { 0 } else { line[i - channels] };
            let differences: Vec<u8> = (0..row).map(|i| line[i].wrapping_sub(left(i))).collect();
            deflated.write_all(&[LEFT_FILTER])?;
            deflated.write_all(&differences)?;
        }

        let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
        push_chunk(&mut file, b"IHDR", &head);
        push_chunk(&mut file, b"IDAT", &deflated.finish()?);
        push_chunk(&mut file, b"IEND", &[]);
        Ok(file)
    }
}

/// Each sample is stored as its difference from the one to its left.
const LEFT_FILTER: u8 = 1;

fn push_chunk(file: &mut Vec<u8>, kind: &[u8; 4], data: &[u8]) {
    let mut crc = flate2::Crc::new();
    crc.update(kind);
    crc.update(data);
    file.extend((data.len() as u32).to_be_bytes());
    file.extend(kind);
    file.extend(data);
    file.extend(crc.sum().to_be_bytes());
}

fn middles([width, height]: [u32; 2]) -> impl Iterator<Item = (f64, f64)> {
    (0..height).flat_map(move |y| {
        (0..width).map(move |x| {
            (
                (f64::from(x) + 0.5) / f64::from(width),
                (f64::from(y) + 0.5) / f64::from(height),
            )
        })
    })
}

fn byte(x: f64) -> u8 {
    // The shift keeps round numbers off the border between two bytes.
    (x.clamp(0.0, 1.0) * 255.0 + 0.500_001).floor().min(255.0) as u8
}

fn srgb(x: f64) -> f64 {
    if x <= 0.003_130_8 {
        12.92 * x
    } else {
        1.055 * x.powf(1.0 / 2.4) - 0.055
    }
}

/// Value noise that repeats after `period` steps in both directions: smooth, from 0 to 1, one value to each lattice point.
pub fn noise(u: f64, v: f64, period: [u32; 2], seed: u32) -> f64 {
    let (x, y) = (u * f64::from(period[0]), v * f64::from(period[1]));
    let (column, row) = (x.floor(), y.floor());
    let ease = |t: f64| t * t * (3.0 - 2.0 * t);
    let (s, t) = (ease(x - column), ease(y - row));
    let at = |dx: f64, dy: f64| {
        let i = (column + dx).rem_euclid(f64::from(period[0])) as u32;
        let j = (row + dy).rem_euclid(f64::from(period[1])) as u32;
        lattice(i, j, seed)
    };
    let lower = at(0.0, 0.0) + (at(1.0, 0.0) - at(0.0, 0.0)) * s;
    let upper = at(0.0, 1.0) + (at(1.0, 1.0) - at(0.0, 1.0)) * s;
    lower + (upper - lower) * t
}

/// Octaves of `noise`, each twice as fine and half as strong as the one before; from 0 to 1.
pub fn fractal_noise(u: f64, v: f64, period: [u32; 2], octaves: u32, seed: u32) -> f64 {
    let mut sum = 0.0;
    let mut total = 0.0;
    for octave in 0..octaves {
        let strength = 0.5_f64.powi(octave as i32);
        let finer = period.map(|p| p << octave);
        sum += strength * noise(u, v, finer, seed + octave);
        total += strength;
    }
    sum / total
}

fn lattice(i: u32, j: u32, seed: u32) -> f64 {
    let mut h =
        i.wrapping_mul(0x9E37_79B1) ^ j.wrapping_mul(0x85EB_CA77) ^ seed.wrapping_mul(0xC2B2_AE3D);
    h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D);
    h = (h ^ (h >> 12)).wrapping_mul(0x297A_2D39);
    f64::from((h ^ (h >> 15)) >> 8) / f64::from(1 << 24)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_repeats() {
        let a = fractal_noise(0.1, 0.999_999, [4, 3], 3, 7);
        let b = fractal_noise(1.1, -0.000_001, [4, 3], 3, 7);
        assert!((a - b).abs() < 1e-9);
        assert!((0.0..1.0).contains(&a));
    }

    #[test]
    fn a_png_starts_as_one_and_names_its_size() {
        let png = Picture::of_colors([3, 2], |u, v| [u, v, 0.0])
            .encode()
            .unwrap();
        assert_eq!(&png[1..4], b"PNG");
        assert_eq!(&png[16..24], [0, 0, 0, 3, 0, 0, 0, 2]);
    }

    #[test]
    fn colors_are_encoded_and_weights_are_not() {
        let color = Picture::of_colors([1, 1], |_, _| [0.2140; 3]);
        assert_eq!(color.samples, [127; 3]);
        let weight = Picture::of_weights([1, 1], |_, _| 0.2);
        assert_eq!(weight.samples, [51]);
    }
}
