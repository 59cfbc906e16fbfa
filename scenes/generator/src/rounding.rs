//! Rounding of written numbers, so that the files are the same bytes on every platform.
//!
//! Sine, cosine and power functions may differ in the last bit between platforms. Rounding to a
//! much coarser step removes the difference.

/// Shift of the rounding threshold, as a fraction of a step. Values in a model are often exact
/// multiples of half a step; the shift makes such a tie round up even if its last bit differs.
const TIE_SHIFT: f64 = 3.1e-6;

/// `x` rounded to the nearest multiple of `1 / steps`. The result is never negative zero.
pub fn rounded(x: f64, steps: f64) -> f64 {
    (x * steps + 0.5 + TIE_SHIFT).floor() / steps + 0.0
}

/// `x` in decimal with at most five digits after the point and no trailing zeros.
pub fn decimal(x: f64) -> String {
    format!("{}", rounded(x, 1e5))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tie_rounds_up_even_if_its_last_bit_differs() {
        let tie: f64 = 0.00625;
        assert_eq!(rounded(tie.next_down(), 1e4), rounded(tie.next_up(), 1e4));
        assert_eq!(rounded(tie, 1e4), 0.0063);
    }

    #[test]
    fn zero_has_no_sign() {
        assert!(rounded(-1e-9, 1e4).is_sign_positive());
        assert_eq!(decimal(-1e-9), "0");
        assert_eq!(decimal(-1.25), "-1.25");
    }
}
