//! What specular events throw onto smooth ones: a density estimate over caustic photons.
//!
//! The estimate spreads each photon over a disc, much of which may hang in the air beside an edge or a thin tube. So it is divided by
//! the part of the disc that is surface, which some short rays tell: what falls off an edge is given back near it.

use super::eye_path::Gathering;
use super::light_set::LightSet;
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::geometry::{Geometry, Ray};
use crate::maps::Neighbors;
use crate::maps::density::{Bandwidth, Receiver, estimate};
use crate::math::Frame;
use crate::sampling::rng;
use std::f32::consts::TAU;

/// Photons in an estimate.
pub(super) const CAUSTIC_NEIGHBORS: usize = 48;
/// Largest radius of an estimate in pixels, after one pass.
const CAUSTIC_PIXELS: f32 = 72.0;
/// And as a share of the scene's diagonal.
const CAUSTIC_RADIUS: f32 = 0.03;
/// Radii shrink with the number of passes to the power of less this, so that the mean over passes goes to the right picture:
/// squared radii by n^(-1/3), where the errors by blur and by noise fall alike.
/// Source: Knaus, Zwicker, "Progressive Photon Mapping: A Probabilistic Approach", ACM TOG 2011, with alpha = 2/3.
const CAUSTIC_SHRINKING: f32 = 1.0 / 6.0;
/// Places in the disc that are looked at.
const PROBES: u32 = 16;

/// How far estimates at a gathering point look.
pub(super) fn bandwidth(set: &LightSet, point: &Gathering) -> Bandwidth {
    let largest = CAUSTIC_RADIUS * set.scene.geometry.bounds().diagonal();
    Bandwidth {
        largest: point.reach.min(largest),
        share: (set.passes.end as f32).powf(-CAUSTIC_SHRINKING),
    }
}

impl LightSet<'_> {
    /// Density estimate over caustic photons: `Σ_j k_j f Φ_j`, over the covered part of the kernel. On glossy lobes, eye paths
    /// look for what photons bring from other surfaces.
    pub(super) fn caustic_radiance(&self, point: &Gathering, found: &mut Neighbors) -> Rgb {
        let x = &point.at.x;
        let n = point.at.lit_from.unwrap_or(x.normal_towards(point.at.wo));
        let receiver = Receiver { p: x.p, n };
        let mut sum = Rgb::BLACK;
        let radius = estimate(
            &self.caustics,
            receiver,
            bandwidth(self, point),
            found,
            |photon, kernel| {
                if self.limits.allow(point.segments + u32::from(photon.depth)) {
                    let lobes = if photon.origin == Lobes::NONE {
                        Lobes::SMOOTH
                    } else {
                        Lobes::DIFFUSE
                    };
                    sum += photon.flux * point.at.bsdf.f(photon.wi, point.at.wo, lobes) * kernel;
                }
            },
        );
        if sum.is_black() {
            return sum;
        }
        // The view names the turn of the probes: it differs in every pass, and not with the scene's unit of length.
        let turn = rng::unit(rng::key(point.at.wo.to_array()));
        sum / covered(&self.scene.geometry, receiver, radius, turn)
    }

    /// Largest radius of an estimate at the end of an eye path of the given length, in m: some pixels.
    pub(super) fn caustic_reach(&self, length: f32) -> f32 {
        CAUSTIC_PIXELS * (self.pixel.0 + self.pixel.1 * length)
    }
}

/// How much of the kernel around the receiver lies on its surface, in (0, 1]. The pattern of probes is turned by `turn`.
fn covered(geometry: &Geometry, receiver: Receiver, radius: f32, turn: f32) -> f32 {
    let Receiver { p, n } = receiver;
    let frame = Frame::from_normal(n);
    let height = receiver.slab(radius);
    let is_surface = |i: &u32| {
        // Distances by the Epanechnikov kernel, whose cumulative distribution over s = d²/r² is 2s - s²; angles by the golden
        // ratio.
        let u = (*i as f32 + 0.5) / PROBES as f32;
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
    let count = (0..PROBES).filter(is_surface).count().max(1);
    count as f32 / PROBES as f32
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
            covered(&scene.geometry, Receiver { p, n: Vec3::Z }, radius, 0.3)
        };
        assert_eq!(at(0.0, 0.1), 1.0);
        // Half of it at the edge; the square of 4 m² is little of a kernel of 20 m.
        assert!((at(0.999, 0.1) - 0.5).abs() < 0.13, "{}", at(0.999, 0.1));
        assert!(at(0.0, 20.0) < 0.1);
    }
}
