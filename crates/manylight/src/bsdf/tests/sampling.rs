//! Samplers against densities, values and energy.

use super::cases::unequal_lobes;
use super::*;
use crate::bsdf::leaf::Given;
use crate::bsdf::sampling::MAX_DEFENSIVE_PROBABILITY;
use crate::testing::chi_square::{self, Resolution};
use rayon::prelude::*;

#[test]
fn samplers_follow_their_densities() {
    // About 800 tests with fixed seeds: one in ten thousand runs of a right program with other
    // seeds would fail.
    let significance = 1e-7;
    let unequal = unequal_lobes();
    let all: Vec<&Case> = cases().iter().chain(&unequal).collect();
    let failures: Vec<String> = all
        .par_iter()
        .flat_map_iter(|case| {
            let mut failures = Vec::new();
            for (n, ng) in normals().into_iter().enumerate() {
                let bsdf = case.bsdf(ng);
                for (m, mask) in masks(&bsdf).into_iter().enumerate() {
                    for end in [Given::Wo, Given::Wi] {
                        // The geometric normal makes no difference to camera walks.
                        if n == 1 && end == Given::Wo {
                            continue;
                        }
                        let given =
                            Vec3::new(0.5, 0.3, if m % 2 == 0 { 0.7 } else { -0.2 }).normalize();
                        for given in [given, Vec3::new(given.x, -given.y, -given.z)] {
                            let outcome = test_sampler(&bsdf, end, given, mask);
                            if outcome.p_value < significance {
                                failures.push(format!(
                                    "{} {ng} {mask:?} {end:?} {given}: {outcome:?}",
                                    case.name
                                ));
                            }
                        }
                    }
                }
            }
            failures
        })
        .collect();
    assert!(failures.is_empty(), "{failures:#?}");
}

fn test_sampler(bsdf: &Bsdf, end: Given, given: Vec3, mask: Lobes) -> chi_square::ChiSquareResult {
    let draw = |i: u32| {
        let u = numbers(&mut sampler(u64::from(i)));
        let given = given.into();
        let local = bsdf.frame.to_local(given);
        let drawn = match end {
            Given::Wo => bsdf.draw_wi(local, u.into(), mask.into()),
            Given::Wi => bsdf.draw_wo(given, local, u.into(), mask.into()),
        };
        (drawn.valid & !drawn.is_delta)
            .any()
            .then(|| drawn.w.into())
    };
    let pdf = |w: Vec3| match end {
        Given::Wo => bsdf.pdf_wi(w, given, mask),
        Given::Wi => bsdf.pdf_wo(given, w, mask),
    };
    let resolution = Resolution {
        samples: 10_000,
        points: 6,
        ..Resolution::default()
    };
    chi_square::test_directions(Vec3::Z, resolution, draw, pdf)
}

#[test]
fn weights_are_values_over_densities() {
    for case in cases() {
        for ng in normals() {
            let bsdf = case.bsdf(ng);
            for mask in [Lobes::DIFFUSE, Lobes::GLOSSY, Lobes::NEAR_DELTA] {
                let mut sampler = sampler(11);
                for _ in 0..200 {
                    let (given, u) = (direction(&mut sampler), numbers(&mut sampler));
                    if let Some(s) = bsdf.sample_wi(given, u, mask) {
                        assert_eq!(s.lobe, mask, "{}", case.name);
                        assert_close(s.pdf, bsdf.pdf_wi(s.w, given, mask), 1e-4, case.name);
                        let expected = bsdf.f_cos_wi(s.w, given, mask) / s.pdf;
                        assert_close(s.weight.g, expected.g, 1e-4, case.name);
                    }
                    if let Some(s) = bsdf.sample_wo(given, u, mask) {
                        assert_eq!(s.lobe, mask, "{}", case.name);
                        assert_close(s.pdf, bsdf.pdf_wo(given, s.w, mask), 1e-4, case.name);
                        let expected = bsdf.f_cos_wo(given, s.w, mask) / s.pdf;
                        assert_close(s.weight.g, expected.g, 1e-4, case.name);
                    }
                }
            }
        }
    }
}

#[test]
fn events_of_a_class_carry_that_class() {
    // Samples of all classes at once give the flux of each class.
    cases().par_iter().for_each(|case| {
        let bsdf = case.bsdf(Vec3::Z);
        let given = Vec3::new(0.5, 0.3, 0.5).normalize();
        let count = 5000;
        let mut moments = [(0.0f64, 0.0f64); 4];
        for i in 0..count {
            if let Some(s) = bsdf.sample_wo(given, numbers(&mut sampler(i)), Lobes::ALL) {
                let (sum, squares) = &mut moments[s.lobe.0.trailing_zeros() as usize];
                *sum += f64::from(s.weight.g) / count as f64;
                *squares += f64::from(s.weight.g).powi(2) / count as f64;
            }
        }
        for (bit, (mean, square)) in moments.into_iter().enumerate() {
            let class = Lobes(1 << bit);
            let finite = quadrature(&bsdf, given, class);
            let expected = f64::from(if class == Lobes::DELTA {
                bsdf.albedo(given, class).g
            } else {
                finite.g
            });
            let deviation = ((square - mean * mean).max(0.0) / count as f64).sqrt();
            // Five standard deviations, the error of the quadrature, and that of sums.
            let tolerance = 5.0 * deviation + 0.01 * expected + 1e-5;
            assert!(
                (mean - expected).abs() <= tolerance,
                "{} class {bit}: {mean} vs {expected}",
                case.name
            );
        }
    });
}

#[test]
fn albedo_is_the_integral_and_energy_is_conserved() {
    // These models reflect more than the incident flux; so do tilted normals.
    let exceptions = ["ward_duer", "principled_full", "ward"];
    let may_gain = |name: &str| exceptions.contains(&name) || name.contains("_map");
    cases().par_iter().for_each(|case| {
        let bsdf = case.bsdf(Vec3::Z);
        for wi in [
            Vec3::new(0.2, 0.1, 0.9),
            Vec3::new(0.5, -0.6, 0.4),
            Vec3::new(0.1, 0.7, -0.6),
        ] {
            let wi = wi.normalize();
            let (albedo, integral) = (
                bsdf.albedo(wi, Lobes::FINITE),
                quadrature(&bsdf, wi, Lobes::FINITE),
            );
            for (a, b) in albedo.to_array().into_iter().zip(integral.to_array()) {
                assert!((a - b).abs() < 0.012, "{} from {wi}: {a} vs {b}", case.name);
            }
            let total = bsdf.albedo(wi, Lobes::ALL) + bsdf.transmittance(wi);
            assert!(
                total.max_channel() < 1.005 || may_gain(case.name),
                "{} from {wi}: {total:?}",
                case.name
            );
        }
    });
}

#[test]
fn lobes_are_chosen_by_the_light_that_they_return() {
    let given = Vec3::new(0.5, 0.3, 0.7).normalize();
    for case in unequal_lobes() {
        let bsdf = case.bsdf(Vec3::Z);
        for end in [Given::Wo, Given::Wi] {
            let (mut sum, mut squares) = (0.0, 0.0);
            let count = 4000;
            for i in 0..count {
                let u = numbers(&mut sampler(i));
                let sample = match end {
                    Given::Wo => bsdf.sample_wi(given, u, Lobes::ALL),
                    Given::Wi => bsdf.sample_wo(given, u, Lobes::ALL),
                };
                let Some(sample) = sample else { continue };
                // Without the squared index that refraction puts into radiance.
                let radiance = if end == Given::Wo {
                    sample.eta * sample.eta
                } else {
                    1.0
                };
                let weight = f64::from(sample.weight.max_channel() * radiance);
                sum += weight / count as f64;
                squares += weight * weight / count as f64;
            }
            let spread = squares / (sum * sum);
            assert!(
                sum > 0.0 && spread < 1.25,
                "{} {end:?}: {spread}",
                case.name
            );
        }
    }
}

#[test]
fn photon_weights_stay_bounded_under_tilted_normals() {
    let bsdf = cases()[0].bsdf(normals()[1]);
    let mut sampler = sampler(15);
    for _ in 0..20_000 {
        let wi = warp::cosine_hemisphere(sampler.next_2d());
        let tilt = wi.z / wi.dot(normals()[1]).abs();
        if let Some(s) = bsdf.sample_wo(wi, numbers(&mut sampler), Lobes::ALL) {
            assert!(
                s.weight.g <= 0.5 * tilt / MAX_DEFENSIVE_PROBABILITY * 1.001,
                "{} from {wi}",
                s.weight.g
            );
        }
    }
}

#[test]
fn delta_weights_are_adjoint_under_tilted_normals() {
    // The weights of a camera walk and a photon walk differ by the quotient of the cosines.
    let ng = normals()[1];
    let case = cases()
        .iter()
        .find(|case| case.name == "conductor")
        .unwrap();
    let bsdf = case.bsdf(ng);
    let u = BsdfNumbers {
        lobe: 0.5,
        direction: Vec2::splat(0.5),
    };
    let wo = Vec3::new(0.4, 0.5, 0.6).normalize();
    let seen = bsdf.sample_wi(wo, u, Lobes::ALL).unwrap();
    let sent = bsdf.sample_wo(seen.w, u, Lobes::ALL).unwrap();
    assert!((sent.w - wo).length() < 1e-6);
    let cosines = (seen.w.z * wo.dot(ng) / (seen.w.dot(ng) * wo.z)).abs();
    assert_close(sent.weight.g, seen.weight.g * cosines, 1e-5, "conductor");
}

#[test]
fn lambertian_albedo_includes_the_tilt() {
    let bsdf = cases()[0].bsdf(normals()[1]);
    for wi in [Vec3::new(0.2, 0.1, 0.9), Vec3::new(-0.5, 0.6, 0.4)] {
        let wi = wi.normalize();
        let integral = quadrature(&bsdf, wi, Lobes::ALL);
        assert_close(bsdf.albedo(wi, Lobes::ALL).g, integral.g, 1e-3, "diffuse");
    }
}
