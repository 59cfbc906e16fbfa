//! Flux: which photons each light speaks for, by a partition.
//!
//! Every photon is given to the nearest light of its own surface, or divided among the nearest few, so all flux is represented, wherever the
//! lights stand. Photons that no light may take are thinned into lights of their own.

use super::curve::Curve;
use super::nearest_light::{NearestLights, SurfaceLocation, Surfaces, UNASSIGNED};
use super::select::{WEIGHT_FLOOR, defensive_weights};
use super::{PhotonClusters, Site};
use crate::particles::Photon;
use crate::sampling::systematic::{inclusion_probabilities, systematic};
use rayon::prelude::*;

/// Residual lights carry at most about this many times the weight of a median light.
const MAX_RESIDUAL_WEIGHT: f64 = 10.0;
/// Residual lights per light, while the weight limit allows.
const RESIDUAL_SHARE: f64 = 0.25;
/// A residual light stands for many photons like its own, and so for this many times the surface of a light that has its place to
/// itself: the clamp must not take it for a small bright one.
const RESIDUAL_SURFACE: f32 = 16.0;

/// The partition rule. Lights that stand nearer to no photon than others vanish; photons that no light may take are thinned
/// without bias, by weight and flux, into lights of one photon with the random number `u`. The claims tell later whose a
/// photon anywhere would be.
pub fn assign(
    surfaces: &impl Surfaces,
    photons: &[Photon],
    sites: &[Site],
    weights: &[f32],
    u: f32,
) -> (PhotonClusters, NearestLights) {
    let mut claims = NearestLights::new(surfaces, photons, sites);
    let mut owners = vec![UNASSIGNED; photons.len()];
    owners
        .par_iter_mut()
        .with_min_len(256)
        .zip(photons)
        .for_each(|(owner, photon)| {
            *owner = claims.site(surfaces, &SurfaceLocation::of(photon, surfaces));
        });
    let mut residual = [0.0; 3];
    for photon in orphans(&owners).map(|j| &photons[j]) {
        for (sum, f) in residual.iter_mut().zip(photon.flux.to_array()) {
            *sum += f64::from(f);
        }
    }
    let extras = thin_residual(photons, &owners, sites.len(), weights, u);
    let (shares, lights) = gather_shares(photons, sites, &owners, &extras);
    claims.name_lights(lights);
    (PhotonClusters { residual, ..shares }, claims)
}

/// The photons that have a site, each with that.
fn owned(owners: &[u32]) -> impl Iterator<Item = (usize, usize)> {
    let owners = owners.iter().enumerate();
    owners
        .filter(|(_, site)| **site != UNASSIGNED)
        .map(|(j, &site)| (j, site as usize))
}

/// The photons that nobody takes.
fn orphans(owners: &[u32]) -> impl Iterator<Item = usize> {
    let owners = owners.iter().enumerate();
    owners
        .filter(|(_, site)| **site == UNASSIGNED)
        .map(|(j, _)| j)
}

/// Chooses among the photons that nobody took. Half of the probability goes by weight (importance), half by flux, which
/// bounds the flux of the lights.
fn thin_residual(
    photons: &[Photon],
    owners: &[u32],
    light_count: usize,
    weights: &[f32],
    u: f32,
) -> Vec<Site> {
    let mut light_weights = vec![0.0f64; light_count];
    for (j, site) in owned(owners) {
        light_weights[site] += f64::from(weights[j]);
    }
    let mut residual: Vec<u32> = orphans(owners)
        .filter(|&j| !photons[j].flux.is_black())
        .map(|j| j as u32)
        .collect();
    if residual.is_empty() {
        return Vec::new();
    }
    let curve = Curve::around(photons);
    residual.sort_by_cached_key(|&j| curve.key(photons[j as usize].p, photons[j as usize].n));

    let of = |value: &dyn Fn(usize) -> f32| -> Vec<f32> {
        residual.iter().map(|&j| value(j as usize)).collect()
    };
    let its_weights = of(&|j| weights[j]);
    let fluxes = of(&|j| photons[j].flux.luminance());
    let mixed: Vec<f32> = defensive_weights(&its_weights, &fluxes, 1.0)
        .into_iter()
        .map(|w| w.max(f32::MIN_POSITIVE))
        .collect();
    let total_weight = its_weights.iter().map(|&w| f64::from(w)).sum();
    let count = residual_count(total_weight, &mut light_weights);
    let probabilities = inclusion_probabilities(&mixed, count, WEIGHT_FLOOR);
    systematic(&probabilities, u)
        .into_iter()
        .map(|i| Site {
            photon: residual[i],
            probability: probabilities[i],
        })
        .collect()
}

/// How many lights the residual becomes: as important as the median light if that needs few, else more so up to a limit.
fn residual_count(residual_weight: f64, light_weights: &mut Vec<f64>) -> usize {
    let lights = light_weights.len() as f64;
    light_weights.retain(|&w| w > 0.0);
    if light_weights.is_empty() {
        return (lights as usize).max(1);
    }
    let middle = light_weights.len() / 2;
    let (_, &mut median, _) = light_weights.select_nth_unstable_by(middle, f64::total_cmp);
    let even = residual_weight / median;
    // Half of the probability goes by weight, hence the 2.
    let fewest = 2.0 * even / MAX_RESIDUAL_WEIGHT;
    even.min(lights * RESIDUAL_SHARE)
        .max(fewest)
        .min(lights)
        .ceil()
        .max(1.0) as usize
}

/// Lists each light's photons, and sorts lights and extra lights along the curve. Also for each site the index of its light, or
/// [`UNASSIGNED`] if that vanished.
fn gather_shares(
    photons: &[Photon],
    sites: &[Site],
    owners: &[u32],
    extras: &[Site],
) -> (PhotonClusters, Vec<u32>) {
    let mut counts = vec![0u32; sites.len()];
    for (_, site) in owned(owners) {
        counts[site] += 1;
    }
    let curve = Curve::around(photons);
    let key = |site: &Site| {
        curve.key(
            photons[site.photon as usize].p,
            photons[site.photon as usize].n,
        )
    };
    let of_sites = sites
        .iter()
        .zip(&counts)
        .enumerate()
        .filter(|(_, (_, count))| **count > 0);
    let mut order: Vec<(u64, u32)> = of_sites
        .map(|(k, (site, _))| (key(site), k as u32))
        .collect();
    order.extend(
        extras
            .iter()
            .enumerate()
            .map(|(e, site)| (key(site), (sites.len() + e) as u32)),
    );
    order.sort_unstable();

    let mut shares = PhotonClusters {
        offsets: vec![0],
        stray_surface: RESIDUAL_SURFACE,
        ..PhotonClusters::default()
    };
    let mut next = vec![0u32; sites.len()];
    for &(_, k) in &order {
        let k = k as usize;
        let end = shares.offsets[shares.sites.len()];
        match sites.get(k) {
            Some(&site) => {
                next[k] = end;
                shares.sites.push(site);
                shares.surfaces.push(1.0);
                shares.offsets.push(end + counts[k]);
            }
            None => {
                let site = extras[k - sites.len()];
                shares.sites.push(site);
                shares.surfaces.push(RESIDUAL_SURFACE);
                shares.offsets.push(end + 1);
            }
        }
    }
    let entries = shares.offsets[shares.sites.len()] as usize;
    (shares.photons, shares.weights) = (vec![0; entries], vec![0.0; entries]);
    for (j, site) in owned(owners) {
        let slot = &mut next[site];
        shares.photons[*slot as usize] = j as u32;
        shares.weights[*slot as usize] = 1.0;
        *slot += 1;
    }
    let mut lights = vec![UNASSIGNED; sites.len()];
    for (l, &(_, k)) in order.iter().enumerate() {
        match lights.get_mut(k as usize) {
            Some(light) => *light = l as u32,
            None => {
                let (slot, site) = (shares.offsets[l] as usize, &shares.sites[l]);
                shares.photons[slot] = site.photon;
                shares.weights[slot] = 1.0 / site.probability;
            }
        }
    }
    (shares, lights)
}

#[cfg(test)]
mod tests {
    use super::super::select::select;
    use super::super::testing::{OPEN, Room, photon, photons_on_square};
    use super::*;
    use crate::ids::{MaterialId, PrimitiveId};
    use crate::math::Vec3;

    fn luminances(photons: &[Photon]) -> Vec<f32> {
        photons.iter().map(|p| p.flux.luminance()).collect()
    }

    /// The factor on the first photon of a light.
    fn weight(shares: &PhotonClusters, k: usize) -> f32 {
        shares.of(k).next().unwrap().1
    }

    fn flux(photons: &[Photon], indices: impl Iterator<Item = u32>) -> [f64; 3] {
        indices.fold([0.0; 3], |mut sum, j| {
            for (s, f) in sum.iter_mut().zip(photons[j as usize].flux.to_array()) {
                *s += f64::from(f);
            }
            sum
        })
    }

    #[test]
    fn no_flux_is_lost() {
        let mut photons = photons_on_square(20_000, 1);
        // A few photons of another material and some on the other side: residual unless they have sites.
        for photon in photons.iter_mut().skip(5).step_by(997) {
            photon.at.primitive = PrimitiveId(1);
        }
        for photon in photons.iter_mut().skip(8).step_by(1501) {
            photon.n = -photon.n;
        }
        let weights = luminances(&photons);
        let sites = select(&photons, &weights, 300, 0.4);
        let (shares, _) = assign(&OPEN, &photons, &sites, &weights, 0.7);
        assert!(shares.residual()[0] > 0.0);
        let mut assigned = [0.0; 3];
        for k in (0..shares.len()).filter(|&k| weight(&shares, k) == 1.0) {
            let f = flux(&photons, shares.of(k).map(|(j, _)| j));
            (0..3).for_each(|c| assigned[c] += f[c]);
        }
        let total = flux(&photons, 0..photons.len() as u32);
        // Residual photons that were kept with certainty are lights of scale 1 as well.
        let certain: Vec<u32> = (0..shares.len())
            .filter(|&k| weight(&shares, k) == 1.0 && shares.of(k).len() == 1)
            .map(|k| shares.sites()[k].photon)
            .filter(|j| sites.iter().all(|s| s.photon != *j))
            .collect();
        let certain = flux(&photons, certain.into_iter());
        for c in 0..3 {
            let sum = assigned[c] - certain[c] + shares.residual()[c];
            assert!((sum / total[c] - 1.0).abs() < 1e-6, "{sum} of {}", total[c]);
        }
    }

    #[test]
    fn photons_go_to_the_nearest_light() {
        let photons = photons_on_square(3000, 2);
        let weights = luminances(&photons);
        let sites = select(&photons, &weights, 100, 0.4);
        let (shares, _) = assign(&OPEN, &photons, &sites, &weights, 0.7);
        let mut seen = vec![false; photons.len()];
        for k in 0..shares.len() {
            let p = photons[shares.sites()[k].photon as usize].p;
            for (j, _) in shares.of(k) {
                assert!(
                    !std::mem::replace(&mut seen[j as usize], true),
                    "photon {j} was given away twice"
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
    fn claims_name_the_lights_that_took_the_photons() {
        let photons = photons_on_square(3000, 5);
        let weights = luminances(&photons);
        let sites = select(&photons, &weights, 100, 0.2);
        let (shares, claims) = assign(&OPEN, &photons, &sites, &weights, 0.7);
        for k in 0..shares.len() {
            for (j, _) in shares.of(k) {
                let spot = SurfaceLocation::of(&photons[j as usize], &OPEN);
                assert_eq!(claims.light(&OPEN, &spot).map(|id| id.index()), Some(k));
            }
        }
        let elsewhere = SurfaceLocation {
            material: MaterialId(7),
            ..SurfaceLocation::of(&photons[0], &OPEN)
        };
        assert!(claims.light(&OPEN, &elsewhere).is_none());
        assert!(
            NearestLights::none()
                .light(&OPEN, &SurfaceLocation::of(&photons[0], &OPEN))
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
        let (shares, _) = assign(&Room { wall: Some(0.5) }, &photons, &sites, &weights, 0.1);
        for k in 0..shares.len() {
            let x = photons[shares.sites()[k].photon as usize].p.x;
            assert!(
                shares
                    .of(k)
                    .all(|(j, _)| (photons[j as usize].p.x < 0.5) == (x < 0.5))
            );
        }
    }

    #[test]
    fn residual_flux_is_right_on_average_and_bounded() {
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
        let mut residual = 0.0;
        for t in 0..trials {
            let (shares, _) = assign(
                &OPEN,
                &photons,
                &sites,
                &weights,
                (t as f32 + 0.5) / trials as f32,
            );
            residual = shares.residual()[1];
            for k in (0..shares.len()).filter(|&k| weight(&shares, k) > 1.0) {
                let light = photons[shares.sites()[k].photon as usize].flux * weight(&shares, k);
                assert!(light.luminance() < 10.0 * median);
                mean += f64::from(light.g) / f64::from(trials);
            }
        }
        assert!(residual > 100.0);
        assert!((mean / residual - 1.0).abs() < 0.02, "{mean} of {residual}");
    }

    #[test]
    fn there_may_be_nothing_to_assign() {
        assert!(assign(&OPEN, &[], &[], &[], 0.5).0.is_empty());
        let photons = [photon(Vec3::ZERO, Vec3::Z)];
        let (shares, _) = assign(&OPEN, &photons, &[], &[1.0], 0.5);
        assert_eq!((shares.len(), weight(&shares, 0)), (1, 1.0));
        let own = PhotonClusters::own(&[Site {
            photon: 0,
            probability: 0.25,
        }]);
        assert!(own.of(0).eq([(0, 4.0)]));
    }
}
