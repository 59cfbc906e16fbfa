//! A single walk from the camera, its vertices, and the state between two segments that it shares
//! with streams (`stream`).

use crate::bsdf::{Bsdf, BsdfNumbers, Lobes};
use crate::geometry::{Ray, SurfacePoint};
use crate::ids::MaterialId;
use crate::math::Vec3;
use crate::scene::{PathLimits, Scene};

/// Most segments of a camera path by specular events: longer ones would carry hardly any light.
pub(crate) const MAX_SPECULAR_SEGMENTS: u32 = 64;

/// The last scattering event of a walk, or its start.
#[derive(Clone, Copy, Debug)]
pub struct Previous {
    /// Position, in m.
    pub p: Vec3,
    /// Normal by which next-event estimation chooses emitters there; see
    /// [`Bsdf::receiving_normal`].
    pub n: Option<Vec3>,
    /// Class of the sampled lobe; [`Lobes::NONE`] at the start.
    pub event: Lobes,
    /// Density of the sampled direction per solid angle; 0 for delta events and at the start.
    pub pdf: f32,
    /// The material around the body in which the walk goes on, if that has a medium.
    pub(crate) inside: Option<MaterialId>,
}

impl Previous {
    /// The start of a walk at `p`.
    pub(crate) fn start(p: Vec3) -> Self {
        Previous {
            p,
            n: None,
            event: Lobes::NONE,
            pdf: 0.0,
            inside: None,
        }
    }
}

/// A walk from the camera: the only one that advances one vertex at a time, for the maps of interim
/// results.
#[derive(Clone, Debug)]
pub struct Walk<'s> {
    scene: &'s Scene,
    ray: Ray,
    /// Length of the last segment, in m.
    distance: f32,
    segments: u32,
}

/// A surface point that a walk arrived at.
#[derive(Clone, Debug)]
pub struct Vertex<'s> {
    /// Surface point.
    pub x: SurfacePoint,
    /// Scattering function there.
    pub bsdf: Bsdf<'s>,
    /// Unit direction back along the ray.
    pub w_prev: Vec3,
    /// Segments from the start of the walk to here.
    pub segments: u32,
}

impl<'s> Walk<'s> {
    /// A walk along a camera ray. With [`PathLimits::hide_emitters`], it sees no emitters before
    /// the first other surface.
    pub fn from_sensor(scene: &'s Scene, limits: PathLimits, ray: Ray) -> Self {
        let (ray, _) = visible_part(scene, limits.hide_emitters, ray);
        Walk {
            scene,
            ray,
            distance: 0.0,
            segments: 0,
        }
    }

    /// Follows the ray to the next surface; `None` if there is none.
    pub fn advance(&mut self) -> Option<Vertex<'s>> {
        self.segments += 1;
        let hit = self.scene.geometry.intersect(&self.ray)?;
        self.distance = hit.t;
        let x = self.scene.surface_point(hit.at);
        Some(Vertex {
            bsdf: self.scene.bsdf(&x),
            x,
            w_prev: -self.ray.d,
            segments: self.segments,
        })
    }

    /// Continues straight through `v` with the probability of its straight-through transmittance.
    /// `false`: the walk scatters here.
    pub fn pass_through(&mut self, v: &Vertex, u: f32) -> bool {
        let passes = u < v.bsdf.transmittance(v.w_prev).max_channel().min(1.0);
        if passes {
            self.ray = Ray {
                t_max: self.ray.t_max - self.distance,
                ..v.x.spawn(-v.w_prev)
            };
        }
        passes
    }

    /// Scatters at `v` by one of `lobes`. `false`: the walk ends here.
    pub fn scatter(&mut self, v: &Vertex, u: BsdfNumbers, lobes: Lobes) -> bool {
        let sample = v.bsdf.sample_wi(v.w_prev, u, lobes);
        let sample = sample.filter(|sample| !sample.weight.is_black());
        if let Some(sample) = &sample {
            self.ray = v.x.spawn(sample.w);
        }
        sample.is_some()
    }
}

/// The part of a camera ray that the camera sees, and the length in m of the part before it:
/// [`past_emitters`] if these are hidden.
pub(crate) fn visible_part(scene: &Scene, hides_emitters: bool, ray: Ray) -> (Ray, f32) {
    if !hides_emitters {
        return (ray, 0.0);
    }
    let visible = past_emitters(scene, ray);
    (visible, (visible.o - ray.o).length())
}

/// The part of a camera ray behind the emitters that it meets before any other surface. This is
/// Mitsuba's rule for hidden emitters: the camera sees what lies behind them, from any side. Behind
/// the first other surface, masks and thin glass included, emitters are seen.
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
