//! Surfaces that emit on both sides. Area emitters have one side, so an open double-sided surface
//! gets a second one, which is turned over and lies behind it.

use super::primitives::Geometry;
use manylight::math::{Aabb, Vec3};
use manylight::texture::ColorInput;
use std::collections::HashMap;

/// Distance of the second surface, relative to the diagonal of the bounds: far above the rounding
/// of coordinates, and too small to see.
const DISTANCE: f32 = 1e-4;

/// A key of emitted radiance, which is the same for equal values only.
pub(super) fn key(radiance: ColorInput) -> [u32; 4] {
    match radiance {
        ColorInput::Constant(c) => [0, c.r.to_bits(), c.g.to_bits(), c.b.to_bits()],
        ColorInput::Texture(id) => [1, id.0, 0, 0],
    }
}

/// The back of a surface.
pub(super) fn back(geometry: &Geometry) -> Geometry {
    let mut back = geometry.clone();
    let bounds = Aabb::from_points(geometry.positions.iter().copied());
    let distance = DISTANCE * (bounds.max - bounds.min).length();
    let normals = match geometry.normals.is_empty() {
        true => mean_normals(geometry),
        false => geometry.normals.clone(),
    };
    for (position, normal) in back.positions.iter_mut().zip(normals) {
        *position -= normal * distance;
    }
    for normal in &mut back.normals {
        *normal = -*normal;
    }
    back.reverse();
    back
}

/// Whether every edge has a triangle on each side. Vertices with equal positions are the same; 0 is
/// added because 0 and -0 are equal.
pub(super) fn is_closed(geometry: &Geometry) -> bool {
    let place = |vertex: u32| {
        geometry.positions[vertex as usize]
            .to_array()
            .map(|v| (v + 0.0).to_bits())
    };
    let mut edges: HashMap<_, i64> = HashMap::new();
    for triangle in &geometry.triangles {
        for corner in 0..3 {
            let (a, b) = (place(triangle[corner]), place(triangle[(corner + 1) % 3]));
            match a.cmp(&b) {
                std::cmp::Ordering::Less => *edges.entry((a, b)).or_default() += 1,
                std::cmp::Ordering::Greater => *edges.entry((b, a)).or_default() -= 1,
                std::cmp::Ordering::Equal => {}
            }
        }
    }
    edges.values().all(|balance| *balance == 0)
}

/// The sums of the normals of the triangles at each vertex, normalized.
fn mean_normals(geometry: &Geometry) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; geometry.positions.len()];
    for triangle in &geometry.triangles {
        let [a, b, c] = triangle.map(|i| geometry.positions[i as usize]);
        for corner in triangle {
            sums[*corner as usize] += (b - a).cross(c - a);
        }
    }
    sums.into_iter().map(Vec3::normalize_or_zero).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use manylight::geometry::Mesh;

    fn geometry(mesh: Mesh) -> Geometry {
        Geometry {
            positions: mesh.positions,
            normals: mesh.normals,
            triangles: mesh.triangles,
            ..Geometry::default()
        }
    }

    #[test]
    fn backs_of_open_surfaces_lie_behind_them() {
        assert!(is_closed(&geometry(Mesh::cube())));
        assert!(!is_closed(&geometry(Mesh::rectangle())));
        let square = back(&geometry(Mesh::rectangle()));
        assert!(square.positions.iter().all(|p| p.z < 0.0 && p.z > -0.001));
        assert!(square.normals.iter().all(|n| *n == Vec3::NEG_Z));
        let [a, b, c] = square.triangles[0].map(|i| square.positions[i as usize]);
        assert!((b - a).cross(c - a).z < 0.0);
    }
}
