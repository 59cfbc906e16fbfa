//! Storage of octahedral tables: texel formats, and all tables of a set one after the other.

use super::octahedral_grid::Grid;
use super::table_blocks::{BIAS, BlockTexels, MAX_SIDE, expected_bytes, pack_blocks, power_of_two};
use super::table_lookup::Cells;
use crate::arrays::{FoundArray, InvalidArray, NamedArray, read_floats, read_words};
use crate::color::Rgb;
use crate::lanes::{Color, Float, LANES, Mask, One, Vector, Width, Word};
use crate::simd::{Isa, Simd, SimdKernel};
use bytemuck::{Pod, Zeroable};

/// Format of the texels of a table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TableStorage {
    /// Three floats: 12 bytes.
    Float,
    /// Three mantissas with a shared exponent: 4 bytes.
    #[default]
    Shared,
    /// Blocks of 4 x 4 texels that are not black: half a byte, and four bytes per block. At most
    /// [`TableStorage::MAX_SIDE_OF_BLOCKS`] texels along an edge.
    Blocks,
}

impl TableStorage {
    /// Largest edge of a table of [`TableStorage::Blocks`], in texels.
    pub const MAX_SIDE_OF_BLOCKS: u32 = MAX_SIDE as u32;

    /// Bytes of a table of `side`² texels; of blocks, with those above a horizon.
    fn table_bytes(self, side: usize) -> usize {
        match self {
            TableStorage::Float => side * side * size_of::<Rgb>(),
            TableStorage::Shared => side * side * size_of::<SharedExponent>(),
            TableStorage::Blocks => expected_bytes(side),
        }
    }

    /// The texels of a table on `grid` in this format, with the scale that keeps their sum weighted
    /// by the hat functions.
    pub(super) fn pack(self, texels: &[Rgb], grid: &Grid) -> PackedTable {
        match self {
            TableStorage::Float => pack::<Rgb>(texels, &grid.hats),
            TableStorage::Shared => pack::<SharedExponent>(texels, &grid.hats),
            TableStorage::Blocks => {
                let unit = unit_of(texels);
                let scaled: Vec<Rgb> = texels.iter().map(|&t| t / unit).collect();
                let words = pack_blocks(&scaled, grid.side());
                let scale = match BlockTexels::new(&words, grid.side()) {
                    Some(blocks) => {
                        let rounded = |t| blocks.get(t, grid.side());
                        scale_that_keeps_the_sum(texels, rounded, &grid.hats)
                    }
                    None => Rgb::BLACK,
                };
                PackedTable { words, scale }
            }
        }
    }
}

/// A stored color.
pub(crate) trait Texel: Pod {
    /// Colors rounded to the nearest. Channels must be at most [`BRIGHTEST`].
    fn pack(colors: &[Rgb]) -> Vec<Self>;
    /// The color.
    fn rgb(self) -> Rgb;
}

/// Value to which the brightest texel of a table is scaled: close to the largest number of
/// [`SharedExponent`].
const BRIGHTEST: f32 = 32_768.0;

impl Texel for Rgb {
    fn pack(colors: &[Rgb]) -> Vec<Self> {
        colors.to_vec()
    }

    fn rgb(self) -> Rgb {
        self
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

impl Texel for SharedExponent {
    fn pack(colors: &[Rgb]) -> Vec<Self> {
        Isa::best().run(PackShared(colors))
    }

    fn rgb(self) -> Rgb {
        SharedExponent::colors(Word::splat(One, self.0)).into()
    }
}

impl SharedExponent {
    /// The word of the color in each lane.
    #[inline(always)]
    fn words<S: Width>(color: Color<S>) -> Word<S> {
        let s = color.r.width();
        let color = Color::new(color.r.max(0.0), color.g.max(0.0), color.b.max(0.0));
        let most = color.max_channel();
        // From here on the largest mantissa has nine bits.
        let least = (BIAS - 1 + 9 + UNIT) as f32;
        let stored = ((most.to_bits() >> 23).integer() - least).max(0.0);
        let per_unit = |stored: Float<S>| {
            let exponents = Word::splat(s, (BIAS - UNIT) as u32) - stored.to_word();
            (exponents << 23).to_float()
        };
        let rounds_up = (most * per_unit(stored)).ge(MANTISSAS - 0.5);
        let stored = rounds_up.select(stored + 1.0, stored);
        let mantissas = color * per_unit(stored);
        mantissas.r.to_word()
            + (mantissas.g.to_word() << 9)
            + (mantissas.b.to_word() << 18)
            + (stored.to_word() << 27)
    }

    /// The color of the word in each lane.
    #[inline(always)]
    fn colors<S: Width>(words: Word<S>) -> Color<S> {
        let unit = power_of_two(words >> 27, UNIT);
        let (r, g, b) = (words & 511, words >> 9 & 511, words >> 18 & 511);
        Color::new(r.integer(), g.integer(), b.integer()) * unit
    }
}

/// Kernel of [`SharedExponent::pack`].
struct PackShared<'a>(&'a [Rgb]);

impl SimdKernel for PackShared<'_> {
    type Output = Vec<SharedExponent>;

    #[inline(always)]
    fn run<I: Simd>(self, isa: I) -> Vec<SharedExponent> {
        let mut packed = Vec::with_capacity(self.0.len());
        for colors in self.0.chunks(LANES) {
            let last = colors.len() - 1;
            let color = Color::from_fn(isa.wide(), |i| colors[i.min(last)]);
            let words = SharedExponent::words(color).store();
            packed.extend(
                words[..colors.len()]
                    .iter()
                    .map(|&word| SharedExponent(word)),
            );
        }
        packed
    }
}

/// The texels of a table.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Texels<'a> {
    Float(&'a [Rgb]),
    Shared(&'a [SharedExponent]),
    Blocks(BlockTexels<'a>),
}

impl<'a> Texels<'a> {
    #[inline(always)]
    fn new((side, storage): (usize, TableStorage), words: &'a [u32]) -> Self {
        match storage {
            TableStorage::Float => Texels::Float(bytemuck::cast_slice(words)),
            TableStorage::Shared => Texels::Shared(bytemuck::cast_slice(words)),
            TableStorage::Blocks => match BlockTexels::new(words, side) {
                Some(blocks) => Texels::Blocks(blocks),
                None => Texels::Float(&[]),
            },
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

/// Name of the array of texels.
const TEXELS: &str = "tables.texels";
/// Name of the array of ends of the tables among the texels.
const ENDS: &str = "tables.end";
/// Name of the array of scales.
const SCALES: &str = "tables.scale";

impl OctahedralTable<'_> {
    /// The color of texel `t`, in units of `scale`.
    pub(super) fn texel(&self, t: usize) -> Rgb {
        match self.texels {
            Texels::Float(texels) => texels[t].rgb(),
            Texels::Shared(texels) => texels[t].rgb(),
            Texels::Blocks(blocks) => blocks.get(t, self.side),
        }
    }
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
    /// Ends of the tables in `words`.
    ends: Vec<u32>,
    /// One per table.
    scales: Vec<Rgb>,
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
        let bytes = tables * self.storage.table_bytes(self.side);
        match self.storage {
            TableStorage::Float | TableStorage::Shared => {
                self.words.reserve_exact(bytes / size_of::<u32>());
            }
            TableStorage::Blocks => self.words.reserve(bytes / size_of::<u32>()),
        }
        self.ends.reserve_exact(tables);
        self.scales.reserve_exact(tables);
    }

    /// Appends a table and returns its index.
    pub(super) fn push(&mut self, table: &PackedTable) -> u32 {
        self.words.extend_from_slice(&table.words);
        let end = u32::try_from(self.words.len());
        self.ends
            .push(end.expect("tables of a group of passes take less than 16 GB"));
        self.scales.push(table.scale);
        (self.scales.len() - 1) as u32
    }

    /// The table with the given index.
    #[inline(always)]
    pub(super) fn get(&self, index: u32) -> OctahedralTable<'_> {
        let index = index as usize;
        let own = &self.words[self.start(index)..self.ends[index] as usize];
        OctahedralTable {
            texels: Texels::new((self.side, self.storage), own),
            scale: self.scales[index],
            side: self.side,
        }
    }

    /// Where a table begins in `words`.
    #[inline(always)]
    fn start(&self, index: usize) -> usize {
        index
            .checked_sub(1)
            .map_or(0, |before| self.ends[before] as usize)
    }

    /// Number of tables.
    pub(super) fn len(&self) -> usize {
        self.scales.len()
    }

    /// As arrays.
    pub(super) fn arrays(&self) -> Vec<NamedArray<'_>> {
        let scales = || self.scales.iter().flat_map(|scale| scale.to_array());
        vec![
            NamedArray::words(TEXELS, [self.words.len()], || self.words.iter().copied()),
            NamedArray::words(ENDS, [self.len()], || self.ends.iter().copied()),
            NamedArray::floats(SCALES, [self.len(), 3], scales),
        ]
    }

    /// The inverse of [`OctahedralTables::arrays`].
    ///
    /// # Errors
    /// Those of `read`, and tables of another size.
    pub(super) fn of_arrays<E: From<InvalidArray>>(
        (side, storage): (usize, TableStorage),
        read: &mut impl FnMut(&str) -> Result<FoundArray, E>,
    ) -> Result<Self, E> {
        let scales: Vec<Rgb> = read_floats(SCALES, 3, read)?
            .as_chunks::<3>()
            .0
            .iter()
            .map(|&scale| scale.into())
            .collect();
        let tables = OctahedralTables {
            side,
            storage,
            words: read_words(TEXELS, 1, read)?,
            ends: read_words(ENDS, 1, read)?,
            scales,
        };
        match tables.are_sound() {
            true => Ok(tables),
            false => {
                let message = format!("expected tables of {side} x {side} texels");
                Err(InvalidArray::new(TEXELS, message).into())
            }
        }
    }

    /// Whether all tables have the words of their size.
    fn are_sound(&self) -> bool {
        let last = self.ends.last().map_or(0, |&end| end as usize);
        let follow = last == self.words.len() && self.ends.is_sorted();
        let is_sound = |index: usize| {
            let own = &self.words[self.start(index)..self.ends[index] as usize];
            match self.storage {
                TableStorage::Float | TableStorage::Shared => {
                    size_of_val(own) == self.storage.table_bytes(self.side)
                }
                TableStorage::Blocks => {
                    BlockTexels::new(own, self.side).is_some_and(|blocks| blocks.is_complete())
                }
            }
        };
        self.ends.len() == self.scales.len() && follow && (0..self.len()).all(is_sound)
    }

    /// Bytes of one table.
    pub(super) fn bytes_per_table(side: usize, storage: TableStorage) -> usize {
        storage.table_bytes(side) + size_of::<Rgb>() + size_of::<u32>()
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.words.as_slice())
            + size_of_val(self.ends.as_slice())
            + size_of_val(self.scales.as_slice())
    }
}

/// Rounds the texels to the format `T`, with a scale per channel that keeps their sum weighted by
/// `weights`.
fn pack<T: Texel>(texels: &[Rgb], weights: &[f32]) -> PackedTable {
    let unit = unit_of(texels);
    let scaled: Vec<Rgb> = texels.iter().map(|&t| t / unit).collect();
    let packed = T::pack(&scaled);
    PackedTable {
        scale: scale_that_keeps_the_sum(texels, |t| packed[t].rgb(), weights),
        words: bytemuck::pod_collect_to_vec(&packed),
    }
}

/// The unit in which the brightest channel of all texels is [`BRIGHTEST`].
fn unit_of(texels: &[Rgb]) -> f32 {
    let brightest = texels.iter().map(|t| t.max_channel()).fold(0.0, f32::max);
    match brightest > 0.0 {
        true => brightest / BRIGHTEST,
        false => 1.0,
    }
}

/// The scale per channel with which the texels `rounded` have the sum of `texels`, weighted by
/// `weights`.
fn scale_that_keeps_the_sum(
    texels: &[Rgb],
    rounded: impl Fn(usize) -> Rgb,
    weights: &[f32],
) -> Rgb {
    let (mut exact, mut sum) = ([0.0f64; 3], [0.0f64; 3]);
    for (t, (texel, &weight)) in texels.iter().zip(weights).enumerate() {
        let rounded = rounded(t).to_array();
        for c in 0..3 {
            exact[c] += f64::from(texel.to_array()[c] * weight);
            sum[c] += f64::from(rounded[c] * weight);
        }
    }
    let scale = |c: usize| match sum[c] > 0.0 {
        true => (exact[c] / sum[c]) as f32,
        false => 0.0,
    };
    Rgb::new(scale(0), scale(1), scale(2))
}

impl OctahedralTable<'_> {
    /// Bilinear interpolation in the unit directions `w`, also below the horizon; inactive lanes
    /// hold any value.
    #[inline(always)]
    pub(super) fn lookup<S: Width>(&self, w: Vector<S>, active: Mask<S>) -> Color<S> {
        let side = self.side;
        let cells = Cells::of(w, side);
        let sum = match self.texels {
            Texels::Float(texels) => {
                let texel = |row: usize, column: usize| {
                    let color = texels
                        .get(row * side + column)
                        .copied()
                        .unwrap_or(Rgb::BLACK);
                    [color.r.to_bits(), color.g.to_bits(), color.b.to_bits()]
                };
                let color =
                    |[r, g, b]: [Word<S>; 3]| Color::new(r.to_float(), g.to_float(), b.to_float());
                weighted_sum(cells.words(active, texel), color)
            }
            Texels::Shared(texels) => {
                let texel = |row: usize, column: usize| {
                    [texels.get(row * side + column).map_or(0, |texel| texel.0)]
                };
                weighted_sum(cells.words(active, texel), |[word]| {
                    SharedExponent::colors(word)
                })
            }
            Texels::Blocks(blocks) => {
                let texel = |row, column| [blocks.fetch(row, column, side)];
                weighted_sum(cells.words(active, texel), |[word]| {
                    BlockTexels::colors(word)
                })
            }
        };
        sum * Color::splat(w.z.width(), self.scale)
    }
}

/// The sum of the colors of texels times their weights.
#[inline(always)]
fn weighted_sum<S: Width, const N: usize>(
    texels: [([Word<S>; N], Float<S>); 4],
    colors: impl Fn([Word<S>; N]) -> Color<S>,
) -> Color<S> {
    let mut sum = Color::black(texels[0].1.width());
    for (texel, weight) in texels {
        sum += colors(texel) * weight;
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
        let packed = SharedExponent::pack(&exact);
        assert!(packed.iter().map(|texel| texel.rgb()).eq(exact));
        for _ in 0..10_000 {
            let size = 2f32.powf(30.0 * rng.next_f32() - 15.0);
            let color = Rgb::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) * size;
            let (got, most) = (SharedExponent::pack(&[color])[0].rgb(), color.max_channel());
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
