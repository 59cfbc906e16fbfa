//! Transforms in the precision of the renderer.

use super::super::description;
use glam::{DMat3, DMat4, DVec3};
use manylight::math::{Affine3A, Mat3};

/// The affine part of a matrix.
pub(super) fn affine(matrix: DMat4) -> Affine3A {
    Affine3A::from_mat4(matrix.as_mat4())
}

/// The normalized axes of a transform.
pub(super) fn rotation(matrix: DMat4) -> Mat3 {
    description::rotation(Mat3::from_mat4(matrix.as_mat4()))
}

/// `matrix` after a rotation of z to `axis`, with the scale along `axis` set to the scale across
/// it.
pub(super) fn without_stretch(matrix: DMat4, axis: DVec3) -> DMat4 {
    let along = axis.normalize_or(DVec3::Z);
    let (a, b) = along.any_orthonormal_pair();
    let turned = matrix * DMat4::from_mat3(DMat3::from_cols(a, b, along));
    let z_axis = turned.z_axis.normalize_or_zero() * turned.x_axis.length();
    DMat4 { z_axis, ..turned }
}

/// The scale of a similarity, negative if it mirrors. `None` if `matrix` changes angles.
pub(super) fn similarity_scale(matrix: DMat4) -> Option<f64> {
    /// Relative tolerance; matrices in files have about seven digits.
    const TOLERANCE: f64 = 1e-5;
    let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.truncate());
    let scale_squared = axes[0].length_squared();
    let near = |a: f64, b: f64| (a - b).abs() <= TOLERANCE * scale_squared;
    let keeps = near(axes[1].length_squared(), scale_squared)
        && near(axes[2].length_squared(), scale_squared)
        && near(axes[0].dot(axes[1]), 0.0)
        && near(axes[1].dot(axes[2]), 0.0)
        && near(axes[2].dot(axes[0]), 0.0);
    keeps.then(|| scale_squared.sqrt() * matrix.determinant().signum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cylinders_may_be_stretched_along_their_axis_alone() {
        let keeps = |scale: DVec3, axis: DVec3| {
            let turned = DMat4::from_rotation_y(0.7) * DMat4::from_scale(scale);
            similarity_scale(without_stretch(turned, axis)).is_some()
        };
        let long = DVec3::new(0.4, 0.4, 1.1);
        assert!(keeps(long, DVec3::Z) && keeps(DVec3::splat(2.0), DVec3::ONE));
        assert!(!keeps(long, DVec3::X) && !keeps(long, DVec3::new(0.0, 1.0, 1.0)));
    }
}
