//! Evaluation in lanes against evaluation of single functions.

use super::bounds::bound_within;
use super::*;
use crate::bsdf::{FixedWi, FixedWo, FixedWoLanes, LaneModel};
use crate::lanes::{LANES, LaneMask, Lanes, Lanes3, Mask};
use crate::math::Spread;
use crate::simd::{Instructions, Isa, Simd, SimdKernel};

/// [`FixedWoLanes::f_cos_wi`] in lanes.
struct InLanes<'a>(&'a FixedWoLanes<'a, 'a>, &'a Lanes3);

impl SimdKernel for InLanes<'_> {
    type Output = Lanes3;

    #[inline(always)]
    fn run<I: Simd>(self, isa: I) -> Lanes3 {
        let s = isa.wide();
        let values = self.0.f_cos_wi(self.1.vectors(s), Mask::splat(s, true));
        Lanes3::of_colors(values)
    }
}

fn assert_same(a: Rgb, b: Rgb, what: &str) {
    for (a, b) in a.to_array().into_iter().zip(b.to_array()) {
        assert_close(a, b, 1e-4, what);
    }
}

#[test]
fn each_direction_has_its_single_value() {
    for case in cases() {
        for ng in normals() {
            let bsdf = case.bsdf(ng);
            let mut sampler = sampler(8);
            for count in [0, 1, LANES, LANES + 3] {
                let wi: Vec<Vec3> = (0..count).map(|_| direction(&mut sampler)).collect();
                let wo = direction(&mut sampler);
                for lobes in [Lobes::NON_SPECULAR, Lobes::DIFFUSE, Lobes::ALL] {
                    let mut values = vec![Rgb::WHITE];
                    FixedWoLanes::f_cos_each_wi(&bsdf, &wi, wo, lobes, &mut values);
                    assert_eq!(values.len(), count);
                    for (&wi, value) in wi.iter().zip(values) {
                        let single = bsdf.f_cos_wi(wi, wo, lobes.and(Lobes::NON_SPECULAR));
                        assert_same(value, single, case.name);
                    }
                }
            }
        }
    }
}

#[test]
fn lanes_have_the_values_of_single_functions() {
    for case in cases() {
        for ng in normals() {
            let bsdf = case.bsdf(ng);
            let mut sampler = sampler(7);
            for count in [1, 5, LANES] {
                let directions: Vec<Vec3> = (0..count).map(|_| direction(&mut sampler)).collect();
                let mut incident = Lanes3::ZERO;
                (0..LANES).for_each(|i| incident.set(i, direction(&mut sampler)));
                for model in [LaneModel::of(&bsdf), LaneModel::Any] {
                    let lanes = FixedWoLanes::new(
                        model,
                        Lobes::NON_SPECULAR,
                        directions.iter().map(|&wo| (&bsdf, wo)),
                    );
                    for isa in Instructions::available().into_iter().filter_map(Isa::new) {
                        let values = isa.run(InLanes(&lanes, &incident));
                        for (i, &wo) in directions.iter().enumerate() {
                            let single = FixedWo::new(&bsdf, wo, Lobes::NON_SPECULAR);
                            let single = single.f_cos_wi(incident.vec(i));
                            assert_same(values.rgb(i), single, case.name);
                        }
                        for i in count..LANES {
                            assert!(values.rgb(i).is_black(), "{}", case.name);
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn flat_and_tilted_functions_share_lanes() {
    let all = cases();
    let of = |name: &str| {
        let case = all.iter().find(|case| case.name == name);
        case.expect("a case of this name").bsdf(Vec3::Z)
    };
    let mut sampler = sampler(9);
    for [flat, tilted] in [
        ["diffuse", "normal_map"],
        ["rough_conductor_ggx", "normal_map_anisotropic"],
    ] {
        for names in [[flat, tilted], [tilted, flat]] {
            let both = names.map(of);
            let model = LaneModel::of(&both[0]);
            assert!(model == LaneModel::of(&both[1]) && model != LaneModel::Any);
            let directions: [Vec3; LANES] = std::array::from_fn(|_| direction(&mut sampler));
            let functions = directions
                .iter()
                .enumerate()
                .map(|(i, &wo)| (&both[i % 2], wo));
            for lobes in [Lobes::NON_SPECULAR, Lobes::DIFFUSE, Lobes::GLOSSY] {
                let lanes = FixedWoLanes::new(model, lobes, functions.clone());
                for _ in 0..8 {
                    let mut incident = Lanes3::ZERO;
                    (0..LANES).for_each(|i| incident.set(i, direction(&mut sampler)));
                    let values = Isa::best().run(InLanes(&lanes, &incident));
                    for (i, (bsdf, wo)) in functions.clone().enumerate() {
                        let single = FixedWo::new(bsdf, wo, lobes).f_cos_wi(incident.vec(i));
                        assert_same(values.rgb(i), single, names[i % 2]);
                    }
                }
            }
        }
    }
}

/// [`FixedWi::f_cos_wo_each`] in lanes.
struct OutgoingInLanes<'a>(&'a Bsdf<'a>, Vec3, Lobes, &'a Lanes3);

impl SimdKernel for OutgoingInLanes<'_> {
    type Output = Lanes3;

    #[inline(always)]
    fn run<I: Simd>(self, isa: I) -> Lanes3 {
        let s = isa.wide();
        let OutgoingInLanes(bsdf, wi, lobes, outgoing) = self;
        let function = FixedWi::new(s, bsdf, wi, lobes);
        let values = function.f_cos_wo_each(outgoing.vectors(s), Mask::splat(s, true));
        Lanes3::of_colors(values)
    }
}

#[test]
fn fixed_incident_directions_have_the_values_of_single_ones() {
    for case in cases() {
        for ng in normals() {
            let bsdf = case.bsdf(ng);
            let mut sampler = sampler(10);
            for lobes in [Lobes::NON_SPECULAR, Lobes::GLOSSY] {
                for _ in 0..8 {
                    let wi = direction(&mut sampler);
                    let mut outgoing = Lanes3::ZERO;
                    (0..LANES).for_each(|i| outgoing.set(i, direction(&mut sampler)));
                    let values = Isa::best().run(OutgoingInLanes(&bsdf, wi, lobes, &outgoing));
                    for i in 0..LANES {
                        let single = bsdf.f_cos_wo(wi, outgoing.vec(i), lobes);
                        assert_same(values.rgb(i), single, case.name);
                    }
                }
            }
        }
    }
}

/// [`FixedWoLanes::bounds`] in lanes.
struct BoundsInLanes<'a>(&'a FixedWoLanes<'a, 'a>, &'a Lanes3, &'a [Spread; LANES]);

impl SimdKernel for BoundsInLanes<'_> {
    type Output = Lanes;

    #[inline(always)]
    fn run<I: Simd>(self, isa: I) -> Lanes {
        (self.0).bounds(isa.wide(), self.1, self.2, LaneMask::MAX)
    }
}

#[test]
fn bounds_in_lanes_are_those_of_single_functions() {
    for case in cases() {
        let bsdf = case.bsdf(Vec3::Z);
        let mut sampler = sampler(33);
        for _ in 0..20 {
            let directions: [Vec3; LANES] = std::array::from_fn(|_| direction(&mut sampler));
            let cones: [(Cone, Vec3); LANES] =
                std::array::from_fn(|_| cone_with_direction(&mut sampler));
            let lobes = Lobes::NON_SPECULAR;
            let lanes = FixedWoLanes::new(
                LaneModel::of(&bsdf),
                lobes,
                directions.iter().map(|&wo| (&bsdf, wo)),
            );
            let axes = Lanes3::from_fn(|i| cones[i].0.axis);
            let spreads = cones.map(|(cone, _)| Spread::new(cone.half_angle));
            let bounds = Isa::best().run(BoundsInLanes(&lanes, &axes, &spreads));
            for (i, &wo) in directions.iter().enumerate() {
                let single = bound_within(&bsdf, &cones[i].0, wo, lobes);
                if single.is_finite() {
                    assert_close(bounds[i], single, 1e-3, case.name);
                }
            }
        }
    }
}
