//! Emission: the glossy radiant intensity of a light in an octahedral table.
//!
//! Some photons are drawn from the light's own in proportion to flux, and their lobes are evaluated, each about its own normal.
//! Then the table is scaled so that the integral of what is looked up (bilinear, cut at the horizon) is the flux that
//! these photons reflect, which importance sampling of their lobes tells.

use super::octahedral_grid::Grid;
use super::tables::{Packed, pack};
use crate::bsdf::{Bsdf, BsdfNumbers, Lobes};
use crate::color::Rgb;
use crate::math::octahedral::bilinear;
use crate::math::{Vec2, Vec3};
use crate::sampling::rng::Pcg;

/// Lobes narrower than this are averaged over a texel, wider ones taken at its center.
const NARROW: f32 = 0.3;
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

    /// The normal of the horizon, if there is one.
    fn horizon(self) -> Option<Vec3> {
        match self {
            Range::Above(n) => Some(n),
            Range::Sphere => None,
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

impl Grid {
    /// The table of `sources`, whose narrowest lobe has roughness `width`, on a surface with normal `n`.
    pub(super) fn fill(&self, sources: &[Source], width: f32, n: Vec3, rng: &mut Pcg) -> Profile {
        let (range, target) = reflected(sources, n, rng);
        let mut texels = vec![Rgb::BLACK; self.side() * self.side()];
        self.evaluate(sources, width, range, &mut texels);
        let mut flux = self.integral(&texels, range.horizon());
        let mut scale = correction(flux, target);
        if scale.is_none() {
            texels.fill(Rgb::BLACK);
            for source in sources {
                self.splat(source, range, rng, &mut texels);
            }
            flux = self.integral(&texels, range.horizon());
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

    /// Adds the intensity of the sources: one value for each block of 2 x 2 texels first, then the texels of the blocks that
    /// matter.
    fn evaluate(&self, sources: &[Source], width: f32, range: Range, texels: &mut [Rgb]) {
        let narrow = width < NARROW;
        let bright_share = if narrow {
            NARROW_BRIGHT_SHARE
        } else {
            WIDE_BRIGHT_SHARE
        };
        let inside = |corner: usize| {
            let texels = self.block(corner).into_iter();
            texels.filter(move |&t| range.contains(self.center(t)))
        };
        let (mut corners, mut middles) = (Vec::new(), Vec::new());
        for corner in self.blocks() {
            let middle: Vec3 = inside(corner).map(|t| self.center(t)).sum();
            if middle != Vec3::ZERO {
                corners.push(corner);
                middles.push(middle.normalize());
            }
        }
        let (mut values, mut closer) = (Vec::new(), Vec::new());
        let (mut parts, mut directions) = (Vec::new(), Vec::new());
        for source in sources {
            let outgoing = source.bsdf.outgoing(source.wi, Lobes::GLOSSY);
            outgoing.f_cos_wo(&middles, &mut values);
            let luminance = |value: &Rgb| (*value * source.flux).luminance();
            let bright = bright_share * values.iter().map(luminance).fold(0.0, f32::max);
            parts.clear();
            directions.clear();
            let mut look_at = |t: usize, share: f32, w: Vec3| {
                parts.push((t, share));
                directions.push(w);
            };
            for (&corner, value) in corners.iter().zip(&values) {
                for t in inside(corner) {
                    if luminance(value) < bright {
                        texels[t] += *value * source.flux;
                    } else if narrow {
                        for (w, share) in self.within_texel(t) {
                            look_at(t, share, w);
                        }
                    } else {
                        look_at(t, 1.0, self.center(t));
                    }
                }
            }
            outgoing.f_cos_wo(&directions, &mut closer);
            for (&(t, share), value) in parts.iter().zip(&closer) {
                texels[t] += *value * source.flux * share;
            }
        }
    }

    /// Adds directions drawn from the lobes of one source, each as a hat function of its flux.
    fn splat(&self, source: &Source, range: Range, rng: &mut Pcg, texels: &mut [Rgb]) {
        source.scatter(SPLAT_SAMPLES, rng, |w, flux, _| {
            if range.contains(w) {
                for (t, weight) in bilinear(w, self.side()) {
                    texels[t] += flux * (weight / self.hats[t]);
                }
            }
        });
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
