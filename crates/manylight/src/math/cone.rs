//! Bounding cones of directions, and bounds of angles with their cosines.

use super::Vec3;
use super::float::safe_sqrt;
use std::f32::consts::{FRAC_PI_2, PI};

/// Margin added to the half angle of a [`Spread`], in radians. The cosine of an angle near 0 does
/// not resolve smaller angles in `f32`.
const ROUNDING: f32 = 1e-3;

/// All unit directions within `half_angle` of `axis`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Unit axis.
    pub axis: Vec3,
    /// Half angle in radians, from 0 to π; negative for the empty cone.
    pub half_angle: f32,
}

impl Cone {
    /// The empty cone: the neutral element of [`Cone::union`].
    pub const EMPTY: Cone = Cone {
        axis: Vec3::Z,
        half_angle: -1.0,
    };
    /// The cone of all directions.
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

    /// A bounding cone of both cones.
    ///
    /// Source: Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree
    /// Splitting", 2018, algorithm 1.
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
        // Rotate the wide axis towards the narrow one until the new cone touches the far rim of the
        // wide cone.
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

/// An upper bound of the angle between a set of directions and an axis, with its cosine and sine.
/// All functions but [`Spread::new`] are free of calls and branches, so that loops over them
/// vectorize.
#[derive(Clone, Copy, Debug)]
pub struct Spread {
    /// Upper bound of the angle in radians, up to π.
    pub half_angle: f32,
    /// Cosine of the bound.
    pub cos: f32,
    /// Sine of the bound.
    pub sin: f32,
}

impl Spread {
    /// The bound of all directions.
    pub const EVERYWHERE: Spread = Spread {
        half_angle: PI,
        cos: -1.0,
        sin: 0.0,
    };

    /// The bound of a cone with this half angle in radians, plus a margin of 1e-3.
    pub fn new(half_angle: f32) -> Self {
        let half_angle = (half_angle + ROUNDING).min(PI);
        let (sin, cos) = half_angle.sin_cos();
        Spread {
            half_angle,
            cos,
            sin,
        }
    }

    /// The bound of the directions to a ball around the axis, plus a margin of about 1e-3.
    /// `distance` is that of the ball's center; inside of the ball the bound is π.
    #[inline(always)]
    pub fn to_ball(radius: f32, distance: f32) -> Self {
        let sin = radius / distance + ROUNDING;
        let outside = sin < 1.0;
        let sin = if outside { sin } else { 0.0 };
        let cos = (1.0 - sin * sin).sqrt();
        Spread {
            // asin x <= x + (π/2 - 1) x³ on [0, 1]: (asin x - x) / x³ is a series with positive
            // terms, largest at x = 1.
            half_angle: if outside {
                sin + (FRAC_PI_2 - 1.0) * sin * sin * sin
            } else {
                PI
            },
            cos: if outside { cos } else { -1.0 },
            sin,
        }
    }

    /// The bound of the sum of both angles: of directions within `self` of an axis that is within
    /// `o` of another axis.
    #[inline(always)]
    pub fn plus(self, o: Spread) -> Self {
        let everywhere = self.cos <= -o.cos;
        let (cos, sin) = (
            self.cos * o.cos - self.sin * o.sin,
            self.sin * o.cos + self.cos * o.sin,
        );
        Spread {
            half_angle: (self.half_angle + o.half_angle).min(PI),
            cos: if everywhere { -1.0 } else { cos },
            sin: if everywhere { 0.0 } else { sin },
        }
    }

    /// Bounds of the cosine between the directions and a unit vector; `cos` is the cosine between
    /// that vector and the axis.
    #[inline(always)]
    pub fn cosines(&self, cos: f32) -> [f32; 2] {
        let across = safe_sqrt(1.0 - cos * cos) * self.sin;
        let along = cos * self.cos;
        [
            if cos <= -self.cos {
                -1.0
            } else {
                along - across
            },
            if cos >= self.cos { 1.0 } else { along + across },
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spreads_are_wide_enough() {
        for k in 0..1000 {
            let ratio = k as f32 / 900.0;
            let spread = Spread::to_ball(ratio * 3.0, 3.0);
            let exact = if ratio < 1.0 { ratio.asin() } else { PI };
            assert!(spread.half_angle >= exact, "{ratio}: {spread:?}");
            assert!(spread.cos <= exact.cos() + 1e-6, "{ratio}: {spread:?}");
            let other = Spread::new(k as f32 * 0.003);
            let sum = (exact + other.half_angle).min(PI);
            let both = spread.plus(other);
            assert!(both.half_angle >= sum && both.cos <= sum.cos() + 1e-6);
        }
        let full = Spread::to_ball(0.0, 0.0);
        assert_eq!((full.half_angle, full.cosines(-0.3)), (PI, [-1.0, 1.0]));
        let [low, high] = Spread::new(0.5).cosines(1.0f32.cos());
        assert!(low <= 1.5f32.cos() && low > 1.51f32.cos());
        assert!(high >= 0.5f32.cos() && high < 0.49f32.cos());
    }

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
