//! Surfaces as the stages see them: material, orientation, and visibility over short distances.

use crate::bsdf::Lobes;
use crate::geometry::Segment;
use crate::ids::MaterialId;
use crate::maps::Patch;
use crate::math::Vec3;
use crate::particles::Photon;
use crate::scene::Scene;

/// Height of the ends of the visibility test above the surface, relative to their distance: clears
/// concave surfaces with up to 25° between the normals.
const SIGHT_LIFT: f32 = 0.1;

/// A point on one side of a surface.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceLocation {
    /// Position.
    pub p: Vec3,
    /// Geometric normal on the side from which light arrives, unit.
    pub n: Vec3,
    /// Material of the surface.
    pub material: MaterialId,
}

impl SurfaceLocation {
    /// The location of a photon.
    pub fn of_photon(photon: &Photon, surfaces: &impl Surfaces) -> Self {
        SurfaceLocation {
            p: photon.p,
            n: photon.n,
            material: surfaces.material(photon),
        }
    }
}

/// The surfaces on which photons lie: a [`Scene`], or a simple model of one in tests.
pub trait Surfaces: Sync {
    /// The surface around a photon.
    fn patch(&self, photon: &Photon) -> Patch;
    /// Material at a photon.
    fn material(&self, photon: &Photon) -> MaterialId;
    /// Whether the patch is visible from the location.
    fn connected(&self, location: &SurfaceLocation, patch: &Patch) -> bool;
}

impl Surfaces for Scene {
    fn patch(&self, photon: &Photon) -> Patch {
        let bsdf = self.bsdf(&self.surface_point(photon.at));
        let roughness = if bsdf.lobes().has(Lobes::GLOSSY) {
            bsdf.glossy_roughness()
        } else {
            1.0
        };
        Patch::new(photon.p, photon.n, self.material(photon), roughness)
    }

    fn material(&self, photon: &Photon) -> MaterialId {
        self.geometry.primitives()[photon.at.primitive.index()].material
    }

    fn connected(&self, location: &SurfaceLocation, patch: &Patch) -> bool {
        let lift = SIGHT_LIFT * location.p.distance(patch.p);
        let segment = Segment {
            from: location.p + location.n * lift,
            to: patch.p + patch.n * lift,
        };
        !self.geometry.occluded(&segment)
    }
}
