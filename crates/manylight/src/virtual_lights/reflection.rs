//! What the glossy part of a light is made of: some of its photons with the lobes that they are scattered into.

use crate::bsdf::{Bsdf, BsdfNumbers, Lobes};
use crate::color::Rgb;
use crate::math::{Vec2, Vec3};
use crate::sampling::rng::Pcg;

/// Directions drawn from all lobes together for the flux that they reflect, and fewest for each.
const FLUX_SAMPLES: u32 = 256;
/// See [`FLUX_SAMPLES`].
const MIN_FLUX_SAMPLES: u32 = 16;
/// Sine of the depth below the horizon that reflection about shading normals may reach.
const MAX_TILT: f32 = 0.5;
/// Additive recurrence in three dimensions.
/// Source: Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018.
const STEPS: [f32; 3] = [0.819_172_5, 0.671_043_6, 0.549_700_5];
/// The largest number below 1.
const LARGEST: f32 = 1.0 - f32::EPSILON / 2.0;

/// One light path that a light shows: incident flux in W from `wi` onto a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source<'s> {
    pub(super) bsdf: Bsdf<'s>,
    pub(super) wi: Vec3,
    pub(super) flux: Rgb,
}

/// Draws `count` directions from the glossy lobes of all sources, evenly spread over those that are alike: calls `visit` with each
/// and the flux that it carries.
pub(super) fn scatter_all(
    sources: &[Source],
    count: u32,
    rng: &mut Pcg,
    mut visit: impl FnMut(Vec3, Rgb),
) {
    let shift = [rng.next_f32(), rng.next_f32(), rng.next_f32()];
    let each = count.div_ceil(sources.len().max(1) as u32);
    let numbers = (1..=each).flat_map(|_| sources).zip(1..);
    for (source, i) in numbers {
        if let Some((w, flux, _)) = source.draw(shift, i) {
            visit(w, flux / each as f32);
        }
    }
}

impl Source<'_> {
    /// The direction number `i` of the sequence that begins at `shift`, its flux, and the relative index.
    fn draw(&self, shift: [f32; 3], i: u32) -> Option<(Vec3, Rgb, f32)> {
        let u: [f32; 3] =
            std::array::from_fn(|c| (shift[c] + STEPS[c] * i as f32).fract().min(LARGEST));
        let numbers = BsdfNumbers {
            lobe: u[0],
            direction: Vec2::new(u[1], u[2]),
        };
        let sample = self.bsdf.sample_wo(self.wi, numbers, Lobes::GLOSSY)?;
        Some((sample.w, self.flux * sample.weight, sample.eta))
    }

    /// Draws directions from the glossy lobes: calls `visit` with each, the flux that it carries, and the relative index.
    pub(super) fn scatter(&self, count: u32, rng: &mut Pcg, mut visit: impl FnMut(Vec3, Rgb, f32)) {
        let shift = [rng.next_f32(), rng.next_f32(), rng.next_f32()];
        for i in 1..=count {
            if let Some((w, flux, eta)) = self.draw(shift, i) {
                visit(w, flux / count as f32, eta);
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
    pub(super) fn contains(self, w: Vec3) -> bool {
        match self {
            Range::Above(n) => w.dot(n) > 0.0,
            Range::Sphere => true,
        }
    }

    /// The normal of the horizon, if there is one.
    pub(super) fn horizon(self) -> Option<Vec3> {
        match self {
            Range::Above(n) => Some(n),
            Range::Sphere => None,
        }
    }
}

/// Into what range the sources shine, and how much flux they send there. Directions drawn from their lobes tell.
pub(super) fn reflected(sources: &[Source], n: Vec3, rng: &mut Pcg) -> (Range, Rgb) {
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
