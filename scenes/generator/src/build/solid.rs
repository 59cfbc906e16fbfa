//! Boxes and superellipsoids.

use super::patch::{Edges, grid};
use crate::mesh::Mesh;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Largest bevel, as a fraction of the smallest half extent of a box.
const MAX_BEVEL: f64 = 0.9;
/// Angle between faces, in degrees, from which an edge of a superellipsoid is sharp.
const CREASE: f64 = 60.0;

/// A box between two corners with sharp edges.
pub fn boxed(low: [f64; 3], high: [f64; 3]) -> Mesh {
    let (low, high) = (DVec3::from(low), DVec3::from(high));
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        for end in [low, high] {
            let corner = |u: f64, v: f64| face_corner(axis, end[axis], low, high, u, v);
            let ring = [
                corner(0.0, 0.0),
                corner(1.0, 0.0),
                corner(1.0, 1.0),
                corner(0.0, 1.0),
            ];
            let normal = DVec3::AXES[axis] * (end[axis] - (low + high)[axis] / 2.0).signum();
            push_quad(&mut mesh, ring, [normal; 4]);
        }
    }
    mesh
}

/// A point of the face at `level` on `axis`; u and v, from 0 to 1, run along the other two axes.
fn face_corner(axis: usize, level: f64, low: DVec3, high: DVec3, u: f64, v: f64) -> DVec3 {
    let mut corner = DVec3::ZERO;
    let (first, second) = ((axis + 1) % 3, (axis + 2) % 3);
    corner[axis] = level;
    corner[first] = low[first] + (high[first] - low[first]) * u;
    corner[second] = low[second] + (high[second] - low[second]) * v;
    corner
}

/// Adds two triangles over a ring of four corners, oriented as their normals.
fn push_quad(mesh: &mut Mesh, ring: [DVec3; 4], normals: [DVec3; 4]) {
    let start = mesh.positions.len() as u32;
    mesh.positions.extend(ring);
    mesh.normals.extend(normals);
    let facing = (ring[1] - ring[0]).cross(ring[2] - ring[0]);
    let order = if facing.dot(normals[0] + normals[2]) > 0.0 {
        [[0, 1, 2], [0, 2, 3]]
    } else {
        [[0, 2, 1], [0, 3, 2]]
    };
    mesh.triangles
        .extend(order.map(|t| t.map(|i: u32| i + start)));
}

/// A box between two corners with edges bevelled by `bevel`. Corners of a face keep its normal, so
/// the bevels are shaded as if round. The bevel is at most 0.9 of the smallest half extent.
pub fn bevelled_box(low: [f64; 3], high: [f64; 3], bevel: f64) -> Mesh {
    let (low, high) = (DVec3::from(low), DVec3::from(high));
    let center = (low + high) / 2.0;
    let half = (high - low) / 2.0;
    let bevel = bevel.min(half.min_element() * MAX_BEVEL);
    let mut mesh = Mesh::default();
    // Vertex 3 c + a belongs to corner c (bits: x, y, z) and to its face across axis a.
    for c in 0..8 {
        let sign = corner_sign(c);
        for axis in 0..3 {
            let mut inset = half - bevel;
            inset[axis] = half[axis];
            mesh.positions.push(center + sign * inset);
            mesh.normals.push(DVec3::AXES[axis] * sign[axis]);
        }
    }
    for axis in 0..3 {
        let (first, second) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        for end in [0, 1 << axis] {
            let ring = [end, end | first, end | first | second, end | second];
            push_facing(&mut mesh, &ring.map(|c| 3 * c + axis), center);
        }
        // The bevels of the four edges along this axis.
        let (other, another) = ((axis + 1) % 3, (axis + 2) % 3);
        for start in [0, first, second, first | second] {
            let end = start | 1 << axis;
            let ring = [
                3 * start + other,
                3 * end + other,
                3 * end + another,
                3 * start + another,
            ];
            push_facing(&mut mesh, &ring, center);
        }
    }
    for c in 0..8 {
        push_facing(&mut mesh, &[3 * c, 3 * c + 1, 3 * c + 2], center);
    }
    mesh
}

/// Signs of the coordinates of a corner given by bits.
fn corner_sign(c: usize) -> DVec3 {
    let sign = |bit: usize| if c & (1 << bit) == 0 { -1.0 } else { 1.0 };
    DVec3::new(sign(0), sign(1), sign(2))
}

/// Adds the triangles of a convex polygon, facing away from `center`.
fn push_facing(mesh: &mut Mesh, ring: &[usize], center: DVec3) {
    let at = |i: usize| mesh.positions[i];
    let normal = (at(ring[1]) - at(ring[0])).cross(at(ring[2]) - at(ring[0]));
    let outwards = normal.dot(at(ring[0]) - center) > 0.0;
    for i in 1..ring.len() - 1 {
        let (b, c) = if outwards { (i, i + 1) } else { (i + 1, i) };
        mesh.triangles
            .push([ring[0], ring[b], ring[c]].map(|v| v as u32));
    }
}

/// A superellipsoid about the origin. Exponents of 1 give an ellipsoid; smaller ones are closer to
/// a box. `upright` is the exponent of the outline seen from the side, `around` of the one seen
/// from above.
pub fn superellipsoid(radii: [f64; 3], upright: f64, around: f64, segments: usize) -> Mesh {
    let power = |x: f64, exponent: f64| x.abs().powf(exponent) * x.signum();
    let rows: Vec<Vec<DVec3>> = (0..=segments / 2)
        .map(|row| {
            let latitude = FRAC_PI_2 * (4.0 * row as f64 / segments as f64 - 1.0);
            let pole = row == 0 || row == segments / 2;
            let ring = if pole {
                0.0
            } else {
                power(latitude.cos(), upright)
            };
            (0..segments)
                .map(|i| {
                    let (sin, cos) = (TAU * i as f64 / segments as f64).sin_cos();
                    DVec3::new(
                        radii[0] * ring * power(cos, around),
                        radii[1] * power(latitude.sin(), upright),
                        -radii[2] * ring * power(sin, around),
                    )
                })
                .collect()
        })
        .collect();
    grid(&rows, Edges::Joined, CREASE)
}
