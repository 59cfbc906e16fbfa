//! Emission: the glossy radiant intensity of a light in an octahedral table.
//!
//! Some photons are drawn from the light's own in proportion to flux, and their lobes are evaluated, each about its own normal.
//! Then the table is scaled so that the integral of what is looked up (bilinear, cut at the horizon) is the flux that
//! these photons reflect, which importance sampling of their lobes tells.

use super::octahedral_grid::Grid;
use super::sources::{Range, Source};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::math::Vec3;
use crate::math::octahedral::bilinear;
use crate::sampling::rng::Pcg;

/// Lobes narrower than this are averaged over a texel, wider ones taken at its center.
const NARROW: f32 = 0.3;
/// A block of 2 x 2 texels is looked at closely if it shines with this share of the brightest: narrow lobes.
const NARROW_BRIGHT_SHARE: f32 = 0.05;
/// And wide ones, which hardly change over a block.
const WIDE_BRIGHT_SHARE: f32 = 0.3;
/// Directions drawn from each lobe when the table has to be made of them.
const SPLAT_SAMPLES: u32 = 128;
/// Correction by more than this, or less than its inverse, means that the lobe fell between the texels.
const MAX_CORRECTION: f32 = 2.0;

impl Grid {
    /// The texels of the table of `sources`, whose narrowest lobe has roughness `width` and which reflect `target`; and the flux that
    /// they hold.
    pub(super) fn fill(
        &self,
        sources: &[Source],
        width: f32,
        range: Range,
        target: Rgb,
        rng: &mut Pcg,
    ) -> (Vec<Rgb>, Rgb) {
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
        (texels, flux * scale)
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
            let outgoing = source.bsdf.with_wi(source.wi, Lobes::GLOSSY);
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
