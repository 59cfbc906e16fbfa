//! Sides of a surface.

use crate::lanes::{Float, Mask, Width};

/// The sides of a frame on which a model scatters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sides {
    /// Those of the model itself.
    Own,
    /// The side of the normal.
    Front,
    /// The other side. Directions are mirrored for the model.
    Back,
    /// Both sides. Directions are mirrored for the model on the other side.
    Both,
}

impl Sides {
    /// The factor by which z is multiplied for the model, given a direction with the coordinate
    /// `z`, and the lanes on a side with scattering.
    #[inline(always)]
    pub(super) fn mirror<S: Width>(self, z: Float<S>) -> (Float<S>, Mask<S>) {
        let everywhere = Mask::splat(z.width(), true);
        match self {
            Sides::Own => (z.same(1.0), everywhere),
            Sides::Front => (z.same(1.0), z.gt(0.0)),
            Sides::Back => (z.same(-1.0), z.lt(0.0)),
            Sides::Both => (z.sign(), everywhere),
        }
    }
}
