//! A cut through the product of a gather tree and the light tree: the light that all virtual lights
//! send through all gather points of a pixel. Pairs of nodes are refined until the error bound of
//! each pair is small.
//!
//! Sources: Walter, Arbree, Bala, Greenberg, "Multidimensional Lightcuts", SIGGRAPH 2006, for the
//! product graph; Walter, Khungurn, Bala, "Bidirectional Lightcuts", SIGGRAPH 2012, for gather
//! points at several vertices of a camera path. Deviation: representatives are drawn at random,
//! after Yuksel, "Stochastic Lightcuts", HPG 2019.

use super::light_points::part_count;
use super::pairs::{ConnectionValue, PairBound, PairContext, Parts};
use super::{CutLimits, Gathered, ShadingPoint};
use crate::color::Rgb;
use crate::light_tree::DrawnLight;
use crate::sampling::rng::{self, Pcg};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// A pair of a gather node and a light node, with a representative connection.
#[derive(Clone, Copy)]
struct Pair {
    gather: usize,
    light: usize,
    /// The representative point, drawn by throughput, and its probability.
    point: usize,
    point_probability: f32,
    /// The representative light, drawn for the whole gather node, independently of the point.
    drawn: DrawnLight,
    /// The representative connection.
    value: ConnectionValue,
    /// 0 for single connections, which are exact.
    bound: PairBound,
}

impl Pair {
    /// Inverse of the probability of the representative connection.
    fn inverse_probability(&self) -> f32 {
        (self.point_probability * self.drawn.probability).recip()
    }
}

/// An entry of the queue of refinement, ordered by the likely contribution.
struct Refinable {
    likely: f32,
    pair: usize,
}

impl Ord for Refinable {
    fn cmp(&self, other: &Self) -> Ordering {
        (self.likely.total_cmp(&other.likely)).then(other.pair.cmp(&self.pair))
    }
}

impl PartialOrd for Refinable {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Refinable {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Refinable {}

/// The cut of a pixel during refinement.
struct ProductCut<'a, 'b, 's> {
    context: PairContext<'a, 'b, 's>,
    rng: Pcg,
    /// Pairs of the cut; `None` for refined ones.
    pairs: Vec<Option<Pair>>,
    queue: BinaryHeap<Refinable>,
    /// Number of pairs of the cut.
    terms: usize,
    /// Estimate of the pixel so far: luminance in W/(m² sr).
    total: f64,
    cost: Gathered,
}

/// See [`Gather::sum_of_pixel`](super::Gather::sum_of_pixel); `points` are the gather points of
/// `context`.
pub(super) fn sums(
    context: PairContext,
    limits: CutLimits,
    tolerance: f32,
    points: &[(&ShadingPoint, Rgb)],
    by_group: &mut Vec<Rgb>,
) -> Vec<Gathered> {
    let mut sums = vec![Gathered::default(); points.len()];
    let first_of_pixel = by_group.len();
    let groups = context.lights.groups;
    by_group.resize(first_of_pixel + points.len() * groups, Rgb::BLACK);
    if context.gather_tree.points.is_empty() || context.tree.roots().is_empty() {
        return sums;
    }
    let (first, _) = points[0];
    let key = rng::key(first.x.p.to_array()) ^ u64::from(first.u.to_bits());
    let mut cut = ProductCut {
        context,
        rng: Pcg::new(key),
        pairs: Vec::new(),
        queue: BinaryHeap::new(),
        terms: 0,
        total: 0.0,
        cost: Gathered::default(),
    };
    for &root in context.tree.roots() {
        cut.put(0, root, None);
    }
    cut.refine(limits, tolerance);
    cut.finish(&mut sums, &mut by_group[first_of_pixel..]);
    sums
}

impl ProductCut<'_, '_, '_> {
    /// Refines until no bound exceeds the allowed error, or the cut is as large as it may be.
    fn refine(&mut self, limits: CutLimits, tolerance: f32) {
        let allowed = |total: f64| tolerance.max(limits.max_error * total as f32);
        while self.terms < limits.max_lights as usize {
            let Some(Refinable { pair: index, .. }) = self.queue.pop() else {
                break;
            };
            let wide = |pair: &mut Pair| pair.bound.bound > allowed(self.total);
            if let Some(pair) = self.pairs[index].take_if(wide) {
                self.total -= self.luminance(&pair);
                self.terms -= 1;
                self.split(&pair);
            }
        }
    }

    /// Replaces a pair by the pairs with the children of one of its nodes: the one with the larger
    /// box.
    fn split(&mut self, pair: &Pair) {
        let PairContext {
            tree, gather_tree, ..
        } = self.context;
        let size = [
            gather_tree.nodes[pair.gather].bounds.diagonal(),
            tree.nodes()[pair.light].bounds.diagonal(),
        ];
        match (gather_tree.children(pair.gather), tree.children(pair.light)) {
            (Some(children), None) => self.split_gather(pair, children),
            (None, Some(children)) => self.split_light(pair, children),
            (Some(children), Some(_)) if size[0] > size[1] => self.split_gather(pair, children),
            (Some(_), Some(children)) => self.split_light(pair, children),
            (None, None) => {}
        }
    }

    /// Both children draw anew: the light of the parent was drawn for other points.
    fn split_gather(&mut self, pair: &Pair, children: [usize; 2]) {
        for gather in children {
            self.put(gather, pair.light, None);
        }
    }

    /// The child that contains the light keeps the representative.
    fn split_light(&mut self, pair: &Pair, children: [usize; 2]) {
        let PairContext { tree, lights, .. } = self.context;
        let context = self.context;
        let receiver = context.receiver(pair.gather);
        let (holder, drawn) = tree.inherit(&lights.set, children, pair.drawn, &receiver);
        for (i, light) in children.into_iter().enumerate() {
            let inherited = Pair { drawn, ..*pair };
            self.put(pair.gather, light, (i == holder).then_some(inherited));
        }
    }

    /// Puts a pair into the cut, unless no light can arrive. Its representative is `inherited`, or
    /// drawn.
    fn put(&mut self, gather: usize, light: usize, inherited: Option<Pair>) {
        let PairContext {
            tree, gather_tree, ..
        } = self.context;
        let is_single = gather_tree.children(gather).is_none() && tree.children(light).is_none();
        let bound = if is_single {
            PairBound::default()
        } else {
            self.context.bound(gather, light)
        };
        if !is_single && bound.bound == 0.0 {
            return;
        }
        let pair = match inherited {
            Some(pair) => Pair {
                gather,
                light,
                bound,
                ..pair
            },
            None => self.drawn(gather, light, bound),
        };
        let has_value = inherited.is_some() && !(is_single && self.has_parts(&pair));
        let pair = if has_value {
            pair
        } else {
            self.connected(pair, is_single)
        };
        self.total += self.luminance(&pair);
        if !is_single {
            self.queue.push(Refinable {
                likely: bound.likely,
                pair: self.pairs.len(),
            });
        }
        self.pairs.push(Some(pair));
        self.terms += 1;
    }

    /// Estimate of the light of a pair: luminance in W/(m² sr).
    fn luminance(&self, pair: &Pair) -> f64 {
        let weight = self.context.gather_tree.points[pair.point].throughput;
        let light = (weight * pair.value.radiance).luminance();
        f64::from(light) * f64::from(pair.inverse_probability())
    }

    /// Whether the light of a pair is several parts as seen from its point.
    fn has_parts(&self, pair: &Pair) -> bool {
        let PairContext {
            gather,
            lights,
            gather_tree,
            ..
        } = self.context;
        let light = &lights.set.lights()[pair.drawn.id.index()];
        part_count(gather, &gather_tree.points[pair.point].at.into(), light) > 1
    }

    /// The pair with the value of its representative: of a cluster, one part of the light
    /// represents it.
    fn connected(&mut self, pair: Pair, is_single: bool) -> Pair {
        let parts = if is_single {
            Parts::All
        } else {
            Parts::One(self.rng.next_f32())
        };
        let point = &self.context.gather_tree.points[pair.point];
        let value = (self.context).value(point, pair.drawn.id, parts, &mut self.cost);
        Pair { value, ..pair }
    }

    /// Adds the terms of the cut to the sums of their points.
    fn finish(self, sums: &mut [Gathered], by_group: &mut [Rgb]) {
        let lights = self.context.lights;
        let mut largest = 0.0f32;
        for pair in self.pairs.iter().flatten() {
            let index = self.context.gather_tree.points[pair.point].index;
            let sum = &mut sums[index];
            let weight = pair.inverse_probability();
            sum.radiance += pair.value.radiance * weight;
            if lights.groups > 0 {
                let group = lights.set.lights()[pair.drawn.id.index()].group;
                by_group[index * lights.groups + group.index()] += pair.value.radiance * weight;
            }
            sum.clamped += pair.value.clamped * weight;
            sum.unclamped += pair.value.unclamped * weight;
            largest = largest.max(pair.bound.bound);
        }
        if largest > 0.0 {
            let error = largest / self.total.max(0.0) as f32;
            sums.iter_mut().for_each(|sum| sum.cluster_error = error);
        }
        sums[0].terms = self.terms as u32;
        sums[0].connections = self.cost.connections;
        sums[0].shadow_rays = self.cost.shadow_rays;
    }

    /// A pair with a new representative that has no value yet.
    fn drawn(&mut self, gather: usize, light: usize, bound: PairBound) -> Pair {
        let PairContext {
            tree,
            gather_tree,
            lights,
            ..
        } = self.context;
        let (point, point_probability) = gather_tree.draw(gather, self.rng.next_f32());
        let context = self.context;
        let receiver = context.receiver(gather);
        let drawn = tree.draw(&lights.set, light, &receiver, &mut self.rng);
        Pair {
            gather,
            light,
            point,
            point_probability,
            drawn,
            value: ConnectionValue::default(),
            bound,
        }
    }
}
