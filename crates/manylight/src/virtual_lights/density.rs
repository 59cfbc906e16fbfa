//! Flux: lights that speak for the photons around them, by a density estimate.
//!
//! The reflected radiance around a site is that of its nearest photons (Jensen, "Realistic Image Synthesis Using Photon Mapping", 2001), as
//! in the paper's creation of Rich-VPLs; the rules differ in how much surface it is multiplied with.

use super::nearest_light::{SurfaceLocation, Surfaces};
use super::{PhotonClusters, Site};
use crate::maps::{DensityKernel, KdTree, Neighbors};
use crate::math::Vec3;
use crate::particles::Photon;

/// The density rule, our reading of the paper: a site carries the flux of its own photon over the probability with which it was
/// kept, and shines as the `neighbors` photons nearest to it shine on average,
///
/// ```text
/// I_k = F_k Σ_j w_j Φ_j f(ω_j) / Σ_j w_j |Φ_j|,   F_k = |Φ_k| / p_k,   w_j = 1 - d_j²/d_K²
/// ```
///
/// The flux is right on average, as long as sites stand where selection has put them. With one neighbor it is [`PhotonClusters::own`].
pub fn by_density(
    surfaces: &impl Surfaces,
    photons: &[Photon],
    sites: &[Site],
    neighbors: usize,
) -> PhotonClusters {
    let around = Neighborhoods::new(surfaces, photons, neighbors);
    PhotonClusters::of_sites(sites, |site| {
        let own = photons[site.photon as usize].flux.luminance() / site.probability;
        let mut share = around.of(site);
        let flux = |&(j, weight): &(u32, f32)| {
            f64::from(weight) * f64::from(photons[j as usize].flux.luminance())
        };
        let sum: f64 = share.iter().map(flux).sum();
        if neighbors <= 1 || sum <= 0.0 {
            return vec![(site.photon, 1.0 / site.probability)];
        }
        let scale = (f64::from(own) / sum) as f32;
        share.iter_mut().for_each(|(_, weight)| *weight *= scale);
        share
    })
}

/// The photons around sites.
struct Neighborhoods<'a, S> {
    surfaces: &'a S,
    photons: &'a [Photon],
    tree: KdTree<Vec3>,
    neighbors: usize,
}

impl<'a, S: Surfaces> Neighborhoods<'a, S> {
    fn new(surfaces: &'a S, photons: &'a [Photon], neighbors: usize) -> Self {
        let places: Vec<Vec3> = photons.iter().map(|photon| photon.p).collect();
        Neighborhoods {
            surfaces,
            photons,
            tree: KdTree::build(places),
            neighbors,
        }
    }

    /// The nearest photons of the site's own surface, each with its kernel weight in 1/m²; the site's photon at least.
    fn of(&self, site: &Site) -> Vec<(u32, f32)> {
        let center = &self.photons[site.photon as usize];
        let patch = self.surfaces.patch(center);
        let found = &mut Neighbors::new(self.neighbors);
        self.tree.nearest(center.p, f32::INFINITY, found);
        let r2 = found.radius_squared();
        let own = |&(j, d2): &(u32, f32)| {
            let spot = SurfaceLocation::of(&self.photons[j as usize], self.surfaces);
            let same = patch.distance_squared(spot.p, spot.n, spot.material);
            (same.is_some() && (d2 < r2 || j == site.photon)).then_some((j, d2))
        };
        let mut share: Vec<(u32, f32)> = found
            .iter()
            .filter_map(|neighbor| own(&neighbor))
            .map(|(j, d2)| (j, DensityKernel::Epanechnikov.weight(d2, r2)))
            .collect();
        if share.is_empty() {
            share.push((site.photon, DensityKernel::Epanechnikov.weight(0.0, r2)));
        }
        share
    }
}

#[cfg(test)]
mod tests {
    use super::super::select::select;
    use super::super::testing::{OPEN, photons_on_square};
    use super::*;

    fn flux(photons: &[Photon], shares: &PhotonClusters) -> f64 {
        let of = |k| {
            let flux = |(j, w): (u32, f32)| f64::from(photons[j as usize].flux.luminance() * w);
            shares.of(k).map(flux).sum::<f64>()
        };
        (0..shares.len()).map(of).sum()
    }

    /// Photons on a square, more of them to the right, and lights that prefer the right even more.
    fn placed(count: usize, u: f32) -> (Vec<Photon>, Vec<Site>) {
        let mut photons = photons_on_square(20_000, 7);
        photons.iter_mut().for_each(|p| p.p.x = p.p.x.sqrt());
        let weights: Vec<f32> = photons
            .iter()
            .map(|p| p.flux.luminance() * (0.1 + p.p.x))
            .collect();
        let sites = select(&photons, &weights, count, u);
        (photons, sites)
    }

    #[test]
    fn one_neighbor_is_the_photon_itself() {
        let (photons, sites) = placed(50, 0.3);
        let (one, own) = (
            by_density(&OPEN, &photons, &sites, 1),
            PhotonClusters::own(&sites),
        );
        for k in 0..sites.len() {
            assert!(one.of(k).eq(own.of(k)));
        }
    }

    #[test]
    fn density_keeps_flux_on_average() {
        let trials = 32;
        let (mut density, mut total) = (0.0, 0.0);
        for t in 0..trials {
            let (photons, sites) = placed(200, (t as f32 + 0.5) / trials as f32);
            total = photons
                .iter()
                .map(|p| f64::from(p.flux.luminance()))
                .sum::<f64>();
            let sum = flux(&photons, &by_density(&OPEN, &photons, &sites, 64));
            density += sum / f64::from(trials);
        }
        assert!((density / total - 1.0).abs() < 0.01, "{density} of {total}");
    }

    #[test]
    fn shares_do_not_reach_across_to_other_surfaces() {
        let (mut photons, sites) = placed(50, 0.6);
        for (j, photon) in photons.iter_mut().enumerate() {
            if j % 2 == 0 && sites.iter().all(|s| s.photon != j as u32) {
                photon.n = -photon.n;
            }
        }
        let shares = by_density(&OPEN, &photons, &sites, 64);
        for k in 0..shares.len() {
            let n = photons[sites[k].photon as usize].n;
            assert!(shares.of(k).all(|(j, _)| photons[j as usize].n == n));
            assert!(shares.of(k).len() > 10);
        }
    }
}
