//! Comparisons as a plain text table.

use super::comparison::Comparison;

/// Plain text table of comparisons: one row per measure and one column per image, below the name of
/// the reference. The text has no final line end.
pub fn table(reference: &str, comparisons: &[Comparison]) -> String {
    let mut rows: Vec<Vec<String>> = vec![header(comparisons)];
    for measures in [ERROR_ROWS, MEAN_ROWS, NOISE_ROWS, EMITTER_ROWS] {
        rows.extend(measures.iter().filter_map(|row| row.cells(comparisons)));
    }
    format!("reference: {reference}\n{}", aligned(&rows))
}

/// One measure of all images.
struct TableRow {
    label: &'static str,
    cell: fn(&Comparison) -> Option<String>,
}

impl TableRow {
    const fn new(label: &'static str, cell: fn(&Comparison) -> Option<String>) -> Self {
        TableRow { label, cell }
    }

    /// The label and one cell per image; `None` if no image has a value.
    fn cells(&self, comparisons: &[Comparison]) -> Option<Vec<String>> {
        let cells: Vec<_> = comparisons.iter().map(self.cell).collect();
        cells.iter().any(Option::is_some).then(|| {
            let texts = cells
                .into_iter()
                .map(|cell| cell.unwrap_or_else(|| "-".into()));
            std::iter::once(self.label.to_string())
                .chain(texts)
                .collect()
        })
    }
}

const ERROR_ROWS: &[TableRow] = &[
    TableRow::new("MSE", |c| Some(number(c.errors.mse))),
    TableRow::new("relMSE", |c| Some(number(c.errors.relmse))),
    TableRow::new("  of 8x8 blocks", |c| Some(number(c.errors.block_relmse))),
    TableRow::new("MAPE", |c| Some(number(c.errors.mape))),
    TableRow::new("SMAPE", |c| Some(number(c.errors.smape))),
    TableRow::new("PSNR (dB)", |c| {
        Some(c.errors.psnr.map_or("inf".into(), |v| format!("{v:.2}")))
    }),
    TableRow::new("SSIM", |c| c.ssim.map(number)),
    TableRow::new("HDR-FLIP", |c| Some(number(c.flip))),
    TableRow::new("pixels 50, 99, 99.9 %", |c| {
        let q = c.errors.pixel_error;
        Some([q.median, q.p99, q.p99_9].map(number).join(" "))
    }),
];

const MEAN_ROWS: &[TableRow] = &[
    TableRow::new("mean RGB", |c| Some(triple(c.means.mean.map(Some)))),
    TableRow::new("reference mean RGB", |c| {
        Some(triple(c.means.reference_mean.map(Some)))
    }),
    TableRow::new("ratio of means RGB", |c| {
        Some(triple(c.means.ratio_of_means))
    }),
    TableRow::new("  standard error", |c| known(c.means.ratio_standard_error)),
];

const NOISE_ROWS: &[TableRow] = &[
    TableRow::new("noise MSE", |c| Some(number(c.noise_floor?.mse))),
    TableRow::new("noise relMSE", |c| Some(number(c.noise_floor?.relmse))),
    TableRow::new("  of the reference", |c| {
        Some(number(c.reference_noise?.relmse))
    }),
    TableRow::new("blocks |z| > 3", |c| {
        Some(percent(c.blocks?.share_beyond_3))
    }),
    TableRow::new("blocks z mean", |c| Some(format!("{:.3}", c.blocks?.mean))),
    TableRow::new("blocks z rms", |c| Some(format!("{:.3}", c.blocks?.rms))),
    TableRow::new("within error bars", |c| {
        Some(percent(c.within_bars?.pixels))
    }),
    TableRow::new("  of 8x8 blocks", |c| Some(percent(c.within_bars?.blocks))),
];

const EMITTER_ROWS: &[TableRow] = &[
    TableRow::new("without emitters", |c| {
        Some(format!("{} pixels", c.without_emitters.as_ref()?.pixels))
    }),
    TableRow::new("  relMSE", |c| {
        Some(number(c.without_emitters.as_ref()?.errors.relmse))
    }),
    TableRow::new("  ratio of means RGB", |c| {
        Some(triple(c.without_emitters.as_ref()?.means.ratio_of_means))
    }),
    TableRow::new("    standard error", |c| {
        known(c.without_emitters.as_ref()?.means.ratio_standard_error)
    }),
    TableRow::new("  blocks |z| > 3", |c| {
        Some(percent(c.without_emitters.as_ref()?.blocks?.share_beyond_3))
    }),
    TableRow::new("non-finite pixels", |c| {
        (c.non_finite_pixels > 0).then(|| c.non_finite_pixels.to_string())
    }),
];

fn header(comparisons: &[Comparison]) -> Vec<String> {
    let images = comparisons.iter().map(|c| c.image.clone());
    std::iter::once(String::new()).chain(images).collect()
}

fn number(value: f64) -> String {
    let plain = value == 0.0 || (1e-3..1e5).contains(&value.abs());
    if plain {
        format!("{value:.6}")
    } else {
        format!("{value:.4e}")
    }
}

fn percent(share: f64) -> String {
    format!("{:.2} %", share * 100.0)
}

fn triple(values: [Option<f64>; 3]) -> String {
    values
        .map(|v| v.map_or("-".into(), |v| format!("{v:.5}")))
        .join(" ")
}

fn known(values: [Option<f64>; 3]) -> Option<String> {
    values.iter().any(Option::is_some).then(|| triple(values))
}

fn aligned(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |c: usize| {
        rows.iter()
            .filter_map(|row| row.get(c))
            .map(|s| s.chars().count())
            .max()
    };
    let widths: Vec<usize> = (0..columns).map(|c| width(c).unwrap_or(0)).collect();
    let line = |row: &Vec<String>| {
        let cells = row
            .iter()
            .zip(&widths)
            .map(|(cell, &width)| format!("{cell:<width$}"));
        cells.collect::<Vec<_>>().join("  ").trim_end().to_string()
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::super::{ComparisonImage, compare};
    use super::*;

    fn frame(value: f32) -> ComparisonImage {
        ComparisonImage {
            variance: Some(vec![[0.01; 3]; 64]),
            ..ComparisonImage::from_rgb(8, 8, vec![[value; 3]; 64])
        }
    }

    #[test]
    fn every_known_measure_has_a_row() {
        let text = table("r.exr", &[compare("a.exr", &frame(1.1), &frame(1.0))]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!((lines[0], lines[1].trim()), ("reference: r.exr", "a.exr"));
        let row = |label: &str| lines.iter().find(|line| line.starts_with(label)).copied();
        assert!(
            row("ratio of means RGB")
                .unwrap()
                .ends_with("1.10000 1.10000 1.10000")
        );
        assert!(row("blocks |z| > 3").unwrap().ends_with("100.00 %"));
        assert!(row("MSE").unwrap().ends_with("0.010000"));
        assert_eq!(row("without emitters"), None);
    }
}
