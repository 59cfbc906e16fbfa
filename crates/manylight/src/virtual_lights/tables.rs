//! Octahedral tables in four bytes per texel.

use crate::color::Rgb;
use crate::math::Vec3;
use crate::math::octahedral::bilinear;

/// Three numbers that are not negative: mantissas of nine bits with a common exponent of five. A channel is off by at most 1/512 of
/// the largest. Source: the OpenGL extension EXT_texture_shared_exponent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Packed(u32);

/// The largest mantissa plus one.
const MANTISSAS: f32 = 512.0;
/// Exponent of the unit of a mantissa whose exponent is stored as zero.
const UNIT: i32 = -24;
/// Of a float.
const BIAS: i32 = 127;
/// The brightest texel of a table is stored as this, close to the largest number that can be.
const BRIGHTEST: f32 = 32_768.0;

impl Packed {
    /// Zero in every channel.
    pub(crate) const BLACK: Packed = Packed(0);

    /// Rounds to the nearest. Channels must be at most [`BRIGHTEST`].
    fn new(color: Rgb) -> Self {
        let color = color.map(|x| x.max(0.0));
        let exponent_of = |x: f32| (x.to_bits() >> 23) as i32 - BIAS;
        let unit = |stored: i32| f32::from_bits(((stored + UNIT + BIAS) as u32) << 23);
        let mut stored = (exponent_of(color.max_channel()) + 1 - 9 - UNIT).max(0);
        if (color.max_channel() / unit(stored)).round() >= MANTISSAS {
            stored += 1;
        }
        let [r, g, b] = color.to_array().map(|x| (x / unit(stored)).round() as u32);
        Packed(r | g << 9 | b << 18 | (stored as u32) << 27)
    }

    #[inline(always)]
    pub(crate) fn rgb(self) -> Rgb {
        let unit = f32::from_bits(((self.0 >> 27) + (UNIT + BIAS) as u32) << 23);
        let mantissa = |shift: u32| (self.0 >> shift & 511) as i32 as f32;
        Rgb::new(mantissa(0) * unit, mantissa(9) * unit, mantissa(18) * unit)
    }
}

/// A table of `side`² values, row by row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Table<'a> {
    /// In units of `scale`.
    pub(crate) texels: &'a [Packed],
    /// By channel.
    pub(crate) scale: Rgb,
    pub(super) side: usize,
}

impl Table<'_> {
    /// The bilinear value in direction `w`, horizon not counted.
    pub(super) fn lookup(&self, w: Vec3) -> Rgb {
        let sum: Rgb = bilinear(w, self.side)
            .into_iter()
            .map(|(t, weight)| self.texels[t].rgb() * weight)
            .sum();
        sum * self.scale
    }
}

/// Tables of one size, one after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct Tables {
    side: usize,
    texels: Vec<Packed>,
    /// One per table.
    scales: Vec<Rgb>,
}

impl Tables {
    /// No tables so far; they will have `side`² texels.
    pub(super) fn new(side: usize) -> Self {
        Tables {
            side,
            ..Tables::default()
        }
    }

    /// Makes room for exactly so many tables.
    pub(super) fn reserve(&mut self, tables: usize) {
        self.texels.reserve_exact(tables * self.side * self.side);
        self.scales.reserve_exact(tables);
    }

    /// Appends a table and returns its index.
    pub(super) fn push(&mut self, (texels, scale): (Vec<Packed>, Rgb)) -> u32 {
        self.texels.extend_from_slice(&texels);
        self.scales.push(scale);
        (self.scales.len() - 1) as u32
    }

    /// The table with the given index.
    #[inline(always)]
    pub(super) fn get(&self, index: u32) -> Table<'_> {
        let texels = self.side * self.side;
        Table {
            texels: &self.texels[index as usize * texels..][..texels],
            scale: self.scales[index as usize],
            side: self.side,
        }
    }

    /// Bytes of one table.
    pub(super) fn bytes_per_table(side: usize) -> usize {
        side * side * size_of::<Packed>() + size_of::<Rgb>()
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.texels.as_slice()) + size_of_val(self.scales.as_slice())
    }
}

/// The texels in units of the scale that is returned, chosen so that rounding does not change the sum weighted by `weights`.
pub(super) fn pack(texels: &[Rgb], weights: &[f32]) -> (Vec<Packed>, Rgb) {
    let brightest = texels.iter().map(|t| t.max_channel()).fold(0.0, f32::max);
    if brightest == 0.0 {
        return (vec![Packed::BLACK; texels.len()], Rgb::BLACK);
    }
    let unit = brightest / BRIGHTEST;
    let packed: Vec<Packed> = texels.iter().map(|&t| Packed::new(t / unit)).collect();
    let (mut exact, mut rounded) = ([0.0f64; 3], [0.0f64; 3]);
    for ((texel, packed), &weight) in texels.iter().zip(&packed).zip(weights) {
        for c in 0..3 {
            exact[c] += f64::from(texel.to_array()[c] * weight);
            rounded[c] += f64::from(packed.rgb().to_array()[c] * weight);
        }
    }
    let scale = |c: usize| {
        if rounded[c] > 0.0 {
            (exact[c] / rounded[c]) as f32
        } else {
            0.0
        }
    };
    (packed, Rgb::new(scale(0), scale(1), scale(2)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::rng::Pcg;

    #[test]
    fn packed_colors_are_near() {
        let mut rng = Pcg::new(1);
        let exact = [0.0, 1.0, 255.5, 511.0, BRIGHTEST].map(Rgb::splat);
        assert_eq!(exact.map(|x| Packed::new(x).rgb()), exact);
        for _ in 0..10_000 {
            let size = 2f32.powf(30.0 * rng.next_f32() - 15.0);
            let color = Rgb::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) * size;
            let (got, most) = (Packed::new(color).rgb(), color.max_channel());
            for (a, b) in got.to_array().into_iter().zip(color.to_array()) {
                let unit = 2f32.powi(UNIT);
                assert!((a - b).abs() <= most / 512.0 + 0.5 * unit, "{a} {b}");
            }
        }
    }

    #[test]
    fn packing_keeps_the_sum() {
        let mut rng = Pcg::new(2);
        let mut number = || rng.next_f32().powi(9);
        let texels: Vec<Rgb> = (0..64)
            .map(|_| Rgb::new(number(), 1e-3 * number(), 0.0))
            .collect();
        let weights: Vec<f32> = (0..64).map(|_| number()).collect();
        let (packed, scale) = pack(&texels, &weights);
        let sum =
            |value: &dyn Fn(usize) -> Rgb| -> Rgb { (0..64).map(|t| value(t) * weights[t]).sum() };
        let (exact, got) = (sum(&|t| texels[t]), sum(&|t| packed[t].rgb() * scale));
        assert!((got.r / exact.r - 1.0).abs() < 1e-5);
        assert!((got.g / exact.g - 1.0).abs() < 1e-5);
        assert_eq!(got.b, 0.0);
    }
}
