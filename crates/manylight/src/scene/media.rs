//! Absorbing media inside of closed surfaces.

use super::Scene;
use super::desc::MediumDesc;
use crate::color::Rgb;
use crate::geometry::{Geometry, Hit, Primitive, Ray, Segment, Shape};
use crate::ids::MaterialId;
use crate::math::float::exp;
use crate::math::{Aabb, Vec3};

/// Surfaces that are followed from the end of a segment to the surface around it. Bodies with more
/// layers than these count as empty.
const MAX_LAYERS: u32 = 64;

/// The media of a scene, by the materials of the surfaces around them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Media {
    /// Absorption coefficients in 1/m; shorter than the list of materials, and empty without media.
    absorption: Vec<Option<Rgb>>,
    /// Bounds of the surfaces around media.
    bodies: Vec<Aabb>,
}

impl Media {
    /// `in_world` is the number of primitives of the world, which come first.
    pub(super) fn new(media: &[MediumDesc], geometry: &Geometry, in_world: usize) -> Self {
        let mut absorption = Vec::new();
        for medium in media {
            let index = medium.material.index();
            if absorption.len() <= index {
                absorption.resize(index + 1, None);
            }
            absorption[index] = Some(medium.absorption);
        }
        let mut media = Media {
            absorption,
            bodies: Vec::new(),
        };
        if !media.is_empty() {
            let (world, groups) = geometry.primitives().split_at(in_world);
            let is_around = |p: &&Primitive| media.absorption(p.material).is_some();
            // Instances are somewhere in the scene.
            media.bodies = match groups.iter().any(|p| is_around(&p)) {
                true => vec![geometry.bounds()],
                false => (world.iter().filter(is_around))
                    .map(|p| bounds_of(p, geometry))
                    .collect(),
            };
        }
        media
    }

    #[inline]
    pub(crate) fn is_empty(&self) -> bool {
        self.absorption.is_empty()
    }

    /// The absorption coefficient inside of surfaces of this material, in 1/m; `None` if there is
    /// no medium.
    #[inline]
    pub(crate) fn absorption(&self, material: MaterialId) -> Option<Rgb> {
        self.absorption.get(material.index()).copied().flatten()
    }

    /// Whether both ends of a segment may lie in one medium. False for most segments.
    #[inline]
    pub(crate) fn may_contain(&self, segment: &Segment) -> bool {
        let contains = |body: &Aabb, p| body.distance_squared(p) == 0.0;
        let Segment { from, to } = *segment;
        (self.bodies.iter()).any(|body| contains(body, from) && contains(body, to))
    }
}

/// Bounds of a primitive of the world.
fn bounds_of(primitive: &Primitive, geometry: &Geometry) -> Aabb {
    let around = |p: Vec3, radius: f32| Aabb {
        min: p - radius,
        max: p + radius,
    };
    let own = match &geometry.shapes()[primitive.shape.index()] {
        Shape::Mesh(mesh) => Aabb::from_points(mesh.positions.iter().copied()),
        Shape::Sphere { center, radius } => around(*center, *radius),
        Shape::Disk => around(Vec3::ZERO, 1.0),
        Shape::Cylinder { p0, p1, radius } => around(*p0, *radius).union(around(*p1, *radius)),
    };
    own.transformed(&primitive.world_from_object)
}

impl Scene {
    /// The fraction of light that media transmit between two points that see each other, `exp(-σ
    /// t)` (Beer and Lambert), if both lie in one medium.
    pub(crate) fn transmittance_of_medium(&self, segment: &Segment) -> Rgb {
        if !self.media.may_contain(segment) {
            return Rgb::WHITE;
        }
        let across = segment.to - segment.from;
        let length = across.length();
        let beyond = Ray::new(segment.to, across / length);
        let medium = self.medium_before(self.geometry.intersect(&beyond), beyond.d);
        medium.map_or(Rgb::WHITE, |absorption| transmittance(absorption, length))
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
}

/// The fraction of light that a medium transmits over a distance in m.
pub(crate) fn transmittance(absorption: Rgb, distance: f32) -> Rgb {
    absorption.map(|sigma| exp(-sigma * distance))
}
