//! The words that options accept. The same lists serve parsing, help and reports.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use manylight::film::Filter;
use manylight::integrators::many_light::{
    Compensation, EmissionKind, FluxRule, GlossyForm, Kernel, Placement, Resampling, Strategy,
    TableStorage,
};
use manylight_io::image::View;

/// A kind of values with a word for each.
pub(crate) trait Named: Copy + PartialEq + Send + Sync + 'static {
    /// Words and values, in the order of the help.
    const NAMES: &'static [(&'static str, Self)];
}

/// The words of a kind of values.
pub(crate) fn words<T: Named>() -> Vec<&'static str> {
    T::NAMES.iter().map(|&(word, _)| word).collect()
}

/// The value of a word.
///
/// # Errors
/// The words that are known.
pub(crate) fn value_of<T: Named>(word: &str) -> Result<T, String> {
    let found = T::NAMES.iter().find(|(name, _)| *name == word);
    let value = found.map(|&(_, value)| value);
    value.ok_or_else(|| format!("expected one of {}", words::<T>().join(", ")))
}

/// The word of a value.
pub(crate) fn name_of<T: Named>(value: &T) -> Option<&'static str> {
    T::NAMES
        .iter()
        .find(|(_, v)| v == value)
        .map(|&(name, _)| name)
}

/// Parser of the words of a kind of values; clap suggests the most similar one.
pub(crate) fn one_of<T: Named>() -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(words::<T>())
        .map(|word| value_of(&word).expect("invariant: the parser accepts only words of the list"))
}

/// `--placement`.
impl Named for Placement {
    const NAMES: &'static [(&'static str, Self)] = &[
        ("uniform", Placement::Uniform),
        ("importance", Placement::Importance),
        ("relaxed", Placement::Relaxed),
    ];
}

/// `--flux`.
impl Named for FluxRule {
    const NAMES: &'static [(&'static str, Self)] = &[
        ("density", FluxRule::Density),
        ("partition", FluxRule::Partition),
    ];
}

/// `--kernel`.
impl Named for Kernel {
    const NAMES: &'static [(&'static str, Self)] = &[
        ("point", Kernel::Point),
        ("sphere", Kernel::Sphere),
        ("disc", Kernel::Disc),
    ];
}

/// `--resampling`.
impl Named for Resampling {
    const NAMES: &'static [(&'static str, Self)] = &[
        ("new", Resampling::New),
        ("progressive", Resampling::Progressive),
    ];
}

/// `--compensation`.
impl Named for Compensation {
    const NAMES: &'static [(&'static str, Self)] = &[
        ("none", Compensation::None),
        ("kollig-keller", Compensation::KolligKeller),
    ];
}

/// The kinds of [`EmissionKind`] without their parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EmissionName {
    /// The reflection of one photon.
    Single,
    /// An octahedral table.
    Table,
    /// Von Mises-Fisher lobes.
    Vmf,
}

/// `--emission`.
impl Named for EmissionName {
    const NAMES: &'static [(&'static str, Self)] = &[
        ("single", EmissionName::Single),
        ("table", EmissionName::Table),
        ("vmf", EmissionName::Vmf),
    ];
}

/// The kind of an emission.
pub(crate) fn emission_name(kind: EmissionKind) -> EmissionName {
    match kind {
        EmissionKind::Single => EmissionName::Single,
        EmissionKind::Rich(GlossyForm::Table { .. }) => EmissionName::Table,
        EmissionKind::Rich(GlossyForm::Lobes { .. }) => EmissionName::Vmf,
    }
}

/// `--table-storage`.
impl Named for TableStorage {
    const NAMES: &'static [(&'static str, Self)] = &[
        ("float", TableStorage::Float),
        ("shared", TableStorage::Shared),
        ("blocks", TableStorage::Blocks),
    ];
}

/// The kinds of [`Strategy`] without their parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StrategyName {
    /// All lights.
    All,
    /// Cuts through a light tree.
    Lightcuts,
    /// A cut through the product of the gather points of a pixel and the lights.
    Bidirectional,
}

/// `--strategy`.
impl Named for StrategyName {
    const NAMES: &'static [(&'static str, Self)] = &[
        ("all", StrategyName::All),
        ("lightcuts", StrategyName::Lightcuts),
        ("bidirectional", StrategyName::Bidirectional),
    ];
}

/// The kind of a strategy.
pub(crate) fn strategy_name(strategy: Strategy) -> StrategyName {
    match strategy {
        Strategy::All => StrategyName::All,
        Strategy::Cuts(_) => StrategyName::Lightcuts,
        Strategy::Bidirectional(_) => StrategyName::Bidirectional,
    }
}

/// `--filter`, with the default parameters of Mitsuba.
impl Named for Filter {
    const NAMES: &'static [(&'static str, Self)] = &[
        ("box", Filter::Box),
        ("tent", Filter::Tent { radius: 1.0 }),
        ("gaussian", Filter::Gaussian { stddev: 0.5 }),
        (
            "mitchell",
            Filter::Mitchell {
                b: 1.0 / 3.0,
                c: 1.0 / 3.0,
            },
        ),
        ("catmullrom", Filter::CatmullRom),
        ("lanczos", Filter::Lanczos { lobes: 3.0 }),
    ];
}

/// `--view`.
impl Named for View {
    const NAMES: &'static [(&'static str, Self)] = &[
        ("standard", View::Standard),
        ("neutral", View::Neutral),
        ("agx", View::Agx),
    ];
}

/// Naming of the layers of EXR files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum AovNames {
    /// `R`, `normal.X`.
    #[default]
    Manylight,
    /// `ViewLayer.Combined.R`, `ViewLayer.Normal.X`, as Blender writes them.
    Blender,
}

/// `--aov-names`.
impl Named for AovNames {
    const NAMES: &'static [(&'static str, Self)] = &[
        ("manylight", AovNames::Manylight),
        ("blender", AovNames::Blender),
    ];
}

/// The name of a filter, for any parameters.
pub(crate) fn filter_name(filter: &Filter) -> &'static str {
    let same = |other: &Filter| std::mem::discriminant(other) == std::mem::discriminant(filter);
    let found = Filter::NAMES.iter().find(|(_, f)| same(f));
    found.expect("invariant: every filter has a name").0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_reads_back() {
        assert_eq!(name_of(&Kernel::Disc), Some("disc"));
        assert_eq!(name_of(&TableStorage::Float), Some("float"));
        assert_eq!(filter_name(&Filter::Gaussian { stddev: 2.0 }), "gaussian");
    }
}
