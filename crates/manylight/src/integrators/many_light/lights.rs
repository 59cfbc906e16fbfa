//! Stages 2 to 4: photons become virtual lights. Each stage calls what [`crate::virtual_lights`]
//! does for the choices of the method.

use super::schedule::{GroupContext, LightSubsets, PassGroup};
use super::trace;
use super::{ClampRule, Compensation, EmissionKind, FluxRule, ManyLight, Placement};
use crate::gather::{Clamp, CutLimits, Gather, Gathered, LightIndex, ShadingPoint, Strategy};
use crate::maps::KdTree;
use crate::particles::{Importon, Photon};
use crate::sampling::Stream;
use crate::stats::Stats;
use crate::virtual_lights::candidates::Candidates;
use crate::virtual_lights::light_groups::{
    NearestLightsOfGroups, assign_groups, by_density_of_groups, relax_groups,
};
use crate::virtual_lights::{PhotonClusters, Site, VirtualLights, build_lights, select};
use std::borrow::Borrow;

/// Most photons per light on average; more of them are thinned before the partition of flux. The
/// flux of a light of n photons has a relative standard deviation of about `1/√n`, 3 %: 4.4 % with
/// half as many, 2.2 % with twice as many.
const PHOTONS_PER_LIGHT: usize = 1024;
/// Probability of placement that follows flux alone, relative to that which follows importance
/// times flux. Where importons have missed what matters, photons would otherwise be assigned to a
/// few lights far off, which is a bias. At 0.05 and 0.2 (2 passes of 128 lights at 72x40, 6 seeds;
/// Kitchen, Glossy Room, U-Shape): relMSE -1.9 and -1.3 % (standard error 2 %).
const PLACED_BY_FLUX: f32 = 0.1;

/// Factor on the area that a light represents in [`Clamp::Auto`] where clamping is compensated:
/// directions estimate the light of near surfaces with less noise than lights. At 16 and 32 (8
/// passes at 160x90): relMSE times time +1 and +12 % in the Kitchen, +19 and +32 % in the U-Shape. 4
/// was compared with 16 alone, which halves the variance of virtual lights in the Kitchen (0.0023
/// to 0.0012) and adds less to that of the compensation (0.0008 to 0.0015).
const COMPENSATED_CLAMP: f32 = 8.0;

/// Camera rays that estimate the mean of the sum over virtual lights. At 128 and 512 (a pass of
/// 4096 lights at 72x40, 3 seeds; Glossy Room, Kitchen): relMSE -0.1 and -0.2 %.
const PROBES: u32 = 256;
/// Most clusters of the cut at a probe. The sum over a cut is unbiased, and its noise averages over
/// the probes. At 32 and 128 (a pass of 4096 lights at 72x40, 3 seeds; Glossy Room, Kitchen):
/// relMSE 0 and -0.3 %.
const PROBE_CUT: u32 = 64;
/// A pixel counts as no darker than this fraction of that mean: smaller errors are not seen. At
/// 0.025 and 0.1 (a pass of 4096 lights at 72x40, 3 seeds; Glossy Room, Kitchen): relMSE -1.0 and
/// -1.0 % (standard error 1 %).
pub const DARKEST_PIXEL: f32 = 0.05;

/// Random numbers of the selection of lights.
struct SelectionNumbers {
    thinning: f32,
    sites: f32,
    /// Of photons that are assigned to no light.
    unassigned: f32,
}

impl SelectionNumbers {
    fn of(cx: &GroupContext) -> Self {
        let mut sampler = cx.run.pass.sampler(Stream::Selection, 0);
        SelectionNumbers {
            thinning: sampler.next_1d(),
            sites: sampler.next_1d(),
            unassigned: sampler.next_1d(),
        }
    }
}

/// The photons that may become lights, with the weights that placement follows.
pub(super) fn candidates(cx: &GroupContext, photons: Vec<Photon>) -> Candidates {
    let candidates = (cx.run.stats).time("lights", || Candidates::by_flux(cx.limits, photons));
    weighted(cx, candidates, || trace::importons(cx))
}

/// `candidates` with the weights that placement follows: flux, or importance times flux, for which
/// `importons` are made.
pub(super) fn weighted<I: Borrow<KdTree<Importon>>>(
    cx: &GroupContext,
    candidates: Candidates,
    importons: impl FnOnce() -> I,
) -> Candidates {
    match cx.method.placement {
        Placement::Uniform => candidates,
        Placement::Importance | Placement::Relaxed => {
            let importons = importons();
            (cx.run.stats).time("importance", || {
                candidates.by_importance(importons.borrow())
            })
        }
    }
}

/// Under the partition rule, no more candidates than the lights of the group need. Refined lights
/// need fewer, until every photon is a light.
pub(super) fn thinned(cx: &GroupContext, candidates: Candidates) -> Candidates {
    cx.run.stats.time("lights", || match cx.method.flux {
        FluxRule::Density => candidates,
        FluxRule::Partition => {
            let refinement2 = cx.group.refinement * cx.group.refinement;
            let per_light = (PHOTONS_PER_LIGHT as f32 / refinement2).max(1.0);
            let most = (per_light * cx.group.placed_lights as f32) as usize;
            candidates.thinned(most, SelectionNumbers::of(cx).thinning)
        }
    })
}

/// The sites of the lights of a group, along the space-filling curve.
pub(super) fn sites(cx: &GroupContext, candidates: &Candidates) -> Vec<Site> {
    cx.run.stats.time("lights", || {
        let selected = selected_sites(cx, candidates);
        match cx.method.placement {
            Placement::Uniform | Placement::Importance => selected,
            Placement::Relaxed => relax_groups(cx.scene, candidates, &selected),
        }
    })
}

/// The sites before relaxation.
pub(super) fn selected_sites(cx: &GroupContext, candidates: &Candidates) -> Vec<Site> {
    let (count, u) = (
        cx.group.placed_lights as usize,
        SelectionNumbers::of(cx).sites,
    );
    let weights = match cx.method.placement {
        Placement::Uniform => candidates.weights.clone(),
        Placement::Importance | Placement::Relaxed => candidates.defensive_weights(PLACED_BY_FLUX),
    };
    let weights = candidates.with_lights_for_all_groups(weights);
    select(&candidates.photons, &weights, count, u)
}

/// The photons that each light represents, and the light that a photon anywhere would be assigned
/// to. Under the density rule photons are assigned to no light.
pub(super) fn clusters(
    cx: &GroupContext,
    candidates: &Candidates,
    sites: &[Site],
) -> (PhotonClusters, NearestLightsOfGroups) {
    let (method, groups) = (cx.method, cx.run.light_groups.max(1));
    cx.run.stats.time("lights", || match method.flux {
        FluxRule::Partition => {
            let u = SelectionNumbers::of(cx).unassigned;
            assign_groups(cx.scene, candidates, sites, (u, groups))
        }
        FluxRule::Density => {
            let is_single =
                method.emission == EmissionKind::Single && !method.kernel.needs_extent();
            let clusters = if is_single {
                PhotonClusters::single_photons(sites)
            } else {
                let neighbors = cx.group.neighbors as usize;
                by_density_of_groups(cx.scene, candidates, sites, neighbors)
            };
            (clusters, NearestLightsOfGroups::none(groups))
        }
    })
}

/// The virtual lights of the clusters. Lights that no pass shades with keep their position and flux
/// alone.
pub(super) fn lights<'s>(
    cx: &GroupContext<'_, 's>,
    photons: &[Photon],
    clusters: &PhotonClusters,
    subsets: &LightSubsets,
) -> VirtualLights<'s> {
    let stats = cx.run.stats;
    let form = cx.method.emission.glossy_form();
    let is_shaded = |k| subsets.is_shaded(k);
    let lights = stats.time("lights", || {
        build_lights(cx.scene, cx.limits, photons, clusters, form, is_shaded)
    });
    Stats::count(&stats.lights, lights.lights().len() as u64);
    Stats::count(&stats.light_bytes, lights.bytes() as u64);
    lights
}

/// The lights with what the strategy needs to evaluate them: for cuts, a tree.
pub(super) fn index<'s>(cx: &GroupContext, lights: VirtualLights<'s>) -> LightIndex<'s> {
    let lights = LightIndex::new(lights).of_groups(cx.run.light_groups);
    match cx.method.strategy {
        Strategy::All => lights,
        Strategy::Cuts(_) => cx.run.stats.time("tree", || lights.with_tree()),
        Strategy::Bidirectional(_) => {
            (cx.run.stats).time("tree", || lights.with_tree_of_bounded_lights())
        }
    }
}

/// How the lights are summed.
pub(super) fn gather(
    method: &ManyLight,
    group: &PassGroup,
    lights: &VirtualLights,
    subsets: &LightSubsets,
) -> Gather {
    // With compensation, the sum is complete whatever is clamped. A cut is through all lights:
    // refined ones are more.
    let refinement = match (method.compensation, method.strategy) {
        (Compensation::None, Strategy::All) => group.refinement,
        _ => 1.0,
    };
    let clamp = match method.clamp {
        ClampRule::None => Clamp::None,
        ClampRule::Auto => Clamp::Auto(match method.compensation {
            Compensation::None => 1.0,
            Compensation::KolligKeller => COMPENSATED_CLAMP,
        }),
        ClampRule::Fixed => {
            let area = lights.median_area() * subsets.count as f32;
            Clamp::Value(refinement / area.max(f32::MIN_POSITIVE))
        }
        ClampRule::Value(limit) => Clamp::Value(limit * refinement),
    };
    Gather {
        kernel: method.kernel,
        strategy: method.strategy,
        clamp,
        refinement,
        roulette: method.roulette,
    }
}

/// Radiance by which a cluster of lights may be off in any pixel, luminance in W/(m² sr); 0 without
/// cuts. Estimated from the mean of the sum over virtual lights at first surfaces, over camera rays;
/// it is 0 for rays that meet none.
pub(super) fn cut_tolerance(cx: &GroupContext, gather: &Gather, lights: &LightIndex) -> f32 {
    let Some(limits) = gather.strategy.cut_limits() else {
        return 0.0;
    };
    let scene = cx.scene;
    let probe = |k| {
        let mut sampler = cx.run.pass.sampler(Stream::ToleranceProbe, k);
        let ray = scene.random_camera_ray(k, &mut sampler);
        let (_, x) = scene.intersect(&ray)?;
        Some(ShadingPoint::unlimited(x, -ray.d, scene.bsdf(&x)))
    };
    let probes: Vec<ShadingPoint> = (0..u64::from(PROBES)).filter_map(probe).collect();
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
