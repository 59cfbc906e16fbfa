//! Small numeric helpers.

/// `sqrt(max(x, 0))`: for values that are negative by rounding alone.
#[inline]
pub fn safe_sqrt(x: f32) -> f32 {
    x.max(0.0).sqrt()
}

/// Real roots of `a t² + b t + c = 0`, the smaller first; `None` without real roots.
/// Works in `f64`, so that spheres far from the origin keep their precision.
pub fn quadratic_roots(a: f64, b: f64, c: f64) -> Option<(f64, f64)> {
    if a == 0.0 {
        return (b != 0.0).then(|| (-c / b, -c / b));
    }
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return None;
    }
    // The sum of equal signs avoids cancellation; the other root follows from the product c/a.
    let q = -0.5 * (b + discriminant.sqrt().copysign(b));
    let (t0, t1) = (q / a, if q == 0.0 { 0.0 } else { c / q });
    Some(if t0 <= t1 { (t0, t1) } else { (t1, t0) })
}

/// Index of the last element of the sorted list `cdf` that is `<= u`; `cdf[0]` must be 0.
#[inline]
pub fn find_interval(cdf: &[f32], u: f32) -> usize {
    cdf.partition_point(|&c| c <= u).saturating_sub(1)
}
