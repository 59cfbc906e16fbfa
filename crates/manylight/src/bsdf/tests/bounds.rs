//! Upper bounds over cones against values.

use super::*;
use crate::bsdf::FixedWo;
use crate::math::Spread;
use rayon::prelude::*;

/// Upper bound of all channels of [`Bsdf::f_cos_wi`] over the directions `wi` in `cone`.
pub(super) fn bound_within(bsdf: &Bsdf, cone: &Cone, wo: Vec3, lobes: Lobes) -> f32 {
    FixedWo::new(bsdf, wo, lobes).bound(cone.axis, Spread::new(cone.half_angle))
}

/// Checks bounds for random cones and directions, with each normal. Returns the geometric mean of
/// bound over value where the value is positive.
fn hold_bounds(case: &Case, count: u64) -> f64 {
    let (mut looseness, mut lit) = (0.0, 0u64);
    for ng in normals() {
        let bsdf = case.bsdf(ng);
        let mut sampler = sampler(31);
        for i in 0..count {
            let wo = direction(&mut sampler);
            let (cone, wi) = cone_with_direction(&mut sampler);
            let lobes = [Lobes::NON_SPECULAR, Lobes::ALL][(i % 2) as usize];
            let bound = bound_within(&bsdf, &cone, wo, lobes);
            let value = bsdf.f_cos_wi(wi, wo, lobes).max_channel();
            assert!(
                value <= bound * 1.0001 + 1e-6,
                "{}: {value} > {bound} for wi {wi}, wo {wo}, {lobes:?}, {cone:?}",
                case.name
            );
            let (cone, wo) = cone_with_direction(&mut sampler);
            let leaving = bsdf.bound_f_cos_wo(wi, &cone);
            let value_leaving = bsdf.f_cos_wo(wi, wo, Lobes::NON_SPECULAR).max_channel();
            assert!(
                value_leaving <= leaving * 1.0001 + 1e-6,
                "{}: {value_leaving} > {leaving} leaves for wi {wi}, wo {wo}, {cone:?}",
                case.name
            );
            if value > 1e-6 && bound.is_finite() {
                looseness += f64::from(bound / value).ln();
                lit += 1;
            }
        }
    }
    (looseness / lit.max(1) as f64).exp()
}

#[test]
fn bounds_hold_over_cones() {
    let looseness = cases().par_iter().map(|case| {
        let looseness = hold_bounds(case, 20_000);
        (case.name, looseness, case.bsdf(Vec3::Z).transmits())
    });
    let mut looseness: Vec<(&str, f64, bool)> = looseness.collect();
    looseness.sort_by(|a, b| b.1.total_cmp(&a.1));
    for (name, looseness, transmits) in looseness {
        println!("{name}: the bound is {looseness:.1} times the value");
        // Bounds on refraction contain only the maximum of the lobe.
        assert!(transmits || looseness < 200.0, "{name}: {looseness}");
    }
}

#[test]
fn bounds_of_single_directions_are_tight() {
    for case in cases() {
        let bsdf = case.bsdf(Vec3::Z);
        let mut sampler = sampler(32);
        for _ in 0..200 {
            let (wi, wo) = (direction(&mut sampler), direction(&mut sampler));
            let value = bsdf.f_cos_wi(wi, wo, Lobes::DIFFUSE).max_channel();
            let bound = bound_within(&bsdf, &Cone::from_axis(wi), wo, Lobes::DIFFUSE);
            // The transmittance of a rough coat is bounded by the largest of all angles.
            let flat = value > 0.01 && !case.name.contains("_map");
            assert!(
                !flat || bound < 2.0 * value,
                "{}: {bound} for {value}",
                case.name
            );
        }
    }
}
