//! Where light from afar comes from: a density over directions at a point, made of the photons that arrive around it.
//!
//! A window is small beside the sky, so that few directions to the sky lead through it; photons have found those that do.
//! Source: Jensen, "Importance Driven Path Tracing Using the Photon Map", EGWR 1995; here with von Mises-Fisher lobes.

use super::{KdTree, Located, Neighbors};
use crate::bsdf::Lobes;
use crate::math::{Frame, Vec2, Vec3};
use crate::particles::Photon;
use crate::sampling::warp::{von_mises_fisher, von_mises_fisher_pdf};
use crate::scene::Scene;

/// Photons asked around a point.
pub const INCIDENT_NEIGHBORS: usize = 32;
/// Fewer than this say nothing.
const LEAST_PHOTONS: usize = 4;
/// Photons of the point's own surface have normals within this: cos 25°.
const MIN_COS: f32 = 0.906_308;
/// Photons kept, about: directions change slowly from place to place.
const MOST_PHOTONS: usize = 1 << 18;
/// Bounds of the variance of a lobe, in rad² along each of two axes.
const VARIANCE: [f32; 2] = [4e-4, 0.25];

/// Where a photon came from.
#[derive(Clone, Copy, Debug)]
pub struct Incident {
    /// Where it arrives.
    pub p: Vec3,
    /// Geometric normal there, on its side; unit.
    pub n: Vec3,
    /// Unit direction that it comes from.
    pub wi: Vec3,
}

impl Located for Incident {
    #[inline]
    fn position(&self) -> Vec3 {
        self.p
    }
}

/// Where photons come from, all over the scene.
#[derive(Debug)]
pub struct IncidentMap {
    photons: KdTree<Incident>,
}

impl IncidentMap {
    /// Of so many photons that some of them are enough, only some are kept.
    pub fn new(photons: &[Incident]) -> Self {
        let step = photons.len().div_ceil(MOST_PHOTONS).max(1);
        IncidentMap {
            photons: KdTree::build_ordered(photons.iter().copied().step_by(step).collect()),
        }
    }

    /// Of the photons straight from emitters beyond the scene, if these fill a solid angle. Emitters within it are found by their
    /// area.
    pub fn from_afar(scene: &Scene, photons: &[Photon]) -> Self {
        let bounds = scene.geometry.bounds();
        let is_from_afar = |photon: &&Photon| {
            photon.event == Lobes::NONE
                && scene.emitters.has_environment()
                && bounds.distance_squared(photon.prev) > 0.0
        };
        let incident = |photon: &Photon| Incident {
            p: photon.p,
            n: photon.n,
            wi: photon.wi,
        };
        let incidents: Vec<Incident> = photons.iter().filter(is_from_afar).map(incident).collect();
        IncidentMap::new(&incidents)
    }

    /// The directions around `p` on the side of the unit normal `n`; `None` if too few photons are known there. `found` asks for
    /// [`INCIDENT_NEIGHBORS`] at most.
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
        if guide.count < LEAST_PHOTONS {
            return None;
        }
        // Scott's rule for kernels of n samples in two dimensions: n^(-1/3) of the variance.
        let n = guide.count as f32;
        let variance = (1.0 - sum.length() / n) * n.powf(-1.0 / 3.0);
        guide.kappa = variance.clamp(VARIANCE[0], VARIANCE[1]).recip();
        Some(guide)
    }
}

/// A mixture of equal lobes.
#[derive(Clone, Debug)]
pub struct IncidentGuide {
    axes: [Vec3; INCIDENT_NEIGHBORS],
    count: usize,
    kappa: f32,
}

impl IncidentGuide {
    /// A unit direction with the density [`IncidentGuide::pdf`].
    pub fn sample(&self, u_lobe: f32, u: Vec2) -> Vec3 {
        let lobe = ((u_lobe * self.count as f32) as usize).min(self.count - 1);
        Frame::from_normal(self.axes[lobe])
            .to_world(von_mises_fisher(u, self.kappa))
            .normalize()
    }

    /// Per solid angle.
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
    fn samples_follow_the_density_and_look_where_photons_come_from() {
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
    fn strangers_say_nothing() {
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
