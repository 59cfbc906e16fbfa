//! Flux, rule 1: a partition of the photons among the lights.
//!
//! Every photon gives all of its flux to the nearest light on its surface, so that `Σ F_k = Σ
//! Φ_j` in every realization and for any placement. (The paper estimates densities instead: see
//! [`density`](super::density).) Photons without such a light are unassigned; they are thinned
//! without bias into additional lights of one photon each.

use super::candidates::Candidates;
use super::clusters::PhotonClusters;
use super::nearest_light::{NearestLights, UNASSIGNED};
use super::select::{Site, WEIGHT_FLOOR, defensive_weights};
use super::surfaces::{SurfaceLocation, Surfaces};
use crate::ids::LightGroup;
use crate::sampling::systematic::{inclusion_probabilities, systematic};
use rayon::prelude::*;

/// Largest selection weight (importance times flux) of an additional light, in units of the median
/// light's. Smaller values bound the noise of additional lights and make more of them. At 5 and 20
/// (2 passes of 128 lights at 72x40, 3 seeds; Kitchen, Glossy Room): the same picture.
const MAX_UNASSIGNED_WEIGHT: f64 = 10.0;
/// Number of additional lights per light, where [`MAX_UNASSIGNED_WEIGHT`] allows. Limits the time
/// of a pass: the sum over lights grows by a quarter at most. At 0.125 and 0.5 (2 passes of 128
/// lights at 72x40, 3 seeds; Kitchen, Glossy Room): relMSE -5.2 and -0.6 % (standard error 4 %).
const UNASSIGNED_PER_LIGHT: f64 = 0.25;
/// Surface represented by an additional light, in units of the surface per light around it. It
/// represents many unassigned photons around it; with the factor 1 the clamp treats it as a small
/// bright light, which makes dark halos beside thin objects. At 8 and 32 (2 passes of 128 lights at
/// 72x40, 6 seeds; Kitchen, Glossy Room, U-Shape): relMSE +1.2 and 0 % (standard error 0.7 %).
const UNASSIGNED_SURFACE: f32 = 16.0;

/// Assigns every photon to the nearest light, and thins unassigned photons into lights of one
/// photon.
///
/// `u` in [0, 1) is the random number for the thinning. Sites to which no photon is assigned make
/// no light. Lights and additional lights are sorted along the curve of the candidates. Also
/// returns the cells of the lights, for any other location.
pub fn assign(
    surfaces: &impl Surfaces,
    candidates: &Candidates,
    sites: &[Site],
    u: f32,
) -> (PhotonClusters, NearestLights) {
    let photons = &candidates.photons;
    let mut nearest = NearestLights::new(surfaces, photons, sites);
    let mut sites_of = vec![UNASSIGNED; photons.len()];
    sites_of
        .par_iter_mut()
        .with_min_len(256)
        .zip(photons)
        .for_each(|(site, photon)| {
            *site = nearest.site(surfaces, &SurfaceLocation::of_photon(photon, surfaces));
        });
    let additional = thin_unassigned(candidates, &sites_of, sites.len(), u);
    let (clusters, lights) = collect_clusters(candidates, sites, &sites_of, &additional);
    nearest.set_lights(lights);
    (clusters, nearest)
}

/// The assigned photons, each with its site.
fn assigned(sites_of: &[u32]) -> impl Iterator<Item = (usize, usize)> {
    let sites_of = sites_of.iter().enumerate();
    sites_of
        .filter(|(_, site)| **site != UNASSIGNED)
        .map(|(j, &site)| (j, site as usize))
}

/// The unassigned photons.
fn unassigned(sites_of: &[u32]) -> impl Iterator<Item = usize> {
    let sites_of = sites_of.iter().enumerate();
    sites_of
        .filter(|(_, site)| **site == UNASSIGNED)
        .map(|(j, _)| j)
}

/// Selects unassigned photons as additional lights. Half of the probability is in proportion to
/// `weights`, half to flux, which bounds the flux of these lights.
fn thin_unassigned(
    candidates: &Candidates,
    sites_of: &[u32],
    light_count: usize,
    u: f32,
) -> Vec<Site> {
    let Candidates {
        photons,
        weights,
        curve,
    } = candidates;
    let mut light_weights = vec![0.0f64; light_count];
    for (j, site) in assigned(sites_of) {
        light_weights[site] += f64::from(weights[j]);
    }
    let mut photons_left: Vec<u32> = unassigned(sites_of)
        .filter(|&j| !photons[j].flux.is_black())
        .map(|j| j as u32)
        .collect();
    if photons_left.is_empty() {
        return Vec::new();
    }
    photons_left.sort_by_cached_key(|&j| curve.photon_key(&photons[j as usize]));

    let of = |value: &dyn Fn(usize) -> f32| -> Vec<f32> {
        photons_left.iter().map(|&j| value(j as usize)).collect()
    };
    let their_weights = of(&|j| weights[j]);
    let fluxes = of(&|j| photons[j].flux.luminance());
    let mixed: Vec<f32> = defensive_weights(&their_weights, &fluxes, 1.0)
        .into_iter()
        .map(|w| w.max(f32::MIN_POSITIVE))
        .collect();
    let total_weight = their_weights.iter().map(|&w| f64::from(w)).sum();
    let count = additional_light_count(total_weight, &mut light_weights);
    let probabilities = inclusion_probabilities(&mixed, count, WEIGHT_FLOOR);
    systematic(&probabilities, u)
        .into_iter()
        .map(|i| Site {
            photon: photons_left[i],
            probability: probabilities[i],
        })
        .collect()
}

/// Number of additional lights: each gets the weight of the median light, or a larger one, up to
/// [`MAX_UNASSIGNED_WEIGHT`], if there would be more than [`UNASSIGNED_PER_LIGHT`].
fn additional_light_count(unassigned_weight: f64, light_weights: &mut Vec<f64>) -> usize {
    let lights = light_weights.len() as f64;
    light_weights.retain(|&w| w > 0.0);
    if light_weights.is_empty() {
        return (lights as usize).max(1);
    }
    let middle = light_weights.len() / 2;
    let (_, &mut median, _) = light_weights.select_nth_unstable_by(middle, f64::total_cmp);
    let even = unassigned_weight / median;
    // Half of the probability is in proportion to weight, hence the 2.
    let fewest = 2.0 * even / MAX_UNASSIGNED_WEIGHT;
    even.min(lights * UNASSIGNED_PER_LIGHT)
        .max(fewest)
        .min(lights)
        .ceil()
        .max(1.0) as usize
}

/// The clusters of all lights along the curve; and for each site the index of its light, or
/// [`UNASSIGNED`] if it has no photons.
fn collect_clusters(
    candidates: &Candidates,
    sites: &[Site],
    sites_of: &[u32],
    additional: &[Site],
) -> (PhotonClusters, Vec<u32>) {
    let mut counts = vec![0u32; sites.len()];
    for (_, site) in assigned(sites_of) {
        counts[site] += 1;
    }
    let order = order_along_curve(candidates, sites, &counts, additional);

    let mut clusters = PhotonClusters {
        offsets: vec![0],
        unassigned_surface: UNASSIGNED_SURFACE,
        ..PhotonClusters::default()
    };
    let mut next = vec![0u32; sites.len()];
    let mut lights = vec![UNASSIGNED; sites.len()];
    for (l, &k) in order.iter().enumerate() {
        let start = clusters.offsets[l];
        let (site, count, surface) = match sites.get(k) {
            Some(&site) => {
                (next[k], lights[k]) = (start, l as u32);
                (site, counts[k], 1.0)
            }
            None => (additional[k - sites.len()], 1, UNASSIGNED_SURFACE),
        };
        clusters.sites.push(site);
        clusters.surfaces.push(surface);
        clusters.offsets.push(start + count);
    }
    let entries = clusters.offsets[order.len()] as usize;
    (clusters.photons, clusters.weights) = (vec![0; entries], vec![1.0; entries]);
    for (j, site) in assigned(sites_of) {
        let slot = &mut next[site];
        clusters.photons[*slot as usize] = j as u32;
        *slot += 1;
    }
    for l in (0..order.len()).filter(|&l| order[l] >= sites.len()) {
        let (slot, site) = (clusters.offsets[l] as usize, clusters.sites[l]);
        clusters.photons[slot] = site.photon;
        clusters.weights[slot] = 1.0 / site.probability;
    }
    (clusters, lights)
}

/// Sites with photons, by index, and additional lights, counted on from the number of sites, sorted
/// along the curve.
fn order_along_curve(
    candidates: &Candidates,
    sites: &[Site],
    counts: &[u32],
    additional: &[Site],
) -> Vec<usize> {
    let Candidates { photons, curve, .. } = candidates;
    let key = |site: &Site| curve.photon_key(&photons[site.photon as usize]);
    let with_photons = (sites.iter().zip(counts).enumerate()).filter(|(_, (_, count))| **count > 0);
    let mut order: Vec<((LightGroup, u64), usize)> =
        with_photons.map(|(k, (site, _))| (key(site), k)).collect();
    let additional = additional.iter().enumerate();
    order.extend(additional.map(|(e, site)| (key(site), sites.len() + e)));
    order.sort_unstable();
    order.into_iter().map(|(_, k)| k).collect()
}

#[cfg(test)]
mod tests {
    use super::super::select::select;
    use super::super::testing::{OPEN, Room, candidates, photon, photons_on_square};
    use super::*;
    use crate::ids::{MaterialId, PrimitiveId};
    use crate::math::Vec3;
    use crate::particles::Photon;

    fn luminances(photons: &[Photon]) -> Vec<f32> {
        photons.iter().map(|p| p.flux.luminance()).collect()
    }

    /// The factor on the first photon of a light.
    fn weight(clusters: &PhotonClusters, k: usize) -> f32 {
        clusters.of(k).next().unwrap().1
    }

    fn flux(photons: &[Photon], indices: impl Iterator<Item = u32>) -> [f64; 3] {
        indices.fold([0.0; 3], |mut sum, j| {
            for (s, f) in sum.iter_mut().zip(photons[j as usize].flux.to_array()) {
                *s += f64::from(f);
            }
            sum
        })
    }

    fn unassigned_flux(photons: &[Photon], nearest: &NearestLights) -> [f64; 3] {
        let is_unassigned = |j: &u32| {
            let location = SurfaceLocation::of_photon(&photons[*j as usize], &OPEN);
            nearest.site(&OPEN, &location) == UNASSIGNED
        };
        flux(photons, (0..photons.len() as u32).filter(is_unassigned))
    }

    #[test]
    fn the_partition_conserves_flux() {
        let mut photons = photons_on_square(20_000, 1);
        // A few photons have another material, some the other side: unassigned unless they have
        // sites.
        for photon in photons.iter_mut().skip(5).step_by(997) {
            photon.at.primitive = PrimitiveId(1);
        }
        for photon in photons.iter_mut().skip(8).step_by(1501) {
            photon.n = -photon.n;
        }
        let weights = luminances(&photons);
        let sites = select(&photons, &weights, 300, 0.4);
        let (clusters, nearest) = assign(&OPEN, &candidates(&photons, &weights), &sites, 0.7);
        let unassigned = unassigned_flux(&photons, &nearest);
        assert!(unassigned[0] > 0.0);
        let mut assigned = [0.0; 3];
        for k in (0..clusters.len()).filter(|&k| weight(&clusters, k) == 1.0) {
            let f = flux(&photons, clusters.of(k).map(|(j, _)| j));
            (0..3).for_each(|c| assigned[c] += f[c]);
        }
        let total = flux(&photons, 0..photons.len() as u32);
        // Unassigned photons selected with probability 1 are lights of weight 1 as well.
        let certain: Vec<u32> = (0..clusters.len())
            .filter(|&k| weight(&clusters, k) == 1.0 && clusters.of(k).len() == 1)
            .map(|k| clusters.sites()[k].photon)
            .filter(|j| sites.iter().all(|s| s.photon != *j))
            .collect();
        let certain = flux(&photons, certain.into_iter());
        for c in 0..3 {
            let sum = assigned[c] - certain[c] + unassigned[c];
            assert!((sum / total[c] - 1.0).abs() < 1e-6, "{sum} of {}", total[c]);
        }
    }

    #[test]
    fn photons_go_to_the_nearest_light() {
        let photons = photons_on_square(3000, 2);
        let weights = luminances(&photons);
        let sites = select(&photons, &weights, 100, 0.4);
        let (clusters, _) = assign(&OPEN, &candidates(&photons, &weights), &sites, 0.7);
        let mut seen = vec![false; photons.len()];
        for k in 0..clusters.len() {
            let p = photons[clusters.sites()[k].photon as usize].p;
            for (j, _) in clusters.of(k) {
                assert!(
                    !std::mem::replace(&mut seen[j as usize], true),
                    "photon {j} is in two clusters"
                );
                let q = photons[j as usize].p;
                let nearest = sites
                    .iter()
                    .map(|s| photons[s.photon as usize].p.distance_squared(q))
                    .fold(f32::INFINITY, f32::min);
                assert_eq!(p.distance_squared(q), nearest);
            }
        }
        assert!(seen.iter().all(|&s| s));
    }

    #[test]
    fn cells_hold_the_photons_of_their_lights() {
        let photons = photons_on_square(3000, 5);
        let weights = luminances(&photons);
        let sites = select(&photons, &weights, 100, 0.2);
        let (clusters, nearest) = assign(&OPEN, &candidates(&photons, &weights), &sites, 0.7);
        for k in 0..clusters.len() {
            for (j, _) in clusters.of(k) {
                let location = SurfaceLocation::of_photon(&photons[j as usize], &OPEN);
                assert_eq!(
                    nearest.light(&OPEN, &location).map(|id| id.index()),
                    Some(k)
                );
            }
        }
        let elsewhere = SurfaceLocation {
            material: MaterialId(7),
            ..SurfaceLocation::of_photon(&photons[0], &OPEN)
        };
        assert!(nearest.light(&OPEN, &elsewhere).is_none());
        assert!(
            NearestLights::empty()
                .light(&OPEN, &SurfaceLocation::of_photon(&photons[0], &OPEN))
                .is_none()
        );
    }

    #[test]
    fn flux_does_not_pass_through_a_wall_that_lights_are_far_from() {
        let mut photons = photons_on_square(4000, 3);
        // All lights stand on the left.
        photons.sort_by(|a, b| a.p.x.total_cmp(&b.p.x));
        let sites: Vec<Site> = (0..200)
            .map(|i| Site {
                photon: i,
                probability: 0.1,
            })
            .collect();
        let weights = luminances(&photons);
        let room = Room { wall: Some(0.5) };
        let (clusters, _) = assign(&room, &candidates(&photons, &weights), &sites, 0.1);
        for k in 0..clusters.len() {
            let x = photons[clusters.sites()[k].photon as usize].p.x;
            assert!(
                clusters
                    .of(k)
                    .all(|(j, _)| (photons[j as usize].p.x < 0.5) == (x < 0.5))
            );
        }
    }

    #[test]
    fn unassigned_flux_is_unbiased_and_bounded() {
        let mut photons = photons_on_square(10_000, 4);
        for i in 0..200 {
            photons[i * 50].at.primitive = PrimitiveId(1);
        }
        let sites: Vec<Site> = (0..100)
            .map(|i| Site {
                photon: i * 100 + 1,
                probability: 0.01,
            })
            .collect();
        let weights = luminances(&photons);
        let median = 100.0 * 0.6;
        let (mut mean, trials) = (0.0, 50);
        let mut unassigned = 0.0;
        for t in 0..trials {
            let (clusters, nearest) = assign(
                &OPEN,
                &candidates(&photons, &weights),
                &sites,
                (t as f32 + 0.5) / trials as f32,
            );
            unassigned = unassigned_flux(&photons, &nearest)[1];
            for k in (0..clusters.len()).filter(|&k| weight(&clusters, k) > 1.0) {
                let light =
                    photons[clusters.sites()[k].photon as usize].flux * weight(&clusters, k);
                assert!(light.luminance() < 10.0 * median);
                mean += f64::from(light.g) / f64::from(trials);
            }
        }
        assert!(unassigned > 100.0);
        assert!(
            (mean / unassigned - 1.0).abs() < 0.02,
            "{mean} of {unassigned}"
        );
    }

    #[test]
    fn no_photons_or_no_sites() {
        assert!(assign(&OPEN, &candidates(&[], &[]), &[], 0.5).0.is_empty());
        let photons = [photon(Vec3::ZERO, Vec3::Z)];
        let (clusters, _) = assign(&OPEN, &candidates(&photons, &[1.0]), &[], 0.5);
        assert_eq!((clusters.len(), weight(&clusters, 0)), (1, 1.0));
        let own = PhotonClusters::single_photons(&[Site {
            photon: 0,
            probability: 0.25,
        }]);
        assert!(own.of(0).eq([(0, 4.0)]));
    }
}
