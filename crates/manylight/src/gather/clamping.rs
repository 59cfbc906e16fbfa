//! The singularity of `1 / d²`, and what is done about it. The sum over lights and its compensation ask the same function.

use crate::color::Rgb;
use crate::math::Vec3;

/// What is done about the singularity of `1 / d²`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clamp {
    /// Nothing.
    None,
    /// Scale-free: a light of area `A` has the radiance `I / (A cosθ)`, and no surface reflects more than it receives. So
    /// the value of a connection is reduced smoothly towards that limit, by `1/√(1 + x²)` with `x = f cosθ_x cosθ_y A / d²`, what
    /// the surface would reflect of the light's radiance (derived; a bound that knows the material). All lights count as so many times larger.
    Auto(f32),
    /// `G <= value`, in 1/m².
    Value(f32),
}

/// The way from a shading point to a piece of light, as far as the clamp is concerned.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClampedConnection {
    /// Unit direction to the light.
    pub w: Vec3,
    /// Inverse of the squared distance, in 1/m².
    pub inv_d2: f32,
    /// `f cosθ_x` of the smooth lobes, in 1/sr.
    pub f_cos: Rgb,
    /// Geometric normal of the shading point.
    pub n_x: Vec3,
    /// Normal of the light.
    pub n_y: Vec3,
    /// Area of the piece in m².
    pub area: f32,
}

impl Clamp {
    /// Share of the value of a connection that the sum over lights keeps, in (0, 1].
    #[inline(always)]
    pub(super) fn kept(self, way: &ClampedConnection) -> f32 {
        let cos_y = way.w.dot(way.n_y).abs();
        match self {
            Clamp::None => 1.0,
            Clamp::Auto(strength) => {
                let area = strength * way.area;
                let image = way.f_cos.max_channel() * area * cos_y * way.inv_d2;
                (1.0 + image * image).sqrt().recip()
            }
            Clamp::Value(limit) => {
                let geometry = way.w.dot(way.n_x).abs() * cos_y * way.inv_d2;
                (limit / geometry).min(1.0)
            }
        }
    }
}
