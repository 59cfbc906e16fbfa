//! Matrices of bits.

/// Transposes a matrix of 64 x 64 bits in place: bit `j` of word `i` becomes bit `i` of word `j`.
///
/// Source: Warren, "Hacker's Delight", section 7-3.
pub fn transpose(bits: &mut [u64; 64]) {
    let (mut width, mut mask) = (32, 0xffff_ffffu64);
    while width != 0 {
        let mut k = 0;
        while k < bits.len() {
            let t = (bits[k] >> width ^ bits[k + width]) & mask;
            bits[k + width] ^= t;
            bits[k] ^= t << width;
            k = (k + width + 1) & !width;
        }
        width /= 2;
        mask ^= mask << width;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transposition_turns_rows_to_columns() {
        let rows: [u64; 64] =
            std::array::from_fn(|i| (i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let mut columns = rows;
        transpose(&mut columns);
        for (i, row) in rows.iter().enumerate() {
            for (j, column) in columns.iter().enumerate() {
                assert_eq!(row >> j & 1, column >> i & 1, "{i} {j}");
            }
        }
    }
}
