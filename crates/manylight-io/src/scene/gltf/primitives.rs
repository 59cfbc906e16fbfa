//! Primitives of meshes: vertex attributes and triangles.

use super::accessors::{Accessors, FLOAT, INDEX, UNIT};
use super::compressed_primitives;
use super::json::Json;
use super::textures::VertexNeeds;
use manylight::math::{Vec2, Vec3};

/// The triangles of one primitive with the attributes of their vertices, in the space of the mesh.
#[derive(Clone, Debug, Default)]
pub(super) struct Geometry {
    pub(super) positions: Vec<Vec3>,
    /// Unit vectors; empty for flat triangles.
    pub(super) normals: Vec<Vec3>,
    /// May be empty.
    pub(super) tangents: Vec<Vec3>,
    /// The fourth components of `TANGENT`, the signs of the bitangents; empty if the file has none.
    pub(super) signs: Vec<f32>,
    /// Sets of texture coordinates by their numbers; the first is the primary one.
    pub(super) uvs: Vec<(usize, Vec<Vec2>)>,
    /// Linear colors with opacity; may be empty.
    pub(super) colors: Vec<[f32; 4]>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Modes of primitives in files.
const POINTS: u64 = 0;
const TRIANGLES: u64 = 4;
const TRIANGLE_STRIP: u64 = 5;
const TRIANGLE_FAN: u64 = 6;

impl Geometry {
    /// The geometry of a primitive with triangles; `None` for others, and for invalid ones, which
    /// are reported.
    pub(super) fn read<'a>(
        json: &Json<'a>,
        needs: &VertexNeeds,
        accessors: &Accessors<'a, '_>,
    ) -> Option<Self> {
        let mode = json.unsigned("mode").unwrap_or(TRIANGLES);
        if (POINTS..TRIANGLES).contains(&mode) {
            json.warn_once("points and lines", "points and lines are ignored");
            return None;
        }
        if mode > TRIANGLE_FAN {
            json.unexpected("mode", mode, "a number from 0 to 6");
            return None;
        }
        let decoded = compressed_primitives::of_primitive(json, accessors).ok()?;
        let accessors = decoded.as_ref().unwrap_or(accessors);
        let attributes = json.required_member("attributes")?;
        let Some(at) = attributes.get("POSITION") else {
            json.warn_once("no positions", "primitives without positions are ignored");
            return None;
        };
        let positions: Vec<[f32; 3]> = accessors.floats(&at, "VEC3", accessors.attribute())?;
        let mut geometry = Geometry {
            triangles: triangles(json, mode, positions.len(), accessors)?,
            positions: positions.into_iter().map(Vec3::from).collect(),
            ..Geometry::default()
        };
        geometry.read_directions(&attributes, needs, accessors)?;
        geometry.read_uvs(&attributes, needs, accessors)?;
        if let Some(at) = attributes.get("COLOR_0") {
            geometry.colors = accessors.colors(&at)?;
            geometry.check_count(&at, geometry.colors.len())?;
        }
        Some(geometry)
    }

    /// Normals and tangents.
    fn read_directions<'a>(
        &mut self,
        attributes: &Json<'a>,
        needs: &VertexNeeds,
        accessors: &Accessors<'a, '_>,
    ) -> Option<()> {
        let allowed = accessors.attribute();
        let unit = |v: Vec3| v.normalize_or(Vec3::Z);
        if let Some(at) = attributes.get("NORMAL") {
            let normals: Vec<[f32; 3]> = accessors.floats(&at, "VEC3", allowed)?;
            self.check_count(&at, normals.len())?;
            self.normals = normals.into_iter().map(|n| unit(n.into())).collect();
        }
        let tangents = attributes.get("TANGENT").filter(|_| needs.tangents);
        // The specification has tangents without normals ignored.
        if let Some(at) = tangents.filter(|_| !self.normals.is_empty()) {
            let tangents: Vec<[f32; 4]> = accessors.floats(&at, "VEC4", allowed)?;
            self.check_count(&at, tangents.len())?;
            let direction = |[x, y, z, _]: &[f32; 4]| unit(Vec3::new(*x, *y, *z));
            self.tangents = tangents.iter().map(direction).collect();
            self.signs = tangents.iter().map(|t| 1.0f32.copysign(t[3])).collect();
        }
        Some(())
    }

    fn read_uvs<'a>(
        &mut self,
        attributes: &Json<'a>,
        needs: &VertexNeeds,
        accessors: &Accessors<'a, '_>,
    ) -> Option<()> {
        // Tangents follow texture coordinates, also where no texture needs them.
        let is_alone = needs.tangents && needs.sets.is_empty() && attributes.has("TEXCOORD_0");
        let of_tangents: &[usize] = if is_alone { &[0] } else { &[] };
        for set in needs.sets.iter().chain(of_tangents) {
            let name = format!("TEXCOORD_{set}");
            let Some(at) = attributes.get(&name) else {
                let message =
                    format!("the material has textures by {name}, which the primitive lacks");
                attributes.warn_once("texture coordinates", message);
                continue;
            };
            let allowed = if accessors.quantized {
                accessors.attribute()
            } else {
                UNIT
            };
            let uvs: Vec<[f32; 2]> = accessors.floats(&at, "VEC2", allowed)?;
            self.check_count(&at, uvs.len())?;
            self.uvs
                .push((*set, uvs.into_iter().map(Vec2::from).collect()));
        }
        Some(())
    }

    /// Reports an attribute with another number of elements than there are positions.
    pub(super) fn check_count(&self, at: &Json<'_>, count: usize) -> Option<()> {
        let expected = self.positions.len();
        if count == expected {
            return Some(());
        }
        at.error(format!(
            "the accessor has {count} elements, but POSITION has {expected}"
        ));
        None
    }

    /// Drops vertices that no triangle has: files keep the vertices of many primitives in one
    /// array.
    pub(super) fn drop_unused_vertices(&mut self) {
        let mut is_used = vec![false; self.positions.len()];
        for &corner in self.triangles.as_flattened() {
            is_used[corner as usize] = true;
        }
        let used: Vec<u32> = (0..is_used.len() as u32)
            .filter(|&i| is_used[i as usize])
            .collect();
        if used.len() == is_used.len() {
            return;
        }
        let mut index = vec![0; is_used.len()];
        for (new, &old) in used.iter().enumerate() {
            index[old as usize] = new as u32;
        }
        for corner in self.triangles.as_flattened_mut() {
            *corner = index[*corner as usize];
        }
        self.pick_vertices(&used);
    }

    /// Replaces the vertices by those of these indices.
    pub(super) fn pick_vertices(&mut self, indices: &[u32]) {
        pick(&mut self.positions, indices);
        pick(&mut self.normals, indices);
        pick(&mut self.tangents, indices);
        pick(&mut self.signs, indices);
        pick(&mut self.colors, indices);
        self.uvs.iter_mut().for_each(|(_, uvs)| pick(uvs, indices));
    }

    /// Size in memory.
    pub(super) fn bytes(&self) -> usize {
        let uvs = self.uvs.iter().map(|(_, uvs)| size_of_val(&uvs[..]));
        size_of_val(&self.positions[..])
            + size_of_val(&self.normals[..])
            + size_of_val(&self.tangents[..])
            + size_of_val(&self.signs[..])
            + size_of_val(&self.colors[..])
            + size_of_val(&self.triangles[..])
            + uvs.sum::<usize>()
    }

    /// Reverses the order of the corners, for transforms that mirror.
    pub(super) fn reverse(&mut self) {
        for triangle in &mut self.triangles {
            triangle.swap(1, 2);
        }
    }
}

/// Replaces the values, if there are any, by those of these indices.
fn pick<T: Copy>(values: &mut Vec<T>, indices: &[u32]) {
    if !values.is_empty() {
        *values = indices.iter().map(|&i| values[i as usize]).collect();
    }
}

/// The triangles of a primitive of `count` vertices.
fn triangles<'a>(
    json: &Json<'a>,
    mode: u64,
    count: usize,
    accessors: &Accessors<'a, '_>,
) -> Option<Vec<[u32; 3]>> {
    let corners: Vec<u32> = match json.get("indices") {
        Some(at) => {
            let indices: Vec<[u32; 1]> = accessors.integers(&at, "SCALAR", INDEX)?;
            let is_outside = |index: &[u32; 1]| index[0] as usize >= count;
            if let Some(i) = indices.iter().position(is_outside) {
                at.error(format!(
                    "index {i} is {}, expected less than {count}, the number of vertices",
                    indices[i][0]
                ));
                return None;
            }
            indices.into_flattened()
        }
        None => (0..u32::try_from(count).ok()?).collect(),
    };
    let triangle = |i: usize, [a, b, c]: [usize; 3]| {
        let corner = |k: usize| corners[i + k];
        [corner(a), corner(b), corner(c)]
    };
    let strip = corners.len().saturating_sub(2);
    Some(match mode {
        TRIANGLE_STRIP => (0..strip)
            .map(|i| triangle(i, if i % 2 == 0 { [0, 1, 2] } else { [0, 2, 1] }))
            .collect(),
        TRIANGLE_FAN => (0..strip)
            .map(|i| [corners[i + 1], corners[i + 2], corners[0]])
            .collect(),
        _ => {
            if !corners.len().is_multiple_of(3) {
                let message = format!(
                    "{} corners are not whole triangles; the last ones are ignored",
                    corners.len()
                );
                json.warn_once("incomplete triangles", message);
            }
            corners
                .chunks_exact(3)
                .map(|c| [c[0], c[1], c[2]])
                .collect()
        }
    })
}

/// Differences of positions or normals of one morph target.
pub(super) fn morph_differences<'a>(
    at: &Json<'a>,
    accessors: &Accessors<'a, '_>,
) -> Option<Vec<[f32; 3]>> {
    let allowed = if accessors.quantized {
        accessors.attribute()
    } else {
        FLOAT
    };
    accessors.floats(at, "VEC3", allowed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unused_vertices_are_dropped() {
        let mut geometry = Geometry {
            positions: (0..6).map(|i| Vec3::splat(i as f32)).collect(),
            uvs: vec![(0, (0..6).map(|i| Vec2::splat(i as f32)).collect())],
            triangles: vec![[5, 1, 3], [3, 1, 5]],
            ..Geometry::default()
        };
        geometry.drop_unused_vertices();
        assert_eq!(geometry.triangles, [[2, 0, 1], [1, 0, 2]]);
        assert_eq!(geometry.positions, [1.0, 3.0, 5.0].map(Vec3::splat));
        assert_eq!(geometry.uvs[0].1, [1.0, 3.0, 5.0].map(Vec2::splat));
        assert_eq!(geometry.bytes(), 3 * 12 + 3 * 8 + 2 * 12);
    }
}
