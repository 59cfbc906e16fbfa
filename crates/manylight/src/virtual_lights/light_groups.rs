//! Virtual lights of several light groups: each group has its own lights, which represent its
//! photons alone. Lights are placed for all groups together; what depends on neighbors is done group
//! by group.

use super::assign::assign;
use super::candidates::Candidates;
use super::clusters::PhotonClusters;
use super::density::by_density;
use super::nearest_light::NearestLights;
use super::relax::relax;
use super::select::Site;
use super::surfaces::{SurfaceLocation, Surfaces};
use crate::ids::{LightGroup, LightId};
use std::ops::Range;

/// The nearest light of each light group to any location.
#[derive(Clone, Debug)]
pub struct NearestLightsOfGroups {
    /// By group.
    of_groups: Vec<NearestLights>,
}

impl NearestLightsOfGroups {
    /// Of one group.
    pub fn of_one(nearest: NearestLights) -> Self {
        NearestLightsOfGroups {
            of_groups: vec![nearest],
        }
    }

    /// Of `groups` groups without lights.
    pub fn none(groups: usize) -> Self {
        NearestLightsOfGroups {
            of_groups: vec![NearestLights::empty(); groups],
        }
    }

    /// The light to which a photon of `group` at `location` is assigned; `None` if it is unassigned.
    #[inline]
    pub fn light(
        &self,
        group: LightGroup,
        surfaces: &impl Surfaces,
        location: &SurfaceLocation,
    ) -> Option<LightId> {
        self.of_groups[group.index()].light(surfaces, location)
    }
}

/// [`relax`], group by group.
pub fn relax_groups(
    surfaces: &impl Surfaces,
    candidates: &Candidates,
    sites: &[Site],
) -> Vec<Site> {
    let mut relaxed = Vec::with_capacity(sites.len());
    for (photons, part, own) in parts(candidates, sites) {
        let moved = relax(surfaces, &part, &own);
        relaxed.extend(moved.into_iter().map(|site| Site {
            photon: site.photon + photons.start as u32,
            ..site
        }));
    }
    relaxed
}

/// [`assign`], group by group, of `groups` groups.
pub fn assign_groups(
    surfaces: &impl Surfaces,
    candidates: &Candidates,
    sites: &[Site],
    (u, groups): (f32, usize),
) -> (PhotonClusters, NearestLightsOfGroups) {
    let mut clusters = PhotonClusters::default();
    let mut of_groups = vec![NearestLights::empty(); groups];
    for (photons, part, own) in parts(candidates, sites) {
        let (of_group, mut nearest) = assign(surfaces, &part, &own, u);
        nearest.move_lights(clusters.len() as u32);
        clusters.append(of_group, photons.start as u32);
        of_groups[part.photons[0].group.index()] = nearest;
    }
    (clusters, NearestLightsOfGroups { of_groups })
}

/// [`by_density`], group by group.
pub fn by_density_of_groups(
    surfaces: &impl Surfaces,
    candidates: &Candidates,
    sites: &[Site],
    neighbors: usize,
) -> PhotonClusters {
    let mut clusters = PhotonClusters::default();
    for (photons, part, own) in parts(candidates, sites) {
        let of_group = by_density(surfaces, &part.photons, &own, neighbors);
        clusters.append(of_group, photons.start as u32);
    }
    clusters
}

/// The candidates of each group that has any, their place among all, and their sites.
fn parts<'a>(
    candidates: &'a Candidates,
    sites: &'a [Site],
) -> impl Iterator<Item = (Range<usize>, Candidates, Vec<Site>)> + 'a {
    (candidates.groups().into_iter()).map(move |photons| {
        let is_own = |site: &&Site| photons.contains(&(site.photon as usize));
        let own = sites.iter().filter(is_own).map(|site| Site {
            photon: site.photon - photons.start as u32,
            ..*site
        });
        let own = own.collect();
        (photons.clone(), candidates.part(photons), own)
    })
}
