//! Tangents by MikkTSpace, with which normal maps are baked, and the signs of bitangents.

use super::primitives::Geometry;
use super::textures::Bitangents;
use bevy_mikktspace::{Geometry as Interface, TangentSpace, generate_tangents};
use manylight::math::Vec3;
use std::collections::HashMap;

/// Sets the tangents of a geometry with normals and texture coordinates. Vertices are split where
/// triangles have different tangents.
pub(super) fn add_tangents(geometry: &mut Geometry) {
    if geometry.normals.is_empty() || geometry.uvs.is_empty() {
        return;
    }
    let mut corners = Corners {
        tangents: vec![[Vec3::ZERO; 3]; geometry.triangles.len()],
        geometry,
    };
    if generate_tangents(&mut corners).is_err() {
        return;
    }
    let tangents = corners.tangents;
    split(geometry, &tangents);
}

/// The bitangents of a geometry, placed by a transform that mirrors or not. Mirrored texture
/// coordinates say the signs where they are those of the file, as in files with tangents by
/// MikkTSpace; they take no memory.
pub(super) fn bitangents(geometry: &Geometry, is_mirrored: bool) -> Bitangents {
    let Some(first) = geometry.signs.first() else {
        return Bitangents::ByTextureCoordinates;
    };
    let mut expected = geometry.triangles.iter().filter_map(|triangle| {
        let sign = sign_by_texture_coordinates(geometry, triangle)?;
        Some(triangle.iter().all(|i| geometry.signs[*i as usize] == sign))
    });
    if expected
        .next()
        .is_some_and(|agrees| agrees && expected.all(|agrees| agrees))
    {
        return Bitangents::ByTextureCoordinates;
    }
    // n x t is an axial vector.
    let turn = if is_mirrored { -1.0 } else { 1.0 };
    match geometry.signs.iter().all(|sign| sign == first) {
        true => Bitangents::OneSign(first * turn),
        false => Bitangents::Signs(geometry.signs.iter().map(|sign| sign * turn).collect()),
    }
}

/// The sign of the bitangent that points to smaller v; `None` for triangles without area, in space
/// or in the texture.
fn sign_by_texture_coordinates(geometry: &Geometry, triangle: &[u32; 3]) -> Option<f32> {
    let (_, uvs) = geometry.uvs.first()?;
    let [a, b, c] = triangle.map(|i| i as usize);
    let edges = [b, c].map(|i| geometry.positions[i] - geometry.positions[a]);
    let normal: Vec3 = [a, b, c].into_iter().map(|i| geometry.normals[i]).sum();
    let in_texture = (uvs[b] - uvs[a]).perp_dot(uvs[c] - uvs[a]);
    let facing = edges[0].cross(edges[1]).dot(normal);
    let is_mirrored = (facing > 0.0) == (in_texture > 0.0);
    (facing != 0.0 && in_texture != 0.0).then_some(if is_mirrored { -1.0 } else { 1.0 })
}

struct Corners<'g> {
    geometry: &'g Geometry,
    tangents: Vec<[Vec3; 3]>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.geometry.triangles[face][corner] as usize
    }
}

impl Interface for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.geometry.triangles.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.geometry.positions[self.vertex(face, corner)].to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.geometry.normals[self.vertex(face, corner)].to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        let [u, v] = self.geometry.uvs[0].1[self.vertex(face, corner)].to_array();
        // MikkTSpace has v = 1 at the top.
        [u, 1.0 - v]
    }

    fn set_tangent(&mut self, tangent: Option<TangentSpace>, face: usize, corner: usize) {
        let tangent = tangent.unwrap_or_default().tangent();
        self.tangents[face][corner] = Vec3::from(tangent);
    }
}

/// Gives each vertex one tangent, by copies of the vertices that have several.
fn split(geometry: &mut Geometry, tangents: &[[Vec3; 3]]) {
    let mut copies: HashMap<(u32, [u32; 3]), u32> = HashMap::new();
    let mut sources: Vec<u32> = Vec::new();
    let mut all = Vec::new();
    for (triangle, tangents) in geometry.triangles.iter_mut().zip(tangents) {
        for (corner, tangent) in triangle.iter_mut().zip(tangents) {
            let key = (*corner, tangent.to_array().map(f32::to_bits));
            let vertex = *copies.entry(key).or_insert_with(|| {
                sources.push(*corner);
                all.push(*tangent);
                sources.len() as u32 - 1
            });
            *corner = vertex;
        }
    }
    geometry.pick_vertices(&sources);
    geometry.tangents = all;
}

#[cfg(test)]
mod tests {
    use super::*;
    use manylight::math::Vec2;

    /// Two triangles in the plane z = 0 with u = |x|, v downwards.
    fn mirrored() -> Geometry {
        let uvs = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 1.0)];
        Geometry {
            positions: vec![Vec3::Y, Vec3::ZERO, Vec3::X, Vec3::NEG_X],
            normals: vec![Vec3::Z; 4],
            uvs: vec![(0, uvs.map(Vec2::from).to_vec())],
            triangles: vec![[0, 1, 2], [0, 3, 1]],
            ..Geometry::default()
        }
    }

    #[test]
    fn signs_are_kept_where_texture_coordinates_do_not_say_them() {
        let mut geometry = mirrored();
        assert_eq!(
            bitangents(&geometry, false),
            Bitangents::ByTextureCoordinates
        );
        add_tangents(&mut geometry);
        let [right, left] = [[0, 1, 2], [3, 4, 5]];
        assert_eq!(geometry.triangles, [right, left]);
        geometry.signs = [[1.0; 3], [-1.0; 3]].concat();
        assert_eq!(
            bitangents(&geometry, true),
            Bitangents::ByTextureCoordinates
        );
        geometry.signs = vec![1.0; 6];
        assert_eq!(bitangents(&geometry, false), Bitangents::OneSign(1.0));
        assert_eq!(bitangents(&geometry, true), Bitangents::OneSign(-1.0));
        geometry.signs = [[-1.0; 3], [1.0; 3]].concat();
        let signs = geometry.signs.clone();
        assert_eq!(bitangents(&geometry, false), Bitangents::Signs(signs));
        // Texture coordinates without area say nothing.
        geometry.uvs[0].1 = vec![Vec2::ZERO; 6];
        geometry.signs = vec![-1.0; 6];
        assert_eq!(bitangents(&geometry, false), Bitangents::OneSign(-1.0));
    }

    #[test]
    fn mirrored_texture_coordinates_split_the_common_edge() {
        let mut geometry = mirrored();
        add_tangents(&mut geometry);
        assert_eq!(geometry.positions.len(), 6);
        for (triangle, along) in geometry.triangles.iter().zip([Vec3::X, Vec3::NEG_X]) {
            for corner in triangle {
                let tangent = geometry.tangents[*corner as usize];
                assert!(tangent.abs_diff_eq(along, 1e-5), "{tangent}");
            }
        }
    }
}
