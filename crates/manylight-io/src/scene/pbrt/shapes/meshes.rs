//! Meshes in the scene file and in PLY files.

use super::super::super::assets::{MeshContent, MeshRequest, Normals};
use super::super::super::parameters::Parameters;
use super::super::builder::Builder;
use super::super::elements::Elements;
use super::super::entities::ShapeEntity;
use super::super::param_types::ParamType;
use super::super::transforms::mirrors;
use super::tessellation::{Geometry, append, grid};
use crate::mesh::MeshFormat;
use manylight::geometry::{Mesh, Shape};
use manylight::math::{Vec2, Vec3};
use manylight::scene::SceneDesc;

/// Cells along each edge of a patch that is not flat.
const PATCH_CELLS: usize = 8;

impl Builder<'_> {
    pub(super) fn triangle_mesh(&mut self, shape: &ShapeEntity<'_>) -> Option<Geometry> {
        let params = &shape.entity.params;
        params.ignore(&["faceIndices", "S", "edgelength"]);
        let mut mesh = self.triangle_list(shape)?;
        if self.needs_coordinates(shape) {
            add_coordinates(&mut mesh);
        }
        self.add_mesh(shape, mesh, Elements::Triangles)
    }

    /// Vertices and triangles.
    pub(super) fn triangle_list(&self, shape: &ShapeEntity<'_>) -> Option<Mesh> {
        let mesh = self.vertices(shape, 3)?;
        let triangles = self.elements::<3>(shape, mesh.positions.len())?;
        Some(Mesh { triangles, ..mesh })
    }

    /// The vertices of a mesh. `least` is the least number of them.
    fn vertices(&self, shape: &ShapeEntity<'_>, least: usize) -> Option<Mesh> {
        let params = &shape.entity.params;
        params.require("P");
        let positions = params.vectors("P")?;
        let count = positions.len();
        if count < least {
            params.refuse_named("P", &format!("at least {least} points"));
            return None;
        }
        let mut normals = params.vectors("N").unwrap_or_default();
        let uv_name = ["uv", "st"].into_iter().find(|name| params.has(name));
        let uv_name = uv_name.unwrap_or("uv");
        let mut uvs = params.pairs(uv_name).unwrap_or_default();
        for (name, found) in [("N", normals.len()), (uv_name, uvs.len())] {
            if found != 0 && found != count {
                let required = format!("one value for each of the {count} points, found {found}");
                params.refuse_named(name, &required);
                (normals, uvs) = (Vec::new(), Vec::new());
            }
        }
        normals
            .iter_mut()
            .for_each(|n| *n = n.normalize_or(Vec3::Z));
        Some(Mesh {
            positions,
            normals,
            tangents: Vec::new(),
            uvs,
            triangles: Vec::new(),
        })
    }

    /// The lists of `N` indices of vertices. Without `indices`, the vertices are one list.
    fn elements<const N: usize>(
        &self,
        shape: &ShapeEntity<'_>,
        vertex_count: usize,
    ) -> Option<Vec<[u32; N]>> {
        let params = &shape.entity.params;
        let Some(indices) = params.integers("indices") else {
            if vertex_count == N {
                return Some(vec![std::array::from_fn(|i| i as u32)]);
            }
            params.require("indices");
            return None;
        };
        let param = params.get("indices")?;
        if !indices.len().is_multiple_of(N) || indices.is_empty() {
            let required = format!("a multiple of {N} integers, found {}", indices.len());
            params.refuse(param, &required);
            return None;
        }
        let is_outside = |index: &&i32| **index < 0 || **index as usize >= vertex_count;
        if let Some(index) = indices.iter().find(is_outside) {
            let required = format!("indices of the {vertex_count} points, found {index}");
            params.refuse(param, &required);
            return None;
        }
        let lists = indices.chunks_exact(N);
        Some(
            lists
                .map(|list| std::array::from_fn(|i| list[i] as u32))
                .collect(),
        )
    }

    pub(super) fn ply_mesh(&mut self, shape: &ShapeEntity<'_>) -> Option<Geometry> {
        let entity = &shape.entity;
        let params = &entity.params;
        params.ignore(&["edgelength", "displacement.edgelength"]);
        if let Some(param) = params.get("displacement") {
            let message = "displacement of meshes is not supported; it is ignored";
            self.sink
                .unsupported("displacement", param.name.span, message);
        }
        let world_from_object = self.world_of_shape(shape)?;
        let name = params.required_string("filename")?;
        let path = entity.find_file(name, "mesh file")?;
        let request = MeshRequest {
            path,
            content: MeshContent::Mesh(MeshFormat::Ply),
            flip_v: false,
            normals: Normals::Stored {
                mirrored: mirrors(entity.transform),
            },
        };
        let needs_coordinates = self.needs_coordinates(shape);
        let shapes = &mut self.desc.shapes;
        let id = self.assets.mesh(request, name.span, shapes);
        if needs_coordinates {
            self.after_loading(move |desc: &mut SceneDesc| {
                if let Shape::Mesh(mesh) = &mut desc.shapes[id.index()] {
                    add_coordinates(mesh);
                }
            });
        }
        Some(Geometry {
            shape: id,
            world_from_object,
            is_reversed: false,
            elements: Elements::Triangles,
        })
    }

    /// Whether a mesh must have texture coordinates.
    fn needs_coordinates(&mut self, shape: &ShapeEntity<'_>) -> bool {
        let material = self.resolve_material(&shape.material);
        let light = shape.area_light.as_deref();
        let alpha = shape.entity.params.get("alpha");
        self.made.textured.contains(&material)
            || light.is_some_and(|light| light.params.has("filename"))
            || alpha.is_some_and(|alpha| alpha.ty == ParamType::Texture)
    }

    /// Bilinear patches. Flat parallelograms are two triangles, other patches are grids.
    pub(super) fn bilinear_mesh(&mut self, shape: &ShapeEntity<'_>) -> Option<Geometry> {
        let params = &shape.entity.params;
        params.ignore(&["faceIndices"]);
        if let Some(param) = params.get("emissionfilename") {
            let message = "`emissionfilename` is not supported; use `filename` of the area light";
            self.sink
                .unsupported("emissionfilename", param.name.span, message);
        }
        let vertices = self.vertices(shape, 4)?;
        let patches = self.elements::<4>(shape, vertices.positions.len())?;
        let mut mesh = Mesh::default();
        let has_normals = !vertices.normals.is_empty();
        let mut runs = Vec::with_capacity(patches.len());
        for patch in patches {
            let piece = patch_mesh(&vertices, patch);
            runs.push(piece.triangles.len() as u32);
            append(&mut mesh, piece);
        }
        if !has_normals {
            mesh.normals = Vec::new();
        }
        self.add_tessellated(shape, mesh, Elements::Runs(runs))
    }

    pub(super) fn height_field(&mut self, shape: &ShapeEntity<'_>) -> Option<Geometry> {
        let params = &shape.entity.params;
        let n = ["nu", "nv"].map(|name| params.integer(name, 2, 2) as usize);
        params.require("Pz");
        let heights = params.floats("Pz")?;
        if n[0].checked_mul(n[1]) != Some(heights.len()) {
            let required = format!("{} x {} numbers, found {}", n[0], n[1], heights.len());
            params.refuse_named("Pz", &required);
            return None;
        }
        let cells = n.map(|n| n - 1);
        let mut mesh = grid(cells, |u, v| {
            let at = |t: f32, cells: usize| (t * cells as f32).round() as usize;
            let z = heights[at(v, cells[1]) * n[0] + at(u, cells[0])];
            (Vec3::new(u, v, z), Vec3::Z)
        });
        mesh.normals = Vec::new();
        self.add_mesh(shape, mesh, Elements::Triangles)
    }
}

/// Gives a mesh without texture coordinates those of PBRT: (0, 0), (1, 0) and (1, 1) at the corners
/// of every triangle, which gets its own vertices.
fn add_coordinates(mesh: &mut Mesh) {
    if !mesh.uvs.is_empty() {
        return;
    }
    let corners: Vec<usize> = mesh
        .triangles
        .iter()
        .flatten()
        .map(|i| *i as usize)
        .collect();
    let at_corners = |values: &[Vec3]| -> Vec<Vec3> {
        let filled = corners.iter().filter(|_| !values.is_empty());
        filled.map(|i| values[*i]).collect()
    };
    mesh.positions = at_corners(&mesh.positions);
    mesh.normals = at_corners(&mesh.normals);
    mesh.tangents = at_corners(&mesh.tangents);
    mesh.uvs = [Vec2::ZERO, Vec2::X, Vec2::ONE].repeat(mesh.triangles.len());
    for (triangle, first) in mesh.triangles.iter_mut().zip((0..).step_by(3)) {
        *triangle = [first, first + 1, first + 2];
    }
}

/// The bilinear patch with the corners (0,0), (1,0), (0,1), (1,1).
fn patch_mesh(vertices: &Mesh, patch: [u32; 4]) -> Mesh {
    let p = patch.map(|i| vertices.positions[i as usize]);
    let uv = match vertices.uvs.is_empty() {
        true => [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE],
        false => patch.map(|i| vertices.uvs[i as usize]),
    };
    let normals = match vertices.normals.is_empty() {
        true => [Vec3::Z; 4],
        false => patch.map(|i| vertices.normals[i as usize]),
    };
    let twist = (p[0] + p[3] - p[1] - p[2]).length();
    let extent = (p[3] - p[0]).length().max((p[2] - p[1]).length());
    // Rounding in files of six digits.
    let is_parallelogram = twist <= 1e-5 * extent;
    let n = if is_parallelogram { 1 } else { PATCH_CELLS };
    let mut mesh = grid([n, n], |u, v| (bilinear(p, u, v), bilinear(normals, u, v)));
    mesh.uvs
        .iter_mut()
        .for_each(|at| *at = uv[0].lerp(uv[1], at.x).lerp(uv[2].lerp(uv[3], at.x), at.y));
    mesh
}

fn bilinear(corners: [Vec3; 4], u: f32, v: f32) -> Vec3 {
    let [a, b, c, d] = corners;
    a.lerp(b, u).lerp(c.lerp(d, u), v)
}
