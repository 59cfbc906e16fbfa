//! The error that a cut may have in any pixel, from the mean of the sum over virtual lights at the first surfaces.

use crate::gather::{CutLimits, Gather, Gathered, LightIndex, ShadingPoint, Strategy, Subset};
use crate::sampling::{Pass, Stream};
use crate::scene::Scene;

/// Camera rays that estimate the mean of the sum over virtual lights. Unmeasured.
const PROBES: u32 = 256;
/// Most clusters of the cut at a probe. Unmeasured.
const PROBE_CUT: u32 = 64;
/// A pixel counts as no darker than this fraction of that mean: smaller errors are not seen. Unmeasured.
pub const DARKEST_PIXEL: f32 = 0.05;

/// Radiance by which a cluster of lights may be off in any pixel, luminance in W/(m² sr); 0 without cuts.
pub(super) fn tolerance(scene: &Scene, gather: &Gather, lights: &LightIndex, pass: Pass) -> f32 {
    let Some(limits) = gather.strategy.cut_limits() else {
        return 0.0;
    };
    // The sensor takes positions in the crop window.
    let size = scene.sensor.desc().film.crop_size.as_vec2();
    let probe = |k: u32| {
        let mut sampler = pass.sampler(Stream::Selection, 4 + u64::from(k));
        let film = sampler.next_2d() * size;
        let ray = scene.sensor.ray(film, sampler.next_2d()).ray;
        let (_, x) = scene.intersect(&ray)?;
        Some(ShadingPoint {
            x,
            wo: -ray.d,
            bsdf: scene.bsdf(&x),
            max_photon_depth: None,
            u: 0.5,
            lights: Subset::ALL,
            tolerance: 0.0,
            lit_from: None,
        })
    };
    let probes: Vec<ShadingPoint> = (0..PROBES).filter_map(probe).collect();
    let probe_gather = Gather {
        strategy: Strategy::Cuts(CutLimits {
            max_lights: PROBE_CUT,
            ..limits
        }),
        ..*gather
    };
    let sums = probe_gather.sum(scene, lights, &probes);
    let radiance = |sum: &Gathered| sum.radiance.luminance();
    let mean = sums.iter().map(radiance).sum::<f32>() / PROBES as f32;
    limits.max_error * DARKEST_PIXEL * mean
}
