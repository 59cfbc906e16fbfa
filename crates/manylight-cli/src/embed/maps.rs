//! The interim maps of a many-light method.

use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::preset::no_lights;
use crate::session::Session;
use manylight::integrators::{InterimMaps, MethodKind, PassContext};
use manylight::sampling::Pass;

impl Session {
    /// The maps of the first pass, as `manylight maps` shows them. `None` if it was interrupted.
    ///
    /// # Errors
    /// The method has no virtual lights.
    pub fn interim_maps(&self, interrupt: &Interrupt) -> Result<Option<InterimMaps>, Failure> {
        let MethodKind::ManyLight(lights) = &self.request.kind else {
            return Err(no_lights(self.request.method));
        };
        let method = self.request.method(self.scene.limits);
        Ok(self.pool.install(|| {
            let guide = self.scene.emission_guide();
            let run = PassContext {
                guide: &guide,
                pass: Pass {
                    seed: self.request.seed,
                    index: 0,
                },
                stats: &self.stats,
                cancel: interrupt.cancel(),
            };
            lights.interim_maps(&self.scene, method.limits, &run)
        }))
    }
}
