//! Emission: the glossy radiant intensity of a light in an octahedral table.
//!
//! Some photons are drawn from the light's own in proportion to flux, and their lobes are evaluated, each about its own normal.
//! Then the table is scaled so that the integral of what is looked up (bilinear, cut at the horizon) is the flux that
//! these photons reflect, which importance sampling of their lobes tells.

use super::tables::{Packed, pack};
use crate::bsdf::{Bsdf, BsdfNumbers, Lobes};
use crate::color::Rgb;
use crate::math::octahedral::{
    bilinear, direction_from_square, solid_angle_density, texel_direction,
};
use crate::math::{Vec2, Vec3};
use crate::sampling::rng::Pcg;

/// Sub-samples along an edge of a texel in the integrals of the bilinear function.
const FINE: usize = 6;
/// Lobes narrower than this are averaged over a texel, wider ones taken at its center.
const NARROW: f32 = 0.3;
/// Sub-samples along an edge of a texel for narrow lobes.
const NARROW_FINE: usize = 2;
/// A block of 2 x 2 texels is looked at closely if it shines with this share of the brightest: narrow lobes.
const NARROW_BRIGHT_SHARE: f32 = 0.05;
/// And wide ones, which hardly change over a block.
const WIDE_BRIGHT_SHARE: f32 = 0.3;
/// Directions drawn from all lobes together for the flux that they reflect, and fewest for each.
const FLUX_SAMPLES: u32 = 256;
/// See [`FLUX_SAMPLES`].
const MIN_FLUX_SAMPLES: u32 = 16;
/// Directions drawn from each lobe when the table has to be made of them.
const SPLAT_SAMPLES: u32 = 128;
/// Correction by more than this, or less than its inverse, means that the lobe fell between the texels.
const MAX_CORRECTION: f32 = 2.0;
/// Sine of the depth below the horizon that reflection about shading normals may reach.
const MAX_TILT: f32 = 0.5;
/// Additive recurrence in three dimensions.
/// Source: Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018.
const STEPS: [f32; 3] = [0.819_172_5, 0.671_043_6, 0.549_700_5];
/// The largest number below 1.
const LARGEST: f32 = 1.0 - f32::EPSILON / 2.0;

/// One light path that a table shows: incident flux in W from `wi` onto a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source<'s> {
    pub(super) bsdf: Bsdf<'s>,
    pub(super) wi: Vec3,
    pub(super) flux: Rgb,
}

impl Source<'_> {
    /// Draws directions from the glossy lobes: calls `visit` with each, the flux that it carries, and the relative index.
    fn scatter(&self, count: u32, rng: &mut Pcg, mut visit: impl FnMut(Vec3, Rgb, f32)) {
        let shift = [rng.next_f32(), rng.next_f32(), rng.next_f32()];
        for i in 1..=count {
            let u: [f32; 3] =
                std::array::from_fn(|c| (shift[c] + STEPS[c] * i as f32).fract().min(LARGEST));
            let numbers = BsdfNumbers {
                lobe: u[0],
                direction: Vec2::new(u[1], u[2]),
            };
            if let Some(sample) = self.bsdf.sample_wo(self.wi, numbers, Lobes::GLOSSY) {
                visit(
                    sample.w,
                    self.flux * sample.weight / count as f32,
                    sample.eta,
                );
            }
        }
    }
}

/// What a light on a surface with normal `n` may shine into.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Range {
    /// Directions above the horizon of the normal.
    Above(Vec3),
    /// All: light is also transmitted.
    Sphere,
}

impl Range {
    #[inline]
    fn contains(self, w: Vec3) -> bool {
        match self {
            Range::Above(n) => w.dot(n) > 0.0,
            Range::Sphere => true,
        }
    }
}

/// The glossy part of a light.
#[derive(Clone, Debug)]
pub(super) struct Profile {
    /// W/sr, row by row, in units of the colour.
    pub(super) table: (Vec<Packed>, Rgb),
    pub(super) range: Range,
    /// Flux that the table should hold, in W.
    pub(super) target: Rgb,
    /// Flux that it holds.
    pub(super) flux: Rgb,
}

/// Everything about an octahedral grid that does not depend on the light.
#[derive(Debug)]
pub(super) struct Grid {
    side: usize,
    /// Texel centers.
    centers: Vec<Vec3>,
    /// Integrals of the bilinear hat functions over the sphere, in sr.
    hats: Vec<f32>,
}

/// `FINE`² sub-samples of texel `t`: direction and solid angle.
fn sub_samples(t: usize, side: usize, fine: usize) -> impl Iterator<Item = (Vec3, f32)> {
    (0..fine * fine).map(move |s| {
        let offset = Vec2::new((s % fine) as f32 + 0.5, (s / fine) as f32 + 0.5) / fine as f32;
        let uv = (Vec2::new((t % side) as f32, (t / side) as f32) + offset) / side as f32;
        let area = 1.0 / ((side * fine) as f32).powi(2);
        (direction_from_square(uv), solid_angle_density(uv) * area)
    })
}

impl Grid {
    /// A grid of `side`² texels; `side` must be even.
    pub(super) fn new(side: usize) -> Self {
        assert!(
            side >= 2 && side.is_multiple_of(2),
            "tables are made of blocks of 2 x 2 texels"
        );
        let mut hats = vec![0.0; side * side];
        for (w, solid_angle) in (0..side * side).flat_map(|t| sub_samples(t, side, 2 * FINE)) {
            for (texel, weight) in bilinear(w, side) {
                hats[texel] += weight * solid_angle;
            }
        }
        Grid {
            side,
            centers: (0..side * side).map(|t| texel_direction(t, side)).collect(),
            hats,
        }
    }

    /// Texels along an edge.
    pub(super) fn side(&self) -> usize {
        self.side
    }

    /// The table of `sources`, whose narrowest lobe has roughness `width`, on a surface with normal `n`.
    pub(super) fn fill(&self, sources: &[Source], width: f32, n: Vec3, rng: &mut Pcg) -> Profile {
        let (range, target) = reflected(sources, n, rng);
        let mut texels = vec![Rgb::BLACK; self.side * self.side];
        for source in sources {
            self.evaluate(source, width, range, &mut texels);
        }
        let mut flux = self.integral(&texels, range);
        let mut scale = correction(flux, target);
        if scale.is_none() {
            texels.fill(Rgb::BLACK);
            for source in sources {
                self.splat(source, range, rng, &mut texels);
            }
            flux = self.integral(&texels, range);
            scale = correction(flux, target);
        }
        // No more than what the samples say can be known of a lobe that escapes both.
        let scale = scale.unwrap_or(Rgb::WHITE);
        texels.iter_mut().for_each(|texel| *texel *= scale);
        Profile {
            table: pack(&texels, &self.hats),
            range,
            target,
            flux: flux * scale,
        }
    }

    /// Adds the intensity of one source: one value for each block of 2 x 2 texels first, then the texels of the blocks that
    /// matter.
    fn evaluate(&self, source: &Source, width: f32, range: Range, texels: &mut [Rgb]) {
        let value = |w: Vec3| source.bsdf.f_cos_wo(source.wi, w, Lobes::GLOSSY) * source.flux;
        let blocks: Vec<(usize, Rgb)> = (0..self.side * self.side / 4)
            .filter_map(|b| {
                let half = self.side / 2;
                let corner = 2 * (b / half) * self.side + 2 * (b % half);
                let inside = self
                    .block(corner)
                    .into_iter()
                    .filter(|&t| range.contains(self.centers[t]));
                let middle: Vec3 = inside.map(|t| self.centers[t]).sum();
                (middle != Vec3::ZERO).then(|| (corner, value(middle.normalize())))
            })
            .collect();
        let brightest = blocks
            .iter()
            .map(|block| block.1.luminance())
            .fold(0.0, f32::max);
        let narrow = width < NARROW;
        let bright = brightest
            * if narrow {
                NARROW_BRIGHT_SHARE
            } else {
                WIDE_BRIGHT_SHARE
            };
        for (corner, intensity) in blocks {
            for t in self
                .block(corner)
                .into_iter()
                .filter(|&t| range.contains(self.centers[t]))
            {
                texels[t] += match (intensity.luminance() < bright, narrow) {
                    (true, _) => intensity,
                    (false, false) => value(self.centers[t]),
                    (false, true) => self.mean_over_texel(t, value),
                };
            }
        }
    }

    fn mean_over_texel(&self, t: usize, value: impl Fn(Vec3) -> Rgb) -> Rgb {
        let (sum, total) = sub_samples(t, self.side, NARROW_FINE)
            .fold((Rgb::BLACK, 0.0), |(sum, total), (w, dw)| {
                (sum + value(w) * dw, total + dw)
            });
        sum / total
    }

    /// The four texels of the block whose first is `corner`.
    #[inline]
    fn block(&self, corner: usize) -> [usize; 4] {
        [
            corner,
            corner + 1,
            corner + self.side,
            corner + self.side + 1,
        ]
    }

    /// Adds directions drawn from the lobes of one source, each as a hat function of its flux.
    fn splat(&self, source: &Source, range: Range, rng: &mut Pcg, texels: &mut [Rgb]) {
        source.scatter(SPLAT_SAMPLES, rng, |w, flux, _| {
            if range.contains(w) {
                for (t, weight) in bilinear(w, self.side) {
                    texels[t] += flux * (weight / self.hats[t]);
                }
            }
        });
    }

    /// Integral of the bilinear function over its range: all hats, less what leaks below the horizon.
    pub(super) fn integral(&self, texels: &[Rgb], range: Range) -> Rgb {
        let mut sum = [0.0f64; 3];
        let mut add = |value: Rgb, weight: f32| {
            for (s, v) in sum.iter_mut().zip(value.to_array()) {
                *s += f64::from(v) * f64::from(weight);
            }
        };
        for (texel, &hat) in texels.iter().zip(&self.hats) {
            add(*texel, hat);
        }
        if let Range::Above(n) = range {
            // Texels that reach below the horizon, and those next to one above: a texel measures at most 4.3 / side from
            // center to corner.
            let (above, below) = (4.5 / self.side as f32, -9.5 / self.side as f32);
            let near = |t: &usize| (below..above).contains(&self.centers[*t].dot(n));
            for t in (0..texels.len()).filter(near) {
                for (w, solid_angle) in sub_samples(t, self.side, FINE) {
                    // A sub-sample on the horizon counts by the part of it that is below.
                    let below = (0.5 - w.dot(n) / solid_angle.sqrt()).clamp(0.0, 1.0);
                    if below > 0.0 {
                        add(lookup(texels, self.side, w), -solid_angle * below);
                    }
                }
            }
        }
        Rgb::new(sum[0] as f32, sum[1] as f32, sum[2] as f32)
    }
}

/// Factor per channel from the flux of a table to `target`; `None` if it is too far from 1 to be a mere correction.
fn correction(flux: Rgb, target: Rgb) -> Option<Rgb> {
    let ratio = |target: f32, flux: f32| match (target > 0.0, flux > 0.0) {
        (true, true) => target / flux,
        (false, _) => 0.0,
        (true, false) => f32::INFINITY,
    };
    let overall = ratio(target.luminance(), flux.luminance());
    let close = overall == 0.0 || (1.0 / MAX_CORRECTION..=MAX_CORRECTION).contains(&overall);
    let factor = target.zip(flux, ratio);
    (close && factor.is_finite()).then_some(factor)
}

/// Bilinear lookup without the horizon.
#[inline]
fn lookup(texels: &[Rgb], side: usize, w: Vec3) -> Rgb {
    bilinear(w, side)
        .into_iter()
        .map(|(t, weight)| texels[t] * weight)
        .sum()
}

/// Into what range the sources shine, and how much flux they send there.
fn reflected(sources: &[Source], n: Vec3, rng: &mut Pcg) -> (Range, Rgb) {
    let count = (FLUX_SAMPLES / sources.len().max(1) as u32).max(MIN_FLUX_SAMPLES);
    let (mut above, mut all, mut transmits) = ([0.0f64; 3], [0.0f64; 3], false);
    for source in sources {
        source.scatter(count, rng, |w, flux, eta| {
            let is_above = w.dot(n) > 0.0;
            // Reflection about a tilted shading normal gets below the horizon as well, but not far.
            transmits |= !is_above && (eta != 1.0 || w.dot(n) < -MAX_TILT);
            for (c, f) in flux.to_array().into_iter().enumerate() {
                all[c] += f64::from(f);
                above[c] += if is_above { f64::from(f) } else { 0.0 };
            }
        });
    }
    let rgb = |v: [f64; 3]| Rgb::new(v[0] as f32, v[1] as f32, v[2] as f32);
    if transmits {
        (Range::Sphere, rgb(all))
    } else {
        (Range::Above(n), rgb(above))
    }
}
