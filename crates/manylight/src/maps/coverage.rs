//! How much of the kernel of a density estimate is surface.
//!
//! An estimate spreads each photon over a disc, much of which may hang in the air beside an edge or a thin tube. Divided by the part
//! of the disc that is surface, which some short rays tell, what falls off an edge is given back near it.

use super::density::Receiver;
use crate::geometry::{Geometry, Ray};
use crate::math::Frame;
use std::f32::consts::TAU;

/// Probes where the camera sees the estimate.
pub const PROBES: u32 = 16;
/// Probes where it is part of other light.
pub const FEW_PROBES: u32 = 8;

/// How much of the kernel around the receiver lies on its surface, in (0, 1], told by so many probes. Their pattern is turned by `turn`.
pub fn covered(
    geometry: &Geometry,
    receiver: Receiver,
    radius: f32,
    probes: u32,
    turn: f32,
) -> f32 {
    let Receiver { p, n } = receiver;
    let frame = Frame::from_normal(n);
    let height = receiver.slab(radius);
    let is_surface = |i: &u32| {
        // Distances by the Epanechnikov kernel, whose cumulative distribution over s = d²/r² is 2s - s²; angles by the golden
        // ratio.
        let u = (*i as f32 + 0.5) / probes as f32;
        let distance = radius * (1.0 - (1.0 - u).sqrt()).sqrt();
        let (sin, cos) = ((turn + *i as f32 * 0.618_034).fract() * TAU).sin_cos();
        let above = p + (frame.s * cos + frame.t * sin) * distance + n * height;
        let down = Ray {
            t_max: 2.0 * height,
            ..Ray::new(above, -n)
        };
        geometry.intersect(&down).is_some_and(|hit| {
            let there = geometry.surface_point(hit.at);
            receiver.shares_surface(there.p, there.normal_towards(n), radius)
        })
    };
    let count = (0..probes).filter(is_surface).count().max(1);
    count as f32 / probes as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::testing::scenes::{Builder, diffuse};

    #[test]
    fn a_kernel_over_an_edge_is_covered_in_part() {
        let mut builder = Builder::new(Vec3::Z * 5.0, Vec3::ZERO, 40.0, 4);
        let grey = builder.material(diffuse(0.5, 0.5, 0.5));
        builder.rectangle(Vec3::ZERO, Vec3::X, Vec3::Y, grey, None);
        let scene = builder.build();
        let at = |x: f32, radius: f32| {
            let p = Vec3::new(x, 0.013, 0.0);
            covered(
                &scene.geometry,
                Receiver { p, n: Vec3::Z },
                radius,
                PROBES,
                0.3,
            )
        };
        assert_eq!(at(0.0, 0.1), 1.0);
        // Half of it at the edge; the square of 4 m² is little of a kernel of 20 m.
        assert!((at(0.999, 0.1) - 0.5).abs() < 0.13, "{}", at(0.999, 0.1));
        assert!(at(0.0, 20.0) < 0.1);
    }
}
