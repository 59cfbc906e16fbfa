//! The interim maps of a many-light method.

use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::memory::{OtherMemory, check_memory};
use crate::preset::no_lights;
use crate::session::Session;
use manylight::integrators::{InterimMaps, MethodKind, PassContext, Stage, StageMemory};
use manylight::sampling::Pass;

/// Of a map: five numbers, twice while they are collected, and five pictures of them.
const BYTES_PER_PIXEL: u64 = 2 * 24 + 5 * 12;

/// The maps of the first pass, as `manylight maps` shows them. `None` if it was interrupted.
///
/// # Errors
/// The method has no virtual lights, or would take more memory than the limit.
pub fn interim_maps(
    session: &Session,
    interrupt: &Interrupt,
) -> Result<Option<InterimMaps>, Failure> {
    check_memory_of_maps(session)?;
    checked_maps(session, interrupt)
}

/// Compares the memory of the maps with the limit, before anything is done.
pub(crate) fn check_memory_of_maps(session: &Session) -> Result<(), Failure> {
    let job = session.job();
    let pixels = session.scene.sensor.desc().film.crop_size;
    let maps = StageMemory {
        stage: Stage::Maps,
        bytes: u64::from(pixels.x) * u64::from(pixels.y) * BYTES_PER_PIXEL,
    };
    let limit = session.request.memory_limit;
    let other = OtherMemory {
        beside: Some(maps),
        ..OtherMemory::default()
    };
    (session.pool).install(|| check_memory(limit, &job, other))
}

/// [`interim_maps`] after [`check_memory_of_maps`].
pub(crate) fn checked_maps(
    session: &Session,
    interrupt: &Interrupt,
) -> Result<Option<InterimMaps>, Failure> {
    let (MethodKind::ManyLight(lights), Some(guide)) = (&session.request.kind, session.guide())
    else {
        return Err(no_lights(session.request.paths.method));
    };
    let method = session.request.method(session.scene.limits);
    Ok(session.pool.install(|| {
        let pass = Pass {
            seed: session.request.paths.seed,
            index: 0,
        };
        let (stats, cancel) = (&session.stats, interrupt.cancel());
        let run = PassContext::of_picture(&session.scene, pass, guide, stats, cancel);
        lights.interim_maps(&session.scene, method.limits, &run)
    }))
}
