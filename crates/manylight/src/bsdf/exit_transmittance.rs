//! The factor of `DIFFUSE` lobes that depends on the exit direction.

use super::models::coat::{self, COSINES};
use super::models::fresnel;
use crate::lanes::{Float, One, Width};

/// `b(wo)` of a `DIFFUSE` lobe `f = a(wi) b(wo) / π`, a function of the cosine of `wo` to the
/// shading normal. Virtual lights store it.
#[derive(Clone, Copy, Debug)]
pub enum ExitTransmittance<'s> {
    /// `b = 1`.
    Lambert,
    /// Fresnel transmittance of a smooth dielectric coat.
    Fresnel {
        /// Index of refraction of the coat over that of the outside.
        eta: f32,
    },
    /// Transmittance of a rough dielectric coat, tabulated over the cosine on [0, 1].
    Coated(&'s [f32; COSINES]),
}

impl ExitTransmittance<'_> {
    /// `b` at a cosine in [0, 1].
    #[inline]
    pub fn eval(&self, cos: f32) -> f32 {
        self.at_cosines::<One>(cos.into()).get()
    }

    /// `b` at a cosine in [0, 1] per lane.
    #[inline(always)]
    pub(crate) fn at_cosines<S: Width>(&self, cos: Float<S>) -> Float<S> {
        match *self {
            ExitTransmittance::Lambert => cos.same(1.0),
            ExitTransmittance::Fresnel { eta } => fresnel::coat_transmittance(cos, eta),
            ExitTransmittance::Coated(table) => coat::interpolate_near(table, cos),
        }
    }
}
