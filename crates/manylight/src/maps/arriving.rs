//! Photons that arrive around a point of a camera path, ready to be summed:
//!
//! ```text
//! L = Σ_j k_j f_j Φ_j / c
//! ```
//!
//! with the kernel `k_j` in 1/m², the scattering function `f_j` in 1/sr, the flux `Φ_j` in W, and
//! the fraction `c` of the kernel that is surface, so that edges and thin tubes keep their light.

use super::density::{Bandwidth, DensityReceiver, OnSurface, density_estimate};
use super::{KdTree, Neighbors, covered_fraction};
use crate::bsdf::{Bsdf, FixedWoLanes, Lobes};
use crate::color::Rgb;
use crate::geometry::{Geometry, SurfacePoint};
use crate::math::Vec3;
use crate::scene::PathLimits;

/// A vertex of a camera path at which photons are summed.
#[derive(Clone, Copy, Debug)]
pub struct PhotonReceiver<'a, 's> {
    /// Surface point.
    pub x: &'a SurfacePoint,
    /// Scattering function.
    pub bsdf: &'a Bsdf<'s>,
    /// Unit direction to the viewer.
    pub wo: Vec3,
    /// Segments of the camera path up to here.
    pub segments: u32,
    /// Limits on the segments of camera path and photon together.
    pub limits: PathLimits,
}

/// The photons around a receiver that arrive on one side of its surface.
#[derive(Clone, Debug)]
pub struct ArrivingPhotons<'m, 'a, 's, P> {
    at: PhotonReceiver<'a, 's>,
    receiver: DensityReceiver,
    /// Radius of the kernel, in m.
    radius: f32,
    /// With `k_j / cosθ_j`, in 1/m²: sums are of `f cosθ`.
    photons: Vec<(&'m P, f32)>,
}

impl<'m, 'a, 's, P: OnSurface + Sync> ArrivingPhotons<'m, 'a, 's, P> {
    /// The photons within the path limits on the side of the unit normal `n`. As many are searched
    /// as `found` holds.
    pub fn around(
        photons: &'m KdTree<P>,
        at: PhotonReceiver<'a, 's>,
        n: Vec3,
        bandwidth: Bandwidth,
        found: &mut Neighbors,
    ) -> Self {
        let receiver = DensityReceiver { p: at.x.p, n };
        let mut arriving = Vec::new();
        let radius = density_estimate(photons, receiver, bandwidth, found, |photon, kernel| {
            let cos = photon.wi().dot(at.x.ng).abs();
            if cos > 0.0 && at.limits.allow(at.segments + photon.depth()) {
                arriving.push((photon, kernel / cos));
            }
        });
        ArrivingPhotons {
            at,
            receiver,
            radius,
            photons: arriving,
        }
    }

    /// Those for which `test` holds, and the others.
    pub fn partition(self, test: impl Fn(&P) -> bool) -> [Self; 2] {
        let (photons, others) = (self.photons.iter()).partition(|(photon, _)| test(photon));
        let of = |photons| ArrivingPhotons { photons, ..self };
        [of(photons), of(others)]
    }

    /// `f cosθ` of the lobes for each photon, in 1/sr.
    pub fn f_cos(&self, lobes: Lobes) -> Vec<Rgb> {
        let directions: Vec<Vec3> = self.iter().map(|(photon, _)| photon.wi()).collect();
        let mut f_cos = Vec::with_capacity(directions.len());
        FixedWoLanes::f_cos_each_wi(self.at.bsdf, &directions, self.at.wo, lobes, &mut f_cos);
        f_cos
    }

    /// The photons, each with `k / cosθ` in 1/m².
    pub fn iter(&self) -> impl Iterator<Item = (&'m P, f32)> {
        self.photons.iter().copied()
    }

    /// Calls `visit` with each photon, `f cosθ` of the lobes in 1/sr, and `k / cosθ` in 1/m².
    pub fn each(&self, lobes: Lobes, mut visit: impl FnMut(&'m P, Rgb, f32)) {
        for ((photon, kernel), f_cos) in self.iter().zip(self.f_cos(lobes)) {
            visit(photon, f_cos, kernel);
        }
    }

    /// Radius of the kernel, in m.
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// The covered fraction `c` of the kernel, by `probes` short rays.
    pub fn covered(&self, geometry: &Geometry, probes: u32) -> f32 {
        covered_fraction(geometry, self.receiver, self.radius, probes, self.at.wo)
    }
}
