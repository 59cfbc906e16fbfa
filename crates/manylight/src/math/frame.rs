//! Orthonormal frames; the local z axis is the normal.

use super::Vec3;

/// A right-handed orthonormal basis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Local x axis in world space.
    pub s: Vec3,
    /// Local y axis in world space.
    pub t: Vec3,
    /// Local z axis in world space: the normal.
    pub n: Vec3,
}

impl Frame {
    /// A frame with the unit normal `n`; continuous in `n` except where `n.z` changes its sign.
    ///
    /// Source: Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
    #[inline]
    pub fn from_normal(n: Vec3) -> Self {
        let sign = 1.0f32.copysign(n.z);
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        Frame {
            s: Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
            t: Vec3::new(b, sign + n.y * n.y * a, -n.y),
            n,
        }
    }

    /// A frame with the unit normal `n`; its x axis is `tangent` made orthogonal to `n`. If both
    /// are parallel, the result is that of [`Frame::from_normal`].
    #[inline]
    pub fn from_normal_and_tangent(n: Vec3, tangent: Vec3) -> Self {
        match (tangent - n * n.dot(tangent)).try_normalize() {
            Some(s) => Frame {
                s,
                t: n.cross(s),
                n,
            },
            None => Frame::from_normal(n),
        }
    }

    /// From world to local coordinates.
    #[inline]
    pub fn to_local(&self, w: Vec3) -> Vec3 {
        Vec3::new(self.s.dot(w), self.t.dot(w), self.n.dot(w))
    }

    /// From local to world coordinates.
    #[inline]
    pub fn to_world(&self, w: Vec3) -> Vec3 {
        self.s * w.x + self.t * w.y + self.n * w.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_orthonormal_and_invert() {
        for n in [
            Vec3::Z,
            -Vec3::Z,
            Vec3::X,
            Vec3::new(0.3, -0.5, -0.8).normalize(),
        ] {
            for f in [
                Frame::from_normal(n),
                Frame::from_normal_and_tangent(n, Vec3::new(0.1, 0.9, 0.2)),
            ] {
                assert!(
                    f.s.dot(f.t).abs() < 1e-6
                        && f.s.dot(f.n).abs() < 1e-6
                        && f.t.dot(f.n).abs() < 1e-6
                );
                assert!((f.s.cross(f.t) - f.n).length() < 1e-5);
                let w = Vec3::new(0.2, 0.4, -0.7);
                assert!((f.to_world(f.to_local(w)) - w).length() < 1e-5);
            }
        }
    }
}
