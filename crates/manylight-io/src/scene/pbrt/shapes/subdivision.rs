//! Loop subdivision surfaces.
//!
//! Source: Loop, "Smooth Subdivision Surfaces Based on Triangles", 1987; limit positions and
//! tangents as in Pharr, Jakob, Humphreys, "Physically Based Rendering", 3rd edition, section 3.8.

use super::super::super::parameters::Parameters;
use super::super::builder::Builder;
use super::super::elements::Elements;
use super::super::entities::ShapeEntity;
use super::tessellation::Geometry;
use manylight::geometry::Mesh;
use manylight::math::Vec3;
use std::collections::HashMap;
use std::f32::consts::TAU;

/// Most levels: each multiplies the number of triangles by 4.
const MAX_LEVELS: i32 = 10;
/// Most triangles of the result.
const MAX_TRIANGLES: usize = 1 << 26;
/// Levels from which on the triangles of all surfaces of a scene have a bound: with more, a small
/// file fills the memory.
const MANY_LEVELS: i32 = 7;
/// Most triangles of these surfaces.
const MAX_TRIANGLES_OF_MANY_LEVELS: usize = 1 << 20;

impl Builder<'_> {
    pub(super) fn subdivision_surface(&mut self, shape: &ShapeEntity<'_>) -> Option<Geometry> {
        let params = &shape.entity.params;
        params.ignore(&["scheme"]);
        let name = if params.has("nlevels") {
            "nlevels"
        } else {
            "levels"
        };
        let levels = params.integer(name, 3, 0);
        let mesh = self.triangle_list(shape)?;
        let result = mesh.triangles.len() << (2 * levels.clamp(0, MAX_LEVELS));
        if levels > MAX_LEVELS || result > MAX_TRIANGLES {
            let required = format!("at most {MAX_LEVELS}, with at most {MAX_TRIANGLES} triangles");
            params.refuse_named(name, &required);
            return None;
        }
        if levels >= MANY_LEVELS {
            self.finely_subdivided += result;
            if self.finely_subdivided > MAX_TRIANGLES_OF_MANY_LEVELS {
                let required = format!(
                    "less than {MANY_LEVELS}, or at most {MAX_TRIANGLES_OF_MANY_LEVELS} triangles of such surfaces in all"
                );
                params.refuse_named(name, &required);
                return None;
            }
        }
        let mut control = ControlMesh {
            positions: mesh.positions,
            triangles: mesh.triangles,
        };
        for _ in 0..levels {
            control = control.subdivided();
        }
        self.add_tessellated(shape, control.limit(), Elements::Triangles)
    }
}

/// A mesh that is refined.
struct ControlMesh {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

/// The neighbors of a vertex.
#[derive(Clone, Default)]
struct Neighbors {
    /// For every triangle at the vertex, the two other corners in the order of the triangle.
    edges: Vec<[u32; 2]>,
}

impl Neighbors {
    /// The neighbors in order around the vertex, and whether they form a closed ring. At a border
    /// they begin and end there.
    fn ring(&self) -> (Vec<u32>, bool) {
        let next: HashMap<u32, u32> = self.edges.iter().map(|[a, b]| (*a, *b)).collect();
        let ends: Vec<u32> = self.edges.iter().map(|[_, b]| *b).collect();
        let border = next.keys().filter(|a| !ends.contains(a)).min();
        let Some(first) = border.or_else(|| next.keys().min()).copied() else {
            return (Vec::new(), false);
        };
        let mut ring = vec![first];
        let mut at = first;
        while let Some(&following) = next.get(&at) {
            if following == first || ring.len() > self.edges.len() {
                break;
            }
            ring.push(following);
            at = following;
        }
        (ring, border.is_none())
    }
}

impl ControlMesh {
    fn neighbors(&self) -> Vec<Neighbors> {
        let mut neighbors = vec![Neighbors::default(); self.positions.len()];
        for &[a, b, c] in &self.triangles {
            neighbors[a as usize].edges.push([b, c]);
            neighbors[b as usize].edges.push([c, a]);
            neighbors[c as usize].edges.push([a, b]);
        }
        neighbors
    }

    fn at(&self, index: u32) -> Vec3 {
        self.positions[index as usize]
    }

    fn sum(&self, indices: &[u32]) -> Vec3 {
        indices.iter().map(|&i| self.at(i)).sum()
    }

    /// One level finer: every triangle becomes four.
    fn subdivided(&self) -> ControlMesh {
        let neighbors = self.neighbors();
        let mut positions: Vec<Vec3> = neighbors
            .iter()
            .enumerate()
            .map(|(i, neighbors)| self.smoothed(self.positions[i], neighbors))
            .collect();
        // The corners opposite to each edge.
        let mut opposite: HashMap<[u32; 2], Vec<u32>> = HashMap::new();
        for &[a, b, c] in &self.triangles {
            for ([p, q], r) in [([a, b], c), ([b, c], a), ([c, a], b)] {
                opposite.entry([p.min(q), p.max(q)]).or_default().push(r);
            }
        }
        let mut midpoints: HashMap<[u32; 2], u32> = HashMap::new();
        let mut triangles = Vec::with_capacity(self.triangles.len() * 4);
        for &[a, b, c] in &self.triangles {
            let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[p, q]| {
                let edge = [p.min(q), p.max(q)];
                *midpoints.entry(edge).or_insert_with(|| {
                    let ends = self.at(p) + self.at(q);
                    positions.push(match opposite[&edge][..] {
                        [r, s] => ends * 0.375 + (self.at(r) + self.at(s)) * 0.125,
                        _ => ends * 0.5,
                    });
                    positions.len() as u32 - 1
                })
            });
            triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        ControlMesh {
            positions,
            triangles,
        }
    }

    /// The position of a vertex on the next level.
    fn smoothed(&self, p: Vec3, neighbors: &Neighbors) -> Vec3 {
        let (ring, closed) = neighbors.ring();
        match (&ring[..], closed) {
            ([], _) => p,
            (ring, true) => {
                let n = ring.len() as f32;
                let beta = beta(ring.len());
                p * (1.0 - n * beta) + self.sum(ring) * beta
            }
            ([first, .., last], false) => p * 0.75 + (self.at(*first) + self.at(*last)) * 0.125,
            ([_], false) => p,
        }
    }

    /// The vertices on the limit surface, with its normals.
    fn limit(self) -> Mesh {
        let neighbors = self.neighbors();
        let on_limit = |(i, neighbors): (usize, &Neighbors)| {
            let p = self.positions[i];
            let (ring, closed) = neighbors.ring();
            match (&ring[..], closed) {
                ([], _) | ([_], false) => p,
                (ring, true) => {
                    let n = ring.len() as f32;
                    let gamma = 1.0 / (n + 3.0 / (8.0 * beta(ring.len())));
                    p * (1.0 - n * gamma) + self.sum(ring) * gamma
                }
                ([first, .., last], false) => p * 0.6 + (self.at(*first) + self.at(*last)) * 0.2,
            }
        };
        let positions: Vec<Vec3> = neighbors.iter().enumerate().map(on_limit).collect();
        let moved = ControlMesh {
            positions,
            triangles: self.triangles,
        };
        let normals = neighbors
            .iter()
            .enumerate()
            .map(|(i, neighbors)| moved.normal(moved.positions[i], neighbors))
            .collect();
        Mesh {
            positions: moved.positions,
            normals,
            tangents: Vec::new(),
            uvs: Vec::new(),
            triangles: moved.triangles,
        }
    }

    /// The normal at a vertex from tangents of the limit surface.
    fn normal(&self, p: Vec3, neighbors: &Neighbors) -> Vec3 {
        let (ring, closed) = neighbors.ring();
        let at = |i: usize| self.at(ring[i]);
        let n = ring.len();
        let (s, t) = if closed {
            let weighted = |shift: f32| -> Vec3 {
                (0..n)
                    .map(|i| at(i) * (TAU * i as f32 / n as f32 - shift).cos())
                    .sum()
            };
            (weighted(0.0), weighted(0.25 * TAU))
        } else if n < 2 {
            return Vec3::Z;
        } else {
            let along = at(n - 1) - at(0);
            let inward = match n {
                2 => at(0) + at(1) - p * 2.0,
                3 => at(1) - p,
                4 => -at(0) + at(1) * 2.0 + at(2) * 2.0 - at(3) - p * 2.0,
                _ => {
                    let theta = 0.5 * TAU / (n - 1) as f32;
                    let mut sum = (at(0) + at(n - 1)) * theta.sin();
                    for i in 1..n - 1 {
                        let weight = (2.0 * theta.cos() - 2.0) * (i as f32 * theta).sin();
                        sum += at(i) * weight;
                    }
                    -sum
                }
            };
            (along, inward)
        };
        let first = neighbors.edges.first();
        let facet = first.map_or(Vec3::Z, |[a, b]| (self.at(*a) - p).cross(self.at(*b) - p));
        let normal = s.cross(t).normalize_or(facet.normalize_or(Vec3::Z));
        if normal.dot(facet) < 0.0 {
            -normal
        } else {
            normal
        }
    }
}

/// Loop's weight of each of `n` neighbors.
fn beta(n: usize) -> f32 {
    if n == 3 {
        3.0 / 16.0
    } else {
        3.0 / (8.0 * n as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_octahedron_becomes_round() {
        let axes = [
            Vec3::X,
            Vec3::Y,
            Vec3::NEG_X,
            Vec3::NEG_Y,
            Vec3::Z,
            Vec3::NEG_Z,
        ];
        let faces = [[0, 1], [1, 2], [2, 3], [3, 0]];
        let triangles = faces.iter().flat_map(|&[a, b]| [[a, b, 4], [b, a, 5]]);
        let mut control = ControlMesh {
            positions: axes.to_vec(),
            triangles: triangles.collect(),
        };
        for _ in 0..3 {
            control = control.subdivided();
        }
        let mesh = control.limit();
        assert_eq!(mesh.triangles.len(), 8 * 64);
        let radii: Vec<f32> = mesh.positions.iter().map(|p| p.length()).collect();
        let (low, high) = radii
            .iter()
            .fold((1.0f32, 0.0f32), |(a, b), &r| (a.min(r), b.max(r)));
        assert!(
            low > 0.4 && high < 0.75 && high / low < 1.25,
            "{low} {high}"
        );
        for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
            assert!(p.normalize().dot(*n) > 0.95, "{p} {n}");
        }
    }

    #[test]
    fn a_flat_square_stays_flat_and_keeps_its_border() {
        let positions = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let control = ControlMesh {
            positions: positions.map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        };
        let mesh = control.subdivided().limit();
        assert_eq!(mesh.triangles.len(), 8);
        assert!(
            mesh.normals.iter().all(|n| n.abs_diff_eq(Vec3::Z, 1e-5)),
            "{:?}",
            mesh.normals
        );
        assert!(mesh.positions.iter().all(|p| p.z == 0.0));
    }
}
