//! Storage of octahedral tables: texel formats, and all tables of a set one after the other.

use super::octahedral_grid::Grid;
use super::table_lookup::TexelCorners;
use crate::color::Rgb;
use crate::lanes::{Color, Mask, One, Vector, Width, Word};
use bytemuck::{Pod, Zeroable};

/// Format of the texels of a table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TableStorage {
    /// Three floats: 12 bytes.
    Float,
    /// Three mantissas with a shared exponent: 4 bytes.
    #[default]
    Shared,
}

impl TableStorage {
    /// Bytes of one texel.
    pub const fn texel_bytes(self) -> usize {
        match self {
            TableStorage::Float => size_of::<Rgb>(),
            TableStorage::Shared => size_of::<SharedExponent>(),
        }
    }

    /// The texels of a table on `grid` in this format, with the scale that keeps their sum weighted
    /// by the hat functions.
    pub(super) fn pack(self, texels: &[Rgb], grid: &Grid) -> PackedTable {
        match self {
            TableStorage::Float => pack::<Rgb>(texels, &grid.hats),
            TableStorage::Shared => pack::<SharedExponent>(texels, &grid.hats),
        }
    }
}

/// A stored color.
pub(crate) trait Texel: Pod {
    /// Rounds to the nearest. Channels must be at most [`BRIGHTEST`].
    fn new(color: Rgb) -> Self;
    /// The colors of a texel per lane.
    fn colors<S: Width>(s: S, texels: &S::Each<Self>) -> Color<S>;
    /// The color.
    fn rgb(self) -> Rgb {
        Self::colors(One, &[self]).into()
    }
}

/// Value to which the brightest texel of a table is scaled: close to the largest number of
/// [`SharedExponent`].
const BRIGHTEST: f32 = 32_768.0;

impl Texel for Rgb {
    fn new(color: Rgb) -> Self {
        color
    }

    #[inline(always)]
    fn colors<S: Width>(s: S, texels: &S::Each<Self>) -> Color<S> {
        Color::from_fn(s, |i| texels.as_ref()[i])
    }
}

/// Three non-negative numbers: mantissas of 9 bits with a shared exponent of 5 bits. The error of a
/// channel is at most 1/512 of the largest channel. Source: the OpenGL extension
/// EXT_texture_shared_exponent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub(crate) struct SharedExponent(u32);

/// The largest mantissa plus one.
const MANTISSAS: f32 = 512.0;
/// Binary exponent of the unit of a mantissa for the stored exponent 0.
const UNIT: i32 = -24;
/// Exponent bias of an f32.
const BIAS: i32 = 127;

impl Texel for SharedExponent {
    fn new(color: Rgb) -> Self {
        let color = color.map(|x| x.max(0.0));
        let exponent_of = |x: f32| (x.to_bits() >> 23) as i32 - BIAS;
        let unit = |stored: i32| f32::from_bits(((stored + UNIT + BIAS) as u32) << 23);
        let mut stored = (exponent_of(color.max_channel()) + 1 - 9 - UNIT).max(0);
        if (color.max_channel() / unit(stored)).round() >= MANTISSAS {
            stored += 1;
        }
        let [r, g, b] = color.to_array().map(|x| (x / unit(stored)).round() as u32);
        SharedExponent(r | g << 9 | b << 18 | (stored as u32) << 27)
    }

    #[inline(always)]
    fn colors<S: Width>(s: S, texels: &S::Each<Self>) -> Color<S> {
        let words = Word::load(s, &s.each(|i| texels.as_ref()[i].0));
        let unit = (((words >> 27) + (UNIT + BIAS) as u32) << 23).to_float();
        let (r, g, b) = (words & 511, words >> 9 & 511, words >> 18 & 511);
        Color::new(r.integer(), g.integer(), b.integer()) * unit
    }
}

/// The texels of a table.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Texels<'a> {
    Float(&'a [Rgb]),
    Shared(&'a [SharedExponent]),
}

impl<'a> Texels<'a> {
    #[inline(always)]
    fn new(storage: TableStorage, words: &'a [u32]) -> Self {
        match storage {
            TableStorage::Float => Texels::Float(bytemuck::cast_slice(words)),
            TableStorage::Shared => Texels::Shared(bytemuck::cast_slice(words)),
        }
    }

    pub(super) fn get(&self, t: usize) -> Rgb {
        match self {
            Texels::Float(texels) => texels[t].rgb(),
            Texels::Shared(texels) => texels[t].rgb(),
        }
    }
}

/// A table of `side`² colors on the octahedral map, row by row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OctahedralTable<'a> {
    /// In units of `scale`.
    pub(crate) texels: Texels<'a>,
    /// Value of one unit, per channel.
    pub(crate) scale: Rgb,
    pub(super) side: usize,
}

/// One table before it is stored in [`OctahedralTables`].
#[derive(Clone, Debug)]
pub(super) struct PackedTable {
    /// The bytes of the texels.
    words: Vec<u32>,
    /// Value of one unit, per channel.
    scale: Rgb,
}

/// Tables of one size and format, one after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct OctahedralTables {
    side: usize,
    storage: TableStorage,
    /// The bytes of the texels.
    words: Vec<u32>,
    /// One per table.
    scales: Vec<Rgb>,
}

/// Number of words of the texels of one table; an integer because `side` is even.
const fn words_of(side: usize, storage: TableStorage) -> usize {
    side * side * storage.texel_bytes() / size_of::<u32>()
}

impl OctahedralTables {
    /// An empty store of tables of `side`² texels.
    pub(super) fn new(side: usize, storage: TableStorage) -> Self {
        OctahedralTables {
            side,
            storage,
            ..OctahedralTables::default()
        }
    }

    /// Reserves memory for exactly this many more tables.
    pub(super) fn reserve(&mut self, tables: usize) {
        self.words
            .reserve_exact(tables * words_of(self.side, self.storage));
        self.scales.reserve_exact(tables);
    }

    /// Appends a table and returns its index.
    pub(super) fn push(&mut self, table: &PackedTable) -> u32 {
        self.words.extend_from_slice(&table.words);
        self.scales.push(table.scale);
        (self.scales.len() - 1) as u32
    }

    /// The table with the given index.
    #[inline(always)]
    pub(super) fn get(&self, index: u32) -> OctahedralTable<'_> {
        let words = words_of(self.side, self.storage);
        let own = &self.words[index as usize * words..][..words];
        OctahedralTable {
            texels: Texels::new(self.storage, own),
            scale: self.scales[index as usize],
            side: self.side,
        }
    }

    /// Bytes of one table.
    pub(super) fn bytes_per_table(side: usize, storage: TableStorage) -> usize {
        side * side * storage.texel_bytes() + size_of::<Rgb>()
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.words.as_slice()) + size_of_val(self.scales.as_slice())
    }
}

/// Rounds the texels to the format `T`, with a scale per channel that keeps their sum weighted by
/// `weights`.
fn pack<T: Texel>(texels: &[Rgb], weights: &[f32]) -> PackedTable {
    let brightest = texels.iter().map(|t| t.max_channel()).fold(0.0, f32::max);
    let unit = if brightest > 0.0 {
        brightest / BRIGHTEST
    } else {
        1.0
    };
    let packed: Vec<T> = texels.iter().map(|&t| T::new(t / unit)).collect();
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
    PackedTable {
        words: bytemuck::pod_collect_to_vec(&packed),
        scale: Rgb::new(scale(0), scale(1), scale(2)),
    }
}

impl OctahedralTable<'_> {
    /// Bilinear interpolation in the unit directions `w`, also below the horizon; inactive lanes
    /// hold any value.
    #[inline(always)]
    pub(super) fn lookup<S: Width>(&self, w: Vector<S>, active: Mask<S>) -> Color<S> {
        let corners = TexelCorners::of(w, self.side as f32, active);
        let sum = match self.texels {
            Texels::Float(texels) => weighted_sum(&corners, texels),
            Texels::Shared(texels) => weighted_sum(&corners, texels),
        };
        sum * Color::splat(w.z.width(), self.scale)
    }
}

/// The weighted sums of the texels of `table` at the corners.
#[inline(always)]
fn weighted_sum<S: Width, T: Texel>(corners: &TexelCorners<S>, table: &[T]) -> Color<S> {
    let s = corners.weights[0].width();
    let mut sum = Color::black(s);
    let Some(last) = table.len().checked_sub(1) else {
        return sum;
    };
    for k in 0..4 {
        let texels = corners.texels[k].as_ref();
        let fetched = s.each(|i| table[(texels[i] as usize).min(last)]);
        sum += T::colors(s, &fetched) * corners.weights[k];
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::rng::Pcg;

    #[test]
    fn packed_colors_are_near() {
        let mut rng = Pcg::new(1);
        let exact = [0.0, 1.0, 255.5, 511.0, BRIGHTEST].map(Rgb::splat);
        assert_eq!(exact.map(|x| SharedExponent::new(x).rgb()), exact);
        for _ in 0..10_000 {
            let size = 2f32.powf(30.0 * rng.next_f32() - 15.0);
            let color = Rgb::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) * size;
            let (got, most) = (SharedExponent::new(color).rgb(), color.max_channel());
            for (a, b) in got.to_array().into_iter().zip(color.to_array()) {
                let unit = 2f32.powi(UNIT);
                assert!((a - b).abs() <= most / 512.0 + 0.5 * unit, "{a} {b}");
            }
        }
    }

    fn packing_keeps_the_sum_of<T: Texel>(worst: f32) {
        let mut rng = Pcg::new(2);
        let mut number = || 1e-12 * rng.next_f32().powi(9);
        let texels: Vec<Rgb> = (0..64)
            .map(|_| Rgb::new(number(), 1e-3 * number(), 0.0))
            .collect();
        let weights: Vec<f32> = (0..64).map(|_| number()).collect();
        let packed = pack::<T>(&texels, &weights);
        let got: Vec<Rgb> = bytemuck::cast_slice::<u32, T>(&packed.words)
            .iter()
            .map(|texel| texel.rgb() * packed.scale)
            .collect();
        let sum = |texels: &[Rgb]| -> Rgb {
            texels
                .iter()
                .zip(&weights)
                .map(|(t, w)| *t * (*w * 1e12))
                .sum()
        };
        let (exact, rounded) = (sum(&texels), sum(&got));
        assert!((rounded.r / exact.r - 1.0).abs() < 1e-5);
        assert!((rounded.g / exact.g - 1.0).abs() < 1e-5);
        assert_eq!(rounded.b, 0.0);
        let most = texels.iter().map(|t| t.max_channel()).fold(0.0, f32::max);
        for (a, b) in got.iter().zip(&texels) {
            assert!((*a - *b).map(f32::abs).max_channel() <= worst * most);
        }
    }

    #[test]
    fn packing_keeps_the_sum() {
        packing_keeps_the_sum_of::<Rgb>(1e-6);
        packing_keeps_the_sum_of::<SharedExponent>(1.0 / 256.0);
    }
}
