//! What a scattering function answers where both directions are known: its value class by class and the density of sampling.

use super::Lobes;
use crate::color::Rgb;
use std::ops::{Index, IndexMut};

/// The finite classes in the order of [`ByClass`].
pub(super) const CLASSES: [Lobes; 3] = [Lobes::DIFFUSE, Lobes::GLOSSY, Lobes::NEAR_DELTA];

/// `f |cosθ_i|` of the lobes of each finite class.
#[derive(Clone, Copy, Debug)]
pub(super) struct ByClass([Rgb; 3]);

impl ByClass {
    /// No light.
    pub(super) const BLACK: ByClass = ByClass([Rgb::BLACK; 3]);

    /// What `value` gives for the classes in `lobes`; black for the others.
    #[inline]
    pub(super) fn of(lobes: Lobes, value: impl Fn(Lobes) -> Rgb) -> Self {
        ByClass(CLASSES.map(|class| {
            if lobes.has(class) {
                value(class)
            } else {
                Rgb::BLACK
            }
        }))
    }

    /// Of all classes together.
    #[inline]
    pub(super) fn sum(&self) -> Rgb {
        self.0.into_iter().sum()
    }

    /// Adds the values of a part of the material that has this weight.
    #[inline]
    pub(super) fn add(&mut self, other: &ByClass, weight: f32) {
        for (sum, value) in self.0.iter_mut().zip(other.0) {
            *sum += value * weight;
        }
    }

    /// Lets all count `factor` times as much.
    #[inline]
    pub(super) fn scale(&mut self, factor: f32) {
        self.0 = self.0.map(|value| value * factor);
    }

    /// Counts what is `DIFFUSE` as `GLOSSY`.
    #[inline]
    pub(super) fn demote(&mut self) {
        let [diffuse, glossy, _] = &mut self.0;
        *glossy += *diffuse;
        *diffuse = Rgb::BLACK;
    }
}

impl Index<Lobes> for ByClass {
    type Output = Rgb;

    /// The value of one finite class.
    #[inline]
    fn index(&self, class: Lobes) -> &Rgb {
        &self.0[class.0.trailing_zeros() as usize]
    }
}

impl IndexMut<Lobes> for ByClass {
    #[inline]
    fn index_mut(&mut self, class: Lobes) -> &mut Rgb {
        &mut self.0[class.0.trailing_zeros() as usize]
    }
}

/// See the module.
#[derive(Clone, Copy, Debug)]
pub(super) struct Response {
    pub(super) values: ByClass,
    /// Of sampling `wi` from `wo`, per solid angle.
    pub(super) pdf: f32,
}

impl Response {
    /// Neither light nor density.
    pub(super) const NONE: Response = Response {
        values: ByClass::BLACK,
        pdf: 0.0,
    };
}
