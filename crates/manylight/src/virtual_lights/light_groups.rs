//! Virtual lights of light groups: each group has its own lights, which represent its photons
//! alone. Lights are placed for all groups together; what depends on neighbors is done group by
//! group. Where groups are not told apart, all photons are of one.

use super::assign::assign;
use super::candidates::Candidates;
use super::clusters::PhotonClusters;
use super::density::by_density;
use super::nearest_light::NearestLights;
use super::relax::relax;
use super::select::Site;
use super::surfaces::{SurfaceLocation, Surfaces};
use crate::arrays::{FoundArray, InvalidArray, NamedArray};
use crate::ids::{LightGroup, LightId};
use std::borrow::Cow;
use std::ops::Range;

/// The nearest light of each light group to any location.
#[derive(Clone, Debug)]
pub struct NearestLightsOfGroups {
    /// By group.
    of_groups: Vec<NearestLights>,
}

impl NearestLightsOfGroups {
    /// Of `groups` groups without lights.
    pub fn none(groups: usize) -> Self {
        NearestLightsOfGroups {
            of_groups: vec![NearestLights::empty(); groups],
        }
    }

    /// As arrays.
    pub(crate) fn arrays(&self) -> Vec<NamedArray<'_>> {
        let of_groups = self.of_groups.iter().enumerate();
        of_groups
            .flat_map(|(group, nearest)| nearest.arrays(&prefix(group)))
            .collect()
    }

    /// The inverse of [`NearestLightsOfGroups::arrays`], of `groups` groups with `lights` lights.
    ///
    /// # Errors
    /// Those of `read`, and arrays of other lights.
    pub(crate) fn of_arrays<E: From<InvalidArray>>(
        groups: usize,
        lights: usize,
        read: &mut impl FnMut(&str) -> Result<FoundArray, E>,
    ) -> Result<Self, E> {
        let of_group = |group| NearestLights::of_arrays(&prefix(group), lights, read);
        let of_groups: Result<Vec<NearestLights>, E> = (0..groups).map(of_group).collect();
        Ok(NearestLightsOfGroups {
            of_groups: of_groups?,
        })
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

/// Begin of the names of the arrays of a light group.
fn prefix(group: usize) -> String {
    format!("cells.{group}.")
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
) -> impl Iterator<Item = (Range<usize>, Cow<'a, Candidates>, Vec<Site>)> + 'a {
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

#[cfg(test)]
mod tests {
    use super::super::select::select;
    use super::super::testing::{OPEN, photons_on_square};
    use super::*;
    use crate::particles::Photon;
    use crate::scene::PathLimits;

    /// Photons of three groups; the last has one faint photon, which makes no site.
    fn candidates() -> Candidates {
        let mut photons = photons_on_square(6000, 3);
        for (j, photon) in photons.iter_mut().enumerate() {
            photon.group = LightGroup(u8::from(j % 3 == 0));
        }
        photons[17].group = LightGroup(2);
        photons[17].flux *= 1e-6;
        Candidates::by_flux(PathLimits::default(), photons)
    }

    /// Flux of the photons of a group, in W.
    fn flux<'p>(photons: impl Iterator<Item = (&'p Photon, f32)>, group: usize) -> f64 {
        let own = photons.filter(|(photon, _)| photon.group.index() == group);
        own.map(|(photon, weight)| f64::from(photon.flux.g * weight))
            .sum()
    }

    #[test]
    fn lights_represent_photons_of_one_group_and_all_of_them() {
        let candidates = candidates();
        let photons = &candidates.photons;
        let weights = candidates.with_lights_for_all_groups(candidates.weights.clone());
        assert!(photons.is_sorted_by_key(|photon| photon.group));
        let sites = select(photons, &weights, 200, 0.3);
        let (clusters, nearest) = assign_groups(&OPEN, &candidates, &sites, (0.6, 3));
        for k in 0..clusters.len() {
            let group = photons[clusters.sites()[k].photon as usize].group;
            let of_light = clusters.of(k).map(|(j, _)| photons[j as usize].group);
            assert!(
                of_light.into_iter().all(|other| other == group),
                "light {k}"
            );
        }
        for group in 0..3 {
            let of_lights = (0..clusters.len()).flat_map(|k| {
                clusters
                    .of(k)
                    .map(|(j, weight)| (&photons[j as usize], weight))
            });
            let found = flux(of_lights, group);
            let expected = flux(photons.iter().map(|photon| (photon, 1.0)), group);
            let error = (found / expected - 1.0).abs();
            assert!(error < 0.02, "group {group}: {found} and {expected}");
        }
        let photon = &photons[100];
        let location = SurfaceLocation::of_photon(photon, &OPEN);
        for group in 0..2 {
            let light = nearest.light(LightGroup(group), &OPEN, &location).unwrap();
            let site = clusters.sites()[light.index()];
            assert_eq!(photons[site.photon as usize].group, LightGroup(group));
        }
    }
}
