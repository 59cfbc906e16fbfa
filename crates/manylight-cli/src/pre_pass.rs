//! The pre-pass of `--method auto`: when it is made, and its filter.

use crate::choice;
use crate::failure::Failure;
use crate::memory::{OtherMemory, check_memory};
use crate::output::print_message;
use crate::session::Session;
use manylight::image::Image;
use manylight::integrators::choice::FilterInput;
use manylight::integrators::{ChoicePrePass, PassContext};
use manylight::sampling::Pass;
use manylight::scene::LimitedScene;
use manylight_denoise::{Oidn, denoise_picture};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Makes the choice of a method that is chosen, unless it is made: for a picture that `oidn`
/// denoises, if there is one.
///
/// # Errors
/// The memory limit is too small for the pre-pass.
pub(crate) fn choose(session: &Session, oidn: Option<&Oidn>) -> Result<(), Failure> {
    let request = &session.request;
    if !request.paths.method.is_chosen() || session.choice.get().is_some() {
        return Ok(());
    }
    let method = request.method(session.scene.limits);
    let (Some(lights), Some(guide)) = (method.lights(), session.guide()) else {
        return Ok(());
    };
    let job = session.job();
    let limit = request.memory_limit;
    (session.pool).install(|| check_memory(limit, &job, OtherMemory::default()))?;
    let never = AtomicBool::new(false);
    let pre_pass = session.pool.install(|| {
        let pass = Pass {
            seed: request.paths.seed,
            index: 0,
        };
        let (scene, limits) = (&*session.scene, method.limits);
        let run = PassContext::of_picture(scene, pass, guide, &session.stats, &never);
        ChoicePrePass::new(lights, LimitedScene { scene, limits }, &run)
    });
    let choice = session.stats.time("choice", || match oidn {
        None => pre_pass.choice(None),
        Some(oidn) => pre_pass.choice(Some(&|input: &FilterInput| -> Option<Image> {
            denoise_picture(oidn, input, &never).ok()
        })),
    });
    // Another thread may have made the same choice.
    let _ = session.choice.set(choice);
    Ok(())
}

/// Time of the pre-pass.
pub(crate) fn choice_time(session: &Session) -> Duration {
    let stages = session.stats.stages();
    let choice = stages.iter().find(|(name, _)| *name == "choice");
    choice.map_or(Duration::ZERO, |(_, time)| *time)
}

/// Prints the choice in one line.
pub(crate) fn print_choice(session: &Session) {
    if let Some(choice) = session.choice.get() {
        print_message(choice::line(choice));
    }
}
