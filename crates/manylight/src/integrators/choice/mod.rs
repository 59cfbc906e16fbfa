//! The choice between path tracing, virtual lights, and the mean of both, by the error that each
//! leaves in a picture at equal cost.
//!
//! A pre-pass renders a small picture of the view: two passes by independent virtual lights, and
//! four groups of path samples. Two groups and a pass take the same computation by the counts of
//! rays and photons. The error of a method is the variance of its picture after the filter that the
//! render ends with, from the difference of two independent pictures, relative to the squared
//! radiance. The bias of the filter is left out: in a small picture it is far larger than in the
//! render, and much the same for all methods. An error against a path-traced reference, `(F(A) -
//! B)²` less the variance of `B`, has this bias, and the noise of `B`.
//!
//! The choice depends on the scene, the settings, the filter and the seed alone, so that it is the
//! same for all parts of a render. No sample of the pre-pass is used again.
//!
//! | file | content |
//! |---|---|
//! | `pictures` | the pictures of the pre-pass, and their means |
//! | `errors` | errors of the methods, and the light that path samples miss |

mod errors;
mod pictures;

use super::context::PassContext;
use super::many_light::{LightPictures, ManyLight};
use super::method::MethodKind;
use super::mixed::Mixed;
use crate::image::Image;
use crate::scene::{LimitedScene, Scene};
pub use pictures::FilterInput;
use pictures::{PrePass, shadow_rays_per_sample};
use std::num::NonZeroU32;

/// Constant part of a pass by virtual lights, in path samples. This and the next two are fitted to
/// processor times of eleven scenes at 256x144, with 256 lights: off by 8 % in the median, and by at
/// most 30 % (U-Shape and Disco are dearer, veach-ajar is cheaper).
const PASS_SAMPLES: f64 = 26.0;
/// Path samples per ratio of the shadow rays of a pixel to those of a path sample.
const SAMPLES_PER_RAY_RATIO: f64 = 0.24;
/// Path samples per photon path of the render and pixel.
const SAMPLES_PER_PHOTON_PATH: f64 = 1.2;
/// Least shadow rays of a path sample: scenes without lamps have none.
const MIN_RAYS: f64 = 0.5;
/// Most pixels of the pictures: those of 64x36, 144 blocks of 4x4 pixels. In the Glossy
/// Room the pre-pass takes half the time of a pass of 320x180 pixels.
const MAX_PICTURE_PIXELS: u32 = 2304;
/// Fewest path samples of the pre-pass that take the computation of a pass: four for each group.
const MIN_SAMPLES: u32 = 8;
/// Most of them: bounds the time of the pre-pass.
const MAX_SAMPLES: u32 = 256;
/// Ratio of errors within which the mean of both is chosen: the estimates are not more certain. The
/// mean of both has at most half the sum of both errors, so that it loses little by a wrong choice.
/// With the pictures of six seeds of 13 scenes, and the errors of both methods after 20 s, the error
/// of what is chosen is 1.064 times that of the better method in the geometric mean; at 1.0 and 1.3
/// it is 1.073 and 1.068 times.
const EVEN: f64 = 1.2;
/// Factor of the error of virtual lights after a filter: what of their noise neighbors share falls
/// slower with the size of the picture than other noise. It is the geometric mean over 13 scenes of
/// the ratio of the errors of `rich-vpl` and path tracing after 20 s, over that of pictures of 64x36:
/// from 1.15 in many-lights-bunny to 3.5 in staircase2. With 1.4 and 2.0 what is chosen has 1.086 and
/// 1.082 times the error of the better method, as for [`EVEN`].
const SHARED_NOISE: f64 = 1.7;
/// Passes after which errors are compared: noise has fallen by this factor, while light that path
/// samples miss is missed still. Ratio of the errors of `rich-vpl` and path tracing that are
/// predicted, and as measured after 4 passes: U-Shape 0.28, 0.16; Disco 0.54, 0.5; veach-ajar 0.46,
/// 1.1; without the factor 0.9, 1.9 and 0.9.
const COMPARED_PASSES: f64 = 4.0;
/// Steps of a weight: its text is exact.
const WEIGHT_STEPS: f64 = 64.0;

/// The filter that a render ends with; `None` if it fails.
pub type Filter<'f> = &'f dyn Fn(&FilterInput) -> Option<Image>;

/// What was chosen, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// [`MethodKind::Path`], [`MethodKind::ManyLight`], or
    /// [`MethodKind::Mixed`].
    pub kind: MethodKind,
    /// Path samples that take the computation of a pass by the virtual lights of the render.
    pub path_samples: NonZeroU32,
    /// The measured errors.
    pub errors: ChoiceErrors,
}

/// Estimates of the relative squared errors at equal computation, in the mean over pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChoiceErrors {
    /// Of path tracing.
    pub path: f64,
    /// Of virtual lights.
    pub lights: f64,
    /// Of the mean of both.
    pub mixed: f64,
    /// Of path tracing by light that its samples miss, beside `path`.
    pub missed: f64,
    /// Whether the pictures were filtered.
    pub filtered: bool,
}

/// The pre-pass of a choice.
pub struct ChoicePrePass {
    pictures: PrePass,
    lights: ManyLight,
    path_samples: NonZeroU32,
}

impl ChoicePrePass {
    /// Renders the pictures of path tracing and of `lights`.
    pub fn new(lights: &ManyLight, scene: LimitedScene, run: &PassContext) -> Self {
        let film = &scene.scene.sensor.desc().film;
        let pixels = film.reduced_sampler(MAX_PICTURE_PIXELS);
        run.stats.time("choice", || {
            let pictures = LightPictures::new(lights, scene, run, &pixels);
            let rays = shadow_rays_per_sample(&pixels, scene, run);
            let pass_cost = pass_in_samples(&pictures, scene.scene, rays);
            // The effort of the render reaches the variance of a pass at this cost.
            let samples = (pass_cost * pictures.inefficiency).round() as u32;
            let samples = samples.clamp(MIN_SAMPLES, MAX_SAMPLES);
            let path_samples = NonZeroU32::new((pass_cost * pictures.cost).round() as u32);
            ChoicePrePass {
                pictures: PrePass::new(&pictures.pictures, &pixels, scene, run, samples),
                lights: *lights,
                path_samples: path_samples.unwrap_or(NonZeroU32::MIN),
            }
        })
    }

    /// The choice for a render that ends with `filter`; as rendered without one, or where it fails.
    pub fn choice(&self, filter: Option<Filter>) -> Choice {
        let errors = self.pictures.errors(filter);
        let mixed = Mixed {
            lights: self.lights,
            path_samples: self.path_samples,
            weights: self.pictures.weights(filter.is_some()),
        };
        Choice {
            kind: best(&errors, mixed),
            path_samples: self.path_samples,
            errors,
        }
    }
}

/// A pass of the pre-pass in path samples with `rays` shadow rays, in a render of the film.
fn pass_in_samples(pass: &LightPictures, scene: &Scene, rays: f64) -> f64 {
    let film = scene.sensor.desc().film.crop_size.as_dvec2();
    PASS_SAMPLES
        + SAMPLES_PER_RAY_RATIO * pass.shadow_rays / rays.max(MIN_RAYS)
        + SAMPLES_PER_PHOTON_PATH * f64::from(pass.photon_paths) / (film.x * film.y)
}

/// The method with the least error; the mean of both where the errors are even.
fn best(errors: &ChoiceErrors, mixed: Mixed) -> MethodKind {
    let lights = errors.lights;
    let path = errors.path + COMPARED_PASSES * errors.missed;
    if errors.mixed < path.min(lights) {
        MethodKind::Mixed(mixed)
    } else if lights > 0.0 && EVEN * lights <= path {
        MethodKind::ManyLight(mixed.lights)
    } else if EVEN * path <= lights {
        MethodKind::Path
    } else {
        MethodKind::Mixed(mixed)
    }
}

/// The weight of path samples with the variance `path` beside a pass with the variance `lights`.
fn weight(path: f64, lights: f64) -> f32 {
    let weight = lights / (path + lights);
    let weight = if weight.is_finite() { weight } else { 0.5 };
    ((weight * WEIGHT_STEPS).round() / WEIGHT_STEPS) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrators::mixed::PathWeights;

    fn errors(path: f64, lights: f64, mixed: f64) -> ChoiceErrors {
        ChoiceErrors {
            path,
            lights,
            mixed,
            missed: 0.0,
            filtered: false,
        }
    }

    fn mixed() -> Mixed {
        Mixed {
            lights: ManyLight::rich_vpl(),
            path_samples: NonZeroU32::MIN,
            weights: PathWeights {
                emission: 0.5,
                direct: 0.5,
                indirect: 0.5,
                caustics: 0.5,
            },
        }
    }

    fn chosen(path: f64, lights: f64, both: f64) -> MethodKind {
        best(&errors(path, lights, both), mixed())
    }

    #[test]
    fn the_least_error_is_chosen_and_the_mean_of_both_where_they_are_even() {
        assert_eq!(chosen(1.0, 3.0, 2.0), MethodKind::Path);
        assert!(matches!(chosen(3.0, 1.0, 2.0), MethodKind::ManyLight(_)));
        assert!(matches!(chosen(1.0, 1.1, 1.3), MethodKind::Mixed(_)));
        assert!(matches!(chosen(3.0, 1.0, 0.9), MethodKind::Mixed(_)));
        let missed = |missed| ChoiceErrors {
            missed,
            ..errors(1.0, 3.0, 4.0)
        };
        assert!(matches!(best(&missed(0.5), mixed()), MethodKind::Mixed(_)));
        assert!(matches!(
            best(&missed(1.0), mixed()),
            MethodKind::ManyLight(_)
        ));
        // Nothing has noise: path tracing takes the least time.
        assert_eq!(chosen(0.0, 0.0, 0.0), MethodKind::Path);
    }

    #[test]
    fn weights_are_inverse_to_variances() {
        assert_eq!(weight(1.0, 3.0), 0.75);
        assert_eq!(weight(0.0, 1.0), 1.0);
        assert_eq!(weight(0.0, 0.0), 0.5);
        assert_eq!(weight(1.0, 1.01), 0.5);
    }
}
