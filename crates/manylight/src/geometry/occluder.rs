//! Flat convex pieces of opaque surface, to prove that whole regions are hidden from each other.

use super::{Geometry, Shape, SurfaceRef};
use crate::math::{Vec2, Vec3};

/// Largest distance of a corner from the plane and from convexity, in units of the longest edge.
/// Admits rounding of `f32` corners.
const FLAT: f32 = 1e-6;
/// Width of the rim that is excluded from the piece, in units of the longest edge. Keeps the test
/// conservative under rounding.
const RIM: f32 = 1e-4;

/// A convex piece of a plane that blocks light.
#[derive(Clone, Copy, Debug)]
pub struct Occluder {
    /// Unit normal of the plane.
    pub n: Vec3,
    /// `n·x` of the points `x` of the plane.
    pub offset: f32,
    /// For each edge a unit vector `e` in the plane and a bound `b`: the piece is where `e·x >= b`
    /// for all edges.
    pub edges: [(Vec3, f32); 4],
}

impl Occluder {
    /// The triangle of an opaque mesh at `at`, or the convex quadrilateral that it forms with the
    /// triangle before or after it in the mesh. `None` for other shapes, transparent surfaces and
    /// degenerate triangles.
    pub fn at(geometry: &Geometry, at: SurfaceRef) -> Option<Self> {
        let primitive = &geometry.primitives()[at.primitive.index()];
        let Shape::Mesh(mesh) = &geometry.shapes()[primitive.shape.index()] else {
            return None;
        };
        if primitive.transparent {
            return None;
        }
        let corners = |element: usize| {
            [Vec2::ZERO, Vec2::X, Vec2::Y].map(|coordinates| {
                let corner = SurfaceRef {
                    element: element as u32,
                    coordinates,
                    ..at
                };
                geometry.surface_point(corner).p
            })
        };
        let element = at.element as usize;
        let own = corners(element);
        let beside = [element.wrapping_sub(1), element + 1];
        let quadrilaterals = beside.into_iter().filter_map(|other| {
            let indices = mesh.triangles.get(other)?;
            let of = |i: &u32| mesh.positions[*i as usize];
            let (mine, others) = (
                mesh.triangles[element].each_ref().map(of),
                indices.each_ref().map(of),
            );
            let first = mine.iter().position(|p| !others.contains(p))?;
            let last = others.iter().position(|p| !mine.contains(p))?;
            let [a, b, c] = [0, 1, 2].map(|k| own[(first + k) % 3]);
            Occluder::new([a, b, corners(other)[last], c])
        });
        let [a, b, c] = own;
        quadrilaterals
            .into_iter()
            .next()
            .or_else(|| Occluder::new([a, b, c, c]))
    }

    /// The convex polygon with these corners in order; a triangle repeats its last corner. `None`
    /// if the corners are degenerate, not convex or not coplanar.
    fn new(corners: [Vec3; 4]) -> Option<Self> {
        let [a, b, c, d] = corners;
        let n = (c - a)
            .cross(d - b)
            .try_normalize()
            .or_else(|| (b - a).cross(c - a).try_normalize())?;
        let edge = |k: usize| corners[(k + 1) % 4] - corners[k];
        let longest = (0..4).map(|k| edge(k).length()).fold(0.0, f32::max);
        let mut edges = [(Vec3::ZERO, 0.0); 4];
        for (k, bound) in edges.iter_mut().enumerate() {
            // A repeated corner has no edge: take the edge before it.
            let k = if edge(k) == Vec3::ZERO { k - 1 } else { k };
            let inwards = n.cross(edge(k)).try_normalize()?;
            let along = inwards.dot(corners[k]);
            let is_convex = corners
                .iter()
                .all(|p| inwards.dot(*p) - along >= -FLAT * longest);
            let is_flat = (n.dot(corners[k] - a)).abs() <= FLAT * longest;
            if !(is_convex && is_flat) {
                return None;
            }
            *bound = (inwards, along + RIM * longest);
        }
        Some(Occluder {
            n,
            offset: n.dot(a),
            edges,
        })
    }
}
