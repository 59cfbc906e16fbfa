//! Owen-scrambled Sobol' points of four dimensions, by index: no state, and no branch.
//!
//! Sources: Burley, "Practical Hash-based Owen Scrambling", JCGT 2020, for the construction: the
//! index is shuffled and each coordinate is scrambled, both as nested uniform permutations.
//! Vegdahl, "Building a Better LK Hash", 2021, for the constants of the permutation. Joe and Kuo,
//! "Constructing Sobol Sequences with Better Two-Dimensional Projections", SIAM J. Sci. Comput.
//! 2008, for the polynomials and first direction numbers.

use crate::lanes::{Float, Width, Word};

/// Points of one sequence. Fewer bits than a word save half of the work of the coordinates.
pub(super) const SEQUENCE_BITS: u32 = 16;

/// Degrees, coefficients between the first and the last, and first direction numbers of the
/// primitive polynomials of coordinates 1 to 3. Coordinate 0 is the radical inverse.
const POLYNOMIALS: [(usize, u32, [u32; 3]); 3] =
    [(1, 0, [1, 0, 0]), (2, 1, [1, 3, 0]), (3, 1, [1, 3, 1])];

/// By coordinate and bit of the index: the direction number with its bits reversed, so that the
/// leading digit is the lowest bit.
const DIRECTIONS: [[u32; SEQUENCE_BITS as usize]; 4] = directions();

const fn directions() -> [[u32; SEQUENCE_BITS as usize]; 4] {
    let mut all = [[0; SEQUENCE_BITS as usize]; 4];
    let mut i = 0;
    while i < all[0].len() {
        all[0][i] = 1 << i;
        i += 1;
    }
    let mut d = 0;
    while d < POLYNOMIALS.len() {
        let (degree, inner, first) = POLYNOMIALS[d];
        let mut v = [0; SEQUENCE_BITS as usize];
        let mut i = 0;
        while i < v.len() {
            v[i] = if i < degree {
                first[i] << (31 - i)
            } else {
                let mut x = v[i - degree] ^ (v[i - degree] >> degree);
                let mut k = 1;
                while k < degree {
                    if inner >> (degree - 1 - k) & 1 == 1 {
                        x ^= v[i - k];
                    }
                    k += 1;
                }
                x
            };
            all[d + 1][i] = v[i].reverse_bits();
            i += 1;
        }
        d += 1;
    }
    all
}

/// Coordinates 2 and 3 of [`DIRECTIONS`], side by side: an index of 16 bits leads to coordinates of
/// 16 digits.
const TWO_DIRECTIONS: [u32; SEQUENCE_BITS as usize] = two_directions();

const fn two_directions() -> [u32; SEQUENCE_BITS as usize] {
    let mut both = DIRECTIONS[2];
    let mut i = 0;
    while i < both.len() {
        both[i] |= DIRECTIONS[3][i] << SEQUENCE_BITS;
        i += 1;
    }
    both
}

/// Mixes words: every input bit affects every output bit.
///
/// Source: Wellons, "Prospecting for Hash Functions", 2018 (`lowbias32`).
#[inline(always)]
fn mix<S: Width>(x: Word<S>) -> Word<S> {
    let x = (x ^ (x >> 16)) * 0x7feb_352d;
    let x = (x ^ (x >> 15)) * 0x846c_a68b;
    x ^ (x >> 16)
}

/// A nested uniform permutation, chosen by `seed`, of words with reversed bits: each bit is flipped
/// by a function of those below it.
#[inline(always)]
fn permute<S: Width>(x: Word<S>, seed: Word<S>) -> Word<S> {
    let x = x ^ (x * 0x3d20_adea);
    let x = x + seed;
    // With its lowest bit set.
    let odd = ((seed >> 16) & !1) + 1;
    let x = x * odd;
    let x = x ^ (x * 0x0552_6c56);
    x ^ (x * 0x53a2_2864)
}

/// The digits of coordinate 1 by those of the index: the rows of Pascal's triangle modulo 2, which
/// is a sum over supersets by Lucas's theorem.
#[inline(always)]
fn pascal<S: Width>(x: Word<S>) -> Word<S> {
    let x = x ^ ((x >> 1) & 0x5555);
    let x = x ^ ((x >> 2) & 0x3333);
    let x = x ^ ((x >> 4) & 0x0f0f);
    x ^ ((x >> 8) & 0x00ff)
}

/// Points of sequences in [0, 1)⁴, shuffled and scrambled apart from those with other keys: point
/// `index` of sequence `key`, below 2¹⁶.
///
/// Each aligned run of 2ᵏ indices gives one point to each of 2ᵏ equal intervals of every
/// coordinate, and to each elementary interval of the first two.
#[inline(always)]
pub(super) fn points<S: Width>(key: Word<S>, index: Word<S>) -> [Float<S>; 4] {
    let seed = mix(key);
    let shuffled = permute(index.reverse_bits(), seed).reverse_bits() & 0xffff;
    let mut both = Word::splat(key.width(), 0);
    let mut bit = 0;
    while bit < SEQUENCE_BITS {
        let digit = (shuffled >> bit) & 1;
        // All bits set where the digit is 1.
        let all = Word::splat(key.width(), 0) - digit;
        both = both ^ (all & TWO_DIRECTIONS[bit as usize]);
        bit += 1;
    }
    [
        scrambled(shuffled, seed, 1),
        scrambled(pascal(shuffled), seed, 2),
        scrambled(both & 0xffff, seed, 3),
        scrambled(both >> SEQUENCE_BITS, seed, 4),
    ]
}

/// A coordinate with the digits `x`, scrambled by the `d`-th permutation of a sequence.
#[inline(always)]
fn scrambled<S: Width>(x: Word<S>, seed: Word<S>, d: u32) -> Float<S> {
    let digits = permute(x, mix(seed ^ (0x1000_0001 * d))).reverse_bits();
    // 24 bits, in two parts that are small enough for `integer`.
    let high = (digits >> 10).integer();
    let low = ((digits >> 8) & 3).integer();
    (high * 4.0 + low) * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::One;

    fn point(key: u32, index: u32) -> [f32; 4] {
        let word = |x| Word::load(One, &[x]);
        points(word(key), word(index)).map(|x| x.store()[0])
    }

    fn cell(x: f32, cells: u32) -> usize {
        (x * cells as f32) as usize
    }

    /// Every elementary interval of the first two coordinates, and every interval of the others,
    /// has one of the points of each aligned run.
    #[test]
    fn runs_have_a_point_in_each_elementary_interval() {
        for key in 0..50 {
            for (log, run) in [(2, 3), (4, 0), (4, 5), (6, 1), (10, 2)] {
                let n = 1 << log;
                let points: Vec<[f32; 4]> = (0..n).map(|i| point(key, run * n + i)).collect();
                for wide in 0..=log {
                    let mut seen = vec![0; n as usize];
                    for [x, y, ..] in &points {
                        seen[cell(*x, 1 << wide) << (log - wide) | cell(*y, 1 << (log - wide))] +=
                            1;
                    }
                    assert!(seen.iter().all(|&count| count == 1), "{key} {log} {wide}");
                }
                for d in 0..4 {
                    let mut seen = vec![0; n as usize];
                    points.iter().for_each(|p| seen[cell(p[d], n)] += 1);
                    assert!(seen.iter().all(|&count| count == 1), "{key} {log} {d}");
                }
            }
        }
    }

    /// Over keys, one point is uniform, and two coordinates, two keys and two indices of different
    /// runs are uncorrelated.
    #[test]
    fn keys_and_coordinates_are_independent() {
        const KEYS: u32 = 1 << 16;
        // A correlation of independent numbers has standard deviation 1/√n.
        let bound = 5.0 / f64::from(KEYS).sqrt();
        let centered = |key, index| point(key, index).map(|x| (f64::from(x) - 0.5) * 12f64.sqrt());
        for index in [0, 1, 7, 100] {
            let mut means = [0.0; 4];
            let mut products = [[0.0; 4]; 4];
            let mut next_key = [[0.0; 4]; 4];
            for key in 0..KEYS {
                let (a, b) = (centered(key, index), centered(key + 1, index));
                for i in 0..4 {
                    means[i] += a[i] / f64::from(KEYS);
                    for j in 0..4 {
                        products[i][j] += a[i] * a[j] / f64::from(KEYS);
                        next_key[i][j] += a[i] * b[j] / f64::from(KEYS);
                    }
                }
            }
            for i in 0..4 {
                assert!(means[i].abs() < bound, "{index}: mean {}", means[i]);
                for j in 0..4 {
                    let expected = if i == j { 1.0 } else { 0.0 };
                    let product: f64 = products[i][j];
                    assert!(
                        (product - expected).abs() < bound,
                        "{index} {i} {j}: {product}"
                    );
                    let product: f64 = next_key[i][j];
                    assert!(product.abs() < bound, "{index} {i} {j}: {product} of keys");
                }
            }
        }
    }
}
