//! Glossy form 2: a mixture of von Mises-Fisher lobes, fitted to weighted directions by expectation
//! maximization.
//!
//! Directions are sampled from the lobes of the paths; 512 of them describe a lobe about as well as
//! a table of 32 x 32 texels, without its blur.
//!
//! Source: Banerjee, Dhillon, Ghosh, Sra, "Clustering on the Unit Hypersphere using von
//! Mises-Fisher Distributions", 2005; here with sample weights, an initialization by k-means++
//! (Arthur, Vassilvitskii, 2007), a prior that widens lobes of few samples, and with the part of
//! each lobe below the horizon as missing data. Without the latter, lobes near the horizon come out
//! too narrow, as emission is cut at the horizon a second time.

#[cfg(test)]
mod tests;

use super::reflection::{EmissionDomain, Reflection, scatter_all};
use super::von_mises_fisher::{VmfLobe, part_below, solid_angle};
use crate::color::Rgb;
use crate::lanes::{Color, Float, LANES, Lanes3, Sixteen, Vector};
use crate::math::Vec3;
use crate::sampling::rng::Pcg;
use crate::simd::{Isa, Simd, SimdKernel};

/// Largest number of lobes of a mixture.
pub(super) const MAX_LOBES: usize = 8;
/// Number of directions sampled for a fit.
const SAMPLES: u32 = 512;
/// Largest number of steps of expectation and maximization. At 20 and 80 (2 passes with `--emission
/// vmf` at 72x40, 3 seeds; Glossy Room, Kitchen): pictures differ by at most 0.5 % (RMS).
const MAX_STEPS: usize = 40;
/// Change per step below which the fit has converged: absolute for mixture weights, relative for
/// concentrations. At 0.005 and 0.02 (2 passes with `--emission vmf` at 72x40, 3 seeds; Glossy
/// Room, Kitchen): pictures differ by at most 0.3 % (RMS).
const CONVERGENCE: f32 = 0.01;
/// Weight of the prior on the mean cosine (with mean 0), in units of the mean sample: bounds the
/// concentration of lobes of few samples. At 0.05 and 0.2 (2 passes with `--emission vmf` at 72x40,
/// 3 seeds; Glossy Room, Kitchen): pictures differ by at most 0.3 % (RMS).
const PRIOR: f32 = 0.1;
/// Smallest mixture weight in the expectation step, so that no lobe loses all of its samples. At
/// 0.0005 and 0.002 (2 passes with `--emission vmf` at 72x40, 3 seeds; Glossy Room, Kitchen): the
/// same picture.
const MIN_WEIGHT: f32 = 1e-3;
/// Largest concentration times the square of the roughness. A reflected lobe has about 1 at its
/// peak, and more at grazing angles.
const MAX_KAPPA_ALPHA2: f32 = 4.0;
/// Smallest concentration: an almost uniform lobe.
const MIN_KAPPA: f32 = 1e-2;
/// Smallest exponent of a density in the expectation step, so that no density vanishes.
const LOWEST_EXPONENT: f32 = -60.0;

/// A mixture of at most `count` lobes with the shape of what `paths` scatter into `domain`, scaled
/// per channel to the flux `target`; and the flux that it holds there, both in W. `roughness` is
/// the smallest of the paths' lobes.
pub(super) fn fit_mixture(
    count: usize,
    paths: &[Reflection],
    roughness: f32,
    domain: EmissionDomain,
    target: Rgb,
    rng: &mut Pcg,
) -> (Vec<VmfLobe>, Rgb) {
    let mut samples = WeightedDirections::default();
    scatter_all(paths, SAMPLES, rng, |w, flux| {
        if domain.contains(w) {
            samples.all.push((w, flux));
        }
    });
    let n = domain.horizon();
    let fitted = samples.fit(count, MAX_KAPPA_ALPHA2 / (roughness * roughness), n, rng);
    let lobes: Vec<VmfLobe> = fitted.iter().map(|c| c.lobe(n)).collect();
    let flux = |lobes: &[VmfLobe]| -> Rgb { lobes.iter().map(|lobe| lobe.flux(n)).sum() };
    let factor = target.zip(flux(&lobes), |target, flux| match flux > 0.0 {
        true => target / flux,
        false => 0.0,
    });
    let lobes: Vec<VmfLobe> = lobes.iter().map(|lobe| lobe.scaled(factor)).collect();
    let held = flux(&lobes);
    (lobes, held)
}

/// One component of a mixture during the fit.
#[derive(Clone, Copy, Debug)]
struct Component {
    /// `μ`, unit.
    axis: Vec3,
    /// `κ`.
    kappa: f32,
    /// Flux of the samples, weighted by the responsibility of this component.
    flux: Rgb,
    /// Mixture weight: luminance of `flux` and of the missing part below the horizon, relative to
    /// all samples.
    weight: f32,
}

impl Component {
    /// See [`part_below`].
    fn below(&self, n: Vec3) -> (f32, Vec3) {
        let (fraction, direction) = part_below(self.axis, f64::from(self.kappa), n);
        (fraction as f32, direction)
    }

    /// The lobe to store, with this flux above the horizon of `n`.
    fn lobe(&self, n: Option<Vec3>) -> VmfLobe {
        let below = n.map_or(0.0, |n| self.below(n).0);
        VmfLobe::new(self.axis, self.kappa, self.flux / (1.0 - below))
    }
}

/// Unit directions, each with its flux in W.
#[derive(Clone, Debug, Default)]
struct WeightedDirections {
    all: Vec<(Vec3, Rgb)>,
}

impl WeightedDirections {
    /// Fits at most `count` lobes to the samples, of which those below the horizon of `n` are
    /// missing. Concentrations are at most `max_kappa`. Empty if no sample has flux.
    fn fit(&self, count: usize, max_kappa: f32, n: Option<Vec3>, rng: &mut Pcg) -> Vec<Component> {
        let total: f32 = self.all.iter().map(|(_, flux)| flux.luminance()).sum();
        if total.is_nan() || total <= 0.0 {
            return Vec::new();
        }
        let samples = self.in_lanes(1.0 / total);
        let prior = PRIOR / self.all.len() as f32;
        let mut components = self.initial_components(count, max_kappa, rng);
        for _ in 0..MAX_STEPS {
            let next = em_step(&samples, &components, n, prior, max_kappa);
            let converged = components.iter().zip(&next).all(|(a, b)| {
                (a.weight - b.weight).abs() < CONVERGENCE
                    && (a.kappa - b.kappa).abs() < CONVERGENCE * b.kappa
            });
            components = next;
            if converged {
                break;
            }
        }
        for component in &mut components {
            component.flux *= total;
        }
        components
    }

    /// Directions and fluxes times `scale` in groups of [`LANES`], the last one filled with black
    /// samples.
    fn in_lanes(&self, scale: f32) -> Vec<[Lanes3; 2]> {
        let group = |chunk: &[(Vec3, Rgb)]| {
            let mut lanes = [Lanes3::ZERO; 2];
            for i in 0..LANES {
                let (w, flux) = chunk.get(i).copied().unwrap_or((Vec3::Z, Rgb::BLACK));
                lanes[0].set(i, w);
                lanes[1].set(i, (flux * scale).to_array());
            }
            lanes
        };
        self.all.chunks(LANES).map(group).collect()
    }

    /// Initial lobes by k-means++: axes are samples drawn in proportion to luminance times the
    /// squared distance to the nearest previous axis.
    fn initial_components(&self, count: usize, max_kappa: f32, rng: &mut Pcg) -> Vec<Component> {
        let mut weights: Vec<f32> = self.all.iter().map(|(_, flux)| flux.luminance()).collect();
        let total: f32 = weights.iter().sum();
        // 1 - μ·w for the nearest axis.
        let mut distances = vec![f32::INFINITY; weights.len()];
        let mut axes: Vec<Vec3> = Vec::with_capacity(count);
        while axes.len() < count {
            let Some(chosen) = choose(&weights, rng.next_f32()) else {
                break;
            };
            let axis = self.all[chosen].0;
            axes.push(axis);
            let samples = self.all.iter().zip(&mut distances).zip(&mut weights);
            for (((w, flux), distance), weight) in samples {
                *distance = distance.min(0.5 * (*w - axis).length_squared());
                *weight = flux.luminance() * *distance;
            }
        }
        // The mean of 1 - μ·w over a lobe is 1/κ.
        let kappa = (total / weights.iter().sum::<f32>()).clamp(MIN_KAPPA, max_kappa);
        let weight = 1.0 / axes.len() as f32;
        axes.iter()
            .map(|&axis| Component {
                axis,
                kappa,
                flux: Rgb::BLACK,
                weight,
            })
            .collect()
    }
}

/// The index at which the cumulative sum of `weights` exceeds the fraction `u` in [0, 1) of the
/// total; `None` if all are 0.
fn choose(weights: &[f32], u: f32) -> Option<usize> {
    let end = u * weights.iter().sum::<f32>();
    let mut sum = 0.0;
    let mut last = None;
    for (i, &weight) in weights.iter().enumerate().filter(|(_, w)| **w > 0.0) {
        sum += weight;
        last = Some(i);
        if sum > end {
            break;
        }
    }
    last
}

/// One step of expectation (responsibilities by densities) and maximization: with the resultant
/// vector `r` and weight `s` of a component,
///
/// ```text
/// μ = r / |r|,   r̄ = |r| / (s + prior),   κ = r̄ (3 - r̄²) / (1 - r̄²)
/// ```
fn em_step(
    samples: &[[Lanes3; 2]],
    components: &[Component],
    n: Option<Vec3>,
    prior: f32,
    max_kappa: f32,
) -> Vec<Component> {
    let sums = Isa::best().run(ResponsibilitySums {
        samples,
        components,
    });
    // Missing data: the part of each lobe below the horizon, in proportion to the observed part
    // above.
    let below: Vec<(f32, Vec3)> = components
        .iter()
        .map(|c| n.map_or((0.0, Vec3::ZERO), |n| c.below(n)))
        .collect();
    let above: f32 = components
        .iter()
        .zip(&below)
        .map(|(c, below)| c.weight * (1.0 - below.0))
        .sum();
    let maximized = |((old, sum), below): ((&Component, &[f32; 6]), &(f32, Vec3))| {
        let missing = old.weight / above.max(f32::MIN_POSITIVE);
        let resultant = Vec3::new(sum[0], sum[1], sum[2]) + below.1 * missing;
        let flux = Rgb::new(sum[3], sum[4], sum[5]);
        let weight = flux.luminance() + below.0 * missing;
        let length = resultant.length();
        let mean = (length / (weight + prior)).min(1.0 - f32::EPSILON);
        let kappa = mean * (3.0 - mean * mean) / (1.0 - mean * mean);
        let axis = resultant.try_normalize().unwrap_or(old.axis);
        Component {
            axis: n.map_or(axis, |n| raised(axis, n)),
            kappa: kappa.clamp(MIN_KAPPA, max_kappa),
            flux,
            weight,
        }
    };
    (components.iter().zip(&sums).zip(&below))
        .map(maximized)
        .collect()
}

/// `axis`, or the nearest direction on the horizon of `n` if it is below: the tail of a lobe far
/// below the horizon would have to hold all flux.
fn raised(axis: Vec3, n: Vec3) -> Vec3 {
    let depth = axis.dot(n).min(0.0);
    (axis - n * depth).try_normalize().unwrap_or(n)
}

/// Expectation step. For each component, sums over the samples weighted by its responsibility:
/// direction times luminance (3 numbers), and flux (3 numbers).
struct ResponsibilitySums<'a> {
    samples: &'a [[Lanes3; 2]],
    components: &'a [Component],
}

impl SimdKernel for ResponsibilitySums<'_> {
    type Output = [[f32; 6]; MAX_LOBES];

    #[inline(always)]
    fn run<I: Simd>(self, isa: I) -> Self::Output {
        responsibility_sums(isa.wide(), self.samples, self.components)
    }
}

#[inline(always)]
fn responsibility_sums<S: Sixteen>(
    s: S,
    samples: &[[Lanes3; 2]],
    components: &[Component],
) -> [[f32; 6]; MAX_LOBES] {
    let zero = Float::splat(s, 0.0);
    let mut directions = [Vector::new(zero, zero, zero); MAX_LOBES];
    let mut fluxes = [Color::black(s); MAX_LOBES];
    let mut densities = [zero; MAX_LOBES];
    for [w, flux] in samples {
        let (w, flux) = (w.vectors(s), flux.colors(s));
        // Positive, for samples far from all lobes.
        let mut all = Float::splat(s, f32::MIN_POSITIVE);
        for (density, lobe) in densities.iter_mut().zip(components) {
            let apart = w - Vector::splat(s, lobe.axis);
            let exponent = apart.length_squared() * (-0.5 * lobe.kappa);
            let front = lobe.weight.max(MIN_WEIGHT) / solid_angle(f64::from(lobe.kappa)) as f32;
            *density = front * exponent.max(LOWEST_EXPONENT).exp();
            all += *density;
        }
        let scale = all.recip();
        let weight = flux.weighted_sum(Rgb::LUMINANCE);
        for k in 0..components.len().min(MAX_LOBES) {
            let responsibility = densities[k] * scale;
            directions[k] = directions[k] + w * (weight * responsibility);
            fluxes[k] += flux * responsibility;
        }
    }
    let mut sums = [[0.0; 6]; MAX_LOBES];
    for k in 0..MAX_LOBES {
        let (direction, flux) = (directions[k], fluxes[k]);
        let numbers = [
            direction.x,
            direction.y,
            direction.z,
            flux.r,
            flux.g,
            flux.b,
        ];
        for (sum, lanes) in sums[k].iter_mut().zip(numbers) {
            *sum = lanes.store().iter().sum();
        }
    }
    sums
}
