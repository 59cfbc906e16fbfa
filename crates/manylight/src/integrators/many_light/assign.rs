//! Stage 3: the flux of the photons is assigned to the lights.

use super::place::Candidates;
use super::schedule::GroupContext;
use super::settings::{EmissionKind, FluxRule};
use crate::gather::Kernel;
use crate::virtual_lights::assign::assign;
use crate::virtual_lights::density::by_density;
use crate::virtual_lights::{NearestLights, PhotonClusters, Site};

/// The photons that each light represents, and the light that a photon anywhere would be assigned to. Under the density rule
/// photons are assigned to no light.
pub(super) fn clusters(
    cx: &GroupContext,
    candidates: &Candidates,
    sites: &[Site],
) -> (PhotonClusters, NearestLights) {
    let (method, photons) = (cx.method, &candidates.photons);
    cx.run.stats.time("lights", || match method.flux {
        FluxRule::Partition => {
            let u = candidates.u_unassigned;
            assign(cx.scene, photons, sites, &candidates.weights, u)
        }
        FluxRule::Density => {
            // The extent of a disc needs neighbors, even where the emission is that of one photon.
            let is_single =
                method.emission == EmissionKind::Single && method.kernel != Kernel::Disc;
            let clusters = if is_single {
                PhotonClusters::single_photons(sites)
            } else {
                by_density(cx.scene, photons, sites, cx.group.neighbors as usize)
            };
            (clusters, NearestLights::empty())
        }
    })
}
