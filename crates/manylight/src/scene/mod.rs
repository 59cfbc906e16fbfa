//! Scenes: descriptions, checks, and the immutable scene that transport works in.

mod check;
mod check_emitters;
mod check_materials;
mod check_sensors;
pub mod desc;
pub mod error;
mod light_groups;
mod media;
mod names;
mod nesting;
#[cfg(test)]
mod tests;

pub use check::check_textures;
pub use desc::{InstanceDesc, MediumDesc, PathLimits, PrimitiveDesc, SceneDesc};
pub use error::SceneError;
pub use light_groups::{LightGroupNames, LightGroups, REST};
pub(crate) use media::{Media, transmittance};
pub use names::SurfaceNames;

use crate::bsdf::{Bsdf, Materials};
use crate::color::Rgb;
use crate::emitters::{EmissionGuide, Emitter, Emitters};
use crate::geometry::{Geometry, Hit, Instance, Primitive, Ray, Segment, SurfacePoint, SurfaceRef};
use crate::ids::PrimitiveId;
use crate::math::{Vec2, Vec3};
use crate::sampling::{Pass, Sampler, Stream};
use crate::sensors::{Sensor, SensorDesc};
use crate::texture::{Texture, TexturePoint};

/// Camera rays of the guiding pre-pass, see [`Scene::infinite_light_guide`]. With half and twice as many,
/// the pixel variance of `photon-map` with 50,000 photon paths is 1.31 and .94 times as large in the
/// third-party kitchen, 1.07 and 1.04 in the living-room, 1.45 and 1.36 in the classroom (16 seeds
/// at 128x72; the guide itself is random), and the time .76 to .86 and 1.04 to 1.09.
const GUIDE_RAYS: u64 = 16_384;

/// Surfaces that are followed from the end of a segment to the surface around it: a bound of the
/// work. Bodies with more layers count as empty.
const MAX_LAYERS: u32 = 64;

/// A scene, with the limits of the paths through it.
#[derive(Clone, Copy, Debug)]
pub struct LimitedScene<'s> {
    /// The scene.
    pub scene: &'s Scene,
    /// Limits of path length.
    pub limits: PathLimits,
}

/// A scene. Immutable, and shared by all threads.
#[derive(Debug)]
pub struct Scene {
    /// Surfaces.
    pub geometry: Geometry,
    /// Materials of the surfaces.
    pub materials: Materials,
    /// Media inside of surfaces.
    pub(crate) media: Media,
    /// Textures of materials and emitters.
    pub textures: Vec<Texture>,
    /// Emitters.
    pub emitters: Emitters,
    /// The sensor to render.
    pub sensor: Sensor,
    /// The cameras of a walkthrough, frame by frame; empty where there is one picture, by `sensor`.
    frames: Vec<Sensor>,
    /// Limits on path length in the file.
    pub limits: PathLimits,
    /// Names of objects and materials.
    pub names: SurfaceNames,
    /// Light groups of the emitters.
    pub light_groups: LightGroups,
}

impl Scene {
    /// Checks the description, and builds the acceleration structures. `sensor` is the index of the
    /// sensor to render.
    ///
    /// # Errors
    /// Ids out of range, cycles of materials, singular or non-finite transforms, numbers that are
    /// not finite, emitters inside of groups, an empty film, a field of view or a distance out of
    /// its domain.
    pub fn build(mut desc: SceneDesc, sensor: usize) -> Result<Scene, SceneError> {
        check::check(&desc, sensor)?;
        let names = SurfaceNames::new(&desc);
        let group_names = LightGroupNames::of(&desc);
        let materials = Materials::new(desc.materials);
        let in_world = desc.primitives.len();
        let groups = group_ranges(in_world, &desc.groups);
        let placed = desc
            .primitives
            .into_iter()
            .chain(desc.groups.into_iter().flatten());
        let primitives = placed.map(|p| primitive(p, &materials, &desc.emitters));
        let primitives = primitives.collect();
        let instances = desc.instances.iter().map(instance).collect();
        let geometry = Geometry::build(desc.shapes, primitives, groups, instances);
        let media = Media::new(&desc.media, &geometry, in_world);
        let emitters = Emitters::new(desc.emitters, &geometry, &desc.textures);
        let light_groups = LightGroups::new(&group_names, &emitters);
        let sensor = Sensor::new(desc.sensors.swap_remove(sensor));
        Ok(Scene {
            geometry,
            materials,
            media,
            textures: desc.textures,
            emitters,
            sensor,
            frames: Vec::new(),
            limits: desc.limits,
            names,
            light_groups,
        })
    }

    /// Replaces the sensor. Nothing else is built anew.
    ///
    /// # Errors
    /// A singular or non-finite transform, an empty film, or a number out of its domain: the sensor
    /// stays.
    pub fn set_sensor(&mut self, sensor: SensorDesc) -> Result<(), SceneError> {
        check_sensors::check_sensor(&sensor)?;
        self.sensor = Sensor::new(sensor);
        Ok(())
    }

    /// The cameras of a walkthrough, frame by frame. All of them have the film of the sensor.
    ///
    /// # Errors
    /// As of [`Scene::set_sensor`], with the index of the frame: the frames stay.
    pub fn set_frames(&mut self, cameras: Vec<SensorDesc>) -> Result<(), (usize, SceneError)> {
        let film = &self.sensor.desc().film;
        let frame = |(index, camera): (usize, SensorDesc)| {
            let camera = SensorDesc {
                film: film.clone(),
                ..camera
            };
            check_sensors::check_sensor(&camera).map_err(|error| (index, error))?;
            Ok(Sensor::new(camera))
        };
        self.frames = cameras
            .into_iter()
            .enumerate()
            .map(frame)
            .collect::<Result<_, _>>()?;
        Ok(())
    }

    /// The cameras of a walkthrough, frame by frame; empty where there is none.
    pub fn frames(&self) -> &[Sensor] {
        &self.frames
    }

    /// The camera of a frame, counted from 0; the sensor without one.
    ///
    /// # Panics
    /// There is no such frame.
    pub fn camera(&self, frame: Option<u32>) -> &Sensor {
        frame.map_or(&self.sensor, |index| &self.frames[index as usize])
    }

    /// The cameras whose pictures photons and virtual lights serve: those of all frames, or the
    /// sensor.
    pub fn views(&self) -> &[Sensor] {
        match self.frames.as_slice() {
            [] => std::slice::from_ref(&self.sensor),
            frames => frames,
        }
    }

    /// Whether the light groups are those of these names.
    pub fn has_light_groups(&self, names: &LightGroupNames) -> bool {
        self.light_groups == LightGroups::new(names, &self.emitters)
    }

    /// Divides the emitters into light groups by other names.
    pub fn set_light_groups(&mut self, names: &LightGroupNames) {
        self.light_groups = LightGroups::new(names, &self.emitters);
    }

    /// The guide for photons of infinite lights, for [`EmissionGuide::sample`]: it concentrates
    /// them on the part of the scene that the cameras see. Depends on the scene alone, and takes a
    /// pre-pass to compute, so make it once per render.
    pub fn infinite_light_guide(&self) -> EmissionGuide {
        let rays = || {
            let pass = Pass { seed: 0, index: 0 };
            let ray = |i| self.random_camera_ray(i, &mut pass.sampler(Stream::Pass, i));
            (0..GUIDE_RAYS).map(ray).collect()
        };
        let is_glass = |id: PrimitiveId| {
            let material = self.geometry.primitives()[id.index()].material;
            self.materials.is_transparent(material) || self.materials.refracts(material)
        };
        EmissionGuide::new(&self.emitters, &self.geometry, rays, is_glass)
    }

    /// Ray `i` of the cameras in turn, through a random point of the film and of the lens.
    pub(crate) fn random_camera_ray(&self, i: u64, sampler: &mut Sampler) -> Ray {
        // The sensor takes positions in the crop window.
        let film = sampler.next_2d() * self.sensor.desc().film.crop_size.as_vec2();
        let views = self.views();
        views[i as usize % views.len()].ray(film, sampler.next_2d())
    }

    /// The nearest hit of a ray, and the surface point there.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<(Hit, SurfacePoint)> {
        let hit = self.geometry.intersect(ray)?;
        Some((hit, self.geometry.surface_point(hit.at)))
    }

    /// The scattering function at a surface point.
    #[inline]
    pub fn bsdf(&self, x: &SurfacePoint) -> Bsdf<'_> {
        let material = self.geometry.primitives()[x.at.primitive.index()].material;
        self.materials.bsdf(material, x, &self.textures)
    }

    /// The surface point of a stored reference.
    #[inline]
    pub fn surface_point(&self, at: SurfaceRef) -> SurfacePoint {
        self.geometry.surface_point(at)
    }

    /// Fraction of light transmitted along the segment; black if an opaque surface blocks it.
    pub fn transmittance(&self, segment: &Segment) -> Rgb {
        self.transmittance_and_crossings(segment).0
    }

    /// [`Scene::transmittance`], and the number of transparent surfaces along the segment. Each of
    /// them is a path vertex.
    pub fn transmittance_and_crossings(&self, segment: &Segment) -> (Rgb, u32) {
        if self.geometry.occluded(segment) {
            return (Rgb::BLACK, 0);
        }
        self.cross_transparent(segment)
    }

    /// [`Scene::transmittance_and_crossings`] for a segment without opaque surfaces.
    pub fn cross_transparent(&self, segment: &Segment) -> (Rgb, u32) {
        let mut through = match self.media.is_empty() {
            true => Rgb::WHITE,
            false => self.transmittance_of_medium(segment),
        };
        if !self.geometry.has_transparent() {
            return (through, 0);
        }
        let mut crossings = 0;
        let mut on_edges = EdgeHits::new(segment);
        let w = (segment.to - segment.from).normalize_or_zero();
        self.geometry.visit_transparent(segment, |hit| {
            if !on_edges.are_repeated_by(&hit) {
                crossings += 1;
                let p = segment.from.lerp(segment.to, hit.t);
                through *= self.straight_through(hit.at, p, w);
            }
            through.is_black()
        });
        (through, crossings)
    }

    /// The fraction of light that media transmit between two points that see each other, `exp(-σ
    /// t)` (Beer and Lambert), if both lie in one medium.
    pub(crate) fn transmittance_of_medium(&self, segment: &Segment) -> Rgb {
        let across = segment.to - segment.from;
        let Some(d) = across.try_normalize() else {
            return Rgb::WHITE;
        };
        if !self.media.may_contain(segment) {
            return Rgb::WHITE;
        }
        let beyond = self.geometry.intersect(&Ray::new(segment.to, d));
        let medium = self.medium_before(beyond, d);
        medium.map_or(Rgb::WHITE, |sigma| transmittance(sigma, across.length()))
    }

    /// The absorption coefficient in front of a hit along `d`: in the body whose surface is left
    /// first, behind the bodies that lie within it. Refracting bodies without a medium are empty.
    pub(crate) fn medium_before(&self, mut hit: Option<Hit>, d: Vec3) -> Option<Rgb> {
        let mut entered = 0;
        for _ in 0..MAX_LAYERS {
            let x = self.surface_point(hit?.at);
            let material = self.geometry.primitives()[x.at.primitive.index()].material;
            let absorption = self.media.absorption(material);
            if absorption.is_some() || self.materials.refracts(material) {
                match (x.ng.dot(d) > 0.0, entered) {
                    (true, 0) => return absorption,
                    (true, _) => entered -= 1,
                    (false, _) => entered += 1,
                }
            }
            hit = self.geometry.intersect(&x.spawn(d));
        }
        None
    }

    /// [`Bsdf::transmittance`] at a surface point with the position `p` along `w`.
    fn straight_through(&self, at: SurfaceRef, p: Vec3, w: Vec3) -> Rgb {
        let material = self.geometry.primitives()[at.primitive.index()].material;
        match self.materials.cut_out(material) {
            Some(opacity) => {
                let place = TexturePoint::new(self.geometry.uv(at), p, at);
                let opacity = opacity.eval(place, &self.textures);
                Rgb::splat(1.0 - opacity.clamp(0.0, 1.0))
            }
            None => self.bsdf(&self.surface_point(at)).transmittance(w),
        }
    }
}

fn primitive(desc: PrimitiveDesc, materials: &Materials, emitters: &[Emitter]) -> Primitive {
    let emitter = desc.emitter.map(|id| &emitters[id.index()]);
    Primitive {
        shape: desc.shape,
        world_from_object: desc.world_from_object,
        flip_normals: desc.flip_normals,
        material: desc.material,
        emitter: desc.emitter,
        transparent: materials.is_transparent(desc.material),
        invisible: emitter.is_some_and(Emitter::is_invisible),
    }
}

fn instance(desc: &InstanceDesc) -> Instance {
    Instance {
        group: desc.group as u32,
        world_from_group: desc.world_from_group,
    }
}

/// The ranges of the groups' primitives, in a list that starts with `first` other primitives.
fn group_ranges(first: usize, groups: &[Vec<PrimitiveDesc>]) -> Vec<std::ops::Range<usize>> {
    let ranges = groups.iter().scan(first, |start, group| {
        let range = *start..*start + group.len();
        *start = range.end;
        Some(range)
    });
    ranges.collect()
}

/// Finds repeated hits on the common edge of two triangles: there the segment hits both, but
/// crosses the surface once.
struct EdgeHits {
    hits: Vec<Hit>,
    /// Tolerance for equal positions along the segment, as a fraction of its length.
    rounding: f32,
}

impl EdgeHits {
    /// Without hits.
    fn new(segment: &Segment) -> Self {
        let size = segment.from.abs().max(segment.to.abs()).max_element();
        let length = segment.from.distance(segment.to);
        EdgeHits {
            hits: Vec::new(),
            rounding: 8.0 * f32::EPSILON * (1.0 + size / length),
        }
    }

    /// Adds a hit. Returns whether an earlier hit was on the same edge of the same surface.
    fn are_repeated_by(&mut self, hit: &Hit) -> bool {
        /// Largest barycentric coordinate of a hit on an edge: rounding of coordinates.
        const EDGE: f32 = 1e-4;
        let Vec2 { x, y } = hit.at.coordinates;
        if x.min(y).min(1.0 - x - y) > EDGE {
            return false;
        }
        let surface = |hit: &Hit| (hit.at.primitive, hit.at.instance);
        let is_same = |other: &Hit| {
            surface(other) == surface(hit)
                && other.at.element != hit.at.element
                && (other.t - hit.t).abs() <= self.rounding
        };
        let is_repeated = self.hits.iter().any(is_same);
        self.hits.push(*hit);
        is_repeated
    }
}
