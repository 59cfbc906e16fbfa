//! Whose is a photon at some place: the light that the partition rule gives it to.

use super::Site;
use crate::bsdf::Lobes;
use crate::geometry::{Segment, SurfacePoint};
use crate::ids::{LightId, MaterialId};
use crate::maps::{KdTree, Neighbors, Patch};
use crate::math::Vec3;
use crate::particles::Photon;
use crate::scene::Scene;
use rayon::prelude::*;

/// Neighbors that tell the spacing of lights; the light itself is among them.
const SPACING_NEIGHBORS: usize = 9;
/// A photon goes no farther than this many spacings: where so many lights are nearer than the nearest compatible one,
/// the photon's surface has none.
const MAX_SPACINGS: f32 = 3.0;
/// Photons farther than this many spacings from their light must see it. The spacing is the distance of the 8th neighbor, so one
/// photon in eight is tested on an even plane.
const UNSEEN_SPACINGS: f32 = 0.5;
/// Height of the line of sight over the surface, relative to its length: clears hollows of up to 25° between normals.
const SIGHT_LIFT: f32 = 0.1;

/// No light takes this photon.
pub(super) const UNASSIGNED: u32 = u32::MAX;

/// Where a photon arrives, or might.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceLocation {
    /// Position.
    pub p: Vec3,
    /// Geometric normal on the side that the photon arrives from, unit.
    pub n: Vec3,
    /// What the surface is made of.
    pub material: MaterialId,
}

impl SurfaceLocation {
    /// The place of a photon.
    pub fn of(photon: &Photon, surfaces: &impl Surfaces) -> Self {
        SurfaceLocation {
            p: photon.p,
            n: photon.n,
            material: surfaces.material(photon),
        }
    }

    /// The side of `x` that `n`, one of its geometric normals, points to.
    pub fn on(scene: &Scene, x: &SurfacePoint, n: Vec3) -> Self {
        SurfaceLocation {
            p: x.p,
            n,
            material: scene.geometry.primitives()[x.at.primitive.index()].material,
        }
    }
}

/// What claims must know about surfaces.
pub trait Surfaces: Sync {
    /// The surface around a photon that becomes a light.
    fn patch(&self, photon: &Photon) -> Patch;
    /// What the photon lies on.
    fn material(&self, photon: &Photon) -> MaterialId;
    /// Whether nothing stands between the spot and the patch.
    fn connected(&self, spot: &SurfaceLocation, patch: &Patch) -> bool;
}

impl Surfaces for Scene {
    fn patch(&self, photon: &Photon) -> Patch {
        let bsdf = self.bsdf(&self.surface_point(photon.at));
        let width = if bsdf.lobes().has(Lobes::GLOSSY) {
            bsdf.glossy_width()
        } else {
            1.0
        };
        Patch::new(photon.p, photon.n, self.material(photon), width)
    }

    fn material(&self, photon: &Photon) -> MaterialId {
        self.geometry.primitives()[photon.at.primitive.index()].material
    }

    fn connected(&self, spot: &SurfaceLocation, patch: &Patch) -> bool {
        let lift = SIGHT_LIFT * spot.p.distance(patch.p);
        let segment = Segment {
            from: spot.p + spot.n * lift,
            to: patch.p + patch.n * lift,
        };
        !self.geometry.occluded(&segment)
    }
}

/// The lights' claims on photons: a function of the place alone, and the same before and after the lights are made.
#[derive(Clone, Debug)]
pub struct NearestLights {
    patches: Vec<Patch>,
    tree: KdTree<Vec3>,
    /// Distance of each site to its 8th neighbor.
    spacings: Vec<f32>,
    /// The light that each site became.
    lights: Vec<u32>,
}

impl NearestLights {
    /// The claims of `sites`; their lights have no names yet.
    pub(super) fn new(surfaces: &impl Surfaces, photons: &[Photon], sites: &[Site]) -> Self {
        let patches: Vec<Patch> = sites
            .par_iter()
            .map(|site| surfaces.patch(&photons[site.photon as usize]))
            .collect();
        let tree = KdTree::build(patches.iter().map(|patch| patch.p).collect::<Vec<Vec3>>());
        let spacings: Vec<f32> = patches
            .par_iter()
            .map_init(
                || Neighbors::new(SPACING_NEIGHBORS),
                |found, patch| {
                    tree.nearest(patch.p, f32::INFINITY, found);
                    found.radius_squared().sqrt()
                },
            )
            .collect();
        NearestLights {
            patches,
            tree,
            spacings,
            lights: vec![UNASSIGNED; sites.len()],
        }
    }

    /// Unassigned claims anything: every photon is its own light.
    pub fn none() -> Self {
        NearestLights {
            patches: Vec::new(),
            tree: KdTree::build(Vec::new()),
            spacings: Vec::new(),
            lights: Vec::new(),
        }
    }

    /// Says which light each site has become; [`UNASSIGNED`] for those that vanished.
    pub(super) fn name_lights(&mut self, lights: Vec<u32>) {
        self.lights = lights;
    }

    /// The light that a photon at `spot` would belong to; `None` if it would be a light by itself.
    pub fn light(&self, surfaces: &impl Surfaces, spot: &SurfaceLocation) -> Option<LightId> {
        let light = *self.lights.get(self.site(surfaces, spot) as usize)?;
        (light != UNASSIGNED).then_some(LightId(light))
    }

    /// The site that takes a photon at `spot`, or [`UNASSIGNED`].
    pub(super) fn site(&self, surfaces: &impl Surfaces, spot: &SurfaceLocation) -> u32 {
        let cost =
            |k: u32| self.patches[k as usize].distance_squared(spot.p, spot.n, spot.material);
        let Some((any, any_d2)) = self.tree.cheapest(spot.p, f32::INFINITY, |_, d2| Some(d2))
        else {
            return UNASSIGNED;
        };
        // Some spacings of the lights around the photon, whichever way those face: if the nearest is at distance d and has
        // its 8th neighbor at s, the photon has its 8th no farther than d + s.
        let reach = (MAX_SPACINGS * (any_d2.sqrt() + self.spacings[any as usize])).powi(2);
        // The nearest of all mostly is the answer, and bounds the search if not.
        let limit = cost(any).map_or(reach, |c| c.min(reach));
        let Some((k, d2)) = self.tree.cheapest(spot.p, limit, |k, _| cost(k)) else {
            return UNASSIGNED;
        };
        let sees = |k: u32| surfaces.connected(spot, &self.patches[k as usize]);
        if d2 <= (UNSEEN_SPACINGS * self.spacings[k as usize]).powi(2) || sees(k) {
            return k;
        }
        self.tree
            .cheapest(spot.p, reach, |k, _| cost(k).filter(|_| sees(k)))
            .map_or(UNASSIGNED, |(k, _)| k)
    }
}
