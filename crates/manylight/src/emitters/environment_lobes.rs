//! Density of directions to the environment at a point, from photons that arrive around it.
//!
//! Few directions to the sky lead through a small window. Photons from the environment have found
//! such directions. Source: Jensen, "Importance Driven Path Tracing Using the Photon Map", EGWR
//! 1995; here with von Mises-Fisher lobes.

use crate::lanes::{Float, LANES, Mask, Vector, Width};
use crate::math::{Frame, Vec2, Vec3};
use crate::sampling::warp::{von_mises_fisher, von_mises_fisher_pdf};
use crate::simd::{Isa, Simd, SimdKernel};

/// Largest number of lobes of a density. More make it smoother and slower to evaluate: 16 take one
/// vector, 32 two. At 16 and 64 (2 passes of 128 lights at 72x40, 2 seeds; third-party kitchen):
/// relMSE +2.6 and +0.2 % (standard error 1 %).
pub const MAX_ENVIRONMENT_LOBES: usize = 32;
/// Smallest number of photons for a density.
const MIN_PHOTONS: usize = 4;
/// Smallest and largest variance `1/κ` of a lobe along each of two axes, in rad². Smallest at 2e-4
/// and 8e-4 (2 passes of 128 lights at 72x40, 2 seeds; third-party kitchen): relMSE -1.2 and +2.9 %
/// (standard error 1 %). Largest at 0.125 and 0.5: the same picture.
const VARIANCE: [f32; 2] = [4e-4, 0.25];

/// A density over directions to the environment: a mixture of von Mises-Fisher lobes of equal
/// weight and concentration, one for each photon.
#[derive(Clone, Debug)]
pub struct EnvironmentLobes {
    /// Unit axes; indices: component, lobe.
    axes: [[f32; MAX_ENVIRONMENT_LOBES]; 3],
    count: usize,
    kappa: f32,
    /// Density on the axis of a lobe over the number of lobes, in 1/sr.
    peak: f32,
}

impl EnvironmentLobes {
    /// Of photons by their unit directions to the environment, at most [`MAX_ENVIRONMENT_LOBES`];
    /// `None` for fewer than 4.
    pub fn new(directions: impl Iterator<Item = Vec3>) -> Option<Self> {
        let mut lobes = EnvironmentLobes {
            axes: [[0.0; MAX_ENVIRONMENT_LOBES]; 3],
            count: 0,
            kappa: 0.0,
            peak: 0.0,
        };
        let mut sum = Vec3::ZERO;
        for direction in directions.take(MAX_ENVIRONMENT_LOBES) {
            for (axes, x) in lobes.axes.iter_mut().zip(direction.to_array()) {
                axes[lobes.count] = x;
            }
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
        lobes.peak = von_mises_fisher_pdf(1.0, lobes.kappa) / n;
        Some(lobes)
    }

    /// Samples a unit direction with the density [`EnvironmentLobes::pdf`]; `u_lobe` and `u` are
    /// uniform in [0, 1).
    pub fn sample(&self, u_lobe: f32, u: Vec2) -> Vec3 {
        let lobe = ((u_lobe * self.count as f32) as usize).min(self.count - 1);
        Frame::from_normal(self.axes.map(|axes| axes[lobe]).into())
            .to_world(von_mises_fisher(u, self.kappa))
            .normalize()
    }

    /// Density of the unit direction `w` by solid angle, in 1/sr.
    pub fn pdf(&self, w: Vec3) -> f32 {
        Isa::best().run(LobesKernel { lobes: self, w })
    }

    /// As [`EnvironmentLobes::pdf`], with the lobes in the lanes of `s`, sixteen.
    #[inline(always)]
    pub(super) fn pdf_in_lanes<S: Width>(&self, s: S, w: Vec3) -> f32 {
        let w = Vector::splat(s, w);
        let mut sum = Float::splat(s, 0.0);
        for first in (0..self.count).step_by(LANES) {
            let [x, y, z] = &self.axes;
            let at = |i: usize| (first + i) % MAX_ENVIRONMENT_LOBES;
            let axes = Vector::new(
                Float::from_fn(s, |i| x[at(i)]),
                Float::from_fn(s, |i| y[at(i)]),
                Float::from_fn(s, |i| z[at(i)]),
            );
            let cos = axes.dot(w);
            let used = Mask::from_bits(s, !(u32::MAX << (self.count - first).min(LANES)));
            sum += used.select(((cos - 1.0) * self.kappa).exp(), 0.0);
        }
        self.peak * sum.store().as_ref().iter().sum::<f32>()
    }
}

struct LobesKernel<'a> {
    lobes: &'a EnvironmentLobes,
    w: Vec3,
}

impl SimdKernel for LobesKernel<'_> {
    type Output = f32;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> f32 {
        self.lobes.pdf_in_lanes(s.wide(), self.w)
    }
}
