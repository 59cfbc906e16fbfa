//! Directional density of the light from the environment at a point, from the photons around it: guides directions through windows.
//!
//! Few directions to the sky lead through a small window. Photons from the environment have found such directions.
//! Source: Jensen, "Importance Driven Path Tracing Using the Photon Map", EGWR 1995; here with von Mises-Fisher lobes.

use super::{KdTree, Located, Neighbors};
use crate::bsdf::Lobes;
use crate::math::{Frame, Vec2, Vec3};
use crate::particles::Photon;
use crate::sampling::warp::{von_mises_fisher, von_mises_fisher_pdf};
use crate::scene::Scene;

/// Largest number of photons, and of lobes, of a density. More make it smoother and slower to evaluate. Unmeasured.
pub const INCIDENT_NEIGHBORS: usize = 32;
/// Smallest number of photons for a density.
const MIN_PHOTONS: usize = 4;
/// Smallest cosine between the normals of the point and of photons on its surface: 25°.
const MIN_COS: f32 = 0.906_308;
/// Number of photons above which only a regular subset is stored. Directions vary slowly over a surface; fewer photons save memory and time. Unmeasured.
const MAX_PHOTONS: usize = 1 << 18;
/// Smallest and largest variance `1/κ` of a lobe along each of two axes, in rad². Unmeasured.
const VARIANCE: [f32; 2] = [4e-4, 0.25];

/// Position and direction of an arriving photon.
#[derive(Clone, Copy, Debug)]
pub struct Incident {
    /// Position.
    pub p: Vec3,
    /// Geometric normal on the side from which the photon arrives, unit.
    pub n: Vec3,
    /// Unit direction to its origin.
    pub wi: Vec3,
}

impl Located for Incident {
    #[inline]
    fn position(&self) -> Vec3 {
        self.p
    }
}

/// Arriving photons of a scene, found by position.
#[derive(Debug)]
pub struct IncidentMap {
    photons: KdTree<Incident>,
}

impl IncidentMap {
    /// A map of the photons, or of a regular subset if these are very many.
    pub fn new(photons: &[Incident]) -> Self {
        let step = photons.len().div_ceil(MAX_PHOTONS).max(1);
        IncidentMap {
            photons: KdTree::build_ordered(photons.iter().copied().step_by(step).collect()),
        }
    }

    /// A map of the photons that arrive straight from the environment; empty if the scene has only directional infinite lights or none. (Emitters
    /// inside the scene are sampled by area.)
    pub fn of_environment(scene: &Scene, photons: &[Photon]) -> Self {
        let bounds = scene.geometry.bounds();
        let is_from_environment = |photon: &&Photon| {
            photon.event == Lobes::NONE
                && scene.emitters.has_environment()
                && bounds.distance_squared(photon.prev) > 0.0
        };
        let incident = |photon: &Photon| Incident {
            p: photon.p,
            n: photon.n,
            wi: photon.wi,
        };
        let incidents: Vec<Incident> = photons
            .iter()
            .filter(is_from_environment)
            .map(incident)
            .collect();
        IncidentMap::new(&incidents)
    }

    /// The density at `p` on the side of the unit normal `n`; `None` with fewer than 4 photons there. The size of `found` is at most
    /// [`INCIDENT_NEIGHBORS`].
    pub fn around(&self, p: Vec3, n: Vec3, found: &mut Neighbors) -> Option<IncidentGuide> {
        if self.photons.items().is_empty() {
            return None;
        }
        self.photons.nearest(p, f32::INFINITY, found);
        let mut guide = IncidentGuide {
            axes: [Vec3::Z; INCIDENT_NEIGHBORS],
            count: 0,
            kappa: 0.0,
        };
        let mut sum = Vec3::ZERO;
        for (i, _) in found.iter() {
            let photon = &self.photons.items()[i as usize];
            if photon.n.dot(n) >= MIN_COS && guide.count < INCIDENT_NEIGHBORS {
                guide.axes[guide.count] = photon.wi;
                guide.count += 1;
                sum += photon.wi;
            }
        }
        if guide.count < MIN_PHOTONS {
            return None;
        }
        // Scott's rule for n samples in two dimensions: the kernel has n^(-1/3) of their variance.
        let n = guide.count as f32;
        let variance = (1.0 - sum.length() / n) * n.powf(-1.0 / 3.0);
        guide.kappa = variance.clamp(VARIANCE[0], VARIANCE[1]).recip();
        Some(guide)
    }
}

/// A density over directions: a mixture of von Mises-Fisher lobes of equal weight and concentration, one for each photon.
#[derive(Clone, Debug)]
pub struct IncidentGuide {
    axes: [Vec3; INCIDENT_NEIGHBORS],
    count: usize,
    kappa: f32,
}

impl IncidentGuide {
    /// Samples a unit direction with the density [`IncidentGuide::pdf`]; `u_lobe` and `u` are uniform in [0, 1).
    pub fn sample(&self, u_lobe: f32, u: Vec2) -> Vec3 {
        let lobe = ((u_lobe * self.count as f32) as usize).min(self.count - 1);
        Frame::from_normal(self.axes[lobe])
            .to_world(von_mises_fisher(u, self.kappa))
            .normalize()
    }

    /// Density of the unit direction `w` by solid angle, in 1/sr.
    pub fn pdf(&self, w: Vec3) -> f32 {
        let lobes = &self.axes[..self.count];
        let sum: f32 = lobes
            .iter()
            .map(|axis| von_mises_fisher_pdf(axis.dot(w), self.kappa))
            .sum();
        sum / self.count as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::rng::Pcg;

    /// Photons on a square, from two directions; others arrive from below.
    fn map() -> IncidentMap {
        let mut rng = Pcg::new(4);
        let photons: Vec<Incident> = (0..6000)
            .map(|i| {
                let n = if i % 3 == 0 { -Vec3::Z } else { Vec3::Z };
                let towards = Vec3::new(if i % 2 == 0 { 0.8 } else { -0.8 }, 0.0, 0.6 * n.z);
                let jitter = Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) - 0.5;
                Incident {
                    p: Vec3::new(rng.next_f32(), rng.next_f32(), 0.0),
                    n,
                    wi: (towards + jitter * 0.2).normalize(),
                }
            })
            .collect();
        IncidentMap::new(&photons)
    }

    #[test]
    fn samples_follow_the_density_and_the_photons() {
        let mut found = Neighbors::new(INCIDENT_NEIGHBORS);
        let p = Vec3::new(0.4, 0.6, 0.0);
        let guide = map().around(p, Vec3::Z, &mut found).unwrap();
        let mut rng = Pcg::new(5);
        let (n, mut up, mut solid_angle) = (200_000, 0, 0.0);
        for _ in 0..n {
            let (u_lobe, u) = (rng.next_f32(), Vec2::new(rng.next_f32(), rng.next_f32()));
            let w = guide.sample(u_lobe, u);
            up += u32::from(w.z > 0.0);
            // E[1/pdf] over a region is its solid angle, here a band of height 0.4.
            if (0.4..0.8).contains(&w.z) {
                solid_angle += f64::from(1.0 / guide.pdf(w)) / f64::from(n);
            }
        }
        assert!(up as f32 > 0.9 * n as f32, "{up} of {n} look up");
        let exact = std::f64::consts::TAU * 0.4;
        assert!(
            (solid_angle / exact - 1.0).abs() < 0.05,
            "{solid_angle} for {exact}"
        );
    }

    #[test]
    fn other_surfaces_and_empty_maps_have_no_density() {
        let mut found = Neighbors::new(INCIDENT_NEIGHBORS);
        assert!(
            map()
                .around(Vec3::splat(0.5), Vec3::X, &mut found)
                .is_none()
        );
        assert!(
            IncidentMap::new(&[])
                .around(Vec3::ZERO, Vec3::X, &mut found)
                .is_none()
        );
    }
}
