//! The effort of a pass: how many virtual lights it sums, how many emitters it samples, and how
//! many camera paths a pixel has, by the variance of each term of the path partition.
//!
//! A pre-pass shades some pixels twice, with independent lights, at several efforts. The variance
//! of a pass with `n` lights, `E` emitter samples per direction and `S` camera paths per pixel is
//! modelled as `V = a + b/n + c/E + d/S`, and its cost as linear in all three. The smallest product
//! of variance and cost gives the smallest error at equal time. The variance also sets the
//! threshold of roulette before shadow rays. Photon paths grow with the pixels of the film.
//!
//! The choice depends on the scene, the settings and the seed alone, so that a pass is the same in
//! every render. The samples of the pre-pass are not used again: no estimate depends on its own
//! noise.

use super::gather_point::DIRECTIONS;
use super::schedule::{MAX_GROUP_PHOTON_PATHS, PassGroup};
use super::shade::tiling;
use super::{Effort, ManyLight, PreparedPasses};
use crate::color::Rgb;
use crate::film::{FilmSampler, Layer, ShadedPixels, shaded_pixels};
use crate::gather::Strategy;
use crate::integrators::context::PassContext;
use crate::sampling::{Pass, Stream};
use crate::scene::{LimitedScene, PathLimits, Scene};
use crate::stats::Stats;

/// Factors on the number of lights that are considered. Steps of two: an effort between two of them
/// has at most `(√2 + 1/√2)/2`, 1.06, of the least product of variance and cost.
const LIGHT_FRACTIONS: [f32; 4] = [1.0, 0.5, 0.25, 0.125];
/// Emitter samples per direction that are considered, likewise.
const EMITTER_SAMPLE_CHOICES: [u32; 4] = [1, 2, 4, 8];
/// Camera paths per pixel that are considered, likewise.
const CAMERA_PATH_CHOICES: [u32; 2] = [4, 8];
/// Fraction of the lights and photons with which the pre-pass measures: one of those considered. The
/// variance that it extrapolates is exactly as 1/n.
const MEASURED_FRACTION: f32 = 0.25;
/// Emitter samples and camera paths with which the pre-pass measures: as few as separate the terms
/// of [`PassModel`].
const MEASURED: [(u32, u32); 3] = [(2, 4), (8, 4), (2, 8)];
/// Least gain in the product of variance and cost for which the effort changes. With 1.15, the
/// noise of the pre-pass changed the effort in the CBox, at a loss of a third at 30 s.
const MIN_GAIN: f64 = 1.3;
/// Cycles per pixel and pass of a light in the sum, by a profile of the Garage.
const LIGHT_CYCLES: f64 = 780.0;
/// Cycles of an emitter sample, likewise.
const EMITTER_SAMPLE_CYCLES: f64 = 2500.0;
/// Cycles per pixel and pass of a camera path, by the times of four scenes with 4 and 8 of them.
const CAMERA_PATH_CYCLES: f64 = 35_000.0;
/// Cycles per pixel and pass of all the rest, by a profile of the Garage.
const REST_CYCLES: f64 = 150_000.0;

/// Threshold of roulette, in mean lights, per light and relative noise of a pass. Veach's analysis
/// gives the square root of the time of a shadow ray over that of a pixel. Measured at 0, 0.03 and
/// 0.06, over 4 passes at 160x90, without the worst thousandth of the pixels: variance times time
/// is 1, 0.90 and 0.89 in the Kitchen, 1, 0.97 and 1.01 in the U-Shape, 1, 0.93 and 0.93 in the
/// Disco, 1, 1.01 and 1.00 in the CBox.
const ROULETTE_PER_NOISE: f32 = 0.03;
/// Most pixels of the pre-pass. At 320x180 the pre-pass of 1620 pixels takes about a fifth of the
/// time of a pass.
const MAX_PIXELS: u32 = 2048;
/// Least spacing of their columns and rows: at most a sixteenth of the pixels of a small picture.
const MIN_SPACING: u32 = 4;
/// Largest variance of a pixel relative to its squared mean that counts: rare bright samples must
/// not decide.
const MAX_RELATIVE_VARIANCE: f64 = 1.0;
/// Squared radiance, relative to that of the mean of the image, below which variances count as
/// absolute, as in relMSE.
pub(in crate::integrators) const RELMSE_FLOOR: f64 = 0.01;
/// Most pixels of a picture with the photons of the preset. Larger ones have more in proportion, at
/// the same part of the time: kernels of density estimates shrink with the pixels, and would hold
/// single photons. At 640x360, three times as many photons take 1.17 of the time of 4 passes, and
/// relMSE is 1.00 (Kitchen) and 0.96 (Glossy Room) of that with the photons of the preset.
const SMALL_PICTURE_PIXELS: u32 = 640 * 360;
/// Layers that the pre-pass records: the beauty, and its terms.
pub(in crate::integrators) const LAYERS: [Layer; 6] = [
    Layer::Beauty,
    Layer::VirtualLights,
    Layer::Compensation,
    Layer::Direct,
    Layer::Emission,
    Layer::Caustics,
];
/// Terms of which the variance falls with the number of lights.
const INDIRECT: [Layer; 2] = [Layer::VirtualLights, Layer::Compensation];

/// A model of the variance and the cost of a pass.
#[derive(Clone, Copy, Debug)]
struct PassModel {
    constant: f64,
    /// Times one over the number of lights.
    lights: f64,
    /// Times one over the number of emitter samples.
    emitters: f64,
    /// Times one over the number of camera paths.
    camera: f64,
}

impl PassModel {
    /// Of the variances at the efforts [`MEASURED`], shaded with `lights` lights.
    fn new(variances: [TermVariances; 3], lights: f64) -> Self {
        let [base, more_emitters, more_paths] = variances;
        let [(e, s), (more_e, _), (_, more_s)] =
            MEASURED.map(|(e, s)| (1.0 / f64::from(e), 1.0 / f64::from(s)));
        let emitters = ((base.rest - more_emitters.rest) / (e - more_e)).max(0.0);
        let camera = ((base.rest - more_paths.rest) / (s - more_s)).max(0.0);
        let indirect = variances.iter().map(|v| v.indirect).sum::<f64>() / 3.0;
        PassModel {
            constant: (base.rest - emitters * e - camera * s).max(0.0),
            lights: indirect * lights,
            emitters,
            camera,
        }
    }

    /// Relative variance of a pass with this effort.
    fn variance(&self, effort: &ManyLight) -> f64 {
        self.constant
            + self.lights / f64::from(effort.light_count)
            + self.emitters / f64::from(effort.emitter_samples)
            + self.camera / f64::from(effort.camera_paths)
    }

    /// Variance times cost: the inverse of the efficiency of an estimator.
    fn inefficiency(&self, effort: &ManyLight) -> f64 {
        self.variance(effort) * cycles(effort)
    }

    /// The threshold of roulette, in proportion to the noise of a pass: in a noisy pass, noise by
    /// roulette costs less than shadow rays.
    fn roulette(&self, effort: &ManyLight) -> f32 {
        let noise = self.variance(effort).sqrt() as f32;
        ROULETTE_PER_NOISE * noise * effort.light_count as f32
    }
}

/// Cycles per pixel of a pass.
fn cycles(effort: &ManyLight) -> f64 {
    REST_CYCLES
        + LIGHT_CYCLES * f64::from(effort.light_count)
        + EMITTER_SAMPLE_CYCLES * f64::from(DIRECTIONS * effort.emitter_samples)
        + CAMERA_PATH_CYCLES * f64::from(effort.camera_paths)
}

/// A pass by the lights of a method, with other random numbers than those of the render's passes.
struct MeasuredPass<'s, 'r> {
    run: PassContext<'r>,
    prepared: PreparedPasses<'s>,
}

impl<'s: 'r, 'r> MeasuredPass<'s, 'r> {
    /// Pass `index` of the pre-pass, of the view in the middle of all.
    fn new(
        method: &ManyLight,
        LimitedScene { scene, limits }: LimitedScene<'s>,
        run: &PassContext<'r>,
        index: u32,
    ) -> Self {
        let (seed, views) = (!run.lights_seed, scene.views());
        let run = PassContext {
            camera: &views[views.len() / 2],
            ..run.with_pass(Pass { seed, index }).without_light_groups()
        };
        let group = PassGroup::single_pass(method, index);
        let prepared = method.prepare(scene, limits, &group, &run);
        MeasuredPass { run, prepared }
    }

    /// The layers [`LAYERS`] of `pixels`.
    fn shade(&self, method: &ManyLight, pixels: &FilmSampler) -> ShadedPixels {
        let layers = (LAYERS.as_slice(), [].as_slice());
        let tiling = tiling(method, self.run.pass);
        shaded_pixels(pixels.size(), tiling, layers, |samples| {
            self.prepared.shade_tile(&self.run, pixels, samples);
        })
    }
}

/// Pictures by two passes with independent virtual lights, for a choice between methods.
pub(in crate::integrators) struct LightPictures {
    /// The layers [`LAYERS`] of the pictures.
    pub(in crate::integrators) pictures: [ShadedPixels; 2],
    /// Shadow rays per pixel of a pass.
    pub(in crate::integrators) shadow_rays: f64,
    /// Photon paths of a pass of the render with these lights.
    pub(in crate::integrators) photon_paths: u32,
    /// Cost of a pass of the render over that of a pass of the pictures, by the model.
    pub(in crate::integrators) cost: f64,
    /// Product of variance and cost, likewise.
    pub(in crate::integrators) inefficiency: f64,
}

impl LightPictures {
    /// Shades `pixels` with few of the lights of `method`.
    pub(in crate::integrators) fn new(
        method: &ManyLight,
        scene: LimitedScene,
        run: &PassContext,
        pixels: &FilmSampler,
    ) -> Self {
        let (emitter_samples, camera_paths) = MEASURED[0];
        let shaded = ManyLight {
            emitter_samples,
            camera_paths,
            effort: Effort::Fixed,
            ..with_lights(method, MEASURED_FRACTION)
        };
        let before = Stats::get(&run.stats.shadow_rays);
        let pictures = [0, 1].map(|index| {
            let pass = MeasuredPass::new(&shaded, scene, run, index);
            pass.shade(&shaded, pixels)
        });
        let shadow_rays = (Stats::get(&run.stats.shadow_rays) - before) as f64;
        let [a, b] = &pictures;
        let relative = relative_effort(method, &shaded, variances(&a.values, &b.values));
        LightPictures {
            shadow_rays: shadow_rays / f64::from(2 * pixels.size().x * pixels.size().y),
            pictures,
            photon_paths: with_most_photons(&with_lights(method, MEASURED_FRACTION), scene.scene)
                .photon_paths,
            cost: relative.cost,
            inefficiency: relative.inefficiency,
        }
    }
}

/// Cost, and product of variance and cost, of a pass over those of another pass.
struct RelativeEffort {
    cost: f64,
    inefficiency: f64,
}

/// Of a pass of `method` relative to one of `shaded`, with which the variances were measured. A
/// measured effort is taken to have the best number of lights.
fn relative_effort(
    method: &ManyLight,
    shaded: &ManyLight,
    variances: TermVariances,
) -> RelativeEffort {
    let model = PassModel {
        constant: variances.rest,
        lights: variances.indirect * f64::from(shaded.light_count),
        emitters: 0.0,
        camera: 0.0,
    };
    let fractions = match method.effort {
        Effort::Fixed => &LIGHT_FRACTIONS[..1],
        Effort::Measured => &LIGHT_FRACTIONS[..],
    };
    let efforts = fractions
        .iter()
        .map(|&fraction| with_lights(method, fraction));
    let best = efforts.min_by(|a, b| model.inefficiency(a).total_cmp(&model.inefficiency(b)));
    let best = best.unwrap_or(*method);
    let inefficiency = model.inefficiency(&best) / model.inefficiency(shaded);
    RelativeEffort {
        cost: cycles(&best) / cycles(shaded),
        inefficiency: if inefficiency.is_finite() {
            inefficiency
        } else {
            1.0
        },
    }
}

/// `method` with its effort fixed: measured, if it asks for that.
pub(in crate::integrators) fn with_fixed_effort(
    method: &ManyLight,
    scene: &Scene,
    limits: PathLimits,
    run: &PassContext,
) -> ManyLight {
    let fixed = ManyLight {
        effort: Effort::Fixed,
        ..*method
    };
    if method.effort == Effort::Fixed || method.strategy != Strategy::All {
        return fixed;
    }
    let measured = with_lights(&fixed, MEASURED_FRACTION);
    let variants = MEASURED.map(|(emitter_samples, camera_paths)| {
        move |prepared: &mut PreparedPasses| {
            prepared.emitter_samples = emitter_samples;
            prepared.camera_paths = camera_paths;
        }
    });
    let variances = (run.stats).time("effort", || {
        term_variances(&measured, LimitedScene { scene, limits }, run, variants)
    });
    let model = PassModel::new(variances, f64::from(measured.light_count));
    let best =
        efforts(fixed).min_by(|a, b| model.inefficiency(a).total_cmp(&model.inefficiency(b)));
    let best = best
        .filter(|best| model.inefficiency(best) * MIN_GAIN < model.inefficiency(&fixed))
        .unwrap_or(fixed);
    ManyLight {
        roulette: model.roulette(&best),
        photon_paths: paths_for_film(best.photon_paths, scene),
        ..best
    }
}

/// Photon paths per pass for the film of `scene`, of which a small picture has `paths`.
fn paths_for_film(paths: u32, scene: &Scene) -> u32 {
    let film = scene.sensor.desc().film.crop_size;
    let pixels = u64::from(film.x) * u64::from(film.y);
    let scaled = u64::from(paths) * pixels / u64::from(SMALL_PICTURE_PIXELS);
    paths.max(scaled.min(u64::from(MAX_GROUP_PHOTON_PATHS)) as u32)
}

/// The method with the most photon paths that its effort may ask for in `scene`.
pub(in crate::integrators) fn with_most_photons(method: &ManyLight, scene: &Scene) -> ManyLight {
    let photon_paths = match method.effort {
        Effort::Fixed => method.photon_paths,
        Effort::Measured => paths_for_film(method.photon_paths, scene),
    };
    ManyLight {
        photon_paths,
        ..*method
    }
}

/// `method` with the efforts that are considered.
fn efforts(method: ManyLight) -> impl Iterator<Item = ManyLight> {
    LIGHT_FRACTIONS.into_iter().flat_map(move |fraction| {
        EMITTER_SAMPLE_CHOICES
            .into_iter()
            .flat_map(move |emitter_samples| {
                CAMERA_PATH_CHOICES.map(|camera_paths| ManyLight {
                    emitter_samples,
                    camera_paths,
                    ..with_lights(&method, fraction)
                })
            })
    })
}

/// `method` with this fraction of the lights and photons.
fn with_lights(method: &ManyLight, fraction: f32) -> ManyLight {
    let part = |count: u32| ((count as f32 * fraction) as u32).max(1);
    ManyLight {
        light_count: part(method.light_count),
        photon_paths: part(method.photon_paths),
        ..*method
    }
}

/// Relative variances of a pass, in the mean over pixels.
#[derive(Clone, Copy, Debug, Default)]
struct TermVariances {
    /// Virtual lights, and compensation of what clamping removes from them.
    indirect: f64,
    /// All other light.
    rest: f64,
}

/// Draws positions in at most [`MAX_PIXELS`] pixels: the crossings of columns and rows, one of each
/// in `spacing`, drawn at random.
fn sparse_pixels(scene: &Scene, pass: Pass) -> FilmSampler {
    let film = &scene.sensor.desc().film;
    let size = film.crop_size;
    let count = |spacing: u32| size.x.div_ceil(spacing) * size.y.div_ceil(spacing);
    let mut spacing = MIN_SPACING;
    while count(spacing) > MAX_PIXELS {
        spacing += 1;
    }
    let mut rng = pass.sampler(Stream::EffortPixels, 0);
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

/// The mean over pixels of the variances of a pass, by two passes with independent virtual lights.
/// The passes are changed by each of `variants` after the lights are made.
fn term_variances<const N: usize>(
    method: &ManyLight,
    scene: LimitedScene,
    run: &PassContext,
    variants: [impl Fn(&mut PreparedPasses); N],
) -> [TermVariances; N] {
    // Whichever pass comes first in this run.
    let pixels = sparse_pixels(scene.scene, run.of_lights(0).pass);
    let [a, b] = [0, 1].map(|index| {
        let mut pass = MeasuredPass::new(method, scene, run, index);
        variants.each_ref().map(|variant| {
            variant(&mut pass.prepared);
            pass.shade(method, &pixels).values
        })
    });
    std::array::from_fn(|k| variances(&a[k], &b[k]))
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
        let scale = mean.powi(2) + RELMSE_FLOOR * image * image;
        if !(scale > 0.0 && scale.is_finite()) {
            continue;
        }
        for ((x, y), layer) in x.iter().zip(y).zip(LAYERS).skip(1) {
            let difference = luminance(*x) - luminance(*y);
            let variance = 0.5 * difference * difference / scale;
            let term = match INDIRECT.contains(&layer) {
                true => &mut sum.indirect,
                false => &mut sum.rest,
            };
            *term += variance.min(MAX_RELATIVE_VARIANCE) / means.len() as f64;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::testing::scenes::Builder;

    /// Variances of a pass by the model, at the measured efforts.
    fn measured(constant: f64, lights: f64, emitters: f64, camera: f64) -> [TermVariances; 3] {
        MEASURED.map(|(e, s)| TermVariances {
            indirect: lights / 128.0,
            rest: constant + emitters / f64::from(e) + camera / f64::from(s),
        })
    }

    /// The effort that the model prefers.
    fn best(variances: [TermVariances; 3]) -> (u32, u32, u32) {
        let model = PassModel::new(variances, 128.0);
        let by_inefficiency =
            |a: &ManyLight, b: &ManyLight| model.inefficiency(a).total_cmp(&model.inefficiency(b));
        let best = efforts(ManyLight::rich_vpl())
            .min_by(by_inefficiency)
            .unwrap();
        (best.light_count, best.emitter_samples, best.camera_paths)
    }

    #[test]
    fn large_pictures_have_photons_in_proportion() {
        let paths = |size: [u32; 2], paths: u32| {
            let mut b = Builder::new(Vec3::Z, Vec3::ZERO, 90.0, 8);
            b.desc.sensors[0].film.size = size.into();
            b.desc.sensors[0].film.crop_size = size.into();
            paths_for_film(paths, &b.build())
        };
        assert_eq!(paths([64, 36], 262_144), 262_144);
        assert_eq!(paths([640, 360], 262_144), 262_144);
        assert_eq!(paths([1920, 1080], 262_144), 9 * 262_144);
        assert_eq!(paths([8000, 4000], 262_144), MAX_GROUP_PHOTON_PATHS);
        assert_eq!(paths([8000, 4000], 5_000_000), 5_000_000);
    }

    #[test]
    fn effort_goes_to_the_term_with_the_variance() {
        assert_eq!(best(measured(0.0, 1.0, 0.0, 0.0)), (512, 1, 4));
        assert_eq!(best(measured(0.0, 0.0, 1.0, 0.0)), (64, 8, 4));
        assert_eq!(best(measured(0.0, 0.0, 0.0, 1.0)), (64, 1, 8));
        assert_eq!(best(measured(1.0, 0.0, 0.0, 0.0)), (64, 1, 4));
    }

    #[test]
    fn the_model_meets_the_variances_that_it_is_made_of() {
        let model = PassModel::new(measured(0.1, 5.0, 0.2, 0.3), 128.0);
        for (found, expected) in [
            (model.constant, 0.1),
            (model.lights, 5.0),
            (model.emitters, 0.2),
            (model.camera, 0.3),
        ] {
            assert!((found - expected).abs() < 1e-9, "{found} for {expected}");
        }
    }
}
