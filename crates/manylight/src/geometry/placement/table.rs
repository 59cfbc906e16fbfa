//! The triangles of all meshes under their transforms, and surface points on them.

use super::mesh::PlacedMesh;
use super::numbering::Numbering;
use super::runs::Runs;
use super::triangle::{PlacedTriangle, TriangleCorners, derivatives};
use super::vertex::{PlacedVertex, corner_uvs, mix};
use crate::geometry::bvh::CornerRows;
use crate::geometry::{Derivatives, Primitive, Shape, SurfacePoints, SurfaceRef};
use crate::ids::PrimitiveId;
use crate::lanes::{Axes, Float, LANES, One, Pair, Vector, Width};
use crate::math::{Vec2, Vec3};
use crate::simd::{Isa, Simd, SimdKernel};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// All triangles and vertices, each in one list, so that a point needs few look-ups.
#[derive(Debug)]
pub(in crate::geometry) struct TriangleTable {
    /// Index of the first triangle of each primitive; [`NO_TRIANGLES`] for analytic shapes.
    first: Vec<u32>,
    triangles: Vec<PlacedTriangle>,
    /// Before all others, [`PlacedVertex::PLAIN`].
    vertices: Vec<PlacedVertex>,
    tangents: Vec<Vec3>,
    numbering: Arc<Numbering>,
}

/// In the place of the index of a first triangle.
const NO_TRIANGLES: u32 = u32::MAX;

fn index(i: usize) -> u32 {
    u32::try_from(i).expect("a scene has fewer than 2^32 vertices")
}

/// Where the triangles, vertices and tangents of each primitive are in the lists of the table.
struct Places {
    triangles: Runs,
    /// After those of [`PlacedVertex::PLAIN`].
    vertices: Runs,
    tangents: Runs,
}

impl Places {
    fn new(meshes: &[Option<PlacedMesh>]) -> Self {
        let runs = |count: fn(&PlacedMesh) -> usize| {
            Runs::new(meshes.iter().map(|mesh| mesh.as_ref().map_or(0, count)))
        };
        Places {
            triangles: runs(|mesh| mesh.mesh.triangles.len()),
            vertices: runs(|mesh| mesh.vertex_count()),
            tangents: runs(|mesh| mesh.mesh.tangents.len()),
        }
    }

    /// The corners of triangle `i` of the primitive `run`, with the indices of its vertices in the
    /// table.
    #[inline]
    fn corners(&self, run: usize, mesh: &PlacedMesh, i: usize) -> TriangleCorners {
        let corners = mesh.corners(i);
        let first = index(PlacedVertex::PLAIN.len() + self.vertices.first(run));
        TriangleCorners {
            vertices: match mesh.vertex_count() {
                0 => [0, 1, 2],
                _ => corners.vertices.map(|i| first + i),
            },
            tangents_behind: match mesh.mesh.tangents.is_empty() {
                true => 0,
                false => first - index(self.tangents.first(run)),
            },
            ..corners
        }
    }
}

impl TriangleTable {
    /// The triangles of all primitives.
    pub(in crate::geometry) fn new(shapes: &[Shape], primitives: &[Primitive]) -> Self {
        let meshes: Vec<Option<PlacedMesh>> = primitives
            .par_iter()
            .map(|primitive| match &shapes[primitive.shape.index()] {
                Shape::Mesh(mesh) => Some(PlacedMesh::new(mesh, primitive)),
                Shape::Sphere { .. } | Shape::Disk | Shape::Cylinder { .. } => None,
            })
            .collect();
        let places = Places::new(&meshes);
        let mesh = |run: usize| {
            let mesh: &Option<PlacedMesh> = &meshes[run];
            mesh.as_ref().expect("invariant: others have no runs")
        };
        let first = |(run, mesh): (usize, &Option<_>)| match mesh {
            Some(_) => index(places.triangles.first(run)),
            None => NO_TRIANGLES,
        };
        let first: Vec<u32> = meshes.iter().enumerate().map(first).collect();
        let mut vertices = Vec::with_capacity(PlacedVertex::PLAIN.len() + places.vertices.len());
        vertices.extend(PlacedVertex::PLAIN);
        vertices.par_extend(places.vertices.par_map(|run, i| mesh(run).vertex(i)));
        let tangents = places.tangents.par_map(|run, i| mesh(run).tangent(i));
        TriangleTable {
            numbering: Arc::new(numbering(&first, places.triangles.len())),
            first,
            triangles: in_lanes(&places.triangles, |run, i| {
                places.corners(run, mesh(run), i)
            }),
            vertices,
            tangents: tangents.collect(),
        }
    }

    /// Which primitive each triangle belongs to.
    pub(in crate::geometry) fn numbering(&self) -> &Arc<Numbering> {
        &self.numbering
    }

    /// The corners of a triangle, by its index.
    #[inline]
    pub(in crate::geometry) fn corners(&self, index: u32) -> &CornerRows {
        self.triangles[index as usize].corner_rows()
    }

    /// The triangles of a primitive, as a range for [`TriangleTable::triangles`].
    pub(super) fn range(&self, primitive: usize, count: usize) -> Range<u32> {
        let first = self.first[primitive];
        first..first + count as u32
    }

    /// Triangles by index.
    pub(super) fn triangles(&self, range: Range<u32>) -> &[PlacedTriangle] {
        &self.triangles[range.start as usize..range.end as usize]
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

/// The numbering of `count` triangles, by the index of the first of each primitive.
fn numbering(first: &[u32], count: usize) -> Numbering {
    let runs = first
        .iter()
        .zip(0..)
        .map(|(&first, i)| (first, PrimitiveId(i)));
    let runs = runs.filter(|run| run.0 != NO_TRIANGLES);
    Numbering::new(runs.collect(), index(count))
}

/// The triangles with the `corners(run, i)`, run by run.
fn in_lanes(
    runs: &Runs,
    corners: impl Fn(usize, usize) -> TriangleCorners + Sync + Send,
) -> Vec<PlacedTriangle> {
    let isa = Isa::best();
    let groups = runs.par_groups(|at: [_; LANES]| {
        isa.run(PlaceTriangles(|lane: usize| {
            corners(at[lane].0, at[lane].1)
        }))
    });
    let groups: Vec<[PlacedTriangle; LANES]> = groups.collect();
    let mut triangles = groups.into_flattened();
    triangles.truncate(runs.len());
    triangles
}

/// Kernel of [`in_lanes`]: the triangles with the corners in each lane.
struct PlaceTriangles<F>(F);

impl<F: FnMut(usize) -> TriangleCorners> SimdKernel for PlaceTriangles<F> {
    type Output = [PlacedTriangle; LANES];

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> [PlacedTriangle; LANES] {
        let s = s.wide();
        let mut triangles = [PlacedTriangle::NONE; LANES];
        triangles.copy_from_slice(PlacedTriangle::each(s, &s.each(self.0)).as_ref());
        triangles
    }
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
