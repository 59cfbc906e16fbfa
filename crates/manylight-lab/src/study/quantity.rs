//! The quantities that a page lists: names and headings.

use serde::Deserialize;

/// A measured quantity that a table of the page lists; plans call it a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// Mean relative squared error.
    Relmse,
    /// Square root of relMSE; the error of an unbiased method decreases as n^(-1/2) with n samples.
    RootRelmse,
    /// The relMSE of the means of 8x8 blocks.
    BlockRelmse,
    /// Mean squared error.
    Mse,
    /// Square root of the MSE.
    Rmse,
    /// Mean symmetric relative error.
    Smape,
    /// Structural similarity.
    Ssim,
    /// Mean of HDR-FLIP.
    Flip,
    /// Mean of the image over the mean of the reference, in the channel with the largest deviation
    /// from 1.
    RatioOfMeans,
    /// Fraction of 8x8 blocks with |z| > 3.
    #[serde(rename = "blocks-beyond-3")]
    BlocksBeyond3,
    /// Rendering time in seconds.
    Seconds,
    /// Time of each stage of the render in seconds.
    Stages,
    /// Number of complete passes.
    Passes,
    /// Number of virtual lights.
    Lights,
    /// Peak memory of the process.
    PeakMemory,
    /// Memory per virtual light.
    BytesPerLight,
    /// Clamped fraction of the energy of the virtual lights.
    ClampedShare,
}

/// The quantities of a task that lists none.
pub(super) const DEFAULT_QUANTITIES: &[Quantity] = &[
    Quantity::Relmse,
    Quantity::RatioOfMeans,
    Quantity::Seconds,
    Quantity::Stages,
    Quantity::PeakMemory,
    Quantity::BytesPerLight,
    Quantity::ClampedShare,
];

impl Quantity {
    /// Name in plan files.
    pub fn name(self) -> &'static str {
        match self {
            Quantity::Relmse => "relmse",
            Quantity::RootRelmse => "root-relmse",
            Quantity::BlockRelmse => "block-relmse",
            Quantity::Mse => "mse",
            Quantity::Rmse => "rmse",
            Quantity::Smape => "smape",
            Quantity::Ssim => "ssim",
            Quantity::Flip => "flip",
            Quantity::RatioOfMeans => "ratio-of-means",
            Quantity::BlocksBeyond3 => "blocks-beyond-3",
            Quantity::Seconds => "seconds",
            Quantity::Stages => "stages",
            Quantity::Passes => "passes",
            Quantity::Lights => "lights",
            Quantity::PeakMemory => "peak-memory",
            Quantity::BytesPerLight => "bytes-per-light",
            Quantity::ClampedShare => "clamped-share",
        }
    }

    /// Heading of its table.
    pub(super) fn title(self) -> &'static str {
        match self {
            Quantity::Relmse => "relMSE",
            Quantity::RootRelmse => "Root of relMSE",
            Quantity::BlockRelmse => "relMSE of blocks",
            Quantity::Mse => "MSE",
            Quantity::Rmse => "RMSE",
            Quantity::Smape => "SMAPE",
            Quantity::Ssim => "SSIM",
            Quantity::Flip => "HDR-FLIP",
            Quantity::RatioOfMeans => "Ratio of means",
            Quantity::BlocksBeyond3 => "Blocks beyond 3 standard deviations",
            Quantity::Seconds => "Seconds",
            Quantity::Stages => "Seconds per stage",
            Quantity::Passes => "Passes",
            Quantity::Lights => "Virtual lights",
            Quantity::PeakMemory => "Peak memory (MB)",
            Quantity::BytesPerLight => "Bytes per light",
            Quantity::ClampedShare => "Clamped fraction",
        }
    }

    /// Definition below the heading; may be empty.
    pub(super) fn remark(self) -> &'static str {
        match self {
            Quantity::RatioOfMeans => {
                "Mean of the image over mean of the reference, in the channel with the largest deviation from 1, ± standard error."
            }
            Quantity::BlockRelmse => {
                "Of the means of blocks of 8x8 pixels: the error that neighbors share."
            }
            Quantity::BlocksBeyond3 => "Fraction of the blocks of 8x8 pixels with |z| > 3.",
            Quantity::Seconds => {
                "Rendering alone, without loading the scene and writing the image."
            }
            Quantity::Passes | Quantity::Lights => "Total over the render.",
            Quantity::ClampedShare => "Before visibility and bias compensation.",
            _ => "",
        }
    }

    /// Whether a run has a single number for it.
    pub fn is_scalar(self) -> bool {
        self != Quantity::Stages
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_plans() {
        for quantity in DEFAULT_QUANTITIES.iter().chain(&[
            Quantity::RootRelmse,
            Quantity::BlockRelmse,
            Quantity::Mse,
            Quantity::Rmse,
            Quantity::Smape,
            Quantity::Ssim,
            Quantity::Flip,
            Quantity::BlocksBeyond3,
            Quantity::Passes,
            Quantity::Lights,
        ]) {
            let read: Quantity = serde_json::from_value(quantity.name().into()).unwrap();
            assert_eq!(read, *quantity);
        }
    }
}
