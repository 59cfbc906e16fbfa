//! Octahedral tables in blocks of 4 x 4 texels: 4 bits per texel and a word per block.
//!
//! | words of a table | content |
//! |---|---|
//! | one byte per block, row by row | the number of the block among those that are stored; 0: black |
//! | 3 per stored block | the 16 levels, and the header between the two halves |
//!
//! With the sum of the channels `s`, the texels of a block are `s = h (l + (1 - l) q)`, with one of
//! 16 levels `q` from 0 to 1, the largest sum `h` and the relative offset `l` of the smallest.
//! Red and blue are fixed fractions of `s`.
//!
//! The lights of a reflecting surface are black below the horizon, which half of the blocks are.

use crate::color::Rgb;
use crate::lanes::{Color, Float, One, Width, Word};

/// Texels along an edge of a block.
const EDGE: usize = 4;
/// Words of a block: levels, header, levels.
const WORDS: usize = 3;
/// Bits of a level.
const LEVEL_BITS: u32 = 4;
/// The largest level.
const LEVELS: f32 = 15.0;
/// Largest value of the relative offset.
const OFFSETS: f32 = 15.0;
/// Largest value of a fraction of the sum.
const FRACTIONS: f32 = 127.0;
/// Mantissas of the largest sum: it is rounded up by at most a part in 32.
const MANTISSAS: u32 = 32;
/// Binary exponent of the unit of a mantissa for the stored exponent 0.
const UNIT: i32 = -20;
/// The largest stored exponent.
const MAX_EXPONENT: u32 = 31;
/// Exponent bias of an f32.
pub(super) const BIAS: i32 = 127;
/// Largest edge of a table in texels: blocks are counted in a byte, and one number is that of black.
pub(super) const MAX_SIDE: usize = 60;

/// Fields of a header, with their lowest bit once four bits of a level are below it.
const OFFSET: u32 = 4;
const RED: u32 = 8;
const BLUE: u32 = 15;
const MANTISSA: u32 = 22;
const EXPONENT: u32 = 27;

/// The words of a table in blocks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BlockTexels<'a> {
    /// Numbers of the blocks.
    numbers: &'a [u8],
    /// Of the stored blocks, the black one first.
    words: &'a [u32],
}

/// Blocks along an edge of a table of `side`² texels.
const fn blocks_across(side: usize) -> usize {
    side.div_ceil(EDGE)
}

/// Words of the numbers of a table's blocks.
fn number_words(side: usize) -> usize {
    blocks_across(side).pow(2).div_ceil(size_of::<u32>())
}

/// Bytes of a table of a reflecting surface: of the blocks that a horizon leaves, which are half of
/// them and those that it crosses (79 of 144 on average in the Kitchen).
pub(super) fn expected_bytes(side: usize) -> usize {
    let across = blocks_across(side);
    let stored = (across * across).div_ceil(2) + across / 2 + 1;
    (number_words(side) + WORDS * stored) * size_of::<u32>()
}

impl<'a> BlockTexels<'a> {
    /// The table in `words`; `None` if they are no table of `side`² texels.
    pub(super) fn new(words: &'a [u32], side: usize) -> Option<Self> {
        let (numbers, words) = words.split_at_checked(number_words(side))?;
        let numbers = &bytemuck::cast_slice(numbers)[..blocks_across(side).pow(2)];
        Some(BlockTexels { numbers, words })
    }

    /// Whether all blocks are stored.
    pub(super) fn is_complete(&self) -> bool {
        let last = self.numbers.iter().copied().max().unwrap_or(0);
        self.words.len() == WORDS * (usize::from(last) + 1)
    }

    /// The level and the header of a texel.
    #[inline(always)]
    pub(super) fn fetch(&self, row: usize, column: usize, side: usize) -> u32 {
        let block = row / EDGE * blocks_across(side) + column / EDGE;
        let place = row % EDGE * EDGE + column % EDGE;
        let first = WORDS * usize::from(self.numbers[block.min(self.numbers.len() - 1)]);
        let [low, header, high] = self.words[first..first + WORDS] else {
            return 0;
        };
        let levels = if place < 8 { low } else { high };
        header << LEVEL_BITS | levels >> (LEVEL_BITS as usize * (place & 7)) & 15
    }

    /// The colors of levels with their headers, as of [`BlockTexels::fetch`].
    #[inline(always)]
    pub(super) fn colors<S: Width>(words: Word<S>) -> Color<S> {
        let level = (words & 15).integer() * (1.0 / LEVELS);
        let offset = (words >> OFFSET & 15).integer() * (1.0 / OFFSETS);
        let red = (words >> RED & 127).integer() * (1.0 / FRACTIONS);
        let blue = (words >> BLUE & 127).integer() * (1.0 / FRACTIONS);
        let unit = power_of_two(words >> EXPONENT, UNIT);
        let mantissa = (words >> MANTISSA & 31).integer() + MANTISSAS as f32;
        let largest = mantissa * unit;
        let sum = largest * (offset + (1.0 - offset) * level);
        // Rounding must not make green negative.
        let green = (1.0 - red - blue).max(0.0);
        Color::new(sum * red, sum * green, sum * blue)
    }

    /// The color of texel `t`, row by row.
    pub(super) fn get(&self, t: usize, side: usize) -> Rgb {
        let word = self.fetch(t / side, t % side, side);
        BlockTexels::colors(Word::splat(One, word)).into()
    }
}

/// `2^(exponent + unit)` per lane.
#[inline(always)]
pub(super) fn power_of_two<S: Width>(exponents: Word<S>, unit: i32) -> Float<S> {
    ((exponents + (unit + BIAS) as u32) << 23).to_float()
}

/// The table of `texels` in blocks. Channels must be non-negative and at most 32768.
pub(super) fn pack_blocks(texels: &[Rgb], side: usize) -> Vec<u32> {
    let across = blocks_across(side);
    let (mut numbers, mut words) = (vec![0u8; number_words(side) * 4], vec![0u32; WORDS]);
    for (block, number) in numbers.iter_mut().enumerate().take(across * across) {
        let (row, column) = (block / across * EDGE, block % across * EDGE);
        let texel = |place: usize| {
            let (row, column) = (row + place / EDGE, column + place % EDGE);
            let inside = row < side && column < side;
            inside.then(|| texels[row * side + column])
        };
        if let Some(packed) = pack_block(&std::array::from_fn(texel)) {
            *number = (words.len() / WORDS) as u8;
            words.extend(packed);
        }
    }
    let mut all: Vec<u32> = bytemuck::pod_collect_to_vec(&numbers);
    all.append(&mut words);
    all
}

/// The words of a block, of which texels beyond the table are `None`; `None` for a black block.
fn pack_block(texels: &[Option<Rgb>; EDGE * EDGE]) -> Option<[u32; WORDS]> {
    let sum = |texel: Rgb| texel.r + texel.g + texel.b;
    let sums = || texels.iter().flatten().map(|&texel| sum(texel));
    let (most, least) = (sums().fold(0.0, f32::max), sums().fold(f32::MAX, f32::min));
    let total: Rgb = texels.iter().flatten().copied().sum();
    let unit = 2f32.powi(UNIT) * MANTISSAS as f32;
    if most < 0.5 * unit {
        return None;
    }
    let exponent = ((most / unit).log2().floor().max(0.0) as u32).min(MAX_EXPONENT);
    let step = 2f32.powi(UNIT + exponent as i32);
    let rounded = ((most / step).ceil() as u32).max(MANTISSAS);
    // The next power of two, beyond the last mantissa.
    let (exponent, rounded) = match rounded < 2 * MANTISSAS {
        true => (exponent, rounded),
        false => ((exponent + 1).min(MAX_EXPONENT), MANTISSAS),
    };
    let largest = rounded as f32 * 2f32.powi(UNIT + exponent as i32);
    let offset = (least / largest * OFFSETS).floor();
    let low = largest * offset / OFFSETS;
    let fraction = |channel: f32| (channel / sum(total) * FRACTIONS).round() as u32;
    let header = (offset as u32) << OFFSET
        | fraction(total.r) << RED
        | fraction(total.b) << BLUE
        | (rounded - MANTISSAS) << MANTISSA
        | exponent << EXPONENT;
    let range = (largest - low).max(f32::MIN_POSITIVE);
    let mut levels = [0u32; 2];
    for (place, texel) in texels.iter().enumerate() {
        let level = texel.map_or(0.0, |texel| (sum(texel) - low) / range * LEVELS);
        let level = (level.clamp(0.0, LEVELS) + 0.5) as u32;
        levels[place / 8] |= level << (LEVEL_BITS as usize * (place & 7));
    }
    Some([levels[0], header >> LEVEL_BITS, levels[1]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::rng::Pcg;

    #[test]
    fn unpacked_texels_are_near() {
        let mut rng = Pcg::new(4);
        for side in [8, 10, 48, 60] {
            for _ in 0..20 {
                let scale = 2f32.powf(20.0 * rng.next_f32() - 5.0);
                let tint = Rgb::new(rng.next_f32(), rng.next_f32(), rng.next_f32());
                let texels: Vec<Rgb> = (0..side * side)
                    .map(|t| match (t / side) < side / 2 {
                        true => tint * (scale * rng.next_f32()),
                        false => Rgb::BLACK,
                    })
                    .collect();
                let words = pack_blocks(&texels, side);
                let blocks = BlockTexels::new(&words, side).unwrap();
                assert!(blocks.is_complete());
                let most = scale * (tint.r + tint.g + tint.b);
                for (t, &exact) in texels.iter().enumerate() {
                    let found = blocks.get(t, side);
                    let error = (found - exact).map(f32::abs);
                    // Half a level of sixteen, half a step of a fraction.
                    let bound = most * (0.5 / LEVELS + 1.0 / FRACTIONS) * 1.05;
                    assert!(error.max_channel() <= bound, "{found:?} for {exact:?}");
                }
                // Half of the blocks are black, but for a row that the edge crosses.
                let stored = (words.len() - number_words(side)) / WORDS - 1;
                let across = blocks_across(side);
                assert_eq!(stored, across * (side / 2).div_ceil(EDGE));
            }
        }
    }

    #[test]
    fn one_color_and_black_are_exact_up_to_the_steps() {
        for value in [0.0, 1e-9, 1e-3, 1.0, 32_768.0] {
            let words = pack_blocks(&[Rgb::splat(value); 64], 8);
            let blocks = BlockTexels::new(&words, 8).unwrap();
            for t in 0..64 {
                let found = blocks.get(t, 8);
                let error = (found - Rgb::splat(value)).map(f32::abs).max_channel();
                assert!(error <= 0.04 * value.max(1e-5), "{found:?} for {value}");
            }
        }
    }

    #[test]
    fn words_that_are_no_table_are_refused() {
        let words = pack_blocks(&[Rgb::WHITE; 64], 8);
        assert!(BlockTexels::new(&words[..words.len() - 1], 8).is_some_and(|b| !b.is_complete()));
        assert!(BlockTexels::new(&[], 8).is_none());
    }
}
