//! Triangle meshes in double precision.

use crate::pose::Pose;
use glam::{DAffine3, DVec2, DVec3};

/// Steps in a meter to which positions are rounded before they are compared: a micrometer.
const WELD_STEPS: f64 = 1e6;
/// Squared distance between unit normals below which two corners share a vertex.
const SAME_NORMAL: f64 = 1e-8;

/// An indexed triangle mesh. Triangles are counterclockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions in meters.
    pub positions: Vec<DVec3>,
    /// Unit shading normals, one for each vertex.
    pub normals: Vec<DVec3>,
    /// Texture coordinates: one pair for each vertex, or none.
    pub uvs: Vec<DVec2>,
    /// Vertex indices.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// A mesh with computed shading normals. The normal at a corner is the area-weighted mean over
    /// the faces around the vertex that meet its face at less than `crease` degrees.
    pub fn shaded(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>, crease: f64) -> Mesh {
        let bare = Mesh {
            positions,
            triangles,
            ..Mesh::default()
        };
        bare.welded().with_normals(crease)
    }

    /// Appends the triangles of `other`. Texture coordinates are dropped unless both meshes have
    /// them.
    pub fn append(&mut self, other: &Mesh) {
        let offset = self.positions.len() as u32;
        if self.uvs.len() == self.positions.len() && other.uvs.len() == other.positions.len() {
            self.uvs.extend(&other.uvs);
        } else {
            self.uvs.clear();
        }
        self.positions.extend(&other.positions);
        self.normals.extend(&other.normals);
        let shifted = other.triangles.iter().map(|t| t.map(|i| i + offset));
        self.triangles.extend(shifted);
    }

    /// The union of several meshes.
    pub fn joined(parts: &[Mesh]) -> Mesh {
        let mut whole = Mesh::default();
        for part in parts {
            whole.append(part);
        }
        whole
    }

    /// The mesh transformed by `pose`.
    pub fn placed(&self, pose: Pose) -> Mesh {
        self.transformed(&pose.matrix())
    }

    /// The mesh under an affine map. A reflection reverses the triangles, so that they still face
    /// outwards.
    pub fn transformed(&self, map: &DAffine3) -> Mesh {
        let normal_map = map.matrix3.inverse().transpose();
        let mirrors = map.matrix3.determinant() < 0.0;
        Mesh {
            positions: self
                .positions
                .iter()
                .map(|&p| map.transform_point3(p))
                .collect(),
            normals: self
                .normals
                .iter()
                .map(|&n| (normal_map * n).normalize())
                .collect(),
            uvs: self.uvs.clone(),
            triangles: self
                .triangles
                .iter()
                .map(|&[a, b, c]| if mirrors { [a, c, b] } else { [a, b, c] })
                .collect(),
        }
    }

    /// The mesh with the opposite orientation.
    pub fn flipped(mut self) -> Mesh {
        for t in &mut self.triangles {
            t.swap(1, 2);
        }
        for n in &mut self.normals {
            *n = -*n;
        }
        self
    }

    /// Box mapping: texture coordinates from the two axes across the dominant axis of each normal.
    /// `size` is the length in meters of one repetition of the texture; v follows the longest side
    /// of the mesh where it can.
    pub fn box_mapped(mut self, size: f64) -> Mesh {
        let (low, high) = self.bounds();
        let extent = high - low;
        let along = extent.max_position();
        self.uvs = self
            .positions
            .iter()
            .zip(&self.normals)
            .map(|(p, n)| {
                let facing = n.abs().max_position();
                let v = if along == facing {
                    (facing + 1) % 3
                } else {
                    along
                };
                let u = 3 - facing - v;
                DVec2::new(p[u], p[v]) / size
            })
            .collect();
        self
    }

    /// Corners of the axis-aligned bounding box.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.positions
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| {
                (low.min(p), high.max(p))
            })
    }

    /// Surface area.
    pub fn area(&self) -> f64 {
        (0..self.triangles.len())
            .map(|t| self.doubled_area(t).length() / 2.0)
            .sum()
    }

    /// Enclosed volume of a closed mesh; positive if the triangles face outwards.
    pub fn volume(&self) -> f64 {
        let sixfold: f64 = self
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| self.positions[i as usize]);
                a.dot(b.cross(c))
            })
            .sum();
        sixfold / 6.0
    }

    /// Whether each edge belongs to exactly two triangles with opposite directions. Vertices at
    /// equal positions count as one.
    pub fn is_closed(&self) -> bool {
        let welded = self.welded();
        let mut edges: Vec<(u32, u32)> = welded
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
            .collect();
        edges.sort_unstable();
        let each_once = edges.windows(2).all(|pair| pair[0] != pair[1]);
        each_once
            && edges
                .iter()
                .all(|&(a, b)| edges.binary_search(&(b, a)).is_ok())
    }

    /// Whether all shading normals equal the geometric normals.
    pub fn is_flat(&self) -> bool {
        self.triangles.iter().enumerate().all(|(t, corners)| {
            let face = self.doubled_area(t).normalize_or_zero();
            corners
                .iter()
                .all(|&i| self.normals[i as usize].dot(face) > 1.0 - 1e-7)
        })
    }

    /// Cross product of two sides: the geometric normal with twice the area as its length.
    fn doubled_area(&self, triangle: usize) -> DVec3 {
        let [a, b, c] = self.triangles[triangle].map(|i| self.positions[i as usize]);
        (b - a).cross(c - a)
    }

    /// The mesh without normals, with vertices at equal positions merged and degenerate triangles
    /// removed.
    fn welded(&self) -> Mesh {
        let key = |p: DVec3| (p * WELD_STEPS).round().as_i64vec3().to_array();
        let mut order: Vec<u32> = (0..self.positions.len() as u32).collect();
        order.sort_by_key(|&i| (key(self.positions[i as usize]), i));
        let mut first_of = vec![0u32; self.positions.len()];
        for run in order
            .chunk_by(|&a, &b| key(self.positions[a as usize]) == key(self.positions[b as usize]))
        {
            for &i in run {
                first_of[i as usize] = run[0];
            }
        }
        let triangles = self
            .triangles
            .iter()
            .map(|t| t.map(|i| first_of[i as usize]))
            .filter(|&[a, b, c]| a != b && b != c && c != a)
            .collect();
        Mesh {
            positions: self.positions.clone(),
            triangles,
            ..Mesh::default()
        }
    }

    /// Computes shading normals and splits vertices at creases.
    fn with_normals(&self, crease: f64) -> Mesh {
        let smooth_above = crease.to_radians().cos();
        let faces: Vec<DVec3> = (0..self.triangles.len())
            .map(|t| self.doubled_area(t))
            .collect();
        let mut around: Vec<Vec<usize>> = vec![Vec::new(); self.positions.len()];
        for (t, corners) in self.triangles.iter().enumerate() {
            for &i in corners {
                around[i as usize].push(t);
            }
        }
        let mut mesh = Mesh::default();
        let mut copies: Vec<Vec<u32>> = vec![Vec::new(); self.positions.len()];
        for (t, corners) in self.triangles.iter().enumerate() {
            let own = faces[t].normalize_or_zero();
            let shaded = corners.map(|i| {
                let i = i as usize;
                let normal = around[i]
                    .iter()
                    .map(|&f| faces[f])
                    .filter(|f| f.normalize_or_zero().dot(own) > smooth_above)
                    .sum::<DVec3>()
                    .try_normalize()
                    .unwrap_or(own);
                let known = copies[i]
                    .iter()
                    .find(|&&c| mesh.normals[c as usize].distance_squared(normal) < SAME_NORMAL);
                known.copied().unwrap_or_else(|| {
                    let new = mesh.positions.len() as u32;
                    mesh.positions.push(self.positions[i]);
                    mesh.normals.push(normal);
                    copies[i].push(new);
                    new
                })
            });
            mesh.triangles.push(shaded);
        }
        mesh
    }
}
