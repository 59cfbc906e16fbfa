//! From a description to an immutable world.

pub mod desc;
pub mod error;

pub use desc::{InstanceDesc, PathLimits, PrimitiveDesc, SceneDesc};
pub use error::SceneError;

use crate::bsdf::{Bsdf, Materials};
use crate::color::Rgb;
use crate::emitters::Emitters;
use crate::geometry::{Geometry, Hit, Ray, Segment, SurfacePoint, SurfaceRef};
use crate::sensors::Sensor;
use crate::texture::Texture;

/// The world that transport works in. Immutable; shared by all threads.
#[derive(Debug)]
pub struct Scene {
    /// Surfaces.
    pub geometry: Geometry,
    /// How they scatter.
    pub materials: Materials,
    /// What is painted on them.
    pub textures: Vec<Texture>,
    /// What shines.
    pub emitters: Emitters,
    /// The camera.
    pub sensor: Sensor,
    /// Path lengths that the file asks for.
    pub limits: PathLimits,
}

impl Scene {
    /// Checks the description, resolves it, and builds the acceleration structures. `sensor` is the index of the camera.
    ///
    /// # Errors
    /// An id out of range, a cycle of materials, a singular or non-finite transform, an emitter inside a group,
    /// no such sensor, an empty film.
    pub fn build(_desc: SceneDesc, _sensor: usize) -> Result<Scene, SceneError> {
        todo!()
    }

    /// The nearest surface.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<(Hit, SurfacePoint)> {
        let hit = self.geometry.intersect(ray)?;
        Some((hit, self.geometry.surface_point(hit.at)))
    }

    /// The scattering function at a point.
    #[inline]
    pub fn bsdf(&self, x: &SurfacePoint) -> Bsdf<'_> {
        let material = self.geometry.primitives()[x.at.primitive.index()].material;
        self.materials.bsdf(material, x, &self.textures)
    }

    /// The point that a stored reference names.
    #[inline]
    pub fn surface_point(&self, at: SurfaceRef) -> SurfacePoint {
        self.geometry.surface_point(at)
    }

    /// Fraction of light that passes along the segment; black when an opaque surface lies between.
    pub fn transmittance(&self, _segment: &Segment) -> Rgb {
        todo!()
    }

    /// [`Scene::transmittance`] with the number of transparent surfaces on the way.
    pub fn transmittance_and_crossings(&self, _segment: &Segment) -> (Rgb, u32) {
        todo!()
    }
}
