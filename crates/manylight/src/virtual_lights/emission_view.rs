//! Radiant intensity of a light: in one direction, and in [`LANES`](crate::lanes::LANES) directions at once.

use super::glossy::Glossy;
use super::light::{Emission, VirtualLight};
use super::reflection::Reflection;
use super::set::VirtualLights;
use crate::bsdf::{ExitTransmittance, FixedWi, Lobes, interpolate_lanes};
use crate::color::Rgb;
use crate::ids::LightId;
use crate::lanes::vectors::{dot, mul3, scale3, splat3};
use crate::lanes::{LANES, LaneMask, Lanes3};
use crate::math::Vec3;
use crate::simd::Wide;
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

impl EmissionView<'_, '_> {
    /// [`VirtualLights::intensity`] in the directions `-wi`, lane by lane, where the unit directions `wi` point from the receivers to the
    /// light; inactive lanes hold any value.
    #[inline(always)]
    pub(crate) fn intensities<W: Wide>(&self, w: W, wi: &Lanes3, active: LaneMask) -> Lanes3 {
        match self {
            EmissionView::Single { flux, reflection } => {
                let wo = scale3(w, wi.load(w), w.splat(-1.0));
                let values = reflection.f_cos_wo_lanes(w, &Lanes3::store(w, wo), active);
                let flux = splat3(w, Vec3::from(flux.to_array()));
                Lanes3::store(w, mul3(w, values.load(w), flux))
            }
            EmissionView::Rich {
                light,
                diffuse,
                exit,
                glossy,
            } => {
                let away = wi.load(w);
                let zero = w.splat(0.0);
                let cos = dot(w, away, splat3(w, -light.n));
                let cos_s = dot(w, away, splat3(w, -light.ns));
                let above = w.lt(zero, cos);
                let exits = exits(w, exit, cos_s);
                let share = w.mul(w.mul(exits, cos), w.splat(FRAC_1_PI));
                let share = w.select(w.and(above, w.lt(zero, cos_s)), share, zero);
                let mut sum = scale3(w, splat3(w, Vec3::from(diffuse.to_array())), share);
                if let Some(glossy) = glossy {
                    let glossy = glossy.lookups(w, wi, active).load(w);
                    let emitted = if light.one_sided {
                        above
                    } else {
                        w.lanes(u32::MAX)
                    };
                    for (sum, glossy) in sum.iter_mut().zip(glossy) {
                        *sum = w.add(*sum, w.select(emitted, glossy, zero));
                    }
                }
                Lanes3::store(w, sum)
            }
        }
    }
}

/// Exit transmittance of the diffuse part at the cosines to the shading normal, lane by lane.
#[inline(always)]
fn exits<W: Wide>(w: W, exit: &ExitTransmittance, cos: W::F) -> W::F {
    let mut out = w.store(w.max(cos, w.splat(0.0)));
    match exit {
        ExitTransmittance::Lambert => return w.splat(1.0),
        ExitTransmittance::Fresnel { eta } => {
            for cos in &mut out {
                *cos = ExitTransmittance::Fresnel { eta: *eta }.eval(*cos);
            }
        }
        ExitTransmittance::Coated(table) => out = interpolate_lanes(&[table; LANES], &out),
    }
    w.load(&out)
}
