//! Photons that arrive straight from the environment: they guide the search for its light around
//! them.

use super::compatible::MIN_COS;
use super::{KdTree, Located, Neighbors};
use crate::arrays::{Fields, Record};
use crate::bsdf::Lobes;
use crate::emitters::EnvironmentLobes;
use crate::math::Vec3;
use crate::particles::Photon;
use crate::scene::Scene;

/// Number of photons above which only a regular subset is stored. Directions vary slowly over a
/// surface; fewer photons save memory and time. A path brings at most one of these photons, so that
/// all of a pass with the default number of paths are stored, and at least one in eight of a group
/// of eight passes.
const MAX_PHOTONS: usize = 1 << 18;

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

impl Record for Incident {
    const EMPTY: Self = Incident {
        p: Vec3::ZERO,
        n: Vec3::ZERO,
        wi: Vec3::ZERO,
    };

    fn fields(&mut self, f: &mut impl Fields) {
        f.vec3("p", &mut self.p);
        f.vec3("n", &mut self.n);
        f.vec3("wi", &mut self.wi);
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

    /// A map of all the photons, which keep their order.
    pub(crate) fn of_photons(photons: Vec<Incident>) -> Self {
        IncidentMap {
            photons: KdTree::of_ordered(photons),
        }
    }

    /// A map of the photons that arrive straight from the environment; empty if the scene has only
    /// directional infinite lights or none. (Emitters inside the scene are sampled by area.)
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

    /// The photons.
    pub(crate) fn photons(&self) -> &[Incident] {
        self.photons.items()
    }

    /// The density at `p` on the side of the unit normal `n`; `None` with fewer than 4 photons
    /// there. The size of `found` is at most
    /// [`MAX_ENVIRONMENT_LOBES`](crate::emitters::MAX_ENVIRONMENT_LOBES).
    pub fn around(&self, p: Vec3, n: Vec3, found: &mut Neighbors) -> Option<EnvironmentLobes> {
        if self.photons.items().is_empty() {
            return None;
        }
        self.photons.nearest(p, f32::INFINITY, found);
        let items = self.photons.items();
        let on_surface = found
            .iter()
            .map(|(i, _)| &items[i as usize])
            .filter(|photon| photon.n.dot(n) >= MIN_COS);
        EnvironmentLobes::new(on_surface.map(|photon| photon.wi))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emitters::MAX_ENVIRONMENT_LOBES;
    use crate::math::Vec2;
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
        let mut found = Neighbors::new(MAX_ENVIRONMENT_LOBES);
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
        let mut found = Neighbors::new(MAX_ENVIRONMENT_LOBES);
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
