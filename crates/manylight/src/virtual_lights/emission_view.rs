//! Radiant intensity of a light, in one direction or in one per lane.

use super::glossy::Glossy;
use super::light::{Emission, VirtualLight};
use super::reflection::Reflection;
use super::set::VirtualLights;
use crate::bsdf::{ExitTransmittance, FixedWi, Lobes};
use crate::color::Rgb;
use crate::ids::LightId;
use crate::lanes::{Color, Mask, One, Sixteen, Vector, Width};
use crate::math::Vec3;
use crate::simd::outlined;
use std::f32::consts::FRAC_1_PI;

/// The emission of one light, with all that does not depend on the direction looked up.
pub(crate) enum EmissionView<'f, 's, S: Sixteen> {
    /// See [`Emission::Single`].
    Single {
        flux: Rgb,
        reflection: FixedWi<'f, 's, S>,
    },
    /// See [`Emission::Rich`].
    Rich(RichEmission<'f, 's>),
}

/// See [`Emission::Rich`].
#[derive(Clone, Copy)]
pub(crate) struct RichEmission<'f, 's> {
    light: &'f VirtualLight<'s>,
    diffuse: Rgb,
    exit: &'f ExitTransmittance<'s>,
    glossy: Option<Glossy<'f>>,
}

/// The emission of one light.
enum LightEmission<'f, 's> {
    /// See [`Emission::Single`].
    Single(&'f Reflection<'s>),
    /// See [`Emission::Rich`].
    Rich(RichEmission<'f, 's>),
}

/// Radiant intensities of a light, cosine included, in W/sr.
pub(crate) trait RadiantIntensity<S: Width> {
    /// In the unit directions `w` away from the light; inactive lanes hold any value.
    fn intensity(&self, w: Vector<S>, active: Mask<S>) -> Color<S>;
}

impl VirtualLights<'_> {
    /// Radiant intensity of light `id` in the unit direction `w` away from it, cosine included, in
    /// W/sr.
    #[inline]
    pub fn intensity(&self, id: LightId, w: Vec3) -> Rgb {
        match LightEmission::of(self, id) {
            LightEmission::Rich(rich) => rich.intensity(w.into(), Mask::splat(One, true)).into(),
            LightEmission::Single(reflection) => reflection.intensity(w),
        }
    }
}

impl<'f, 's, S: Sixteen> EmissionView<'f, 's, S> {
    /// The emission of light `id` of `lights`, prepared for many directions.
    #[inline(always)]
    pub(crate) fn of(s: S, lights: &'f VirtualLights<'s>, id: LightId) -> Self {
        match LightEmission::of(lights, id) {
            LightEmission::Rich(rich) => EmissionView::Rich(rich),
            LightEmission::Single(Reflection { wi, flux, bsdf }) => EmissionView::Single {
                flux: *flux,
                reflection: FixedWi::new(s, bsdf, *wi, Lobes::NON_SPECULAR),
            },
        }
    }
}

impl<'f, 's> LightEmission<'f, 's> {
    #[inline(always)]
    fn of(lights: &'f VirtualLights<'s>, id: LightId) -> Self {
        let light = &lights.lights[id.index()];
        match &light.emission {
            Emission::Single(index) => LightEmission::Single(lights.reflection(*index)),
            Emission::Rich {
                diffuse,
                exit,
                glossy,
            } => LightEmission::Rich(RichEmission {
                light,
                diffuse: *diffuse,
                exit,
                glossy: glossy.map(|index| lights.glossy(index)),
            }),
        }
    }
}

impl<S: Width> RadiantIntensity<S> for RichEmission<'_, '_> {
    #[inline(always)]
    fn intensity(&self, w: Vector<S>, active: Mask<S>) -> Color<S> {
        let (s, light) = (w.z.width(), self.light);
        let cos = w.dot(Vector::splat(s, light.n));
        let cos_s = w.dot(Vector::splat(s, light.ns));
        let above = cos.gt(0.0);
        let share = self.exit.at_cosines(cos_s.max(0.0)) * cos * FRAC_1_PI;
        let diffuse = Color::splat(s, self.diffuse) * share;
        let mut sum = diffuse.within(above & cos_s.gt(0.0));
        if let Some(glossy) = &self.glossy {
            let glossy = glossy.lookup(w, active);
            sum += if light.one_sided {
                glossy.within(above)
            } else {
                glossy
            };
        }
        sum
    }
}

impl<S: Sixteen> RadiantIntensity<S> for EmissionView<'_, '_, S> {
    #[inline(always)]
    fn intensity(&self, w: Vector<S>, active: Mask<S>) -> Color<S> {
        view_intensity(self, w, active)
    }
}

/// The emission of one light, for single directions.
#[derive(Clone, Copy)]
pub(crate) struct SingleEmission<'f, 's> {
    pub(crate) lights: &'f VirtualLights<'s>,
    pub(crate) id: LightId,
}

impl RadiantIntensity<One> for SingleEmission<'_, '_> {
    #[inline(always)]
    fn intensity(&self, w: Vector<One>, _: Mask<One>) -> Color<One> {
        self.lights.intensity(self.id, w.into()).into()
    }
}

outlined! {
    /// The intensity of an [`EmissionView`].
    fn view_intensity<S: Sixteen>(
        view: &EmissionView<'_, '_, S>, w: Vector<S>, active: Mask<S>,
    ) -> Color<S> { w.z.width() => view.intensity_inlined(w, active) }
}

impl<S: Sixteen> EmissionView<'_, '_, S> {
    #[inline(always)]
    fn intensity_inlined(&self, w: Vector<S>, active: Mask<S>) -> Color<S> {
        match self {
            EmissionView::Single { flux, reflection } => {
                reflection.f_cos_wo_each(w, active) * Color::splat(w.z.width(), *flux)
            }
            EmissionView::Rich(rich) => rich.intensity(w, active),
        }
    }
}
