//! Terms of the principled model.

use crate::lanes::{Float, Width};

/// Schlick's weight (1 - cos)⁵.
#[inline(always)]
pub(super) fn schlick_weight<S: Width>(cos: Float<S>) -> Float<S> {
    let x = (1.0 - cos).clamp(0.0, 1.0);
    let x2 = x * x;
    x2 * x2 * x
}

/// Burley's GTR1 distribution of facet normals; `excess` is `α² - 1`, `norm` is
/// `(α² - 1) / (π ln α²)`.
#[inline(always)]
pub(super) fn gtr1<S: Width>(excess: Float<S>, norm: Float<S>, cos_m: Float<S>) -> Float<S> {
    let density = norm / (1.0 + excess * cos_m * cos_m);
    (density * cos_m).gt(1e-20).select(density, 0.0)
}

/// Smith's masking function of an isotropic GGX surface of roughness `alpha`.
#[inline(always)]
pub(super) fn ggx_masking<S: Width>(cos: Float<S>, alpha: f32) -> Float<S> {
    let cos2 = cos * cos;
    let tan2 = (1.0 - cos2) / cos2;
    2.0 / (1.0 + (1.0 + alpha * alpha * tan2).sqrt())
}
