//! Radiant intensity of a light: in one direction, and in [`LANES`](crate::lanes::LANES) directions at once.

use super::glossy::Glossy;
use super::light::{Emission, VirtualLight};
use super::reflection::Reflection;
use super::set::VirtualLights;
use crate::bsdf::{ExitTransmittance, FixedWi, Lobes};
use crate::color::Rgb;
use crate::ids::LightId;
use crate::lanes::{Color, LaneMask, Lanes3, Sixteen, Vector};
use crate::math::Vec3;
use crate::simd::Outlined;
use std::f32::consts::FRAC_1_PI;

impl VirtualLights<'_> {
    /// Radiant intensity of light `id` in the unit direction `w` away from it, cosine included, in W/sr.
    #[inline]
    pub fn intensity(&self, id: LightId, w: Vec3) -> Rgb {
        let light = &self.lights()[id.index()];
        match &light.emission {
            Emission::Single(index) => self.reflection(*index).intensity(w),
            Emission::Rich {
                diffuse,
                exit,
                glossy,
            } => {
                let (cos, cos_s) = (w.dot(light.n), w.dot(light.ns));
                let mut sum = Rgb::BLACK;
                if cos > 0.0 && cos_s > 0.0 {
                    sum += *diffuse * (exit.eval(cos_s) * cos * FRAC_1_PI);
                }
                if let Some(glossy) = glossy
                    && (cos > 0.0 || !light.one_sided)
                {
                    sum += self.glossy(*glossy).lookup(w);
                }
                sum
            }
        }
    }

    /// The emission of light `id`, prepared for many directions.
    #[inline(always)]
    pub(crate) fn emission_view(&self, id: LightId) -> EmissionView<'_, '_> {
        let light = &self.lights()[id.index()];
        match &light.emission {
            Emission::Single(index) => {
                let Reflection { wi, flux, bsdf } = self.reflection(*index);
                EmissionView::Single {
                    flux: *flux,
                    reflection: bsdf.with_wi(*wi, Lobes::NON_SPECULAR),
                }
            }
            Emission::Rich {
                diffuse,
                exit,
                glossy,
            } => EmissionView::Rich {
                light,
                diffuse: *diffuse,
                exit,
                glossy: glossy.map(|index| self.glossy(index)),
            },
        }
    }
}

/// The emission of one light, with all that does not depend on the direction looked up.
pub(crate) enum EmissionView<'f, 's> {
    /// See [`Emission::Single`].
    Single {
        flux: Rgb,
        reflection: FixedWi<'f, 's>,
    },
    /// See [`Emission::Rich`].
    Rich {
        light: &'f VirtualLight<'s>,
        diffuse: Rgb,
        exit: &'f ExitTransmittance<'s>,
        glossy: Option<Glossy<'f>>,
    },
}

/// [`EmissionView::intensities`]: a function that its many callers share.
struct Intensities<'a, 'f, 's, W> {
    emission: &'a EmissionView<'f, 's>,
    s: W,
    wi: &'a Lanes3,
    active: LaneMask,
}

impl<W: Sixteen> Outlined for Intensities<'_, '_, '_, W> {
    type Output = Lanes3;

    #[inline(always)]
    fn run(self) -> Lanes3 {
        let Intensities {
            emission,
            s,
            wi,
            active,
        } = self;
        let away = wi.vectors(s);
        match emission {
            EmissionView::Single { flux, reflection } => {
                let wo = Lanes3::of_vectors(-away);
                let values = reflection.f_cos_wo_lanes(s, &wo, active).colors(s);
                Lanes3::of_colors(values * Color::splat(s, *flux))
            }
            EmissionView::Rich {
                light,
                diffuse,
                exit,
                glossy,
            } => {
                let cos = away.dot(Vector::splat(s, -light.n));
                let cos_s = away.dot(Vector::splat(s, -light.ns));
                let above = cos.gt(0.0);
                let share = exit.at_cosines(cos_s.max(0.0)) * cos * FRAC_1_PI;
                let diffuse = Color::splat(s, *diffuse) * share;
                let mut sum = diffuse.within(above & cos_s.gt(0.0));
                if let Some(glossy) = glossy {
                    let glossy = glossy.lookups(s, wi, active).colors(s);
                    sum += if light.one_sided {
                        glossy.within(above)
                    } else {
                        glossy
                    };
                }
                Lanes3::of_colors(sum)
            }
        }
    }
}

impl EmissionView<'_, '_> {
    /// [`VirtualLights::intensity`] in the directions `-wi`, lane by lane, where the unit directions `wi` point from the receivers to the
    /// light; inactive lanes hold any value.
    #[inline(always)]
    pub(crate) fn intensities<W: Sixteen>(&self, w: W, wi: &Lanes3, active: LaneMask) -> Lanes3 {
        w.outline(Intensities {
            emission: self,
            s: w,
            wi,
            active,
        })
    }
}
