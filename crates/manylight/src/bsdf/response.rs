//! Values by class and density of a scattering function, for two given directions.

use super::Lobes;
use crate::color::Rgb;
use std::ops::{Index, IndexMut};

/// The finite classes, in the order of [`ByClass`].
pub(super) const CLASSES: [Lobes; 3] = [Lobes::DIFFUSE, Lobes::GLOSSY, Lobes::NEAR_DELTA];

/// `f |cosθ_i|` of the lobes of each finite class.
#[derive(Clone, Copy, Debug)]
pub(super) struct ByClass([Rgb; 3]);

impl ByClass {
    /// Zero.
    pub(super) const BLACK: ByClass = ByClass([Rgb::BLACK; 3]);

    /// `value` of each class in `lobes`; black for the others.
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

    /// The sum over the classes.
    #[inline]
    pub(super) fn sum(&self) -> Rgb {
        self.0.into_iter().sum()
    }

    /// Adds `weight` times `other`.
    #[inline]
    pub(super) fn add(&mut self, other: &ByClass, weight: f32) {
        for (sum, value) in self.0.iter_mut().zip(other.0) {
            *sum += value * weight;
        }
    }

    /// Multiplies all values.
    #[inline]
    pub(super) fn scale(&mut self, factor: f32) {
        self.0 = self.0.map(|value| value * factor);
    }

    /// Adds the value of `DIFFUSE` to `GLOSSY`, and sets it to zero.
    #[inline]
    pub(super) fn move_diffuse_to_glossy(&mut self) {
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

/// Values and density for two directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Response {
    /// `f |cosθ_i|` by class.
    pub(super) values: ByClass,
    /// Density of sampling `wi` given `wo`, per solid angle.
    pub(super) pdf: f32,
}

impl Response {
    /// No scattering.
    pub(super) const NONE: Response = Response {
        values: ByClass::BLACK,
        pdf: 0.0,
    };
}
