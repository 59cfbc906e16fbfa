//! Curves as lists of points, and interpolated tables.

use glam::{DVec2, DVec3};

/// A Catmull-Rom spline through `points`, with `steps` segments between neighbours.
pub fn catmull_rom(points: &[DVec3], steps: usize) -> Vec<DVec3> {
    let last = points.len() - 1;
    let mut curve = Vec::with_capacity(last * steps + 1);
    for i in 0..last {
        let before = points[i.saturating_sub(1)];
        let (from, to) = (points[i], points[i + 1]);
        let after = points[(i + 2).min(last)];
        let (out, into) = ((to - before) / 2.0, (after - from) / 2.0);
        curve.extend((0..steps).map(|s| hermite(from, out, to, into, s as f64 / steps as f64)));
    }
    curve.push(points[last]);
    curve
}

/// Cubic Hermite interpolation at `t` in [0, 1]; `out` and `into` are the tangents at the ends.
fn hermite(from: DVec3, out: DVec3, to: DVec3, into: DVec3, t: f64) -> DVec3 {
    let (t2, t3) = (t * t, t * t * t);
    from * (2.0 * t3 - 3.0 * t2 + 1.0)
        + out * (t3 - 2.0 * t2 + t)
        + to * (3.0 * t2 - 2.0 * t3)
        + into * (t3 - t2)
}

/// Points of a circular arc, `segments` + 1 with both ends. Angles are in degrees from the first
/// axis.
pub fn arc(center: DVec2, radius: f64, from: f64, to: f64, segments: usize) -> Vec<DVec2> {
    (0..=segments)
        .map(|i| {
            let angle = (from + (to - from) * i as f64 / segments as f64).to_radians();
            center + radius * DVec2::from_angle(angle)
        })
        .collect()
}

/// Monotone cubic interpolation at `x` of a table of (x, value) with rising x. Constant outside the
/// table.
///
/// Source: Fritsch and Butland, "A Method for Constructing Local Monotone Piecewise Cubic
/// Interpolants", 1984.
pub fn smooth_table(table: &[(f64, f64)], x: f64) -> f64 {
    let (i, t) = table_interval(table, x);
    let next = (i + 1).min(table.len() - 1);
    let width = table[next].0 - table[i].0;
    let (from, to) = (table[i].1, table[next].1);
    let (out, into) = (
        table_slope(table, i) * width,
        table_slope(table, next) * width,
    );
    let (t2, t3) = (t * t, t * t * t);
    from * (2.0 * t3 - 3.0 * t2 + 1.0)
        + out * (t3 - 2.0 * t2 + t)
        + to * (3.0 * t2 - 2.0 * t3)
        + into * (t3 - t2)
}

/// The index of the entry before `x`, and the position of x between it and the next entry, in [0,
/// 1).
fn table_interval(table: &[(f64, f64)], x: f64) -> (usize, f64) {
    let after = table.partition_point(|entry| entry.0 <= x);
    if after == 0 || after == table.len() {
        return (after.saturating_sub(1), 0.0);
    }
    let (from, to) = (table[after - 1].0, table[after].0);
    (after - 1, (x - from) / (to - from))
}

/// Slope at an entry: the harmonic mean of the two adjacent secants; zero at extrema and at the
/// ends.
fn table_slope(table: &[(f64, f64)], i: usize) -> f64 {
    if i == 0 || i + 1 == table.len() {
        return 0.0;
    }
    let secant = |a: usize| (table[a + 1].1 - table[a].1) / (table[a + 1].0 - table[a].0);
    let (left, right) = (secant(i - 1), secant(i));
    if left * right <= 0.0 {
        0.0
    } else {
        2.0 * left * right / (left + right)
    }
}
