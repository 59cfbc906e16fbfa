//! Shapes under their transforms: points on surfaces, areas, and sampling by area.

mod instance;
mod triangle;

pub(super) use instance::PlacedInstance;

use super::analytic::Analytic;
use super::{Hit, Mesh, Ray, Segment, Shape, SurfaceRef};
use crate::ids::PrimitiveId;
use crate::math::prefetch::prefetch;
use crate::math::{Affine3A, Frame, Vec2, Vec3};
use crate::sampling::warp;
use rayon::prelude::*;
use std::sync::OnceLock;
use triangle::{NormalTransform, PlacedTriangle, texture_coordinates};

/// Offset of ray origins from their surface, in units of the rounding of the coordinates.
///
/// Estimated: two roundings in the point (a sum of three products), one in the sum of point and offset, about three in the distance to
/// the plane. Twice the sum allows for an angle between the offset and the exact normal.
const OFFSET_ROUNDINGS: f32 = 12.0;

/// A point on a surface with its outer normals; fields as in [`SurfacePoint`](super::SurfacePoint).
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    pub(super) p: Vec3,
    pub(super) ng: Vec3,
    pub(super) frame: Frame,
    pub(super) uv: Vec2,
    pub(super) dp_du: Vec3,
    pub(super) dp_dv: Vec3,
    pub(super) offset: f32,
}

impl Surface {
    /// The same point with both normals reversed.
    #[inline]
    pub(super) fn flipped(self) -> Self {
        let Frame { s, t, n } = self.frame;
        Surface {
            ng: -self.ng,
            frame: Frame { s, t: -t, n: -n },
            ..self
        }
    }
}

/// A shape under its transform.
#[derive(Debug)]
pub(super) enum PlacedShape {
    /// Triangles, transformed into the world or the group.
    Mesh {
        /// All triangles in the order of the mesh.
        triangles: Vec<PlacedTriangle>,
        /// Transform of the vertex normals; `None` if the shading normals equal the geometric ones.
        normals: Option<NormalTransform>,
        /// Area under the transform.
        area: f32,
        /// Cumulative sums of twice the areas of the triangles; computed on first use.
        cumulative: OnceLock<Vec<f64>>,
    },
    /// A sphere, disk or cylinder.
    Analytic {
        /// Unit shape with its transform.
        shape: Analytic,
        /// Area under the transform.
        area: f32,
    },
}

impl PlacedShape {
    pub(super) fn new(shape: &Shape, world_from_object: &Affine3A) -> Self {
        if let Some(shape) = Analytic::new(shape, world_from_object) {
            return PlacedShape::Analytic {
                shape,
                area: shape.area(),
            };
        }
        let mesh = mesh_of(shape);
        let triangles: Vec<PlacedTriangle> = (0..mesh.triangles.len())
            .into_par_iter()
            .map(|i| PlacedTriangle::new(mesh, world_from_object, i))
            .collect();
        let area: f64 = triangles.iter().map(PlacedTriangle::twice_area).sum();
        let normals = NormalTransform::new(world_from_object);
        let normals = (!normals.is_idle(mesh, &triangles)).then_some(normals);
        PlacedShape::Mesh {
            triangles,
            normals,
            area: (0.5 * area) as f32,
            cumulative: OnceLock::new(),
        }
    }

    /// The shape, if it is not a mesh.
    pub(super) fn analytic(&self) -> Option<&Analytic> {
        match self {
            PlacedShape::Mesh { .. } => None,
            PlacedShape::Analytic { shape, .. } => Some(shape),
        }
    }

    /// Appends the corners of the transformed triangles of a mesh.
    pub(super) fn bake(&self, out: &mut Vec<[Vec3; 3]>) {
        if let PlacedShape::Mesh { triangles, .. } = self {
            /// Triangles per task: smaller tasks cost more to distribute than to copy.
            const SMALL: usize = 1 << 14;
            let corners = triangles.par_iter().with_min_len(SMALL);
            out.par_extend(corners.map(|triangle| triangle.corners));
        }
    }

    /// The nearest hit on an analytic shape; `None` for meshes.
    pub(super) fn intersect_analytic(&self, primitive: PrimitiveId, ray: &Ray) -> Option<Hit> {
        let PlacedShape::Analytic { shape, .. } = self else {
            return None;
        };
        let (t, coordinates) = shape.intersect(ray.o, ray.d, ray.t_max)?;
        let at = SurfaceRef {
            primitive,
            element: 0,
            instance: SurfaceRef::NO_INSTANCE,
            coordinates,
        };
        Some(Hit { t, at })
    }

    /// Whether an analytic shape cuts the segment; false for meshes.
    pub(super) fn blocks(&self, segment: &Segment) -> bool {
        let PlacedShape::Analytic { shape, .. } = self else {
            return false;
        };
        shape
            .intersect(segment.from, segment.to - segment.from, 1.0)
            .is_some()
    }

    /// The surface point with these coordinates.
    #[inline]
    pub(super) fn surface(&self, shape: &Shape, element: u32, coordinates: Vec2) -> Surface {
        match self {
            PlacedShape::Analytic { shape, .. } => analytic_surface(shape, coordinates),
            PlacedShape::Mesh {
                triangles, normals, ..
            } => {
                let element = element as usize;
                triangles[element].surface(mesh_of(shape), normals.as_ref(), element, coordinates)
            }
        }
    }

    /// The texture coordinates of [`PlacedShape::surface`].
    #[inline]
    pub(super) fn uv(&self, shape: &Shape, element: u32, coordinates: Vec2) -> Vec2 {
        match self {
            PlacedShape::Analytic { shape, .. } => analytic_surface(shape, coordinates).uv,
            PlacedShape::Mesh { .. } => {
                texture_coordinates(mesh_of(shape), element as usize, coordinates)
            }
        }
    }

    /// Prefetches the memory of a triangle for [`PlacedShape::surface`].
    #[inline]
    pub(super) fn prefetch(&self, shape: &Shape, element: u32) {
        if let PlacedShape::Mesh { triangles, .. } = self {
            prefetch(&triangles[element as usize]);
            prefetch(&mesh_of(shape).triangles[element as usize]);
        }
    }

    /// Prefetches the vertex attributes of a triangle. Reads the indices that [`PlacedShape::prefetch`] has asked for.
    #[inline]
    pub(super) fn prefetch_vertices(&self, shape: &Shape, element: u32) {
        if let PlacedShape::Mesh { normals, .. } = self {
            let mesh = mesh_of(shape);
            for i in mesh.triangles[element as usize] {
                if normals.is_some() {
                    prefetch(&mesh.normals[i as usize]);
                }
                if !mesh.uvs.is_empty() {
                    prefetch(&mesh.uvs[i as usize]);
                }
            }
        }
    }

    /// Area under the transform.
    pub(super) fn area(&self) -> f32 {
        match self {
            PlacedShape::Mesh { area, .. } | PlacedShape::Analytic { area, .. } => *area,
        }
    }

    /// Element, coordinates and density by area of a point drawn by area; `None` if the area is 0.
    pub(super) fn sample(&self, u: Vec2) -> Option<(u32, Vec2, f32)> {
        match self {
            PlacedShape::Analytic { area, .. } if *area <= 0.0 => None,
            PlacedShape::Analytic { shape, .. } => {
                let (coordinates, pdf_area) = shape.sample(u);
                Some((0, coordinates, pdf_area))
            }
            PlacedShape::Mesh {
                triangles,
                area,
                cumulative,
                ..
            } => {
                let areas = cumulative.get_or_init(|| cumulative_areas(triangles));
                let total = areas.last().copied().filter(|&total| total > 0.0)?;
                let target = f64::from(u.x) * total;
                let element = areas
                    .partition_point(|&sum| sum <= target)
                    .min(areas.len() - 1);
                // What the choice of the triangle leaves of `u.x` is uniform again.
                let below = if element == 0 {
                    0.0
                } else {
                    areas[element - 1]
                };
                let rest = ((target - below) / (areas[element] - below)) as f32;
                Some((
                    element as u32,
                    warp::triangle(Vec2::new(rest.min(1.0), u.y)),
                    1.0 / area,
                ))
            }
        }
    }
}

/// For each triangle the sum of twice the areas up to and including it.
fn cumulative_areas(triangles: &[PlacedTriangle]) -> Vec<f64> {
    let areas = triangles.iter().map(PlacedTriangle::twice_area);
    areas
        .scan(0.0, |sum, area| {
            *sum += area;
            Some(*sum)
        })
        .collect()
}

#[inline]
fn mesh_of(shape: &Shape) -> &Mesh {
    match shape {
        Shape::Mesh(mesh) => mesh,
        Shape::Sphere { .. } | Shape::Disk | Shape::Cylinder { .. } => {
            unreachable!("invariant: a shape that is not analytic is a mesh")
        }
    }
}

fn analytic_surface(shape: &Analytic, coordinates: Vec2) -> Surface {
    /// Addition to the magnitude of a point in the offset, in units of the shape's size. Points are exact in `f64`, so that their own
    /// magnitude bounds the rounding; the addition keeps the offset above zero near the origin.
    const SHARE_OF_SIZE: f32 = 1e-3;
    let point = shape.point(coordinates);
    let magnitude = point.p.abs().max_element() + SHARE_OF_SIZE * shape.scale();
    Surface {
        p: point.p,
        ng: point.ng,
        frame: Frame::from_normal_and_tangent(point.ng, point.dp_du),
        uv: point.uv,
        dp_du: point.dp_du,
        dp_dv: point.dp_dv,
        offset: OFFSET_ROUNDINGS * 0.5 * f32::EPSILON * magnitude,
    }
}
