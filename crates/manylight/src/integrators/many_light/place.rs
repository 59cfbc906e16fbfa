//! Stage 2: photons are kept as sites of virtual lights, with probability proportional to importance times flux.

use super::radiance_cache::CacheParticles;
use super::schedule::GroupContext;
use super::settings::{FluxRule, Placement};
use super::trace;
use crate::particles::Photon;
use crate::sampling::Stream;
use crate::virtual_lights::candidates::{
    importance_times_flux, light_carriers, luminances, thin_photons,
};
use crate::virtual_lights::relax::relax;
use crate::virtual_lights::select::defensive_weights;
use crate::virtual_lights::{Site, select};

/// Most photons per light on average; more of them are thinned before the partition of flux. Unmeasured: beyond it, the
/// noise of the photons is small beside that of the light positions.
const PHOTONS_PER_LIGHT: usize = 1024;
/// Probability of placement that follows flux alone, relative to that which follows importance times flux. Where importons
/// have missed what matters, photons would otherwise be assigned to a few lights far off, which is a bias.
const PLACED_BY_FLUX: f32 = 0.1;

/// Photons that may become lights, with what placement follows.
pub(super) struct Candidates {
    /// In the order of the space-filling curve.
    pub(super) photons: Vec<Photon>,
    /// Weight of each photon: flux, or importance times flux.
    pub(super) weights: Vec<f32>,
    /// Random number of the selection of sites.
    u_sites: f32,
    /// Random number for thinning photons that no light can be assigned to.
    pub(super) u_unassigned: f32,
}

/// The candidates among `photons`, and those for the radiance cache. Importons are traced if placement follows importance.
pub(super) fn candidates(cx: &GroupContext, photons: Vec<Photon>) -> (Candidates, CacheParticles) {
    let stats = cx.run.stats;
    let photons = stats.time("lights", || light_carriers(cx.limits, photons));
    let weights: Vec<f32> = match cx.method.placement {
        Placement::Uniform => luminances(&photons),
        Placement::Importance | Placement::Relaxed => {
            let importons = trace::importons(cx);
            stats.time("importance", || importance_times_flux(&importons, &photons))
        }
    };
    let cache = stats.time("maps", || CacheParticles::draw(cx, &photons, &weights));
    let candidates = stats.time("lights", || thinned_candidates(cx, photons, weights));
    (candidates, cache)
}

/// Under the partition rule, keeps no more photons than the lights of the group need. Refined lights need fewer, until every
/// photon is a light.
pub(super) fn thinned_candidates(
    cx: &GroupContext,
    photons: Vec<Photon>,
    weights: Vec<f32>,
) -> Candidates {
    let mut sampler = cx.run.pass.sampler(Stream::Selection, 0);
    let (u_thinned, u_sites, u_unassigned) =
        (sampler.next_1d(), sampler.next_1d(), sampler.next_1d());
    let (photons, weights) = match cx.method.flux {
        FluxRule::Density => (photons, weights),
        FluxRule::Partition => {
            let refinement2 = cx.group.refinement * cx.group.refinement;
            let per_light = (PHOTONS_PER_LIGHT as f32 / refinement2).max(1.0);
            let most = (per_light * cx.group.placed_lights as f32) as usize;
            thin_photons(photons, weights, most, u_thinned)
        }
    };
    Candidates {
        photons,
        weights,
        u_sites,
        u_unassigned,
    }
}

/// The sites of the lights of a group, along the space-filling curve.
pub(super) fn sites(cx: &GroupContext, candidates: &Candidates) -> Vec<Site> {
    cx.run.stats.time("lights", || {
        let selected = selected_sites(cx, candidates);
        match cx.method.placement {
            Placement::Uniform | Placement::Importance => selected,
            Placement::Relaxed => relax(cx.scene, &candidates.photons, &selected),
        }
    })
}

/// The sites before relaxation.
pub(super) fn selected_sites(cx: &GroupContext, candidates: &Candidates) -> Vec<Site> {
    let Candidates {
        photons, weights, ..
    } = candidates;
    let count = cx.group.placed_lights as usize;
    match cx.method.placement {
        Placement::Uniform => select(photons, weights, count, candidates.u_sites),
        Placement::Importance | Placement::Relaxed => {
            let mixed = defensive_weights(weights, &luminances(photons), PLACED_BY_FLUX);
            select(photons, &mixed, count, candidates.u_sites)
        }
    }
}
