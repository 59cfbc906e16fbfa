//! Shapes under their transforms: baking, points on surfaces, areas.

use super::analytic::{Analytic, affine_f64};
use super::{Hit, Mesh, Ray, Segment, Shape, SurfaceRef};
use crate::ids::PrimitiveId;
use crate::math::prefetch::prefetch;
use crate::math::{Aabb, Affine3A, Frame, Mat3, Vec2, Vec3};
use crate::sampling::warp;
use glam::{DAffine3, Mat3A};
use rayon::prelude::*;
use std::sync::OnceLock;

/// How far rays start off a surface, in roundings of the coordinates that are involved.
///
/// A point is off its surface by about two roundings (a sum of three products), the start of the ray by one more (the
/// sum of point and offset), and the distance to the plane is computed with about three. Twice the sum leaves room for
/// angles between the direction of the offset and that of the exact normal.
const OFFSET_ROUNDINGS: f32 = 12.0;

/// Slivers longer than this times their height are treated as if they were not: no offset would be safe for them that
/// is still small against the scene.
const MAX_SLENDERNESS: f32 = 1000.0;

/// A shape under its transform.
#[derive(Debug)]
pub(super) enum PlacedShape {
    /// Triangles, baked into the world (or the group).
    Mesh {
        /// In the order of the mesh.
        triangles: Vec<PlacedTriangle>,
        /// Takes normals there; `None` where all of them are the triangles' own.
        normals: Option<NormalTransform>,
        /// In the world.
        area: f32,
        /// Running sums of the triangles' areas (times two); made when first asked for.
        cumulative: OnceLock<Vec<f64>>,
    },
    /// Anything else.
    Analytic {
        /// The placed shape.
        shape: Analytic,
        /// In the world.
        area: f32,
    },
}

/// All that is constant over a triangle: one cache line, so that a hit need not look its corners up in the mesh.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct PlacedTriangle {
    corners: [Vec3; 3],
    ng: Vec3,
    /// Unit vector along `dp_du`.
    tangent: Vec3,
    /// See [`Surface::offset`].
    offset: f32,
}

impl PlacedTriangle {
    fn new(mesh: &Mesh, transform: &Affine3A, triangle: usize) -> Self {
        let corners = mesh.triangles[triangle]
            .map(|i| transform.transform_point3(mesh.positions[i as usize]));
        let [a, b, c] = corners;
        let (ab, ac) = (b - a, c - a);
        let longest = ab
            .length_squared()
            .max(ac.length_squared())
            .max((c - b).length_squared());
        let (ng, slenderness) = normal_and_slenderness(ab, ac, longest);
        let magnitude = a.abs().max(b.abs()).max(c.abs()).max_element();
        let extent = longest.sqrt() * slenderness.min(MAX_SLENDERNESS);
        let (_, dp_du, _) = parametrization(mesh, triangle, Vec2::ZERO, ng, ab, ac);
        PlacedTriangle {
            corners,
            ng,
            tangent: Frame::from_normal_and_tangent(ng, dp_du).s,
            offset: OFFSET_ROUNDINGS * 0.5 * f32::EPSILON * (magnitude + 0.25 * extent),
        }
    }

    fn twice_area(&self) -> f64 {
        let [a, b, c] = self.corners.map(Vec3::as_dvec3);
        (b - a).cross(c - a).length()
    }

    #[inline]
    fn surface(
        &self,
        mesh: &Mesh,
        normals: Option<&NormalTransform>,
        triangle: usize,
        at: Vec2,
    ) -> Surface {
        let [a, b, c] = self.corners;
        let (ng, weight_a) = (self.ng, 1.0 - at.x - at.y);
        let frame = match normals {
            None => Frame {
                s: self.tangent,
                t: ng.cross(self.tangent),
                n: ng,
            },
            Some(normals) => {
                let ns = normals.of_triangle(mesh, triangle, at).normalize_or(ng);
                Frame::from_normal_and_tangent(ns, self.tangent)
            }
        };
        let (uv, dp_du, dp_dv) = parametrization(mesh, triangle, at, ng, b - a, c - a);
        Surface {
            p: a * weight_a + b * at.x + c * at.y,
            ng,
            frame,
            uv,
            dp_du,
            dp_dv,
            offset: self.offset,
        }
    }
}

/// Takes the normals of vertices to another space.
#[derive(Clone, Copy, Debug)]
pub(super) struct NormalTransform {
    /// The inverse transpose.
    matrix: Mat3,
    /// Lengths change all alike, so that the interpolated normal need not care.
    is_similarity: bool,
}

impl NormalTransform {
    fn new(transform: &Affine3A) -> Self {
        let m = transform.matrix3;
        let scale = m.x_axis.length_squared();
        let gram = m.transpose() * m;
        let is_similarity =
            gram.abs_diff_eq(Mat3A::from_diagonal(Vec3::splat(scale)), 1e-5 * scale);
        NormalTransform {
            matrix: m.inverse().transpose().into(),
            is_similarity,
        }
    }

    /// The normal between those of a triangle's vertices, not normalized.
    #[inline]
    fn of_triangle(&self, mesh: &Mesh, triangle: usize, at: Vec2) -> Vec3 {
        let corners = mesh.triangles[triangle].map(|i| mesh.normals[i as usize]);
        let mix = |[a, b, c]: [Vec3; 3]| a * (1.0 - at.x - at.y) + b * at.x + c * at.y;
        let transformed = |n: Vec3| self.matrix * n;
        if self.is_similarity {
            transformed(mix(corners))
        } else {
            mix(corners.map(|n| transformed(n).normalize_or_zero()))
        }
    }

    /// Whether no normal of the mesh differs from its triangles' own by more than rounding.
    fn is_idle(&self, mesh: &Mesh, triangles: &[PlacedTriangle]) -> bool {
        const ROUNDING: f32 = 4.0 * f32::EPSILON;
        let is_flat = |i: usize, at: Vec2| {
            let ng = triangles[i].ng;
            self.of_triangle(mesh, i, at)
                .normalize_or(ng)
                .abs_diff_eq(ng, ROUNDING)
        };
        let corners = [Vec2::ZERO, Vec2::X, Vec2::Y];
        mesh.normals.is_empty()
            || (0..triangles.len()).all(|i| corners.iter().all(|&at| is_flat(i, at)))
    }
}

/// A point on a surface, its normals outwards.
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
    /// The same point with both normals turned round.
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

    /// Appends the triangles of a mesh in the space that the transform leads to.
    pub(super) fn bake(&self, out: &mut Vec<[Vec3; 3]>) {
        if let PlacedShape::Mesh { triangles, .. } = self {
            // Small meshes are copied before another thread could come to help.
            const SMALL: usize = 1 << 14;
            let corners = triangles.par_iter().with_min_len(SMALL);
            out.par_extend(corners.map(|triangle| triangle.corners));
        }
    }

    /// The nearest hit on an analytic shape.
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

    /// Whether an analytic shape cuts the segment.
    pub(super) fn blocks(&self, segment: &Segment) -> bool {
        let PlacedShape::Analytic { shape, .. } = self else {
            return false;
        };
        shape
            .intersect(segment.from, segment.to - segment.from, 1.0)
            .is_some()
    }

    /// The point that a reference names.
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

    /// Asks for the memory of a triangle that [`PlacedShape::surface`] will read.
    #[inline]
    pub(super) fn prefetch(&self, shape: &Shape, element: u32) {
        if let PlacedShape::Mesh { triangles, .. } = self {
            prefetch(&triangles[element as usize]);
            prefetch(&mesh_of(shape).triangles[element as usize]);
        }
    }

    /// The same for the triangle's vertices, once [`PlacedShape::expect`] has had its time.
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

    /// Area where the transform leads to.
    pub(super) fn area(&self) -> f32 {
        match self {
            PlacedShape::Mesh { area, .. } | PlacedShape::Analytic { area, .. } => *area,
        }
    }

    /// Element, coordinates and density of a point drawn by area; `None` without area.
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
                // The choice of the triangle leaves a uniform number over.
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

/// Twice the area of all triangles up to and including each.
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

/// Unit normal, and longest edge over height.
fn normal_and_slenderness(ab: Vec3, ac: Vec3, longest_squared: f32) -> (Vec3, f32) {
    /// Beyond this the normal loses digits that matter in `f32`.
    const SLIVER: f32 = 16.0;
    let normal = ab.cross(ac);
    let length = normal.length();
    let slenderness = longest_squared / length;
    if slenderness < SLIVER {
        return (normal / length, slenderness);
    }
    // A small difference of large products, or products that underflow.
    let normal = ab.as_dvec3().cross(ac.as_dvec3());
    let slenderness = f64::from(longest_squared) / normal.length();
    (
        normal.normalize_or(glam::DVec3::Z).as_vec3(),
        slenderness.min(f32::MAX.into()) as f32,
    )
}

/// Texture coordinates of a point of a triangle.
#[inline]
fn texture_coordinates(mesh: &Mesh, triangle: usize, at: Vec2) -> Vec2 {
    if mesh.uvs.is_empty() {
        return at;
    }
    let [a, b, c] = mesh.triangles[triangle].map(|i| mesh.uvs[i as usize]);
    a * (1.0 - at.x - at.y) + b * at.x + c * at.y
}

/// [`texture_coordinates`], and the derivatives of the position by them.
#[inline]
fn parametrization(
    mesh: &Mesh,
    triangle: usize,
    at: Vec2,
    ng: Vec3,
    ab: Vec3,
    ac: Vec3,
) -> (Vec2, Vec3, Vec3) {
    let uv = texture_coordinates(mesh, triangle, at);
    if mesh.uvs.is_empty() {
        return (uv, ab, ac);
    }
    let [a, b, c] = mesh.triangles[triangle].map(|i| mesh.uvs[i as usize]);
    let (b, c) = (b - a, c - a);
    let inverse = 1.0 / b.perp_dot(c);
    if !inverse.is_finite() {
        let frame = Frame::from_normal(ng);
        return (uv, frame.s, frame.t);
    }
    (
        uv,
        (ab * c.y - ac * b.y) * inverse,
        (ac * b.x - ab * c.x) * inverse,
    )
}

fn analytic_surface(shape: &Analytic, coordinates: Vec2) -> Surface {
    /// The points are exact in `f64`, so that their own magnitude counts; this share of the shape's size keeps the
    /// offset above zero where the surface passes the origin.
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

/// A group under its transform.
#[derive(Debug)]
pub(super) struct PlacedInstance {
    group: usize,
    world_from_group: DAffine3,
    group_from_world: DAffine3,
}

impl PlacedInstance {
    pub(super) fn new(group: u32, world_from_group: &Affine3A) -> Self {
        let world_from_group = affine_f64(world_from_group);
        PlacedInstance {
            group: group as usize,
            world_from_group,
            group_from_world: world_from_group.inverse(),
        }
    }

    pub(super) fn group(&self) -> usize {
        self.group
    }

    /// The box in the world around a box in the group.
    pub(super) fn bounds(&self, group: Aabb) -> Aabb {
        if group.is_empty() {
            return group;
        }
        let b = Aabb::from_points(group.corners().map(|c| {
            self.world_from_group
                .transform_point3(c.as_dvec3())
                .as_vec3()
        }));
        // Rays are rounded when they enter the group, so what they hit there may seem to lie a little outside.
        let margin = 4.0 * f32::EPSILON * self.magnitude(group.min.abs().max(group.max.abs()));
        Aabb {
            min: b.min - margin,
            max: b.max + margin,
        }
    }

    /// The same ray in the group; distances along it keep their values.
    pub(super) fn ray_in_group(&self, ray: &Ray) -> Ray {
        Ray {
            o: self.point_in_group(ray.o),
            d: self
                .group_from_world
                .transform_vector3(ray.d.as_dvec3())
                .as_vec3(),
            t_max: ray.t_max,
        }
    }

    pub(super) fn segment_in_group(&self, segment: &Segment) -> Segment {
        Segment {
            from: self.point_in_group(segment.from),
            to: self.point_in_group(segment.to),
        }
    }

    pub(super) fn point_in_group(&self, p: Vec3) -> Vec3 {
        self.group_from_world
            .transform_point3(p.as_dvec3())
            .as_vec3()
    }

    pub(super) fn surface_in_world(&self, surface: &Surface) -> Surface {
        let vector = |v: Vec3| {
            self.world_from_group
                .transform_vector3(v.as_dvec3())
                .as_vec3()
        };
        let normals = self.group_from_world.matrix3.transpose();
        let normal = |n: Vec3| (normals * n.as_dvec3()).normalize_or_zero().as_vec3();
        let dp_du = vector(surface.dp_du);
        Surface {
            p: self
                .world_from_group
                .transform_point3(surface.p.as_dvec3())
                .as_vec3(),
            ng: normal(surface.ng),
            frame: Frame::from_normal_and_tangent(normal(surface.frame.n), dp_du),
            uv: surface.uv,
            dp_du,
            dp_dv: vector(surface.dp_dv),
            // On the way back into the group the start of a ray is rounded once more, there and here.
            offset: self.stretch() * surface.offset
                + OFFSET_ROUNDINGS * 0.5 * f32::EPSILON * self.magnitude(surface.p.abs()),
        }
    }

    /// No vector becomes longer than this times its length.
    fn stretch(&self) -> f32 {
        let m = &self.world_from_group.matrix3;
        (m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared()).sqrt()
            as f32
    }

    /// Largest term in the sums that take a point with these absolute coordinates to the world.
    fn magnitude(&self, p: Vec3) -> f32 {
        self.stretch() * p.max_element()
            + self.world_from_group.translation.abs().max_element() as f32
    }
}
