//! The pre-pass: variances of a pass, measured in some pixels by two passes with independent virtual lights.
//!
//! Its samples are not used in the image, so that no estimate depends on its own noise.

use super::prepared::PreparedPasses;
use super::settings::ManyLight;
use crate::color::Rgb;
use crate::film::{FilmSampler, Layer, shaded_pixels};
use crate::integrators::context::PassContext;
use crate::sampling::{Pass, Stream};
use crate::scene::{PathLimits, Scene};

/// Most pixels of the pre-pass, and the least spacing of their columns and rows. At 320x180 the pre-pass of 1620 pixels takes about a
/// fifth of the time of a pass.
const MAX_PIXELS: u32 = 2048;
const LEAST_SPACING: u32 = 4;
/// Largest variance of a pixel relative to its squared mean that counts: rare bright samples must not decide.
const MAX_RELATIVE_VARIANCE: f64 = 1.0;
/// Squared radiance, relative to that of the mean of the image, below which variances count as absolute, as in relMSE.
const DARK: f64 = 0.01;
/// Layers that the pre-pass records.
const LAYERS: [Layer; 6] = [
    Layer::Beauty,
    Layer::VirtualLights,
    Layer::Compensation,
    Layer::Direct,
    Layer::Emission,
    Layer::Caustics,
];

/// Relative variances of a pass, in the mean over pixels.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TermVariances {
    /// Virtual lights, and compensation of what clamping removes from them.
    pub(super) indirect: f64,
    /// All other light.
    pub(super) rest: f64,
}

/// Draws positions in at most [`MAX_PIXELS`] pixels: the crossings of columns and rows, one of each in `spacing`, drawn at random.
fn sparse_pixels(scene: &Scene, pass: Pass) -> FilmSampler {
    let film = &scene.sensor.desc().film;
    let size = film.crop_size;
    let count = |spacing: u32| size.x.div_ceil(spacing) * size.y.div_ceil(spacing);
    let mut spacing = LEAST_SPACING;
    while count(spacing) > MAX_PIXELS {
        spacing += 1;
    }
    let mut rng = pass.sampler(Stream::Selection, 5);
    let chosen = size.to_array().map(|end| {
        (0..end)
            .step_by(spacing as usize)
            .map(|start| {
                let room = spacing.min(end - start);
                start + ((rng.next_1d() * room as f32) as u32).min(room - 1)
            })
            .collect()
    });
    film.sampler_of(chosen)
}

impl ManyLight {
    /// The mean over pixels of the variances of a pass with these settings, changed by each of `variants` after the lights are made.
    pub(super) fn term_variances<const N: usize>(
        &self,
        scene: &Scene,
        limits: PathLimits,
        run: &PassContext,
        variants: [impl Fn(&mut PreparedPasses); N],
    ) -> [TermVariances; N] {
        // Whichever pass comes first in this run.
        let pixels = sparse_pixels(scene, run.at_pass(0).pass);
        let [a, b] = [0, 1].map(|index| {
            // Other numbers than those of the render's passes.
            let seed = !run.pass.seed;
            let run = PassContext {
                pass: Pass { seed, index },
                ..*run
            };
            let group = self.single_pass_group(index);
            let mut prepared = self.prepare(scene, limits, &group, &run);
            variants.each_ref().map(|variant| {
                variant(&mut prepared);
                shaded_pixels(pixels.size(), &LAYERS, |samples| {
                    prepared.shade_tile(&run, &pixels, samples);
                })
            })
        });
        std::array::from_fn(|k| variances(&a[k], &b[k]))
    }
}

/// The variances of a pass in some pixels, from the values of two.
fn variances(a: &[Rgb], b: &[Rgb]) -> TermVariances {
    let luminance = |x: Rgb| f64::from(x.luminance());
    let pixels = || {
        a.chunks_exact(LAYERS.len())
            .zip(b.chunks_exact(LAYERS.len()))
    };
    let means: Vec<f64> = pixels()
        .map(|(x, y)| 0.5 * (luminance(x[0]) + luminance(y[0])))
        .collect();
    let image = means.iter().sum::<f64>() / means.len() as f64;
    let mut sum = TermVariances::default();
    for ((x, y), mean) in pixels().zip(&means) {
        let scale = mean.powi(2) + DARK * image * image;
        if !(scale > 0.0 && scale.is_finite()) {
            continue;
        }
        let variance = |layer: usize| {
            let difference = luminance(x[layer]) - luminance(y[layer]);
            let variance = 0.5 * difference * difference / scale;
            variance.min(MAX_RELATIVE_VARIANCE) / means.len() as f64
        };
        sum.indirect += variance(1) + variance(2);
        sum.rest += variance(3) + variance(4) + variance(5);
    }
    sum
}
