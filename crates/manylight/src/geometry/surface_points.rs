//! Points on surfaces in lanes.

use super::{SurfacePoint, SurfaceRef};
use crate::lanes::{Axes, Float, One, Pair, Vector, Width};
use crate::math::{Frame, Vec3};

/// Whether surface points get the derivatives of the position by the texture coordinates, which few materials need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Derivatives {
    /// `dp_du` and `dp_dv` are those of the position.
    OfPosition,
    /// `dp_du` and `dp_dv` are unspecified.
    Unspecified,
}

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

    /// The point in each lane.
    #[inline(always)]
    pub fn store(&self) -> S::Each<SurfacePoint> {
        let s = self.offset.width();
        let vectors = [
            self.p,
            self.ng,
            self.frame.s,
            self.frame.t,
            self.frame.n,
            self.dp_du,
            self.dp_dv,
            Vector::new(self.uv.x, self.uv.y, self.offset),
        ]
        .map(Vector::store);
        s.each(|i| {
            let [p, ng, s, t, n, dp_du, dp_dv, rest] = vectors
                .each_ref()
                .map(|v| Vec3::from_array(v.each_ref().map(|lanes| lanes.as_ref()[i])));
            SurfacePoint {
                p,
                ng,
                frame: Frame { s, t, n },
                uv: rest.truncate(),
                dp_du,
                dp_dv,
                at: self.at.as_ref()[i],
                offset: rest.z,
            }
        })
    }

    /// The positions moved off their surfaces by `offset`, to the side of `w`.
    #[inline(always)]
    pub fn offset_towards(&self, w: Vector<S>) -> Vector<S> {
        self.p + self.ng * self.offset.copysign(self.ng.dot(w))
    }
}

impl From<SurfacePoints<One>> for SurfacePoint {
    #[inline(always)]
    fn from(x: SurfacePoints<One>) -> Self {
        x.store()[0]
    }
}

impl From<&SurfacePoint> for SurfacePoints<One> {
    #[inline(always)]
    fn from(x: &SurfacePoint) -> Self {
        SurfacePoints::load(One, &[*x])
    }
}
