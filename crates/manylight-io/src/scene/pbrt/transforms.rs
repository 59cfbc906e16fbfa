//! Transforms of PBRT: matrices of points as columns, in double precision.

use glam::{DMat4, DVec3};

/// The matrix of 16 numbers, which PBRT writes column by column.
pub(super) fn matrix(numbers: &[f64]) -> DMat4 {
    let columns = numbers.first_chunk::<16>();
    columns.map_or(DMat4::IDENTITY, DMat4::from_cols_array)
}

/// The rotation by the angle in degrees around the axis in `[angle, x, y, z]`.
pub(super) fn rotation(numbers: &[f64]) -> DMat4 {
    let axis = DVec3::from_slice(&numbers[1..]);
    DMat4::from_axis_angle(axis.normalize_or(DVec3::Z), numbers[0].to_radians())
}

/// The transform from the world to a camera with +z towards the target, +y up and +x to the right,
/// in a left-handed frame. `None` if the three vectors do not span a frame.
pub(super) fn look_at(numbers: &[f64]) -> Option<DMat4> {
    let [eye, target, up] = [0, 3, 6].map(|i| DVec3::from_slice(&numbers[i..]));
    let forward = (target - eye).try_normalize()?;
    let right = up.try_normalize()?.cross(forward).try_normalize()?;
    let up = forward.cross(right);
    let world_from_camera = DMat4::from_cols(
        right.extend(0.0),
        up.extend(0.0),
        forward.extend(0.0),
        eye.extend(1.0),
    );
    Some(world_from_camera.inverse())
}

/// Whether the transform turns a right-handed frame into a left-handed one.
pub(super) fn mirrors(matrix: DMat4) -> bool {
    matrix.determinant() < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_look_along_z_with_x_to_the_right() {
        let camera = look_at(&[0.0, 0.0, -5.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]).unwrap();
        let p = camera.transform_point3(DVec3::new(1.0, 2.0, 0.0));
        assert!(p.abs_diff_eq(DVec3::new(1.0, 2.0, 5.0), 1e-12), "{p}");
        assert!(look_at(&[0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0]).is_none());
    }

    #[test]
    fn rotations_turn_x_to_y() {
        let p = rotation(&[90.0, 0.0, 0.0, 2.0]).transform_point3(DVec3::X);
        assert!(p.abs_diff_eq(DVec3::Y, 1e-12));
        assert!(
            !mirrors(DMat4::IDENTITY) && mirrors(DMat4::from_scale(DVec3::new(1.0, -1.0, 1.0)))
        );
    }
}
