//! Named bundles of random numbers, drawn in one order everywhere.

use crate::bsdf::BsdfNumbers;
use crate::emitters::EmissionNumbers;
use crate::math::Vec2;
use crate::sampling::Sampler;

impl Sampler {
    /// Random numbers of one BSDF sample.
    #[inline]
    pub fn next_bsdf(&mut self) -> BsdfNumbers {
        BsdfNumbers {
            lobe: self.next_1d(),
            direction: self.next_2d(),
        }
    }

    /// Random numbers of one emitter sample: the choice of an emitter, and of a point on it.
    #[inline]
    pub fn next_emitter(&mut self) -> (f32, Vec2) {
        (self.next_1d(), self.next_2d())
    }

    /// Random numbers of one photon emission.
    #[inline]
    pub fn next_emission(&mut self) -> EmissionNumbers {
        EmissionNumbers {
            emitter: self.next_1d(),
            position: self.next_2d(),
            direction: self.next_2d(),
            element: self.next_1d(),
        }
    }
}
