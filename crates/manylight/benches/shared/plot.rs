//! Line plots with two logarithmic axes, as SVG files.

use plotters::prelude::*;
use std::error::Error;
use std::path::Path;

/// One line of a plot.
pub(crate) struct PlotLine {
    /// Name in the legend.
    pub(crate) name: String,
    /// (x, y), x increasing, both positive.
    pub(crate) points: Vec<(f64, f64)>,
}

/// Lower limit of the y axis; smaller values are drawn at the bottom edge.
const MIN_Y: f64 = 1e-3;

/// Writes the plot to `file` with the axis titles `x` and `y`.
pub(crate) fn draw(
    file: &Path,
    x: &str,
    y: &str,
    lines: &[PlotLine],
) -> Result<(), Box<dyn Error>> {
    let area = SVGBackend::new(&file, (640, 420)).into_drawing_area();
    area.fill(&WHITE)?;
    let points = || lines.iter().flat_map(|line| &line.points);
    let first = points().fold(f64::INFINITY, |least, p| least.min(p.0));
    let last = points().fold(0.0, |most: f64, p| most.max(p.0));
    let least = points().fold(f64::INFINITY, |least, p| least.min(p.1));
    let least = least.max(MIN_Y);
    let most = points().fold(least, |most, p| most.max(p.1));
    // Space for the legend on the right.
    let right = last * (last / first).powf(0.4);
    let mut chart = ChartBuilder::on(&area)
        .margin(12)
        .x_label_area_size(36)
        .y_label_area_size(56)
        .build_cartesian_2d(
            (0.8 * first..right).log_scale(),
            (0.7 * least..1.5 * most).log_scale(),
        )?;
    chart
        .configure_mesh()
        .x_labels(4)
        .max_light_lines(1)
        .x_label_formatter(&|x| format!("{x}"))
        .x_desc(x)
        .y_desc(y)
        .draw()?;
    for (i, line) in lines.iter().enumerate() {
        let color = Palette99::pick(i).to_rgba();
        let points = line.points.iter().map(|p| (p.0, p.1.max(0.7 * least)));
        chart
            .draw_series(LineSeries::new(points, color.stroke_width(2)).point_size(3))?
            .label(&line.name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], color.stroke_width(2)));
    }
    chart
        .configure_series_labels()
        .background_style(WHITE.mix(0.8))
        .position(SeriesLabelPosition::LowerRight)
        .draw()?;
    area.present()?;
    Ok(())
}
