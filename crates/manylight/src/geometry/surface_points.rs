//! Points on surfaces in lanes.

use super::{SurfacePoint, SurfaceRef};
use crate::lanes::{Axes, Float, One, Pair, Vector, Width};
use crate::math::{Frame, Vec2, Vec3};

/// Whether surface points get the derivatives of the position by the texture coordinates, which few
/// materials need.
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
        let (p, ng, frame) = (self.p.store(), self.ng.store(), &self.frame);
        let axes = [frame.s.store(), frame.t.store(), frame.n.store()];
        let (dp_du, dp_dv) = (self.dp_du.store(), self.dp_dv.store());
        let (u, v, offset) = (self.uv.x.store(), self.uv.y.store(), self.offset.store());
        s.each(|i| {
            let vector = |[x, y, z]: &[S::Each<f32>; 3]| {
                Vec3::new(x.as_ref()[i], y.as_ref()[i], z.as_ref()[i])
            };
            SurfacePoint {
                p: vector(&p),
                ng: vector(&ng),
                frame: Frame {
                    s: vector(&axes[0]),
                    t: vector(&axes[1]),
                    n: vector(&axes[2]),
                },
                uv: Vec2::new(u.as_ref()[i], v.as_ref()[i]),
                dp_du: vector(&dp_du),
                dp_dv: vector(&dp_dv),
                at: self.at.as_ref()[i],
                offset: offset.as_ref()[i],
            }
        })
    }

    /// [`SurfacePoint::normal_towards`] in each lane.
    #[inline(always)]
    pub fn normals_towards(&self, w: Vector<S>) -> Vector<S> {
        self.ng * self.ng.dot(w).sign()
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
