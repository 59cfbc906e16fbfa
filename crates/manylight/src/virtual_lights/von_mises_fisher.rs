//! Von Mises-Fisher lobes `peak · exp(κ (μ·w - 1))` with unit axis `μ` and concentration `κ`, their
//! integrals, and stored mixtures.
//!
//! A light on a surface emits above its horizon only, so the flux of a lobe is its integral over a
//! hemisphere: the integral over the sphere times the fraction of the lobe above a plane.

use crate::arrays::{
    Fields, FoundArray, InvalidArray, NamedArray, Record, arrays_of_records, records_of_arrays,
};
use crate::color::Rgb;
use crate::lanes::{Color, Vector, Width};
use crate::math::octahedral::{direction_from_square, square_from_direction};
use crate::math::{Vec2, Vec3};
use bytemuck::{Pod, Zeroable};
use std::f64::consts::{FRAC_PI_2, TAU};

/// `∫ exp(κ (μ·w - 1)) dw` over the sphere for `κ > 0`, in sr.
pub(super) fn solid_angle(kappa: f64) -> f64 {
    TAU * -(-2.0 * kappa).exp_m1() / kappa
}

/// The positive half of the 16 points of the Gauss-Legendre rule on [-1, 1], with weights.
/// Source: Abramowitz, Stegun, "Handbook of Mathematical Functions", 1964, table 25.4.
const GAUSS_LEGENDRE: [(f64, f64); 8] = [
    (0.095_012_509_837_637_44, 0.189_450_610_455_068_5),
    (0.281_603_550_779_258_9, 0.182_603_415_044_923_6),
    (0.458_016_777_657_227_4, 0.169_156_519_395_002_5),
    (0.617_876_244_402_643_7, 0.149_595_988_816_576_7),
    (0.755_404_408_355_003, 0.124_628_971_255_533_9),
    (0.865_631_202_387_831_7, 0.095_158_511_682_492_78),
    (0.944_575_023_073_232_6, 0.062_253_523_938_647_89),
    (0.989_400_934_991_649_9, 0.027_152_459_411_754_1),
];

/// Distance from the axis, in standard deviations `1/√κ`, beyond which a lobe is taken as 0: the
/// density there is e^-21 of the peak.
const CUTOFF: f64 = 6.5;

/// Fraction of a lobe with concentration `kappa` > 0 above a plane, for the cosine `cos` between
/// the axis and the normal of the plane.
///
/// With the axis at elevation `α`, the fraction is
///
/// ```text
/// 1/2 + 2π / solid_angle(κ) ∫₀^α e^-κ I₁(κ cos α') dα'
/// ```
///
/// Derivation: as the axis rises by `dα`, the horizon sweeps a lune of width `|cos φ| dα`, in which
/// the lobe is `exp(κ (cos α cos φ - 1))`; the integral along the horizon is the Bessel function.
/// The integrand is close to a Gaussian of width `1/√κ`.
pub(super) fn fraction_above(kappa: f64, cos: f64) -> f64 {
    let elevation = FRAC_PI_2 - cos.abs().min(1.0).acos();
    let half = 0.5 * elevation.min(CUTOFF / kappa.sqrt());
    let sum: f64 = GAUSS_LEGENDRE
        .iter()
        .flat_map(|&(x, weight)| [(half * (1.0 - x), weight), (half * (1.0 + x), weight)])
        .map(|(angle, weight)| weight * fraction_derivative(kappa, angle))
        .sum();
    0.5 + (half * sum).min(0.5).copysign(cos)
}

/// Derivative of [`fraction_above`] by the elevation of the axis, per radian, at the angle
/// `elevation` between axis and plane.
fn fraction_derivative(kappa: f64, elevation: f64) -> f64 {
    let (sin, cos) = (0.5 * elevation).sin_cos();
    // 1 - cos(elevation), without cancellation.
    let versine = 2.0 * sin * sin;
    let horizon = (-kappa * versine).exp() * bessel_i1_scaled(kappa * (2.0 * cos * cos - 1.0));
    TAU / solid_angle(kappa) * horizon
}

/// Fraction of a lobe below the plane with unit normal `n`, and the integral of the direction over
/// that part of the normalized lobe.
///
/// The latter follows from a derivative: the gradient by `κ μ` of the integral of `exp(κ μ·w)` is
/// the integral of `w exp(κ μ·w)`.
pub(super) fn part_below(axis: Vec3, kappa: f64, n: Vec3) -> (f64, Vec3) {
    let sin = f64::from(axis.dot(n).clamp(-1.0, 1.0));
    let elevation = sin.asin();
    if elevation * kappa.sqrt() > CUTOFF {
        return (0.0, Vec3::ZERO);
    }
    const STEP: f64 = 0.01;
    let at = |kappa: f64| fraction_above(kappa, sin);
    let below = 1.0 - at(kappa);
    let by_kappa = (at(kappa * (1.0 + STEP)) - at(kappa * (1.0 - STEP))) / (2.0 * STEP * kappa);
    let mean = 1.0 / kappa.tanh() - 1.0 / kappa;
    let rise = (n - axis * sin as f32).normalize_or_zero();
    let along = below * mean - by_kappa;
    let down = fraction_derivative(kappa, elevation.abs()) / kappa;
    (below, axis * along as f32 - rise * down as f32)
}

/// `e^-x I₁(x)` for `x >= 0`, with a relative error below 1e-6.
/// Source: Abramowitz, Stegun, "Handbook of Mathematical Functions", 1964, 9.8.3 and 9.8.4.
fn bessel_i1_scaled(x: f64) -> f64 {
    let horner = |terms: &[f64], t: f64| terms.iter().rev().fold(0.0, |sum, c| sum * t + c);
    if x < 3.75 {
        const TERMS: [f64; 7] = [
            0.5,
            0.878_905_94,
            0.514_988_69,
            0.150_849_34,
            0.026_587_33,
            0.003_015_32,
            0.000_324_11,
        ];
        x * horner(&TERMS, (x / 3.75).powi(2)) * (-x).exp()
    } else {
        const TERMS: [f64; 9] = [
            0.398_942_28,
            -0.039_880_24,
            -0.003_620_18,
            0.001_638_01,
            -0.010_315_55,
            0.022_829_67,
            -0.028_953_12,
            0.017_876_54,
            -0.004_200_59,
        ];
        horner(&TERMS, 3.75 / x) / x.sqrt()
    }
}

/// A stored lobe, 20 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct VmfLobe {
    /// Position of the axis on the octahedral map, in units of 1/65535 of its edge: exact to 8e-5
    /// rad.
    axis: [u16; 2],
    /// `κ`.
    kappa: f32,
    /// Radiant intensity along the axis, in W/sr.
    peak: Rgb,
}

/// Begin of the names of the arrays of lobes.
const ARRAYS: &str = "lobes.";

impl Record for VmfLobe {
    const EMPTY: Self = VmfLobe {
        axis: [0; 2],
        kappa: 0.0,
        peak: Rgb::BLACK,
    };

    fn fields(&mut self, f: &mut impl Fields) {
        f.word("axis_x", &mut self.axis[0]);
        f.word("axis_y", &mut self.axis[1]);
        f.float("kappa", &mut self.kappa);
        f.rgb("peak", &mut self.peak);
    }
}

/// Units of [`VmfLobe::axis`] along an edge of the octahedral map.
const UNITS: f32 = u16::MAX as f32;

impl VmfLobe {
    /// A lobe with the integral `flux`, in W, over the sphere.
    pub(super) fn new(axis: Vec3, kappa: f32, flux: Rgb) -> Self {
        let place = square_from_direction(axis).to_array();
        VmfLobe {
            axis: place.map(|x| (x * UNITS).round() as u16),
            kappa,
            peak: flux / solid_angle(f64::from(kappa)) as f32,
        }
    }

    /// Flux above the horizon of the unit normal `n`, or over the sphere, in W.
    pub(super) fn flux(&self, n: Option<Vec3>) -> Rgb {
        let kappa = f64::from(self.kappa);
        let fraction = n.map_or(1.0, |n| {
            fraction_above(kappa, f64::from(self.axis().dot(n)))
        });
        self.peak * (fraction * solid_angle(kappa)) as f32
    }

    /// The lobe with its intensity times `factor`, per channel.
    pub(super) fn scaled(self, factor: Rgb) -> Self {
        VmfLobe {
            peak: self.peak * factor,
            ..self
        }
    }

    /// `μ`.
    #[inline(always)]
    pub(crate) fn axis(&self) -> Vec3 {
        let [x, y] = self.axis;
        direction_from_square(Vec2::new(x.into(), y.into()) / UNITS)
    }

    /// `κ`.
    #[inline(always)]
    pub(crate) fn kappa(&self) -> f32 {
        self.kappa
    }

    /// Radiant intensity along the axis, in W/sr.
    #[inline(always)]
    pub(crate) fn peak(&self) -> Rgb {
        self.peak
    }
}

/// A sum of lobes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VmfMixture<'a> {
    pub(crate) lobes: &'a [VmfLobe],
}

impl VmfMixture<'_> {
    /// Radiant intensity in the unit directions `w`, in W/sr, also below the horizon. Computes
    /// `1 - μ·w` as `|w - μ|²/2`, without cancellation near the axis.
    #[inline(always)]
    pub(super) fn lookup<S: Width>(&self, w: Vector<S>) -> Color<S> {
        let s = w.z.width();
        let mut sum = Color::black(s);
        for lobe in self.lobes {
            let apart = w - Vector::splat(s, lobe.axis());
            let value = (apart.length_squared() * (-0.5 * lobe.kappa)).exp();
            let peak = Color::splat(s, lobe.peak);
            sum = peak.zip(sum, |peak, sum| peak.mul_add(value, sum));
        }
        sum
    }
}

/// Mixtures with one number of lobes, one after the other; missing lobes are black.
#[derive(Clone, Debug, Default)]
pub(super) struct VmfMixtures {
    count: usize,
    lobes: Vec<VmfLobe>,
}

impl VmfMixtures {
    /// An empty store of mixtures of `count` lobes.
    pub(super) fn new(count: usize) -> Self {
        VmfMixtures {
            count,
            lobes: Vec::new(),
        }
    }

    /// Reserves memory for exactly this many more mixtures.
    pub(super) fn reserve(&mut self, mixtures: usize) {
        self.lobes.reserve_exact(mixtures * self.count);
    }

    /// Appends a mixture of at most `count` lobes and returns its index.
    pub(super) fn push(&mut self, lobes: &[VmfLobe]) -> u32 {
        let index = self.lobes.len() / self.count;
        self.lobes.extend_from_slice(lobes);
        self.lobes
            .resize((index + 1) * self.count, VmfLobe::default());
        index as u32
    }

    /// The mixture with the given index.
    #[inline(always)]
    pub(super) fn get(&self, index: u32) -> VmfMixture<'_> {
        VmfMixture {
            lobes: &self.lobes[index as usize * self.count..][..self.count],
        }
    }

    /// Number of mixtures.
    pub(super) fn len(&self) -> usize {
        self.lobes.len() / self.count
    }

    /// As arrays, with a row for each lobe.
    pub(super) fn arrays(&self) -> Vec<NamedArray<'_>> {
        arrays_of_records(ARRAYS, &self.lobes[..])
    }

    /// The inverse of [`VmfMixtures::arrays`], for mixtures of `count` lobes.
    ///
    /// # Errors
    /// Those of `read`, and mixtures of another size.
    pub(super) fn of_arrays<E: From<InvalidArray>>(
        count: usize,
        read: &mut impl FnMut(&str) -> Result<FoundArray, E>,
    ) -> Result<Self, E> {
        let lobes: Vec<VmfLobe> = records_of_arrays(ARRAYS, read)?;
        match lobes.len().is_multiple_of(count) {
            true => Ok(VmfMixtures { count, lobes }),
            false => {
                let message = format!("found {} lobes, expected {count} per light", lobes.len());
                Err(InvalidArray::new(ARRAYS, message).into())
            }
        }
    }

    /// Bytes of one mixture.
    pub(super) fn bytes_per_mixture(count: usize) -> usize {
        count * size_of::<VmfLobe>()
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.lobes.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Frame;
    use crate::sampling::warp::von_mises_fisher;

    /// Quadrature over rings around the axis, with the fraction of each ring above the plane in
    /// closed form.
    fn fraction_by_rings(kappa: f64, cos: f64) -> f64 {
        let sin = (1.0 - cos * cos).sqrt();
        let count = 400_000;
        let mut sum = 0.0;
        for i in 0..count {
            // Rings of equal integrals of the lobe.
            let u = (i as f64 + 0.5) / count as f64;
            let t = 1.0 + (u + (1.0 - u) * (-2.0 * kappa).exp()).ln() / kappa;
            let t = t.clamp(-1.0, 1.0);
            let ring = (1.0 - t * t).sqrt() * sin;
            let level = t * cos;
            sum += if level >= ring {
                1.0
            } else if level <= -ring {
                0.0
            } else {
                1.0 - (level / ring).acos() / std::f64::consts::PI
            };
        }
        sum / f64::from(count)
    }

    #[test]
    fn fractions_above_a_plane_agree_with_quadrature() {
        for kappa in [0.1, 0.5, 1.0, 3.0, 10.0, 50.0, 200.0, 1e3, 1e4] {
            for i in -24..=24 {
                // Closer together where narrow lobes cross the plane.
                let elevation = FRAC_PI_2 * (f64::from(i) / 24.0).powi(3);
                let cos = elevation.sin();
                let (share, expected) = (fraction_above(kappa, cos), fraction_by_rings(kappa, cos));
                assert!(
                    (share - expected).abs() < 2e-5,
                    "kappa {kappa}, {elevation} rad: {share}, not {expected}"
                );
            }
            let upright = 1.0 / (1.0 + (-kappa).exp());
            assert!((fraction_above(kappa, 1.0) - upright).abs() < 2e-6);
            assert_eq!(fraction_above(kappa, 0.0), 0.5);
        }
    }

    #[test]
    fn parts_below_a_plane_agree_with_quadrature() {
        // The horizon is resolved by whole rows of samples only.
        for kappa in [0.05f32, 1.0, 7.0, 300.0] {
            for elevation in [-1.5f32, -0.4, -0.05, 0.0, 0.02, 0.3, 1.2] {
                let axis = Vec3::new(elevation.cos(), 0.0, elevation.sin());
                let (mut share, mut direction) = (0.0f64, [0.0f64; 3]);
                let n = 1000;
                for i in 0..n * n {
                    let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
                    let local = von_mises_fisher(u, kappa);
                    let w = Frame::from_normal(axis).to_world(local);
                    if w.z < 0.0 {
                        share += 1.0 / f64::from(n * n);
                        for axis in 0..3 {
                            direction[axis] += f64::from(w[axis]) / f64::from(n * n);
                        }
                    }
                }
                let (got, got_direction) = part_below(axis, f64::from(kappa), Vec3::Z);
                assert!(
                    (got - share).abs() < 1e-3,
                    "{kappa} {elevation}: {got} {share}"
                );
                for axis in 0..3 {
                    let off = f64::from(got_direction[axis]) - direction[axis];
                    assert!(
                        off.abs() < 1e-3,
                        "{kappa} {elevation}: {got_direction} {direction:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn stored_lobes_are_close() {
        let mut rng = crate::sampling::rng::Pcg::new(3);
        for _ in 0..10_000 {
            let u = crate::math::Vec2::new(rng.next_f32(), rng.next_f32());
            let axis = crate::sampling::warp::sphere(u);
            let lobe = VmfLobe::new(axis, 50.0, Rgb::new(1.0, 2.0, 3.0));
            assert!((lobe.axis() - axis).length() < 8e-5, "{axis}");
            let flux = lobe.flux(None);
            assert!((flux - Rgb::new(1.0, 2.0, 3.0)).max_channel().abs() < 1e-5);
        }
        assert_eq!(size_of::<VmfLobe>(), 20);
    }
}
