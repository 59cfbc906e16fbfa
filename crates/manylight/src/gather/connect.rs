//! A connection of points with a part of a light: `f cosθ I w_c / d²`, before its visibility `V`.
//!
//! The sum over all lights and cuts through the light tree connect sixteen points at once, product
//! cuts single ones.

use super::clamping::ClampedConnection;
use super::light_points::LightPoint;
use super::sphere::{LightLobe, SphereSamples, integrate};
use super::{Gather, Subset};
use crate::ids::LightId;
use crate::lanes::{Color, Float, Mask, Vector, Width};
use crate::math::Vec3;
use crate::virtual_lights::{RadiantIntensity, VirtualLight, VirtualLights};

/// The point `x` of a connection in each lane.
pub(super) trait Receivers<S: Width> {
    /// The vectors from the points to `p`, in m.
    fn towards(&self, p: Vec3) -> Vector<S>;
    /// Geometric normals.
    fn normals(&self) -> Vector<S>;
    /// The lights that are summed at all points.
    fn lights(&self) -> Subset;
    /// `f cosθ` of the non-specular lobes for unit directions, in 1/sr; inactive lanes hold any
    /// value.
    fn f_cos_wi(&self, wi: Vector<S>, active: Mask<S>) -> Color<S>;
    /// Where light from the unit directions `wi` counts; see
    /// [`ShadingPoint::lit_from`](super::ShadingPoint::lit_from).
    fn count_light_from(&self, wi: Vector<S>) -> Mask<S>;
    /// The fraction of the flux of light `id` that fits the path limits.
    fn shares(&self, lights: &VirtualLights, id: LightId) -> Float<S>;
    /// For lights as spheres.
    fn sphere_samples(&self) -> Option<&SphereSamples<S>>;
}

/// The light of a connection.
pub(super) struct ConnectedLight<'f, 's, E> {
    pub(super) lights: &'f VirtualLights<'s>,
    pub(super) id: LightId,
    pub(super) light: &'f VirtualLight<'s>,
    pub(super) emission: E,
    /// Radius as a sphere, in m.
    pub(super) radius: f32,
    /// The glossy lobe of a light of one photon, for sampling directions to a sphere.
    pub(super) lobe: Option<LightLobe>,
}

/// Where points and a part of a light see each other.
#[derive(Clone, Copy)]
pub(super) struct Direction<S: Width> {
    /// Unit directions to the light.
    pub(super) wi: Vector<S>,
    /// Inverse of the squared distances, in 1/m².
    pub(super) inv_d2: Float<S>,
    pub(super) active: Mask<S>,
}

/// A connection in each lane. All values are unspecified in lanes that are not lit.
#[derive(Clone, Copy)]
pub(super) struct Connection<S: Width> {
    /// Unit directions to the light.
    pub(super) wi: Vector<S>,
    /// `f cosθ I / d²` over the part of the light, in W/(m² sr).
    pub(super) unclamped: Color<S>,
    /// The clamping weight `w_c`.
    pub(super) weight: Float<S>,
    /// The lanes in which light arrives, if it is visible.
    pub(super) lit: Mask<S>,
}

impl<S: Width> Connection<S> {
    /// `f cosθ I w_c / d²`, in W/(m² sr).
    #[inline(always)]
    pub(super) fn clamped(&self) -> Color<S> {
        self.unclamped * self.weight
    }
}

impl Gather {
    /// The connections of the active points with a part of a light.
    ///
    /// ```text
    /// L = f(wi, wo) cosθ · I(-wi) / d² · w_c · V
    /// ```
    ///
    /// Walter et al., "Lightcuts: A Scalable Approach to Illumination", SIGGRAPH 2005, eq. (1), has
    /// the terms as M, I, G and V, with the cosine in G. Here the cosine at the light is part of
    /// the intensity, and the clamping weight `w_c` bounds the singularity. For a light as a
    /// sphere, the integral of `f cosθ I` over its directions takes the place of `f cosθ I / d²`.
    /// `V` is up to the caller, because shadow rays are traced together.
    #[inline(always)]
    pub(super) fn connect<S: Width, E: RadiantIntensity<S>>(
        &self,
        x: &impl Receivers<S>,
        light: &ConnectedLight<E>,
        part: &LightPoint,
        active: Mask<S>,
    ) -> Connection<S> {
        let to = x.towards(part.p);
        let d2 = to.length_squared();
        let inv_d = d2.sqrt().recip();
        let wi = to * inv_d;
        let at = Direction {
            wi,
            inv_d2: inv_d * inv_d,
            active: active & x.count_light_from(wi) & d2.gt(0.0),
        };
        let (reflected, weight) = match (part.directions, x.sphere_samples()) {
            (Some(count), Some(samples)) => {
                (integrate(samples, x, light, &at, count), d2.same(1.0))
            }
            _ => self.reflected(x, light, part, &at),
        };
        let shares = x.shares(light.lights, light.id);
        let flux = shares * self.lights_per_term(x.lights()) * part.weight;
        let unclamped = reflected * flux;
        Connection {
            wi,
            unclamped,
            weight,
            lit: at.active & is_lit(unclamped * weight),
        }
    }

    /// `f cosθ I / d²` of a point light, and the clamping weight `w_c`.
    #[inline(always)]
    fn reflected<S: Width, E: RadiantIntensity<S>>(
        &self,
        x: &impl Receivers<S>,
        light: &ConnectedLight<E>,
        part: &LightPoint,
        at: &Direction<S>,
    ) -> (Color<S>, Float<S>) {
        let Direction { wi, inv_d2, .. } = *at;
        let intensity = light.emission.intensity(-wi, at.active);
        let active = at.active & is_lit(intensity);
        if active.none() {
            return (Color::black(wi.z.width()), wi.z.same(1.0));
        }
        let f_cos = x.f_cos_wi(wi, active);
        let weight = self.clamp.weight(&ClampedConnection {
            w: wi,
            inv_d2,
            f_cos,
            n_x: x.normals(),
            n_y: light.light.n,
            area: part.area * self.area_factor(x.lights()),
        });
        ((f_cos * (intensity * inv_d2)).within(active), weight)
    }
}

/// The lanes with some light in a channel, none of which is negative.
#[inline(always)]
fn is_lit<S: Width>(light: Color<S>) -> Mask<S> {
    (light.r + light.g + light.b).gt(0.0)
}
