//! Trigonometric functions by short polynomials, for sampling: faster than correctly rounded library functions.
//!
//! Source of the coefficients: Moshier, "Methods and Programs for Mathematical Functions", 1989 (single precision).
//! Absolute errors are below 2e-7 for sine and cosine, below 4e-7 for angles (tested).

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// Sine and cosine of `x` radians, `|x| <= π/4`.
#[inline]
pub fn sin_cos_octant(x: f32) -> (f32, f32) {
    let x2 = x * x;
    let sin = (-1.951_529_6e-4 * x2 + 8.332_161e-3) * x2 - 1.666_665_5e-1;
    let cos = (2.443_315_7e-5 * x2 - 1.388_731_6e-3) * x2 + 4.166_664_6e-2;
    (x + x * x2 * sin, 1.0 - 0.5 * x2 + x2 * x2 * cos)
}

/// Sine and cosine of the angle of `x` full turns, `|x| < 2^20`.
#[inline]
pub fn sin_cos_turns(x: f32) -> (f32, f32) {
    // Adding and subtracting 1.5 · 2²³ rounds to the nearest integer.
    const ROUND: f32 = 12_582_912.0;
    let quarters = 4.0 * x;
    let nearest = (quarters + ROUND) - ROUND;
    let (sin, cos) = sin_cos_octant((quarters - nearest) * FRAC_PI_2);
    let quadrant = nearest as i32;
    let (sin, cos) = if quadrant & 1 == 0 {
        (sin, cos)
    } else {
        (cos, sin)
    };
    // Bit 1 of the quadrant is the sign of the sine; bit 1 of the next quadrant that of the cosine.
    let turned =
        |v: f32, quadrant: i32| f32::from_bits(v.to_bits() ^ ((quadrant as u32 & 2) << 30));
    (turned(sin, quadrant), turned(cos, quadrant + 1))
}

/// Angle of the point (`x`, `y`) in radians, in [-π, π]; 0 at the origin.
#[inline]
pub fn atan2(y: f32, x: f32) -> f32 {
    let (low, high) = (y.abs().min(x.abs()), y.abs().max(x.abs()));
    if high == 0.0 {
        return 0.0;
    }
    // tan(π/8): beyond it, measure from the diagonal.
    let beyond = low > 0.414_213_57 * high;
    let t = if beyond {
        (low - high) / (low + high)
    } else {
        low / high
    };
    let t2 = t * t;
    let series = ((8.053_744_5e-2 * t2 - 1.387_768_6e-1) * t2 + 1.997_771e-1) * t2 - 3.333_295e-1;
    let mut angle = t + t * t2 * series + if beyond { FRAC_PI_4 } else { 0.0 };
    if y.abs() > x.abs() {
        angle = FRAC_PI_2 - angle;
    }
    if x < 0.0 {
        angle = PI - angle;
    }
    angle.copysign(y)
}

/// [`atan2`] in full turns, in [-1/2, 1/2].
#[inline]
pub fn atan2_turns(y: f32, x: f32) -> f32 {
    atan2(y, x) * (1.0 / TAU)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_and_cosines() {
        for i in -40_000..=40_000 {
            let x = i as f32 / 10_000.0;
            let (sin, cos) = sin_cos_turns(x);
            let exact = (f64::from(x) * std::f64::consts::TAU).sin_cos();
            assert!((f64::from(sin) - exact.0).abs() < 2e-7, "sin({x})");
            assert!((f64::from(cos) - exact.1).abs() < 2e-7, "cos({x})");
            assert!((sin * sin + cos * cos - 1.0).abs() < 4e-7);
        }
    }

    #[test]
    fn angles() {
        for i in -1000..=1000 {
            for radius in [1e-10, 1.0, 1e10] {
                let angle = f64::from(i) / 1000.0 * std::f64::consts::PI;
                let (y, x) = (radius * angle.sin() as f32, radius * angle.cos() as f32);
                let exact = f64::from(y).atan2(f64::from(x));
                assert!((f64::from(atan2(y, x)) - exact).abs() < 4e-7, "{angle}");
            }
        }
        assert_eq!(atan2(0.0, 0.0), 0.0);
        assert_eq!(atan2(0.0, -2.0), PI);
        assert_eq!(atan2(3.0, 0.0), FRAC_PI_2);
    }
}
