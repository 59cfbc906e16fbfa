//! The clamp on the `1 / d²` singularity of a connection. The sum over lights uses its weight, bias compensation the clamped
//! fraction, one minus the weight.
#![expect(
    clippy::needless_range_loop,
    reason = "loops over lanes read like what they become: vector instructions"
)]

use super::light_index::{Assignment, LightIndex};
use super::points::Batch;
use super::{Gather, ShadingPoint, Subset};
use crate::color::Rgb;
use crate::lanes::{LANES, Lanes, Lanes3};
use crate::math::Vec3;
use crate::virtual_lights::SurfaceLocation;

/// Bound on the `1 / d²` singularity of a connection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clamp {
    /// No bound.
    None,
    /// Scale-free: a light of area `A` has radiance `I / (A cosθ)`, and no surface reflects more than it receives. A connection
    /// is weighted by `1/√(1 + x²)`, with `x = f cosθ_x cosθ_y A / d²` the radiance that the surface would reflect, relative to
    /// that of the light. The bound is derived here; it depends on the material. The number is a factor on all areas.
    Auto(f32),
    /// `G <= value`, in 1/m².
    Value(f32),
}

/// A connection of a shading point `x` with a light, as clamping sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClampedConnection {
    /// Unit direction to the light.
    pub w: Vec3,
    /// Inverse of the squared distance, in 1/m².
    pub inv_d2: f32,
    /// `f cosθ_x` of the non-specular lobes, in 1/sr.
    pub f_cos: Rgb,
    /// Geometric normal at `x`.
    pub n_x: Vec3,
    /// Normal of the light.
    pub n_y: Vec3,
    /// Area that the connected part of the light represents, in m².
    pub area: f32,
}

impl Clamp {
    /// Weight of a connection in the sum over lights, in (0, 1].
    #[inline(always)]
    pub(super) fn weight(self, connection: &ClampedConnection) -> f32 {
        let cos_y = connection.w.dot(connection.n_y).abs();
        match self {
            Clamp::None => 1.0,
            Clamp::Auto(strength) => {
                let area = strength * connection.area;
                let reflected = connection.f_cos.max_channel() * area * cos_y * connection.inv_d2;
                (1.0 + reflected * reflected).sqrt().recip()
            }
            Clamp::Value(limit) => {
                let cos_x = connection.w.dot(connection.n_x).abs();
                let geometry = cos_x * cos_y * connection.inv_d2;
                (limit / geometry).min(1.0)
            }
        }
    }
}

/// The connections of one batch with a point, as clamping sees them: [`ClampedConnection`] in lanes.
pub(super) struct ClampedConnections<'a> {
    pub(super) batch: &'a Batch<'a, 'a>,
    pub(super) w: &'a Lanes3,
    pub(super) inv_d2: &'a Lanes,
    pub(super) f_cos: &'a Lanes3,
    pub(super) n: Vec3,
    pub(super) area: f32,
}

impl ClampedConnections<'_> {
    /// [`Clamp::weight`] in each lane.
    #[inline(always)]
    pub(super) fn weights(&self, clamp: Clamp) -> Lanes {
        let lane = |clamp: Clamp, i: usize| {
            clamp.weight(&ClampedConnection {
                w: self.w.vec(i),
                inv_d2: self.inv_d2[i],
                f_cos: self.f_cos.rgb(i),
                n_x: self.batch.ng.vec(i),
                n_y: self.n,
                area: self.area,
            })
        };
        let mut weights = [1.0; LANES];
        // One loop for each kind, so that the choice is not made in every lane.
        match clamp {
            Clamp::None => {}
            Clamp::Auto(strength) => {
                for i in 0..LANES {
                    weights[i] = lane(Clamp::Auto(strength), i);
                }
            }
            Clamp::Value(limit) => {
                for i in 0..LANES {
                    weights[i] = lane(Clamp::Value(limit), i);
                }
            }
        }
        weights
    }
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

impl Gather {
    /// Fraction of the light from `y` that the clamp removes from the sum at `at`: one minus the weight of a connection with
    /// the part at `y` of the light to which photons at `y` are assigned. `f_cos` is `f cosθ` of the non-specular lobes at
    /// `at` for a direction, in 1/sr.
    pub fn clamped_fraction(
        &self,
        lights: &LightIndex,
        at: &ClampReceiver,
        y: &SurfaceLocation,
        assignment: Assignment,
        f_cos: impl FnOnce(Vec3) -> Rgb,
    ) -> f32 {
        if self.clamp == Clamp::None {
            return 0.0;
        }
        let (n_y, area) = match assignment {
            Assignment::Light(id) => {
                let light = &lights.set.lights()[id.index()];
                (light.n, self.part_area(at, light))
            }
            Assignment::Unassigned { area } => (y.n, area),
        };
        let to_y = y.p - at.p;
        let d2 = to_y.length_squared();
        if d2 == 0.0 {
            return 0.0;
        }
        let inv_d = d2.sqrt().recip();
        let w = to_y * inv_d;
        1.0 - self.clamp.weight(&ClampedConnection {
            w,
            inv_d2: inv_d * inv_d,
            f_cos: f_cos(w),
            n_x: at.n,
            n_y,
            area: area * self.area_factor(at.lights),
        })
    }
}
