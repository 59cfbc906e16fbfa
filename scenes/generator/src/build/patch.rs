//! Surfaces through rows of points, and triangulation of flat polygons.

use crate::mesh::Mesh;
use glam::{DVec2, DVec3};

/// Relative difference of squared lengths that counts as a tie between two diagonals.
const TIE: f64 = 1e-9;
/// Twice the area, in square meters, of the smallest triangle that counts as an ear.
const MIN_DOUBLED_EAR_AREA: f64 = 1e-12;

/// How the two ends of each row of a grid connect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edges {
    /// Not at all.
    Open,
    /// The last point of a row is adjacent to the first.
    Joined,
}

/// A surface through rows with the same number of points. It faces the direction of (along a row) x
/// (to the next row). Edges sharper than `crease` degrees stay sharp.
pub fn grid(rows: &[Vec<DVec3>], edges: Edges, crease: f64) -> Mesh {
    Mesh::shaded(rows.concat(), grid_triangles(rows, edges), crease)
}

/// A closed solid through rings with the same number of points, capped by a polygon at each end.
pub fn loft(rings: &[Vec<DVec3>], crease: f64) -> Mesh {
    let mut triangles = grid_triangles(rings, Edges::Joined);
    let count = rings[0].len() as u32;
    let start = (rings.len() as u32 - 1) * count;
    for t in polygon_triangles(&flattened(&rings[0])) {
        triangles.push([t[0], t[2], t[1]]);
    }
    for t in polygon_triangles(&flattened(&rings[rings.len() - 1])) {
        triangles.push(t.map(|i| i + start));
    }
    Mesh::shaded(rings.concat(), triangles, crease)
}

fn grid_triangles(rows: &[Vec<DVec3>], edges: Edges) -> Vec<[u32; 3]> {
    let count = rows[0].len() as u32;
    let across = match edges {
        Edges::Open => count - 1,
        Edges::Joined => count,
    };
    let mut triangles = Vec::new();
    for row in 0..rows.len() as u32 - 1 {
        for i in 0..across {
            let next = (i + 1) % count;
            let (here, above) = (row * count, (row + 1) * count);
            let [a, b, c, d] = [here + i, here + next, above + next, above + i];
            // The shorter diagonal follows a curved surface better; the factor decides ties the
            // same way everywhere.
            let at = |i: u32| rows[(i / count) as usize][(i % count) as usize];
            if at(a).distance_squared(at(c)) <= at(b).distance_squared(at(d)) * (1.0 + TIE) {
                triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    triangles
}

/// A ring projected to the plane across its area vector.
fn flattened(ring: &[DVec3]) -> Vec<DVec2> {
    let area: DVec3 = (0..ring.len())
        .map(|i| (ring[i] - ring[0]).cross(ring[(i + 1) % ring.len()] - ring[0]))
        .sum();
    let (first, second) = area.normalize_or(DVec3::Z).any_orthonormal_pair();
    ring.iter()
        .map(|&p| DVec2::new(p.dot(first), p.dot(second)))
        .collect()
}

/// Triangulates a counterclockwise polygon without holes by ear clipping.
pub fn polygon_triangles(polygon: &[DVec2]) -> Vec<[u32; 3]> {
    let mut left: Vec<u32> = (0..polygon.len() as u32).collect();
    let mut triangles = Vec::new();
    while left.len() > 3 {
        let ear = (0..left.len()).find(|&i| is_ear(polygon, &left, i));
        // A polygon without an ear is degenerate or intersects itself; then any corner is clipped.
        let i = ear.unwrap_or(0);
        triangles.push(corners_at(&left, i));
        left.remove(i);
    }
    if let [a, b, c] = left[..] {
        triangles.push([a, b, c]);
    }
    triangles
}

/// The corner `i` of the remaining polygon between its neighbours.
fn corners_at(left: &[u32], i: usize) -> [u32; 3] {
    let n = left.len();
    [left[(i + n - 1) % n], left[i], left[(i + 1) % n]]
}

/// Whether the corner `i` is convex and its triangle contains no other remaining corner.
fn is_ear(polygon: &[DVec2], left: &[u32], i: usize) -> bool {
    let corners = corners_at(left, i);
    let [a, b, c] = corners.map(|k| polygon[k as usize]);
    let side = |p: DVec2, q: DVec2, r: DVec2| (q - p).perp_dot(r - p);
    if side(a, b, c) <= MIN_DOUBLED_EAR_AREA {
        return false;
    }
    left.iter().filter(|k| !corners.contains(k)).all(|&k| {
        let p = polygon[k as usize];
        side(a, b, p) < 0.0 || side(b, c, p) < 0.0 || side(c, a, p) < 0.0
    })
}
