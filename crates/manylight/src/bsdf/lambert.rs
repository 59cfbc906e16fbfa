//! Lambert's model in the shading frame, for the shortcuts of the most frequent material.

use super::{BsdfSample, Lobes};
use crate::color::Rgb;
use crate::math::{Frame, Vec2, Vec3};
use crate::sampling::warp;

/// Lambertian reflection on one side of the shading frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lambert {
    pub albedo: Rgb,
    /// The sign of z on that side.
    pub side: f32,
}

impl Lambert {
    /// Density of cosine-distributed directions, which is also `f cosθ` over the albedo.
    #[inline]
    pub(super) fn pdf(&self, w: Vec3) -> f32 {
        warp::cosine_hemisphere_pdf(w.z * self.side)
    }

    /// A cosine-distributed direction. Its weight is the albedo.
    #[inline]
    pub(super) fn sample(&self, frame: &Frame, u: Vec2) -> Option<BsdfSample> {
        let mut w = warp::cosine_hemisphere(u);
        let pdf = warp::cosine_hemisphere_pdf(w.z);
        w.z *= self.side;
        (pdf > 0.0 && !self.albedo.is_black()).then(|| BsdfSample {
            w: frame.to_world(w),
            weight: self.albedo,
            pdf,
            lobe: Lobes::DIFFUSE,
            eta: 1.0,
        })
    }
}
