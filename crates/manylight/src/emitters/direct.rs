//! Sampling of emitters from a point: next-event estimation.

use super::Emitters;
use super::direct_lanes::DirectSamples;
use super::environment_lobes::EnvironmentLobes;
use super::receivers::Receivers;
use crate::color::Rgb;
use crate::geometry::{Geometry, SurfacePoint, SurfacePoints};
use crate::lanes::{Mask, One, Vector};
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

impl Emitters {
    /// A direction towards an emitter for the receiving point `p` with the geometric normal `n`; `None` as a normal stands for
    /// receivers of light from all directions. Elements are chosen by the emitter tree. Directions to the environment are from a mixture
    /// with the density of `lobes`, if given. The numbers `u_choice` and `u` are uniform in [0, 1).
    ///
    /// Visibility is not included. The result is `None` if no light arrives (behind the emitter, zero radiance). Directions below
    /// `n` have a low but positive probability, because shading normals may face them.
    pub fn sample(
        &self,
        geometry: &Geometry,
        textures: &[Texture],
        (p, n): (Vec3, Option<Vec3>),
        (u_choice, u): (f32, Vec2),
        lobes: Option<&EnvironmentLobes>,
    ) -> Option<DirectSample> {
        let receiver = Receivers::from((p, n));
        let numbers = (u_choice.into(), u.into());
        let (lobes, lanes) = (Some(&[lobes]), Mask::splat(One, true));
        DirectSample::of(&self.sample_lanes(geometry, textures, &receiver, numbers, lobes, lanes))
    }

    /// Radiance of the environment from the unit direction `wi` (pointing away from the scene), and the density per solid angle
    /// of sampling that direction with [`Emitters::sample`] for a receiver with normal `n`, given the same `lobes`.
    #[inline]
    pub fn environment(
        &self,
        n: Option<Vec3>,
        wi: Vec3,
        lobes: Option<&EnvironmentLobes>,
    ) -> (Rgb, f32) {
        let receiver = Receivers::from((Vec3::ZERO, n));
        let (radiance, pdf) = self.environment_lanes(&receiver, Vector::from(wi), Some(&[lobes]));
        (radiance.into(), pdf.get())
    }

    /// Density per solid angle of sampling the point `y` of an area emitter with [`Emitters::sample`] from (`p`, `n`).
    pub fn pdf_direct(&self, p: Vec3, n: Option<Vec3>, y: &SurfacePoint) -> f32 {
        let (receiver, y) = (Receivers::from((p, n)), SurfacePoints::from(y));
        let lanes = Mask::splat(One, true);
        self.pdf_direct_lanes(&receiver, &y, lanes).get()
    }
}

impl DirectSample {
    fn of(samples: &DirectSamples<One>) -> Option<Self> {
        samples.valid.any().then(|| DirectSample {
            wi: samples.wi.into(),
            target: samples.target.into(),
            weight: samples.weight.into(),
            pdf: samples.pdf.get(),
        })
    }
}
