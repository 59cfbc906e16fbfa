//! One element of an emitter: sampling and densities.

use crate::color::Rgb;
use crate::emitters::EmissionSource;
use crate::geometry::{Geometry, SurfacePoint, SurfaceRef};
use crate::ids::{EmitterId, PrimitiveId};
use crate::math::{Aabb, Cone, Vec2, Vec3};
use crate::sampling::warp;

/// The set of points of an element, and how it is sampled.
#[derive(Clone, Copy, Debug)]
pub(in crate::emitters) enum ElementShape {
    /// A whole primitive, by area.
    Primitive,
    /// A sphere or cylinder under a transform that does not keep angles, by the area of the shape
    /// before the transform.
    Stretched {
        /// Density of the parameters (u, v) of points that are uniform by that area.
        uv_density: fn(Vec2) -> f32,
    },
    /// One triangle of a mesh, by area.
    Triangle { index: u32 },
    /// The position of a point or a spot.
    Point,
}

/// An element of an emitter.
#[derive(Clone, Copy, Debug)]
pub(in crate::emitters) struct EmitterElement {
    pub(in crate::emitters) emitter: EmitterId,
    /// The primitive that carries the emitter; an invalid id for points and spots.
    pub(in crate::emitters) primitive: PrimitiveId,
    pub(in crate::emitters) shape: ElementShape,
    /// In m²; 0 for points and spots.
    pub(in crate::emitters) area: f32,
}

/// Bounds of an element for the emitter tree.
#[derive(Clone, Copy, Debug)]
pub(in crate::emitters) struct ElementBounds {
    pub(in crate::emitters) bounds: Aabb,
    /// A cone of all normals.
    pub(in crate::emitters) normals: Cone,
    /// Largest angle in radians between a direction of emission and the nearest normal.
    pub(in crate::emitters) emission: f32,
    /// Emitted flux in W.
    pub(in crate::emitters) power: Rgb,
}

impl ElementBounds {
    /// The center, and the selection weight of the power.
    pub(in crate::emitters) fn center_and_weight(&self) -> (Vec3, f32) {
        (self.bounds.center(), self.power.selection_weight())
    }
}

impl EmitterElement {
    /// What emits the light of the element.
    pub(in crate::emitters) fn source(&self) -> EmissionSource {
        match self.shape {
            ElementShape::Point => EmissionSource::Emitter(self.emitter),
            _ => EmissionSource::Surface(self.primitive),
        }
    }

    /// Density of [`EmitterElement::sample_area`] in 1/m².
    pub(in crate::emitters) fn pdf_area(&self, y: &SurfacePoint) -> f32 {
        match self.shape {
            ElementShape::Stretched { uv_density } => {
                uv_density(y.uv) / y.dp_du.cross(y.dp_dv).length()
            }
            _ => 1.0 / self.area,
        }
    }

    /// A point of a surface; uniform by area, except for [`ElementShape::Stretched`].
    pub(in crate::emitters) fn sample_area(
        &self,
        geometry: &Geometry,
        u: Vec2,
    ) -> Option<SurfacePoint> {
        Some(geometry.surface_point(self.sample_ref(geometry, u)?))
    }

    /// [`EmitterElement::sample_area`] by reference.
    pub(super) fn sample_ref(&self, geometry: &Geometry, u: Vec2) -> Option<SurfaceRef> {
        match self.shape {
            ElementShape::Primitive | ElementShape::Stretched { .. } => {
                Some(geometry.sample_area_ref(self.primitive, u)?.0)
            }
            ElementShape::Triangle { index } => {
                Some(surface_ref(self.primitive, index, warp::triangle(u)))
            }
            ElementShape::Point => None,
        }
    }
}

/// Refers to a point of a triangle (or of a shape without triangles) outside of instances.
pub(super) fn surface_ref(primitive: PrimitiveId, element: u32, coordinates: Vec2) -> SurfaceRef {
    SurfaceRef {
        primitive,
        element,
        instance: SurfaceRef::NO_INSTANCE,
        coordinates,
    }
}
