//! A scattering model with its wrappers: weight, sides, a tilted frame. Directions are in the
//! shading frame of the surface.

use super::incident_cone::IncidentCone;
use super::lambert::Lambert;
use super::lobes::{Classes, Lobes};
use super::model::Model;
use super::model_sample::{ModelSample, Numbers};
use super::response::Response;
use super::scattering_model::{ModelBound, ScatteringModel};
use super::sides::Sides;
use super::tilt::{FACING_FRAME_PROBABILITY, Tilt, rotate};
use crate::lanes::{Axes, Color, Float, Mask, One, Pair, Vector, Width};
use crate::math::Vec3;
use crate::math::float::ONE_MINUS_EPSILON;

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
pub(super) struct Leaf<'s, S: Width> {
    pub model: Model<'s, S>,
    /// Factor of the model: the product of blend weights and opacities.
    pub weight: Float<S>,
    /// Sides of the shading frame.
    pub outer: Sides,
    pub tilt: Option<Tilt<S>>,
    /// Sides of the tilted frame.
    pub inner: Sides,
    /// The lanes in which the model's `DIFFUSE` lobe belongs to the class `GLOSSY`, because it does
    /// not have the exit transmittance of the material's `DIFFUSE` lobes around the shading normal.
    pub diffuse_is_glossy: Mask<S>,
    /// The classes of the lobes: those of the model, without lanes of weight 0.
    pub lobes: Classes<S>,
}

/// Directions in the frame of a model.
struct InModel<S: Width> {
    wi: Vector<S>,
    wo: Vector<S>,
    /// Shadowing of the tilt.
    shadowing: Float<S>,
    /// The lanes in which the model scatters from `wi` to `wo`.
    valid: Mask<S>,
}

impl<'s, S: Width> Leaf<'s, S> {
    #[inline(always)]
    pub(super) fn width(&self) -> S {
        self.weight.width()
    }

    /// Sets the field [`Leaf::lobes`].
    #[inline(always)]
    pub(super) fn set_lobes(&mut self) {
        let lobes = self.model.lobes().within(self.weight.gt(0.0));
        self.lobes = lobes.diffuse_as_glossy(self.diffuse_is_glossy);
    }

    /// `a(wi)` of the `DIFFUSE` lobe.
    #[inline(always)]
    pub(super) fn diffuse_weight(&self, wi: Vector<S>) -> Color<S> {
        let (mirror, valid) = self.outer.mirror(wi.z);
        let value = self.model.diffuse_weight(wi.scale_z(mirror)) * self.weight;
        value.within(valid & !self.diffuse_is_glossy)
    }

    /// The set of classes of the model for a set of classes of the leaf.
    #[inline(always)]
    pub(super) fn model_lobes(&self, lobes: Classes<S>) -> Classes<S> {
        let m = self.diffuse_is_glossy;
        Classes {
            diffuse: (lobes.diffuse & !m) | (lobes.glossy & m),
            ..lobes
        }
    }

    /// The lanes in which a direction of `lobes` can be sampled given `given`.
    #[inline(always)]
    pub(super) fn can_sample(&self, given: Vector<S>, lobes: Classes<S>) -> Mask<S> {
        let (_, valid) = self.outer.mirror(given.z);
        valid & self.lobes.has(lobes)
    }

    /// The weight of the leaf in the choice among leaves: an estimate of the light that `lobes`
    /// return, given the direction `given`.
    #[inline(always)]
    pub(super) fn sampling_weight(&self, given: Vector<S>, lobes: Classes<S>) -> Float<S> {
        let (outer, valid) = self.outer.mirror(given.z);
        let lobes = self.model_lobes(lobes);
        // The tilted frame may have the direction on its other side. A loop, so that the models are
        // compiled once.
        let mut cos = given.z * outer;
        let mut value = cos.same(0.0);
        for _ in 0..if self.tilt.is_some() { 2 } else { 1 } {
            let (inner, on_side) = self.inner.mirror(cos);
            let albedo = self.model.albedo_estimate(cos * inner, lobes);
            value = value.max(on_side.select(albedo, 0.0));
            cos = -cos;
        }
        valid.select(self.weight * value, 0.0)
    }

    /// `wi` and `wo` in the frame of the model.
    #[inline(always)]
    fn in_model(&self, wi: Vector<S>, wo: Vector<S>) -> InModel<S> {
        let (mirror, mut valid) = self.outer.mirror(wo.z);
        let (mut wi, mut wo) = (wi.scale_z(mirror), wo.scale_z(mirror));
        let mut shadowing = wi.z.same(1.0);
        if let Some(tilt) = &self.tilt {
            let frame = tilt.frame(tilt.facing(wo));
            let local = frame.to_local(wi);
            valid = valid & ((local.z * wi.z).gt(0.0) | !tilt.is_tilted);
            shadowing = tilt.shadowing(wi);
            wi = local;
            wo = frame.to_local(wo);
        }
        let (mirror, on_side) = self.inner.mirror(wo.z);
        InModel {
            wi: wi.scale_z(mirror),
            wo: wo.scale_z(mirror),
            shadowing,
            valid: valid & on_side,
        }
    }

    /// `f(wi → wo) |cosθ_i|` by class without the leaf's weight, with the cosine to the normal of
    /// the model, and [`Leaf::pdf`] given `wo`.
    #[inline(always)]
    pub(super) fn respond(&self, wi: Vector<S>, wo: Vector<S>, lobes: Classes<S>) -> Response<S> {
        let at = self.in_model(wi, wo);
        if at.valid.none() {
            return Response::none(self.width());
        }
        let response = self.model.respond(at.wi, at.wo, self.model_lobes(lobes));
        let mut values = response.values;
        if self.tilt.is_some() {
            values = values.map(|v| v * at.shadowing);
        }
        if self.diffuse_is_glossy.any() {
            values = values.diffuse_as_glossy(self.diffuse_is_glossy);
        }
        Response { values, ..response }.within(at.valid)
    }

    /// The leaf as Lambert's model; `None` for other models and tilted ones.
    #[inline(always)]
    pub(super) fn plain_lambert(&self, wo: Vector<S>) -> Option<Lambert<S>> {
        let Model::Diffuse(diffuse) = &self.model else {
            return None;
        };
        if self.tilt.is_some() || self.diffuse_is_glossy.any() {
            return None;
        }
        let (side, valid) = self.side(wo.z);
        Some(Lambert {
            albedo: diffuse.reflectance * self.weight,
            side,
            valid: valid & (wo.z * side).gt(0.0),
        })
    }

    /// The factor by which z is multiplied for the model of a leaf without tilt, given a direction
    /// with the coordinate `z`, and the lanes on a side with scattering.
    #[inline(always)]
    fn side(&self, z: Float<S>) -> (Float<S>, Mask<S>) {
        let (outer, on_outer) = self.outer.mirror(z);
        let (inner, on_inner) = self.inner.mirror(z * outer);
        (outer * inner, on_outer & on_inner)
    }

    /// Density of sampling `other` given `given` with [`Leaf::sample`].
    #[inline(always)]
    pub(super) fn pdf(
        &self,
        end: Given,
        given: Vector<S>,
        other: Vector<S>,
        lobes: Classes<S>,
    ) -> Float<S> {
        let (mirror, valid) = self.outer.mirror(given.z);
        let (given, other) = (given.scale_z(mirror), other.scale_z(mirror));
        let lobes = self.model_lobes(lobes);
        let n = self.tilt.map_or(given, |tilt| tilt.facing(given));
        // Given `wi`, either of two frames is sampled. A loop, so that the models are compiled
        // once.
        let both = [
            (n, FACING_FRAME_PROBABILITY),
            (rotate(n), 1.0 - FACING_FRAME_PROBABILITY),
        ];
        let one = [(n, 1.0)];
        let frames: &[(Vector<S>, f32)] = match (&self.tilt, end) {
            (Some(_), Given::Wi) => &both,
            _ => &one,
        };
        let mut sum = given.z.same(0.0);
        for &(n, probability) in frames {
            let pdf = match &self.tilt {
                None => self.inner_pdf(given, other, lobes),
                Some(tilt) => {
                    let frame = tilt.frame(n);
                    let local = frame.to_local(other);
                    let agrees = (local.z * other.z).gt(0.0) | !tilt.is_tilted;
                    let pdf = self.inner_pdf(frame.to_local(given), local, lobes);
                    match end {
                        Given::Wo => agrees.select(pdf, 0.0),
                        Given::Wi => pdf,
                    }
                }
            };
            sum += probability * pdf;
        }
        valid.select(sum, 0.0)
    }

    /// Density in the tilted frame (or the shading frame without tilt).
    #[inline(always)]
    fn inner_pdf(&self, given: Vector<S>, other: Vector<S>, lobes: Classes<S>) -> Float<S> {
        let (mirror, valid) = self.inner.mirror(given.z);
        let (given, other) = (given.scale_z(mirror), other.scale_z(mirror));
        valid.select(self.model.pdf(given, other, lobes), 0.0)
    }

    /// Samples the other direction. The leaf's weight is not in the fraction of delta events.
    #[inline(always)]
    pub(super) fn sample(
        &self,
        end: Given,
        given: Vector<S>,
        u: Numbers<S>,
        lobes: Classes<S>,
    ) -> ModelSample<S> {
        let (outer, valid) = self.outer.mirror(given.z);
        let given = given.scale_z(outer);
        let lobes = self.model_lobes(lobes);
        let tilted = self.tilt.as_ref().map(|tilt| match end {
            Given::Wo => FrameChoice::facing(tilt, given, u),
            Given::Wi => FrameChoice::either(tilt, given, u),
        });
        let (local, u) = match &tilted {
            None => (given, u),
            Some(choice) => (choice.frame.to_local(given), choice.u),
        };
        let (mirror, on_side) = self.inner.mirror(local.z);
        let mut sample = self.model.sample(local.scale_z(mirror), u, lobes);
        sample.w = sample.w.scale_z(mirror);
        sample.valid = sample.valid & on_side;
        if let (Some(tilt), Some(choice)) = (&self.tilt, &tilted) {
            sample = choice.complete(tilt, end, given, sample);
        }
        ModelSample {
            w: sample.w.scale_z(outer),
            valid: sample.valid & valid,
            ..sample
        }
    }
}

/// The frame of a tilt in which a direction is sampled.
struct FrameChoice<S: Width> {
    frame: Axes<S>,
    /// Probability of this frame.
    probability: Float<S>,
    /// Numbers that are uniform given the frame.
    u: Numbers<S>,
}

impl<S: Width> FrameChoice<S> {
    /// The frame that faces `wo`.
    #[inline(always)]
    fn facing(tilt: &Tilt<S>, wo: Vector<S>, u: Numbers<S>) -> Self {
        FrameChoice {
            frame: tilt.frame(tilt.facing(wo)),
            probability: wo.z.same(1.0),
            u,
        }
    }

    /// Given `wi`, the frame depends on the sampled direction, so each of the two has a positive
    /// probability.
    #[inline(always)]
    fn either(tilt: &Tilt<S>, wi: Vector<S>, u: Numbers<S>) -> Self {
        let facing = tilt.facing(wi);
        let x = u.direction.x;
        let faces = x.lt(FACING_FRAME_PROBABILITY);
        let n = Vector::select(faces, facing, rotate(facing));
        let probability = faces.select(FACING_FRAME_PROBABILITY, 1.0 - FACING_FRAME_PROBABILITY);
        let x = (x - faces.select(0.0, FACING_FRAME_PROBABILITY)) / probability;
        let direction = Pair::new(x.min(ONE_MINUS_EPSILON), u.direction.y);
        FrameChoice {
            frame: tilt.frame(n),
            probability,
            u: Numbers { direction, ..u },
        }
    }

    /// The sample in the shading frame.
    #[inline(always)]
    fn complete(
        &self,
        tilt: &Tilt<S>,
        end: Given,
        given: Vector<S>,
        sample: ModelSample<S>,
    ) -> ModelSample<S> {
        let w = self.frame.to_world(sample.w);
        let (wi, agrees) = match end {
            Given::Wo => (w, (sample.w.z * w.z).gt(0.0) | !tilt.is_tilted),
            // A delta lobe exists only in the frame that its own direction selects.
            Given::Wi => {
                let (n, seen) = (self.frame.n, tilt.facing(w));
                let selects = seen.x.equals(n.x) & seen.y.equals(n.y);
                let faces = (n.dot(given) * given.z).gt(0.0);
                (given, !sample.is_delta | (selects & faces))
            }
        };
        ModelSample {
            w,
            fraction: sample.fraction * tilt.shadowing(wi),
            probability: sample.probability * self.probability,
            valid: sample.valid & agrees,
            ..sample
        }
    }
}

impl<'s> Leaf<'s, One> {
    /// The leaf in all lanes.
    #[inline(always)]
    pub(super) fn in_lanes<S: Width>(&self, s: S) -> Leaf<'s, S> {
        Leaf {
            model: self.model.in_lanes(s),
            weight: self.weight.in_lanes(s),
            outer: self.outer,
            tilt: self.tilt.map(|tilt| tilt.in_lanes(s)),
            inner: self.inner,
            diffuse_is_glossy: self.diffuse_is_glossy.in_lanes(s),
            lobes: self.lobes.in_lanes(s),
        }
    }

    /// Upper bound of all channels of `f(wi → wo) |cosθ_i|` times the projected cosine of
    /// `leaving`, over the directions `wo` in that cone. It uses the reciprocity of the model.
    pub(super) fn bound_leaving(&self, wi: Vec3, leaving: &IncidentCone, lobes: Lobes) -> f32 {
        let Some(tilt) = self.tilted() else {
            return self.bound(leaving, wi, lobes) * wi.z.abs();
        };
        let Some(outer) = mirror(self.outer, wi.z) else {
            return 0.0;
        };
        let (wi, leaving) = (mirrored(outer)(wi), leaving.map(mirrored(outer)));
        // The frame depends on `wo`, so both count. The projected cosine is not to either tilted
        // normal.
        let leaving = IncidentCone {
            projected: Some(leaving.projected.unwrap_or(1.0)),
            ..leaving
        };
        let within = |normal: Vector<One>| {
            let frame = tilt.frame(normal);
            let local = Vec3::from(frame.to_local(wi.into()));
            let Some(inner) = mirror(self.inner, local.z) else {
                return 0.0;
            };
            let leaving = leaving.map(|w| mirrored(inner)(frame.to_local(w.into()).into()));
            let local = mirrored(inner)(local);
            let lobes = self.model_lobes(lobes.into()).get();
            let bound = self.model.bound(&leaving, local, lobes);
            self.weight.get() * bound * local.z.abs()
        };
        within(tilt.normal()).max(within(tilt.rotated()))
    }

    /// Upper bound of all channels of the values over a cone of `wi`, without the shadowing of
    /// tilts.
    pub(super) fn bound(&self, incident: &IncidentCone, mut wo: Vec3, lobes: Lobes) -> f32 {
        let Some(outer) = mirror(self.outer, wo.z) else {
            return 0.0;
        };
        let mut incident = incident.map(mirrored(outer));
        wo.z *= outer;
        if let Some(tilt) = self.tilted() {
            let frame = tilt.frame(tilt.facing(wo.into()));
            incident = incident.map(|w| frame.to_local(w.into()).into());
            wo = frame.to_local(wo.into()).into();
        }
        let Some(inner) = mirror(self.inner, wo.z) else {
            return 0.0;
        };
        wo.z *= inner;
        let incident = incident.map(mirrored(inner));
        let lobes = self.model_lobes(lobes.into()).get();
        self.weight.get() * self.model.bound(&incident, wo, lobes)
    }

    /// The tilt, if the normal is not the shading normal.
    #[inline]
    pub(super) fn tilted(&self) -> Option<&Tilt<One>> {
        self.tilt.as_ref().filter(|tilt| tilt.is_tilted.any())
    }
}

/// [`Sides::mirror`] for one direction.
#[inline]
fn mirror(sides: Sides, z: f32) -> Option<f32> {
    let (factor, valid) = sides.mirror::<One>(z.into());
    valid.any().then_some(factor.get())
}

/// Multiplies the z coordinate.
fn mirrored(factor: f32) -> impl Fn(Vec3) -> Vec3 {
    move |w| Vec3::new(w.x, w.y, w.z * factor)
}
