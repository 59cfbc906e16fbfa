//! Albedo of a scattering function.

use super::{Bsdf, BsdfNumbers, ExitTransmittance, LARGEST, Lobes};
use crate::color::Rgb;
use crate::math::{Vec2, Vec3};

/// Steps of a three-dimensional additive recurrence, by powers of a generalized golden ratio.
/// Source: Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018.
const STEPS: [f64; 3] = [
    0.819_172_513_396_164_4,
    0.671_043_606_703_789_2,
    0.549_700_477_901_971,
];

/// Points of the quadrature, for an error of about one percent.
const SAMPLE_COUNT: u32 = 1024;

impl Bsdf<'_> {
    /// Fraction of flux from `wi` that `lobes` scatter (delta lobes included, straight-through transmission not). In closed form for
    /// Lambert's model, else by deterministic quadrature over [`Bsdf::sample_wo`] with an error of about one percent.
    pub fn albedo(&self, wi: Vec3, lobes: Lobes) -> Rgb {
        if self.lobes().and(lobes) == Lobes::DIFFUSE
            && matches!(self.exit_transmittance(), ExitTransmittance::Lambert)
        {
            // |wo·ng| / π integrates to 1 over any hemisphere, also over that around ns.
            return self.diffuse_weight(wi);
        }
        let sum: Rgb = (0..SAMPLE_COUNT)
            .filter_map(|i| {
                let [a, b, c] = STEPS.map(|step| ((0.5 + step * f64::from(i + 1)) % 1.0) as f32);
                let u = BsdfNumbers {
                    lobe: a.min(LARGEST),
                    direction: Vec2::new(b.min(LARGEST), c.min(LARGEST)),
                };
                self.sample_wo(wi, u, lobes)
            })
            .map(|sample| sample.weight)
            .sum();
        sum / SAMPLE_COUNT as f32
    }
}
