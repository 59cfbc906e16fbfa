//! Comparisons for people: the reference, then one row per figure and one column per image.

use super::Comparison;

/// The table, without a final line end.
pub(crate) fn table(reference: &str, comparisons: &[Comparison]) -> String {
    let mut rows: Vec<Vec<String>> = vec![header(comparisons)];
    let mut row = |label: &str, cell: &dyn Fn(&Comparison) -> Option<String>| {
        let cells: Vec<_> = comparisons.iter().map(cell).collect();
        if cells.iter().any(Option::is_some) {
            let cells = cells
                .into_iter()
                .map(|cell| cell.unwrap_or_else(|| "-".into()));
            rows.push(std::iter::once(label.to_string()).chain(cells).collect());
        }
    };
    row("MSE", &|c| Some(figure(c.errors.mse)));
    row("relMSE", &|c| Some(figure(c.errors.relmse)));
    row("MAPE", &|c| Some(figure(c.errors.mape)));
    row("SMAPE", &|c| Some(figure(c.errors.smape)));
    row("PSNR (dB)", &|c| {
        Some(c.errors.psnr.map_or("inf".into(), |v| format!("{v:.2}")))
    });
    row("SSIM", &|c| c.ssim.map(figure));
    row("HDR-FLIP", &|c| Some(figure(c.flip)));
    row("pixels 50, 99, 99.9 %", &|c| {
        let q = c.errors.pixel_error;
        Some([q.median, q.p99, q.p99_9].map(figure).join(" "))
    });
    row("mean RGB", &|c| Some(triple(c.means.mean.map(Some), 5)));
    row("reference mean RGB", &|c| {
        Some(triple(c.means.reference_mean.map(Some), 5))
    });
    row("ratio of means RGB", &|c| {
        Some(triple(c.means.ratio_of_means, 5))
    });
    row("  standard error", &|c| known(c.means.ratio_standard_error));
    row("noise MSE", &|c| c.noise_floor.map(|n| figure(n.mse)));
    row("noise relMSE", &|c| c.noise_floor.map(|n| figure(n.relmse)));
    row("  of the reference", &|c| {
        c.reference_noise.map(|n| figure(n.relmse))
    });
    row("blocks |z| > 3", &|c| {
        c.blocks.map(|b| percent(b.share_beyond_3))
    });
    row("blocks z mean", &|c| {
        c.blocks.map(|b| format!("{:.3}", b.mean))
    });
    row("blocks z rms", &|c| {
        c.blocks.map(|b| format!("{:.3}", b.rms))
    });
    row("without emitters", &|c| {
        c.without_emitters
            .as_ref()
            .map(|w| format!("{} pixels", w.pixels))
    });
    row("  relMSE", &|c| {
        c.without_emitters.as_ref().map(|w| figure(w.errors.relmse))
    });
    row("  ratio of means RGB", &|c| {
        c.without_emitters
            .as_ref()
            .map(|w| triple(w.means.ratio_of_means, 5))
    });
    row("    standard error", &|c| {
        c.without_emitters
            .as_ref()
            .and_then(|w| known(w.means.ratio_standard_error))
    });
    row("  blocks |z| > 3", &|c| {
        c.without_emitters
            .as_ref()
            .and_then(|w| w.blocks)
            .map(|b| percent(b.share_beyond_3))
    });
    row("non-finite pixels", &|c| {
        (c.non_finite_pixels > 0).then(|| c.non_finite_pixels.to_string())
    });
    format!("reference: {reference}\n{}", aligned(&rows))
}

fn header(comparisons: &[Comparison]) -> Vec<String> {
    let images = comparisons.iter().map(|c| c.image.clone());
    std::iter::once(String::new()).chain(images).collect()
}

fn figure(value: f64) -> String {
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

fn triple(values: [Option<f64>; 3], digits: usize) -> String {
    values
        .map(|v| v.map_or("-".into(), |v| format!("{v:.digits$}")))
        .join(" ")
}

fn known(values: [Option<f64>; 3]) -> Option<String> {
    values
        .iter()
        .any(Option::is_some)
        .then(|| triple(values, 5))
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
    use super::super::frame::Correlation;
    use super::super::{Frame, compare};
    use super::*;

    fn frame(value: f32) -> Frame {
        Frame {
            width: 8,
            height: 8,
            rgb: vec![[value; 3]; 64],
            variance: Some(vec![[0.01; 3]; 64]),
            correlation: Correlation::None,
            emission: None,
        }
    }

    #[test]
    fn every_known_figure_has_a_row() {
        let text = table(
            "r.exr",
            &[compare("a.exr".into(), &frame(1.1), &frame(1.0))],
        );
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
