//! Photon maps: light on high-roughness lobes is estimated by the density of the photons that
//! arrive there.
//!
//! Two methods share the camera paths of `camera_paths.rs` and `arriving.rs`:
//!
//! * *Progressive* photon mapping follows low-roughness lobes, uses next-event estimation at every
//!   vertex, and estimates by photons the light that reaches high-roughness lobes from other
//!   surfaces. Each pass has its own photons and a smaller kernel than the pass before, so that the
//!   mean over passes converges to the right image.
//! * The photon map *shown directly* estimates by photons all light that non-specular lobes
//!   reflect, with the same kernel in all passes.
//!
//! At a vertex, the lobes are divided. Lobes that gather end the path: they have density estimates,
//! and one more segment may meet an emitter. The others are followed. Photons that come from an
//! emitter by specular events alone count for all non-specular lobes, and followed lobes leave that
//! light out: emitters behind glass may be too small for them. The division depends on the surface
//! and on events alone, so that every path is counted once.
//!
//! Source: Jensen, "Global Illumination using Photon Maps", EGWR 1996; Hachisuka, Ogaki, Jensen,
//! "Progressive Photon Mapping", ACM TOG 2008; Hachisuka, Jensen, "Stochastic Progressive Photon
//! Mapping", ACM TOG 2009; radii as in [`progressive_radius_scale`].

mod arriving;
mod camera_paths;
mod density_estimates;
mod shade;

use super::context::PassContext;
use crate::bsdf::Lobes;
use crate::film::{Film, Tiling};
use crate::lanes::{Float, Mask, Width};
use crate::maps::density::progressive_radius_scale;
use crate::maps::{IncidentMap, KdTree};
use crate::math::UVec2;
use crate::particles::Photon;
use crate::scene::{PathLimits, Scene};
use camera_paths::PhotonMapPass;

/// The light that photons estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimate {
    /// Light that reaches high-roughness lobes from other surfaces, with a kernel that shrinks from
    /// pass to pass.
    Progressive,
    /// All light that non-specular lobes reflect, with the whole kernel in every pass.
    Direct,
}

/// Light from density estimates over photons. Each pass has its own photons.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PhotonMap {
    /// Emitted photon paths per pass.
    pub photon_paths: u32,
    /// Photons in an estimate, before its kernel shrinks.
    pub neighbors: u32,
    /// The light that they estimate.
    pub estimate: Estimate,
}

/// Least roughness of glossy lobes that gather before a non-specular event: lower ones would show
/// single photons. After such an event, which blurs what is seen, all glossy lobes gather.
/// Unmeasured.
const LEAST_GATHERING_ROUGHNESS: f32 = 0.3;
/// Most camera paths per pixel and pass; see [`PhotonMap::camera_paths`]. Unmeasured.
const MAX_CAMERA_PATHS: u32 = 16;

impl PhotonMap {
    /// Progressive photon mapping.
    pub fn progressive() -> Self {
        PhotonMap {
            photon_paths: 262_144,
            neighbors: 64,
            estimate: Estimate::Progressive,
        }
    }

    /// The photon map shown directly.
    pub fn direct() -> Self {
        PhotonMap {
            neighbors: 128,
            estimate: Estimate::Direct,
            ..PhotonMap::progressive()
        }
    }

    /// One pass with its own photons. `false` if cancelled.
    pub(super) fn render_pass(
        &self,
        scene: &Scene,
        limits: PathLimits,
        run: &PassContext,
        film: &mut Film,
    ) -> bool {
        if run.cancelled() {
            return false;
        }
        let stats = run.stats;
        let added = |surface, event| self.segments_added(scene, surface, event);
        let photons = run.trace_photons(scene, limits, self.photon_paths, added);
        let (incident, photons) = stats.time("maps", || {
            let incident = match self.estimate {
                Estimate::Progressive => IncidentMap::of_environment(scene, &photons),
                Estimate::Direct => IncidentMap::new(&[]),
            };
            let counts = |photon: &Photon| self.counts(photon.event);
            let photons = photons.into_iter().filter(counts).collect();
            (incident, KdTree::build_ordered(photons))
        });
        let pass = PhotonMapPass {
            scene,
            limits,
            method: *self,
            photons,
            incident,
            radius_scale: match self.estimate {
                Estimate::Progressive => progressive_radius_scale(run.pass.index + 1),
                Estimate::Direct => 1.0,
            },
            camera_paths: self.camera_paths(film.image_size()),
        };
        let positions = film.desc().sampler();
        run.shade(film, Tiling::UNSHIFTED, |samples| {
            pass.shade_tile(run, &positions, samples)
        })
    }

    /// For [`trace_photons`](crate::particles::trace_photons): the photons that some camera path may
    /// use.
    pub(super) fn segments_added(
        &self,
        scene: &Scene,
        surface: Lobes,
        event: Lobes,
    ) -> Option<u32> {
        // After a non-specular event, all non-specular lobes gather. Photons of the environment guide
        // directions.
        let is_useful = self.counts(event) || scene.emitters.has_environment();
        (surface.has(Lobes::NON_SPECULAR) && is_useful).then_some(1)
    }

    /// Camera paths per pixel in a pass: about as many in all as photon paths, so that neither
    /// dominates the time.
    fn camera_paths(&self, size: UVec2) -> u32 {
        let pixels = u64::from(size.x) * u64::from(size.y);
        let rounded = (u64::from(self.photon_paths) + pixels / 2) / pixels.max(1);
        rounded.clamp(1, u64::from(MAX_CAMERA_PATHS)) as u32
    }

    /// Whether photons from events of this class are part of estimates.
    fn counts(&self, event: Lobes) -> bool {
        self.estimate == Estimate::Direct || event != Lobes::NONE
    }

    /// The lanes in which glossy lobes of these widths gather before the first non-specular event;
    /// after it, all do.
    #[inline(always)]
    fn glossy_gather<S: Width>(&self, width: Float<S>) -> Mask<S> {
        match self.estimate {
            Estimate::Progressive => width.ge(LEAST_GATHERING_ROUGHNESS),
            Estimate::Direct => Mask::splat(width.width(), true),
        }
    }
}
