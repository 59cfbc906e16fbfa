//! Shapes under their transforms: points on surfaces, areas, and sampling by area.

mod instance;
mod mesh;
mod numbering;
mod runs;
mod table;
mod triangle;
mod vertex;

pub(super) use instance::PlacedInstance;
pub(super) use numbering::Numbering;
pub(super) use table::TriangleTable;

use super::analytic::Analytic;
use super::surface_point::OFFSET_ROUNDINGS;
use super::{Hit, Mesh, Primitive, Ray, Segment, Shape, SurfacePoint, SurfaceRef};
use crate::ids::PrimitiveId;
use crate::math::{Frame, Vec2};
use crate::sampling::warp;
use std::ops::Range;
use std::sync::OnceLock;
use triangle::PlacedTriangle;

/// A shape under its transform.
#[derive(Debug)]
pub(super) enum PlacedShape {
    /// Triangles, transformed into the world or the group.
    Mesh {
        /// All triangles in the order of the mesh, as a range of the table.
        triangles: Range<u32>,
        /// Cumulative sums of twice the areas of the triangles; computed on first use.
        cumulative: OnceLock<Vec<f64>>,
    },
    /// A sphere, disk or cylinder.
    Analytic {
        /// Unit shape with its transform.
        shape: Analytic,
        /// Whether the normals are reversed.
        flip: bool,
        /// Area under the transform.
        area: f32,
    },
}

impl PlacedShape {
    /// The shape of the primitive with this index, which has its triangles in the table.
    pub(super) fn new(
        shape: &Shape,
        primitive: &Primitive,
        index: usize,
        table: &TriangleTable,
    ) -> Self {
        if let Some(shape) = Analytic::new(shape, &primitive.world_from_object) {
            return PlacedShape::Analytic {
                shape,
                flip: primitive.flip_normals,
                area: shape.area(),
            };
        }
        PlacedShape::Mesh {
            triangles: table.range(index, mesh_of(shape).triangles.len()),
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

    /// The point of an analytic shape that a reference names; `None` for meshes.
    pub(super) fn analytic_point(&self, at: SurfaceRef) -> Option<SurfacePoint> {
        let PlacedShape::Analytic { shape, flip, .. } = self else {
            return None;
        };
        let point = analytic_point(shape, at);
        Some(if *flip { flipped(point) } else { point })
    }

    /// Area under the transform.
    pub(super) fn area(&self, table: &TriangleTable) -> f32 {
        match self {
            PlacedShape::Mesh {
                triangles,
                cumulative,
            } => {
                let areas = cumulative_areas(cumulative, table, triangles);
                (0.5 * areas.last().copied().unwrap_or(0.0)) as f32
            }
            PlacedShape::Analytic { area, .. } => *area,
        }
    }

    /// Element, coordinates and density by area of a point drawn by area; `None` if the area is 0.
    pub(super) fn sample(&self, table: &TriangleTable, u: Vec2) -> Option<(u32, Vec2, f32)> {
        match self {
            PlacedShape::Analytic { area, .. } if *area <= 0.0 => None,
            PlacedShape::Analytic { shape, .. } => {
                let (coordinates, pdf_area) = shape.sample(u);
                Some((0, coordinates, pdf_area))
            }
            PlacedShape::Mesh {
                triangles,
                cumulative,
            } => {
                let areas = cumulative_areas(cumulative, table, triangles);
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
                    1.0 / self.area(table),
                ))
            }
        }
    }
}

/// For each triangle the sum of twice the areas up to and including it.
fn cumulative_areas<'a>(
    areas: &'a OnceLock<Vec<f64>>,
    table: &TriangleTable,
    triangles: &Range<u32>,
) -> &'a [f64] {
    areas.get_or_init(|| {
        let placed = table.triangles(triangles.clone()).iter();
        let twice = placed.map(PlacedTriangle::twice_area);
        twice
            .scan(0.0, |sum, area| {
                *sum += area;
                Some(*sum)
            })
            .collect()
    })
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

fn analytic_point(shape: &Analytic, at: SurfaceRef) -> SurfacePoint {
    /// Addition to the magnitude of a point in the offset, in units of the shape's size. Points are
    /// exact in `f64`, so that their own magnitude bounds the rounding; the addition keeps the
    /// offset above zero near the origin.
    const SHARE_OF_SIZE: f32 = 1e-3;
    let point = shape.point(at.coordinates);
    let magnitude = point.p.abs().max_element() + SHARE_OF_SIZE * shape.scale();
    SurfacePoint {
        p: point.p,
        ng: point.ng,
        frame: Frame::from_normal_and_tangent(point.ng, point.dp_du),
        uv: point.uv,
        dp_du: point.dp_du,
        dp_dv: point.dp_dv,
        at,
        offset: OFFSET_ROUNDINGS * 0.5 * f32::EPSILON * magnitude,
    }
}

/// The same point with both normals reversed.
fn flipped(point: SurfacePoint) -> SurfacePoint {
    let Frame { s, t, n } = point.frame;
    SurfacePoint {
        ng: -point.ng,
        frame: Frame { s, t: -t, n: -n },
        ..point
    }
}
