//! Bounding cones of directions.

use super::Vec3;

/// All unit directions within `half_angle` of `axis`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Unit axis.
    pub axis: Vec3,
    /// In radians, from 0 to π. Negative for the empty cone.
    pub half_angle: f32,
}

impl Cone {
    /// Holds no direction; the neutral element of [`Cone::union`].
    pub const EMPTY: Cone = Cone {
        axis: Vec3::Z,
        half_angle: -1.0,
    };
    /// Holds every direction.
    pub const FULL: Cone = Cone {
        axis: Vec3::Z,
        half_angle: std::f32::consts::PI,
    };

    /// The cone that holds `axis` alone.
    pub fn from_axis(axis: Vec3) -> Self {
        Cone {
            axis,
            half_angle: 0.0,
        }
    }

    /// Whether the cone holds no direction.
    pub fn is_empty(&self) -> bool {
        self.half_angle < 0.0
    }

    /// A small cone around both.
    ///
    /// Source: Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", 2018, algorithm 1.
    #[must_use]
    pub fn union(self, other: Cone) -> Self {
        if self.is_empty() {
            return other;
        }
        if other.is_empty() {
            return self;
        }
        let (wide, narrow) = if self.half_angle >= other.half_angle {
            (self, other)
        } else {
            (other, self)
        };
        let between = wide.angle_to_axis(narrow.axis);
        if between + narrow.half_angle <= wide.half_angle {
            return wide;
        }
        let half_angle = 0.5 * (wide.half_angle + between + narrow.half_angle);
        if half_angle >= std::f32::consts::PI {
            return Cone::FULL;
        }
        // Turn the wide axis towards the narrow one until the new cone touches the wide cone's far rim.
        let Some(side) = (narrow.axis - wide.axis * wide.axis.dot(narrow.axis)).try_normalize()
        else {
            return Cone::FULL;
        };
        let turn = half_angle - wide.half_angle;
        Cone {
            axis: (wide.axis * turn.cos() + side * turn.sin()).normalize(),
            half_angle,
        }
    }

    /// Angle between the axis and the unit vector `w`, in radians.
    #[inline]
    pub fn angle_to_axis(&self, w: Vec3) -> f32 {
        // atan2 keeps its precision near 0 and π, where acos loses it.
        self.axis.cross(w).length().atan2(self.axis.dot(w))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn union_holds_both_cones() {
        let a = Cone {
            axis: Vec3::X,
            half_angle: 0.3,
        };
        let b = Cone {
            axis: Vec3::new(0.2, 1.0, 0.1).normalize(),
            half_angle: 0.5,
        };
        let u = a.union(b);
        for c in [a, b] {
            assert!(u.angle_to_axis(c.axis) + c.half_angle <= u.half_angle + 1e-5);
        }
        assert_eq!(Cone::EMPTY.union(a), a);
        assert_eq!(
            Cone::from_axis(Vec3::X).union(Cone::from_axis(-Vec3::X)),
            Cone::FULL
        );
    }
}
