//! Owen-scrambled Sobol' points of four dimensions, by index: no state, and no branch, so that
//! loops over lanes become vector instructions.
//!
//! Sources: Burley, "Practical Hash-based Owen Scrambling", JCGT 2020, for the construction: the
//! index is shuffled and each coordinate is scrambled, both as nested uniform permutations.
//! Vegdahl, "Building a Better LK Hash", 2021, for the constants of the permutation. Joe and Kuo,
//! "Constructing Sobol Sequences with Better Two-Dimensional Projections", SIAM J. Sci. Comput.
//! 2008, for the polynomials and first direction numbers.

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

/// Mixes a word: every input bit affects every output bit.
///
/// Source: Wellons, "Prospecting for Hash Functions", 2018 (`lowbias32`).
#[inline(always)]
fn mix(mut x: u32) -> u32 {
    x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// A nested uniform permutation, chosen by `seed`, of words with reversed bits: each bit is flipped
/// by a function of those below it.
#[inline(always)]
fn permute(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// A sequence of points in [0, 1)⁴, shuffled and scrambled apart from those with other keys.
///
/// Each aligned run of 2ᵏ indices gives one point to each of 2ᵏ equal intervals of every
/// coordinate, and to each elementary interval of the first two.
#[inline(always)]
pub(super) fn point(key: u32, index: u32) -> [f32; 4] {
    let seed = mix(key);
    let shuffled = permute(index.reverse_bits(), seed).reverse_bits();
    let mut point = [0.0; 4];
    let mut d = 0;
    while d < 4 {
        let mut x = 0;
        let mut bit = 0;
        while bit < SEQUENCE_BITS {
            x ^= DIRECTIONS[d][bit as usize] & (shuffled >> bit & 1).wrapping_neg();
            bit += 1;
        }
        let scrambled = permute(x, mix(seed ^ (0x1000_0001 * (d as u32 + 1)))).reverse_bits();
        // As a signed number, which vector instructions convert.
        point[d] = (scrambled >> 8) as i32 as f32 * (1.0 / 16_777_216.0);
        d += 1;
    }
    point
}

#[cfg(test)]
mod tests {
    use super::*;

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
