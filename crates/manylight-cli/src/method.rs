//! The method of a render: a preset with the settings that options override. Contradictions are
//! refused.

use crate::failure::Failure;
use crate::light_options::{LightArgs, LightOption, MANY_LIGHT, PHOTON_MAP};
use crate::preset::{self, Preset};
use manylight::integrators::MethodKind;
use manylight::integrators::many_light::{
    ClampRule, Compensation, Contradiction, Effort, FluxRule, Kernel, ManyLight,
    PHOTON_PATHS_PER_LIGHT, Resampling, Strategy,
};

/// The method of `preset` with the settings of `options`.
///
/// # Errors
/// A combination of settings without a meaning.
pub(crate) fn method_kind(preset: &Preset, options: &LightArgs) -> Result<MethodKind, Failure> {
    let mut kind = (preset.kind)();
    match &mut kind {
        MethodKind::ManyLight(method) => {
            override_settings(method, MANY_LIGHT, preset, options)?;
            follow(method, options);
            refuse_without_meaning(method, MANY_LIGHT, options)?;
            method.check().map_err(contradiction)?;
        }
        MethodKind::PhotonMap(method) => {
            override_settings(method, PHOTON_MAP, preset, options)?;
            refuse_without_meaning(method, PHOTON_MAP, options)?;
        }
        _ => override_settings(&mut (), &[], preset, options)?,
    }
    Ok(kind)
}

/// Sets the given options, and refuses those of other methods.
fn override_settings<M>(
    method: &mut M,
    table: &[LightOption<M>],
    preset: &Preset,
    given: &LightArgs,
) -> Result<(), Failure> {
    let is_foreign = |name: &&str| table.iter().all(|option| option.name != *name);
    if let Some(name) = given.names().find(is_foreign) {
        return Err(Failure::usage(
            format!("--{name} has no meaning for the method `{}`", preset.name),
            format!("it belongs to {}", preset::names_with(name).join(", ")),
        ));
    }
    for option in table {
        if let Some(value) = given.get(option.name) {
            let expected =
                |expected| Failure::usage(format!("--{}: found '{value}'", option.name), expected);
            (option.set)(method, value).map_err(expected)?;
        }
    }
    Ok(())
}

/// Refuses given options that have no meaning beside the other settings.
fn refuse_without_meaning<M>(
    method: &M,
    table: &[LightOption<M>],
    given: &LightArgs,
) -> Result<(), Failure> {
    for option in table
        .iter()
        .filter(|option| given.get(option.name).is_some())
    {
        let Some((other, word)) = option.needs else {
            continue;
        };
        if (option.get)(method).is_none() {
            let found = table.iter().find(|option| option.name == other);
            let found = found
                .and_then(|option| (option.get)(method))
                .unwrap_or_default();
            return Err(Failure::usage(
                format!("--{} has no meaning for --{other} {found}", option.name),
                format!("add --{other} {word}"),
            ));
        }
    }
    Ok(())
}

/// Changes the settings that follow from others, unless they are given.
fn follow(method: &mut ManyLight, given: &LightArgs) {
    let is_open = |name| given.get(name).is_none();
    if is_open("photons") {
        let least = method.light_count.saturating_mul(PHOTON_PATHS_PER_LIGHT);
        method.photon_paths = method.photon_paths.max(least);
    }
    // A cut sums as many lights as its error asks for.
    if is_open("lights") && method.strategy != Strategy::All {
        method.effort = Effort::Fixed;
    }
    if is_open("interleaving") && method.strategy != Strategy::All {
        method.interleaving = 1;
    }
    // A sphere has no singularity.
    if method.kernel.is_sphere() {
        if is_open("clamp") {
            method.clamp = ClampRule::None;
        }
        if is_open("compensation") {
            method.compensation = Compensation::None;
        }
    }
}

/// The failure of settings with which the mean of virtual lights is not that of path tracing, so
/// that no choice is between them; `None` if there are none.
pub(crate) fn choice_refusal(method: &ManyLight) -> Option<Failure> {
    let refused = [
        (method.strategy != Strategy::All, "--strategy"),
        (method.kernel == Kernel::Sphere, "--kernel sphere"),
        (method.flux == FluxRule::Density, "--flux density"),
        (
            method.compensation == Compensation::None && method.clamp != ClampRule::None,
            "--compensation none",
        ),
        (method.resampling == Resampling::New, "--resampling new"),
    ];
    let (_, option) = refused.into_iter().find(|(is_refused, _)| *is_refused)?;
    Some(Failure::usage(
        format!("{option} has no meaning for the method `auto`, which may choose path tracing"),
        "name a method of virtual lights, such as --method rich-vpl",
    ))
}

/// The failure of settings that contradict each other, in words of the options.
fn contradiction(found: Contradiction) -> Failure {
    let (options, remedy) = match found {
        Contradiction::RelaxedDensity => (
            "--placement relaxed with --flux density",
            "use --flux partition",
        ),
        Contradiction::SphereCut => (
            "--kernel sphere with --strategy lightcuts",
            "use --kernel disc or point",
        ),
        Contradiction::SphereClamp => ("--kernel sphere with --clamp", "use --clamp none"),
        Contradiction::SphereCompensation => (
            "--kernel sphere with --compensation",
            "use --compensation none",
        ),
        Contradiction::MeasuredCut => (
            "--lights auto with --strategy lightcuts",
            "give their number",
        ),
        Contradiction::UncompensatedPairs => (
            "--strategy bidirectional without --compensation kollig-keller",
            "use --strategy lightcuts",
        ),
        Contradiction::InterleavedCut => (
            "--interleaving with --strategy lightcuts",
            "use --interleaving 1",
        ),
        Contradiction::LargeBlocks => (
            "--table-storage blocks with a large --table-size",
            "use at most --table-size 60, or --table-storage shared",
        ),
        Contradiction::NoLights | Contradiction::Pattern | Contradiction::CameraPaths => {
            unreachable!("values of options are checked where they are read")
        }
    };
    Failure::usage(
        format!("{options} is a contradiction"),
        format!("{}; {remedy}", found.reason()),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{Cli, Command};
    use crate::names::{EmissionName, words};
    use clap::Parser;
    use manylight::integrators::many_light::{
        EmissionKind, FluxRule, GlossyForm, Kernel, Placement, TableStorage,
    };

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
        let method = lights("s.xml -m vpl --emission table");
        assert_eq!(method.emission, ManyLight::rich_vpl().emission);
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
    fn a_choice_is_between_methods_with_the_same_mean() {
        for (words, is_refused) in [
            ("", false),
            ("-n 512 --photons 1000 --placement uniform --clamp 3", false),
            ("--clamp none --compensation none", false),
            ("--compensation none", true),
            ("--strategy lightcuts", true),
            ("--kernel sphere", true),
            ("--flux density", true),
            ("--resampling new", true),
        ] {
            let refusal = choice_refusal(&lights(&format!("s.xml {words}")));
            assert_eq!(refusal.is_some(), is_refused, "{words}");
        }
    }

    #[test]
    fn every_setting_combines_with_every_other() {
        let mut legal = 0;
        for placement in words::<Placement>() {
            for flux in words::<FluxRule>() {
                for emission in words::<EmissionName>() {
                    for kernel in words::<Kernel>() {
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
        let rules = words::<Placement>().len() * words::<FluxRule>().len() - 1;
        let lights = words::<EmissionName>().len() * words::<Kernel>().len();
        assert_eq!(legal, rules * lights);
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
