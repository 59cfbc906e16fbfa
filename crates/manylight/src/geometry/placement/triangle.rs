//! Triangles under the transform of their mesh: normals, offsets and parametrizations.

use super::{OFFSET_ROUNDINGS, Surface};
use crate::geometry::Mesh;
use crate::math::{Affine3A, Frame, Mat3, Vec2, Vec3};
use glam::Mat3A;

/// Largest ratio of longest edge to height that enlarges the offset. For longer slivers a safe offset would no longer be small against
/// the scene.
const MAX_SLENDERNESS: f32 = 1000.0;

/// Weight of the product of longest edge and slenderness in the offset. The rounding of the normal grows with the slenderness and moves the
/// plane in proportion to the longest edge. Larger weights are safer, smaller ones leak less light at contacts.
const EXTENT_WEIGHT: f32 = 0.25;

/// The constants of a triangle in one cache line, so that a hit reads no corners from the mesh.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(in crate::geometry) struct PlacedTriangle {
    pub(super) corners: [Vec3; 3],
    /// Unit geometric normal.
    ng: Vec3,
    /// Unit vector along `dp_du`.
    tangent: Vec3,
    /// Distance of ray origins from the surface; see [`SurfacePoint::offset`](crate::geometry::SurfacePoint::offset).
    offset: f32,
}

impl PlacedTriangle {
    pub(super) fn new(mesh: &Mesh, transform: &Affine3A, triangle: usize) -> Self {
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
            offset: OFFSET_ROUNDINGS * 0.5 * f32::EPSILON * (magnitude + EXTENT_WEIGHT * extent),
        }
    }

    /// Twice the area of the triangle.
    pub(super) fn twice_area(&self) -> f64 {
        let [a, b, c] = self.corners.map(Vec3::as_dvec3);
        (b - a).cross(c - a).length()
    }

    /// The point with the barycentric coordinates `at` of the second and third corner.
    #[inline]
    pub(super) fn surface(
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
                let tangent = match mesh.tangents.is_empty() {
                    true => self.tangent,
                    false => normals.tangent_of_triangle(mesh, triangle, at),
                };
                Frame::from_normal_and_tangent(ns, tangent)
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

/// Transform of vertex normals and tangents.
#[derive(Clone, Copy, Debug)]
pub(in crate::geometry) struct NormalTransform {
    /// Inverse transpose of the transform.
    matrix: Mat3,
    /// The transform, for tangents.
    tangents: Mat3,
    /// Whether all lengths scale alike, so that normals may be interpolated before the transform.
    is_similarity: bool,
}

impl NormalTransform {
    pub(super) fn new(transform: &Affine3A) -> Self {
        /// Relative difference of squared scales that counts as equal.
        const SIMILARITY: f32 = 1e-5;
        let m = transform.matrix3;
        let scale = m.x_axis.length_squared();
        let gram = m.transpose() * m;
        let is_similarity =
            gram.abs_diff_eq(Mat3A::from_diagonal(Vec3::splat(scale)), SIMILARITY * scale);
        NormalTransform {
            matrix: m.inverse().transpose().into(),
            tangents: m.into(),
            is_similarity,
        }
    }

    /// The interpolated normal of a triangle, transformed, not normalized.
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

    /// The interpolated tangent of a triangle, transformed, not normalized.
    #[inline]
    fn tangent_of_triangle(&self, mesh: &Mesh, triangle: usize, at: Vec2) -> Vec3 {
        let [a, b, c] = mesh.triangles[triangle].map(|i| mesh.tangents[i as usize]);
        self.tangents * (a * (1.0 - at.x - at.y) + b * at.x + c * at.y)
    }

    /// Whether there are no vertex tangents, and all vertex normals equal the geometric normals of their triangles up to rounding.
    pub(super) fn is_idle(&self, mesh: &Mesh, triangles: &[PlacedTriangle]) -> bool {
        /// Difference per component that counts as equal.
        const ROUNDING: f32 = 4.0 * f32::EPSILON;
        let is_flat = |i: usize, at: Vec2| {
            let ng = triangles[i].ng;
            self.of_triangle(mesh, i, at)
                .normalize_or(ng)
                .abs_diff_eq(ng, ROUNDING)
        };
        let corners = [Vec2::ZERO, Vec2::X, Vec2::Y];
        mesh.tangents.is_empty()
            && (mesh.normals.is_empty()
                || (0..triangles.len()).all(|i| corners.iter().all(|&at| is_flat(i, at))))
    }
}

/// Unit normal, and slenderness: the ratio of the longest edge to the height.
fn normal_and_slenderness(ab: Vec3, ac: Vec3, longest_squared: f32) -> (Vec3, f32) {
    /// Slenderness from which the normal is computed in `f64`: in `f32` it would lose significant digits.
    const SLIVER: f32 = 16.0;
    let normal = ab.cross(ac);
    let length = normal.length();
    let slenderness = longest_squared / length;
    if slenderness < SLIVER {
        return (normal / length, slenderness);
    }
    // The cross product is a small difference of large products, or underflows.
    let normal = ab.as_dvec3().cross(ac.as_dvec3());
    let slenderness = f64::from(longest_squared) / normal.length();
    (
        normal.normalize_or(glam::DVec3::Z).as_vec3(),
        slenderness.min(f32::MAX.into()) as f32,
    )
}

/// Texture coordinates of a point of a triangle.
#[inline]
pub(super) fn texture_coordinates(mesh: &Mesh, triangle: usize, at: Vec2) -> Vec2 {
    if mesh.uvs.is_empty() {
        return at;
    }
    let [a, b, c] = mesh.triangles[triangle].map(|i| mesh.uvs[i as usize]);
    a * (1.0 - at.x - at.y) + b * at.x + c * at.y
}

/// Texture coordinates, and the derivatives of the position by u and by v.
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
