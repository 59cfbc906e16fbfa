//! Mixtures of von Mises-Fisher lobes from weighted directions, by expectation maximization.
//!
//! Source: Banerjee, Dhillon, Ghosh, Sra, "Clustering on the Unit Hypersphere using von Mises-Fisher Distributions", 2005, with
//! weights of samples, starts by k-means++ (Arthur, Vassilvitskii, 2007), a prior that keeps lobes of few samples wide, and with what
//! a lobe has below the horizon as data that are missing: else lobes near the horizon, cut there once more, would be too narrow.
//!
//! The directions are drawn from the sources' lobes, evenly spread over all sources together. 512 of them show a lobe as well as a
//! table of 32 x 32 texels would, and are not blurred by texels.

use super::sources::{Range, Source, scatter_all};
use super::von_mises_fisher::{Lobe, part_below, solid_angle};
use crate::color::Rgb;
use crate::lanes::vectors::{add3, dot, luminance, scale3, splat3, sub3};
use crate::lanes::{LANES, Lanes3, exp};
use crate::math::Vec3;
use crate::sampling::rng::Pcg;
use crate::simd::{Isa, Simd, SimdKernel, Wide};

/// Most lobes of a mixture.
pub(super) const MAX_LOBES: usize = 8;
/// Directions drawn for a fit.
const SAMPLES: u32 = 512;
/// Steps of expectation and maximization, at most.
const MAX_STEPS: usize = 40;
/// They end when no lobe's share of the flux moves by more than this, and no concentration by more than this part.
const SETTLED: f32 = 0.01;
/// Flux of the opinion that a lobe looks nowhere, as a part of one sample's: bounds the concentration of lobes of few samples.
const PRIOR: f32 = 0.1;
/// Lobes are given at least this share of the flux when samples are divided, so that none dies.
const LEAST_SHARE: f32 = 1e-3;
/// The most concentrated lobe times the square of the roughness: a reflected lobe has about 1 at its peak, more at grazing angles.
const SHARPEST: f32 = 4.0;
/// The widest lobe.
const LEAST_KAPPA: f32 = 1e-2;

/// At most `count` lobes that hold `target` within `range`, of the shape of what `sources` reflect, whose narrowest lobe has roughness
/// `width`; and the flux that they hold.
pub(super) fn mixture(
    count: usize,
    sources: &[Source],
    width: f32,
    range: Range,
    target: Rgb,
    rng: &mut Pcg,
) -> (Vec<Lobe>, Rgb) {
    let mut samples = Samples::default();
    scatter_all(sources, SAMPLES, rng, |w, flux| {
        if range.contains(w) {
            samples.all.push((w, flux));
        }
    });
    let n = range.horizon();
    let fitted = samples.fit(count, SHARPEST / (width * width), n, rng);
    let lobes: Vec<Lobe> = fitted.iter().map(|c| c.lobe(n)).collect();
    let flux = |lobes: &[Lobe]| -> Rgb { lobes.iter().map(|lobe| lobe.flux(n)).sum() };
    let factor = target.zip(flux(&lobes), |target, flux| match flux > 0.0 {
        true => target / flux,
        false => 0.0,
    });
    let lobes: Vec<Lobe> = lobes.iter().map(|lobe| lobe.scaled(factor)).collect();
    let held = flux(&lobes);
    (lobes, held)
}

/// One lobe of a mixture.
#[derive(Clone, Copy, Debug)]
struct Component {
    /// Unit.
    axis: Vec3,
    kappa: f32,
    /// Flux of its samples, each by the share that it has in it.
    flux: Rgb,
    /// Of the luminance of all samples, and those that would be below the horizon.
    share: f32,
}

impl Component {
    /// See [`part_below`].
    fn below(&self, n: Vec3) -> (f32, Vec3) {
        let (share, direction) = part_below(self.axis, f64::from(self.kappa), n);
        (share as f32, direction)
    }

    /// As it is stored, holding its flux above the horizon of `n`.
    fn lobe(&self, n: Option<Vec3>) -> Lobe {
        let below = n.map_or(0.0, |n| self.below(n).0);
        Lobe::new(self.axis, self.kappa, self.flux / (1.0 - below))
    }
}

/// Directions with the flux that each carries.
#[derive(Clone, Debug, Default)]
struct Samples {
    all: Vec<(Vec3, Rgb)>,
}

impl Samples {
    /// At most `count` lobes that the samples come from, of which only those above the horizon of `n` are there; none more concentrated
    /// than `max_kappa`, and none from samples without flux.
    fn fit(&self, count: usize, max_kappa: f32, n: Option<Vec3>, rng: &mut Pcg) -> Vec<Component> {
        let total: f32 = self.all.iter().map(|(_, flux)| flux.luminance()).sum();
        if total.is_nan() || total <= 0.0 {
            return Vec::new();
        }
        let samples = self.in_lanes(1.0 / total);
        let prior = PRIOR / self.all.len() as f32;
        let mut components = self.start(count, max_kappa, rng);
        for _ in 0..MAX_STEPS {
            let next = maximized(&samples, &components, n, prior, max_kappa);
            let settled = components.iter().zip(&next).all(|(a, b)| {
                (a.share - b.share).abs() < SETTLED && (a.kappa - b.kappa).abs() < SETTLED * b.kappa
            });
            components = next;
            if settled {
                break;
            }
        }
        for component in &mut components {
            component.flux *= total;
        }
        components
    }

    /// Sixteen at a time, filled up with black ones; flux times `scale`.
    fn in_lanes(&self, scale: f32) -> Vec<[Lanes3; 2]> {
        let part = |chunk: &[(Vec3, Rgb)]| {
            let mut lanes = [Lanes3::ZERO; 2];
            for i in 0..LANES {
                let (w, flux) = chunk.get(i).copied().unwrap_or((Vec3::Z, Rgb::BLACK));
                lanes[0].set(i, w);
                lanes[1].set(i, (flux * scale).to_array());
            }
            lanes
        };
        self.all.chunks(LANES).map(part).collect()
    }

    /// Lobes around samples far from each other, as wide as the samples are from the nearest of them.
    fn start(&self, count: usize, max_kappa: f32, rng: &mut Pcg) -> Vec<Component> {
        let mut weights: Vec<f32> = self.all.iter().map(|(_, flux)| flux.luminance()).collect();
        let total: f32 = weights.iter().sum();
        let mut apart = vec![f32::INFINITY; weights.len()];
        let mut axes: Vec<Vec3> = Vec::with_capacity(count);
        while axes.len() < count {
            let Some(chosen) = choose(&weights, rng.next_f32()) else {
                break;
            };
            let axis = self.all[chosen].0;
            axes.push(axis);
            for (((w, flux), apart), weight) in self.all.iter().zip(&mut apart).zip(&mut weights) {
                *apart = apart.min(0.5 * (*w - axis).length_squared());
                *weight = flux.luminance() * *apart;
            }
        }
        // The mean of 1 - μ·w over a lobe is 1/κ.
        let kappa = (total / weights.iter().sum::<f32>()).clamp(LEAST_KAPPA, max_kappa);
        let share = 1.0 / axes.len() as f32;
        axes.iter()
            .map(|&axis| Component {
                axis,
                kappa,
                flux: Rgb::BLACK,
                share,
            })
            .collect()
    }
}

/// The index at which the sum of `weights` passes the share `u`; `None` if they are all 0.
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

/// One step: divides the samples among the lobes by their densities, and makes each lobe anew of what it got.
fn maximized(
    samples: &[[Lanes3; 2]],
    components: &[Component],
    n: Option<Vec3>,
    prior: f32,
    max_kappa: f32,
) -> Vec<Component> {
    let sums = Isa::best().run(Division {
        samples,
        components,
    });
    // What the lobes would have below the horizon, where no sample is, in proportion to what is above.
    let below: Vec<(f32, Vec3)> = components
        .iter()
        .map(|c| n.map_or((0.0, Vec3::ZERO), |n| c.below(n)))
        .collect();
    let above: f32 = components
        .iter()
        .zip(&below)
        .map(|(c, below)| c.share * (1.0 - below.0))
        .sum();
    let anew = |((old, sum), below): ((&Component, &[f32; 6]), &(f32, Vec3))| {
        let missing = old.share / above.max(f32::MIN_POSITIVE);
        let resultant = Vec3::new(sum[0], sum[1], sum[2]) + below.1 * missing;
        let flux = Rgb::new(sum[3], sum[4], sum[5]);
        let share = flux.luminance() + below.0 * missing;
        let length = resultant.length();
        let mean = (length / (share + prior)).min(1.0 - f32::EPSILON);
        let kappa = mean * (3.0 - mean * mean) / (1.0 - mean * mean);
        let axis = resultant.try_normalize().unwrap_or(old.axis);
        Component {
            axis: n.map_or(axis, |n| raised(axis, n)),
            kappa: kappa.clamp(LEAST_KAPPA, max_kappa),
            flux,
            share,
        }
    };
    components.iter().zip(&sums).zip(&below).map(anew).collect()
}

/// `axis`, or the nearest on the horizon of `n`: of a lobe far below it the least part would have to hold all flux.
fn raised(axis: Vec3, n: Vec3) -> Vec3 {
    let depth = axis.dot(n).min(0.0);
    (axis - n * depth).try_normalize().unwrap_or(n)
}

/// Sums over the samples, each counting by the share that a lobe has in it: the direction weighted by luminance, and the flux.
struct Division<'a> {
    samples: &'a [[Lanes3; 2]],
    components: &'a [Component],
}

impl SimdKernel for Division<'_> {
    type Output = [[f32; 6]; MAX_LOBES];

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Self::Output {
        divide(s.wide(), self.samples, self.components)
    }
}

#[inline(always)]
fn divide<W: Wide>(
    s: W,
    samples: &[[Lanes3; 2]],
    components: &[Component],
) -> [[f32; 6]; MAX_LOBES] {
    let zero = s.splat(0.0);
    let mut sums = [[zero; 6]; MAX_LOBES];
    let mut densities = [zero; MAX_LOBES];
    for [w, flux] in samples {
        let (w, flux) = (w.load(s), flux.load(s));
        // So that what is far from all lobes has shares, too.
        let mut all = s.splat(f32::MIN_POSITIVE);
        for (density, lobe) in densities.iter_mut().zip(components) {
            let apart = sub3(s, w, splat3(s, lobe.axis));
            let exponent = s.mul(dot(s, apart, apart), s.splat(-0.5 * lobe.kappa));
            let front = lobe.share.max(LEAST_SHARE) / solid_angle(f64::from(lobe.kappa)) as f32;
            *density = s.mul(
                s.splat(front),
                exp(s, s.max(exponent, s.splat(LOWEST_EXPONENT))),
            );
            all = s.add(all, *density);
        }
        let scale = s.div(s.splat(1.0), all);
        let weight = luminance(s, flux);
        for ((sum, &density), _) in sums.iter_mut().zip(&densities).zip(components) {
            let share = s.mul(density, scale);
            let direction = add3(
                s,
                [sum[0], sum[1], sum[2]],
                scale3(s, w, s.mul(weight, share)),
            );
            let colour = add3(s, [sum[3], sum[4], sum[5]], scale3(s, flux, share));
            *sum = [
                direction[0],
                direction[1],
                direction[2],
                colour[0],
                colour[1],
                colour[2],
            ];
        }
    }
    let mut out = [[0.0; 6]; MAX_LOBES];
    for (out, sums) in out.iter_mut().zip(sums) {
        for (out, sum) in out.iter_mut().zip(sums) {
            *out = total(s, sum);
        }
    }
    out
}

/// Densities are not taken further from an axis, so that they never vanish.
const LOWEST_EXPONENT: f32 = -60.0;

#[inline(always)]
fn total<W: Wide>(s: W, sum: W::F) -> f32 {
    s.store(sum).iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Frame, Vec2};
    use crate::sampling::warp;

    /// Lobes of `(axis, kappa, share, colour)` in samples of equal luminance.
    fn samples(lobes: &[(Vec3, f32, f32, Rgb)], count: usize, rng: &mut Pcg) -> Samples {
        let mut samples = Samples::default();
        for &(axis, kappa, share, colour) in lobes {
            for _ in 0..(share * count as f32).round() as usize {
                let u = Vec2::new(rng.next_f32(), rng.next_f32());
                let w = Frame::from_normal(axis).to_world(warp::von_mises_fisher(u, kappa));
                samples.all.push((w, colour / colour.luminance()));
            }
        }
        samples
    }

    #[test]
    fn known_mixtures_are_recovered() {
        let axis = |x, y, z| Vec3::new(x, y, z).normalize();
        let (red, green, blue) = (
            Rgb::new(1.0, 0.1, 0.2),
            Rgb::new(0.2, 1.0, 0.3),
            Rgb::new(0.3, 0.2, 1.0),
        );
        let mixtures: [&[(Vec3, f32, f32, Rgb)]; 4] = [
            &[(axis(0.3, -0.2, 0.9), 6.0, 1.0, red)],
            &[(axis(-0.5, 0.2, 0.6), 1e4, 1.0, blue)],
            &[
                (axis(1.0, 0.0, 0.2), 200.0, 0.5, red),
                (axis(0.0, 1.0, 0.5), 50.0, 0.3, green),
                (axis(-0.5, -1.0, 0.5), 15.0, 0.2, blue),
            ],
            // One lobe within another, as peaks have tails.
            &[
                (axis(0.1, 0.1, 1.0), 400.0, 0.6, red),
                (axis(0.1, 0.1, 1.0), 10.0, 0.4, green),
            ],
        ];
        let mut rng = Pcg::new(1);
        for mixture in mixtures {
            let samples = samples(mixture, 20_000, &mut rng);
            let total: Rgb = samples.all.iter().map(|s| s.1).sum();
            let fitted = samples.fit(mixture.len(), 1e5, None, &mut rng);
            assert_eq!(fitted.len(), mixture.len());
            let got: Rgb = fitted.iter().map(|c| c.flux).sum();
            assert!(
                (got / total.max_channel() - total / total.max_channel())
                    .g
                    .abs()
                    < 1e-4
            );
            for &(axis, kappa, share, colour) in mixture {
                let lobe = fitted
                    .iter()
                    .min_by(|a, b| {
                        let off =
                            |c: &Component| (c.axis - axis).length() + (c.kappa / kappa).ln().abs();
                        off(a).total_cmp(&off(b))
                    })
                    .expect("lobes");
                assert!((lobe.axis - axis).length() < 0.05, "{lobe:?}, not {axis}");
                assert!(
                    (lobe.kappa / kappa - 1.0).abs() < 0.1,
                    "{lobe:?}, not {kappa}"
                );
                assert!((lobe.share - share).abs() < 0.02, "{lobe:?}, not {share}");
                let hue = (lobe.flux.r / lobe.flux.g) / (colour.r / colour.g);
                assert!(mixture.len() == 2 || (0.8..1.25).contains(&hue), "{lobe:?}");
            }
        }
    }

    #[test]
    fn lobes_that_the_horizon_cuts_are_recovered() {
        let mut rng = Pcg::new(2);
        for (elevation, kappa) in [(0.2f32, 4.0), (0.1, 30.0), (0.6, 2.0)] {
            let axis = Vec3::new(elevation.cos(), 0.0, elevation.sin());
            let mut samples = samples(&[(axis, kappa, 1.0, Rgb::WHITE)], 20_000, &mut rng);
            samples.all.retain(|(w, _)| w.z > 0.0);
            let fitted = samples.fit(1, 1e5, Some(Vec3::Z), &mut rng);
            let lobe = fitted[0];
            assert!((lobe.axis - axis).length() < 0.1, "{lobe:?}, not {axis}");
            assert!(
                (lobe.kappa / kappa - 1.0).abs() < 0.15,
                "{lobe:?}, not {kappa}"
            );
        }
    }

    #[test]
    fn few_samples_make_bounded_lobes() {
        let mut rng = Pcg::new(3);
        let none = Samples::default();
        assert!(none.fit(5, 100.0, None, &mut rng).is_empty());
        let black = Samples {
            all: vec![(Vec3::Z, Rgb::BLACK); 20],
        };
        assert!(black.fit(5, 100.0, None, &mut rng).is_empty());
        // All in one direction: one lobe, however many are asked for.
        let one = Samples {
            all: vec![(Vec3::Z, Rgb::WHITE); 20],
        };
        for max_kappa in [10.0, 1e6] {
            let lobes = one.fit(5, max_kappa, Some(Vec3::Z), &mut rng);
            assert_eq!(lobes.len(), 1);
            assert!(lobes[0].kappa <= max_kappa && lobes[0].kappa.is_finite());
            assert!((lobes[0].axis - Vec3::Z).length() < 1e-5);
            assert!((lobes[0].flux.g - 20.0).abs() < 1e-3, "{lobes:?}");
        }
    }
}
