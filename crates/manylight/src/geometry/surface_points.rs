//! Points on surfaces in lanes.

use super::{SurfacePoint, SurfaceRef};
use crate::lanes::{Axes, Float, One, Pair, Vector, Width};

/// A [`SurfacePoint`] per lane; the fields are those of a single one.
#[derive(Clone, Copy, Debug)]
#[expect(missing_docs, reason = "the fields are documented at SurfacePoint")]
pub struct SurfacePoints<S: Width> {
    pub p: Vector<S>,
    pub ng: Vector<S>,
    pub frame: Axes<S>,
    pub uv: Pair<S>,
    pub dp_du: Vector<S>,
    pub dp_dv: Vector<S>,
    pub offset: Float<S>,
    pub at: S::Each<SurfaceRef>,
}

impl<S: Width> SurfacePoints<S> {
    /// The point `points[i]` in each lane `i`.
    #[inline(always)]
    pub fn load(s: S, points: &S::Each<SurfacePoint>) -> Self {
        let x = points.as_ref();
        SurfacePoints {
            p: Vector::from_fn(s, |i| x[i].p),
            ng: Vector::from_fn(s, |i| x[i].ng),
            frame: Axes {
                s: Vector::from_fn(s, |i| x[i].frame.s),
                t: Vector::from_fn(s, |i| x[i].frame.t),
                n: Vector::from_fn(s, |i| x[i].frame.n),
            },
            uv: Pair::from_fn(s, |i| x[i].uv),
            dp_du: Vector::from_fn(s, |i| x[i].dp_du),
            dp_dv: Vector::from_fn(s, |i| x[i].dp_dv),
            offset: Float::from_fn(s, |i| x[i].offset),
            at: s.each(|i| x[i].at),
        }
    }

    /// The positions moved off their surfaces by `offset`, to the side of `w`.
    #[inline(always)]
    pub fn offset_towards(&self, w: Vector<S>) -> Vector<S> {
        self.p + self.ng * self.offset.copysign(self.ng.dot(w))
    }
}

impl From<&SurfacePoint> for SurfacePoints<One> {
    #[inline(always)]
    fn from(x: &SurfacePoint) -> Self {
        SurfacePoints::load(One, &[*x])
    }
}
