//! Rays and segments.

use crate::math::Vec3;

/// A half-line, or its part up to `t_max`. Origins are moved off their surface by whoever spawns the ray
/// ([`SurfacePoint::spawn`](super::SurfacePoint::spawn)), so hits count from `t = 0`.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Origin.
    pub o: Vec3,
    /// Direction; unit in world space.
    pub d: Vec3,
    /// Hits count up to here, exclusively.
    pub t_max: f32,
}

impl Ray {
    /// An unbounded ray.
    #[inline]
    pub fn new(o: Vec3, d: Vec3) -> Self {
        Ray {
            o,
            d,
            t_max: f32::INFINITY,
        }
    }

    /// The point at parameter `t`.
    #[inline]
    pub fn at(&self, t: f32) -> Vec3 {
        self.o + self.d * t
    }
}

/// The open line between two points, both already moved off their surfaces. What lies on it blocks the view.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// One end.
    pub from: Vec3,
    /// The other end.
    pub to: Vec3,
}

impl Segment {
    /// From one end to the other, which is at 1.
    pub fn ray(&self) -> Ray {
        Ray {
            o: self.from,
            d: self.to - self.from,
            t_max: 1.0,
        }
    }
}
