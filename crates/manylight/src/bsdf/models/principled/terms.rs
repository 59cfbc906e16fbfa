//! Terms of the principled model.

/// Schlick's weight (1 - cos)⁵.
#[inline(always)]
pub(super) fn schlick_weight(cos: f32) -> f32 {
    let x = (1.0 - cos).clamp(0.0, 1.0);
    let x2 = x * x;
    x2 * x2 * x
}

/// Burley's GTR1 distribution of facet normals; `excess` is `α² - 1`, `norm` is `(α² - 1) / (π ln α²)`.
#[inline(always)]
pub(super) fn gtr1(excess: f32, norm: f32, cos_m: f32) -> f32 {
    let density = norm / (1.0 + excess * cos_m * cos_m);
    if density * cos_m > 1e-20 {
        density
    } else {
        0.0
    }
}

/// Smith's masking function of an isotropic GGX surface of roughness `alpha`.
#[inline(always)]
pub(super) fn ggx_masking(cos: f32, alpha: f32) -> f32 {
    let tan2 = (1.0 - cos * cos) / (cos * cos);
    2.0 / (1.0 + (1.0 + alpha * alpha * tan2).sqrt())
}
