//! Bounds of pairs of clusters, product cuts against sums over all pairs, and the sum of the
//! weights of all techniques of a path.

use super::gather_tree::GatherTree;
use super::pairs::{PairContext, Parts};
use super::tests::{PASS, UNLIMITED, lights, many_lights, many_materials, points, table};
use super::*;
use crate::color::Rgb;
use crate::ids::LightId;
use crate::light_tree::Receiver;
use crate::math::Vec3;
use crate::particles::{trace_photons, usable_by_virtual_lights};
use crate::sampling::rng::Pcg;
use crate::virtual_lights::{GlossyForm, SurfaceLocation};

fn gather(kernel: Kernel, clamp: Clamp) -> Gather {
    Gather {
        kernel,
        strategy: Strategy::Bidirectional(CutLimits::default()),
        clamp,
        refinement: 1.0,
        roulette: 0.0,
    }
}

/// A gather point of a pixel, with the throughput of the camera path up to it.
#[derive(Clone, Copy)]
struct WeightedPoint<'s> {
    at: ShadingPoint<'s>,
    throughput: Rgb,
}

fn weighted<'p, 's>(pixel: &'p [WeightedPoint<'s>]) -> Vec<(&'p ShadingPoint<'s>, Rgb)> {
    let points = pixel.iter();
    points.map(|point| (&point.at, point.throughput)).collect()
}

/// Groups of a few points with random throughputs, as the gather points of pixels: some near each
/// other, some anywhere.
fn pixels(scene: &Scene, seed: u64) -> Vec<Vec<WeightedPoint<'_>>> {
    let points = points(scene, false);
    let mut rng = Pcg::new(seed);
    let mut pixels = Vec::new();
    for first in (0..points.len() - 3).step_by(5) {
        let mut pixel = points[first..first + 3].to_vec();
        for _ in 0..(rng.next_f32() * 6.0) as usize {
            pixel.push(points[(rng.next_f32() * points.len() as f32) as usize]);
        }
        let weighted = pixel.into_iter().map(|at| WeightedPoint {
            at: ShadingPoint {
                lights: Subset::ALL,
                ..at
            },
            throughput: Rgb::new(rng.next_f32(), rng.next_f32(), 2.0 * rng.next_f32()),
        });
        pixels.push(weighted.collect());
    }
    pixels
}

/// The lights below a node.
fn below(context: &PairContext, node: usize) -> Vec<LightId> {
    match context.tree.children(node) {
        Some(children) => children.map(|child| below(context, child)).concat(),
        None => {
            let anywhere = Receiver::anywhere(Vec3::ZERO);
            let leaf = (context.tree).draw(&context.lights.set, node, &anywhere, &mut Pcg::new(0));
            vec![leaf.id]
        }
    }
}

#[test]
fn no_pair_of_clusters_sends_more_than_its_bound() {
    let scene = many_materials();
    let mut rng = Pcg::new(5);
    let (mut inner, mut lit) = (0, 0);
    for form in [None, table(16), Some(GlossyForm::Lobes { count: 3 })] {
        let lights = many_lights(&scene, form).with_tree_of_bounded_lights();
        let tree = lights.tree.as_ref().unwrap();
        for kernel in [Kernel::Point, Kernel::Disc] {
            let gather = gather(kernel, Clamp::None);
            for pixel in pixels(&scene, 7) {
                let gather_tree = GatherTree::new(&weighted(&pixel));
                let context = PairContext::new(&gather, &scene, &lights, &gather_tree);
                let receivers = (rng.next_f32() * gather_tree.nodes.len() as f32) as usize;
                // Nodes of all depths.
                let mut node = 0;
                while let Some(children) = tree.children(node) {
                    if rng.next_f32() < 0.15 {
                        break;
                    }
                    node = children[usize::from(rng.next_f32() < 0.5)];
                }
                let bound = context.bound(receivers, node).bound;
                let range = &gather_tree.nodes[receivers];
                let mut sum = 0.0;
                let mut cost = Gathered::default();
                for point in &gather_tree.points[range.first..range.end] {
                    for id in below(&context, node) {
                        let value = context.value(point, id, Parts::All, &mut cost);
                        sum += (point.throughput * value.radiance).luminance();
                    }
                }
                assert!(sum <= bound * 1.0001 + 1e-9, "{sum} beyond {bound}");
                inner += usize::from(gather_tree.children(receivers).is_some());
                lit += usize::from(sum > 0.0 && bound.is_finite());
            }
        }
    }
    assert!(inner > 100 && lit > 100, "{inner} and {lit}");
}

/// Sums over all pairs by [`Gather::sum`], which evaluates all lights at all points.
fn all_pairs(scene: &Scene, gather: &Gather, lights: &LightIndex, pixel: &[WeightedPoint]) -> Rgb {
    let brute_force = Gather {
        strategy: Strategy::All,
        ..*gather
    };
    let places: Vec<ShadingPoint> = pixel.iter().map(|point| point.at).collect();
    let sums = brute_force.sum(scene, lights, &places);
    let weighted = pixel.iter().zip(sums);
    weighted
        .map(|(point, sum)| point.throughput * sum.radiance)
        .sum()
}

/// The light of a pixel by a product cut.
fn cut(
    scene: &Scene,
    gather: &Gather,
    lights: &LightIndex,
    limits: CutLimits,
    pixel: &[WeightedPoint],
) -> (Rgb, Gathered) {
    let sums = gather.sum_of_pixel(
        scene,
        lights,
        (limits, 0.0),
        &weighted(pixel),
        &mut Vec::new(),
    );
    let weighted = pixel.iter().zip(&sums);
    let sum = weighted
        .map(|(point, sum)| point.throughput * sum.radiance)
        .sum();
    (sum, sums[0])
}

#[test]
fn a_cut_refined_to_its_leaves_is_the_sum_of_all_pairs() {
    let scene = many_materials();
    for form in [None, table(16)] {
        let lights = lights(&scene, form, UNLIMITED).with_tree_of_bounded_lights();
        for gather in [
            gather(Kernel::Point, Clamp::None),
            gather(Kernel::Disc, Clamp::Auto(1.0)),
        ] {
            let limits = CutLimits {
                max_error: 0.0,
                max_lights: u32::MAX,
            };
            let mut terms = 0;
            for pixel in pixels(&scene, 11) {
                let expected = all_pairs(&scene, &gather, &lights, &pixel);
                let (sum, first) = cut(&scene, &gather, &lights, limits, &pixel);
                for (a, b) in sum.to_array().into_iter().zip(expected.to_array()) {
                    assert!((a - b).abs() <= 2e-3 * b + 1e-5, "{a} and {b}");
                }
                assert_eq!(first.cluster_error, 0.0);
                terms += first.terms;
            }
            assert!(terms > 5000, "{terms}");
        }
    }
}

/// Coarse cuts with many choices of representatives have the mean of the sum over all pairs, within
/// five standard errors.
#[test]
fn coarse_cuts_are_right_in_the_mean() {
    let scene = many_materials();
    let lights = lights(&scene, table(16), UNLIMITED).with_tree_of_bounded_lights();
    let gather = gather(Kernel::Disc, Clamp::Auto(1.0));
    let limits = CutLimits {
        max_error: 0.0,
        max_lights: 12,
    };
    let trials = 3000;
    for mut pixel in pixels(&scene, 13).into_iter().step_by(12) {
        // The random number of the first point is the seed of the cut. It also decides how many
        // points represent a light, and must not do so at a point with throughput.
        let dark = WeightedPoint {
            throughput: Rgb::BLACK,
            ..pixel[0]
        };
        pixel.insert(0, dark);
        let expected = f64::from(all_pairs(&scene, &gather, &lights, &pixel).luminance());
        let (mut sum, mut squares) = (0.0, 0.0);
        for t in 0..trials {
            pixel[0].at.u = (t as f32 + 0.5) / trials as f32;
            let (light, first) = cut(&scene, &gather, &lights, limits, &pixel);
            assert!(first.terms <= 13);
            let light = f64::from(light.luminance());
            sum += light;
            squares += light * light;
        }
        let n = f64::from(trials);
        let mean = sum / n;
        let error = ((squares / n - mean * mean) / n).sqrt();
        assert!(
            (mean - expected).abs() < 5.0 * error + 1e-3 * expected,
            "{mean} and {expected}, standard error {error}"
        );
    }
}

/// A path `x_0 x_1 ... x_n` is found by connecting `x_t` with the light at `x_{t+1}`. The weight of
/// this technique is the clamping weight of the edge, times the clamped fractions of all edges
/// before. The last technique, next-event estimation at `x_n`, has no clamp.
#[test]
fn the_weights_of_all_techniques_sum_to_one() {
    let scene = many_materials();
    let lights = lights(&scene, None, UNLIMITED).with_tree_of_bounded_lights();
    let all = lights.set.lights();
    let guide = scene.infinite_light_guide();
    let photons = trace_photons(
        &scene,
        &guide,
        UNLIMITED,
        2000,
        PASS,
        usable_by_virtual_lights,
    );
    let starts = points(&scene, false);
    let mut rng = Pcg::new(17);
    let (mut paths, mut clamped_sum) = (0, 0.0);
    for clamp in [Clamp::Auto(8.0), Clamp::Auto(1000.0), Clamp::Value(2.0)] {
        let gather = gather(Kernel::Point, clamp);
        for start in &starts {
            let mut at = ShadingPoint {
                lights: Subset::ALL,
                lit_from: None,
                ..*start
            };
            let (mut weights, mut before, mut edges) = (0.0, 1.0, 0);
            for _ in 0..40 {
                let id = LightId((rng.next_f32() * all.len() as f32) as u32);
                let light = &all[id.index()];
                let gather_tree = GatherTree::new(&[(&at, Rgb::WHITE)]);
                let context = PairContext::new(&gather, &scene, &lights, &gather_tree);
                let mut cost = Gathered::default();
                let value = context.value(&gather_tree.points[0], id, Parts::All, &mut cost);
                if value.unclamped <= 1e-9 {
                    continue;
                }
                weights += before * (1.0 - value.clamped / value.unclamped);
                let photon = photons.iter().find(|photon| photon.p == light.p).unwrap();
                let y = SurfaceLocation::of_photon(photon, &scene);
                let f_cos = |w| at.bsdf.f_cos_wi(w, at.wo, crate::bsdf::Lobes::NON_SPECULAR);
                let assignment = Assignment::Light(id);
                before *= gather.clamped_fraction(&lights, &(&at).into(), &y, assignment, f_cos);
                edges += 1;
                let x = scene.surface_point(photon.at);
                at = ShadingPoint {
                    x,
                    wo: (at.x.p - x.p).normalize(),
                    bsdf: scene.bsdf(&x),
                    ..at
                };
            }
            let sum = weights + before;
            assert!((sum - 1.0f32).abs() < 1e-4, "{sum} after {edges} edges");
            paths += usize::from(edges > 1);
            clamped_sum += before;
        }
    }
    assert!(
        paths > 500 && clamped_sum > 0.1,
        "{paths} and {clamped_sum}"
    );
}
