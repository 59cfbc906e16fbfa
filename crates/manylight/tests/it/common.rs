//! Renders for tests.

use manylight::film::Film;
use manylight::film::blocks::DEFAULT_BLOCK;
use manylight::integrators::many_light::{EmissionKind, GlossyForm};
use manylight::integrators::{
    ExtraLayers, ManyLight, Method, MethodKind, Mixed, PathWeights, PhotonMap,
};
use manylight::render::{Budget, RenderJob, Stats, render};
use manylight::scene::Scene;
use std::num::NonZeroU32;
use std::sync::atomic::AtomicBool;

fn small(method: ManyLight) -> MethodKind {
    MethodKind::ManyLight(few_lights(method))
}

fn few_lights(method: ManyLight) -> ManyLight {
    ManyLight {
        photon_paths: 5000,
        light_count: 100,
        importon_paths: 1000,
        ..with_small_tables(method)
    }
}

/// The method with tables of 16 x 16 texels, if it has any: larger ones take most of the time of
/// tests.
pub(crate) fn with_small_tables(method: ManyLight) -> ManyLight {
    match method.emission {
        EmissionKind::Rich(GlossyForm::Table { storage, .. }) => ManyLight {
            emission: EmissionKind::Rich(GlossyForm::Table { side: 16, storage }),
            ..method
        },
        _ => method,
    }
}

/// The mean of `lights` and three path samples, with a weight of its own for each term.
pub(crate) fn mixed(lights: ManyLight) -> Mixed {
    Mixed {
        lights,
        path_samples: NonZeroU32::new(3).unwrap(),
        weights: PathWeights {
            emission: 0.75,
            direct: 0.5,
            indirect: 0.25,
            caustics: 0.625,
        },
    }
}

/// Methods with cuts, with few photons and lights.
pub(crate) fn methods_with_cuts() -> [MethodKind; 2] {
    [
        small(ManyLight::rich_lightcuts()),
        small(ManyLight::bidirectional_lightcuts()),
    ]
}

/// Methods without cuts, with few photons and lights.
pub(crate) fn methods() -> Vec<MethodKind> {
    let few = |method: PhotonMap| {
        MethodKind::PhotonMap(PhotonMap {
            photon_paths: 5000,
            ..method
        })
    };
    vec![
        MethodKind::Path,
        MethodKind::LightTracer,
        MethodKind::Aov,
        small(ManyLight::rich_vpl()),
        small(ManyLight::rich_vpl_by_scene()),
        MethodKind::Mixed(mixed(few_lights(ManyLight::rich_vpl_by_scene()))),
        small(ManyLight::vpl()),
        small(ManyLight::vpl_importance()),
        few(PhotonMap::progressive()),
        few(PhotonMap::direct()),
    ]
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
    let job = RenderJob {
        scene,
        method,
        budget: Budget::passes(passes),
        seed,
        frame: None,
        lights: None,
        block: DEFAULT_BLOCK,
        guide: None,
    };
    render(&job, &Stats::default(), &AtomicBool::new(false), &mut ()).film
}
