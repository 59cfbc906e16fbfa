//! The emitter tree: probabilities against frequencies, completeness, variance.

use super::*;
use crate::emitters::elements::ElementBounds;
use crate::lanes::{Float, Mask, One, Word};
use crate::math::{Aabb, Cone};
use crate::sampling::warp;

/// An element and its probability.
fn sample(tree: &EmitterTree, p: Vec3, n: Option<Vec3>, u: f32) -> Option<(usize, f32)> {
    let (receiver, all) = (Receivers::from((p, n)), Mask::splat(One, true));
    let chosen = EmitterTree::sample(tree, &receiver, Float::from(u), all);
    let element = chosen.element.store()[0] as usize;
    chosen.found.any().then(|| (element, chosen.pmf.get()))
}

fn pmf(tree: &EmitterTree, p: Vec3, n: Option<Vec3>, element: usize) -> f32 {
    let (receiver, all) = (Receivers::from((p, n)), Mask::splat(One, true));
    let element = Word::splat(One, element as u32);
    tree.pmf(&receiver, element, all).get()
}

/// Small facets scattered over a plate, some facing up, some down, and a few points.
fn facets(count: usize) -> Vec<ElementBounds> {
    let mut sampler = Sampler::new(7, 0, Stream::Test, 0);
    (0..count)
        .map(|i| {
            let at = sampler.next_2d() * 20.0 - Vec2::splat(10.0);
            let p = at.extend(sampler.next_1d());
            let normals = match i % 7 {
                0 => Cone::FULL,
                1 => Cone {
                    axis: -Vec3::Z,
                    half_angle: 0.4,
                },
                _ => Cone::from_axis((Vec3::Z + warp::sphere(sampler.next_2d()) * 0.5).normalize()),
            };
            ElementBounds {
                bounds: Aabb {
                    min: p - Vec3::splat(0.02),
                    max: p + Vec3::splat(0.02),
                },
                normals,
                emission: if i % 7 == 0 { 0.0 } else { PI * 0.5 },
                power: Rgb::splat(0.1 + sampler.next_1d()),
            }
        })
        .collect()
}

/// Irradiance from the center of a facet at `p`, up to a factor.
fn arriving(element: &ElementBounds, p: Vec3, n: Vec3) -> f32 {
    let d = p - element.bounds.center();
    let cos = (element.normals.angle_to_axis(d.normalize()) - element.normals.half_angle)
        .max(0.0)
        .cos()
        .max(0.0);
    element.power.r * cos * (-n.dot(d.normalize())).max(0.0) / d.length_squared()
}

#[test]
fn tree_probabilities_match_frequencies() {
    for count in [1, 2, 3, 5, 40] {
        let elements = facets(count);
        let tree = EmitterTree::new(&elements);
        for (p, n) in [
            (Vec3::new(1.0, 2.0, 3.0), Some(-Vec3::Z)),
            (Vec3::new(0.0, 0.0, 0.5), None),
        ] {
            let n_samples = 40_000;
            let mut counts = vec![0.0f32; count];
            for i in 0..n_samples {
                let Some((element, found)) =
                    sample(&tree, p, n, (i as f32 + 0.5) / n_samples as f32)
                else {
                    continue;
                };
                assert!((found / pmf(&tree, p, n, element) - 1.0).abs() < 1e-4);
                counts[element] += 1.0 / n_samples as f32;
            }
            let pmfs: Vec<f32> = (0..count).map(|i| pmf(&tree, p, n, i)).collect();
            // Below 1 where the bounds of a node allow light from its elements, and no element
            // sends any.
            assert!(
                pmfs.iter().sum::<f32>() < 1.001,
                "{count} elements: {pmfs:?}"
            );
            for (frequency, pmf) in counts.iter().zip(&pmfs) {
                assert!((frequency - pmf).abs() < 1e-3, "{frequency} for {pmf}");
            }
        }
    }
}

#[test]
fn elements_that_send_light_have_a_probability() {
    let elements = facets(300);
    let tree = EmitterTree::new(&elements);
    let mut sampler = Sampler::new(8, 0, Stream::Test, 0);
    for _ in 0..200 {
        let p = Vec3::new(
            sampler.next_1d() * 24.0 - 12.0,
            sampler.next_1d() * 24.0 - 12.0,
            sampler.next_1d() * 6.0 - 3.0,
        );
        let n = warp::sphere(sampler.next_2d());
        for (i, element) in elements.iter().enumerate() {
            if arriving(element, p, n) > 0.0 || arriving(element, p, -n) > 0.0 {
                assert!(
                    pmf(&tree, p, Some(n), i) > 0.0 && pmf(&tree, p, None, i) > 0.0,
                    "element {i} from {p}"
                );
            }
        }
    }
}

#[test]
fn the_tree_beats_choice_by_power() {
    let elements = facets(10_000);
    let tree = EmitterTree::new(&elements);
    let total: f64 = elements.iter().map(|p| f64::from(p.power.r)).sum();
    let mut ratio = 0.0;
    let receivers = [
        Vec3::new(1.0, 2.0, 1.5),
        Vec3::new(-7.0, 3.0, 4.0),
        Vec3::new(0.0, 9.0, 1.2),
    ];
    for p in receivers {
        let n = -Vec3::Z;
        // Exact second moments of value over probability.
        let (mut by_tree, mut by_power) = (0.0f64, 0.0f64);
        let mut sum = 0.0f64;
        for (i, element) in elements.iter().enumerate() {
            let value = f64::from(arriving(element, p, n));
            if value > 0.0 {
                sum += value;
                by_tree += value * value / f64::from(pmf(&tree, p, Some(n), i));
                by_power += value * value / (f64::from(element.power.r) / total);
            }
        }
        ratio += (by_power - sum * sum) / (by_tree - sum * sum) / receivers.len() as f64;
    }
    assert!(ratio > 10.0, "variance reduced by {ratio}");
}

#[test]
fn small_trees_are_at_least_as_good_as_choice_by_power() {
    for count in 2..=4 {
        let elements = facets(count);
        let tree = EmitterTree::new(&elements);
        let total: f64 = elements.iter().map(|p| f64::from(p.power.r)).sum();
        let (mut by_tree, mut by_power) = (0.0f64, 0.0f64);
        let mut sampler = Sampler::new(9, 0, Stream::Test, 0);
        for _ in 0..200 {
            let p = Vec3::new(
                sampler.next_1d() * 20.0 - 10.0,
                sampler.next_1d() * 20.0 - 10.0,
                2.0 + sampler.next_1d(),
            );
            let n = -Vec3::Z;
            let values: Vec<f64> = elements
                .iter()
                .map(|element| f64::from(arriving(element, p, n)))
                .collect();
            let sum2 = values.iter().sum::<f64>().powi(2);
            if sum2 == 0.0 {
                continue;
            }
            for (i, (value, element)) in values
                .iter()
                .zip(&elements)
                .enumerate()
                .filter(|(_, (v, _))| **v > 0.0)
            {
                by_tree += value * value / sum2 / f64::from(pmf(&tree, p, Some(n), i));
                by_power += value * value / sum2 / (f64::from(element.power.r) / total);
            }
        }
        assert!(
            by_tree <= by_power,
            "{count} elements: {by_tree} for {by_power}"
        );
    }
}
