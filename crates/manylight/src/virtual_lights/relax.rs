//! Placement: relaxation, which pushes lights apart until they are evenly spread.
//!
//! Source: Simon, Hanika, Dachsbacher 2015, after Spencer, Jones, "Into the Blue: Better Caustics through Photon Relaxation", 2009.

use super::Site;
use super::curve::Curve;
use super::nearest_light::Surfaces;
use crate::maps::{KdTree, Neighbors, Patch};
use crate::math::Vec3;
use crate::particles::Photon;
use rayon::prelude::*;

/// Rounds of repulsion, at most.
pub const ITERATIONS: usize = 20;
/// Neighbors that push a light.
const PUSHING: usize = 12;
/// Lights that are looked at for them: some are on other surfaces.
const LOOKED_AT: usize = 2 * PUSHING;
/// Lights rest when they move by less than this share of their spacing on average.
const AT_REST: f32 = 0.05;

/// A light on its way.
#[derive(Clone, Copy)]
struct Mover {
    patch: Patch,
    photon: u32,
    /// Distance of the farthest neighbor that pushes it, in m.
    spacing: f32,
}

/// Pushes lights away from their nearest neighbors on the same surface,
///
/// ```text
/// Δx = 1/K Σ_k (x - x_k) (d_K / d_k - 1)
/// ```
///
/// along the surface, and lets each return to the nearest photon of its surface that no other light stands on. The probabilities
/// of the sites no longer say how densely they stand: flux must come from a rule that does not ask them. The sites follow the
/// space-filling curve.
pub fn relax(surfaces: &impl Surfaces, photons: &[Photon], sites: &[Site]) -> Vec<Site> {
    let places: Vec<Vec3> = photons.iter().map(|photon| photon.p).collect();
    let photon_tree = KdTree::build(places);
    let mut movers: Vec<Mover> = sites
        .par_iter()
        .map(|site| Mover {
            patch: surfaces.patch(&photons[site.photon as usize]),
            photon: site.photon,
            spacing: 0.0,
        })
        .collect();
    for _ in 0..ITERATIONS {
        let before: Vec<Vec3> = movers.iter().map(|mover| mover.patch.p).collect();
        push(&mut movers);
        settle(surfaces, photons, &photon_tree, &mut movers);
        let moved = |(mover, before): (&Mover, &Vec3)| f64::from(mover.patch.p.distance(*before));
        let way: f64 = movers.iter().zip(&before).map(moved).sum();
        // K lights share the disc that reaches to the K-th.
        let spacing = |mover: &Mover| f64::from(mover.spacing / (PUSHING as f32).sqrt());
        if way < f64::from(AT_REST) * movers.iter().map(spacing).sum::<f64>() {
            break;
        }
    }
    let curve = Curve::around(photons);
    let mut relaxed: Vec<Site> = sites
        .iter()
        .zip(&movers)
        .map(|(&site, mover)| Site {
            photon: mover.photon,
            ..site
        })
        .collect();
    relaxed.sort_by_cached_key(|site| {
        let photon = &photons[site.photon as usize];
        curve.key(photon.p, photon.n)
    });
    relaxed
}

/// One round of repulsion, within the tangent planes.
fn push(movers: &mut [Mover]) {
    let places: Vec<Vec3> = movers.iter().map(|mover| mover.patch.p).collect();
    let tree = KdTree::build(places);
    let pushed: Vec<Mover> = movers
        .par_iter()
        .map_init(
            || Neighbors::new(LOOKED_AT + 1),
            |found, mover| pushed(movers, &tree, mover, found),
        )
        .collect();
    movers.copy_from_slice(&pushed);
}

fn pushed(movers: &[Mover], tree: &KdTree<Vec3>, mover: &Mover, found: &mut Neighbors) -> Mover {
    let Patch { p, n, material, .. } = mover.patch;
    tree.nearest(p, f32::INFINITY, found);
    let mut near: Vec<(f32, Vec3)> = found
        .iter()
        .map(|(k, d2)| (d2, &movers[k as usize].patch))
        .filter(|(d2, other)| {
            *d2 > 0.0
                && mover
                    .patch
                    .distance_squared(other.p, other.n, material)
                    .is_some()
                && other.material == material
        })
        .map(|(d2, other)| (d2.sqrt(), p - other.p))
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    near.truncate(PUSHING);
    let Some(&(farthest, _)) = near.last() else {
        return *mover;
    };
    let step: Vec3 = near
        .iter()
        .map(|&(d, away)| away * (farthest / d - 1.0))
        .sum();
    let step = step / near.len() as f32;
    let mut moved = Mover {
        spacing: farthest,
        ..*mover
    };
    moved.patch.p += step - n * n.dot(step);
    moved
}

/// Lets every light return to the nearest photon of its surface; to its last one if there is none free.
fn settle(surfaces: &impl Surfaces, photons: &[Photon], tree: &KdTree<Vec3>, movers: &mut [Mover]) {
    let nearest: Vec<u32> = movers
        .par_iter()
        .map(|mover| {
            let cost = |j: u32| {
                let photon = &photons[j as usize];
                if photon.flux.is_black() {
                    return None;
                }
                mover
                    .patch
                    .distance_squared(photon.p, photon.n, surfaces.material(photon))
            };
            let reach = (mover.spacing * mover.spacing).max(f32::MIN_POSITIVE);
            let found = tree.cheapest(mover.patch.p, reach, |j, _| cost(j));
            found.map_or(mover.photon, |(j, _)| j)
        })
        .collect();
    let mut taken = vec![false; photons.len()];
    for mover in movers.iter() {
        taken[mover.photon as usize] = true;
    }
    for (mover, &photon) in movers.iter_mut().zip(&nearest) {
        if !taken[photon as usize] {
            taken[mover.photon as usize] = false;
            taken[photon as usize] = true;
            mover.photon = photon;
        }
        mover.patch = surfaces.patch(&photons[mover.photon as usize]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::select::select;
    use super::super::testing::{OPEN, photons_on_square};
    use super::*;

    /// Mean over lights of the distance to the nearest other one, times the square root of their number.
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
    fn lights_move_apart() {
        let (photons, sites) = placed();
        // Random points are at 0.5 on average, a hexagonal grid at 1.07.
        let before = mean_distance(&photons, &sites);
        assert!((0.4..0.6).contains(&before), "{before}");
        let relaxed = relax(&OPEN, &photons, &sites);
        assert_eq!(relaxed.len(), sites.len());
        let mut own: Vec<u32> = relaxed.iter().map(|site| site.photon).collect();
        own.sort_unstable();
        own.dedup();
        assert_eq!(own.len(), sites.len(), "two lights on one photon");
        let after = mean_distance(&photons, &relaxed);
        assert!(after > 0.65, "{after} after {before}");
    }

    #[test]
    fn lights_stay_on_their_surface() {
        let (mut photons, sites) = placed();
        for photon in photons.iter_mut().skip(1).step_by(2) {
            photon.n = -photon.n;
        }
        let relaxed = relax(&OPEN, &photons, &sites);
        let facing_up = |sites: &[Site]| {
            let up = sites
                .iter()
                .filter(|s| photons[s.photon as usize].n.z > 0.0);
            up.count()
        };
        assert_eq!(facing_up(&relaxed), facing_up(&sites));
        assert!((100..200).contains(&facing_up(&sites)));
    }

    #[test]
    fn a_lone_light_stays() {
        let photons = photons_on_square(100, 4);
        let sites = select(&photons, &[1.0; 100], 1, 0.5);
        let relaxed = relax(&OPEN, &photons, &sites);
        assert_eq!(relaxed[0].photon, sites[0].photon);
        assert!(relax(&OPEN, &photons, &[]).is_empty());
    }
}
