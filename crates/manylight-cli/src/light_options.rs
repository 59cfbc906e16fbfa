//! The options of particles and virtual lights: one row says name, help, and how the option is read
//! and written.
//!
//! The rows make the arguments and the help of the command line, the settings of presets, reports
//! and image files, the command that repeats a render, and the keywords of Python. To add an
//! option, add a row, and a field of the method that it sets.

use crate::names::{
    EmissionName, Named, StrategyName, emission_name, name_of, one_of, strategy_name, value_of,
};
use crate::values;
use clap::builder::ValueParser;
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches};
use manylight::integrators::many_light::{
    Compensation, CutLimits, Effort, EmissionKind, FluxRule, GlossyForm, Kernel, ManyLight,
    Placement, Resampling, Strategy, TableStorage,
};
use manylight::integrators::{MethodKind, PhotonMap};

/// An option of the methods with settings `M`.
pub(crate) struct LightOption<M: 'static> {
    /// Name, after `--`.
    pub(crate) name: &'static str,
    /// Name of one letter.
    pub(crate) short: Option<char>,
    /// What stands for the value in the help.
    pub(crate) value: &'static str,
    /// What it means, without a full stop.
    pub(crate) help: &'static str,
    /// The option and its word without which this one has no meaning.
    pub(crate) needs: Option<(&'static str, &'static str)>,
    /// Parser of the words that it takes; `None` if `set` says what it takes.
    words: Option<fn() -> ValueParser>,
    /// Sets it to a value of the command line, or says what is expected.
    pub(crate) set: fn(&mut M, &str) -> Result<(), String>,
    /// Its value as `set` takes it; `None` if it has no meaning beside the other settings.
    pub(crate) get: fn(&M) -> Option<String>,
}

/// What a row leaves out: that of an option for a number, without a short name.
const NUMBER: LightOption<ManyLight> = LightOption {
    name: "",
    short: None,
    value: "N",
    help: "",
    needs: None,
    words: None,
    set: |_, _| Ok(()),
    get: |_| None,
};

/// The options of the many-light methods, in the order of the help. They are set in this order.
pub(crate) const MANY_LIGHT: &[LightOption<ManyLight>] = &[
    LightOption {
        name: "lights",
        short: Some('n'),
        value: "N|auto",
        help: "Virtual lights per pass. This is a lower bound: photons without a suitable light nearby get additional lights. \
            auto: 512 or a half, a quarter or an eighth of it, and as many photons, emitter samples and camera \
            paths as suit the scene, by a short pre-pass. Default: the preset's",
        set: |method, text| {
            let count = values::light_count(text)?;
            method.light_count = count.map_or(method.light_count, |n| n.get());
            method.effort = count.map_or(Effort::Measured, |_| Effort::Fixed);
            Ok(())
        },
        get: |method| {
            Some(match method.effort {
                Effort::Fixed => method.light_count.to_string(),
                Effort::Measured => values::AUTO.into(),
            })
        },
        ..NUMBER
    },
    photons(
        |method, text| values::set_count(&mut method.photon_paths, text),
        |method| Some(method.photon_paths.to_string()),
    ),
    LightOption {
        name: "placement",
        value: "RULE",
        help: "Selection of light positions among the photons: uniform (probability proportional to flux), importance (flux times \
            importance), relaxed (as importance, then moved apart)",
        words: Some(words::<Placement>),
        set: |method, word| set_word(&mut method.placement, word),
        get: |method| word_of(&method.placement),
        ..NUMBER
    },
    LightOption {
        name: "flux",
        value: "RULE",
        help: "Flux of a light: density (flux of its photon over the selection probability), partition (sum over the photons in its \
            Voronoi cell)",
        words: Some(words::<FluxRule>),
        set: |method, word| set_word(&mut method.flux, word),
        get: |method| word_of(&method.flux),
        ..NUMBER
    },
    LightOption {
        name: "emission",
        value: "KIND",
        help: "Emission of a light: single (reflection of one photon), table (octahedral table of radiant intensity from many photons), \
            vmf (mixture of von Mises-Fisher lobes from many photons)",
        words: Some(words::<EmissionName>),
        set: |method, word| {
            let kind = value_of(word)?;
            if kind != emission_name(method.emission) {
                method.emission = match kind {
                    EmissionName::Single => EmissionKind::Single,
                    EmissionName::Table => EmissionKind::TABLE,
                    EmissionName::Vmf => EmissionKind::LOBES,
                };
            }
            Ok(())
        },
        get: |method| word_of(&emission_name(method.emission)),
        ..NUMBER
    },
    LightOption {
        name: "table-size",
        help: "Texels along an edge of an emission table: an even number from 8 to 128",
        needs: Some(("emission", "table")),
        set: |method, text| {
            let size = values::table_size(text)?;
            if let EmissionKind::Rich(GlossyForm::Table { side, .. }) = &mut method.emission {
                *side = size;
            }
            Ok(())
        },
        get: |method| match method.emission {
            EmissionKind::Rich(GlossyForm::Table { side, .. }) => Some(side.to_string()),
            _ => None,
        },
        ..NUMBER
    },
    LightOption {
        name: "table-storage",
        value: "KIND",
        help: "Storage of a texel: float (12 bytes), shared (4 bytes with a shared exponent), blocks (half a byte in blocks of 4 x 4 texels; black blocks \
            take one byte)",
        needs: Some(("emission", "table")),
        words: Some(words::<TableStorage>),
        set: |method, word| match &mut method.emission {
            EmissionKind::Rich(GlossyForm::Table { storage, .. }) => set_word(storage, word),
            _ => Ok(()),
        },
        get: |method| match method.emission {
            EmissionKind::Rich(GlossyForm::Table { storage, .. }) => word_of(&storage),
            _ => None,
        },
        ..NUMBER
    },
    LightOption {
        name: "lobes",
        help: "Von Mises-Fisher lobes per light, from 1 to 8",
        needs: Some(("emission", "vmf")),
        set: |method, text| {
            let lobes = values::lobes(text)?;
            if let EmissionKind::Rich(GlossyForm::Lobes { count }) = &mut method.emission {
                *count = lobes;
            }
            Ok(())
        },
        get: |method| match method.emission {
            EmissionKind::Rich(GlossyForm::Lobes { count }) => Some(count.to_string()),
            _ => None,
        },
        ..NUMBER
    },
    LightOption {
        name: "kernel",
        value: "KIND",
        help: "Evaluation of a light: point (virtual point light), sphere (virtual spherical light), disc (points over the extent of its \
            photons)",
        words: Some(words::<Kernel>),
        set: |method, word| set_word(&mut method.kernel, word),
        get: |method| word_of(&method.kernel),
        ..NUMBER
    },
    LightOption {
        name: "strategy",
        value: "KIND",
        help: "Summation over the lights: all (every light of the pass), lightcuts (clusters of a light tree), bidirectional (clusters \
            of pairs of gather points and lights: all vertices of the camera paths of a pixel share a cut)",
        words: Some(words::<StrategyName>),
        set: |method, word| {
            let limits = method.strategy.cut_limits().unwrap_or_default();
            method.strategy = match value_of(word)? {
                StrategyName::All => Strategy::All,
                StrategyName::Lightcuts => Strategy::Cuts(limits),
                StrategyName::Bidirectional => Strategy::Bidirectional(limits),
            };
            Ok(())
        },
        get: |method| word_of(&strategy_name(method.strategy)),
        ..NUMBER
    },
    LightOption {
        name: "max-error",
        value: "FRACTION",
        help: "Lightcuts: largest error bound of a cluster, as a fraction of the radiance that all lights contribute",
        needs: Some(("strategy", "lightcuts")),
        set: |method, text| {
            let max_error = values::fraction(text)?;
            limit_cut(method, |limits| limits.max_error = max_error);
            Ok(())
        },
        get: |method| Some(method.strategy.cut_limits()?.max_error.to_string()),
        ..NUMBER
    },
    LightOption {
        name: "max-cut",
        help: "Lightcuts: largest number of clusters in a cut; it takes precedence over --max-error",
        needs: Some(("strategy", "lightcuts")),
        set: |method, text| {
            let max_lights = values::count(text)?.get();
            limit_cut(method, |limits| limits.max_lights = max_lights);
            Ok(())
        },
        get: |method| Some(method.strategy.cut_limits()?.max_lights.to_string()),
        ..NUMBER
    },
    LightOption {
        name: "clamp",
        value: "none|auto|fixed|VALUE",
        help: "Bound of the geometry term: none, auto (from the area that each light represents), fixed (from the median of these \
            areas), or a value in 1/m²",
        set: |method, text| {
            method.clamp = values::clamp(text)?;
            Ok(())
        },
        get: |method| Some(values::clamp_name(method.clamp)),
        ..NUMBER
    },
    LightOption {
        name: "compensation",
        value: "RULE",
        help: "Compensation of the bias of clamping: none, kollig-keller (the clamped fraction is estimated by extending camera paths)",
        words: Some(words::<Compensation>),
        set: |method, word| set_word(&mut method.compensation, word),
        get: |method| word_of(&method.compensation),
        ..NUMBER
    },
    LightOption {
        name: "neighbors",
        help: "Photons in the emission estimate of a light with --flux density",
        set: |method, text| values::set_count(&mut method.neighbors, text),
        get: |method| {
            let is_estimated =
                method.flux == FluxRule::Density && method.emission != EmissionKind::Single;
            is_estimated.then(|| method.neighbors.to_string())
        },
        ..NUMBER
    },
    LightOption {
        name: "resampling",
        value: "KIND",
        help: "Lights of successive passes: new (resampled for each pass), progressive (resampled with increasing density, so that the \
            bias of the mean image vanishes)",
        words: Some(words::<Resampling>),
        set: |method, word| set_word(&mut method.resampling, word),
        get: |method| word_of(&method.resampling),
        ..NUMBER
    },
    LightOption {
        name: "interleaving",
        help: "Edge of the pattern of pixels that are shaded by different subsets of the lights: 1 (all pixels by the same lights), 2, 4",
        needs: Some(("strategy", "all")),
        set: |method, text| {
            method.interleaving = values::interleaving(text)?;
            Ok(())
        },
        get: |method| (method.strategy == Strategy::All).then(|| method.interleaving.to_string()),
        ..NUMBER
    },
];

/// The options of photon maps: some of those of the many-light methods.
pub(crate) const PHOTON_MAP: &[LightOption<PhotonMap>] = &[photons(
    |method, text| values::set_count(&mut method.photon_paths, text),
    |method| Some(method.photon_paths.to_string()),
)];

const fn photons<M>(
    set: fn(&mut M, &str) -> Result<(), String>,
    get: fn(&M) -> Option<String>,
) -> LightOption<M> {
    LightOption {
        name: "photons",
        short: None,
        value: "N",
        help: "Emitted photon paths per pass. Under --lights auto, pictures of more than 640x360 pixels have more in proportion. Default: the preset's, and at least 64 per virtual light",
        needs: None,
        words: None,
        set,
        get,
    }
}

fn words<T: Named>() -> ValueParser {
    one_of::<T>().into()
}

fn set_word<T: Named>(setting: &mut T, word: &str) -> Result<(), String> {
    *setting = value_of(word)?;
    Ok(())
}

fn word_of<T: Named>(setting: &T) -> Option<String> {
    name_of(setting).map(str::to_owned)
}

fn limit_cut(method: &mut ManyLight, change: impl FnOnce(&mut CutLimits)) {
    if let Strategy::Cuts(limits) | Strategy::Bidirectional(limits) = &mut method.strategy {
        change(limits);
    }
}

/// The settings of a method as (option, value), in the order of the help; empty for methods without
/// settings.
pub(crate) fn settings(kind: &MethodKind) -> Vec<(&'static str, String)> {
    fn shown<M>(options: &[LightOption<M>], method: &M) -> Vec<(&'static str, String)> {
        let shown = |option: &LightOption<M>| Some((option.name, (option.get)(method)?));
        options.iter().filter_map(shown).collect()
    }
    match kind {
        MethodKind::ManyLight(method) => shown(MANY_LIGHT, method),
        MethodKind::PhotonMap(method) => shown(PHOTON_MAP, method),
        _ => Vec::new(),
    }
}

/// The given options of particles and virtual lights, as (name, value). Each overrides one setting
/// of the preset.
#[derive(Clone, Debug, Default)]
pub(crate) struct LightArgs(Vec<(&'static str, String)>);

impl LightArgs {
    /// The value of an option, if it is given.
    pub(crate) fn get(&self, name: &str) -> Option<&str> {
        let found = self.0.iter().find(|(option, _)| *option == name);
        found.map(|(_, value)| value.as_str())
    }

    /// Names of the given options.
    pub(crate) fn names(&self) -> impl Iterator<Item = &'static str> {
        self.0.iter().map(|(name, _)| *name)
    }
}

impl LightOption<ManyLight> {
    fn argument(&'static self) -> Arg {
        let parser = match self.words {
            Some(words) => words(),
            None => {
                let set = self.set;
                let checked = move |text: &str| {
                    // Whether a value is right does not depend on the other settings.
                    set(&mut ManyLight::rich_vpl(), text).map(|()| text.to_owned())
                };
                checked.into()
            }
        };
        Arg::new(self.name)
            .long(self.name)
            .short(self.short)
            .value_name(self.value)
            .help(self.help)
            .help_heading("Virtual lights")
            .allow_negative_numbers(self.words.is_none())
            .value_parser(parser)
    }
}

impl Args for LightArgs {
    fn augment_args(command: Command) -> Command {
        command.args(MANY_LIGHT.iter().map(LightOption::argument))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for LightArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let given = |option: &LightOption<ManyLight>| {
            let value = matches.get_raw(option.name)?.next()?;
            Some((option.name, value.to_string_lossy().into_owned()))
        };
        Ok(LightArgs(MANY_LIGHT.iter().filter_map(given).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}
