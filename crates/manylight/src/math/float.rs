//! Scalar helpers: roots, rounding, the exponential function.

/// The largest number below 1.
pub const ONE_MINUS_EPSILON: f32 = 1.0 - f32::EPSILON / 2.0;

/// `sqrt(max(x, 0))`, for values that only rounding makes negative.
#[inline]
pub fn safe_sqrt(x: f32) -> f32 {
    x.max(0.0).sqrt()
}

/// 1.5 · 2²³. Adding it to |x| < 2²² rounds x to the nearest integer, which the last bits of the
/// sum then hold.
const ROUNDING: f32 = 12_582_912.0;

/// `floor(x)` as a float and as an integer, for |x| < 2²². Free of calls, so that loops over it
/// vectorize.
#[inline(always)]
pub fn floor(x: f32) -> (f32, i32) {
    let sum = x + ROUNDING;
    let nearest = sum - ROUNDING;
    let integer = sum.to_bits() as i32 - ROUNDING.to_bits() as i32;
    if nearest > x {
        (nearest - 1.0, integer - 1)
    } else {
        (nearest, integer)
    }
}

/// `eˣ` with a relative error below 2e-7 for |x| < 87; 0 for x < -87, finite for x > 87. Free of
/// calls, so that loops over it vectorize.
///
/// `eˣ = 2ⁿ eʳ` with |r| <= ln 2 / 2, and the Taylor polynomial of degree 7 for eʳ.
#[inline(always)]
pub fn exp(x: f32) -> f32 {
    // ln 2 as a sum of two terms, so that n ln 2 keeps its precision.
    const LN2_HIGH: f32 = 0.693_359_4;
    const LN2_LOW: f32 = -2.121_944_4e-4;
    let within = if x > -87.0 { x } else { -87.0 };
    let within = if within < 88.0 { within } else { 88.0 };
    let sum = within * std::f32::consts::LOG2_E + ROUNDING;
    let n = sum - ROUNDING;
    let r = within - n * LN2_HIGH - n * LN2_LOW;
    let series = 1.0 / 120.0 + r * (1.0 / 720.0 + r * (1.0 / 5040.0));
    let series = 1.0 + r * (1.0 + r * (0.5 + r * (1.0 / 6.0 + r * (1.0 / 24.0 + r * series))));
    let power = f32::from_bits(
        sum.to_bits()
            .wrapping_sub(ROUNDING.to_bits())
            .wrapping_add(127)
            << 23,
    );
    if x < -87.0 { 0.0 } else { series * power }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floors_are_those_of_the_standard_library() {
        for i in -4000..=4000 {
            let x = i as f32 * 0.013;
            assert_eq!(floor(x), (x.floor(), x.floor() as i32), "at {x}");
        }
        assert_eq!(floor(-1.0), (-1.0, -1));
        assert_eq!(floor(31.5), (31.0, 31));
    }

    #[test]
    fn exponentials_are_those_of_the_standard_library() {
        for i in -8700..=8700 {
            let x = i as f32 * 0.01;
            let exact = f64::from(x).exp();
            assert!((f64::from(exp(x)) / exact - 1.0).abs() < 2e-7, "at {x}");
        }
        assert_eq!(exp(0.0), 1.0);
        assert_eq!(exp(-1e30), 0.0);
        assert_eq!(exp(f32::NEG_INFINITY), 0.0);
        assert!(exp(1e30).is_finite());
    }
}
