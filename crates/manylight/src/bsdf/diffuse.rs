//! Lambertian reflection.

use super::bound::Arriving;
use super::model::ModelSample;
use super::{BsdfNumbers, Lobes};
use crate::color::Rgb;
use crate::math::Vec3;
use crate::sampling::warp;
use std::f32::consts::FRAC_1_PI;

/// One-sided Lambertian reflection: `f = ρ / π`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Diffuse {
    pub reflectance: Rgb,
}

impl Diffuse {
    #[inline]
    pub(super) fn lobes(&self) -> Lobes {
        Lobes::DIFFUSE
    }

    #[inline]
    pub(super) fn eval(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        if !lobes.has(Lobes::DIFFUSE) || wi.z <= 0.0 || wo.z <= 0.0 {
            return Rgb::BLACK;
        }
        self.reflectance * (wi.z * FRAC_1_PI)
    }

    #[inline]
    pub(super) fn bound(&self, arriving: &Arriving, wo: Vec3, lobes: Lobes) -> f32 {
        if !lobes.has(Lobes::DIFFUSE) || wo.z <= 0.0 {
            return 0.0;
        }
        let [_, cos] = arriving.cosines();
        if cos <= 0.0 {
            return 0.0;
        }
        self.reflectance.max_channel() * arriving.projection(cos) * FRAC_1_PI
    }

    #[inline]
    pub(super) fn pdf(&self, given: Vec3, other: Vec3, _lobes: Lobes) -> f32 {
        if given.z <= 0.0 {
            0.0
        } else {
            warp::cosine_hemisphere_pdf(other.z)
        }
    }

    #[inline]
    pub(super) fn sample(&self, given: Vec3, u: BsdfNumbers, _lobes: Lobes) -> Option<ModelSample> {
        (given.z > 0.0).then(|| ModelSample::finite(warp::cosine_hemisphere(u.direction)))
    }

    #[inline]
    pub(super) fn diffuse_weight(&self, wi: Vec3) -> Rgb {
        if wi.z > 0.0 {
            self.reflectance
        } else {
            Rgb::BLACK
        }
    }
}
