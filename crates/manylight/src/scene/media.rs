//! Absorbing media inside of closed surfaces.

use super::desc::MediumDesc;
use crate::color::Rgb;
use crate::geometry::{Geometry, Primitive, Segment, Shape};
use crate::ids::MaterialId;
use crate::math::float::exp;
use crate::math::{Aabb, Vec3};

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

/// The fraction of light that a medium transmits over a distance in m.
pub(crate) fn transmittance(absorption: Rgb, distance: f32) -> Rgb {
    absorption.map(|sigma| exp(-sigma * distance))
}
