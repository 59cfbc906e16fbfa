//! Triangles under the transform of their mesh: normals, offsets and parametrizations.

use crate::geometry::Mesh;
use crate::geometry::surface_point::OFFSET_ROUNDINGS;
use crate::lanes::{Axes, One, Pair, Vector, Width};
use crate::math::{Affine3A, Frame, Vec3};

/// Largest ratio of longest edge to height that enlarges the offset. For longer slivers a safe
/// offset would no longer be small against the scene.
const MAX_SLENDERNESS: f32 = 1000.0;

/// Weight of the product of longest edge and slenderness in the offset. The rounding of the normal
/// grows with the slenderness and moves the plane in proportion to the longest edge. Larger weights
/// are safer, smaller ones leak less light at contacts.
const EXTENT_WEIGHT: f32 = 0.25;

/// A triangle for surface points: all that is the same at its points, and where its vertices are. A
/// hit reads no corners from the mesh.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub(in crate::geometry) struct PlacedTriangle {
    /// By rows: the corners, each before one number, then the unit geometric normal, outer after
    /// `flip_normals`. The numbers are the distance of ray origins from the surface (see
    /// [`SurfacePoint::offset`](crate::geometry::SurfacePoint::offset)) and x and y of the unit
    /// vector along `dp_du`; z of that vector follows the normal.
    pub(super) constants: [[f32; 4]; 4],
    /// Indices of the vertices in the table.
    pub(super) vertices: [u32; 3],
    /// Index of a vertex minus that of its tangent; 0 without vertex tangents.
    pub(super) tangents_behind: u32,
}

impl PlacedTriangle {
    /// A triangle in the place of those that do not exist.
    pub(super) const NONE: PlacedTriangle = PlacedTriangle {
        constants: [
            [0.0; 4],
            [0.0, 0.0, 0.0, 1.0],
            [0.0; 4],
            [0.0, 0.0, 1.0, 0.0],
        ],
        vertices: [0; 3],
        tangents_behind: 0,
    };

    /// The triangle of a mesh, with the indices of vertices that it has there and without vertex
    /// tangents.
    pub(super) fn new(mesh: &Mesh, transform: &Affine3A, flip: bool, triangle: usize) -> Self {
        let vertices = mesh.triangles[triangle];
        let corners = vertices.map(|i| transform.transform_point3(mesh.positions[i as usize]));
        let [a, b, c] = corners;
        let (ab, ac) = (b - a, c - a);
        let longest = ab
            .length_squared()
            .max(ac.length_squared())
            .max((c - b).length_squared());
        let (ng, slenderness) = normal_and_slenderness(ab, ac, longest);
        let ng = if flip { -ng } else { ng };
        let magnitude = a.abs().max(b.abs()).max(c.abs()).max_element();
        let extent = longest.sqrt() * slenderness.min(MAX_SLENDERNESS);
        let offset = OFFSET_ROUNDINGS * 0.5 * f32::EPSILON * (magnitude + EXTENT_WEIGHT * extent);
        let dp_du = dp_du(mesh, triangle, ng, [ab, ac]);
        let tangent = Frame::from_normal_and_tangent(ng, dp_du).s;
        let row = |v: Vec3, number: f32| v.extend(number).to_array();
        PlacedTriangle {
            constants: [
                row(a, offset),
                row(b, tangent.x),
                row(c, tangent.y),
                row(ng, tangent.z),
            ],
            vertices,
            tangents_behind: 0,
        }
    }

    /// The three corners.
    #[inline]
    pub(super) fn corners(&self) -> [Vec3; 3] {
        let [a, b, c, _] = self.constants;
        [a, b, c].map(|[x, y, z, _]| Vec3::new(x, y, z))
    }

    /// Unit geometric normal.
    #[inline]
    pub(super) fn ng(&self) -> Vec3 {
        let [x, y, z, _] = self.constants[3];
        Vec3::new(x, y, z)
    }

    /// Twice the area of the triangle.
    pub(super) fn twice_area(&self) -> f64 {
        let [a, b, c] = self.corners().map(Vec3::as_dvec3);
        (b - a).cross(c - a).length()
    }
}

/// Unit normal, and slenderness: the ratio of the longest edge to the height.
fn normal_and_slenderness(ab: Vec3, ac: Vec3, longest_squared: f32) -> (Vec3, f32) {
    /// Slenderness from which the normal is computed in `f64`: in `f32` it would lose significant
    /// digits.
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

/// The derivative by u of the position on a triangle with these edges.
fn dp_du(mesh: &Mesh, triangle: usize, ng: Vec3, edges: [Vec3; 2]) -> Vec3 {
    if mesh.uvs.is_empty() {
        return edges[0];
    }
    let [a, b, c] = mesh.triangles[triangle].map(|i| mesh.uvs[i as usize]);
    let [b, c] = [b - a, c - a].map(Pair::<One>::from);
    derivatives(edges.map(Vector::from), [b, c], ng.into())[0].into()
}

/// The derivatives of the position by u and by v, for a triangle with these edges from the first
/// corner in space and in texture coordinates; the axes of a frame where the latter are parallel.
#[inline(always)]
pub(super) fn derivatives<S: Width>(
    [ab, ac]: [Vector<S>; 2],
    [b, c]: [Pair<S>; 2],
    ng: Vector<S>,
) -> [Vector<S>; 2] {
    let inverse = (b.x * c.y - b.y * c.x).recip();
    let du = (ab * c.y - ac * b.y) * inverse;
    let dv = (ac * b.x - ab * c.x) * inverse;
    let exist = inverse.is_finite();
    if exist.all() {
        return [du, dv];
    }
    let frame = Axes::from_normal(ng);
    [
        Vector::select(exist, du, frame.s),
        Vector::select(exist, dv, frame.t),
    ]
}
