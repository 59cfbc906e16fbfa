//! Solids swept along a path or a straight line.

use super::patch::{Edges, grid, loft, polygon_triangles};
use crate::mesh::Mesh;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Angle between faces, in degrees, from which an edge of a tube is sharp.
const TUBE_CREASE: f64 = 60.0;
/// Distance in meters below which the ends of a path are the same point.
const SAME_POINT: f64 = 1e-9;

/// A round tube along a path. Its ends are capped, or joined if the path ends where it starts.
/// `radius` is a function of the position along the path, from 0 to 1 by index of the point.
pub fn tube(path: &[DVec3], segments: usize, radius: impl Fn(f64) -> f64) -> Mesh {
    let last = path.len() - 1;
    let loops = is_loop(path);
    let mut side = tangent(path, 0, loops).any_orthonormal_vector();
    let rings: Vec<Vec<DVec3>> = (0..=last)
        .map(|i| {
            // Projecting the previous side vector keeps the tube free of twist.
            let along = tangent(path, i, loops);
            side = (side - along * along.dot(side)).normalize();
            let up = along.cross(side);
            let r = radius(i as f64 / last as f64);
            (0..segments)
                .map(|s| {
                    let (sin, cos) = (TAU * s as f64 / segments as f64).sin_cos();
                    path[i] + r * (side * cos + up * sin)
                })
                .collect()
        })
        .collect();
    if loops {
        let mut rings = rings;
        rings[last] = rings[0].clone();
        grid(&rings, Edges::Joined, TUBE_CREASE)
    } else {
        loft(&rings, TUBE_CREASE)
    }
}

/// Whether a path ends where it starts.
fn is_loop(path: &[DVec3]) -> bool {
    path[0].distance(path[path.len() - 1]) < SAME_POINT
}

/// Unit direction of a path at point `i`, from its neighbours.
fn tangent(path: &[DVec3], i: usize, loops: bool) -> DVec3 {
    let last = path.len() - 1;
    let (before, after) = match (i, loops) {
        (0, true) => (last - 1, 1),
        (i, true) if i == last => (last - 1, 1),
        _ => (i.saturating_sub(1), (i + 1).min(last)),
    };
    (path[after] - path[before]).normalize()
}

/// A counterclockwise polygon in x and y, extruded along z by `thickness` about the plane z = 0.
pub fn extrude(polygon: &[DVec2], thickness: f64, crease: f64) -> Mesh {
    let n = polygon.len() as u32;
    let at = |z: f64| polygon.iter().map(move |p| p.extend(z));
    let positions: Vec<DVec3> = at(-thickness / 2.0).chain(at(thickness / 2.0)).collect();
    let mut triangles = Vec::new();
    for [a, b, c] in polygon_triangles(polygon) {
        triangles.extend([[a, c, b], [a + n, b + n, c + n]]);
    }
    for i in 0..n {
        let next = (i + 1) % n;
        triangles.extend([[i, next, next + n], [i, next + n, i + n]]);
    }
    Mesh::shaded(positions, triangles, crease)
}

/// A profile swept along a level path with mitred corners. The profile is counterclockwise; its x
/// axis points right of the path, its y axis up. Ends are capped, or joined if the path ends where
/// it starts.
pub fn moulding(profile: &[DVec2], path: &[DVec3], crease: f64) -> Mesh {
    let last = path.len() - 1;
    let loops = is_loop(path);
    let direction = |i: usize| (path[i + 1] - path[i]).normalize();
    let rings: Vec<Vec<DVec3>> = (0..=last)
        .map(|i| {
            let into = match (i, loops) {
                (0, false) => direction(0),
                (0, true) => direction(last - 1),
                _ => direction(i - 1),
            };
            let out = match (i == last, loops) {
                (true, false) => direction(last - 1),
                (true, true) => direction(0),
                _ => direction(i),
            };
            let right = (into.cross(DVec3::Y) + out.cross(DVec3::Y)).normalize();
            // The section along the mitre is wider than the profile by 1 / cos(half the turning
            // angle).
            let stretch = 1.0 / right.dot(into.cross(DVec3::Y).normalize());
            profile
                .iter()
                .rev()
                .map(|p| path[i] + right * (p.x * stretch) + DVec3::Y * p.y)
                .collect()
        })
        .collect();
    if loops {
        grid(&rings, Edges::Joined, crease)
    } else {
        loft(&rings, crease)
    }
}
