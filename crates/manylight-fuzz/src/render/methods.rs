//! The methods, with few lights and photons.

use super::numbers::Numbers;
use manylight::integrators::many_light::{ClampRule, EmissionKind, GlossyForm};
use manylight::integrators::{ManyLight, MethodKind, PhotonMap};

/// All presets of the command line.
const METHODS: [fn() -> MethodKind; 15] = [
    || MethodKind::Path,
    || MethodKind::ManyLight(ManyLight::rich_vpl_by_scene()),
    || MethodKind::ManyLight(ManyLight::rich_vpl_paper()),
    || MethodKind::ManyLight(ManyLight::rich_vsl()),
    || MethodKind::ManyLight(ManyLight::vpl()),
    || MethodKind::ManyLight(ManyLight::vpl_importance()),
    || MethodKind::ManyLight(ManyLight::vsl()),
    || MethodKind::ManyLight(ManyLight::lightcuts()),
    || MethodKind::ManyLight(ManyLight::rich_lightcuts()),
    || MethodKind::ManyLight(ManyLight::bidirectional_lightcuts()),
    || MethodKind::PhotonMap(PhotonMap::progressive()),
    || MethodKind::PhotonMap(PhotonMap::direct()),
    || MethodKind::LightTracer,
    || MethodKind::Direct,
    || MethodKind::Aov,
];

/// Texels along an edge of a table. Small ones are the rule: the grid of the largest takes as long
/// as the rest of a render.
const TABLE_SIDES: [u32; 4] = [8, 4, 2, 48];

/// One of the methods.
pub(super) fn method(numbers: &mut Numbers) -> MethodKind {
    let mut kind = numbers.choose(&METHODS)();
    match &mut kind {
        MethodKind::ManyLight(method) => {
            method.light_count = 1 + numbers.below(24) as u32;
            method.photon_paths = 1 + numbers.below(250) as u32;
            method.importon_paths = method.importon_paths.min(numbers.below(100) as u32);
            if numbers.rarely(8) {
                let clamp = ClampRule::Value(numbers.float(0.0, 10.0).abs());
                // Methods that a clamp contradicts keep their own.
                if (ManyLight { clamp, ..*method }).check().is_ok() {
                    method.clamp = clamp;
                }
            }
        }
        MethodKind::PhotonMap(method) => {
            method.photon_paths = 1 + numbers.below(250) as u32;
            method.neighbors = 1 + numbers.below(30) as u32;
        }
        _ => {}
    }
    kind
}

/// Chooses the size of tables, if the lights of the method have tables.
pub(super) fn size_tables(kind: &mut MethodKind, numbers: &mut Numbers) {
    if let MethodKind::ManyLight(method) = kind
        && let EmissionKind::Rich(GlossyForm::Table { side, .. }) = &mut method.emission
    {
        *side = numbers.choose(&TABLE_SIDES);
    }
}
