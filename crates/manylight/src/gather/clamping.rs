//! The clamp on the `1 / d²` singularity of a connection. The sum over lights uses its weight, bias
//! compensation the clamped fraction, one minus the weight.

use super::{ShadingPoint, Subset};
use crate::lanes::{Color, Float, Vector, Width};
use crate::math::Vec3;

/// Bound on the `1 / d²` singularity of a connection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clamp {
    /// No bound.
    None,
    /// Scale-free: a light of area `A` has radiance `I / (A cosθ)`, and no surface reflects more
    /// than it receives. A connection is weighted by `1/√(1 + x²)`, with
    /// `x = f cosθ_x cosθ_y A / d²` the radiance that the surface would reflect, relative to that
    /// of the light. The bound is derived here; it depends on the material. The number is a factor
    /// on all areas.
    Auto(f32),
    /// `G <= value`, in 1/m².
    Value(f32),
}

/// The connection of a point `x` with a light in each lane, as clamping sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClampedConnection<S: Width> {
    /// Unit direction to the light.
    pub w: Vector<S>,
    /// Inverse of the squared distance, in 1/m².
    pub inv_d2: Float<S>,
    /// `f cosθ_x` of the non-specular lobes, in 1/sr.
    pub f_cos: Color<S>,
    /// Geometric normal at `x`.
    pub n_x: Vector<S>,
    /// Normal of the light.
    pub n_y: Vec3,
    /// Area that the connected part of the light represents, in m².
    pub area: f32,
}

impl Clamp {
    /// Weight `w_c` of a connection in the sum over lights, in (0, 1].
    #[inline(always)]
    pub(super) fn weight<S: Width>(self, connection: &ClampedConnection<S>) -> Float<S> {
        let ClampedConnection { w, inv_d2, .. } = *connection;
        let n_y = Vector::splat(w.z.width(), connection.n_y);
        match self {
            Clamp::None => w.z.same(1.0),
            Clamp::Auto(strength) => {
                let area = strength * connection.area;
                let reflected = connection.f_cos.max_channel() * area * cosine(w, n_y) * inv_d2;
                (1.0 + reflected * reflected).sqrt().recip()
            }
            Clamp::Value(limit) => {
                let geometry = cosine(w, connection.n_x) * cosine(w, n_y) * inv_d2;
                (limit / geometry).min(1.0)
            }
        }
    }
}

/// `|w·n|`.
#[inline(always)]
fn cosine<S: Width>(w: Vector<S>, n: Vector<S>) -> Float<S> {
    (w.x * n.x + w.y * n.y + w.z * n.z).abs()
}

/// A point at which the clamped fraction is evaluated.
#[derive(Clone, Copy, Debug)]
pub struct ClampReceiver {
    /// Position, in m.
    pub p: Vec3,
    /// Geometric normal, unit.
    pub n: Vec3,
    /// As [`ShadingPoint::u`].
    pub u: f32,
    /// The lights that are summed there.
    pub lights: Subset,
}

impl From<&ShadingPoint<'_>> for ClampReceiver {
    fn from(at: &ShadingPoint) -> Self {
        ClampReceiver {
            p: at.x.p,
            n: at.x.ng,
            u: at.u,
            lights: at.lights,
        }
    }
}
