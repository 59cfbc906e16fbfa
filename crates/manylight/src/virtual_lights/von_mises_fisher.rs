//! Von Mises-Fisher lobes: `peak · exp(κ (μ·w - 1))` around a unit axis `μ`, and mixtures of them as they are stored.
//!
//! A light on a surface shines above its horizon alone, so the flux of a lobe is its integral over a half-space: the share of the
//! lobe above a plane times its integral over the sphere.

use crate::color::Rgb;
use crate::math::Vec3;
use crate::math::float::exp;
use crate::math::octahedral::{direction_from_square, square_from_direction};
use bytemuck::{Pod, Zeroable};
use std::f64::consts::{FRAC_PI_2, TAU};

/// `∫ exp(κ (μ·w - 1)) dw` over the sphere for `κ > 0`, in sr.
pub(super) fn solid_angle(kappa: f64) -> f64 {
    TAU * -(-2.0 * kappa).exp_m1() / kappa
}

/// Points of the Gauss-Legendre rule on [-1, 1], those above 0, and their weights.
/// Source: Abramowitz, Stegun, "Handbook of Mathematical Functions", 1964, table 25.4.
const RULE: [(f64, f64); 8] = [
    (0.095_012_509_837_637_44, 0.189_450_610_455_068_5),
    (0.281_603_550_779_258_9, 0.182_603_415_044_923_6),
    (0.458_016_777_657_227_4, 0.169_156_519_395_002_5),
    (0.617_876_244_402_643_7, 0.149_595_988_816_576_7),
    (0.755_404_408_355_003, 0.124_628_971_255_533_9),
    (0.865_631_202_387_831_7, 0.095_158_511_682_492_78),
    (0.944_575_023_073_232_6, 0.062_253_523_938_647_89),
    (0.989_400_934_991_649_9, 0.027_152_459_411_754_1),
];

/// Beyond so many standard deviations a lobe holds nothing.
const REACH: f64 = 6.5;

/// The share of a lobe of concentration `kappa` > 0 that lies above a plane, at the cosine between its axis and the plane's normal.
///
/// As the axis rises from the plane by `dα`, the horizon sweeps a lune that is `|cos φ| dα` wide, in which the lobe is
/// `exp(κ (cos α cos φ - 1))`. Its integral along the horizon is a Bessel function: the share is
/// `1/2 + 2π / solid_angle ∫₀^α e^-κ I₁(κ cos α') dα'`, of something like a Gaussian of width `1/√κ`.
pub(super) fn share_above(kappa: f64, cos: f64) -> f64 {
    let elevation = FRAC_PI_2 - cos.abs().min(1.0).acos();
    let half = 0.5 * elevation.min(REACH / kappa.sqrt());
    let sum: f64 = RULE
        .iter()
        .flat_map(|&(x, weight)| [(half * (1.0 - x), weight), (half * (1.0 + x), weight)])
        .map(|(angle, weight)| weight * swept(kappa, angle))
        .sum();
    0.5 + (half * sum).min(0.5).copysign(cos)
}

/// What the share above a plane grows by per radian, as the axis rises, at the angle `elevation` between axis and plane.
fn swept(kappa: f64, elevation: f64) -> f64 {
    let (sin, cos) = (0.5 * elevation).sin_cos();
    // 1 - cos of the angle, without loss of digits.
    let versine = 2.0 * sin * sin;
    let horizon = (-kappa * versine).exp() * bessel_i1_scaled(kappa * (2.0 * cos * cos - 1.0));
    TAU / solid_angle(kappa) * horizon
}

/// The share of a lobe below the plane with normal `n`, and the integral of the direction over that part.
///
/// The integral over the part above, of the unscaled lobe with parameter `κ μ`, has the integral of the direction as its gradient.
pub(super) fn part_below(axis: Vec3, kappa: f64, n: Vec3) -> (f64, Vec3) {
    let sin = f64::from(axis.dot(n).clamp(-1.0, 1.0));
    let elevation = sin.asin();
    if elevation * kappa.sqrt() > REACH {
        return (0.0, Vec3::ZERO);
    }
    const STEP: f64 = 0.01;
    let at = |kappa: f64| share_above(kappa, sin);
    let below = 1.0 - at(kappa);
    let by_kappa = (at(kappa * (1.0 + STEP)) - at(kappa * (1.0 - STEP))) / (2.0 * STEP * kappa);
    let mean = 1.0 / kappa.tanh() - 1.0 / kappa;
    let rise = (n - axis * sin as f32).normalize_or_zero();
    let along = below * mean - by_kappa;
    let down = swept(kappa, elevation.abs()) / kappa;
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

/// A lobe as it is stored, in 20 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Lobe {
    /// Place of the axis on the octahedral map, in units that divide its edge into 65535: good to 8e-5 rad.
    axis: [u16; 2],
    /// `κ`.
    kappa: f32,
    /// Radiant intensity along the axis, in W/sr.
    peak: Rgb,
}

const UNITS: f32 = u16::MAX as f32;

impl Lobe {
    /// A lobe that holds `flux` W over the sphere.
    pub(super) fn new(axis: Vec3, kappa: f32, flux: Rgb) -> Self {
        let place = square_from_direction(axis).to_array();
        Lobe {
            axis: place.map(|x| (x * UNITS).round() as u16),
            kappa,
            peak: flux / solid_angle(f64::from(kappa)) as f32,
        }
    }

    /// Flux above the horizon of `n`, or all, in W.
    pub(super) fn flux(&self, n: Option<Vec3>) -> Rgb {
        let kappa = f64::from(self.kappa);
        let share = n.map_or(1.0, |n| share_above(kappa, f64::from(self.axis().dot(n))));
        self.peak * (share * solid_angle(kappa)) as f32
    }

    /// Its colour times `factor`.
    pub(super) fn scaled(self, factor: Rgb) -> Self {
        Lobe {
            peak: self.peak * factor,
            ..self
        }
    }

    /// `μ`.
    #[inline(always)]
    pub(crate) fn axis(&self) -> Vec3 {
        direction_from_square(self.axis.map(|x| f32::from(x) / UNITS).into())
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

    /// Radiant intensity towards the unit vector `w`, in W/sr.
    ///
    /// Half the square of the distance is `1 - μ·w` without loss of digits near the axis.
    fn intensity(&self, w: Vec3) -> Rgb {
        let apart = (w - self.axis()).length_squared();
        self.peak * exp(-0.5 * self.kappa * apart)
    }
}

/// The sum of some lobes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mixture<'a> {
    pub(crate) lobes: &'a [Lobe],
}

impl Mixture<'_> {
    /// Radiant intensity towards the unit vector `w`, horizon not counted, in W/sr.
    pub(super) fn lookup(&self, w: Vec3) -> Rgb {
        self.lobes.iter().map(|lobe| lobe.intensity(w)).sum()
    }
}

/// Mixtures of as many lobes each, one after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct Mixtures {
    count: usize,
    lobes: Vec<Lobe>,
}

impl Mixtures {
    /// No mixtures so far; they will have `count` lobes each.
    pub(super) fn new(count: usize) -> Self {
        Mixtures {
            count,
            lobes: Vec::new(),
        }
    }

    /// Makes room for exactly so many mixtures.
    pub(super) fn reserve(&mut self, mixtures: usize) {
        self.lobes.reserve_exact(mixtures * self.count);
    }

    /// Appends a mixture and returns its index.
    pub(super) fn push(&mut self, lobes: &[Lobe]) -> u32 {
        let index = self.lobes.len() / self.count;
        self.lobes.extend_from_slice(lobes);
        self.lobes.resize((index + 1) * self.count, Lobe::default());
        index as u32
    }

    /// The mixture with the given index.
    #[inline(always)]
    pub(super) fn get(&self, index: u32) -> Mixture<'_> {
        Mixture {
            lobes: &self.lobes[index as usize * self.count..][..self.count],
        }
    }

    /// Bytes of one mixture.
    pub(super) fn bytes_per_mixture(count: usize) -> usize {
        count * size_of::<Lobe>()
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.lobes.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Frame, Vec2};
    use crate::sampling::warp::von_mises_fisher;

    /// Rings around the axis, the part of each above the plane in closed form, in so many steps that nothing is missed.
    fn share_by_rings(kappa: f64, cos: f64) -> f64 {
        let sin = (1.0 - cos * cos).sqrt();
        let count = 400_000;
        let mut sum = 0.0;
        for i in 0..count {
            // Over equal shares of the lobe.
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
    fn shares_above_a_plane_are_those_of_quadrature() {
        for kappa in [0.1, 0.5, 1.0, 3.0, 10.0, 50.0, 200.0, 1e3, 1e4] {
            for i in -24..=24 {
                // Closer together where narrow lobes cross the plane.
                let elevation = FRAC_PI_2 * (f64::from(i) / 24.0).powi(3);
                let cos = elevation.sin();
                let (share, expected) = (share_above(kappa, cos), share_by_rings(kappa, cos));
                assert!(
                    (share - expected).abs() < 2e-5,
                    "kappa {kappa}, {elevation} rad: {share}, not {expected}"
                );
            }
            let upright = 1.0 / (1.0 + (-kappa).exp());
            assert!((share_above(kappa, 1.0) - upright).abs() < 2e-6);
            assert_eq!(share_above(kappa, 0.0), 0.5);
        }
    }

    #[test]
    fn parts_below_a_plane_are_those_of_quadrature() {
        // The shares are told by whole rows of samples.
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
    fn lobes_are_stored_closely() {
        let mut rng = crate::sampling::rng::Pcg::new(3);
        for _ in 0..10_000 {
            let u = crate::math::Vec2::new(rng.next_f32(), rng.next_f32());
            let axis = crate::sampling::warp::sphere(u);
            let lobe = Lobe::new(axis, 50.0, Rgb::new(1.0, 2.0, 3.0));
            assert!((lobe.axis() - axis).length() < 8e-5, "{axis}");
            let flux = lobe.flux(None);
            assert!((flux - Rgb::new(1.0, 2.0, 3.0)).max_channel().abs() < 1e-5);
        }
        assert_eq!(size_of::<Lobe>(), 20);
    }
}
