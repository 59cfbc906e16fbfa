//! Sampling of emitters from a point: next-event estimation.

use super::Emitters;
use super::description::Emitter;
use super::elements::ElementShape;
use super::environment_lobes::EnvironmentLobes;
use super::infinite::{InfiniteLightPlan, SampledRadiance};
use super::unit_interval::split;
use crate::color::Rgb;
use crate::geometry::{Geometry, SurfacePoint};
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
}

/// Fraction of the samples of infinite lights that are guided, where there is a guide. Measured at 0.5, 0.75 and 0.9, over 4 passes of
/// an interior lit through its windows: the variance of direct light is 0.0191, 0.0182 and 0.0177 of relMSE, and 0.0251 if half
/// of the directions are guided instead. In a second interior it is 0.0045, 0.0046, 0.0050, and 0.0045.
const GUIDED_FRACTION: f32 = 0.75;

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
            EmitterPlan::Infinite(plan) => return self.sample_infinite((p, n), plan, None),
            EmitterPlan::Local { u_choice, u } => (*u_choice, *u),
        };
        let (index, pmf) = self.tree.sample(p, n, u_choice)?;
        let element = self.elements.element(index);
        let pmf = pmf * (1.0 - self.infinite_probability);
        match &self.emitters[element.emitter.index()] {
            Emitter::Area { radiance } => {
                let y = element.sample(geometry, textures, *radiance, p, u)?;
                let pdf = y.pdf * pmf;
                let weight = y.radiance / pdf;
                Some(DirectSample {
                    wi: y.wi,
                    target: y.target,
                    weight,
                    pdf,
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
                };
                (!weight.is_black() && weight.is_finite()).then_some(sample)
            }
        }
    }

    /// As [`Emitters::sample`], with directions to the environment from a mixture with the density of `lobes`; `u_choice` and `u`
    /// are uniform in [0, 1).
    pub fn sample_guided(
        &self,
        geometry: &Geometry,
        textures: &[Texture],
        (p, n): (Vec3, Option<Vec3>),
        lobes: &EnvironmentLobes,
        (u_choice, u): (f32, Vec2),
    ) -> Option<DirectSample> {
        let (is_infinite, u_infinite) = split(u_choice, self.infinite_probability);
        if !is_infinite {
            return self.sample(geometry, textures, p, n, &self.plan(u_choice, u));
        }
        let (is_guided, u_choice) = split(u_infinite, GUIDED_FRACTION);
        if !is_guided {
            let plan = self.infinite.plan(u_choice, u);
            return self.sample_infinite((p, n), &plan, Some(lobes));
        }
        let wi = lobes.sample(u_choice, u);
        let (radiance, pdf) = self.environment(n, wi, Some(lobes));
        self.towards_infinity(p, wi, radiance / pdf, pdf)
    }

    fn sample_infinite(
        &self,
        (p, n): (Vec3, Option<Vec3>),
        plan: &InfiniteLightPlan,
        lobes: Option<&EnvironmentLobes>,
    ) -> Option<DirectSample> {
        let sample = self.infinite.sample(n, plan);
        let (weight, pdf) = match sample.radiance {
            SampledRadiance::Parallel(irradiance) => {
                let unguided = lobes.map_or(1.0, |_| 1.0 - GUIDED_FRACTION);
                (irradiance / (unguided * self.infinite_probability), 0.0)
            }
            SampledRadiance::Known(radiance, pdf) => {
                let pdf = self.environment_pdf(sample.wi, pdf, lobes);
                (radiance / pdf, pdf)
            }
            SampledRadiance::LookUp => {
                let (radiance, pdf) = self.environment(n, sample.wi, lobes);
                (radiance / pdf, pdf)
            }
        };
        self.towards_infinity(p, sample.wi, weight, pdf)
    }

    /// A sample in the direction `wi` to an infinite light.
    fn towards_infinity(&self, p: Vec3, wi: Vec3, weight: Rgb, pdf: f32) -> Option<DirectSample> {
        if weight.is_black() || !weight.is_finite() {
            return None;
        }
        let sphere = self.infinite.sphere();
        let far = (p - sphere.center).length() + 2.0 * sphere.radius;
        Some(DirectSample {
            wi,
            target: p + wi * far,
            weight,
            pdf,
        })
    }

    /// Radiance of the environment from the unit direction `wi` (pointing away from the scene), and the density per solid angle
    /// of sampling that direction for a receiver with normal `n`: with [`Emitters::sample`], or with
    /// [`Emitters::sample_guided`] where there are `lobes`.
    #[inline]
    pub fn environment(
        &self,
        n: Option<Vec3>,
        wi: Vec3,
        lobes: Option<&EnvironmentLobes>,
    ) -> (Rgb, f32) {
        let (radiance, pdf) = self.infinite.look_up(n, wi);
        (radiance, self.environment_pdf(wi, pdf, lobes))
    }

    /// Density of sampling the direction `wi` in 1/sr, where infinite lights without lobes have the density `pdf`.
    #[inline]
    fn environment_pdf(&self, wi: Vec3, pdf: f32, lobes: Option<&EnvironmentLobes>) -> f32 {
        let guided = lobes.map_or(pdf, |lobes| pdf + GUIDED_FRACTION * (lobes.pdf(wi) - pdf));
        self.infinite_probability * guided
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
