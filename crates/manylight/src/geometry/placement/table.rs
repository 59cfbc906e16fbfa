//! The triangles of all meshes under their transforms, and surface points on them.

use super::triangle::{PlacedTriangle, derivatives};
use super::vertex::{PlacedVertex, PlacedVertices, corner_uvs, mix};
use crate::geometry::{Derivatives, Mesh, Primitive, Shape, SurfacePoints, SurfaceRef};
use crate::lanes::{Axes, Float, One, Pair, Vector, Width};
use crate::math::{Vec2, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// All triangles and vertices, each in one list, so that a point needs few look-ups.
#[derive(Debug)]
pub(in crate::geometry) struct TriangleTable {
    /// Index of the first triangle of each primitive; [`NO_TRIANGLES`] for analytic shapes.
    first: Vec<u32>,
    triangles: Vec<PlacedTriangle>,
    /// Before all others, [`PlacedVertex::PLAIN`].
    vertices: Vec<PlacedVertex>,
    tangents: Vec<Vec3>,
}

/// In the place of the index of a first triangle.
const NO_TRIANGLES: u32 = u32::MAX;

impl TriangleTable {
    /// The triangles of all primitives.
    pub(in crate::geometry) fn new(shapes: &[Shape], primitives: &[Primitive]) -> Self {
        let meshes: Vec<Option<(Vec<PlacedTriangle>, PlacedVertices)>> = primitives
            .par_iter()
            .map(|primitive| match &shapes[primitive.shape.index()] {
                Shape::Mesh(mesh) => Some(place(mesh, primitive)),
                Shape::Sphere { .. } | Shape::Disk | Shape::Cylinder { .. } => None,
            })
            .collect();
        let placed = || meshes.iter().flatten();
        let mut table = TriangleTable {
            first: Vec::with_capacity(meshes.len()),
            triangles: Vec::with_capacity(placed().map(|m| m.0.len()).sum()),
            vertices: Vec::with_capacity(placed().map(|m| m.1.vertices.len()).sum::<usize>() + 3),
            tangents: Vec::with_capacity(placed().map(|m| m.1.tangents.len()).sum()),
        };
        table.vertices.extend(PlacedVertex::PLAIN);
        for mesh in meshes {
            let first = match mesh {
                None => NO_TRIANGLES,
                Some((triangles, vertices)) => table.add(triangles, vertices),
            };
            table.first.push(first);
        }
        table
    }

    /// Appends a mesh; returns the index of its first triangle.
    fn add(&mut self, triangles: Vec<PlacedTriangle>, of_mesh: PlacedVertices) -> u32 {
        /// Triangles per task: smaller tasks cost more to distribute than to copy.
        const SMALL: usize = 1 << 14;
        let index = |i: usize| u32::try_from(i).expect("a scene has fewer than 2^32 vertices");
        let first = index(self.triangles.len());
        let first_vertex = index(self.vertices.len());
        let tangents_behind = match of_mesh.tangents.is_empty() {
            true => 0,
            false => first_vertex - self.tangents.len() as u32,
        };
        let is_plain = of_mesh.vertices.is_empty();
        let moved = triangles.into_par_iter().with_min_len(SMALL);
        self.triangles
            .par_extend(moved.map(|triangle| PlacedTriangle {
                vertices: match is_plain {
                    true => [0, 1, 2],
                    false => triangle.vertices.map(|i| first_vertex + i),
                },
                tangents_behind,
                ..triangle
            }));
        self.vertices.extend(of_mesh.vertices);
        self.tangents.extend(of_mesh.tangents);
        first
    }

    /// The triangles of a primitive, as a range for [`TriangleTable::triangles`].
    pub(super) fn range(&self, primitive: usize, count: usize) -> Range<usize> {
        let first = self.first[primitive] as usize;
        first..first + count
    }

    /// Triangles by index.
    pub(super) fn triangles(&self, range: Range<usize>) -> &[PlacedTriangle] {
        &self.triangles[range]
    }

    /// The triangle of a reference; `None` on analytic shapes.
    #[inline(always)]
    fn get(&self, at: &SurfaceRef) -> Option<&PlacedTriangle> {
        let first = self.first[at.primitive.index()];
        self.triangles.get(first.wrapping_add(at.element) as usize)
    }

    /// The texture coordinates of a point; `None` on analytic shapes.
    #[inline]
    pub(in crate::geometry) fn uv(&self, at: &SurfaceRef) -> Option<Vec2> {
        let corners = self.get(at)?.vertices;
        let uvs = corners.map(|i| Pair::from(self.vertices[i as usize].uv()));
        let uv = uv(corner_uvs(uvs), weights(Pair::<One>::from(at.coordinates)));
        Some(Vec2::new(uv.x.get(), uv.y.get()))
    }

    /// The points of references to triangles, and the lanes with references to other shapes, as
    /// bits. Their points are unspecified, and instances are ignored.
    #[inline(always)]
    pub(in crate::geometry) fn points<S: Width>(
        &self,
        s: S,
        at: &S::Each<SurfaceRef>,
        wanted: Derivatives,
    ) -> (SurfacePoints<S>, u32) {
        let mut triangles = s.each(|_| &PlacedTriangle::NONE);
        let mut others = 0;
        let constants = Float::gather_quads(s, |i| {
            match self.get(&at.as_ref()[i]) {
                Some(triangle) => triangles.as_mut()[i] = triangle,
                None => others |= 1 << i,
            }
            let [a, b, c, n] = &triangles.as_ref()[i].constants;
            [a, b, c, n]
        });
        let weights = weights(Pair::from_fn(s, |i| at.as_ref()[i].coordinates));
        let [
            [ax, ay, az, offset],
            [bx, by, bz, tx],
            [cx, cy, cz, ty],
            [nx, ny, nz, tz],
        ] = constants;
        let ng = Vector::new(nx, ny, nz);
        let corners = [
            Vector::new(ax, ay, az),
            Vector::new(bx, by, bz),
            Vector::new(cx, cy, cz),
        ];
        let (na, uv_a) = self.vertex(s, &triangles, 0);
        let (nb, uv_b) = self.vertex(s, &triangles, 1);
        let (nc, uv_c) = self.vertex(s, &triangles, 2);
        let (ns, is_unit) = mix_vectors([na, nb, nc], weights).try_normalize();
        let ns = Vector::select(is_unit, ns, ng);
        let tangent = self.vertex_tangents(&triangles, weights, Vector::new(tx, ty, tz));
        let uvs = corner_uvs([uv_a, uv_b, uv_c]);
        let [dp_du, dp_dv] = match wanted {
            Derivatives::Unspecified => [Vector::splat(s, Vec3::ZERO); 2],
            Derivatives::OfPosition => {
                let [a, b, c] = corners;
                derivatives([b - a, c - a], [uvs[1] - uvs[0], uvs[2] - uvs[0]], ng)
            }
        };
        let points = SurfacePoints {
            p: mix_vectors(corners, weights),
            ng,
            frame: Axes::from_normal_and_tangent(ns, tangent),
            uv: uv(uvs, weights),
            dp_du,
            dp_dv,
            offset,
            at: *at,
        };
        (points, others)
    }

    /// The normals and the texture coordinates of one corner of each triangle.
    #[inline(always)]
    fn vertex<S: Width>(
        &self,
        s: S,
        triangles: &S::Each<&PlacedTriangle>,
        corner: usize,
    ) -> (Vector<S>, Pair<S>) {
        let [[x, y, z, u], [.., v]] = Float::gather_quads(s, |i| {
            // Indices out of range do not occur. To panic at them would order all checks before all
            // loads.
            let index = triangles.as_ref()[i].vertices[corner] as usize;
            let vertex = self.vertices.get(index).unwrap_or(&PlacedVertex::PLAIN[0]);
            vertex.quads()
        });
        (Vector::new(x, y, z), Pair::new(u, v))
    }

    /// The interpolated tangents of vertices, `other` where the mesh has none.
    #[inline(always)]
    fn vertex_tangents<S: Width>(
        &self,
        triangles: &S::Each<&PlacedTriangle>,
        weights: [Float<S>; 3],
        other: Vector<S>,
    ) -> Vector<S> {
        if self.tangents.is_empty() {
            return other;
        }
        let s = other.x.width();
        let [a, b, c] = weights;
        let (a, b, c) = (a.store(), b.store(), c.store());
        let [mut x, mut y, mut z] = other.store();
        for (i, triangle) in triangles.as_ref().iter().enumerate() {
            if triangle.tangents_behind == 0 {
                continue;
            }
            let of_corner = |k: usize| {
                let vertex = triangle.vertices[k];
                self.tangents[(vertex - triangle.tangents_behind) as usize]
            };
            let tangent = of_corner(0) * a.as_ref()[i]
                + of_corner(1) * b.as_ref()[i]
                + of_corner(2) * c.as_ref()[i];
            (x.as_mut()[i], y.as_mut()[i], z.as_mut()[i]) = tangent.into();
        }
        Vector::load(s, &[x, y, z])
    }
}

fn place(mesh: &Mesh, primitive: &Primitive) -> (Vec<PlacedTriangle>, PlacedVertices) {
    let (transform, flip) = (&primitive.world_from_object, primitive.flip_normals);
    let triangles: Vec<PlacedTriangle> = (0..mesh.triangles.len())
        .into_par_iter()
        .map(|i| PlacedTriangle::new(mesh, transform, flip, i))
        .collect();
    let vertices = PlacedVertices::new(mesh, transform, flip, &triangles);
    (triangles, vertices)
}

/// The weights of the corners at a point with the coordinates `at`.
#[inline(always)]
fn weights<S: Width>(at: Pair<S>) -> [Float<S>; 3] {
    [1.0 - at.x - at.y, at.x, at.y]
}

#[inline(always)]
fn mix_vectors<S: Width>([a, b, c]: [Vector<S>; 3], weights: [Float<S>; 3]) -> Vector<S> {
    Vector::new(
        mix([a.x, b.x, c.x], weights),
        mix([a.y, b.y, c.y], weights),
        mix([a.z, b.z, c.z], weights),
    )
}

#[inline(always)]
fn uv<S: Width>([a, b, c]: [Pair<S>; 3], weights: [Float<S>; 3]) -> Pair<S> {
    Pair::new(mix([a.x, b.x, c.x], weights), mix([a.y, b.y, c.y], weights))
}
