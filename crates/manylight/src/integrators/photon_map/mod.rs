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
mod settings;
mod shade;

pub use settings::{Estimate, PhotonMap};

use super::context::PassContext;
use crate::bsdf::Lobes;
use crate::film::{Film, Tiling};
use crate::maps::density::progressive_radius_scale;
use crate::maps::{IncidentMap, KdTree};
use crate::particles::Photon;
use crate::scene::{PathLimits, Scene};
use camera_paths::PhotonMapPass;

impl PhotonMap {
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

    /// For [`trace_photons`](crate::particles::trace_photons): the photons that some camera path
    /// may use.
    pub(super) fn segments_added(
        &self,
        scene: &Scene,
        surface: Lobes,
        event: Lobes,
    ) -> Option<u32> {
        // After a non-specular event, all non-specular lobes gather. Photons of the environment
        // guide directions.
        let is_useful = self.counts(event) || scene.emitters.has_environment();
        (surface.has(Lobes::NON_SPECULAR) && is_useful).then_some(1)
    }
}
