//! Sampling of emitters from a point: next-event estimation.

use super::Emitters;
use super::description::Emitter;
use super::elements::ElementShape;
use super::infinite::{InfiniteLightPlan, SampledRadiance};
use super::unit_interval::split;
use crate::color::Rgb;
use crate::geometry::{Geometry, SurfacePoint};
use crate::ids::EmitterId;
use crate::math::{Vec2, Vec3};
use crate::texture::Texture;

/// A direction from a point towards an emitter.
#[derive(Clone, Copy, Debug)]
pub struct DirectSample {
    /// Unit direction towards the emitter.
    pub wi: Vec3,
    /// End of the shadow ray: the point on the emitter, moved off its surface; for infinite lights a point outside of the scene.
    pub target: Vec3,
    /// Radiance over pdf per solid angle (including the choice of the emitter); for points, spots and parallel light the limit
    /// of that, irradiance on a plane perpendicular to `wi` over the probability of the choice.
    pub weight: Rgb,
    /// Density per solid angle, including the choice of the emitter; 0 for points, spots and parallel light, which BSDF sampling
    /// cannot find.
    pub pdf: f32,
    /// The emitter.
    pub emitter: EmitterId,
}

/// An emitter-sampling plan: the part of a direct sample that does not depend on the receiver.
#[derive(Clone, Copy, Debug)]
pub enum EmitterPlan {
    /// An emitter with a position.
    Local {
        /// Choice of the element.
        u_choice: f32,
        /// Choice of a point on it.
        u: Vec2,
    },
    /// An infinite light.
    Infinite(InfiniteLightPlan),
}

impl Emitters {
    /// Makes a plan from random numbers in [0, 1), and prefetches memory for [`Emitters::prefetch_step`].
    #[inline]
    pub fn plan(&self, u_choice: f32, u: Vec2) -> EmitterPlan {
        let (is_infinite, u_choice) = split(u_choice, self.infinite_probability);
        if is_infinite {
            EmitterPlan::Infinite(self.infinite.plan(u_choice, u))
        } else {
            EmitterPlan::Local { u_choice, u }
        }
    }

    /// Does one of the three table lookups of an environment map, and prefetches the memory of the next one. Optional:
    /// [`Emitters::sample`] does the lookups that are left. Calls for several plans in turn hide the latency of memory.
    #[inline]
    pub fn prefetch_step(&self, plan: &mut EmitterPlan) {
        if let EmitterPlan::Infinite(plan) = plan {
            self.infinite.prefetch_step(plan);
        }
    }

    /// A direction towards an emitter for the receiving point `p` with the geometric normal `n`; `None` as a normal stands for
    /// receivers of light from all directions. Elements are chosen by the emitter tree.
    ///
    /// Visibility is not included. The result is `None` if no light arrives (behind the emitter, zero radiance). Directions below
    /// `n` have a low but positive probability, because shading normals may face them.
    pub fn sample(
        &self,
        geometry: &Geometry,
        textures: &[Texture],
        p: Vec3,
        n: Option<Vec3>,
        plan: &EmitterPlan,
    ) -> Option<DirectSample> {
        let (u_choice, u) = match plan {
            EmitterPlan::Infinite(plan) => return self.sample_infinite(p, n, plan),
            EmitterPlan::Local { u_choice, u } => (*u_choice, *u),
        };
        let (index, pmf) = self.tree.sample(p, n, u_choice)?;
        let element = self.elements.element(index);
        let pmf = pmf * (1.0 - self.infinite_probability);
        let emitter = element.emitter;
        match &self.emitters[emitter.index()] {
            Emitter::Area { radiance } => {
                let y = element.sample(geometry, textures, *radiance, p, u)?;
                let pdf = y.pdf * pmf;
                let weight = y.radiance / pdf;
                Some(DirectSample {
                    wi: y.wi,
                    target: y.target,
                    weight,
                    pdf,
                    emitter,
                })
            }
            point => {
                let ElementShape::Point { position } = element.shape else {
                    return None;
                };
                let d = position - p;
                let wi = d.try_normalize()?;
                let weight = point.point_intensity(textures, -wi) / (d.length_squared() * pmf);
                let sample = DirectSample {
                    wi,
                    target: position,
                    weight,
                    pdf: 0.0,
                    emitter,
                };
                (!weight.is_black() && weight.is_finite()).then_some(sample)
            }
        }
    }

    fn sample_infinite(
        &self,
        p: Vec3,
        n: Option<Vec3>,
        plan: &InfiniteLightPlan,
    ) -> Option<DirectSample> {
        let sample = self.infinite.sample(n, plan);
        let over_pdf = |radiance: Rgb, pdf: f32| {
            let pdf = self.infinite_probability * pdf;
            (radiance / pdf, pdf)
        };
        let (weight, pdf) = match sample.radiance {
            SampledRadiance::Parallel(irradiance) => (irradiance / self.infinite_probability, 0.0),
            SampledRadiance::Known(radiance, pdf) => over_pdf(radiance, pdf),
            SampledRadiance::LookUp => {
                let (radiance, pdf) = self.infinite.look_up(n, sample.wi);
                over_pdf(radiance, pdf)
            }
        };
        if weight.is_black() || !weight.is_finite() {
            return None;
        }
        let sphere = self.infinite.sphere();
        let far = (p - sphere.center).length() + 2.0 * sphere.radius;
        Some(DirectSample {
            wi: sample.wi,
            target: p + sample.wi * far,
            weight,
            pdf,
            emitter: sample.emitter,
        })
    }

    /// Density per solid angle of sampling the point `y` of an area emitter with [`Emitters::sample`] from (`p`, `n`).
    pub fn pdf_direct(&self, p: Vec3, n: Option<Vec3>, y: &SurfacePoint) -> f32 {
        let Some(index) = self.elements.index_at(y.at) else {
            return 0.0;
        };
        let pmf = self.tree.pmf(p, n, index) * (1.0 - self.infinite_probability);
        if pmf > 0.0 {
            pmf * self.elements.element(index).pdf(p, y)
        } else {
            0.0
        }
    }
}
