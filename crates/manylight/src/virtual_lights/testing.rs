//! Photons and surfaces for unit tests.

use super::candidates::Candidates;
use super::surfaces::{SurfaceLocation, Surfaces};
use super::{GlossyForm, PhotonClusters, VirtualLights, build_lights};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::geometry::SurfaceRef;
use crate::ids::{LightGroup, MaterialId, PrimitiveId};
use crate::maps::Patch;
use crate::math::{Vec2, Vec3};
use crate::particles::Photon;
use crate::sampling::rng::Pcg;
use crate::scene::{PathLimits, Scene};

/// A photon of 1 W with normal incidence at `p`, on primitive 0.
pub(super) fn photon(p: Vec3, n: Vec3) -> Photon {
    Photon {
        p,
        n,
        wi: n,
        flux: Rgb::WHITE,
        diffuse_flux: Rgb::WHITE * 0.5,
        prev: p + n,
        at: SurfaceRef {
            primitive: PrimitiveId(0),
            element: 0,
            instance: SurfaceRef::NO_INSTANCE,
            coordinates: Vec2::ZERO,
        },
        depth: 1,
        event: Lobes::NONE,
        origin: Lobes::NONE,
        group: LightGroup::default(),
        ray_density: 1.0,
    }
}

/// Photons of random color on the unit square z = 0 with normal +z.
pub(crate) fn photons_on_square(count: usize, key: u64) -> Vec<Photon> {
    let mut rng = Pcg::new(key);
    (0..count)
        .map(|i| {
            let p = Vec3::new(rng.next_f32(), rng.next_f32(), 0.0);
            let flux = Rgb::new(rng.next_f32(), 0.1 + rng.next_f32(), rng.next_f32());
            Photon {
                flux,
                diffuse_flux: flux * 0.5,
                depth: 1 + (i % 5) as u16,
                ..photon(p, Vec3::Z)
            }
        })
        .collect()
}

/// Candidates of these photons and weights.
pub(crate) fn candidates(photons: &[Photon], weights: &[f32]) -> Candidates {
    Candidates::new(photons.to_vec(), weights.to_vec())
}

/// Lights of one light path each.
pub(crate) fn single_lights<'s>(
    scene: &'s Scene,
    limits: PathLimits,
    photons: &[Photon],
    clusters: &PhotonClusters,
) -> VirtualLights<'s> {
    build_lights(scene, limits, photons, clusters, None, |_| true)
}

/// Rich-VPLs.
pub(crate) fn rich_lights<'s>(
    scene: &'s Scene,
    limits: PathLimits,
    photons: &[Photon],
    clusters: &PhotonClusters,
    form: GlossyForm,
) -> VirtualLights<'s> {
    build_lights(scene, limits, photons, clusters, Some(form), |_| true)
}

/// Surfaces with the primitive as material, and without obstacles but for a wall at x = `wall`.
pub(super) struct Room {
    pub(super) wall: Option<f32>,
}

impl Surfaces for Room {
    fn patch(&self, photon: &Photon) -> Patch {
        Patch::new(photon.p, photon.n, self.material(photon), 1.0)
    }
    fn material(&self, photon: &Photon) -> MaterialId {
        MaterialId(photon.at.primitive.0)
    }
    fn connected(&self, location: &SurfaceLocation, patch: &Patch) -> bool {
        self.wall
            .is_none_or(|x| (location.p.x < x) == (patch.p.x < x))
    }
}

pub(super) const OPEN: Room = Room { wall: None };
