//! Placement, step 2 (optional): relaxation moves sites apart until they are evenly spread over
//! each surface.
//!
//! Source: Simon, Hanika, Dachsbacher, "Rich-VPLs", Eurographics 2015, after Spencer, Jones, "Into
//! the Blue: Better Caustics through Photon Relaxation", Computer Graphics Forum 2009.

use super::candidates::Candidates;
use super::select::Site;
use super::surfaces::Surfaces;
use crate::maps::{KdTree, Neighbors, Patch};
use crate::math::Vec3;
use crate::particles::Photon;
use rayon::prelude::*;

/// Largest number of iterations: the paper's 20.
pub const ITERATIONS: usize = 20;
/// K, the number of neighbors on the same surface in the sum of displacements. More neighbors make
/// a smoother, slower relaxation. At 6 and 24 (2 passes with `--placement relaxed` at 72x40, 3
/// seeds; Glossy Room, Kitchen): relMSE -9.5 and -9.0 % (standard error 6 %), shadow rays +3 and -3
/// %.
const NEIGHBORS: usize = 12;
/// Number of neighbors searched to find [`NEIGHBORS`] on the same surface: the others lie on other
/// surfaces.
const NEIGHBORS_SEARCHED: usize = 2 * NEIGHBORS;
/// Mean displacement per iteration, relative to the mean spacing of sites, below which the
/// iteration stops. Trades evenness for time. At 0.025 and 0.1 (2 passes with `--placement relaxed`
/// at 72x40, 3 seeds; Glossy Room, Kitchen): relMSE -4.1 and -6.7 % (standard error 6 %).
const STOPPING_DISPLACEMENT: f32 = 0.05;

/// The current position of a site.
#[derive(Clone, Copy)]
struct MovingSite {
    patch: Patch,
    photon: u32,
    /// Distance d_K to the K-th neighbor on the same surface, in m.
    reach: f32,
}

/// Moves every site `x` away from its `K` nearest neighbors `x_k` on the same surface,
///
/// ```text
/// Δx = 1/K Σ_k (x - x_k) (d_K / d_k - 1),   d_k = |x - x_k|,
/// ```
///
/// within the tangent plane, then to the nearest photon of its surface that no other site occupies;
/// repeats both up to [`ITERATIONS`] times.
///
/// Returns the moved sites in the order of the space-filling curve. Their probabilities are those
/// of the selection and do not describe the density of the moved sites: the flux of lights must
/// come from a rule that does not use them, such as [`assign`](super::assign::assign).
pub fn relax(surfaces: &impl Surfaces, candidates: &Candidates, sites: &[Site]) -> Vec<Site> {
    let photons = &candidates.photons;
    let positions: Vec<Vec3> = photons.iter().map(|photon| photon.p).collect();
    let photon_tree = KdTree::build(positions);
    let mut moving: Vec<MovingSite> = sites
        .par_iter()
        .map(|site| MovingSite {
            patch: surfaces.patch(&photons[site.photon as usize]),
            photon: site.photon,
            reach: 0.0,
        })
        .collect();
    for _ in 0..ITERATIONS {
        let before: Vec<Vec3> = moving.iter().map(|site| site.patch.p).collect();
        displace(&mut moving);
        snap(surfaces, photons, &photon_tree, &mut moving);
        let distance =
            |(site, before): (&MovingSite, &Vec3)| f64::from(site.patch.p.distance(*before));
        let displacement: f64 = moving.iter().zip(&before).map(distance).sum();
        // A disc of radius d_K holds K sites, so that one site has the area of a disc of radius
        // d_K/√K.
        let spacing = |site: &MovingSite| f64::from(site.reach / (NEIGHBORS as f32).sqrt());
        if displacement < f64::from(STOPPING_DISPLACEMENT) * moving.iter().map(spacing).sum::<f64>()
        {
            break;
        }
    }
    let mut relaxed: Vec<Site> = sites
        .iter()
        .zip(&moving)
        .map(|(&site, moved)| Site {
            photon: moved.photon,
            ..site
        })
        .collect();
    let key = |site: &Site| candidates.curve.photon_key(&photons[site.photon as usize]);
    relaxed.sort_by_cached_key(key);
    relaxed
}

/// Displaces every site once.
fn displace(sites: &mut [MovingSite]) {
    let positions: Vec<Vec3> = sites.iter().map(|site| site.patch.p).collect();
    let tree = KdTree::build(positions);
    let displaced: Vec<MovingSite> = sites
        .par_iter()
        .map_init(
            || Neighbors::new(NEIGHBORS_SEARCHED + 1),
            |found, site| displaced_site(sites, &tree, site, found),
        )
        .collect();
    sites.copy_from_slice(&displaced);
}

/// `site` after one displacement; unchanged without neighbors on its surface.
fn displaced_site(
    sites: &[MovingSite],
    tree: &KdTree<Vec3>,
    site: &MovingSite,
    found: &mut Neighbors,
) -> MovingSite {
    let Patch { p, n, .. } = site.patch;
    tree.nearest(p, f32::INFINITY, found);
    let mut near: Vec<(f32, Vec3)> = found
        .iter()
        .map(|(k, d2)| (d2, &sites[k as usize].patch))
        .filter(|(d2, other)| {
            let to_other = (site.patch).distance_squared(other.p, other.n, other.material);
            *d2 > 0.0 && to_other.is_some()
        })
        .map(|(d2, other)| (d2.sqrt(), p - other.p))
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    near.truncate(NEIGHBORS);
    let Some(&(farthest, _)) = near.last() else {
        return *site;
    };
    let step: Vec3 = near
        .iter()
        .map(|&(d, away)| away * (farthest / d - 1.0))
        .sum();
    let step = step / near.len() as f32;
    let mut moved = MovingSite {
        reach: farthest,
        ..*site
    };
    moved.patch.p += step - n * n.dot(step);
    moved
}

/// Moves every site to the nearest free photon with flux of its surface within d_K; back to its
/// previous photon if none is free.
fn snap(
    surfaces: &impl Surfaces,
    photons: &[Photon],
    tree: &KdTree<Vec3>,
    sites: &mut [MovingSite],
) {
    let nearest: Vec<u32> = sites
        .par_iter()
        .map(|site| {
            let cost = |j: u32| {
                let photon = &photons[j as usize];
                if photon.flux.is_black() {
                    return None;
                }
                site.patch
                    .distance_squared(photon.p, photon.n, surfaces.material(photon))
            };
            let limit = (site.reach * site.reach).max(f32::MIN_POSITIVE);
            let found = tree.cheapest(site.patch.p, limit, |j, _| cost(j));
            found.map_or(site.photon, |(j, _)| j)
        })
        .collect();
    let mut occupied = vec![false; photons.len()];
    for site in sites.iter() {
        occupied[site.photon as usize] = true;
    }
    for (site, &photon) in sites.iter_mut().zip(&nearest) {
        if !occupied[photon as usize] {
            occupied[site.photon as usize] = false;
            occupied[photon as usize] = true;
            site.photon = photon;
        }
        site.patch = surfaces.patch(&photons[site.photon as usize]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::select::select;
    use super::super::testing::{OPEN, candidates, photons_on_square};
    use super::*;

    /// Mean over lights of the distance to the nearest other one, times the square root of their
    /// number.
    fn mean_distance(photons: &[Photon], sites: &[Site]) -> f32 {
        let p = |site: &Site| photons[site.photon as usize].p;
        let nearest = |a: &Site| {
            let others = sites.iter().filter(|b| b.photon != a.photon);
            others
                .map(|b| p(a).distance(p(b)))
                .fold(f32::INFINITY, f32::min)
        };
        sites.iter().map(nearest).sum::<f32>() / (sites.len() as f32).sqrt()
    }

    /// The sites after relaxation among photons of equal weight.
    fn relaxed(photons: &[Photon], sites: &[Site]) -> Vec<Site> {
        let weights = vec![1.0; photons.len()];
        relax(&OPEN, &candidates(photons, &weights), sites)
    }

    fn placed() -> (Vec<Photon>, Vec<Site>) {
        let photons = photons_on_square(20_000, 3);
        // Independent of each other, unlike systematic ones.
        let sites = (0..300)
            .map(|i| Site {
                photon: i * 61,
                probability: 0.015,
            })
            .collect();
        (photons, sites)
    }

    #[test]
    fn sites_move_apart() {
        let (photons, sites) = placed();
        // Random points are at 0.5 on average, a hexagonal grid at 1.07.
        let before = mean_distance(&photons, &sites);
        assert!((0.4..0.6).contains(&before), "{before}");
        let moved = relaxed(&photons, &sites);
        assert_eq!(moved.len(), sites.len());
        let mut own: Vec<u32> = moved.iter().map(|site| site.photon).collect();
        own.sort_unstable();
        own.dedup();
        assert_eq!(own.len(), sites.len(), "two sites on one photon");
        let after = mean_distance(&photons, &moved);
        assert!(after > 0.65, "{after} after {before}");
    }

    #[test]
    fn sites_stay_on_their_surface() {
        let (mut photons, sites) = placed();
        for photon in photons.iter_mut().skip(1).step_by(2) {
            photon.n = -photon.n;
        }
        let moved = relaxed(&photons, &sites);
        let facing_up = |sites: &[Site]| {
            let up = sites
                .iter()
                .filter(|s| photons[s.photon as usize].n.z > 0.0);
            up.count()
        };
        assert_eq!(facing_up(&moved), facing_up(&sites));
        assert!((100..200).contains(&facing_up(&sites)));
    }

    #[test]
    fn a_lone_site_stays() {
        let photons = photons_on_square(100, 4);
        let sites = select(&photons, &[1.0; 100], 1, 0.5);
        let moved = relaxed(&photons, &sites);
        assert_eq!(moved[0].photon, sites[0].photon);
        assert!(relaxed(&photons, &[]).is_empty());
    }
}
