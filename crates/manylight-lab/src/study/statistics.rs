//! Slopes of convergence, and means of ratios.

/// Slope of ln y over ln x by least squares: the exponent of a power law through the points (x, y).
/// `None` with fewer than two different x, or if a value is not positive.
pub(super) fn log_log_slope(points: &[(f64, f64)]) -> Option<f64> {
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let count = logs.len() as f64;
    let mean_x = logs.iter().map(|p| p.0).sum::<f64>() / count;
    let mean_y = logs.iter().map(|p| p.1).sum::<f64>() / count;
    let covariance: f64 = logs.iter().map(|p| (p.0 - mean_x) * (p.1 - mean_y)).sum();
    let variance: f64 = logs.iter().map(|p| (p.0 - mean_x).powi(2)).sum();
    let slope = covariance / variance;
    slope.is_finite().then_some(slope)
}

/// Geometric mean: inverting all ratios inverts their mean. `None` without values.
pub(super) fn geometric_mean(values: &[f64]) -> Option<f64> {
    let sum: f64 = values.iter().map(|v| v.ln()).sum();
    let mean = (sum / values.len() as f64).exp();
    mean.is_finite().then_some(mean)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes() {
        let power = |x: f64| (x, 3.0 * x.powf(-0.5));
        let slope = log_log_slope(&[power(8.0), power(16.0), power(64.0)]).unwrap();
        assert!((slope + 0.5).abs() < 1e-12, "{slope}");
        // ln y over ln x in units of ln 2: (0, 0), (1, -1), (2, -1) has slope -1/2.
        let slope = log_log_slope(&[(1.0, 1.0), (2.0, 0.5), (4.0, 0.5)]).unwrap();
        assert!((slope + 0.5).abs() < 1e-12, "{slope}");
        assert_eq!(log_log_slope(&[(1.0, 1.0)]), None);
        assert_eq!(log_log_slope(&[(2.0, 1.0), (2.0, 3.0)]), None);
        assert_eq!(log_log_slope(&[(1.0, 0.0), (2.0, 3.0)]), None);
        assert_eq!(log_log_slope(&[]), None);
    }

    #[test]
    fn means_of_ratios() {
        let mean = geometric_mean(&[0.5, 2.0, 8.0]).unwrap();
        assert!((mean - 2.0).abs() < 1e-12);
        assert_eq!(geometric_mean(&[]), None);
        assert_eq!(geometric_mean(&[0.0]), Some(0.0));
    }
}
