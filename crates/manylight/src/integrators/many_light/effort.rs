//! The effort of a pass: how many virtual lights it sums, how many emitters it samples, and how many camera paths a pixel has, by
//! the variance of each term of the path partition.
//!
//! A pre-pass shades some pixels twice, with independent lights, at several efforts. The variance of a pass with `n` lights, `E`
//! emitter samples per direction and `S` camera paths per pixel is modelled as `V = a + b/n + c/E + d/S`, and its cost as linear in
//! all three. The smallest product of variance and cost gives the smallest error at equal time. The variance also sets the threshold
//! of roulette before shadow rays.
//!
//! The choice depends on the scene, the settings and the seed alone, so that a pass is the same in every render. The samples
//! of the pre-pass are not used again: no estimate depends on its own noise.

use super::gathering::DIRECTIONS;
use super::pre_pass::TermVariances;
use super::prepared::PreparedPasses;
use super::settings::{Effort, ManyLight};
use crate::gather::Strategy;
use crate::integrators::context::PassContext;
use crate::scene::{PathLimits, Scene};

/// Factors on the number of lights that are considered.
const LIGHT_FRACTIONS: [f32; 4] = [1.0, 0.5, 0.25, 0.125];
/// Emitter samples per direction that are considered.
const EMITTER_SAMPLES: [u32; 4] = [1, 2, 4, 8];
/// Camera paths per pixel that are considered.
const CAMERA_PATHS: [u32; 2] = [4, 8];
/// Fraction of the lights and photons with which the pre-pass measures.
const MEASURED_FRACTION: f32 = 0.25;
/// Emitter samples and camera paths with which the pre-pass measures.
const MEASURED: [(u32, u32); 3] = [(2, 4), (8, 4), (2, 8)];
/// Least gain in the product of variance and cost for which the effort changes. With 1.15, the noise of the pre-pass changed the effort
/// in the CBox, at a loss of a third at 30 s.
const LEAST_GAIN: f64 = 1.3;
/// Cycles per pixel and pass, measured by a profile of the Garage, and for camera paths by the times of four scenes with 4 and 8 of
/// them: of a light in the sum, of an emitter sample, of a camera path, and of all the rest.
const LIGHT_CYCLES: f64 = 780.0;
const EMITTER_SAMPLE_CYCLES: f64 = 2500.0;
const CAMERA_PATH_CYCLES: f64 = 35_000.0;
const REST_CYCLES: f64 = 150_000.0;

/// Threshold of roulette, in mean lights, per light and relative noise of a pass. Veach's analysis gives the square root of the time of
/// a shadow ray over that of a pixel. Measured at 0, 0.03 and 0.06, over 4 passes at 160x90, without the worst thousandth of the
/// pixels: variance times time is 1, 0.90 and 0.89 in the Kitchen, 1, 0.97 and 1.01 in the U-Shape, 1, 0.93 and 0.93 in the Disco, 1, 1.01
/// and 1.00 in the CBox.
const ROULETTE_PER_NOISE: f32 = 0.03;

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

    /// Variance times cost.
    fn error(&self, effort: &ManyLight) -> f64 {
        let emitter_samples = f64::from(DIRECTIONS * effort.emitter_samples);
        let cost = REST_CYCLES
            + LIGHT_CYCLES * f64::from(effort.light_count)
            + EMITTER_SAMPLE_CYCLES * emitter_samples
            + CAMERA_PATH_CYCLES * f64::from(effort.camera_paths);
        self.variance(effort) * cost
    }

    /// The threshold of roulette, in proportion to the noise of a pass: in a noisy pass, noise by roulette costs less than shadow rays.
    fn roulette(&self, effort: &ManyLight) -> f32 {
        let noise = self.variance(effort).sqrt() as f32;
        ROULETTE_PER_NOISE * noise * effort.light_count as f32
    }
}

impl ManyLight {
    /// These settings with their effort fixed: measured, if they ask for that.
    pub(in crate::integrators) fn with_fixed_effort(
        &self,
        scene: &Scene,
        limits: PathLimits,
        run: &PassContext,
    ) -> Self {
        let fixed = ManyLight {
            effort: Effort::Fixed,
            ..*self
        };
        if self.effort == Effort::Fixed || self.strategy != Strategy::All {
            return fixed;
        }
        let measured = fixed.with_lights(MEASURED_FRACTION);
        let variants = MEASURED.map(|(emitter_samples, camera_paths)| {
            move |prepared: &mut PreparedPasses| {
                prepared.emitter_samples = emitter_samples;
                prepared.camera_paths = camera_paths;
            }
        });
        let variances = (run.stats).time("effort", || {
            measured.term_variances(scene, limits, run, variants)
        });
        let model = PassModel::new(variances, f64::from(measured.light_count));
        let best = fixed
            .efforts()
            .min_by(|a, b| model.error(a).total_cmp(&model.error(b)));
        let best = best
            .filter(|best| model.error(best) * LEAST_GAIN < model.error(&fixed))
            .unwrap_or(fixed);
        ManyLight {
            roulette: model.roulette(&best),
            ..best
        }
    }

    /// These settings with the efforts that are considered.
    fn efforts(self) -> impl Iterator<Item = Self> {
        LIGHT_FRACTIONS.into_iter().flat_map(move |fraction| {
            EMITTER_SAMPLES
                .into_iter()
                .flat_map(move |emitter_samples| {
                    CAMERA_PATHS.map(|camera_paths| ManyLight {
                        emitter_samples,
                        camera_paths,
                        ..self.with_lights(fraction)
                    })
                })
        })
    }

    /// With this fraction of the lights and photons.
    fn with_lights(&self, fraction: f32) -> Self {
        let part = |count: u32| ((count as f32 * fraction) as u32).max(1);
        ManyLight {
            light_count: part(self.light_count),
            photon_paths: part(self.photon_paths),
            ..*self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let by_error = |a: &ManyLight, b: &ManyLight| model.error(a).total_cmp(&model.error(b));
        let best = ManyLight::rich_vpl().efforts().min_by(by_error).unwrap();
        (best.light_count, best.emitter_samples, best.camera_paths)
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
