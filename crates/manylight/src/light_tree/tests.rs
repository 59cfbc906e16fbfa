//! Nodes bound their lights, all lights are leaves, and draws have the probabilities reported.

use super::*;
use crate::bsdf::{FixedWoLanes, LaneModel, Lobes};
use crate::lanes::Lanes3;
use crate::math::{Vec2, Vec3};
use crate::particles::{Photon, trace_photons, usable_by_virtual_lights};
use crate::sampling::rng::Pcg;
use crate::sampling::{Pass, warp};
use crate::scene::{PathLimits, Scene};
use crate::simd::{Isa, Simd, SimdKernel};
use crate::testing::scenes::glossy_box;
use crate::virtual_lights::moments::POINTS;
use crate::virtual_lights::testing::{candidates, rich_lights, single_lights};
use crate::virtual_lights::{
    GlossyForm, PhotonClusters, TableStorage, VirtualLights, assign, select,
};
use std::iter::once;

const TABLES: GlossyForm = GlossyForm::Table {
    side: 32,
    storage: TableStorage::Shared,
};

/// The bound of [`LightNode::reflected_bounds`] in the first lane.
struct BoundAtOne<'a>(&'a LightNode, &'a Lanes3, &'a FixedWoLanes<'a, 'a>);

impl SimdKernel for BoundAtOne<'_> {
    type Output = f32;

    #[inline(always)]
    fn run<I: Simd>(self, isa: I) -> f32 {
        let BoundAtOne(node, places, receivers) = self;
        let bounds = node.reflected_bounds(isa.wide(), places, receivers, 1);
        bounds.most[0]
    }
}

/// Some photons of a glossy room, and lights made of them.
fn lit(scene: &Scene, count: usize, form: Option<GlossyForm>) -> (Vec<Photon>, VirtualLights<'_>) {
    let limits = PathLimits::default();
    let pass = Pass { seed: 3, index: 1 };
    let photons = trace_photons(
        scene,
        &scene.infinite_light_guide(),
        limits,
        4000,
        pass,
        usable_by_virtual_lights,
    );
    let fluxes: Vec<f32> = photons.iter().map(|p| p.flux.luminance()).collect();
    let sites = select(&photons, &fluxes, count, 0.4);
    let set = match form {
        None => single_lights(
            scene,
            limits,
            &photons,
            &PhotonClusters::single_photons(&sites),
        ),
        Some(form) => {
            let (clusters, _) = assign(scene, &candidates(&photons, &fluxes), &sites, 0.7);
            rich_lights(scene, limits, &photons, &clusters, form)
        }
    };
    (photons, set)
}

/// The lights below a node.
fn below(tree: &LightTree, node: usize) -> Vec<LightId> {
    match tree.nodes[node].content {
        NodeContent::Light(id) => vec![id],
        NodeContent::Nodes { second } => [node + 1, second as usize]
            .into_iter()
            .flat_map(|child| below(tree, child))
            .collect(),
    }
}

#[test]
fn every_light_is_a_leaf() {
    let scene = glossy_box(8).build();
    let (_, set) = lit(&scene, 1500, Some(TABLES));
    let is_used = |id: LightId| !id.0.is_multiple_of(3);
    let tree = LightTree::new(&set, is_used);
    let lights = set.lights();
    let mut leaves = below(&tree, 0);
    leaves.sort();
    let expected: Vec<LightId> = (0..lights.len() as u32)
        .map(LightId)
        .filter(|&id| is_used(id) && lights[id.index()].flux.luminance() > 0.0)
        .collect();
    assert_eq!(leaves, expected);
    for (k, node) in tree.nodes().iter().enumerate() {
        let own = below(&tree, k);
        let flux: f32 = own
            .iter()
            .map(|id| lights[id.index()].flux.luminance())
            .sum();
        assert!((flux / node.flux - 1.0).abs() < 1e-4);
        for p in own.iter().flat_map(|id| lights[id.index()].points) {
            assert_eq!(node.bounds.distance_squared(p), 0.0);
        }
    }
    // A binary tree of n leaves has 2n - 1 nodes.
    assert_eq!(tree.nodes().len(), 2 * expected.len() - 1);
    assert!(LightTree::new(&set, |_| false).roots().is_empty());
}

/// Draws from the root, and draws converted to a child of the root, have the frequencies reported,
/// for all forms of emission.
#[test]
fn lights_are_drawn_with_the_probability_reported() {
    let scene = glossy_box(8).build();
    let p = Vec3::new(0.3, -0.7, 0.2);
    let trials = 40_000;
    for form in [None, Some(TABLES), Some(GlossyForm::Lobes { count: 3 })] {
        let (_, set) = lit(&scene, 24, form);
        let tree = LightTree::new(&set, |_| true);
        let mut rng = Pcg::new(7);
        let count = set.lights().len();
        let mut drawn = vec![0u32; count];
        let mut reported = vec![0.0; count];
        let mut reported_below = [vec![0.0; count], vec![0.0; count]];
        for _ in 0..trials {
            let one = tree.draw(&set, 0, &Receiver::anywhere(p), &mut rng);
            let (k, own) =
                tree.inherit(&set, tree.children(0).unwrap(), one, &Receiver::anywhere(p));
            let id = one.id.index();
            drawn[id] += 1;
            reported[id] = f64::from(one.probability);
            reported_below[k][id] = f64::from(own.probability);
        }
        let mut unevenness = 0.0f64;
        for (&drawn, &reported) in drawn.iter().zip(&reported) {
            let expected = reported * f64::from(trials);
            let deviation = (f64::from(drawn) - expected).abs();
            assert!(
                deviation < 5.0 * expected.sqrt() + 1.0,
                "{drawn} for {expected}"
            );
            unevenness = unevenness.max((reported * count as f64).ln().abs());
        }
        assert!(unevenness > 0.5, "some lights are nearer");
        let [below_first, below_second] = &reported_below;
        for reported in [&reported, below_first, below_second] {
            let sum: f64 = reported.iter().sum();
            assert!((sum - 1.0).abs() < 5e-3, "{sum}");
        }
    }
}

/// For `count` random receivers with a random inner node each: the sum over the lights of the node,
/// each from one of its points, is within the bound. Returns the geometric mean of bound over sum,
/// and the number of connections.
fn hold_bounds(form: Option<GlossyForm>, count: u32) -> (f64, u64) {
    let scene = glossy_box(8).build();
    let (photons, set) = lit(&scene, 400, form);
    let tree = LightTree::new(&set, |_| true);
    let mut rng = Pcg::new(9);
    let (mut looseness, mut lit, mut connections) = (0.0, 0u64, 0);
    for _ in 0..count {
        let at = &photons[(rng.next_f32() * photons.len() as f32) as usize];
        let x = scene.surface_point(at.at);
        let bsdf = scene.bsdf(&x);
        let wo = warp::sphere(Vec2::new(rng.next_f32(), rng.next_f32()));
        let mut node = 0;
        while let Some(children) = tree.children(node) {
            // Nodes of all depths.
            if rng.next_f32() < 0.1 {
                break;
            }
            node = children[usize::from(rng.next_f32() < 0.5)];
        }
        if tree.children(node).is_none() {
            continue;
        }
        let receivers =
            FixedWoLanes::new(LaneModel::of(&bsdf), Lobes::NON_SPECULAR, once((&bsdf, wo)));
        let places = Lanes3::from_fn(|_| x.p);
        let bound = Isa::best().run(BoundAtOne(&tree.nodes()[node], &places, &receivers));
        let mut sum = 0.0;
        for id in below(&tree, node) {
            let point = (rng.next_f32() * POINTS as f32) as usize;
            let to = set.lights()[id.index()].points[point] - x.p;
            let d2 = to.length_squared();
            if d2 == 0.0 {
                continue;
            }
            let w = to / d2.sqrt();
            let value = bsdf.f_cos_wi(w, wo, Lobes::NON_SPECULAR) * set.intensity(id, -w);
            sum += value.luminance() / d2;
            connections += 1;
        }
        assert!(sum <= bound * 1.0001 + 1e-9, "{sum} beyond {bound}");
        if sum > 0.0 && bound.is_finite() {
            looseness += f64::from(bound / sum).ln();
            lit += 1;
        }
    }
    ((looseness / lit as f64).exp(), connections)
}

/// [`hold_bounds`] for lights of every form, `count` receivers each. Returns the number of
/// connections.
fn hold_bounds_of_all_forms(count: u32) -> u64 {
    let forms = [Some(TABLES), Some(GlossyForm::Lobes { count: 5 }), None];
    let connections = forms.map(|form| {
        let (looseness, connections) = hold_bounds(form, count);
        println!(
            "{form:?}: the bound is {looseness:.1} times the sum of {connections} connections"
        );
        assert!(looseness < 100.0);
        connections
    });
    connections.into_iter().sum()
}

#[test]
fn bounds_hold_for_a_million_connections() {
    let all = hold_bounds_of_all_forms(30_000);
    assert!(all > 1_000_000, "{all}");
}

#[test]
#[cfg(feature = "slow-tests")]
fn bounds_hold_for_a_hundred_million_connections() {
    let all = hold_bounds_of_all_forms(600_000);
    assert!(all > 100_000_000, "{all}");
}
