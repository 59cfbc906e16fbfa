//! Cameras that move from key frame to key frame.

use glam::{DMat4, DQuat, DVec3};
use manylight::math::Affine3A;

/// Most frames of a camera: a bound of the work that a file from a stranger can ask for.
const MAX_FRAMES: f64 = 1e6;

/// The transform from an object to the world at a time in s.
pub(super) type KeyFrame = (f64, DMat4);

/// The transforms at `fps` frames per second, from the first of `keys` to the last one. Positions and
/// scales between two keys change linearly, orientations along the shortest arc.
///
/// # Errors
/// What is wrong with the keys: there are fewer than two, their times do not ascend, or they last too
/// long.
pub(super) fn frames(keys: &[KeyFrame], fps: f32) -> Result<Vec<Affine3A>, String> {
    let ([(first, _), .., (last, _)], fps) = (keys, f64::from(fps)) else {
        return Err(format!(
            "found {} key frames, expected two or more",
            keys.len()
        ));
    };
    if !keys.is_sorted_by(|a, b| a.0 < b.0) {
        return Err("expected the times of key frames in ascending order".into());
    }
    // A rounding of the times must not cost the last frame.
    let steps = ((last - first) * fps + 1e-3).floor();
    if steps >= MAX_FRAMES {
        return Err(format!(
            "found {:.0} frames at {fps} per second, expected at most {MAX_FRAMES:.0}",
            steps + 1.0
        ));
    }
    let frame = |index: u32| at(keys, first + f64::from(index) / fps);
    let frames = (0..=steps as u32).map(frame);
    Ok(frames.map(|m| Affine3A::from_mat4(m.as_mat4())).collect())
}

/// The transform at `time`.
fn at(keys: &[KeyFrame], time: f64) -> DMat4 {
    let next = keys.partition_point(|key| key.0 <= time);
    let (before, after) = (next.saturating_sub(1), next.min(keys.len() - 1));
    let ((t0, a), (t1, b)) = (keys[before], keys[after]);
    if before == after {
        return a;
    }
    let u = (time - t0) / (t1 - t0);
    let (a, b) = (Parts::of(a), Parts::of(b));
    DMat4::from_scale_rotation_translation(
        a.scale.lerp(b.scale, u),
        a.rotation.slerp(b.rotation, u),
        a.translation.lerp(b.translation, u),
    )
}

/// A transform without shear.
struct Parts {
    scale: DVec3,
    rotation: DQuat,
    translation: DVec3,
}

impl Parts {
    fn of(matrix: DMat4) -> Self {
        let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
        Parts {
            scale,
            rotation,
            translation,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use manylight::math::Vec3;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn frames_lie_between_the_keys() {
        let turned = DMat4::from_translation(DVec3::X * 2.0) * DMat4::from_rotation_y(FRAC_PI_2);
        let keys = [(1.0, DMat4::IDENTITY), (2.0, turned), (2.5, turned)];
        let frames = frames(&keys, 4.0).unwrap();
        assert_eq!(frames.len(), 7);
        let (middle, sine) = (&frames[2], std::f32::consts::FRAC_1_SQRT_2);
        assert!((Vec3::from(middle.translation) - Vec3::X).length() < 1e-6);
        let forward = middle.transform_vector3(Vec3::Z);
        assert!(
            (forward - Vec3::new(sine, 0.0, sine)).length() < 1e-6,
            "{forward}"
        );
        assert!(
            frames[4..]
                .iter()
                .all(|frame| frame.abs_diff_eq(frames[4], 1e-6))
        );
    }

    #[test]
    fn mirrored_cameras_stay_mirrored() {
        let mirror = DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let keys = [(0.0, mirror), (1.0, DMat4::from_rotation_y(1.0) * mirror)];
        for frame in frames(&keys, 8.0).unwrap() {
            assert!((frame.matrix3.determinant() + 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn wrong_keys_are_refused() {
        let key = |time| (time, DMat4::IDENTITY);
        assert!(frames(&[], 24.0).is_err());
        assert!(frames(&[key(0.0)], 24.0).is_err());
        assert!(frames(&[key(1.0), key(0.0)], 24.0).is_err());
        assert!(frames(&[key(0.0), key(f64::NAN)], 24.0).is_err());
        assert!(
            frames(&[key(0.0), key(1e9)], 24.0)
                .unwrap_err()
                .contains("at most 1000000")
        );
    }
}
