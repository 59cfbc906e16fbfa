//! Density of directions to the environment at a point, from photons that arrive around it.
//!
//! Few directions to the sky lead through a small window. Photons from the environment have found such directions.
//! Source: Jensen, "Importance Driven Path Tracing Using the Photon Map", EGWR 1995; here with von Mises-Fisher lobes.

use crate::math::{Frame, Vec2, Vec3};
use crate::sampling::warp::{von_mises_fisher, von_mises_fisher_pdf};

/// Largest number of lobes of a density. More make it smoother and slower to evaluate. Unmeasured.
pub const MAX_ENVIRONMENT_LOBES: usize = 32;
/// Smallest number of photons for a density.
const MIN_PHOTONS: usize = 4;
/// Smallest and largest variance `1/κ` of a lobe along each of two axes, in rad². Unmeasured.
const VARIANCE: [f32; 2] = [4e-4, 0.25];

/// A density over directions to the environment: a mixture of von Mises-Fisher lobes of equal weight and concentration, one for
/// each photon.
#[derive(Clone, Debug)]
pub struct EnvironmentLobes {
    axes: [Vec3; MAX_ENVIRONMENT_LOBES],
    count: usize,
    kappa: f32,
}

impl EnvironmentLobes {
    /// Of photons by their unit directions to the environment, at most [`MAX_ENVIRONMENT_LOBES`]; `None` for fewer than 4.
    pub fn new(directions: impl Iterator<Item = Vec3>) -> Option<Self> {
        let mut lobes = EnvironmentLobes {
            axes: [Vec3::Z; MAX_ENVIRONMENT_LOBES],
            count: 0,
            kappa: 0.0,
        };
        let mut sum = Vec3::ZERO;
        for direction in directions.take(MAX_ENVIRONMENT_LOBES) {
            lobes.axes[lobes.count] = direction;
            lobes.count += 1;
            sum += direction;
        }
        if lobes.count < MIN_PHOTONS {
            return None;
        }
        // Scott's rule for n samples in two dimensions: the kernel has n^(-1/3) of their variance.
        let n = lobes.count as f32;
        let variance = (1.0 - sum.length() / n) * n.powf(-1.0 / 3.0);
        lobes.kappa = variance.clamp(VARIANCE[0], VARIANCE[1]).recip();
        Some(lobes)
    }

    /// Samples a unit direction with the density [`EnvironmentLobes::pdf`]; `u_lobe` and `u` are uniform in [0, 1).
    pub fn sample(&self, u_lobe: f32, u: Vec2) -> Vec3 {
        let lobe = ((u_lobe * self.count as f32) as usize).min(self.count - 1);
        Frame::from_normal(self.axes[lobe])
            .to_world(von_mises_fisher(u, self.kappa))
            .normalize()
    }

    /// Density of the unit direction `w` by solid angle, in 1/sr.
    pub fn pdf(&self, w: Vec3) -> f32 {
        let lobes = &self.axes[..self.count];
        let sum: f32 = lobes
            .iter()
            .map(|axis| von_mises_fisher_pdf(axis.dot(w), self.kappa))
            .sum();
        sum / self.count as f32
    }
}
