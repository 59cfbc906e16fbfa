//! Rounding of all that is written, so that the files are the same bytes on every platform.
//!
//! Sine, cosine and powers may differ in the last bit from one platform's library to another's; rounded to a step far
//! coarser than that, they agree.

/// Shifts the border between two steps off the round numbers that designs are made of, so that a value which is half a
/// step in exact arithmetic rounds the same way whatever its last bit.
const OFF_TIES: f64 = 3.1e-6;

/// `x` rounded to a multiple of `1 / steps`, never negative zero.
pub fn rounded(x: f64, steps: f64) -> f64 {
    (x * steps + 0.5 + OFF_TIES).floor() / steps + 0.0
}

/// `x` as short decimal text with at most five digits after the point.
pub fn decimal(x: f64) -> String {
    format!("{}", rounded(x, 1e5))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ties_round_up_whatever_the_last_bit() {
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
