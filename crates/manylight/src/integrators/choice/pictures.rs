//! The pictures of the pre-pass.

use crate::color::Rgb;
use crate::film::{FilmSampler, Layer, ShadedPixels, Tiling};
use crate::image::Image;
use crate::integrators::context::PassContext;
use crate::integrators::many_light::{EFFORT_LAYERS, RELMSE_FLOOR};
use crate::integrators::path::sums_of_samples;
use crate::sampling::Pass;
use crate::scene::LimitedScene;
use crate::stats::Stats;

/// Groups of path samples.
const GROUPS: usize = 4;
/// Path samples per pixel for the count of shadow rays.
const COUNTED_SAMPLES: u32 = 2;
/// Changes the seed of the path samples.
const SEED: u64 = 0xc401_ce00_5eed;
/// Tiles of path samples: few pixels are rendered.
const TILING: Tiling = Tiling {
    edge: 16,
    ..Tiling::OF_STREAMS
};
/// Edge of a block, in pixels. If a filter follows, variances are those of means over blocks.
const BLOCK: usize = 4;
/// Fraction of the largest values that do not count: rare bright samples must not decide.
const TRIMMED: f64 = 0.02;

/// A picture to be filtered, with features that are nearly free of noise.
#[derive(Clone, Debug)]
pub struct FilterInput {
    /// Radiance.
    pub radiance: Image,
    /// Albedo of the first surfaces.
    pub albedo: Image,
    /// Their shading normals.
    pub normal: Image,
}

/// The terms that have weights, each by its layers.
const TERMS: [&[Layer]; 4] = [
    &[Layer::Emission],
    &[Layer::Direct],
    &[Layer::VirtualLights, Layer::Compensation],
    &[Layer::Caustics],
];

/// The radiance of a term, three values per pixel.
pub(super) type Term = Vec<f64>;

/// The pictures of the pre-pass, term by term.
pub(super) struct PrePass {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Passes by virtual lights.
    pub(super) lights: [[Term; 4]; 2],
    /// Groups of path samples; two of them take the computation of a pass.
    pub(super) groups: [[Term; 4]; GROUPS],
    /// Squared radiance to which errors are relative, by pixel.
    pub(super) scale: Vec<f64>,
    albedo: Image,
    normal: Image,
}

impl PrePass {
    /// Renders the groups of path samples. `samples` of them, two groups, take the computation of a
    /// pass by virtual lights.
    pub(super) fn new(
        lights: &[ShadedPixels; 2],
        pixels: &FilmSampler,
        scene: LimitedScene,
        run: &PassContext,
        samples: u32,
    ) -> Self {
        let per_group = samples.div_ceil(2);
        let layers = [&EFFORT_LAYERS[..], &[Layer::Albedo, Layer::Normal]].concat();
        let groups: [ShadedPixels; GROUPS] = std::array::from_fn(|g| {
            let seed = (run.pass.seed ^ SEED).wrapping_add(g as u64);
            let passes = (0..per_group).map(|index| Pass { seed, index });
            let layers = (layers.as_slice(), [].as_slice());
            sums_of_samples(scene, run, (pixels, TILING), layers, passes, |_| 1.0)
        });
        let size = pixels.size().as_usizevec2();
        let per_sample = 1.0 / f64::from(per_group);
        let mut pre_pass = PrePass {
            width: size.x,
            height: size.y,
            lights: lights.each_ref().map(|pass| terms(pass, 1.0)),
            groups: groups.each_ref().map(|group| terms(group, per_sample)),
            scale: Vec::new(),
            albedo: feature(&groups, Layer::Albedo, per_sample, 0.0),
            normal: feature(&groups, Layer::Normal, per_sample, -1.0),
        };
        pre_pass.scale = pre_pass.squared_radiance();
        pre_pass
    }

    /// The squared mean of all pictures, over 3x3 pixels, and that of the whole picture.
    fn squared_radiance(&self) -> Vec<f64> {
        let parts = self.lights.iter().chain(&self.groups);
        let mut mean = vec![0.0; self.width * self.height];
        for picture in parts.map(sum_of_terms) {
            for (mean, rgb) in mean.iter_mut().zip(picture.chunks_exact(3)) {
                *mean += rgb.iter().sum::<f64>() / (3 * (2 + GROUPS)) as f64;
            }
        }
        let whole = mean.iter().sum::<f64>() / mean.len().max(1) as f64;
        let (w, h) = (self.width, self.height);
        let around = |x: usize, end: usize| x.saturating_sub(1)..(x + 2).min(end);
        let mut scale = Vec::with_capacity(mean.len());
        for y in 0..h {
            for x in 0..w {
                let (rows, columns) = (around(y, h), around(x, w));
                let count = rows.len() * columns.len();
                let sum: f64 = rows
                    .map(|y| mean[y * w..][columns.clone()].iter().sum::<f64>())
                    .sum();
                scale.push((sum / count as f64).powi(2) + RELMSE_FLOOR * whole * whole);
            }
        }
        scale
    }

    /// Relative variances of each term, of the path samples of two groups and of a pass by virtual
    /// lights: of the means of blocks if a filter follows, which removes the noise of pixels.
    pub(super) fn term_variances(&self, filtered: bool) -> [[f64; 2]; 4] {
        let edge = if filtered { BLOCK } else { 1 };
        let half = |a: &Term, b: &Term, factor: f64| {
            let spread: Term = a.iter().zip(b).map(|(a, b)| a - b).collect();
            factor * trimmed_mean(self.squares_of_blocks(&spread, edge))
        };
        std::array::from_fn(|t| {
            let [g0, g1, g2, g3] = self.groups.each_ref().map(|group| &group[t]);
            let [a, b] = self.lights.each_ref().map(|pass| &pass[t]);
            // The mean of two groups has half the variance of one.
            let path = 0.5 * (half(g0, g1, 0.25) + half(g2, g3, 0.25));
            [path, half(a, b, 0.5)]
        })
    }

    /// Relative squares of the means of blocks of `edge` pixels, times their number of pixels.
    pub(super) fn squares_of_blocks(&self, values: &[f64], edge: usize) -> Vec<f64> {
        let blocks = self.blocks(edge);
        let square = |pixels: Vec<usize>| {
            let count = pixels.len() as f64;
            let scale = pixels.iter().map(|&i| self.scale[i]).sum::<f64>() / count;
            let square = |c: usize| {
                let sum: f64 = pixels.iter().map(|&i| values[3 * i + c]).sum();
                sum * sum / count
            };
            (0..3).map(square).sum::<f64>() / (3.0 * scale)
        };
        let squares = blocks.into_iter().map(square);
        squares.filter(|square| square.is_finite()).collect()
    }

    /// The indices of the pixels of each block.
    pub(super) fn blocks(&self, edge: usize) -> Vec<Vec<usize>> {
        let mut blocks = Vec::new();
        for y in (0..self.height).step_by(edge) {
            for x in (0..self.width).step_by(edge) {
                let rows = y..(y + edge).min(self.height);
                let columns = x..(x + edge).min(self.width);
                let pixels = rows.flat_map(|y| columns.clone().map(move |x| y * self.width + x));
                blocks.push(pixels.collect());
            }
        }
        blocks
    }

    /// A picture for the filter.
    pub(super) fn filter_input(&self, radiance: &[f64]) -> FilterInput {
        FilterInput {
            radiance: Image {
                data: radiance.iter().map(|&v| v as f32).collect(),
                ..Image::new(self.width, self.height, 3)
            },
            albedo: self.albedo.clone(),
            normal: self.normal.clone(),
        }
    }
}

/// Shadow rays of a path sample, in the mean over the pixels of the pre-pass.
pub(super) fn shadow_rays_per_sample(
    pixels: &FilmSampler,
    scene: LimitedScene,
    run: &PassContext,
) -> f64 {
    let seed = !(run.pass.seed ^ SEED);
    let passes = (0..COUNTED_SAMPLES).map(|index| Pass { seed, index });
    let before = Stats::get(&run.stats.shadow_rays);
    let layers = ([Layer::Beauty].as_slice(), [].as_slice());
    sums_of_samples(scene, run, (pixels, TILING), layers, passes, |_| 1.0);
    let rays = Stats::get(&run.stats.shadow_rays) - before;
    let size = pixels.size().as_dvec2();
    rays as f64 / (size.x * size.y * f64::from(COUNTED_SAMPLES))
}

/// The mean without the largest values.
pub(super) fn trimmed_mean(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let kept = values.len() - (TRIMMED * values.len() as f64).ceil() as usize;
    values[..kept].iter().sum::<f64>() / kept.max(1) as f64
}

/// The picture of all terms.
pub(super) fn sum_of_terms(terms: &[Term; 4]) -> Term {
    let [a, b, c, d] = terms;
    (0..a.len()).map(|i| a[i] + b[i] + c[i] + d[i]).collect()
}

/// The terms of shaded pixels, times `factor`. Values that are not finite count as black.
fn terms(shaded: &ShadedPixels, factor: f64) -> [Term; 4] {
    TERMS.map(|layers| {
        let sum = |pixel: &[Rgb]| {
            let is_part = |l: &usize| layers.contains(&shaded.layers[*l]);
            let parts = (0..pixel.len()).filter(is_part).map(|l| pixel[l]);
            let sum = parts.fold(Rgb::BLACK, |sum, part| sum + part).to_array();
            sum.map(|v| {
                if v.is_finite() {
                    f64::from(v) * factor
                } else {
                    0.0
                }
            })
        };
        let pixels = shaded.values.chunks_exact(shaded.layers.len());
        pixels.flat_map(sum).collect()
    })
}

/// The mean of a layer over all groups, clamped to [`least`, 1].
fn feature(groups: &[ShadedPixels; GROUPS], layer: Layer, per_sample: f64, least: f32) -> Image {
    let size = groups[0].size.as_usizevec2();
    let mut image = Image::new(size.x, size.y, 3);
    let factor = (per_sample / GROUPS as f64) as f32;
    for group in groups {
        let Some(l) = group.layers.iter().position(|&other| other == layer) else {
            continue;
        };
        let pixels = group.values.chunks_exact(group.layers.len());
        for (sum, pixel) in image.data.chunks_exact_mut(3).zip(pixels) {
            for (sum, value) in sum.iter_mut().zip(pixel[l].to_array()) {
                *sum += value * factor;
            }
        }
    }
    for value in &mut image.data {
        *value = if value.is_finite() {
            value.clamp(least, 1.0)
        } else {
            0.0
        };
    }
    image
}

#[cfg(test)]
impl PrePass {
    /// Pictures of constant radiance, all of it emitted.
    pub(super) fn constant(lights: [f64; 2], groups: [f64; GROUPS]) -> Self {
        let (width, height) = (16, 16);
        let zero = || vec![0.0; 3 * width * height];
        let terms = |value: f64| [vec![value; 3 * width * height], zero(), zero(), zero()];
        let mut pre_pass = PrePass {
            width,
            height,
            lights: lights.map(terms),
            groups: groups.map(terms),
            scale: Vec::new(),
            albedo: Image::new(width, height, 3),
            normal: Image::new(width, height, 3),
        };
        pre_pass.scale = pre_pass.squared_radiance();
        pre_pass
    }
}
