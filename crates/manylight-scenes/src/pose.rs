//! Where an object stands.

use glam::{DAffine3, DMat3, DVec3};

/// Scale, then rotations about z, x and y in this order, then a translation. Angles in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Factor along each axis.
    pub scale: DVec3,
    /// Rotation about z.
    pub roll: f64,
    /// Rotation about x, after `roll`.
    pub tilt: f64,
    /// Rotation about y, after `tilt`.
    pub turn: f64,
    /// Translation, last.
    pub position: DVec3,
}

impl Pose {
    /// Upright at a point.
    pub fn at(x: f64, y: f64, z: f64) -> Pose {
        Pose {
            scale: DVec3::ONE,
            roll: 0.0,
            tilt: 0.0,
            turn: 0.0,
            position: DVec3::new(x, y, z),
        }
    }

    /// As modelled.
    pub fn identity() -> Pose {
        Pose::at(0.0, 0.0, 0.0)
    }

    /// With the rotation about z.
    pub fn rolled(self, roll: f64) -> Pose {
        Pose { roll, ..self }
    }

    /// With the rotation about x.
    pub fn tilted(self, tilt: f64) -> Pose {
        Pose { tilt, ..self }
    }

    /// With the rotation about y.
    pub fn turned(self, turn: f64) -> Pose {
        Pose { turn, ..self }
    }

    /// With one factor for all axes.
    pub fn scaled(self, factor: f64) -> Pose {
        self.stretched(factor, factor, factor)
    }

    /// With a factor for each axis.
    pub fn stretched(self, x: f64, y: f64, z: f64) -> Pose {
        Pose {
            scale: DVec3::new(x, y, z),
            ..self
        }
    }

    /// From the object's space to that of the scene.
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
    fn order_of_rotations() {
        let pose = Pose::at(0.0, 0.0, 5.0)
            .rolled(90.0)
            .tilted(90.0)
            .scaled(2.0);
        let moved = pose.matrix().transform_point3(DVec3::X);
        assert!(moved.distance(DVec3::new(0.0, 0.0, 7.0)) < 1e-12);
    }
}
