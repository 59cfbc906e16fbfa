//! What the scene file declares as sources of light ("light" is reserved for virtual lights).
//!
//! An emitter answers three questions: a photon leaves ([`Emitters::sample_emission`]), it is seen from a point
//! ([`Emitters::sample_direct`]), a ray hits it ([`Emitters::radiance`], [`Emitters::environment_radiance`]).

pub mod environment;

pub use environment::Environment;

use crate::color::Rgb;
use crate::geometry::{Geometry, Ray, SurfacePoint};
use crate::ids::EmitterId;
use crate::math::{Aabb, Vec2, Vec3};
use crate::texture::{ColorInput, Texture};

/// A source of light. All directions and positions in world space.
#[derive(Clone, Debug)]
pub enum Emitter {
    /// A primitive that shines from the side of its shading normal.
    Area {
        /// W/(m² sr).
        radiance: ColorInput,
    },
    /// An isotropic point.
    Point {
        /// Where.
        position: Vec3,
        /// W/sr.
        intensity: Rgb,
    },
    /// A cone with a smooth rim.
    Spot {
        /// Where.
        position: Vec3,
        /// Unit axis.
        direction: Vec3,
        /// W/sr on the axis.
        intensity: Rgb,
        /// Half-angle of the rim in radians.
        cutoff: f32,
        /// Half-angle of the constant part in radians, <= `cutoff`.
        beam_width: f32,
    },
    /// Parallel light through the whole scene.
    Directional {
        /// Unit direction in which the light travels.
        direction: Vec3,
        /// W/m² on a plane across it.
        irradiance: Rgb,
    },
    /// The same radiance from every direction.
    Constant {
        /// W/(m² sr).
        radiance: Rgb,
    },
    /// A picture of the surroundings.
    Environment(Environment),
}

/// The numbers that start a photon.
#[derive(Clone, Copy, Debug)]
pub struct EmissionNumbers {
    /// Chooses the emitter.
    pub emitter: f32,
    /// Where on it (or across the scene for distant emitters).
    pub position: Vec2,
    /// Which way.
    pub direction: Vec2,
    /// Chooses among an emitter's parts.
    pub part: f32,
}

/// A photon at its start.
#[derive(Clone, Copy, Debug)]
pub struct EmissionSample {
    /// Already moved off the emitter.
    pub ray: Ray,
    /// Emitted flux over the probability of this sample (choice of the emitter included), in W: the flux of one path
    /// before it is divided by the number of emitted paths.
    pub flux: Rgb,
    /// Which emitter.
    pub emitter: EmitterId,
    /// The point that emits, for surfaces; `None` for points and distant emitters. For splatting what the camera sees directly.
    pub surface: Option<SurfacePoint>,
}

/// A direction towards an emitter from a point.
#[derive(Clone, Copy, Debug)]
pub struct DirectSample {
    /// Unit direction to the emitter.
    pub wi: Vec3,
    /// The point on the emitter, moved off its surface; far outside the scene for distant emitters. End of the shadow ray.
    pub target: Vec3,
    /// Radiance over pdf per solid angle (choice of the emitter included); for delta emitters the same limit: irradiance across `wi`.
    pub weight: Rgb,
    /// Per solid angle, choice of the emitter included; 0 for delta emitters, which BSDF sampling cannot find.
    pub pdf: f32,
    /// Which emitter.
    pub emitter: EmitterId,
}

/// All emitters of a scene, with what is needed to choose among 10^5 of them.
#[derive(Debug)]
pub struct Emitters {
    emitters: Vec<Emitter>,
}

impl Emitters {
    /// Prepares the choice. Area emitters are found through `geometry`'s primitives (one emitter may sit on several primitives;
    /// emitters inside instanced groups are refused by `Scene::build`).
    pub fn new(_emitters: Vec<Emitter>, _geometry: &Geometry, _textures: &[Texture]) -> Self {
        todo!()
    }

    /// The descriptions; index by [`EmitterId`].
    pub fn descriptions(&self) -> &[Emitter] {
        &self.emitters
    }

    /// Starts a photon: emitter by power, then position and direction. `None` if this sample carries nothing.
    pub fn sample_emission(
        &self,
        _geometry: &Geometry,
        _textures: &[Texture],
        _u: EmissionNumbers,
    ) -> Option<EmissionSample> {
        todo!()
    }

    /// Chooses an emitter for the receiving point `p` with geometric normal `n` (`None`: all directions matter),
    /// by a light tree over position, orientation and power, then a point on it.
    /// `None` if nothing arrives (back side, zero radiance). No visibility.
    pub fn sample_direct(
        &self,
        _geometry: &Geometry,
        _textures: &[Texture],
        _p: Vec3,
        _n: Option<Vec3>,
        _u_choice: f32,
        _u: Vec2,
    ) -> Option<DirectSample> {
        todo!()
    }

    /// Density per solid angle with which [`Emitters::sample_direct`] at (`p`, `n`) finds the point `y` of an area emitter.
    pub fn pdf_direct(
        &self,
        _geometry: &Geometry,
        _p: Vec3,
        _n: Option<Vec3>,
        _y: &SurfacePoint,
    ) -> f32 {
        todo!()
    }

    /// Density per solid angle with which [`Emitters::sample_direct`] at (`p`, `n`) finds a direction to the surroundings.
    pub fn pdf_direct_environment(&self, _p: Vec3, _n: Option<Vec3>, _wi: Vec3) -> f32 {
        todo!()
    }

    /// Radiance that the surface emits at `x` towards `wo`; black for surfaces that do not emit.
    pub fn radiance(
        &self,
        _geometry: &Geometry,
        _textures: &[Texture],
        _x: &SurfacePoint,
        _wo: Vec3,
    ) -> Rgb {
        todo!()
    }

    /// Radiance that arrives from the surroundings along unit `wi` (pointing away from the scene).
    pub fn environment_radiance(&self, _wi: Vec3) -> Rgb {
        todo!()
    }

    /// Whether there are surroundings at all.
    pub fn has_environment(&self) -> bool {
        todo!()
    }

    /// Flux of one emitter into the scene in W (an estimate for distant emitters: irradiance times the scene's cross-section).
    pub fn power(&self, _id: EmitterId) -> Rgb {
        todo!()
    }

    /// Sphere around the scene used by distant emitters.
    pub fn scene_bounds(&self) -> Aabb {
        todo!()
    }
}
