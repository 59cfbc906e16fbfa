//! The interim maps of a many-light method.

use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::memory::{Surroundings, check_memory};
use crate::preset::no_lights;
use crate::session::Session;
use manylight::integrators::{InterimMaps, MethodKind, PassContext, StageMemory};
use manylight::sampling::Pass;

/// Of a map: five numbers, twice while they are collected, and five pictures of them.
const BYTES_PER_PIXEL: u64 = 2 * 24 + 5 * 12;

impl Session {
    /// The maps of the first pass, as `manylight maps` shows them. `None` if it was interrupted.
    ///
    /// # Errors
    /// The method has no virtual lights, or would take more memory than the limit.
    pub fn interim_maps(&self, interrupt: &Interrupt) -> Result<Option<InterimMaps>, Failure> {
        self.check_memory_of_maps()?;
        self.checked_maps(interrupt)
    }

    /// Compares the memory of the maps with the limit, before anything is done.
    pub(crate) fn check_memory_of_maps(&self) -> Result<(), Failure> {
        let job = self.job();
        let pixels = self.scene.sensor.desc().film.crop_size;
        let maps = StageMemory {
            stage: "maps",
            bytes: u64::from(pixels.x) * u64::from(pixels.y) * BYTES_PER_PIXEL,
        };
        let limit = self.request.memory_limit;
        let surroundings = Surroundings {
            sums: 0,
            beside: Some(maps),
            at_end: None,
        };
        (self.pool).install(|| check_memory(limit, &job, surroundings))
    }

    /// [`Session::interim_maps`] after [`Session::check_memory_of_maps`].
    pub(crate) fn checked_maps(
        &self,
        interrupt: &Interrupt,
    ) -> Result<Option<InterimMaps>, Failure> {
        let (MethodKind::ManyLight(lights), Some(guide)) = (&self.request.kind, self.guide())
        else {
            return Err(no_lights(self.request.paths.method));
        };
        let method = self.request.method(self.scene.limits);
        Ok(self.pool.install(|| {
            let run = PassContext {
                guide,
                pass: Pass {
                    seed: self.request.paths.seed,
                    index: 0,
                },
                stats: &self.stats,
                cancel: interrupt.cancel(),
                light_groups: 0,
            };
            lights.interim_maps(&self.scene, method.limits, &run)
        }))
    }
}
