//! Sides of a surface.

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
    /// The factor by which z is multiplied for the model, given a direction with the coordinate `z`. `None` on a side without
    /// scattering.
    #[inline]
    pub(super) fn mirror(self, z: f32) -> Option<f32> {
        match self {
            Sides::Own => Some(1.0),
            Sides::Front => (z > 0.0).then_some(1.0),
            Sides::Back => (z < 0.0).then_some(-1.0),
            Sides::Both => Some(1.0f32.copysign(z)),
        }
    }
}
