//! Values by class and density of a scattering function, for two given directions.

use super::lobes::Classes;
use crate::lanes::{Color, Float, Mask, Width};

/// `f |cosθ_i|` of the lobes of each finite class.
#[derive(Clone, Copy, Debug)]
pub(super) struct ByClass<S: Width> {
    pub(super) diffuse: Color<S>,
    pub(super) glossy: Color<S>,
    pub(super) near_delta: Color<S>,
}

impl<S: Width> ByClass<S> {
    /// Zero.
    #[inline(always)]
    pub(super) fn black(s: S) -> Self {
        let black = Color::black(s);
        ByClass {
            diffuse: black,
            glossy: black,
            near_delta: black,
        }
    }

    /// `value` in the class of microfacet lobes: that of the set `class` which is in `lobes`, too.
    #[inline(always)]
    pub(super) fn of_microfacets(class: Classes<S>, lobes: Classes<S>, value: Color<S>) -> Self {
        ByClass {
            glossy: value.within(class.glossy & lobes.glossy),
            near_delta: value.within(class.near_delta & lobes.near_delta),
            diffuse: Color::black(value.r.width()),
        }
    }

    /// The sum over the classes.
    #[inline(always)]
    pub(super) fn sum(&self) -> Color<S> {
        self.diffuse + self.glossy + self.near_delta
    }

    /// Applies `f` to the values of all classes.
    #[inline(always)]
    pub(super) fn map(self, f: impl Fn(Color<S>) -> Color<S>) -> Self {
        ByClass {
            diffuse: f(self.diffuse),
            glossy: f(self.glossy),
            near_delta: f(self.near_delta),
        }
    }

    /// Adds `weight` times `o`.
    #[inline(always)]
    pub(super) fn add(&mut self, o: &Self, weight: Float<S>) {
        self.diffuse += o.diffuse * weight;
        self.glossy += o.glossy * weight;
        self.near_delta += o.near_delta * weight;
    }

    /// Moves the value of `DIFFUSE` to `GLOSSY` in the lanes of `m`.
    #[inline(always)]
    pub(super) fn diffuse_as_glossy(self, m: Mask<S>) -> Self {
        ByClass {
            diffuse: self.diffuse.within(!m),
            glossy: self.glossy + self.diffuse.within(m),
            near_delta: self.near_delta,
        }
    }
}

/// Values and density for two directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Response<S: Width> {
    /// `f |cosθ_i|` by class.
    pub(super) values: ByClass<S>,
    /// Density of sampling `wi` given `wo`, per solid angle.
    pub(super) pdf: Float<S>,
}

impl<S: Width> Response<S> {
    /// No scattering.
    #[inline(always)]
    pub(super) fn none(s: S) -> Self {
        Response {
            values: ByClass::black(s),
            pdf: Float::splat(s, 0.0),
        }
    }

    /// The response in the lanes of `m`, no scattering elsewhere.
    #[inline(always)]
    pub(super) fn within(self, m: Mask<S>) -> Self {
        Response {
            values: self.values.map(|value| value.within(m)),
            pdf: m.select(self.pdf, 0.0),
        }
    }
}
