//! The weighted mean of virtual lights and path tracing, term by term.
//!
//! Both methods estimate the same terms of the path partition, with independent noise. A term of a
//! pass is `(1 - w) x + w y`, with `x` the pass by virtual lights, `y` the mean of `k` path
//! samples, and `w` and `k` the same in all passes. The mean is that of both methods for any `w`,
//! and the noise is least where the weights are inverse to the variances. A film sees one pass:
//! variances, parts and resumed renders are those of any method.
//!
//! Virtual lights and compensation share paths, so that they have one weight. Path tracing brings
//! them all as [`Layer::VirtualLights`].

use super::context::PassContext;
use super::many_light::{ManyLight, PreparedGroups};
use super::path;
use crate::color::Rgb;
use crate::film::{Film, Layer, ShadedPixels, TileSamples, Tiling};
use crate::math::UVec2;
use crate::sampling::Pass;
use crate::scene::LimitedScene;
use std::num::NonZeroU32;

/// Changes the seed of the path samples, so that they do not share numbers with the camera paths of
/// the virtual lights.
const PATH_SEED: u64 = 0x70a7_4000_5eed;

/// The weighted mean of virtual lights and path tracing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mixed {
    /// The virtual lights.
    pub lights: ManyLight,
    /// Path samples per pixel and pass.
    pub path_samples: NonZeroU32,
    /// Their weights.
    pub weights: PathWeights,
}

/// The weights of the path samples by term, from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathWeights {
    /// Of [`Layer::Emission`].
    pub emission: f32,
    /// Of [`Layer::Direct`].
    pub direct: f32,
    /// Of [`Layer::VirtualLights`] and [`Layer::Compensation`].
    pub indirect: f32,
    /// Of [`Layer::Caustics`].
    pub caustics: f32,
}

impl Mixed {
    /// The weight of the path samples in `layer`. Layers of first surfaces count all camera paths
    /// alike.
    fn weight(&self, layer: Layer) -> f32 {
        match layer {
            Layer::Emission => self.weights.emission,
            Layer::Direct => self.weights.direct,
            Layer::VirtualLights | Layer::Compensation => self.weights.indirect,
            Layer::Caustics => self.weights.caustics,
            _ => {
                let samples = self.path_samples.get() as f32;
                samples / (samples + self.lights.camera_paths as f32)
            }
        }
    }

    /// One pass by virtual lights, with its path samples. `false` if cancelled.
    pub(super) fn render_pass<'s>(
        &self,
        scene: LimitedScene<'s>,
        run: &PassContext,
        kept: &mut PreparedGroups<'s>,
        film: &mut Film,
    ) -> bool {
        let paths = self.paths(scene, run, film);
        if run.cancelled() {
            return false;
        }
        let (samples, id_weight) = (self.path_samples.get(), self.weight(Layer::Alpha));
        let begin = |tile: &mut TileSamples| {
            tile.weigh_light_groups(|layer| 1.0 - self.weight(layer));
        };
        let end = |tile: &mut TileSamples| {
            tile.mix(&paths, samples, |layer| self.weight(layer), id_weight);
        };
        (self.lights).render_pass(scene, run, kept, film, (begin, end))
    }

    /// Sums of the path samples of a pass; unfinished if it is cancelled.
    fn paths(&self, scene: LimitedScene, run: &PassContext, film: &Film) -> ShadedPixels {
        let layers = (film.layers(), film.id_layers());
        let samples = self.path_samples.get();
        let Pass { seed, index } = run.pass;
        // Path tracing continues one sequence of samples in even passes and another in odd ones.
        // Here a half of the passes, to which whole groups belong, has one.
        let (half, place) = self.lights.place_in_half(index);
        let passes = (0..samples).map(|s| Pass {
            seed: seed ^ PATH_SEED,
            index: 2_u32
                .wrapping_mul(place.wrapping_mul(samples).wrapping_add(s))
                .wrapping_add(half.index() as u32),
        });
        run.stats.time("shade", || {
            let pixels = (&film.desc().sampler(), Tiling::OF_STREAMS);
            let weight = |layer| self.weight(layer);
            path::sums_of_samples(scene, run, pixels, layers, passes, weight)
        })
    }

    /// Memory of the path samples of a pass for `size` pixels, in bytes.
    pub(super) fn bytes_for(size: UVec2, layers: &[Layer]) -> u64 {
        let pixels = u64::from(size.x) * u64::from(size.y);
        pixels.saturating_mul((layers.len() * size_of::<Rgb>()) as u64)
    }
}
