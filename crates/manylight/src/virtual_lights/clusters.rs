//! What each light speaks for: photons with weights.

use super::Site;
use rayon::prelude::*;

/// Lights to be, in the order of the space-filling curve, and the photons that each speaks for.
#[derive(Clone, Debug, Default)]
pub struct PhotonClusters {
    pub(super) sites: Vec<Site>,
    /// Share `k` is `offsets[k]..offsets[k + 1]` of the photons and weights.
    pub(super) offsets: Vec<u32>,
    pub(super) photons: Vec<u32>,
    /// Factors on the flux of the photons.
    pub(super) weights: Vec<f32>,
    /// See [`PhotonClusters::surface`].
    pub(super) surfaces: Vec<f32>,
    pub(super) stray_surface: f32,
    /// Flux of the photons that no light took, before thinning; W per channel.
    pub(super) residual: [f64; 3],
}

impl PhotonClusters {
    /// Each site speaks for its own photon, over the probability with which it was kept.
    pub fn own(sites: &[Site]) -> Self {
        PhotonClusters::of_sites(sites, |site| vec![(site.photon, 1.0 / site.probability)])
    }

    /// Each site speaks for the photons that `share` lists with their weights; at least one.
    pub(super) fn of_sites(
        sites: &[Site],
        share: impl Fn(&Site) -> Vec<(u32, f32)> + Sync + Send,
    ) -> Self {
        let lists: Vec<Vec<(u32, f32)>> = sites.par_iter().map(share).collect();
        let mut shares = PhotonClusters {
            sites: sites.to_vec(),
            offsets: vec![0],
            surfaces: vec![1.0; sites.len()],
            stray_surface: 1.0,
            ..PhotonClusters::default()
        };
        for (photon, weight) in lists.iter().flatten() {
            shares.photons.push(*photon);
            shares.weights.push(*weight);
        }
        shares.offsets.extend(lists.iter().scan(0, |end, list| {
            *end += list.len() as u32;
            Some(*end)
        }));
        shares
    }

    /// The photons that the lights stand on.
    pub fn sites(&self) -> &[Site] {
        &self.sites
    }

    /// Number of lights.
    pub fn len(&self) -> usize {
        self.sites.len()
    }

    /// Whether there is no light.
    pub fn is_empty(&self) -> bool {
        self.sites.is_empty()
    }

    /// Indices of the photons of light `k`, never none, with the factors on their flux.
    #[inline]
    pub fn of(&self, k: usize) -> impl ExactSizeIterator<Item = (u32, f32)> + Clone {
        let range = self.offsets[k] as usize..self.offsets[k + 1] as usize;
        let photons = self.photons[range.clone()].iter().copied();
        photons.zip(self.weights[range].iter().copied())
    }

    /// For how many times the surface per light around it light `k` stands.
    #[inline]
    pub fn surface(&self, k: usize) -> f32 {
        self.surfaces[k]
    }

    /// The same for a light of its own that a photon might be whom no other light takes.
    pub fn stray_surface(&self) -> f32 {
        self.stray_surface
    }

    /// Flux of the photons that no light took, before thinning; W per channel.
    pub fn residual(&self) -> [f64; 3] {
        self.residual
    }
}
