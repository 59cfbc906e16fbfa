//! Surfaces of revolution about the y axis.

use super::curve::arc;
use super::patch::{Edges, grid};
use crate::mesh::Mesh;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Angle between faces, in degrees, from which an edge is sharp.
const CREASE: f64 = 40.0;

/// A profile of (radius, height) revolved about the y axis. The surface faces right of the
/// direction along the profile, so a profile from bottom to top faces outwards. It is closed if the
/// profile starts and ends on the axis, or is a loop.
pub fn lathe(profile: &[DVec2], segments: usize) -> Mesh {
    let rows: Vec<Vec<DVec3>> = profile
        .iter()
        .map(|p| {
            (0..segments)
                .map(|i| {
                    let (sin, cos) = (TAU * i as f64 / segments as f64).sin_cos();
                    DVec3::new(p.x * cos, p.y, -p.x * sin)
                })
                .collect()
        })
        .collect();
    grid(&rows, Edges::Joined, CREASE)
}

/// A closed cylinder on the plane y = 0.
pub fn cylinder(radius: f64, height: f64, segments: usize) -> Mesh {
    let profile = [(0.0, 0.0), (radius, 0.0), (radius, height), (0.0, height)];
    lathe(&profile.map(DVec2::from), segments)
}

/// A closed cylinder on the plane y = 0 with bevelled rims.
pub fn bevelled_cylinder(radius: f64, height: f64, bevel: f64, segments: usize) -> Mesh {
    let inner = radius - bevel;
    let profile = [
        (0.0, 0.0),
        (inner, 0.0),
        (radius, bevel),
        (radius, height - bevel),
        (inner, height),
        (0.0, height),
    ];
    lathe(&profile.map(DVec2::from), segments)
}

/// A sphere about the origin with poles on the y axis.
pub fn ball(radius: f64, segments: usize) -> Mesh {
    let mut profile = arc(DVec2::ZERO, radius, -90.0, 90.0, segments / 2);
    // Exactly on the axis, so that the points of each pole merge.
    profile[0].x = 0.0;
    profile[segments / 2].x = 0.0;
    lathe(&profile, segments)
}

/// A torus about the y axis: a circle of `radius`, with `around` segments, at `distance` from the
/// axis.
pub fn torus(distance: f64, radius: f64, segments: usize, around: usize) -> Mesh {
    let mut profile = arc(DVec2::new(distance, 0.0), radius, 0.0, 360.0, around);
    profile[around] = profile[0];
    lathe(&profile, segments)
}
