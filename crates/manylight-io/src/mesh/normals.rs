//! Smooth vertex normals for meshes that store none.

use glam::{Affine3A, Vec3A};
use manylight::geometry::Mesh;
use manylight::math::Vec3;

/// Where no triangle with an area touches a vertex, as Mitsuba has it.
const FALLBACK: Vec3 = Vec3::X;

/// Gives every vertex the mean of its triangles' normals, weighted by the angle at the vertex (Thürmer and Wüthrich 1998),
/// as Mitsuba does for meshes that store no normals. Existing normals are replaced. Vertices that lie at one place but are
/// stored twice, as along uv seams, are not joined.
pub fn smooth_normals(mesh: &mut Mesh) {
    mesh.normals = angle_weighted(mesh);
}

/// The same for a mesh that is placed in the world: the weights are the angles in world space, where Mitsuba takes them.
/// The normals are stored in object space, such that the inverse transpose of `world_from_object` gives the world normals.
/// The result differs from [`smooth_normals`] if the placement distorts angles or mirrors.
pub fn smooth_normals_placed(mesh: &mut Mesh, world_from_object: &Affine3A) {
    let object_positions = mesh.positions.clone();
    for p in &mut mesh.positions {
        *p = world_from_object.transform_point3(*p);
    }
    let world = angle_weighted(mesh);
    mesh.positions = object_positions;
    // Normals are placed by the inverse transpose, so the transpose leads back. Mitsuba's world normals follow the winding of
    // the placed triangles, also when the placement mirrors; no sign is changed here.
    let object_from_world = world_from_object.matrix3.transpose();
    mesh.normals = world
        .into_iter()
        .map(|n| Vec3::from(object_from_world * Vec3A::from(n)).normalize_or(FALLBACK))
        .collect();
}

/// Replaces only the normals that are zero: vertices that a file left without a normal.
pub(super) fn complete_normals(mesh: &mut Mesh) {
    if mesh.normals.iter().all(|&n| n != Vec3::ZERO) {
        return;
    }
    let smooth = angle_weighted(mesh);
    for (n, smooth) in mesh.normals.iter_mut().zip(smooth) {
        if *n == Vec3::ZERO {
            *n = smooth;
        }
    }
}

fn angle_weighted(mesh: &Mesh) -> Vec<Vec3> {
    let mut normals = vec![Vec3::ZERO; mesh.positions.len()];
    for triangle in &mesh.triangles {
        let corners = triangle.map(|i| mesh.positions[i as usize]);
        let normal = (corners[1] - corners[0])
            .cross(corners[2] - corners[0])
            .normalize_or_zero();
        if normal == Vec3::ZERO {
            continue;
        }
        for corner in 0..3 {
            let a = (corners[(corner + 1) % 3] - corners[corner]).normalize_or_zero();
            let b = (corners[(corner + 2) % 3] - corners[corner]).normalize_or_zero();
            normals[triangle[corner] as usize] += normal * angle_between_units(a, b);
        }
    }
    normals
        .into_iter()
        .map(|n| n.normalize_or(FALLBACK))
        .collect()
}

/// Stable for all angles, unlike the arc cosine: the half-angle follows from the chord (Kahan).
fn angle_between_units(a: Vec3, b: Vec3) -> f32 {
    if a.dot(b) < 0.0 {
        std::f32::consts::PI - 2.0 * (0.5 * (a + b).length()).min(1.0).asin()
    } else {
        2.0 * (0.5 * (b - a).length()).min(1.0).asin()
    }
}
