//! Interference in a thin film over the main interface.
//!
//! Sources: Belcour and Barla, "A Practical Extension to Microfacet Theory for the Modeling of
//! Varying Iridescence", 2017, in the approximation of KHR_materials_iridescence: Schlick's
//! reflectances of both sides of the film, phases of 0 or π, two orders of interference, and the
//! sensitivities of the eye as Gaussians.

use crate::lanes::{Color, Float, Mask, One, Width, lanewise};
use std::f32::consts::PI;

/// Thickness in nm below which the index of the film becomes that of the outside, so that no film
/// reflects nothing.
const THINNEST: f32 = 0.03;
/// Bounds of the reflectances of which the base is made: an index of refraction has none of 1.
const MAX_BASE: f32 = 0.9999;
/// Bounds of the index of refraction of a film, far beyond those of matter.
const ETAS: [f32; 2] = [0.1, 100.0];
/// Optical path difference in nm from which on colors no longer interfere.
const LONGEST_PATH: f32 = 1e6;
/// Smallest product of the reflectances of both sides of the film.
const MIN_PRODUCT: f32 = 1e-5;

/// A sensitivity as a function of wave number: a Gaussian.
struct Sensitivity {
    /// Index of the tristimulus value.
    value: usize,
    /// Weight in m.
    weight: f32,
    /// Mean of the wave number in 1/m.
    position: f32,
    /// Variance of the wave number in 1/m².
    variance: f32,
}

/// The fits of the tristimulus values X (two), Y, Z.
const SENSITIVITIES: [Sensitivity; 4] = [
    Sensitivity {
        value: 0,
        weight: 5.4856e-13,
        position: 1.6810e6,
        variance: 4.3278e9,
    },
    Sensitivity {
        value: 0,
        weight: 9.7470e-14,
        position: 2.2399e6,
        variance: 4.5282e9,
    },
    Sensitivity {
        value: 1,
        weight: 4.4201e-13,
        position: 1.7953e6,
        variance: 9.3046e9,
    },
    Sensitivity {
        value: 2,
        weight: 5.2481e-13,
        position: 2.2084e6,
        variance: 6.6121e9,
    },
];
/// The integral of the sensitivity to Y in the units of the weights.
const NORMALIZATION: f32 = 1.0685e-7;

/// From tristimulus values to linear Rec. 709, by rows.
const RGB_OF_XYZ: [[f32; 3]; 3] = [
    [3.240_454_2, -1.537_138_5, -0.498_531_4],
    [-0.969_266, 1.876_010_8, 0.041_556],
    [0.055_643_4, -0.204_025_9, 1.057_225_2],
];

/// Largest absolute value of a channel of [`interference`]: the sum over the absolute values of a
/// row of the matrix, times tristimulus values of at most 1.02.
const MAX_INTERFERENCE: f32 = 1.02 * (3.240_454_2 + 1.537_138_5 + 0.498_531_4);

/// Parameters at a point; names as in [`ThinFilm`](crate::bsdf::material::ThinFilm).
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct FilmParameters<S: Width> {
    pub weight: Float<S>,
    pub eta: Float<S>,
    pub thickness: Float<S>,
}

impl<S: Width> FilmParameters<S> {
    /// No film.
    #[inline(always)]
    pub(super) fn none(s: S) -> Self {
        FilmParameters {
            weight: Float::splat(s, 0.0),
            eta: Float::splat(s, 1.0),
            thickness: Float::splat(s, 0.0),
        }
    }
}

lanewise!(FilmParameters {
    weight,
    eta,
    thickness
});

/// A film over an interface at a point.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct Film<S: Width> {
    p: FilmParameters<S>,
    /// Weight of the reflection: that of the film times that of the interface.
    reflecting: Float<S>,
    /// Reflectance of the interface at normal incidence, without the film.
    base: Color<S>,
}

lanewise!(Film {
    p,
    reflecting,
    base
});

impl<S: Width> Film<S> {
    #[inline(always)]
    pub(super) fn new(p: FilmParameters<S>, base: Color<S>) -> Self {
        Film {
            p,
            reflecting: p.weight,
            base,
        }
    }

    /// In a front with an interface of this weight.
    #[inline(always)]
    pub(super) fn requested(self, interface: Float<S>) -> Self {
        Film {
            reflecting: self.p.weight * interface,
            ..self
        }
    }

    /// With all its light times `weight`.
    #[inline(always)]
    pub(super) fn weighted(self, weight: Float<S>) -> Self {
        Film {
            reflecting: self.reflecting * weight,
            ..self
        }
    }

    #[inline(always)]
    pub(super) fn is_present(&self) -> Mask<S> {
        self.p.weight.gt(0.0)
    }

    /// Weight of the interface without the film.
    #[inline(always)]
    pub(super) fn bare(&self) -> Float<S> {
        1.0 - self.p.weight
    }

    /// The light that an interface with this film reflects at the cosine `cos` to a facet, over
    /// what it receives, of at least `least`; and the same over the weight of the film.
    #[inline(always)]
    pub(super) fn reflection(&self, cos: Float<S>, least: f32) -> (Color<S>, Color<S>) {
        let reflectance = self.reflectance(cos).map(|v| v.max(least));
        (reflectance * self.reflecting, reflectance)
    }

    /// Reflectance that the base has under a film: `r` of the bare dielectric in its part.
    #[inline(always)]
    pub(super) fn kept(&self, r: Float<S>, reflectance: Color<S>) -> Float<S> {
        r + (reflectance.max_channel() - r) * self.p.weight
    }

    /// Index of refraction.
    #[inline(always)]
    fn eta(&self) -> Float<S> {
        let x = (self.p.thickness * THINNEST.recip()).clamp(0.0, 1.0);
        let [least, most] = ETAS;
        1.0 + (self.p.eta.clamp(least, most) - 1.0) * (x * x * (3.0 - 2.0 * x))
    }

    /// The terms of the reflectance at a facet.
    #[inline(always)]
    fn terms(&self, cos: Float<S>) -> FilmTerms<S> {
        let eta = self.eta();
        let cos = cos.clamp(0.0, 1.0);
        let cos2 = 1.0 - (1.0 - cos * cos) / (eta * eta);
        let within = cos2.safe_sqrt();
        let outer = schlick(normal_reflectance(eta), cos);
        let base = self.base.map(|v| {
            let root = v.clamp(0.0, MAX_BASE).safe_sqrt();
            (1.0 + root) / (1.0 - root)
        });
        FilmTerms {
            is_total: cos2.lt(0.0),
            path: (2.0 * eta * self.p.thickness * within).min(LONGEST_PATH),
            outer,
            inner: base.map(|v| schlick(normal_reflectance(v / eta), within)),
            // Phases of π at the inner side of the film, of light from within, and at the base.
            sign: base.map(|v| {
                let outside = eta.lt(1.0).select(1.0, -1.0);
                v.lt(eta).select(-outside, outside)
            }),
        }
    }

    /// Reflectance of the interface with the film at the cosine `cos` to a facet.
    #[inline(always)]
    fn reflectance(&self, cos: Float<S>) -> Color<S> {
        let t = self.terms(cos);
        let passing = 1.0 - t.outer;
        let product = t.inner.map(|v| (v * t.outer).clamp(MIN_PRODUCT, MAX_BASE));
        let first = interference(t.path, t.sign);
        let second = interference(2.0 * t.path, Color::grey(cos.same(1.0)));
        let channel = |inner: Float<S>, product: Float<S>, first: Float<S>, second: Float<S>| {
            let direct = passing * passing * inner / (1.0 - product);
            let amplitude = (direct - passing) * product.safe_sqrt();
            let orders = first + second * product.safe_sqrt();
            let sum = t.outer + direct + 2.0 * amplitude * orders;
            t.is_total.select(1.0, sum.clamp(0.0, 1.0))
        };
        Color::new(
            channel(t.inner.r, product.r, first.r, second.r),
            channel(t.inner.g, product.g, first.g, second.g),
            channel(t.inner.b, product.b, first.b, second.b),
        )
    }
}

/// Terms of the reflectance of a film at a facet.
struct FilmTerms<S: Width> {
    /// Whether light is totally reflected at the film.
    is_total: Mask<S>,
    /// Optical path difference in nm.
    path: Float<S>,
    /// Reflectance of the outer side of the film.
    outer: Float<S>,
    /// Reflectance of the base under the film.
    inner: Color<S>,
    /// Cosine of the phase of reflections: 1 or -1.
    sign: Color<S>,
}

/// Schlick's reflectance for one of `r0` at normal incidence.
#[inline(always)]
fn schlick<S: Width>(r0: Float<S>, cos: Float<S>) -> Float<S> {
    r0 + (1.0 - r0) * super::terms::schlick_weight(cos)
}

/// Reflectance at normal incidence of an interface of the relative index `eta`.
#[inline(always)]
fn normal_reflectance<S: Width>(eta: Float<S>) -> Float<S> {
    ((eta - 1.0) / (eta + 1.0)).squared()
}

/// The color of `cos(phase)` over the sensitivities, for a path difference in nm; `sign` is the
/// cosine of the phase of reflections, of each tristimulus value as of the channel of its index.
#[inline(always)]
fn interference<S: Width>(path: Float<S>, sign: Color<S>) -> Color<S> {
    let path = path * 1e-9;
    let phase2 = (2.0 * PI) * (2.0 * PI) * path * path;
    let mut values = [path.same(0.0); 3];
    for fit in &SENSITIVITIES {
        let scale = fit.weight * (2.0 * PI * fit.variance).sqrt() / NORMALIZATION;
        let (_, cos) = (path * fit.position).sin_cos_turns();
        values[fit.value] += scale * cos * (-(phase2 * fit.variance)).exp();
    }
    let [x, y, z] = values;
    let (x, y, z) = (x * sign.r, y * sign.g, z * sign.b);
    let row = |[a, b, c]: [f32; 3]| x * a + y * b + z * c;
    let [r, g, b] = RGB_OF_XYZ;
    Color::new(row(r), row(g), row(b))
}

impl Film<One> {
    /// Upper bound of the first value of [`Film::reflection`] for cosines from `least` on.
    pub(super) fn bound(&self, least: f32) -> f32 {
        if self.reflecting.get() <= 0.0 {
            return 0.0;
        }
        // Both sides of the film reflect most at the smallest cosine, and transmit most at normal
        // incidence.
        let steep = self.terms(least.into());
        let normal = self.terms(1.0.into());
        if steep.is_total.any() {
            return self.reflecting.get();
        }
        let (outer, inner) = (steep.outer.get(), steep.inner.max_channel().get());
        let passing = 1.0 - normal.outer.get();
        let product = (outer * inner).clamp(MIN_PRODUCT, MAX_BASE);
        let direct = passing * passing * inner / (1.0 - product);
        let root = product.sqrt();
        let amplitude = direct.max(passing) * root * (1.0 + root);
        let bound = outer + direct + 2.0 * amplitude * MAX_INTERFERENCE;
        self.reflecting.get() * bound.min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;

    fn film(eta: f32, thickness: f32, base: [f32; 3]) -> Film<One> {
        let p = FilmParameters {
            weight: 1.0.into(),
            eta: eta.into(),
            thickness: thickness.into(),
        };
        Film::new(p, Rgb::from(base).into())
    }

    /// Index, cosine, thickness in nm, reflectance of the base; reflectance by the formulas of the
    /// appendix of KHR_materials_iridescence, evaluated in double precision by NumPy.
    type Specified = (f32, f32, f32, [f32; 3], [f32; 3]);
    const SPECIFIED: [Specified; 10] = [
        (
            1.3,
            1.0,
            400.0,
            [0.04, 0.04, 0.04],
            [0.007456, 0.038352, 0.016038],
        ),
        (
            1.3,
            0.6,
            400.0,
            [0.04, 0.04, 0.04],
            [0.020440, 0.009127, 0.043316],
        ),
        (
            1.8,
            0.3,
            250.0,
            [0.9, 0.6, 0.2],
            [1.000000, 0.170115, 0.227010],
        ),
        (
            1.33,
            0.8,
            700.0,
            [0.95, 0.64, 0.54],
            [0.934695, 0.605238, 0.412268],
        ),
        (
            2.4,
            0.9,
            120.0,
            [0.04, 0.04, 0.04],
            [0.033258, 0.056129, 0.240629],
        ),
        (
            1.5,
            0.5,
            0.0,
            [0.3, 0.2, 0.1],
            [0.480746, 0.354068, 0.243458],
        ),
        (
            1.3,
            0.05,
            400.0,
            [0.04, 0.04, 0.04],
            [0.832680, 0.784951, 0.735848],
        ),
        (
            0.8,
            0.9,
            300.0,
            [0.04, 0.1, 0.2],
            [0.158805, 0.185104, 0.221022],
        ),
        (
            0.8,
            0.3,
            300.0,
            [0.04, 0.1, 0.2],
            [1.000000, 1.000000, 1.000000],
        ),
        (
            1.2,
            0.7,
            5000.0,
            [0.5, 0.5, 0.5],
            [0.437264, 0.437264, 0.437264],
        ),
    ];

    #[test]
    fn reflectances_are_those_of_the_specification() {
        for (eta, cos, thickness, base, expected) in SPECIFIED {
            let film = film(eta, thickness, base);
            let found = Rgb::from(film.reflectance(cos.into())).to_array();
            for (a, b) in found.into_iter().zip(expected) {
                assert!((a - b).abs() < 2e-4, "{eta} {cos}: {found:?} {expected:?}");
            }
        }
    }

    #[test]
    fn odd_films_are_finite_and_bounds_hold() {
        for eta in [1e-30, 0.5, 1.0, 1.3, 2.5, 1e30] {
            for thickness in [0.0, 0.01, 100.0, 400.0, 1e5, 1e30] {
                for base in [[0.0; 3], [0.04, 0.5, 1.0]] {
                    let film = film(eta, thickness, base);
                    for i in 0..=100 {
                        let cos = i as f32 / 100.0;
                        let r = Rgb::from(film.reflectance(cos.into()));
                        let bound = film.bound(cos);
                        let name = format!("{eta} {thickness} {base:?} {cos}: {r:?}");
                        assert!(r.is_finite() && r.max_channel() <= 1.0, "{name}");
                        assert!(film.bound(0.5 * cos) * 1.0001 >= r.max_channel(), "{name}");
                        assert!(bound * 1.0001 >= r.max_channel(), "{name}: {bound}");
                    }
                }
            }
        }
        // The bound follows the film: far below 1 on a dielectric.
        assert!(film(1.3, 400.0, [0.04; 3]).bound(0.9) < 0.15);
    }
}
