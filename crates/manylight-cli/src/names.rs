//! The words that options accept. The same lists serve parsing, help and reports.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use manylight::film::Filter;
use manylight::integrators::many_light::{
    Compensation, EmissionKind, FluxRule, GlossyForm, Kernel, Placement, Resampling, Strategy,
    TableStorage,
};
use manylight_io::image::View;

/// Names of values, in the order of the help.
pub(crate) type Names<T> = [(&'static str, T)];

/// Names of `--placement`.
pub(crate) const PLACEMENTS: &Names<Placement> = &[
    ("uniform", Placement::Uniform),
    ("importance", Placement::Importance),
    ("relaxed", Placement::Relaxed),
];

/// Names of `--flux`.
pub(crate) const FLUX_RULES: &Names<FluxRule> = &[
    ("density", FluxRule::Density),
    ("partition", FluxRule::Partition),
];

/// Names of `--kernel`.
pub(crate) const KERNELS: &Names<Kernel> = &[
    ("point", Kernel::Point),
    ("sphere", Kernel::Sphere),
    ("disc", Kernel::Disc),
];

/// Names of `--resampling`.
pub(crate) const RESAMPLINGS: &Names<Resampling> = &[
    ("new", Resampling::New),
    ("progressive", Resampling::Progressive),
];

/// Names of `--compensation`.
pub(crate) const COMPENSATIONS: &Names<Compensation> = &[
    ("none", Compensation::None),
    ("kollig-keller", Compensation::KolligKeller),
];

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

/// Names of `--emission`.
pub(crate) const EMISSIONS: &Names<EmissionName> = &[
    ("single", EmissionName::Single),
    ("table", EmissionName::Table),
    ("vmf", EmissionName::Vmf),
];

/// The kind of an emission.
pub(crate) fn emission_name(kind: EmissionKind) -> EmissionName {
    match kind {
        EmissionKind::Single => EmissionName::Single,
        EmissionKind::Rich(GlossyForm::Table { .. }) => EmissionName::Table,
        EmissionKind::Rich(GlossyForm::Lobes { .. }) => EmissionName::Vmf,
    }
}

/// Names of `--table-storage`.
pub(crate) const TABLE_STORAGES: &Names<TableStorage> = &[
    ("float", TableStorage::Float),
    ("shared", TableStorage::Shared),
];

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

/// Names of `--strategy`.
pub(crate) const STRATEGIES: &Names<StrategyName> = &[
    ("all", StrategyName::All),
    ("lightcuts", StrategyName::Lightcuts),
    ("bidirectional", StrategyName::Bidirectional),
];

/// The kind of a strategy.
pub(crate) fn strategy_name(strategy: Strategy) -> StrategyName {
    match strategy {
        Strategy::All => StrategyName::All,
        Strategy::Cuts(_) => StrategyName::Lightcuts,
        Strategy::Bidirectional(_) => StrategyName::Bidirectional,
    }
}

/// Names of `--filter`, with the default parameters of Mitsuba.
pub(crate) const FILTERS: &Names<Filter> = &[
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

/// Names of `--view`.
pub(crate) const VIEWS: &Names<View> = &[
    ("standard", View::Standard),
    ("neutral", View::Neutral),
    ("agx", View::Agx),
];

/// Naming of the layers of EXR files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum AovNames {
    /// `R`, `normal.X`.
    #[default]
    Manylight,
    /// `ViewLayer.Combined.R`, `ViewLayer.Normal.X`, as Blender writes them.
    Blender,
}

/// Names of `--aov-names`.
pub(crate) const AOV_NAMES: &Names<AovNames> = &[
    ("manylight", AovNames::Manylight),
    ("blender", AovNames::Blender),
];

/// Parser of one of `names`; clap suggests the most similar name.
pub(crate) fn one_of<T>(names: &'static Names<T>) -> impl TypedValueParser<Value = T>
where
    T: Copy + Send + Sync + 'static,
{
    PossibleValuesParser::new(names.iter().map(|&(name, _)| name)).map(|word| {
        let found = names.iter().find(|&&(name, _)| name == word);
        found
            .expect("invariant: the parser accepts only names of the list")
            .1
    })
}

/// The name of `value`.
pub(crate) fn name_of<T: PartialEq>(names: &Names<T>, value: &T) -> Option<&'static str> {
    names
        .iter()
        .find(|(_, v)| v == value)
        .map(|&(name, _)| name)
}

/// The name of a filter, for any parameters.
pub(crate) fn filter_name(filter: &Filter) -> &'static str {
    let same = |other: &Filter| std::mem::discriminant(other) == std::mem::discriminant(filter);
    let found = FILTERS.iter().find(|(_, f)| same(f));
    found.expect("invariant: every filter has a name").0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_reads_back() {
        assert_eq!(name_of(KERNELS, &Kernel::Disc), Some("disc"));
        assert_eq!(name_of(TABLE_STORAGES, &TableStorage::Float), Some("float"));
        assert_eq!(filter_name(&Filter::Gaussian { stddev: 2.0 }), "gaussian");
    }
}
