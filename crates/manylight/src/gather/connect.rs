//! A connection of points with a part of a light: `f cosθ I w_c / d²`, before its visibility `V`.
//!
//! The sum over all lights and cuts through the light tree connect sixteen points at once, product
//! cuts single ones.

use super::clamping::ClampedConnection;
use super::light_points::LightPoint;
use super::receivers::{ConnectedLight, Direction, Receivers};
use super::sphere::integrate;
use super::{Gather, Strategy, Subset};
use crate::lanes::{Color, Float, Mask, Vector, Width};
use crate::virtual_lights::RadiantIntensity;

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

    /// Factor on each evaluated light: the number of lights that it represents.
    #[inline(always)]
    pub(super) fn lights_per_term(&self, lights: Subset) -> f32 {
        match self.strategy {
            Strategy::All => lights.lights_per_member(),
            Strategy::Cuts(_) | Strategy::Bidirectional(_) => 1.0,
        }
    }

    /// Factor on the area that a light represents, as clamping and spheres see it.
    #[inline(always)]
    pub(super) fn area_factor(&self, lights: Subset) -> f32 {
        let factor = match self.strategy {
            Strategy::All => lights.area_factor(),
            Strategy::Cuts(_) | Strategy::Bidirectional(_) => 1.0,
        };
        factor / self.refinement
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
