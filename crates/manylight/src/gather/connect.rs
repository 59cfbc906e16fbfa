//! A connection of points with a part of a light: `f cosθ I w_c / d²`, before its visibility `V`.
//!
//! ```text
//! L = f(wi, wo) cosθ · I(-wi) / d² · w_c · V
//! ```
//!
//! Walter et al., "Lightcuts: A Scalable Approach to Illumination", SIGGRAPH 2005, eq. (1), has the
//! terms as M, I, G and V, with the cosine in G. Here the cosine at the light is part of the
//! intensity, and the clamping weight `w_c` bounds the singularity. `V` is up to the caller, because
//! shadow rays are traced together.
//!
//! The sum over all lights and cuts through the light tree connect sixteen points at once, product
//! cuts single ones.

use super::clamping::ClampedConnection;
use super::light_points::LightPoint;
use super::receivers::{ConnectedLight, Direction, Receivers};
use super::sphere::integrate;
use super::sphere_samples::SphereSamples;
use super::{Gather, Strategy, Subset};
use crate::lanes::{Color, Float, Mask, One, Vector, Width};
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
    /// The connection of one point with a part of a light that is no sphere.
    pub(super) fn connect<E: RadiantIntensity<One>>(
        &self,
        x: &impl Receivers<One>,
        light: &ConnectedLight<E>,
        part: &LightPoint,
    ) -> Connection<One> {
        let mut at = Direction::towards(x, part, Mask::splat(One, true));
        let intensity = light.emission.intensity(-at.wi, at.active);
        at.active = at.active & is_lit(intensity);
        let f_cos = if at.active.any() {
            x.f_cos_wi(at.wi, at.active)
        } else {
            Color::black(One)
        };
        self.connection(x, light, part, (at, intensity, f_cos))
    }

    /// The connections with a part of a light that is no sphere, in the directions `at`, with the
    /// intensities towards the points and `f cosθ` there.
    #[inline(always)]
    pub(super) fn connection<S: Width, E>(
        &self,
        x: &impl Receivers<S>,
        light: &ConnectedLight<E>,
        part: &LightPoint,
        (at, intensity, f_cos): (Direction<S>, Color<S>, Color<S>),
    ) -> Connection<S> {
        let weight = self.clamp.weight(&ClampedConnection {
            w: at.wi,
            inv_d2: at.inv_d2,
            f_cos,
            n_x: x.normals(),
            n_y: light.light.n,
            area: part.area * self.area_factor(x.lights()),
        });
        let reflected = f_cos * (intensity * at.inv_d2);
        self.of_part(x, light, part, (at, reflected, weight))
    }

    /// The connections of the active points with a light as a sphere, of which `samples` draw
    /// `count` directions: the integral of `f cosθ I` over the directions to the light takes the
    /// place of `f cosθ I / d²`.
    #[inline(always)]
    pub(super) fn connect_sphere<S: Width, E: RadiantIntensity<S>>(
        &self,
        x: &impl Receivers<S>,
        light: &ConnectedLight<E>,
        (part, samples, count): (&LightPoint, &SphereSamples<S>, usize),
        active: Mask<S>,
    ) -> Connection<S> {
        let at = Direction::towards(x, part, active);
        let reflected = integrate(samples, x, light, &at, count);
        self.of_part(x, light, part, (at, reflected, at.inv_d2.same(1.0)))
    }

    /// The connections with a part of a light, from the light that the points would reflect of all
    /// of it, and the clamping weights.
    #[inline(always)]
    fn of_part<S: Width, E>(
        &self,
        x: &impl Receivers<S>,
        light: &ConnectedLight<E>,
        part: &LightPoint,
        (at, reflected, weight): (Direction<S>, Color<S>, Float<S>),
    ) -> Connection<S> {
        let shares = x.shares(light.lights, light.id);
        let fraction = shares * self.lights_per_term(x.lights()) * part.weight;
        let unclamped = (reflected * fraction).within(at.active);
        Connection {
            wi: at.wi,
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
}

/// The lanes with some light in a channel, none of which is negative.
#[inline(always)]
pub(super) fn is_lit<S: Width>(light: Color<S>) -> Mask<S> {
    (light.r + light.g + light.b).gt(0.0)
}
