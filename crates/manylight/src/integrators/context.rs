//! What a pass works with, besides the scene.

use crate::bsdf::Lobes;
use crate::emitters::EmissionGuide;
use crate::film::{Film, TileSamples, Tiling};
use crate::particles::{Photon, trace_photons_of_groups};
use crate::sampling::Pass;
use crate::scene::{PathLimits, Scene};
use crate::sensors::Sensor;
use crate::stats::Stats;
use std::sync::atomic::{AtomicBool, Ordering};

/// What a pass works with, besides the scene.
#[derive(Clone, Copy, Debug)]
pub struct PassContext<'a> {
    /// The camera of the picture.
    pub camera: &'a Sensor,
    /// Names the random numbers.
    pub pass: Pass,
    /// Seed of photons and virtual lights. The frames of a walkthrough share it; otherwise it is that
    /// of the pass.
    pub lights_seed: u64,
    /// Guides the emission of photons; made once per render, by methods that emit them.
    pub guide: &'a EmissionGuide,
    /// Counters and stage times.
    pub stats: &'a Stats,
    /// Checked before each tile; `true` cancels the pass.
    pub cancel: &'a AtomicBool,
    /// Number of light groups that the film records: all of the scene, or 0.
    pub light_groups: usize,
}

impl<'a> PassContext<'a> {
    /// For the picture of the scene's sensor, without light groups.
    pub fn of_picture(
        scene: &'a Scene,
        pass: Pass,
        guide: &'a EmissionGuide,
        stats: &'a Stats,
        cancel: &'a AtomicBool,
    ) -> Self {
        PassContext {
            camera: &scene.sensor,
            pass,
            lights_seed: pass.seed,
            guide,
            stats,
            cancel,
            light_groups: 0,
        }
    }

    /// The same context for the random numbers of `pass`, those of photons and lights included.
    pub(super) fn with_pass(self, pass: Pass) -> Self {
        PassContext {
            pass,
            lights_seed: pass.seed,
            ..self
        }
    }

    /// The same context for photons and virtual lights of pass `index`, which are the same in all
    /// frames of a walkthrough.
    pub(super) fn of_lights(self, index: u32) -> Self {
        let seed = self.lights_seed;
        self.with_pass(Pass { seed, index })
    }

    /// The same context for films without light groups.
    pub(super) fn without_light_groups(self) -> Self {
        PassContext {
            light_groups: 0,
            ..self
        }
    }

    /// [`trace_photons`](crate::particles::trace_photons) of this pass, as the stage "photons".
    pub(super) fn trace_photons(
        &self,
        scene: &Scene,
        limits: PathLimits,
        paths: u32,
        segments_added: impl Fn(Lobes, Lobes) -> Option<u32> + Sync,
    ) -> Vec<Photon> {
        let photons = self.stats.time("photons", || {
            let groups = (self.light_groups > 0).then_some(&scene.light_groups);
            let scene = (scene, groups);
            trace_photons_of_groups(scene, self.guide, limits, paths, self.pass, segments_added)
        });
        Stats::count(&self.stats.photon_paths, u64::from(paths));
        Stats::count(&self.stats.photons, photons.len() as u64);
        photons
    }

    /// [`Film::add_tiled_pass`] with progress, as the stage "shade". `false` if cancelled.
    pub(super) fn shade(
        &self,
        film: &mut Film,
        tiling: Tiling,
        shade: impl Fn(&mut TileSamples) + Sync,
    ) -> bool {
        let done = &self.stats.tiles_done;
        done.store(0, Ordering::Relaxed);
        let tiles = film.tile_count(tiling) as u64;
        self.stats.tiles.store(tiles, Ordering::Relaxed);
        self.stats.time("shade", || {
            film.add_tiled_pass(
                tiling,
                self.cancel,
                &self.stats.dropped_samples,
                |samples| {
                    shade(samples);
                    Stats::count(done, 1);
                },
            )
        })
    }

    /// Whether the pass is to be dropped.
    pub(super) fn cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }
}
