//! Rays and segments.

use crate::math::Vec3;

/// A half-line, or its part up to `t_max`. Hits count from `t = 0` on:
/// [`SurfacePoint::spawn`](super::SurfacePoint::spawn) moves the origin off the surface.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Origin.
    pub o: Vec3,
    /// Direction; unit in world space.
    pub d: Vec3,
    /// Upper bound of the ray parameter of hits, exclusive.
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

/// Largest number of origins, and of targets, in a block of segments: the bits of a mask.
pub const BLOCK: usize = 64;

/// The open segment between two points, both moved off their surfaces.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// One end.
    pub from: Vec3,
    /// The other end.
    pub to: Vec3,
}

impl Segment {
    /// The ray from `from` that reaches `to` at parameter 1 and ends there.
    pub fn ray(&self) -> Ray {
        Ray {
            o: self.from,
            d: self.to - self.from,
            t_max: 1.0,
        }
    }
}
