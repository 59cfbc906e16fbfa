//! Flux, rule 2: a density estimate around each site, our reading of the paper.
//!
//! The reflected radiance at a site is estimated from its nearest photons, as in the creation of
//! Rich-VPLs in Simon, Hanika, Dachsbacher, Eurographics 2015, after Jensen, "Realistic Image
//! Synthesis Using Photon Mapping", 2001.

use super::clusters::PhotonClusters;
use super::select::Site;
use super::surfaces::{SurfaceLocation, Surfaces};
use crate::maps::density::epanechnikov;
use crate::maps::{KdTree, Neighbors};
use crate::math::Vec3;
use crate::particles::Photon;

/// The density rule. Light `k` has the flux of the photon that it stands on, divided by its
/// probability `a_k` of being kept, and the average emission of the `neighbors` = K photons nearest
/// to it on its surface, with the Epanechnikov kernel:
///
/// ```text
/// I_k(ω) = F_k Σ_j w_j Φ_j f(ω_j, ω) |cos θ| / Σ_j w_j |Φ_j|,   F_k = |Φ_k| / a_k,   w_j ∝ 1 - d_j²/d_K²
/// ```
///
/// with luminances `|Φ|`. The total flux is unbiased in luminance if sites are where selection
/// placed them, and biased after relaxation. With one neighbor the result is
/// [`PhotonClusters::single_photons`].
pub fn by_density(
    surfaces: &impl Surfaces,
    photons: &[Photon],
    sites: &[Site],
    neighbors: usize,
) -> PhotonClusters {
    let neighborhoods = Neighborhoods::new(surfaces, photons, neighbors);
    PhotonClusters::of_sites(sites, |site| {
        let site_flux = photons[site.photon as usize].flux.luminance() / site.probability;
        let mut cluster = neighborhoods.of(site);
        let flux = |&(j, weight): &(u32, f32)| {
            f64::from(weight) * f64::from(photons[j as usize].flux.luminance())
        };
        let sum: f64 = cluster.iter().map(flux).sum();
        if neighbors <= 1 || sum <= 0.0 {
            return vec![(site.photon, 1.0 / site.probability)];
        }
        let scale = (f64::from(site_flux) / sum) as f32;
        cluster.iter_mut().for_each(|(_, weight)| *weight *= scale);
        cluster
    })
}

/// Searches for the photons around sites.
struct Neighborhoods<'a, S> {
    surfaces: &'a S,
    photons: &'a [Photon],
    tree: KdTree<Vec3>,
    neighbors: usize,
}

impl<'a, S: Surfaces> Neighborhoods<'a, S> {
    fn new(surfaces: &'a S, photons: &'a [Photon], neighbors: usize) -> Self {
        let positions: Vec<Vec3> = photons.iter().map(|photon| photon.p).collect();
        Neighborhoods {
            surfaces,
            photons,
            tree: KdTree::build(positions),
            neighbors,
        }
    }

    /// The nearest photons on the site's surface with their kernel weights in 1/m²; at least the
    /// site's photon.
    fn of(&self, site: &Site) -> Vec<(u32, f32)> {
        let center = &self.photons[site.photon as usize];
        let patch = self.surfaces.patch(center);
        let found = &mut Neighbors::new(self.neighbors);
        self.tree.nearest(center.p, f32::INFINITY, found);
        let r2 = found.radius_squared();
        let on_surface = |&(j, d2): &(u32, f32)| {
            let location = SurfaceLocation::of_photon(&self.photons[j as usize], self.surfaces);
            let same = patch.distance_squared(location.p, location.n, location.material);
            (same.is_some() && (d2 < r2 || j == site.photon)).then_some((j, d2))
        };
        let mut cluster: Vec<(u32, f32)> = found
            .iter()
            .filter_map(|neighbor| on_surface(&neighbor))
            .map(|(j, d2)| (j, epanechnikov(d2, r2)))
            .collect();
        if cluster.is_empty() {
            cluster.push((site.photon, epanechnikov(0.0, r2)));
        }
        cluster
    }
}

#[cfg(test)]
mod tests {
    use super::super::select::select;
    use super::super::testing::{OPEN, photons_on_square};
    use super::*;

    fn flux(photons: &[Photon], clusters: &PhotonClusters) -> f64 {
        let of = |k| {
            let flux = |(j, w): (u32, f32)| f64::from(photons[j as usize].flux.luminance() * w);
            clusters.of(k).map(flux).sum::<f64>()
        };
        (0..clusters.len()).map(of).sum()
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
    fn one_neighbor_is_the_own_photon() {
        let (photons, sites) = placed(50, 0.3);
        let (one, own) = (
            by_density(&OPEN, &photons, &sites, 1),
            PhotonClusters::single_photons(&sites),
        );
        for k in 0..sites.len() {
            assert!(one.of(k).eq(own.of(k)));
        }
    }

    #[test]
    fn flux_is_unbiased() {
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
    fn clusters_stay_on_their_surface() {
        let (mut photons, sites) = placed(50, 0.6);
        for (j, photon) in photons.iter_mut().enumerate() {
            if j % 2 == 0 && sites.iter().all(|s| s.photon != j as u32) {
                photon.n = -photon.n;
            }
        }
        let clusters = by_density(&OPEN, &photons, &sites, 64);
        for k in 0..clusters.len() {
            let n = photons[sites[k].photon as usize].n;
            assert!(clusters.of(k).all(|(j, _)| photons[j as usize].n == n));
            assert!(clusters.of(k).len() > 10);
        }
    }
}
