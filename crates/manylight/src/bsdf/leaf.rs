//! One scattering model with what wraps it: weight, sides, a tilted frame. Directions here are in the shading frame of the surface.

use super::bound::Arriving;
use super::model::{Model, ModelSample};
use super::response::Response;
use super::{BsdfNumbers, BsdfSample, LARGEST, Lobes};
use crate::color::Rgb;
use crate::math::{Frame, Vec2, Vec3};
use crate::sampling::warp;

/// Which sides of a frame a model answers to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sides {
    /// The model decides.
    Own,
    /// The side of the normal.
    Front,
    /// The other side; the model sees the surface mirrored.
    Back,
    /// Both, the other one mirrored.
    Both,
}

impl Sides {
    /// The factor of z for a direction with the given z, or `None` on a side that the model does not answer to.
    #[inline]
    fn mirror(self, z: f32) -> Option<f32> {
        match self {
            Sides::Own => Some(1.0),
            Sides::Front => (z > 0.0).then_some(1.0),
            Sides::Back => (z < 0.0).then_some(-1.0),
            Sides::Both => Some(1.0f32.copysign(z)),
        }
    }
}

/// Which end of a scattering event is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Given {
    /// Where light goes: a camera walk.
    Wo,
    /// Where light comes from: a photon walk.
    Wi,
}

/// A tilt of the normal by a bump or normal map, in the shading frame.
///
/// Where the tilted normal faces away from the viewer it is turned about the old one by 180 degrees (Schüssler et al.,
/// "Microfacet-based Normal Mapping", 2017), so the frame depends on `wo`; light is attenuated towards the horizon (Conty Estevez
/// et al., "A Microfacet-Based Shadowing Function to Solve the Bump Terminator Problem", 2019). Both as in Mitsuba 3.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tilt {
    normal: Vec3,
    /// What the x axis of the tilted frame follows.
    tangent: Vec3,
}

/// How often a photon walk samples the frame that its own direction suggests, rather than the turned one.
const LIKELY_FRAME: f32 = 0.75;

impl Tilt {
    /// From the unit normal in the shading frame; `None` where nothing is tilted.
    pub(super) fn new(normal: Vec3, tangent: Vec3) -> Option<Self> {
        (normal.is_finite() && normal.truncate() != Vec2::ZERO).then_some(Tilt { normal, tangent })
    }

    /// The tilted normal, not turned.
    pub(super) fn normal(&self) -> Vec3 {
        self.normal
    }

    /// A normal given in the tilted frame, in the shading frame.
    pub(super) fn within(&self, normal: Vec3) -> Vec3 {
        self.frame(self.normal).to_world(normal)
    }

    fn turned(&self) -> Vec3 {
        Vec3::new(-self.normal.x, -self.normal.y, self.normal.z)
    }

    /// The normal that a viewer along `w` sees.
    #[inline]
    fn facing(&self, w: Vec3) -> Vec3 {
        if w.z * self.normal.dot(w) <= 0.0 {
            self.turned()
        } else {
            self.normal
        }
    }

    fn frame(&self, n: Vec3) -> Frame {
        let s = (self.tangent - n * n.dot(self.tangent))
            .try_normalize()
            .unwrap_or(Vec3::Y);
        Frame {
            s,
            t: n.cross(s),
            n,
        }
    }

    /// Fraction of light from `wi` that the bumps let through.
    #[inline]
    fn shadowing(&self, wi: Vec3) -> f32 {
        let tan2 = |w: Vec3| (1.0 - w.z * w.z).max(0.0) / (w.z * w.z).max(f32::MIN_POSITIVE);
        let alpha2 = (0.125 * tan2(self.normal)).min(1.0);
        2.0 / (1.0 + (1.0 + alpha2 * tan2(wi)).sqrt())
    }
}

/// Lambertian reflection on one side of the shading frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lambert {
    pub albedo: Rgb,
    /// Sign of z on that side.
    pub side: f32,
}

impl Lambert {
    /// Density of cosine-distributed directions, and `f cosθ` over the albedo.
    #[inline]
    pub(super) fn pdf(&self, w: Vec3) -> f32 {
        warp::cosine_hemisphere_pdf(w.z * self.side)
    }

    /// A cosine-distributed direction; all of them carry the albedo.
    #[inline]
    pub(super) fn sample(&self, frame: &Frame, u: Vec2) -> Option<BsdfSample> {
        let mut w = warp::cosine_hemisphere(u);
        let pdf = warp::cosine_hemisphere_pdf(w.z);
        w.z *= self.side;
        (pdf > 0.0 && !self.albedo.is_black()).then(|| BsdfSample {
            w: frame.to_world(w),
            weight: self.albedo,
            pdf,
            lobe: Lobes::DIFFUSE,
            eta: 1.0,
        })
    }
}

/// A model as part of a material.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf<'s> {
    pub model: Model<'s>,
    /// Share of the material, opacity included.
    pub weight: f32,
    /// Sides of the surface.
    pub outer: Sides,
    pub tilt: Option<Tilt>,
    /// Sides of the tilted frame.
    pub inner: Sides,
    /// Set where the model's `DIFFUSE` lobe is not of the form that the class promises for the whole material:
    /// it then counts as `GLOSSY`.
    pub demoted: bool,
}

impl Leaf<'_> {
    /// The classes of the leaf's lobes.
    #[inline]
    pub(super) fn lobes(&self) -> Lobes {
        let lobes = self.model.lobes();
        if self.demoted && lobes.has(Lobes::DIFFUSE) {
            return Lobes(lobes.0 & !Lobes::DIFFUSE.0).or(Lobes::GLOSSY);
        }
        lobes
    }

    /// `a(wi)` of the `DIFFUSE` lobe.
    #[inline]
    pub(super) fn diffuse_weight(&self, mut wi: Vec3) -> Rgb {
        match self.outer.mirror(wi.z) {
            Some(mirror) if !self.demoted => {
                wi.z *= mirror;
                self.model.diffuse_weight(wi) * self.weight
            }
            _ => Rgb::BLACK,
        }
    }

    /// The model's classes for a set of the material's.
    #[inline]
    fn model_lobes(&self, lobes: Lobes) -> Lobes {
        if !self.demoted {
            return lobes;
        }
        let rest = Lobes(lobes.0 & !Lobes::DIFFUSE.0);
        if lobes.has(Lobes::GLOSSY) {
            rest.or(Lobes::DIFFUSE)
        } else {
            rest
        }
    }

    /// Whether sampling from `given` can give anything of `lobes`.
    #[inline]
    pub(super) fn answers(&self, given: Vec3, lobes: Lobes) -> bool {
        self.outer.mirror(given.z).is_some() && self.lobes().has(lobes)
    }

    /// `wi` and `wo` in the frame of the model, and how much the tilt shadows. `None`: no light goes this way.
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

    /// `f(wi → wo) |cosθ_i|` with the cosine to the model's normal.
    #[inline]
    pub(super) fn eval(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        let Some((wi, wo, shadowing)) = self.in_model(wi, wo) else {
            return Rgb::BLACK;
        };
        self.model.eval(wi, wo, self.model_lobes(lobes)) * (self.weight * shadowing)
    }

    /// Upper bound of every channel of `f(wi → wo) |cosθ_i|` times the projection of `leaving`, over the directions `wo` in that cone.
    pub(super) fn bound_leaving(&self, wi: Vec3, leaving: &Arriving, lobes: Lobes) -> f32 {
        let Some(tilt) = &self.tilt else {
            return self.bound(leaving, wi, lobes) * wi.z.abs();
        };
        let Some(outer) = self.outer.mirror(wi.z) else {
            return 0.0;
        };
        let mirrored = |mirror: f32| move |w: Vec3| Vec3::new(w.x, w.y, w.z * mirror);
        let (wi, leaving) = (mirrored(outer)(wi), leaving.map(mirrored(outer)));
        // Either frame, whatever the viewer sees; both normals are other than the one that counts.
        let leaving = Arriving {
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
        within(tilt.normal).max(within(tilt.turned()))
    }

    /// Upper bound of every channel of [`Leaf::eval`] for light from a cone. Tilts are taken to shadow nothing.
    pub(super) fn bound(&self, arriving: &Arriving, mut wo: Vec3, lobes: Lobes) -> f32 {
        let mirrored = |mirror: f32| move |w: Vec3| Vec3::new(w.x, w.y, w.z * mirror);
        let Some(outer) = self.outer.mirror(wo.z) else {
            return 0.0;
        };
        let mut arriving = arriving.map(mirrored(outer));
        wo.z *= outer;
        if let Some(tilt) = &self.tilt {
            let frame = tilt.frame(tilt.facing(wo));
            arriving = arriving.map(|w| frame.to_local(w));
            wo = frame.to_local(wo);
        }
        let Some(inner) = self.inner.mirror(wo.z) else {
            return 0.0;
        };
        wo.z *= inner;
        let arriving = arriving.map(mirrored(inner));
        self.weight * self.model.bound(&arriving, wo, self.model_lobes(lobes))
    }

    /// [`Leaf::eval`] class by class but for the leaf's weight, and [`Leaf::pdf`] given `wo`: the changes of frame are made once.
    #[inline]
    pub(super) fn respond(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Response {
        let Some((wi, wo, shadowing)) = self.in_model(wi, wo) else {
            return Response::NONE;
        };
        let mut response = self.model.respond(wi, wo, self.model_lobes(lobes));
        response.values.scale(shadowing);
        if self.demoted {
            response.values.demote();
        }
        response
    }

    /// Lambert's model alone as seen from `wo`; `None` for other models, and on a side that is black.
    #[inline]
    pub(super) fn plain_lambert(&self, wo: Vec3) -> Option<Lambert> {
        let Model::Diffuse(diffuse) = &self.model else {
            return None;
        };
        if self.tilt.is_some() || self.demoted {
            return None;
        }
        let side = self.side(wo.z)?;
        (wo.z * side > 0.0).then_some(Lambert {
            albedo: diffuse.reflectance * self.weight,
            side,
        })
    }

    /// For a leaf that is not tilted: the factor of z from the frame of the surface to that of the model, for directions with the
    /// given z; `None` on a side that it does not answer to.
    #[inline]
    pub(super) fn side(&self, z: f32) -> Option<f32> {
        let outer = self.outer.mirror(z)?;
        Some(outer * self.inner.mirror(z * outer)?)
    }

    /// Density of [`Leaf::sample`].
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
                let likely = tilt.facing(given);
                let unlikely = Vec3::new(-likely.x, -likely.y, likely.z);
                LIKELY_FRAME * pdf_about(likely) + (1.0 - LIKELY_FRAME) * pdf_about(unlikely)
            }
        }
    }

    #[inline]
    fn inner_pdf(&self, mut given: Vec3, mut other: Vec3, lobes: Lobes) -> f32 {
        let Some(mirror) = self.inner.mirror(given.z) else {
            return 0.0;
        };
        given.z *= mirror;
        other.z *= mirror;
        self.model.pdf(given, other, lobes)
    }

    /// Draws the other direction. A Dirac event comes complete but for the leaf's weight.
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

    fn inner_sample(&self, mut given: Vec3, u: BsdfNumbers, lobes: Lobes) -> Option<ModelSample> {
        let mirror = self.inner.mirror(given.z)?;
        given.z *= mirror;
        let mut sample = self.model.sample(given, u, lobes)?;
        sample.w.z *= mirror;
        Some(sample)
    }

    /// Samples in a tilted frame; also gives the direction there.
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

    /// The frame hangs on the direction that is to be sampled: each candidate has its chance.
    fn sample_tilted_wo(
        &self,
        tilt: &Tilt,
        wi: Vec3,
        mut u: BsdfNumbers,
        lobes: Lobes,
    ) -> Option<ModelSample> {
        let likely = tilt.facing(wi);
        let (n, probability) = if u.direction.x < LIKELY_FRAME {
            u.direction.x /= LIKELY_FRAME;
            (likely, LIKELY_FRAME)
        } else {
            u.direction.x = (u.direction.x - LIKELY_FRAME) / (1.0 - LIKELY_FRAME);
            (
                Vec3::new(-likely.x, -likely.y, likely.z),
                1.0 - LIKELY_FRAME,
            )
        };
        u.direction.x = u.direction.x.min(LARGEST);
        let (mut sample, _) = self.sample_in(&tilt.frame(n), wi, u, lobes)?;
        if let Some(delta) = &mut sample.delta {
            // A Dirac lobe exists in the frame that its own direction selects, and nowhere else.
            if tilt.facing(sample.w) != n || n.dot(wi) * wi.z <= 0.0 {
                return None;
            }
            delta.probability *= probability;
            delta.fraction *= tilt.shadowing(wi);
        }
        Some(sample)
    }
}
