//! Photon clusters: the photons that each light represents, with weights on their flux. Both flux
//! rules result in this.

use super::select::Site;
use rayon::prelude::*;

/// The future lights, in the order of the space-filling curve, each with its photons and their
/// weights.
#[derive(Clone, Debug, Default)]
pub struct PhotonClusters {
    pub(super) sites: Vec<Site>,
    /// Cluster `k` is `offsets[k]..offsets[k + 1]` of `photons` and `weights`.
    pub(super) offsets: Vec<u32>,
    pub(super) photons: Vec<u32>,
    /// Factors on the flux of the photons.
    pub(super) weights: Vec<f32>,
    /// See [`PhotonClusters::surface`].
    pub(super) surfaces: Vec<f32>,
    pub(super) unassigned_surface: f32,
}

impl PhotonClusters {
    /// Each site represents its own photon, with flux divided by the selection probability.
    pub fn single_photons(sites: &[Site]) -> Self {
        PhotonClusters::of_sites(sites, |site| vec![(site.photon, 1.0 / site.probability)])
    }

    /// Each site represents the photons, at least one, that `photons_of` lists with their weights.
    pub(super) fn of_sites(
        sites: &[Site],
        photons_of: impl Fn(&Site) -> Vec<(u32, f32)> + Sync + Send,
    ) -> Self {
        let lists: Vec<Vec<(u32, f32)>> = sites.par_iter().map(photons_of).collect();
        let mut clusters = PhotonClusters {
            sites: sites.to_vec(),
            offsets: vec![0],
            surfaces: vec![1.0; sites.len()],
            unassigned_surface: 1.0,
            ..PhotonClusters::default()
        };
        for (photon, weight) in lists.iter().flatten() {
            clusters.photons.push(*photon);
            clusters.weights.push(*weight);
        }
        clusters.offsets.extend(lists.iter().scan(0, |end, list| {
            *end += list.len() as u32;
            Some(*end)
        }));
        clusters
    }

    /// Clusters followed by `next`, with photons that are counted on from `first_photon`.
    pub(super) fn append(&mut self, next: PhotonClusters, first_photon: u32) {
        let entries = self.photons.len() as u32;
        let moved = |site: Site| Site {
            photon: site.photon + first_photon,
            ..site
        };
        self.sites.extend(next.sites.into_iter().map(moved));
        if self.offsets.is_empty() {
            self.offsets.push(0);
        }
        (self.offsets).extend(next.offsets.into_iter().skip(1).map(|end| end + entries));
        (self.photons).extend(next.photons.into_iter().map(|photon| photon + first_photon));
        self.weights.extend(next.weights);
        self.surfaces.extend(next.surfaces);
        self.unassigned_surface = next.unassigned_surface;
    }

    /// The photon at the position of each light.
    pub fn sites(&self) -> &[Site] {
        &self.sites
    }

    /// Number of lights.
    pub fn len(&self) -> usize {
        self.sites.len()
    }

    /// Whether there are no lights.
    pub fn is_empty(&self) -> bool {
        self.sites.is_empty()
    }

    /// The photons of light `k`, at least one: index and factor on the flux.
    #[inline]
    pub fn of(&self, k: usize) -> impl ExactSizeIterator<Item = (u32, f32)> + Clone {
        let range = self.offsets[k] as usize..self.offsets[k + 1] as usize;
        let photons = self.photons[range.clone()].iter().copied();
        photons.zip(self.weights[range].iter().copied())
    }

    /// Surface represented by light `k`, in units of the surface per light around it.
    #[inline]
    pub fn surface(&self, k: usize) -> f32 {
        self.surfaces[k]
    }

    /// Surface represented by the light that an unassigned photon becomes, in the same unit as
    /// [`PhotonClusters::surface`].
    pub fn unassigned_surface(&self) -> f32 {
        self.unassigned_surface
    }
}
