//! Lambert's model in the shading frame, for the shortcuts of the most frequent material.

use super::BsdfSamples;
use super::lobes::Lobes;
use crate::lanes::{
    Axes, Color, Float, Mask, Pair, Vector, Width, Word, cosine_hemisphere, cosine_hemisphere_pdf,
};

/// Lambertian reflection on one side of the shading frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lambert<S: Width> {
    pub albedo: Color<S>,
    /// The sign of z on that side.
    pub side: Float<S>,
    /// The lanes in which the given direction is on that side.
    pub valid: Mask<S>,
}

impl<S: Width> Lambert<S> {
    /// Density of cosine-distributed directions, which is also `f cosθ` over the albedo.
    #[inline(always)]
    pub(super) fn pdf(&self, w: Vector<S>) -> Float<S> {
        self.valid
            .select(cosine_hemisphere_pdf(w.z * self.side), 0.0)
    }

    /// A cosine-distributed direction. Its weight is the albedo.
    #[inline(always)]
    pub(super) fn sample(&self, frame: &Axes<S>, u: Pair<S>) -> BsdfSamples<S> {
        let w = cosine_hemisphere(u);
        let pdf = cosine_hemisphere_pdf(w.z);
        BsdfSamples {
            w: frame.to_world(w.scale_z(self.side)),
            weight: self.albedo,
            pdf,
            lobe: Word::splat(pdf.width(), u32::from(Lobes::DIFFUSE.0)),
            eta: pdf.same(1.0),
            valid: self.valid & pdf.gt(0.0) & !self.albedo.is_black(),
        }
    }
}
