//! Figures of a result: what they are called, where they come from, how they are written, which is better.

use super::results::{Record, Status};
use crate::document::Cell;
use serde::Deserialize;

/// A figure that a table shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Figure {
    /// Mean relative squared error.
    Relmse,
    /// Its root, which falls as RMSE does.
    RootRelmse,
    /// Mean squared error.
    Mse,
    /// Its root.
    Rmse,
    /// Mean symmetric relative error.
    Smape,
    /// Structural similarity.
    Ssim,
    /// Mean of HDR-FLIP.
    Flip,
    /// Mean of the picture over that of the reference, of the channel that is furthest off.
    RatioOfMeans,
    /// Share of blocks that noise does not explain.
    #[serde(rename = "blocks-beyond-3")]
    BlocksBeyond3,
    /// Seconds of rendering.
    Seconds,
    /// Seconds of its stages.
    Stages,
    /// Complete passes.
    Passes,
    /// Virtual lights.
    Lights,
    /// The most memory that the process held.
    PeakMemory,
    /// Memory of a virtual light.
    BytesPerLight,
    /// Share of the virtual lights' energy that the clamp took.
    ClampedShare,
}

/// The tables of a task that does not name its own.
pub(super) const DEFAULT: &[Figure] = &[
    Figure::Relmse,
    Figure::RatioOfMeans,
    Figure::Seconds,
    Figure::Stages,
    Figure::PeakMemory,
    Figure::BytesPerLight,
    Figure::ClampedShare,
];

impl Figure {
    /// As a plan names it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Figure::Relmse => "relmse",
            Figure::RootRelmse => "root-relmse",
            Figure::Mse => "mse",
            Figure::Rmse => "rmse",
            Figure::Smape => "smape",
            Figure::Ssim => "ssim",
            Figure::Flip => "flip",
            Figure::RatioOfMeans => "ratio-of-means",
            Figure::BlocksBeyond3 => "blocks-beyond-3",
            Figure::Seconds => "seconds",
            Figure::Stages => "stages",
            Figure::Passes => "passes",
            Figure::Lights => "lights",
            Figure::PeakMemory => "peak-memory",
            Figure::BytesPerLight => "bytes-per-light",
            Figure::ClampedShare => "clamped-share",
        }
    }

    /// Head of its table.
    pub(super) fn title(self) -> &'static str {
        match self {
            Figure::Relmse => "relMSE",
            Figure::RootRelmse => "Root of relMSE",
            Figure::Mse => "MSE",
            Figure::Rmse => "RMSE",
            Figure::Smape => "SMAPE",
            Figure::Ssim => "SSIM",
            Figure::Flip => "HDR-FLIP",
            Figure::RatioOfMeans => "Ratio of means",
            Figure::BlocksBeyond3 => "Blocks that noise does not explain",
            Figure::Seconds => "Seconds",
            Figure::Stages => "Seconds per stage",
            Figure::Passes => "Passes",
            Figure::Lights => "Virtual lights",
            Figure::PeakMemory => "Peak memory (MB)",
            Figure::BytesPerLight => "Bytes per light",
            Figure::ClampedShare => "Share of energy clamped",
        }
    }

    /// What a reader has to know.
    pub(super) fn remark(self) -> &'static str {
        match self {
            Figure::RatioOfMeans => {
                "Picture over reference, of the channel that is furthest off, ± its standard error."
            }
            Figure::BlocksBeyond3 => "Share of blocks of 8x8 pixels with |z| > 3.",
            Figure::Seconds => {
                "Rendering alone, without loading the scene and writing the picture."
            }
            Figure::Passes | Figure::Lights => "In all.",
            Figure::ClampedShare => "Before visibility, and before the compensation gives it back.",
            _ => "",
        }
    }

    /// Whether there is one number of it per run.
    pub(crate) fn is_one_number(self) -> bool {
        self != Figure::Stages
    }

    /// The number.
    pub(super) fn value(self, record: &Record) -> Option<f64> {
        let lights = record.told("/counts/lights").filter(|&n| n > 0.0);
        match self {
            Figure::Relmse => own_error(record, "relmse"),
            Figure::RootRelmse => own_error(record, "relmse").map(f64::sqrt),
            Figure::Mse => own_error(record, "mse"),
            Figure::Rmse => own_error(record, "mse").map(f64::sqrt),
            Figure::Smape => record.metric("/smape"),
            Figure::Ssim => record.metric("/ssim"),
            Figure::Flip => record.metric("/flip"),
            Figure::RatioOfMeans => worst_ratio(record).map(|(ratio, _)| ratio),
            Figure::BlocksBeyond3 => record.metric("/blocks/share_beyond_3"),
            Figure::Seconds => record.render_seconds(),
            Figure::Stages => None,
            Figure::Passes => record.told("/counts/passes"),
            Figure::Lights => lights,
            Figure::PeakMemory => record.told("/memory/peak_bytes").filter(|&b| b > 0.0),
            Figure::BytesPerLight => lights.and(record.told("/memory/bytes_per_light")),
            Figure::ClampedShare => lights.and(record.told("/clamped_share")),
        }
    }

    /// How far from the best a value is; `None` where more is neither better nor worse.
    fn rank(self, value: f64) -> Option<f64> {
        match self {
            Figure::RatioOfMeans | Figure::Ssim => Some((value - 1.0).abs()),
            Figure::Passes | Figure::Lights => None,
            _ => Some(value),
        }
    }

    fn text(self, value: f64, record: &Record) -> String {
        match self {
            Figure::RatioOfMeans => match worst_ratio(record) {
                Some((_, Some(error))) => format!("{value:.3} ± {error:.3}"),
                _ => format!("{value:.3}"),
            },
            Figure::BlocksBeyond3 | Figure::ClampedShare => {
                format!("{} %", number(value * 100.0))
            }
            Figure::PeakMemory => number(value / 1e6),
            Figure::Passes | Figure::Lights => format!("{value}"),
            _ => number(value),
        }
    }

    /// The entry of a table. What was stopped is marked, and not compared.
    pub(super) fn cell(self, record: Option<&Record>) -> Cell {
        let Some(record) = record else {
            return Cell::default();
        };
        match (record.status, self.value(record)) {
            (Status::Failed, _) => Cell::plain("failed"),
            (Status::Stopped, None) => Cell::plain("†"),
            (Status::Stopped, Some(value)) => {
                Cell::plain(format!("{} †", self.text(value, record)))
            }
            (Status::Done, None) => Cell::default(),
            (Status::Done, Some(value)) => Cell {
                text: self.text(value, record),
                rank: self.rank(value),
            },
        }
    }
}

/// A squared error without what the noise of the reference adds; 0 if nothing is left.
fn own_error(record: &Record, name: &str) -> Option<f64> {
    let of_reference = record.metric(&format!("/reference_noise/{name}"));
    let all = record.metric(&format!("/{name}"))?;
    Some((all - of_reference.unwrap_or(0.0)).max(0.0))
}

/// The ratio of means that is furthest from 1, with its standard error where that is known.
fn worst_ratio(record: &Record) -> Option<(f64, Option<f64>)> {
    let ratios = (0..3).filter_map(|c| {
        let ratio = record.metric(&format!("/ratio_of_means/{c}"))?;
        Some((ratio, record.metric(&format!("/ratio_standard_error/{c}"))))
    });
    ratios.max_by(|a, b| (a.0 - 1.0).abs().total_cmp(&(b.0 - 1.0).abs()))
}

/// A number with three digits that count.
pub(super) fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        return "0".into();
    }
    if !(1e-3..1e6).contains(&size) {
        return format!("{value:.2e}");
    }
    // 9.996 is rounded to 10.00, which has a digit more: so round first.
    let before_point = format!("{size:.2e}")
        .rsplit('e')
        .next()
        .and_then(|exponent| exponent.parse::<i32>().ok())
        .unwrap_or(0);
    let digits = usize::try_from(2 - before_point).unwrap_or(0);
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_digits_count() {
        for (value, text) in [
            (0.0, "0"),
            (0.012345, "0.0123"),
            (0.9996, "1.00"),
            (9.996, "10.0"),
            (61.23, "61.2"),
            (612.3, "612"),
            (61234.0, "61234"),
            (1.2345e-5, "1.23e-5"),
            (-0.4567, "-0.457"),
            (1.5e7, "1.50e7"),
        ] {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn names_are_those_of_plans() {
        for figure in DEFAULT.iter().chain(&[
            Figure::RootRelmse,
            Figure::Mse,
            Figure::Rmse,
            Figure::Smape,
            Figure::Ssim,
            Figure::Flip,
            Figure::BlocksBeyond3,
            Figure::Passes,
            Figure::Lights,
        ]) {
            let read: Figure = serde_json::from_value(figure.name().into()).unwrap();
            assert_eq!(read, *figure);
        }
    }
}
