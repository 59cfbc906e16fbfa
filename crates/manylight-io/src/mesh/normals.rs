//! Smooth vertex normals for meshes without normals.

use glam::{Affine3A, Vec3A};
use manylight::geometry::Mesh;
use manylight::math::Vec3;

/// Normal of a vertex without a triangle of positive area, as in Mitsuba.
const FALLBACK: Vec3 = Vec3::X;

/// Sets every vertex normal to the mean of the adjacent triangle normals, weighted by the angle at
/// the vertex (Thürmer and Wüthrich 1998), as Mitsuba does for meshes without normals. Vertices
/// with equal positions (for instance along uv seams) are not merged.
pub fn smooth_normals(mesh: &mut Mesh) {
    mesh.normals = angle_weighted(mesh);
}

/// Like [`smooth_normals`], but weighted by the angles in world space, as in Mitsuba. The normals
/// are stored in object space: the inverse transpose of `world_from_object` maps them to the
/// world-space normals. The result differs from that of [`smooth_normals`] only if the transform
/// changes angles or mirrors.
pub fn smooth_normals_placed(mesh: &mut Mesh, world_from_object: &Affine3A) {
    let object_positions = mesh.positions.clone();
    for p in &mut mesh.positions {
        *p = world_from_object.transform_point3(*p);
    }
    let world = angle_weighted(mesh);
    mesh.positions = object_positions;
    // The inverse transpose maps normals to world space, so the transpose maps them back. Mitsuba's
    // world-space normals follow the winding order of the transformed triangles even if the
    // transform mirrors, so no sign is changed.
    let object_from_world = world_from_object.matrix3.transpose();
    mesh.normals = world
        .into_iter()
        .map(|n| Vec3::from(object_from_world * Vec3A::from(n)).normalize_or(FALLBACK))
        .collect();
}

/// Winds every triangle so that its geometric normal in world space is on the side of its vertex
/// normals, or, without vertex normals, on the side of its geometric normal in object space.
/// `mirrored`: the transform to world space mirrors, which turns geometric normals but not vertex
/// normals.
pub fn orient_to_normals(mesh: &mut Mesh, mirrored: bool) {
    if mesh.normals.is_empty() {
        if mirrored {
            mesh.triangles
                .iter_mut()
                .for_each(|triangle| triangle.swap(1, 2));
        }
        return;
    }
    for triangle in &mut mesh.triangles {
        let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
        let shading: Vec3 = triangle.iter().map(|&i| mesh.normals[i as usize]).sum();
        let agreement = (b - a).cross(c - a).dot(shading);
        if agreement < 0.0 && !mirrored || agreement > 0.0 && mirrored {
            triangle.swap(1, 2);
        }
    }
}

/// Replaces the normals that are zero, which mark vertices without a normal in the file, by smooth
/// ones.
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

/// Angle between unit vectors from the length of their chord, which is accurate for all angles,
/// unlike the arc cosine (Kahan).
fn angle_between_units(a: Vec3, b: Vec3) -> f32 {
    if a.dot(b) < 0.0 {
        std::f32::consts::PI - 2.0 * (0.5 * (a + b).length()).min(1.0).asin()
    } else {
        2.0 * (0.5 * (b - a).length()).min(1.0).asin()
    }
}
