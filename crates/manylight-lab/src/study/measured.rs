//! The values of quantities in the results of runs.

use super::quantity::Quantity;
use super::record::{Record, RunStatus};
use crate::document::TableCell;
use crate::text::three_digits;

/// The value of a quantity in a record; `None` if it is not known, or not a single number.
pub(super) fn value(quantity: Quantity, record: &Record) -> Option<f64> {
    let lights = record.report_number("/counts/lights").filter(|&n| n > 0.0);
    match quantity {
        Quantity::Relmse => error_without_reference_noise(record, "relmse"),
        Quantity::RootRelmse => error_without_reference_noise(record, "relmse").map(f64::sqrt),
        Quantity::BlockRelmse => record.metric("/block_relmse"),
        Quantity::Mse => error_without_reference_noise(record, "mse"),
        Quantity::Rmse => error_without_reference_noise(record, "mse").map(f64::sqrt),
        Quantity::Smape => record.metric("/smape"),
        Quantity::Ssim => record.metric("/ssim"),
        Quantity::Flip => record.metric("/flip"),
        Quantity::RatioOfMeans => worst_ratio(record).map(|(ratio, _)| ratio),
        Quantity::BlocksBeyond3 => record.metric("/blocks/share_beyond_3"),
        Quantity::Seconds => record.render_seconds(),
        Quantity::Stages => None,
        Quantity::Passes => record.report_number("/counts/passes"),
        Quantity::Lights => lights,
        Quantity::PeakMemory => record
            .report_number("/memory/peak_bytes")
            .filter(|&b| b > 0.0),
        Quantity::BytesPerLight => lights.and(record.report_number("/memory/bytes_per_light")),
        Quantity::ClampedShare => lights.and(record.report_number("/clamped_share")),
    }
}

/// Sorting key of a value, smallest for the best; `None` for quantities without a better direction.
fn rank(quantity: Quantity, value: f64) -> Option<f64> {
    match quantity {
        Quantity::RatioOfMeans | Quantity::Ssim => Some((value - 1.0).abs()),
        Quantity::Passes | Quantity::Lights => None,
        _ => Some(value),
    }
}

/// The displayed text of a value.
fn text(quantity: Quantity, value: f64, record: &Record) -> String {
    match quantity {
        Quantity::RatioOfMeans => match worst_ratio(record) {
            Some((_, Some(error))) => format!("{value:.3} ± {error:.3}"),
            _ => format!("{value:.3}"),
        },
        Quantity::BlocksBeyond3 | Quantity::ClampedShare => {
            format!("{} %", three_digits(value * 100.0))
        }
        Quantity::PeakMemory => three_digits(value / 1e6),
        Quantity::Passes | Quantity::Lights => format!("{value}"),
        _ => three_digits(value),
    }
}

/// The table cell of a quantity. A stopped run is marked and excluded from the comparison.
pub(super) fn cell(quantity: Quantity, record: Option<&Record>) -> TableCell {
    let Some(record) = record else {
        return TableCell::default();
    };
    match (record.status, value(quantity, record)) {
        (RunStatus::Failed, _) => TableCell::plain("failed"),
        (RunStatus::Unavailable, _) => TableCell::plain("unavailable"),
        (RunStatus::Stopped, None) => TableCell::plain("†"),
        (RunStatus::Stopped, Some(value)) => {
            TableCell::plain(format!("{} †", text(quantity, value, record)))
        }
        (RunStatus::Done, None) => TableCell::default(),
        (RunStatus::Done, Some(value)) => TableCell {
            text: text(quantity, value, record),
            rank: rank(quantity, value),
        },
    }
}

/// A squared error minus the expected contribution of the noise of the reference, at least 0.
fn error_without_reference_noise(record: &Record, name: &str) -> Option<f64> {
    let of_reference = record.metric(&format!("/reference_noise/{name}"));
    let all = record.metric(&format!("/{name}"))?;
    Some((all - of_reference.unwrap_or(0.0)).max(0.0))
}

/// The ratio of means with the largest deviation from 1, with its standard error if it is known.
fn worst_ratio(record: &Record) -> Option<(f64, Option<f64>)> {
    let ratios = (0..3).filter_map(|c| {
        let ratio = record.metric(&format!("/ratio_of_means/{c}"))?;
        Some((ratio, record.metric(&format!("/ratio_standard_error/{c}"))))
    });
    ratios.max_by(|a, b| (a.0 - 1.0).abs().total_cmp(&(b.0 - 1.0).abs()))
}
