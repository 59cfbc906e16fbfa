//! A scattering model with its wrappers: weight, sides, a tilted frame. Directions are in the shading frame of the surface.

use super::incident_cone::IncidentCone;
use super::lambert::Lambert;
use super::model::Model;
use super::model_sample::ModelSample;
use super::response::Response;
use super::sides::Sides;
use super::tilt::{FACING_FRAME_PROBABILITY, Tilt};
use super::{BsdfNumbers, LARGEST, Lobes};
use crate::color::Rgb;
use crate::math::{Frame, Vec3};

/// The given direction of a scattering event; the other one is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Given {
    /// The direction in which light leaves: camera walks.
    Wo,
    /// The direction from which light arrives: photon walks.
    Wi,
}

/// A model with its wrappers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf<'s> {
    pub model: Model<'s>,
    /// Factor of the model: the product of blend weights and opacities.
    pub weight: f32,
    /// Sides of the shading frame.
    pub outer: Sides,
    pub tilt: Option<Tilt>,
    /// Sides of the tilted frame.
    pub inner: Sides,
    /// Whether the model's `DIFFUSE` lobe belongs to the class `GLOSSY`, because it does not have the exit transmittance of the material's
    /// `DIFFUSE` lobes around the shading normal.
    pub diffuse_is_glossy: bool,
}

impl Leaf<'_> {
    /// The classes of the leaf's lobes.
    #[inline]
    pub(super) fn lobes(&self) -> Lobes {
        let lobes = self.model.lobes();
        if self.diffuse_is_glossy && lobes.has(Lobes::DIFFUSE) {
            return Lobes(lobes.0 & !Lobes::DIFFUSE.0).or(Lobes::GLOSSY);
        }
        lobes
    }

    /// `a(wi)` of the `DIFFUSE` lobe.
    #[inline]
    pub(super) fn diffuse_weight(&self, mut wi: Vec3) -> Rgb {
        match self.outer.mirror(wi.z) {
            Some(mirror) if !self.diffuse_is_glossy => {
                wi.z *= mirror;
                self.model.diffuse_weight(wi) * self.weight
            }
            _ => Rgb::BLACK,
        }
    }

    /// The set of classes of the model for a set of classes of the leaf.
    #[inline]
    fn model_lobes(&self, lobes: Lobes) -> Lobes {
        if !self.diffuse_is_glossy {
            return lobes;
        }
        let rest = Lobes(lobes.0 & !Lobes::DIFFUSE.0);
        if lobes.has(Lobes::GLOSSY) {
            rest.or(Lobes::DIFFUSE)
        } else {
            rest
        }
    }

    /// Whether a direction of `lobes` can be sampled given `given`.
    #[inline]
    pub(super) fn can_sample(&self, given: Vec3, lobes: Lobes) -> bool {
        self.outer.mirror(given.z).is_some() && self.lobes().has(lobes)
    }

    /// The weight of the leaf in the choice among leaves: an estimate of the light that `lobes` return, given the direction `given`.
    pub(super) fn sampling_weight(&self, given: Vec3, lobes: Lobes) -> f32 {
        let Some(outer) = self.outer.mirror(given.z) else {
            return 0.0;
        };
        let lobes = self.model_lobes(lobes);
        let albedo = |cos: f32| {
            let inner = self.inner.mirror(cos);
            inner.map_or(0.0, |inner| self.model.albedo_estimate(cos * inner, lobes))
        };
        let cos = given.z * outer;
        // The tilted frame may have the direction on its other side.
        let value = match self.tilt {
            None => albedo(cos),
            Some(_) => albedo(cos).max(albedo(-cos)),
        };
        self.weight * value
    }

    /// `wi` and `wo` in the frame of the model, and the shadowing of the tilt. `None` if the model does not scatter from `wi` to `wo`.
    #[inline]
    fn in_model(&self, mut wi: Vec3, mut wo: Vec3) -> Option<(Vec3, Vec3, f32)> {
        let mirror = self.outer.mirror(wo.z)?;
        wi.z *= mirror;
        wo.z *= mirror;
        let mut shadowing = 1.0;
        if let Some(tilt) = &self.tilt {
            let frame = tilt.frame(tilt.facing(wo));
            let local = frame.to_local(wi);
            if local.z * wi.z <= 0.0 {
                return None;
            }
            shadowing = tilt.shadowing(wi);
            wi = local;
            wo = frame.to_local(wo);
        }
        let mirror = self.inner.mirror(wo.z)?;
        wi.z *= mirror;
        wo.z *= mirror;
        Some((wi, wo, shadowing))
    }

    /// `f(wi → wo) |cosθ_i|` of the leaf, with the cosine to the normal of the model.
    #[inline]
    pub(super) fn eval(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        let Some((wi, wo, shadowing)) = self.in_model(wi, wo) else {
            return Rgb::BLACK;
        };
        self.model.eval(wi, wo, self.model_lobes(lobes)) * (self.weight * shadowing)
    }

    /// Upper bound of all channels of `f(wi → wo) |cosθ_i|` times the projected cosine of `leaving`, over the directions `wo` in that
    /// cone. It uses the reciprocity of the model.
    pub(super) fn bound_leaving(&self, wi: Vec3, leaving: &IncidentCone, lobes: Lobes) -> f32 {
        let Some(tilt) = &self.tilt else {
            return self.bound(leaving, wi, lobes) * wi.z.abs();
        };
        let Some(outer) = self.outer.mirror(wi.z) else {
            return 0.0;
        };
        let mirrored = |mirror: f32| move |w: Vec3| Vec3::new(w.x, w.y, w.z * mirror);
        let (wi, leaving) = (mirrored(outer)(wi), leaving.map(mirrored(outer)));
        // The frame depends on `wo`, so both count. The projected cosine is not to either tilted normal.
        let leaving = IncidentCone {
            projected: Some(leaving.projected.unwrap_or(1.0)),
            ..leaving
        };
        let within = |normal: Vec3| {
            let frame = tilt.frame(normal);
            let local = frame.to_local(wi);
            let Some(inner) = self.inner.mirror(local.z) else {
                return 0.0;
            };
            let leaving = leaving.map(|w| mirrored(inner)(frame.to_local(w)));
            let local = mirrored(inner)(local);
            let bound = self.model.bound(&leaving, local, self.model_lobes(lobes));
            self.weight * bound * local.z.abs()
        };
        within(tilt.normal()).max(within(tilt.rotated()))
    }

    /// Upper bound of all channels of [`Leaf::eval`] over a cone of `wi`, without the shadowing of tilts.
    pub(super) fn bound(&self, incident: &IncidentCone, mut wo: Vec3, lobes: Lobes) -> f32 {
        let mirrored = |mirror: f32| move |w: Vec3| Vec3::new(w.x, w.y, w.z * mirror);
        let Some(outer) = self.outer.mirror(wo.z) else {
            return 0.0;
        };
        let mut incident = incident.map(mirrored(outer));
        wo.z *= outer;
        if let Some(tilt) = &self.tilt {
            let frame = tilt.frame(tilt.facing(wo));
            incident = incident.map(|w| frame.to_local(w));
            wo = frame.to_local(wo);
        }
        let Some(inner) = self.inner.mirror(wo.z) else {
            return 0.0;
        };
        wo.z *= inner;
        let incident = incident.map(mirrored(inner));
        self.weight * self.model.bound(&incident, wo, self.model_lobes(lobes))
    }

    /// [`Leaf::eval`] by class without the leaf's weight, and [`Leaf::pdf`] given `wo`.
    #[inline]
    pub(super) fn respond(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Response {
        let Some((wi, wo, shadowing)) = self.in_model(wi, wo) else {
            return Response::NONE;
        };
        let mut response = self.model.respond(wi, wo, self.model_lobes(lobes));
        response.values.scale(shadowing);
        if self.diffuse_is_glossy {
            response.values.move_diffuse_to_glossy();
        }
        response
    }

    /// The leaf as Lambert's model; `None` for other models and tilted ones, and on a black side.
    #[inline]
    pub(super) fn plain_lambert(&self, wo: Vec3) -> Option<Lambert> {
        let Model::Diffuse(diffuse) = &self.model else {
            return None;
        };
        if self.tilt.is_some() || self.diffuse_is_glossy {
            return None;
        }
        let side = self.side(wo.z)?;
        (wo.z * side > 0.0).then_some(Lambert {
            albedo: diffuse.reflectance * self.weight,
            side,
        })
    }

    /// The factor by which z is multiplied for the model of a leaf without tilt, given a direction with the coordinate `z`. `None`
    /// on a side without scattering.
    #[inline]
    pub(super) fn side(&self, z: f32) -> Option<f32> {
        let outer = self.outer.mirror(z)?;
        Some(outer * self.inner.mirror(z * outer)?)
    }

    /// Density of sampling `other` given `given` with [`Leaf::sample`].
    #[inline]
    pub(super) fn pdf(&self, end: Given, mut given: Vec3, mut other: Vec3, lobes: Lobes) -> f32 {
        let Some(mirror) = self.outer.mirror(given.z) else {
            return 0.0;
        };
        given.z *= mirror;
        other.z *= mirror;
        let lobes = self.model_lobes(lobes);
        let Some(tilt) = &self.tilt else {
            return self.inner_pdf(given, other, lobes);
        };
        let pdf_about = |n: Vec3| {
            let frame = tilt.frame(n);
            let local = frame.to_local(other);
            if end == Given::Wo && local.z * other.z <= 0.0 {
                return 0.0;
            }
            self.inner_pdf(frame.to_local(given), local, lobes)
        };
        match end {
            Given::Wo => pdf_about(tilt.facing(given)),
            Given::Wi => {
                let facing = tilt.facing(given);
                let rotated = Vec3::new(-facing.x, -facing.y, facing.z);
                FACING_FRAME_PROBABILITY * pdf_about(facing)
                    + (1.0 - FACING_FRAME_PROBABILITY) * pdf_about(rotated)
            }
        }
    }

    /// Density in the tilted frame (or the shading frame without tilt).
    #[inline]
    fn inner_pdf(&self, mut given: Vec3, mut other: Vec3, lobes: Lobes) -> f32 {
        let Some(mirror) = self.inner.mirror(given.z) else {
            return 0.0;
        };
        given.z *= mirror;
        other.z *= mirror;
        self.model.pdf(given, other, lobes)
    }

    /// Samples the other direction. The leaf's weight is not in the fraction of delta events.
    pub(super) fn sample(
        &self,
        end: Given,
        mut given: Vec3,
        u: BsdfNumbers,
        lobes: Lobes,
    ) -> Option<ModelSample> {
        let outer = self.outer.mirror(given.z)?;
        given.z *= outer;
        let lobes = self.model_lobes(lobes);
        let mut sample = match (&self.tilt, end) {
            (None, _) => self.inner_sample(given, u, lobes),
            (Some(tilt), Given::Wo) => self.sample_tilted_wi(tilt, given, u, lobes),
            (Some(tilt), Given::Wi) => self.sample_tilted_wo(tilt, given, u, lobes),
        }?;
        sample.w.z *= outer;
        Some(sample)
    }

    /// Samples in the tilted frame (or the shading frame without tilt).
    fn inner_sample(&self, mut given: Vec3, u: BsdfNumbers, lobes: Lobes) -> Option<ModelSample> {
        let mirror = self.inner.mirror(given.z)?;
        given.z *= mirror;
        let mut sample = self.model.sample(given, u, lobes)?;
        sample.w.z *= mirror;
        Some(sample)
    }

    /// Samples in a tilted frame. Also returns the direction in that frame.
    fn sample_in(
        &self,
        frame: &Frame,
        given: Vec3,
        u: BsdfNumbers,
        lobes: Lobes,
    ) -> Option<(ModelSample, Vec3)> {
        let mut sample = self.inner_sample(frame.to_local(given), u, lobes)?;
        let local = sample.w;
        sample.w = frame.to_world(local);
        Some((sample, local))
    }

    fn sample_tilted_wi(
        &self,
        tilt: &Tilt,
        wo: Vec3,
        u: BsdfNumbers,
        lobes: Lobes,
    ) -> Option<ModelSample> {
        let frame = tilt.frame(tilt.facing(wo));
        let (mut sample, local) = self.sample_in(&frame, wo, u, lobes)?;
        if local.z * sample.w.z <= 0.0 {
            return None;
        }
        if let Some(delta) = &mut sample.delta {
            delta.fraction *= tilt.shadowing(sample.w);
        }
        Some(sample)
    }

    /// The frame depends on the sampled direction, so each of the two has a positive probability.
    fn sample_tilted_wo(
        &self,
        tilt: &Tilt,
        wi: Vec3,
        mut u: BsdfNumbers,
        lobes: Lobes,
    ) -> Option<ModelSample> {
        let facing = tilt.facing(wi);
        let (n, probability) = if u.direction.x < FACING_FRAME_PROBABILITY {
            u.direction.x /= FACING_FRAME_PROBABILITY;
            (facing, FACING_FRAME_PROBABILITY)
        } else {
            u.direction.x =
                (u.direction.x - FACING_FRAME_PROBABILITY) / (1.0 - FACING_FRAME_PROBABILITY);
            (
                Vec3::new(-facing.x, -facing.y, facing.z),
                1.0 - FACING_FRAME_PROBABILITY,
            )
        };
        u.direction.x = u.direction.x.min(LARGEST);
        let (mut sample, _) = self.sample_in(&tilt.frame(n), wi, u, lobes)?;
        if let Some(delta) = &mut sample.delta {
            // A delta lobe exists only in the frame that its own direction selects.
            if tilt.facing(sample.w) != n || n.dot(wi) * wi.z <= 0.0 {
                return None;
            }
            delta.probability *= probability;
            delta.fraction *= tilt.shadowing(wi);
        }
        Some(sample)
    }
}
