//! Renders for tests.

use manylight::film::Film;
use manylight::integrators::{ExtraLayers, Method, MethodKind};
use manylight::render::{Budget, Observer, RenderJob, Stats, render};
use manylight::scene::Scene;
use std::ops::ControlFlow;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

struct Silent;

impl Observer for Silent {
    fn pass_done(&mut self, _: &Film, _: &Stats, _: Duration) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// `passes` passes of `kind` with the scene's own limits.
pub(crate) fn film(scene: &Scene, kind: MethodKind, passes: u32, seed: u64) -> Film {
    film_with(scene, kind, ExtraLayers::default(), passes, seed)
}

/// [`film`] with more layers.
pub(crate) fn film_with(
    scene: &Scene,
    kind: MethodKind,
    extra: ExtraLayers,
    passes: u32,
    seed: u64,
) -> Film {
    let method = Method {
        kind,
        limits: scene.limits,
        extra,
    };
    let budget = Budget {
        passes: Some(passes),
        time: None,
        relative_error: None,
    };
    let job = RenderJob {
        scene,
        method,
        budget,
        seed,
    };
    render(
        &job,
        &Stats::default(),
        &AtomicBool::new(false),
        &mut Silent,
    )
    .film
}
