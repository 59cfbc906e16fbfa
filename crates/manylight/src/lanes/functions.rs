//! Elementary functions and warps in lanes: [`crate::math`] and [`crate::sampling::warp`] for
//! [`Float`].

use super::numbers::{Float, ROUNDING, Word};
use super::vector::{Pair, Vector};
use crate::simd::Width;
use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, LN_2, PI, TAU};

impl<S: Width> Float<S> {
    /// See [`exp`](crate::math::float::exp).
    #[inline(always)]
    pub fn exp(self) -> Self {
        // ln 2 as a sum of two terms, so that n ln 2 keeps its precision.
        const LN2_HIGH: f32 = 0.693_359_4;
        const LN2_LOW: f32 = -2.121_944_4e-4;
        let within = self.max(-87.0).min(88.0);
        let sum = within * std::f32::consts::LOG2_E + ROUNDING;
        let n = sum - ROUNDING;
        let r = within - n * LN2_HIGH - n * LN2_LOW;
        let series = 1.0 / 120.0 + r * (1.0 / 720.0 + r * (1.0 / 5040.0));
        let series = 1.0 + r * (1.0 + r * (0.5 + r * (1.0 / 6.0 + r * (1.0 / 24.0 + r * series))));
        let power = ((sum.to_bits() - ROUNDING.to_bits() + 127) << 23).to_float();
        self.lt(-87.0).select(0.0, series * power)
    }

    /// Natural logarithm of a normal positive number, with an absolute error below 1e-7 plus a
    /// relative error below 2e-7; a finite number below -87 for 0.
    ///
    /// `ln x = n ln 2 + ln m` with m in [√½, √2), and `ln m = 2 artanh((m - 1) / (m + 1))` by its
    /// Taylor polynomial.
    #[inline(always)]
    pub fn ln(self) -> Self {
        /// Bits of √½.
        const SQRT_HALF: u32 = 0x3f35_04f3;
        let bits = self.max(f32::MIN_POSITIVE).to_bits();
        // The bits beyond those of √½: the exponent relative to that, which may be negative, above
        // the mantissa.
        let beyond = bits - SQRT_HALF + (128 << 23);
        let m = ((beyond & 0x007f_ffff) + SQRT_HALF).to_float();
        let n = ((beyond >> 23) + ROUNDING.to_bits()).to_float() - ROUNDING - 128.0;
        let t = (m - 1.0) / (m + 1.0);
        let t2 = t * t;
        let series = 2.0 / 3.0 + t2 * (2.0 / 5.0 + t2 * (2.0 / 7.0 + t2 * (2.0 / 9.0)));
        n * LN_2 + (2.0 * t + t * t2 * series)
    }

    /// `self` to the power `y`, for a positive normal base; 0 for 0 and a positive power. The
    /// relative error grows in proportion to the logarithm of the result.
    #[inline(always)]
    pub fn powf(self, y: Self) -> Self {
        self.le(0.0).select(0.0, (self.ln() * y).exp())
    }

    /// The angle in [0, π] of a cosine in [-1, 1], with an absolute error below 4e-7.
    ///
    /// `acos x = √(1 - x) p(x)` on [0, 1]; the coefficients are Hastings' in Abramowitz and Stegun,
    /// "Handbook of Mathematical Functions", 4.4.46.
    #[inline(always)]
    pub fn acos(self) -> Self {
        const COEFFICIENTS: [f32; 8] = [
            -0.001_262_491_1,
            0.006_670_09,
            -0.017_088_126,
            0.030_891_88,
            -0.050_174_305,
            0.088_978_99,
            -0.214_598_8,
            FRAC_PI_2,
        ];
        let x = self.abs();
        let series = COEFFICIENTS
            .into_iter()
            .fold(x.same(0.0), |sum, c| sum * x + c);
        let angle = (1.0 - x).safe_sqrt() * series;
        self.lt(0.0).select(PI - angle, angle)
    }

    /// The largest integer that is not larger, for |x| < 2²².
    #[inline(always)]
    pub fn floor(self) -> Self {
        let nearest = (self + ROUNDING) - ROUNDING;
        nearest.gt(self).select(nearest - 1.0, nearest)
    }

    /// The integer that the value is, for 0 <= x < 2²².
    #[inline(always)]
    pub fn to_word(self) -> Word<S> {
        (self + ROUNDING).to_bits() - ROUNDING.to_bits()
    }

    /// Angle of the point (`x`, `self`) in full turns, in [-1/2, 1/2]; 0 at the origin.
    #[inline(always)]
    pub fn atan2_turns(self, x: Self) -> Self {
        let (low, high) = (self.abs().min(x.abs()), self.abs().max(x.abs()));
        // tan(π/8): beyond it, measure from the diagonal.
        let beyond = low.gt(high * 0.414_213_57);
        let t = beyond.select(low - high, low) / beyond.select(low + high, high);
        let t2 = t * t;
        let series = (t2 * 8.053_744_5e-2 - 1.387_768_6e-1) * t2 + 1.997_771e-1;
        let series = series * t2 - 3.333_295e-1;
        let angle = t + t * t2 * series + beyond.select(FRAC_PI_4, 0.0);
        let angle = self.abs().gt(x.abs()).select(FRAC_PI_2 - angle, angle);
        let angle = x.lt(0.0).select(PI - angle, angle);
        let angle = high.equals(0.0).select(0.0, angle.copysign(self));
        angle * (1.0 / TAU)
    }

    /// Sine and cosine of an angle of this many radians, up to π/4.
    #[inline(always)]
    pub fn sin_cos_octant(self) -> (Self, Self) {
        let x2 = self * self;
        let sin = (x2 * -1.951_529_6e-4 + 8.332_161e-3) * x2 - 1.666_665_5e-1;
        let cos = (x2 * 2.443_315_7e-5 - 1.388_731_6e-3) * x2 + 4.166_664_6e-2;
        (self + self * x2 * sin, 1.0 - 0.5 * x2 + x2 * x2 * cos)
    }

    /// Sine and cosine of an angle of this many full turns `x`, `|x| < 2^20`.
    #[inline(always)]
    pub fn sin_cos_turns(self) -> (Self, Self) {
        let quarters = 4.0 * self;
        let sum = quarters + ROUNDING;
        let (sin, cos) = ((quarters - (sum - ROUNDING)) * FRAC_PI_2).sin_cos_octant();
        let quadrant = sum.to_bits() - ROUNDING.to_bits();
        let is_even = (quadrant & 1).equals(0);
        let (sin, cos) = (is_even.select(sin, cos), is_even.select(cos, sin));
        // Bit 1 of the quadrant is the sign of the sine; bit 1 of the next quadrant that of the
        // cosine.
        let turned =
            |v: Float<S>, quadrant: Word<S>| (v.to_bits() ^ ((quadrant & 2) << 30)).to_float();
        (turned(sin, quadrant), turned(cos, quadrant + 1))
    }
}

/// See [`warp::disc`](crate::sampling::warp::disc).
#[inline(always)]
pub(crate) fn disc<S: Width>(u: Pair<S>) -> Pair<S> {
    let (x, y) = (u.x * 2.0 - 1.0, u.y * 2.0 - 1.0);
    // Angles relative to the nearer axis stay within an octant.
    let along_x = x.abs().gt(y.abs());
    let (r, across) = (along_x.select(x, y), along_x.select(y, x));
    let at_center = r.equals(0.0);
    let (sin, cos) = (across / at_center.select(1.0, r) * FRAC_PI_4).sin_cos_octant();
    Pair::new(along_x.select(cos, sin), along_x.select(sin, cos)) * r
}

/// See [`warp::cosine_hemisphere`](crate::sampling::warp::cosine_hemisphere).
#[inline(always)]
pub(crate) fn cosine_hemisphere<S: Width>(u: Pair<S>) -> Vector<S> {
    let d = disc(u);
    Vector::new(d.x, d.y, (1.0 - d.length_squared()).safe_sqrt())
}

/// Density of [`cosine_hemisphere`] per solid angle.
#[inline(always)]
pub(crate) fn cosine_hemisphere_pdf<S: Width>(cos: Float<S>) -> Float<S> {
    cos.max(0.0) * FRAC_1_PI
}
