//! Receivers of light, in lanes.

use crate::lanes::{Mask, One, Vector, Width};
use crate::math::Vec3;

/// A point that receives light per lane.
#[derive(Clone, Copy, Debug)]
pub struct Receivers<S: Width> {
    /// Position, in m.
    pub p: Vector<S>,
    /// Unit geometric normal; any finite vector where there is none.
    pub n: Vector<S>,
    /// The lanes with a normal. The others receive light from all directions.
    pub has_normal: Mask<S>,
}

impl From<(Vec3, Option<Vec3>)> for Receivers<One> {
    #[inline(always)]
    fn from((p, n): (Vec3, Option<Vec3>)) -> Self {
        Receivers {
            p: p.into(),
            n: n.unwrap_or(Vec3::ZERO).into(),
            has_normal: Mask::splat(One, n.is_some()),
        }
    }
}
