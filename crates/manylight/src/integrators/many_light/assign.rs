//! Stage 3: the flux of the photons is assigned to the lights.

use super::axes::{EmissionKind, FluxRule};
use super::place::Candidates;
use super::schedule::PassGroup;
use super::settings::ManyLight;
use crate::gather::Kernel;
use crate::integrators::context::PassContext;
use crate::scene::Scene;
use crate::virtual_lights::assign::assign;
use crate::virtual_lights::density::by_density;
use crate::virtual_lights::{NearestLights, PhotonClusters, Site};

/// The photons that each light represents, and the light that a photon anywhere would be assigned to. Under the density rule
/// photons are assigned to no light.
pub(super) fn clusters(
    method: &ManyLight,
    scene: &Scene,
    group: &PassGroup,
    candidates: &Candidates,
    sites: &[Site],
    run: &PassContext,
) -> (PhotonClusters, NearestLights) {
    let photons = &candidates.photons;
    run.stats.time("lights", || match method.flux {
        FluxRule::Partition => {
            let u = candidates.u_unassigned;
            assign(scene, photons, sites, &candidates.weights, u)
        }
        FluxRule::Density => {
            // The extent of a disc needs neighbors, even where the emission is that of one photon.
            let is_single =
                method.emission == EmissionKind::Single && method.kernel != Kernel::Disc;
            let clusters = if is_single {
                PhotonClusters::own(sites)
            } else {
                by_density(scene, photons, sites, group.neighbors as usize)
            };
            (clusters, NearestLights::none())
        }
    })
}
