//! Transforms from object space to the scene.

use glam::{DAffine3, DMat3, DVec3};

/// A scale, then rotations about z, x and y, then a translation. Angles are in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Scale along each axis.
    pub scale: DVec3,
    /// Angle of the first rotation, about z.
    pub roll: f64,
    /// Angle of the second rotation, about x.
    pub tilt: f64,
    /// Angle of the third rotation, about y.
    pub turn: f64,
    /// Translation.
    pub position: DVec3,
}

impl Pose {
    /// A translation.
    pub fn at(x: f64, y: f64, z: f64) -> Pose {
        Pose {
            scale: DVec3::ONE,
            roll: 0.0,
            tilt: 0.0,
            turn: 0.0,
            position: DVec3::new(x, y, z),
        }
    }

    /// The identity transform.
    pub fn identity() -> Pose {
        Pose::at(0.0, 0.0, 0.0)
    }

    /// Sets the rotation about z.
    pub fn rolled(self, roll: f64) -> Pose {
        Pose { roll, ..self }
    }

    /// Sets the rotation about x.
    pub fn tilted(self, tilt: f64) -> Pose {
        Pose { tilt, ..self }
    }

    /// Sets the rotation about y.
    pub fn turned(self, turn: f64) -> Pose {
        Pose { turn, ..self }
    }

    /// Sets the same scale for all axes.
    pub fn scaled(self, factor: f64) -> Pose {
        self.stretched(factor, factor, factor)
    }

    /// Sets the scale along each axis.
    pub fn stretched(self, x: f64, y: f64, z: f64) -> Pose {
        Pose {
            scale: DVec3::new(x, y, z),
            ..self
        }
    }

    /// Moves the object up along the y axis of the scene.
    pub fn lifted(self, height: f64) -> Pose {
        Pose {
            position: self.position + DVec3::Y * height,
            ..self
        }
    }

    /// The transform from object space to the scene.
    pub fn matrix(&self) -> DAffine3 {
        let rotation = DMat3::from_rotation_y(self.turn.to_radians())
            * DMat3::from_rotation_x(self.tilt.to_radians())
            * DMat3::from_rotation_z(self.roll.to_radians());
        DAffine3::from_mat3_translation(rotation * DMat3::from_diagonal(self.scale), self.position)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_apply_in_order() {
        let pose = Pose::at(0.0, 0.0, 5.0)
            .rolled(90.0)
            .tilted(90.0)
            .scaled(2.0);
        let moved = pose.matrix().transform_point3(DVec3::X);
        assert!(moved.distance(DVec3::new(0.0, 0.0, 7.0)) < 1e-12);
    }
}
