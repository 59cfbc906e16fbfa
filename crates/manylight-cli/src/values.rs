//! Words and numbers that options take: each list of names stands here once, for parsing, for help and for reports.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use manylight::film::Filter;
use manylight::integrators::many_light::{
    ClampRule, Compensation, EmissionKind, FluxRule, GlossyForm, Kernel, Placement, Resampling,
    ShareOf, Strategy, TableStorage,
};
use manylight::math::UVec2;

/// Names with what they mean.
pub(crate) type Names<T> = [(&'static str, T)];

/// Where virtual lights stand.
pub(crate) const PLACEMENTS: &Names<Placement> = &[
    ("uniform", Placement::Uniform),
    ("importance", Placement::Importance),
    ("relaxed", Placement::Relaxed),
];

/// How much flux each carries.
pub(crate) const FLUX_RULES: &Names<FluxRule> = &[
    ("density", FluxRule::Density),
    ("partition", FluxRule::Partition),
];

/// How one is evaluated.
pub(crate) const KERNELS: &Names<Kernel> = &[
    ("point", Kernel::Point),
    ("sphere", Kernel::Sphere),
    ("disc", Kernel::Disc),
];

/// Which lights the passes have.
pub(crate) const RESAMPLINGS: &Names<Resampling> = &[
    ("new", Resampling::New),
    ("progressive", Resampling::Progressive),
];

/// How the light that the clamp takes away is given back.
pub(crate) const COMPENSATIONS: &Names<Compensation> = &[
    ("none", Compensation::None),
    ("kollig-keller", Compensation::KolligKeller),
];

/// What each light shines, without sizes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EmissionName {
    /// The reflection of one photon.
    Single,
    /// An octahedral table.
    Table,
    /// Von Mises-Fisher lobes.
    Vmf,
}

/// What each light shines.
pub(crate) const EMISSIONS: &Names<EmissionName> = &[
    ("single", EmissionName::Single),
    ("table", EmissionName::Table),
    ("vmf", EmissionName::Vmf),
];

/// The name of what a light shines.
pub(crate) fn emission_name(kind: EmissionKind) -> EmissionName {
    match kind {
        EmissionKind::Single => EmissionName::Single,
        EmissionKind::Rich(GlossyForm::Table { .. }) => EmissionName::Table,
        EmissionKind::Rich(GlossyForm::Lobes { .. }) => EmissionName::Vmf,
    }
}

/// How the texels of tables are stored.
pub(crate) const TABLE_STORAGES: &Names<TableStorage> = &[
    ("float", TableStorage::Float),
    ("shared", TableStorage::Shared),
];

/// Which lights are evaluated, without how closely.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StrategyName {
    /// Every one.
    All,
    /// Some for all, by cuts through a tree.
    Lightcuts,
    /// The same, at the ends of longer eye paths as closely as the pixel needs it.
    Bidirectional,
}

/// Which lights are evaluated.
pub(crate) const STRATEGIES: &Names<StrategyName> = &[
    ("all", StrategyName::All),
    ("lightcuts", StrategyName::Lightcuts),
    ("bidirectional", StrategyName::Bidirectional),
];

/// The name of which lights are evaluated.
pub(crate) fn strategy_name(strategy: Strategy) -> StrategyName {
    match strategy {
        Strategy::All => StrategyName::All,
        Strategy::Cuts(limits) => match limits.share_of {
            ShareOf::Point => StrategyName::Lightcuts,
            ShareOf::Pixel => StrategyName::Bidirectional,
        },
    }
}

/// Reads a share: a number between 0 and 1, or 0 itself.
pub(crate) fn share(text: &str) -> Result<f32, String> {
    let value: f32 = text.parse().map_err(|_| format!("`{text}` is no number"))?;
    if (0.0..=1.0).contains(&value) {
        Ok(value)
    } else {
        Err("expected a number from 0 to 1".into())
    }
}

/// Reconstruction filters with Mitsuba's default parameters.
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

/// Parses one of `names`; clap suggests the nearest one.
pub(crate) fn one_of<T>(names: &'static Names<T>) -> impl TypedValueParser<Value = T>
where
    T: Copy + Send + Sync + 'static,
{
    PossibleValuesParser::new(names.iter().map(|&(name, _)| name)).map(|word| {
        let found = names.iter().find(|&&(name, _)| name == word);
        found
            .expect("invariant: the parser accepts names of the list alone")
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

/// The name of a filter, whatever its parameters.
pub(crate) fn filter_name(filter: &Filter) -> &'static str {
    let same = |other: &Filter| std::mem::discriminant(other) == std::mem::discriminant(filter);
    let found = FILTERS.iter().find(|(_, f)| same(f));
    found.expect("invariant: every filter has a name").0
}

/// The name of a clamp as `--clamp` takes it.
pub(crate) fn clamp_name(clamp: ClampRule) -> String {
    match clamp {
        ClampRule::None => "none".into(),
        ClampRule::Auto => "auto".into(),
        ClampRule::Fixed => "fixed".into(),
        ClampRule::Value(value) => value.to_string(),
    }
}

/// `none`, `auto`, `fixed` or a bound in 1/m².
pub(crate) fn clamp(text: &str) -> Result<ClampRule, String> {
    match text {
        "none" => Ok(ClampRule::None),
        "auto" => Ok(ClampRule::Auto),
        "fixed" => Ok(ClampRule::Fixed),
        _ => positive(text)
            .map(ClampRule::Value)
            .map_err(|_| "expected `none`, `auto`, `fixed` or a positive number".into()),
    }
}

/// Texels along an edge of a table, which is made of blocks of 2 x 2.
pub(crate) fn table_size(text: &str) -> Result<u32, String> {
    match text.parse::<u32>() {
        Ok(n) if (8..=128).contains(&n) && n.is_multiple_of(2) => Ok(n),
        _ => Err("expected an even number from 8 to 128".into()),
    }
}

/// A finite number > 0.
pub(crate) fn positive(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("expected a positive number".into()),
    }
}

/// A finite number.
pub(crate) fn finite(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("expected a number".into()),
    }
}

/// Largest film edge in pixels: beyond it a typing error is likelier than a picture.
const MAX_EDGE: u32 = 65_536;

/// A film size such as `640x360`.
pub(crate) fn size(text: &str) -> Result<UVec2, String> {
    let edge = |word: &str| {
        word.parse::<u32>()
            .ok()
            .filter(|n| (1..=MAX_EDGE).contains(n))
    };
    text.split_once(['x', 'X'])
        .and_then(|(width, height)| Some(UVec2::new(edge(width)?, edge(height)?)))
        .ok_or_else(|| format!("expected WIDTHxHEIGHT such as 640x360, each from 1 to {MAX_EDGE}"))
}

/// A part of the film in fractions of its size; y grows downwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crop {
    /// Left and right edge.
    pub(crate) x: [f32; 2],
    /// Upper and lower edge.
    pub(crate) y: [f32; 2],
}

/// A crop window `x0,x1,y0,y1`.
pub(crate) fn crop(text: &str) -> Result<Crop, String> {
    let numbers: Option<Vec<f32>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x0, x1, y0, y1])
            if 0.0 <= x0 && x0 < x1 && x1 <= 1.0 && 0.0 <= y0 && y0 < y1 && y1 <= 1.0 =>
        {
            Ok(Crop {
                x: [x0, x1],
                y: [y0, y1],
            })
        }
        _ => Err("expected x0,x1,y0,y1 with 0 <= x0 < x1 <= 1 and 0 <= y0 < y1 <= 1".into()),
    }
}

/// A scene parameter `name=value`.
pub(crate) fn define(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.is_empty() => Ok((name.into(), value.into())),
        _ => Err("expected name=value".into()),
    }
}

/// Longest path: `Some(n)`, or `None` for the word -1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MaxDepth(pub(crate) Option<u32>);

/// A path length as Mitsuba counts; -1 is no limit.
pub(crate) fn max_depth(text: &str) -> Result<MaxDepth, String> {
    match text.parse::<i64>() {
        Ok(-1) => Ok(MaxDepth(None)),
        Ok(n) if n >= 1 => u32::try_from(n)
            .map(|n| MaxDepth(Some(n)))
            .map_err(|_| "too large".into()),
        _ => Err(
            "expected -1 for no limit, or at least 1 (1 = emitters only, 2 = direct light)".into(),
        ),
    }
}

/// A number of bytes: `8G`, `512M`, `1.5GB`, in powers of 1000.
pub(crate) fn bytes(word: &str) -> Result<u64, String> {
    const UNITS: [(char, f64); 4] = [('K', 1e3), ('M', 1e6), ('G', 1e9), ('T', 1e12)];
    let word = word.to_ascii_uppercase();
    let word = word.strip_suffix('B').unwrap_or(&word);
    let with_unit = |&(name, unit)| Some((word.strip_suffix(name)?, unit));
    let (number, unit) = UNITS.iter().find_map(with_unit).unwrap_or((word, 1.0));
    match number.parse::<f64>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok((x * unit) as u64),
        _ => Err("expected a size such as 8G or 512M".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_in_bytes() {
        assert_eq!(bytes("8G"), Ok(8_000_000_000));
        assert_eq!(bytes("1.5gb"), Ok(1_500_000_000));
        assert_eq!(bytes("512M"), Ok(512_000_000));
        assert_eq!(bytes("4096"), Ok(4096));
        for bad in ["", "G", "-1G", "0", "8X", "inf", "1 000"] {
            assert!(bytes(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn sizes_and_crops() {
        assert_eq!(size("640x360"), Ok(UVec2::new(640, 360)));
        for bad in ["640", "0x3", "3x-1", "70000x2", "axb", "1x2x3"] {
            assert!(size(bad).is_err(), "{bad}");
        }
        assert_eq!(
            crop("0,0.5,0.25,1"),
            Ok(Crop {
                x: [0.0, 0.5],
                y: [0.25, 1.0]
            })
        );
        for bad in [
            "0,1,0",
            "0.5,0.5,0,1",
            "0,1.1,0,1",
            "-0.1,1,0,1",
            "a,b,c,d",
            "0,nan,0,1",
        ] {
            assert!(crop(bad).is_err(), "{bad}");
        }
        assert_eq!([table_size("8"), table_size("128")], [Ok(8), Ok(128)]);
        for bad in ["6", "33", "130", "-8", "x"] {
            assert!(table_size(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn depths_clamps_and_defines() {
        assert_eq!(max_depth("-1"), Ok(MaxDepth(None)));
        assert_eq!(max_depth("2"), Ok(MaxDepth(Some(2))));
        assert!(max_depth("0").is_err() && max_depth("-2").is_err());
        assert_eq!(clamp("auto"), Ok(ClampRule::Auto));
        assert_eq!(clamp("2.5"), Ok(ClampRule::Value(2.5)));
        assert!(clamp("-1").is_err() && clamp("inf").is_err());
        assert_eq!(define("a=b=c"), Ok(("a".into(), "b=c".into())));
        assert!(define("=b").is_err() && define("a").is_err());
    }

    #[test]
    fn every_name_reads_back() {
        assert_eq!(name_of(KERNELS, &Kernel::Disc), Some("disc"));
        assert_eq!(name_of(TABLE_STORAGES, &TableStorage::Float), Some("float"));
        assert_eq!(filter_name(&Filter::Gaussian { stddev: 2.0 }), "gaussian");
        for clamp_value in [
            ClampRule::None,
            ClampRule::Auto,
            ClampRule::Fixed,
            ClampRule::Value(0.1),
        ] {
            assert_eq!(clamp(&clamp_name(clamp_value)), Ok(clamp_value));
        }
    }
}
