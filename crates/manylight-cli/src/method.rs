//! The method of a render: a preset with the settings that options override. Contradictions are refused.

use crate::args::LightArgs;
use crate::failure::Failure;
use crate::names::{EMISSIONS, EmissionName, StrategyName, emission_name, name_of, strategy_name};
use crate::preset::{self, Preset};
use crate::values::LightCount;
use manylight::integrators::many_light::{
    ClampRule, Compensation, CutLimits, Effort, EmissionKind, FluxRule, GlossyForm, Kernel,
    ManyLight, Placement, Strategy, TableStorage,
};
use manylight::integrators::{MethodKind, PhotonMap};

/// Default lower bound of the photon paths per virtual light. With this many, the noise of the photon fluxes is expected to be below the noise
/// of the light positions; no measurement is recorded. More paths take longer.
const PHOTONS_PER_LIGHT: u32 = 64;

/// The method of `preset` with the settings of `options`.
///
/// # Errors
/// A combination of settings without a meaning.
pub(crate) fn method_kind(preset: &Preset, options: &LightArgs) -> Result<MethodKind, Failure> {
    match (preset.kind)() {
        MethodKind::ManyLight(method) => Ok(MethodKind::ManyLight(many_light(method, options)?)),
        MethodKind::PhotonMap(method) => {
            refuse_others(preset, options, &["photons"])?;
            Ok(MethodKind::PhotonMap(PhotonMap {
                photon_paths: options.photons.map_or(method.photon_paths, |n| n.get()),
                ..method
            }))
        }
        kind => {
            refuse_others(preset, options, &[])?;
            Ok(kind)
        }
    }
}

/// Refuses options of particles and virtual lights other than `allowed`.
fn refuse_others(preset: &Preset, options: &LightArgs, allowed: &[&str]) -> Result<(), Failure> {
    match first_given(options, allowed) {
        None => Ok(()),
        Some(option) => Err(Failure::usage(
            format!("--{option} has no meaning for the method `{}`", preset.name),
            format!("it belongs to {}", preset::names_with(option).join(", ")),
        )),
    }
}

/// The first given option of particles and virtual lights other than `allowed`.
fn first_given(options: &LightArgs, allowed: &[&str]) -> Option<&'static str> {
    let given = [
        ("lights", options.lights.is_some()),
        ("photons", options.photons.is_some()),
        ("placement", options.placement.is_some()),
        ("flux", options.flux.is_some()),
        ("emission", options.emission.is_some()),
        ("table-size", options.table_size.is_some()),
        ("table-storage", options.table_storage.is_some()),
        ("lobes", options.lobes.is_some()),
        ("kernel", options.kernel.is_some()),
        ("strategy", options.strategy.is_some()),
        ("max-error", options.max_error.is_some()),
        ("max-cut", options.max_cut.is_some()),
        ("clamp", options.clamp.is_some()),
        ("compensation", options.compensation.is_some()),
        ("neighbors", options.neighbors.is_some()),
        ("resampling", options.resampling.is_some()),
    ];
    given
        .iter()
        .find(|(name, given)| *given && !allowed.contains(name))
        .map(|&(name, _)| name)
}

fn many_light(preset: ManyLight, options: &LightArgs) -> Result<ManyLight, Failure> {
    let strategy = strategy(preset.strategy, options)?;
    let (light_count, effort) = match options.lights {
        Some(LightCount::Fixed(count)) => (count.get(), Effort::Fixed),
        Some(LightCount::Auto) => (preset.light_count, Effort::Measured),
        // A cut sums as many lights as its error asks for.
        None if strategy != Strategy::All => (preset.light_count, Effort::Fixed),
        None => (preset.light_count, preset.effort),
    };
    let photons = preset
        .photon_paths
        .max(light_count.saturating_mul(PHOTONS_PER_LIGHT));
    // A sphere has no singularity.
    let kernel = options.kernel.unwrap_or(preset.kernel);
    let (clamp, compensation) = if kernel == Kernel::Sphere {
        (ClampRule::None, Compensation::None)
    } else {
        (preset.clamp, preset.compensation)
    };
    let method = ManyLight {
        light_count,
        photon_paths: options.photons.map_or(photons, |n| n.get()),
        placement: options.placement.unwrap_or(preset.placement),
        flux: options.flux.unwrap_or(preset.flux),
        emission: emission(preset.emission, options)?,
        kernel,
        strategy,
        clamp: options.clamp.unwrap_or(clamp),
        compensation: options.compensation.unwrap_or(compensation),
        neighbors: options.neighbors.map_or(preset.neighbors, |n| n.get()),
        resampling: options.resampling.unwrap_or(preset.resampling),
        effort,
        ..preset
    };
    check_axes(&method)?;
    Ok(method)
}

fn strategy(preset: Strategy, options: &LightArgs) -> Result<Strategy, Failure> {
    let preset_limits = preset.cut_limits().unwrap_or_default();
    let limits = CutLimits {
        max_error: options.max_error.unwrap_or(preset_limits.max_error),
        max_lights: (options.max_cut).map_or(preset_limits.max_lights, |n| n.get()),
    };
    match options.strategy.unwrap_or(strategy_name(preset)) {
        StrategyName::Lightcuts => Ok(Strategy::Cuts(limits)),
        StrategyName::Bidirectional => Ok(Strategy::Bidirectional(limits)),
        StrategyName::All => {
            let given = [
                ("max-error", options.max_error.is_some()),
                ("max-cut", options.max_cut.is_some()),
            ];
            match given.iter().find(|(_, given)| *given) {
                None => Ok(Strategy::All),
                Some((option, _)) => Err(Failure::usage(
                    format!("--{option} has no meaning for --strategy all"),
                    "add --strategy lightcuts",
                )),
            }
        }
    }
}

fn emission(preset: EmissionKind, options: &LightArgs) -> Result<EmissionKind, Failure> {
    let kind = options.emission.unwrap_or(emission_name(preset));
    let sizes = [
        (
            "table-size",
            options.table_size.is_some(),
            EmissionName::Table,
        ),
        (
            "table-storage",
            options.table_storage.is_some(),
            EmissionName::Table,
        ),
        ("lobes", options.lobes.is_some(), EmissionName::Vmf),
    ];
    for (option, given, of) in sizes {
        if given && kind != of {
            let word = |kind| name_of(EMISSIONS, &kind).unwrap_or("unnamed");
            return Err(Failure::usage(
                format!("--{option} has no meaning for --emission {}", word(kind)),
                format!("add --emission {}", word(of)),
            ));
        }
    }
    let (preset_side, preset_storage) = match preset {
        EmissionKind::Rich(GlossyForm::Table { side, storage }) => (side, storage),
        _ => (DEFAULT_TABLE_SIZE, TableStorage::default()),
    };
    Ok(match kind {
        EmissionName::Single => EmissionKind::Single,
        EmissionName::Table => EmissionKind::Rich(GlossyForm::Table {
            side: options.table_size.unwrap_or(preset_side),
            storage: options.table_storage.unwrap_or(preset_storage),
        }),
        EmissionName::Vmf => EmissionKind::Rich(GlossyForm::Lobes {
            count: options.lobes.unwrap_or(DEFAULT_LOBES),
        }),
    })
}

/// Texels along an edge of emission tables for presets without tables. The size of the rich presets.
const DEFAULT_TABLE_SIZE: u32 = 32;

/// Default number of von Mises-Fisher lobes, as in the paper (Simon, Hanika, Dachsbacher 2015).
const DEFAULT_LOBES: u32 = 5;

/// Refuses combinations of settings that contradict each other.
fn check_axes(method: &ManyLight) -> Result<(), Failure> {
    let sphere = method.kernel == Kernel::Sphere;
    let relaxed = method.placement == Placement::Relaxed;
    let (problem, help) = if relaxed && method.flux == FluxRule::Density {
        (
            "--placement relaxed with --flux density",
            "the flux by density needs the selection probability of each light, which is unknown after a relaxation; \
             use --flux partition",
        )
    } else if sphere && method.strategy != Strategy::All {
        (
            "--kernel sphere with --strategy lightcuts",
            "the contribution of a cluster of spheres has no bound; use --kernel disc or point",
        )
    } else if sphere && method.clamp != ClampRule::None {
        (
            "--kernel sphere with --clamp",
            "a sphere has no singularity; use --clamp none",
        )
    } else if sphere && method.compensation != Compensation::None {
        (
            "--kernel sphere with --compensation",
            "without clamping there is no residual to compensate; use --compensation none",
        )
    } else if method.effort == Effort::Measured && method.strategy != Strategy::All {
        (
            "--lights auto with --strategy lightcuts",
            "a cut sums as many lights as its error asks for; give their number",
        )
    } else if is_bidirectional(method) && method.compensation != Compensation::KolligKeller {
        (
            "--strategy bidirectional without --compensation kollig-keller",
            "camera paths are extended by the clamped residual; use --strategy lightcuts",
        )
    } else {
        return Ok(());
    };
    Err(Failure::usage(
        format!("{problem} is a contradiction"),
        help,
    ))
}

fn is_bidirectional(method: &ManyLight) -> bool {
    strategy_name(method.strategy) == StrategyName::Bidirectional
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{Cli, Command};
    use clap::Parser;

    fn method(words: &str) -> Result<MethodKind, Failure> {
        let all = ["manylight", "render"]
            .into_iter()
            .chain(words.split_whitespace());
        match Cli::try_parse_from(all).unwrap().command {
            Command::Render(args) => method_kind(args.paths.method, &args.lights),
            _ => unreachable!(),
        }
    }

    fn lights(words: &str) -> ManyLight {
        match method(words).unwrap() {
            MethodKind::ManyLight(method) => method,
            kind => panic!("{kind:?}"),
        }
    }

    #[test]
    fn options_override_single_settings() {
        let method = lights("s.xml -m vpl-is -n 30000 --clamp none");
        let expected = ManyLight {
            light_count: 30_000,
            photon_paths: 1_920_000,
            clamp: ClampRule::None,
            ..ManyLight::vpl_importance()
        };
        assert_eq!(method, expected);
        let method = lights("s.xml --table-size 16 --kernel point --placement uniform");
        let storage = TableStorage::Shared;
        let table = GlossyForm::Table { side: 16, storage };
        assert_eq!(method.emission, EmissionKind::Rich(table));
        assert_eq!(
            (method.kernel, method.placement),
            (Kernel::Point, Placement::Uniform)
        );
        let storage = TableStorage::Float;
        let table = GlossyForm::Table { side: 48, storage };
        let method = lights("s.xml --table-storage float");
        assert_eq!(method.emission, EmissionKind::Rich(table));
        for (words, count) in [("", 5), ("--lobes 8", 8)] {
            let method = lights(&format!("s.xml --emission vmf {words}"));
            let lobes = GlossyForm::Lobes { count };
            assert_eq!(method.emission, EmissionKind::Rich(lobes));
        }
        let method = lights("s.xml --photons 1000 -n 5000");
        assert_eq!(method.photon_paths, 1000);
        for (words, effort) in [
            ("", Effort::Measured),
            ("-n 512", Effort::Fixed),
            ("--strategy lightcuts", Effort::Fixed),
            ("-m vpl", Effort::Fixed),
            ("-m vpl -n auto", Effort::Measured),
        ] {
            assert_eq!(lights(&format!("s.xml {words}")).effort, effort, "{words}");
        }
    }

    #[test]
    fn every_setting_combines_with_every_other() {
        let mut legal = 0;
        for placement in ["uniform", "importance", "relaxed"] {
            for flux in ["density", "partition"] {
                for emission in ["single", "table", "vmf"] {
                    for kernel in ["point", "sphere", "disc"] {
                        let words = format!(
                            "s.xml --placement {placement} --flux {flux} --emission {emission} --kernel {kernel}"
                        );
                        let contradicts = placement == "relaxed" && flux == "density";
                        assert_eq!(method(&words).is_err(), contradicts, "{words}");
                        legal += usize::from(!contradicts);
                    }
                }
            }
        }
        assert_eq!(legal, 45);
    }

    #[test]
    fn contradictions_are_usage_errors() {
        for words in [
            "s.xml --placement relaxed --flux density",
            "s.xml -m vsl --clamp auto",
            "s.xml --kernel sphere --compensation kollig-keller",
            "s.xml --kernel sphere --strategy lightcuts",
            "s.xml --max-error 0.1",
            "s.xml -m path --max-cut 100",
            "s.xml -m vpl --table-size 8",
            "s.xml --lobes 3",
            "s.xml --emission vmf --table-size 8",
            "s.xml --emission vmf --table-storage float",
            "s.xml -m path --lobes 3",
            "s.xml -m path --lights 5",
            "s.xml -m direct --strategy all",
            "s.xml -m photon-map --lights 5",
            "s.xml -m photon-map-direct --photons 5 --clamp none",
        ] {
            let failure = method(words).unwrap_err();
            assert_eq!(failure.exit_code(), 2, "{words}");
        }
    }
}
