//! Triangles under the transform of their mesh: normals, offsets and parametrizations.

use crate::geometry::bvh::CornerRows;
use crate::geometry::surface_point::OFFSET_ROUNDINGS;
use crate::lanes::{Axes, Float, Pair, Vector, Width};
use crate::math::{Vec2, Vec3};

/// Largest ratio of longest edge to height that enlarges the offset. For longer slivers a safe
/// offset would no longer be small against the scene.
const MAX_SLENDERNESS: f32 = 1000.0;

/// Weight of the product of longest edge and slenderness in the offset. The rounding of the normal
/// grows with the slenderness and moves the plane in proportion to the longest edge. Larger weights
/// are safer, smaller ones leak less light at contacts.
const EXTENT_WEIGHT: f32 = 0.25;

/// A triangle before the numbers are known that are the same at all of its points.
#[derive(Clone, Copy)]
pub(super) struct TriangleCorners {
    /// Positions under the transform of the mesh.
    pub(super) p: [Vec3; 3],
    /// Texture coordinates, of which (0,0), (1,0), (0,1) take the place if the mesh has none.
    pub(super) uvs: [Vec2; 3],
    /// Whether the normal is against the order of the corners.
    pub(super) flip: bool,
    /// See [`PlacedTriangle::vertices`].
    pub(super) vertices: [u32; 3],
    /// See [`PlacedTriangle::tangents_behind`].
    pub(super) tangents_behind: u32,
}

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

    /// The triangle in each lane.
    #[inline(always)]
    pub(super) fn each<S: Width>(s: S, of: &S::Each<TriangleCorners>) -> S::Each<Self> {
        let of = of.as_ref();
        let a = Vector::from_fn(s, |i| of[i].p[0]);
        let b = Vector::from_fn(s, |i| of[i].p[1]);
        let c = Vector::from_fn(s, |i| of[i].p[2]);
        let (ab, ac, bc) = (b - a, c - a, c - b);
        let longest = ab.length_squared().max(ac.length_squared());
        let longest = longest.max(bc.length_squared());
        let normal = ab.cross(ac);
        let length = normal.length();
        let (mut ng, mut slenderness) = (normal * length.recip(), longest / length);
        let is_wide = slenderness.lt(SLIVER);
        if !is_wide.all() {
            let (wide, longest) = (is_wide.bits(), longest.store());
            let exact = s.each(|i| match wide >> i & 1 {
                0 => normal_of_sliver(&of[i].p, longest.as_ref()[i]),
                _ => (Vec3::ZERO, 0.0),
            });
            let exact = exact.as_ref();
            ng = Vector::select(is_wide, ng, Vector::from_fn(s, |i| exact[i].0));
            slenderness = is_wide.select(slenderness, Float::from_fn(s, |i| exact[i].1));
        }
        let ng = ng * Float::from_fn(s, |i| if of[i].flip { -1.0 } else { 1.0 });
        let magnitude = a.abs().max(b.abs()).max(c.abs()).max_component();
        let extent = longest.sqrt() * slenderness.min(MAX_SLENDERNESS);
        let offset = extent.mul_add(magnitude.same(EXTENT_WEIGHT), magnitude)
            * (OFFSET_ROUNDINGS * 0.5 * f32::EPSILON);
        let uv = Pair::from_fn(s, |i| of[i].uvs[0]);
        let uv_b = Pair::from_fn(s, |i| of[i].uvs[1]) - uv;
        let uv_c = Pair::from_fn(s, |i| of[i].uvs[2]) - uv;
        let [dp_du, _] = derivatives([ab, ac], [uv_b, uv_c], ng);
        let tangent = Axes::from_normal_and_tangent(ng, dp_du).s;
        let (corners, ng) = ([a.store(), b.store(), c.store()], ng.store());
        let numbers = [offset.store(), tangent.x.store(), tangent.y.store()];
        let last = tangent.z.store();
        s.each(|i| {
            let row = |[x, y, z]: &[S::Each<f32>; 3], number: &S::Each<f32>| {
                [
                    x.as_ref()[i],
                    y.as_ref()[i],
                    z.as_ref()[i],
                    number.as_ref()[i],
                ]
            };
            PlacedTriangle {
                constants: [
                    row(&corners[0], &numbers[0]),
                    row(&corners[1], &numbers[1]),
                    row(&corners[2], &numbers[2]),
                    row(&ng, &last),
                ],
                vertices: of[i].vertices,
                tangents_behind: of[i].tangents_behind,
            }
        })
    }

    /// The three corners, each before one number.
    #[inline]
    pub(super) fn corner_rows(&self) -> &CornerRows {
        let [corners @ .., _] = &self.constants;
        corners
    }

    /// The three corners.
    #[inline]
    pub(super) fn corners(&self) -> [Vec3; 3] {
        self.corner_rows().map(|[x, y, z, _]| Vec3::new(x, y, z))
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

/// Slenderness from which the normal is computed in `f64`: in `f32` it would lose significant digits.
const SLIVER: f32 = 16.0;

/// Unit normal, and slenderness: the ratio of the longest edge to the height. In `f32` the cross
/// product is a small difference of large products, or underflows.
fn normal_of_sliver(corners: &[Vec3; 3], longest_squared: f32) -> (Vec3, f32) {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let normal = (b - a).cross(c - a);
    let slenderness = f64::from(longest_squared) / normal.length();
    (
        normal.normalize_or(glam::DVec3::Z).as_vec3(),
        slenderness.min(f32::MAX.into()) as f32,
    )
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
