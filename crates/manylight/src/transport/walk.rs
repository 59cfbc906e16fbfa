//! The random walk of camera paths, photons and importons.
//!
//! ```text
//! while let Some(step) = walk.advance() {
//!     // look at the vertex
//!     if walk.pass_through(&vertex, u) { continue }      // masks, null surfaces, thin glass
//!     if !walk.scatter(&vertex, numbers, lobes) { break }
//! }
//! ```
//!
//! Straight-through light is no scattering event: it changes neither the previous vertex (for MIS and the path partition)
//! nor the class of the last event; only the number of segments sees it.

use crate::bsdf::{Bsdf, BsdfNumbers, BsdfSample, Lobes};
use crate::color::Rgb;
use crate::geometry::{Ray, SurfacePoint, SurfaceRef};
use crate::math::Vec3;
use crate::scene::{PathLimits, Scene};
use std::ops::MulAssign;

/// Which end of the path the walk starts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Source {
    Sensor,
    Emitter,
}

/// The last scattering event of a walk (or its start).
#[derive(Clone, Copy, Debug)]
pub struct Previous {
    /// Where.
    pub p: Vec3,
    /// The normal that emitters are chosen with there; see [`Bsdf::receiving_normal`].
    pub n: Option<Vec3>,
    /// Class of the lobe that was sampled; [`Lobes::NONE`] at the start.
    pub event: Lobes,
    /// Density of the sampled direction per solid angle; 0 for delta events and at the start.
    pub pdf: f32,
}

/// A walk under way.
#[derive(Clone, Debug)]
pub struct Walk<'s> {
    scene: &'s Scene,
    source: Source,
    /// The camera must not see emitters; see [`past_emitters`].
    hides_emitters: bool,
    ray: Ray,
    throughput: Rgb,
    eta_squared: f32,
    segments: u32,
    previous: Previous,
}

/// Where a walk arrived.
#[derive(Clone, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "a step lives on the stack for one loop; boxing would allocate per vertex"
)]
pub enum Step<'s> {
    /// A surface.
    Hit(Vertex<'s>),
    /// The surroundings, along this unit direction.
    Escaped(Vec3),
    /// The surroundings, which the camera must not see.
    Hidden,
}

/// The end of a segment, before anybody asks what is there.
#[derive(Clone, Copy, Debug)]
pub enum Arrival {
    /// A point of a surface, and the length of the segment in m.
    Hit(SurfaceRef, f32),
    /// As [`Step::Escaped`].
    Escaped(Vec3),
    /// As [`Step::Hidden`].
    Hidden,
}

/// A surface that a walk hit.
#[derive(Clone, Debug)]
pub struct Vertex<'s> {
    /// Where.
    pub x: SurfacePoint,
    /// How it scatters.
    pub bsdf: Bsdf<'s>,
    /// Unit direction back along the ray: `wo` of a camera walk, `wi` of a photon.
    pub w_prev: Vec3,
    /// Length of the last segment, in m.
    pub distance: f32,
    /// Segments from the start of the walk to here.
    pub segments: u32,
}

impl<'s> Walk<'s> {
    /// A walk from the camera. With `hide_emitters` it sees neither emitters before the first other surface nor, before it
    /// scatters, the surroundings.
    pub fn from_sensor(scene: &'s Scene, limits: PathLimits, ray: Ray, throughput: Rgb) -> Self {
        let walk = Walk::new(scene, Source::Sensor, ray, throughput);
        Walk {
            hides_emitters: limits.hide_emitters,
            ..walk
        }
    }

    /// A photon: `flux` is carried along.
    pub fn from_emitter(scene: &'s Scene, ray: Ray, flux: Rgb) -> Self {
        Walk::new(scene, Source::Emitter, ray, flux)
    }

    fn new(scene: &'s Scene, source: Source, ray: Ray, throughput: Rgb) -> Self {
        let previous = Previous {
            p: ray.o,
            n: None,
            event: Lobes::NONE,
            pdf: 0.0,
        };
        Walk {
            scene,
            source,
            hides_emitters: false,
            ray,
            throughput,
            eta_squared: 1.0,
            segments: 0,
            previous,
        }
    }

    /// Camera walks: radiance arriving here times this reaches the sensor. Photons: flux.
    #[inline]
    pub fn throughput(&self) -> Rgb {
        self.throughput
    }

    /// Product of squared relative indices of refraction along a camera walk; see [`super::roulette::camera_survival`].
    #[inline]
    pub fn eta_squared(&self) -> f32 {
        self.eta_squared
    }

    /// The last scattering event.
    #[inline]
    pub fn previous(&self) -> &Previous {
        &self.previous
    }

    /// Segments travelled so far.
    #[inline]
    pub fn segments(&self) -> u32 {
        self.segments
    }

    /// Follows the ray to the next surface.
    #[inline]
    pub fn advance(&mut self) -> Step<'s> {
        match self.arrive() {
            Arrival::Hit(at, distance) => {
                Step::Hit(self.vertex(self.scene.surface_point(at), distance))
            }
            Arrival::Escaped(wi) => Step::Escaped(wi),
            Arrival::Hidden => Step::Hidden,
        }
    }

    /// The first half of [`Walk::advance`]: follows the ray.
    #[inline]
    pub fn arrive(&mut self) -> Arrival {
        self.segments += 1;
        let mut hidden = 0.0;
        if self.hides_emitters && self.segments == 1 {
            let visible = past_emitters(self.scene, self.ray);
            hidden = (visible.o - self.ray.o).length();
            self.ray = visible;
        }
        match self.scene.geometry.intersect(&self.ray) {
            Some(hit) => Arrival::Hit(hit.at, hidden + hit.t),
            None if self.hides_emitters && self.previous.event == Lobes::NONE => Arrival::Hidden,
            None => Arrival::Escaped(self.ray.d),
        }
    }

    /// The second half of [`Walk::advance`]: what the surface does to light at the point `x` where the walk arrived.
    #[inline]
    pub fn vertex(&self, x: SurfacePoint, distance: f32) -> Vertex<'s> {
        Vertex {
            bsdf: self.scene.bsdf(&x),
            x,
            w_prev: -self.ray.d,
            distance,
            segments: self.segments,
        }
    }

    /// Unit direction back along the last segment.
    #[inline]
    pub fn w_prev(&self) -> Vec3 {
        -self.ray.d
    }

    /// Lets the walk through `v` with probability of its straight-through transmittance. `false`: it must scatter here,
    /// and its throughput now counts for that.
    #[inline]
    pub fn pass_through(&mut self, v: &Vertex, u: f32) -> bool {
        let transmittance = v.bsdf.transmittance(v.w_prev);
        let p = transmittance.max_channel().min(1.0);
        if p <= 0.0 {
            return false;
        }
        if u < p {
            self.throughput *= transmittance / p;
            self.ray = Ray {
                t_max: self.ray.t_max - v.distance,
                ..v.x.spawn(-v.w_prev)
            };
            return true;
        }
        self.throughput *= 1.0 / (1.0 - p);
        false
    }

    /// Scatters at `v` by one of `lobes`. `false`: the walk ends here.
    pub fn scatter(&mut self, v: &Vertex, u: BsdfNumbers, lobes: Lobes) -> bool {
        let sample = match self.source {
            Source::Sensor => v.bsdf.sample_wi(v.w_prev, u, lobes),
            Source::Emitter => v.bsdf.sample_wo(v.w_prev, u, lobes),
        };
        self.follow(v, sample)
    }

    /// Goes on along a direction that the scattering function at `v` drew. `false`: the walk ends here.
    #[inline]
    pub fn follow(&mut self, v: &Vertex, sample: Option<BsdfSample>) -> bool {
        let Some(sample) = sample.filter(|s| !s.weight.is_black()) else {
            return false;
        };
        let n = match self.source {
            Source::Sensor => v.bsdf.receiving_normal(v.w_prev),
            Source::Emitter => None,
        };
        self.throughput *= sample.weight;
        self.eta_squared *= sample.eta * sample.eta;
        self.previous = Previous {
            p: v.x.p,
            n,
            event: sample.lobe,
            pdf: sample.pdf,
        };
        self.ray = v.x.spawn(sample.w);
        true
    }

    /// Lets the walk, or each of its channels, count `factor` times as much.
    #[inline]
    pub fn scale<F>(&mut self, factor: F)
    where
        Rgb: MulAssign<F>,
    {
        self.throughput *= factor;
    }

    /// Ends the walk with probability `1 - survival`; whoever goes on carries more.
    #[inline]
    pub fn survive(&mut self, survival: f32, u: f32) -> bool {
        if u >= survival {
            return false;
        }
        self.throughput *= 1.0 / survival;
        true
    }
}

/// What is left of a ray of the camera behind the emitters that it meets before any other surface. Mitsuba's rule: hidden
/// emitters are not there for the camera, from any side, and what lies behind them is seen; behind the first other surface,
/// be it a mask or thin glass, emitters are seen again.
#[must_use]
pub fn past_emitters(scene: &Scene, mut ray: Ray) -> Ray {
    while let Some(hit) = scene.geometry.intersect(&ray) {
        if scene.geometry.primitives()[hit.at.primitive.index()]
            .emitter
            .is_none()
        {
            break;
        }
        let x = scene.geometry.surface_point(hit.at);
        ray = Ray {
            t_max: ray.t_max - hit.t,
            ..x.spawn(ray.d)
        };
    }
    ray
}
