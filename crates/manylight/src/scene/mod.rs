//! From a description to an immutable world.

mod build;
pub mod desc;
pub mod error;
#[cfg(test)]
mod tests;

pub use desc::{InstanceDesc, PathLimits, PrimitiveDesc, SceneDesc};
pub use error::SceneError;

use crate::bsdf::{Bsdf, Material, Materials};
use crate::color::Rgb;
use crate::emitters::Emitters;
use crate::geometry::{Geometry, Hit, Ray, Segment, Shape, SurfacePoint, SurfaceRef};
use crate::ids::PrimitiveId;
use crate::sampling::{Pass, Stream};
use crate::sensors::Sensor;
use crate::texture::Texture;

/// Camera rays that teach photons from afar.
const GUIDE_RAYS: u64 = 16_384;

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
    pub fn build(desc: SceneDesc, sensor: usize) -> Result<Scene, SceneError> {
        build::build(desc, sensor)
    }

    /// Teaches photons from afar which windows the camera's surroundings are lit through; to be called before any is emitted.
    /// Methods without photons never need it, and all calls but the first do nothing.
    pub fn guide_emission(&self) {
        let rays = || {
            let film = self.sensor.desc().film.crop_size.as_vec2();
            let pass = Pass { seed: 0, index: 0 };
            let ray = |i: u64| {
                let mut sampler = pass.sampler(Stream::Pass, i);
                let at = sampler.next_2d() * film;
                self.sensor.ray(at, sampler.next_2d()).ray
            };
            (0..GUIDE_RAYS).map(ray).collect()
        };
        let is_glass = |id: PrimitiveId| {
            let material = self.geometry.primitives()[id.index()].material;
            self.materials.is_transparent(material)
                || matches!(
                    self.materials.descriptions()[material.index()],
                    Material::Dielectric { .. }
                )
        };
        self.emitters.guide_emission(&self.geometry, rays, is_glass);
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

    /// Asks for the memory that [`Scene::bsdf`] will read.
    #[inline]
    pub fn expect_bsdf(&self, x: &SurfacePoint) {
        let material = self.geometry.primitives()[x.at.primitive.index()].material;
        self.materials.expect(material, x.uv, &self.textures);
    }

    /// The point that a stored reference names.
    #[inline]
    pub fn surface_point(&self, at: SurfaceRef) -> SurfacePoint {
        self.geometry.surface_point(at)
    }

    /// Fraction of light that passes along the segment; black when an opaque surface lies between.
    pub fn transmittance(&self, segment: &Segment) -> Rgb {
        self.transmittance_and_crossings(segment).0
    }

    /// [`Scene::transmittance`], and how many transparent surfaces the segment crosses: each is a vertex of the path.
    pub fn transmittance_and_crossings(&self, segment: &Segment) -> (Rgb, u32) {
        if self.geometry.occluded(segment) {
            return (Rgb::BLACK, 0);
        }
        if !self.geometry.has_transparent() {
            return (Rgb::WHITE, 0);
        }
        self.cross_transparent(segment)
    }

    /// The transparent surfaces alone, for segments that are known to be clear of opaque ones.
    pub fn cross_transparent(&self, segment: &Segment) -> (Rgb, u32) {
        /// A segment that meets more surfaces than this (or cannot get past one) counts as blocked.
        const MAX_STEPS: u32 = 1024;
        let (mut from, mut through, mut crossings) = (segment.from, Rgb::WHITE, 0);
        let mut last: Option<SurfaceRef> = None;
        let mut step = 1.0;
        for _ in 0..MAX_STEPS {
            let d = segment.to - from;
            let Some(hit) = self.geometry.intersect_transparent(&Ray {
                o: from,
                d,
                t_max: 1.0,
            }) else {
                return (through, crossings);
            };
            let x = self.geometry.surface_point(hit.at);
            // A line crosses a triangle once: a second hit is the rounding of the first, and needs a longer step.
            if last.is_some_and(|last| self.is_same_triangle(last, hit.at)) {
                step *= 2.0;
            } else {
                step = 1.0;
                crossings += 1;
                through *= self.bsdf(&x).transmittance(d.normalize_or_zero());
                if through.is_black() {
                    return (Rgb::BLACK, crossings);
                }
            }
            last = Some(hit.at);
            from = x.p + (x.offset_towards(d) - x.p) * step;
        }
        (Rgb::BLACK, crossings)
    }

    fn is_same_triangle(&self, a: SurfaceRef, b: SurfaceRef) -> bool {
        let shape = self.geometry.primitives()[a.primitive.index()].shape;
        let is_mesh = matches!(self.geometry.shapes()[shape.index()], Shape::Mesh(_));
        is_mesh && (a.primitive, a.element, a.instance) == (b.primitive, b.element, b.instance)
    }
}
