//! A cut through the light tree for up to 64 points together, refined until no cluster can be far
//! off at any of them.
//!
//! Source: Walter et al., "Lightcuts: A Scalable Approach to Illumination", SIGGRAPH 2005.
//! Deviations: one cut serves many points, at each of which clusters are bounded; many clusters are
//! refined at once, so that the shadow rays of new representatives are traced together;
//! representatives are sampled by the light that they send to the points.

use super::batch_sums::{BatchSums, add_light, flush};
use super::occlusion::Occluders;
use super::points::{BATCHES, Batch};
use super::{CutLimits, Gather, Gathered, LightIndex};
use crate::color::Rgb;
use crate::lanes::{Float, LANES, Lanes, Lanes3, Sixteen, lanes_of};
use crate::light_tree::{DrawnLight, LightTree, Receiver, ReflectedBounds};
use crate::math::Vec3;
use crate::sampling::rng::{self, Pcg};
use crate::scene::Scene;
use crate::simd::{Isa, Simd, SimdKernel, outlined};

/// Clusters that are refined in a round, at least: as many representatives as a block of shadow
/// rays holds. At 32 and 128 (a pass of 4096 lights at 72x40, 3 seeds; Glossy Room, Kitchen):
/// relMSE -2.3 and +4.5 % (standard error 2 %).
const ROUND: usize = 64;
/// In a round, this fraction of a large cut is refined (one over the number), so that it needs no
/// more rounds than a small one. At 8 and 2 (a pass of 4096 lights at 72x40, 6 seeds; Kitchen, Glossy
/// Room, U-Shape): relMSE -0.3 and +6.9 % (standard error 1 %).
const ROUND_DIVISOR: usize = 4;
/// A point counts as no darker than this fraction of the brightest point that shares its cut. With
/// an error of 2 % it allows 0.0002 of the brightest, below a step of an 8-bit sRGB picture near
/// black (0.0003). At 0.005 and 0.02 (a pass of 4096 lights at 72x40, 3 seeds; Glossy Room,
/// Kitchen): relMSE -0.4 and +0.2 %.
const DARKEST_POINT: f32 = 0.01;

/// A node of the cut.
struct CutNode {
    node: usize,
    /// Slot of the light of its representative.
    slot: usize,
    /// Its representative: a light below the node.
    drawn: DrawnLight,
    /// Bounds of the light of all its lights at each point; 0 for single lights, which are exact.
    bounds: [ReflectedBounds; BATCHES],
}

/// See [`add`].
struct AddCut<'a> {
    gather: &'a Gather,
    scene: &'a Scene,
    lights: &'a LightIndex<'a>,
    tree: &'a LightTree,
    limits: CutLimits,
    batches: &'a [Batch<'a, 'a>],
    sums: &'a mut [Gathered],
    by_group: &'a mut [Rgb],
    /// Mean position of the points.
    middle: Vec3,
    rng: Pcg,
}

/// Adds a cut through the light tree to the sums of the points of up to [`BATCHES`] batches.
pub(super) fn add(
    gather: &Gather,
    (scene, lights): (&Scene, &LightIndex),
    limits: CutLimits,
    batches: &[Batch],
    (sums, by_group): (&mut [Gathered], &mut [Rgb]),
) {
    let tree = lights.tree.as_ref();
    let tree = tree.expect("invariant: lights have a tree where cuts are asked for");
    let part = batches[0].lights.lights_per_member() as u32;
    let first = batches[0].p.vec(0);
    let key = rng::key(first.to_array()) ^ u64::from(batches[0].u[0].to_bits());
    Isa::best().run(AddCut {
        middle: middle(batches),
        rng: Pcg::new(key),
        gather,
        scene,
        lights,
        tree,
        limits: CutLimits {
            max_lights: (limits.max_lights / part).max(1),
            ..limits
        },
        batches,
        sums,
        by_group,
    });
}

impl SimdKernel for AddCut<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Simd>(mut self, isa: I) {
        let s = isa.wide();
        let mut sum = BatchSums::new(s, self.gather, self.scene, self.lights, self.batches, 0);
        let mut cut = Vec::new();
        for &root in self.tree.roots() {
            put(s, &mut self, None, root, &mut cut, &mut sum);
        }
        flush(&mut sum, self.sums);
        let mut allowed = self.allowed(s, &cut, &sum.gathered);
        let mut occluders = Occluders::new(self.scene, self.batches);
        let mut coarse = Vec::new();
        loop {
            coarse.clear();
            let inverses = allowed.map(|allowed| inverse(s, &allowed));
            for (k, cluster) in cut.iter().enumerate() {
                if is_beyond(s, &cluster.bounds, &allowed) {
                    coarse.push((likeliest(s, &cluster.bounds, &inverses), k));
                }
            }
            let room = (self.limits.max_lights as usize).saturating_sub(cut.len());
            let most = room.min(ROUND.max(cut.len() / ROUND_DIVISOR));
            if coarse.is_empty() || most == 0 {
                break;
            }
            if coarse.len() > most {
                coarse.select_nth_unstable_by(most - 1, |a, b| b.0.total_cmp(&a.0));
                coarse.truncate(most);
            }
            // From the last on, so that removal keeps the indices of the others.
            coarse.sort_unstable_by_key(|&(_, k)| std::cmp::Reverse(k));
            for &(_, k) in &coarse {
                let Some(children) = self.tree.children(cut[k].node) else {
                    continue;
                };
                if self.is_hidden(s, &cut[k], &sum.gathered, &mut occluders) {
                    cut.swap_remove(k);
                    continue;
                }
                let parent = cut.swap_remove(k);
                let set = &self.lights.set;
                let receiver = Receiver::anywhere(self.middle);
                let (holder, drawn) = (self.tree).inherit(set, children, parent.drawn, &receiver);
                for (i, node) in children.into_iter().enumerate() {
                    let inherited = (i == holder).then_some((parent.slot, drawn));
                    put(s, &mut self, inherited, node, &mut cut, &mut sum);
                }
            }
            flush(&mut sum, self.sums);
            allowed = self.allowed(s, &cut, &sum.gathered);
        }
        sum.count_clamped(self.sums);
        self.finish(&cut, &sum.gathered);
    }
}

// Compiled once for each instruction set, though a kernel calls it in two places.
outlined! {
    /// Puts a node into the cut, unless no point can receive light from it. Its representative is
    /// `inherited` from its parent with the slot of that, or sampled anew.
    fn put<S: Sixteen>(
        s: S, add: &mut AddCut<'_>, inherited: Option<(usize, DrawnLight)>, node: usize,
        cut: &mut Vec<CutNode>, sum: &mut BatchSums<'_, '_, '_, S>,
    ) -> () { s => add.put_inlined(s, inherited, node, cut, sum) }
}

impl AddCut<'_> {
    /// Samples a representative of a node.
    fn draw(&mut self, node: usize) -> DrawnLight {
        let receiver = Receiver::anywhere(self.middle);
        (self.tree).draw(&self.lights.set, node, &receiver, &mut self.rng)
    }

    /// Whether one surface hides all of a cluster from all points. Tested only if no light of its
    /// representative arrives.
    #[inline(always)]
    fn is_hidden<S: Sixteen>(
        &self,
        s: S,
        cluster: &CutNode,
        gathered: &[[Lanes3; BATCHES]],
        occluders: &mut Occluders,
    ) -> bool {
        let arrived = gathered[cluster.slot].iter().flat_map(|lanes| &lanes.0);
        let target = self.lights.set.lights()[cluster.drawn.id.index()].p;
        let node = &self.tree.nodes()[cluster.node];
        arrived.flatten().all(|&x| x == 0.0)
            && occluders.hide(s, &node.bounds.grown(node.offset), target)
    }

    #[inline(always)]
    fn put_inlined<S: Sixteen>(
        &mut self,
        s: S,
        inherited: Option<(usize, DrawnLight)>,
        node: usize,
        cut: &mut Vec<CutNode>,
        sum: &mut BatchSums<S>,
    ) {
        let bounds = self.bounds(s, node);
        let is_leaf = self.tree.children(node).is_none();
        let all = bounds.iter().flat_map(|batch| &batch.most);
        if !is_leaf && all.copied().all(|bound| bound == 0.0) {
            return;
        }
        let (slot, drawn) = match inherited {
            Some(inherited) => inherited,
            None => {
                let (slot, drawn) = (sum.gathered.len(), self.draw(node));
                sum.gathered.push([Lanes3::ZERO; BATCHES]);
                sum.slot = slot;
                add_light(sum, drawn.id, self.sums);
                (slot, drawn)
            }
        };
        cut.push(CutNode {
            node,
            slot,
            drawn,
            bounds,
        });
    }

    /// [`LightNode::reflected_bounds`](crate::light_tree::LightNode) for each point.
    #[inline(always)]
    fn bounds<S: Sixteen>(&self, s: S, node: usize) -> [ReflectedBounds; BATCHES] {
        let mut bounds = [ReflectedBounds::NOTHING; BATCHES];
        if self.tree.children(node).is_none() {
            return bounds;
        }
        let node = &self.tree.nodes()[node];
        for (bounds, batch) in bounds.iter_mut().zip(self.batches) {
            let facing = batch.facing_cluster(s, &node.bounds, &node.normals);
            if facing == 0 {
                continue;
            }
            let all = node.reflected_bounds(s, &batch.p, &batch.bsdfs, facing);
            for i in lanes_of(facing) {
                bounds.most[i] = all.most[i];
                bounds.likely[i] = all.likely[i];
            }
        }
        bounds
    }

    /// Largest error of a cluster at each point, luminance in W/(m² sr): relative to the sum there,
    /// or the tolerance of the point.
    #[inline(always)]
    fn allowed<S: Sixteen>(
        &self,
        s: S,
        cut: &[CutNode],
        gathered: &[[Lanes3; BATCHES]],
    ) -> [Lanes; BATCHES] {
        let mut totals = [[0.0; LANES]; BATCHES];
        for (b, total) in totals.iter_mut().enumerate().take(self.batches.len()) {
            let mut sum = Float::splat(s, 0.0);
            for cluster in cut {
                let value = (gathered[cluster.slot][b].colors(s)).weighted_sum(Rgb::LUMINANCE);
                sum = value.mul_add(sum.same(cluster.drawn.probability.recip()), sum);
            }
            *total = sum.store();
        }
        let brightest = totals.iter().flatten().copied().fold(0.0, f32::max);
        let mut allowed = totals
            .map(|total| total.map(|x| self.limits.max_error * x.max(DARKEST_POINT * brightest)));
        for (allowed, batch) in allowed.iter_mut().zip(self.batches) {
            let tolerance = Float::load(s, &batch.tolerance);
            *allowed = Float::load(s, allowed).max(tolerance).store();
        }
        allowed
    }

    /// Adds the terms of the cut to the sums.
    fn finish(self, cut: &[CutNode], gathered: &[[Lanes3; BATCHES]]) {
        for (b, batch) in self.batches.iter().enumerate() {
            for (i, &member) in batch.members.iter().enumerate() {
                let sum = &mut self.sums[member];
                for c in cut {
                    let value = gathered[c.slot][b].rgb(i) / c.drawn.probability;
                    sum.radiance += value;
                    if self.lights.groups > 0 {
                        let group = self.lights.set.lights()[c.drawn.id.index()].group;
                        self.by_group[member * self.lights.groups + group.index()] += value;
                    }
                }
                sum.terms = cut.len() as u32;
                sum.connections = gathered.len() as u64;
                let bound = cut.iter().map(|c| c.bounds[b].most[i]).fold(0.0, f32::max);
                if bound > 0.0 {
                    sum.cluster_error = bound / sum.radiance.luminance();
                }
            }
        }
    }
}

/// Mean position of the points.
fn middle(batches: &[Batch]) -> Vec3 {
    let places = |batch: &Batch| {
        (0..batch.members.len())
            .map(|i| batch.p.vec(i))
            .sum::<Vec3>()
    };
    let count: usize = batches.iter().map(|batch| batch.members.len()).sum();
    batches.iter().map(places).sum::<Vec3>() / count as f32
}

/// One over the allowed errors; a large number where no error is allowed.
#[inline(always)]
fn inverse<S: Sixteen>(s: S, allowed: &Lanes) -> Lanes {
    let allowed = Float::load(s, allowed);
    allowed.max(f32::MIN_POSITIVE).recip().store()
}

/// Whether the bound of a cluster is larger than the allowed error at any of the points.
#[inline(always)]
fn is_beyond<S: Sixteen>(
    s: S,
    bounds: &[ReflectedBounds; BATCHES],
    allowed: &[Lanes; BATCHES],
) -> bool {
    for (bounds, allowed) in bounds.iter().zip(allowed) {
        let most = Float::load(s, &bounds.most);
        if most.gt(Float::load(s, allowed)).any() {
            return true;
        }
    }
    false
}

/// Largest ratio, over the points, of the light that a cluster is likely to send and the allowed
/// error.
#[inline(always)]
fn likeliest<S: Sixteen>(
    s: S,
    bounds: &[ReflectedBounds; BATCHES],
    inverses: &[Lanes; BATCHES],
) -> f32 {
    let mut largest = Float::splat(s, 0.0);
    for (bounds, inverse) in bounds.iter().zip(inverses) {
        let ratio = Float::load(s, &bounds.likely) * Float::load(s, inverse);
        largest = ratio.max(largest);
    }
    largest.store().into_iter().fold(0.0, f32::max)
}
