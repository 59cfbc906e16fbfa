//! Which lights are evaluated at up to 64 points together: a cut through the tree, refined until no cluster can be far off at any of
//! them.
//!
//! Source: Walter et al., "Lightcuts: A Scalable Approach to Illumination", SIGGRAPH 2005. Deviations: one cut serves many points, which are bounded one by
//! one; it is refined at many clusters at once, so that new representatives are tested for visibility together; and these are drawn for
//! the points by what they send there.

use super::connect::Sum;
use super::points::{BATCHES, Batch};
use super::{Gather, Gathered, Lights};
use crate::color::Rgb;
use crate::lanes::vectors::luminance;
use crate::lanes::{LANES, Lanes, Lanes3, lanes_of};
use crate::light_tree::{Drawn, LightTree};
use crate::math::Vec3;
use crate::sampling::rng::{self, Pcg};
use crate::scene::Scene;
use crate::simd::{self, Isa, Simd, Wide};

/// When a cut is fine enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutLimits {
    /// No cluster may be off by more than this share of what a point reflects of all lights.
    pub max_error: f32,
    /// Most lights and clusters, even if some are off by more.
    pub max_lights: u32,
}

impl Default for CutLimits {
    /// What the source uses.
    fn default() -> Self {
        CutLimits {
            max_error: 0.02,
            max_lights: 1000,
        }
    }
}

/// Clusters that are refined at once, at most.
const ROUND: usize = 64;
/// Points count as no darker than this share of the brightest of their group.
const DARKEST: f32 = 0.01;

/// A node of the cut.
struct Cluster {
    node: usize,
    /// Of what its representative sends.
    slot: usize,
    /// The light that stands for all below the node.
    drawn: Drawn,
    /// Upper bounds of the luminance of what all its lights send to each point; 0 for single lights, which are exact.
    bounds: [Lanes; BATCHES],
}

/// See [`Gather::add_cut`].
struct AddCut<'a> {
    gather: &'a Gather,
    scene: &'a Scene,
    lights: &'a Lights<'a>,
    tree: &'a LightTree,
    limits: CutLimits,
    batches: &'a [Batch<'a, 'a>],
    sums: &'a mut [Gathered],
    /// Of the points.
    middle: Vec3,
    rng: Pcg,
}

impl Gather {
    /// Adds what a cut through the lights' tree sends to the points of up to [`BATCHES`] batches.
    pub(super) fn add_cut(
        &self,
        scene: &Scene,
        lights: &Lights,
        limits: CutLimits,
        batches: &[Batch],
        sums: &mut [Gathered],
    ) {
        let tree = lights.tree.as_ref();
        let tree = tree.expect("invariant: lights have a tree where cuts are asked for");
        let part = batches[0].lights.stands_for() as u32;
        let first = batches[0].p.vec(0);
        let key = rng::key(first.to_array()) ^ u64::from(batches[0].u[0].to_bits());
        Isa::best().run(AddCut {
            middle: middle(batches),
            rng: Pcg::new(key),
            gather: self,
            scene,
            lights,
            tree,
            limits: CutLimits {
                max_lights: (limits.max_lights / part).max(1),
                ..limits
            },
            batches,
            sums,
        });
    }
}

impl simd::Kernel for AddCut<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, s: S) {
        let w = s.wide();
        if self.tree.root().is_none() {
            return;
        }
        let mut sum = Sum::new(w, self.gather, self.scene, self.lights, self.batches);
        let drawn = self.draw(0);
        let mut cut = vec![Cluster {
            node: 0,
            slot: 0,
            drawn,
            bounds: self.bounds(0),
        }];
        sum.add_light(w, drawn.id, self.sums);
        sum.flush(w, self.sums);
        let mut allowed = self.allowed(w, &cut, &sum.gathered);
        let mut coarse = Vec::new();
        loop {
            coarse.clear();
            for (k, cluster) in cut.iter().enumerate() {
                let excess = excess(&cluster.bounds, &allowed);
                if excess > 1.0 {
                    coarse.push((excess, k));
                }
            }
            let room = (self.limits.max_lights as usize).saturating_sub(cut.len());
            let most = room.min(ROUND).min(cut.len());
            if coarse.is_empty() || most == 0 {
                break;
            }
            if coarse.len() > most {
                coarse.select_nth_unstable_by(most - 1, |a, b| b.0.total_cmp(&a.0));
                coarse.truncate(most);
            }
            // From the last on, so that removal leaves the others where they are.
            coarse.sort_unstable_by_key(|&(_, k)| std::cmp::Reverse(k));
            for &(_, k) in &coarse {
                let Some(children) = self.tree.children(cut[k].node) else {
                    continue;
                };
                let parent = cut.swap_remove(k);
                let field = &self.lights.field;
                let (heir, drawn) = (self.tree).inherit(field, children, parent.drawn, self.middle);
                for (i, node) in children.into_iter().enumerate() {
                    let inherited = (i == heir).then_some((parent.slot, drawn));
                    self.put(w, inherited, node, &mut cut, &mut sum);
                }
            }
            sum.flush(w, self.sums);
            allowed = self.allowed(w, &cut, &sum.gathered);
        }
        sum.count_clamped(self.sums);
        self.finish(&cut, &sum.gathered, &allowed);
    }
}

impl AddCut<'_> {
    /// A light that stands for all below a node.
    fn draw(&mut self, node: usize) -> Drawn {
        (self.tree).draw(&self.lights.field, node, self.middle, &mut self.rng)
    }

    /// Puts a node into the cut, unless none of the points can receive anything from it; with its parent's light and the slot of that, or
    /// one of its own.
    #[inline(always)]
    fn put<W: Wide>(
        &mut self,
        w: W,
        inherited: Option<(usize, Drawn)>,
        node: usize,
        cut: &mut Vec<Cluster>,
        sum: &mut Sum,
    ) {
        let bounds = self.bounds(node);
        let is_leaf = self.tree.children(node).is_none();
        if !is_leaf && bounds.iter().flatten().all(|&bound| bound == 0.0) {
            return;
        }
        let (slot, drawn) = match inherited {
            Some(inherited) => inherited,
            None => {
                let (slot, drawn) = (sum.gathered.len(), self.draw(node));
                sum.gathered.push([Lanes3::ZERO; BATCHES]);
                sum.slot = slot;
                sum.add_light(w, drawn.id, self.sums);
                (slot, drawn)
            }
        };
        cut.push(Cluster {
            node,
            slot,
            drawn,
            bounds,
        });
    }

    /// [`Node::bounds`] for each point.
    #[inline(always)]
    fn bounds(&self, node: usize) -> [Lanes; BATCHES] {
        let mut bounds = [[0.0; LANES]; BATCHES];
        if self.tree.children(node).is_none() {
            return bounds;
        }
        let node = &self.tree.nodes()[node];
        for (bounds, batch) in bounds.iter_mut().zip(self.batches) {
            let used = batch.used();
            let all = node.bounds(&batch.p, &batch.receivers, used);
            for i in lanes_of(used) {
                bounds[i] = all[i];
            }
        }
        bounds
    }

    /// By how much a cluster may be off at each point: a share of the luminance of the sum there.
    #[inline(always)]
    fn allowed<W: Wide>(
        &self,
        w: W,
        cut: &[Cluster],
        gathered: &[[Lanes3; BATCHES]],
    ) -> [Lanes; BATCHES] {
        let mut totals = [[0.0; LANES]; BATCHES];
        for (b, total) in totals.iter_mut().enumerate().take(self.batches.len()) {
            let mut sum = w.splat(0.0);
            for cluster in cut {
                let value = luminance(w, gathered[cluster.slot][b].load(w));
                sum = w.mul_add(value, w.splat(cluster.drawn.probability.recip()), sum);
            }
            *total = w.store(sum);
        }
        let brightest = totals.iter().flatten().copied().fold(0.0, f32::max);
        totals.map(|total| total.map(|x| self.limits.max_error * x.max(DARKEST * brightest)))
    }

    /// Adds up the cut.
    fn finish(self, cut: &[Cluster], gathered: &[[Lanes3; BATCHES]], allowed: &[Lanes; BATCHES]) {
        for (b, batch) in self.batches.iter().enumerate() {
            for (i, &member) in batch.members.iter().enumerate() {
                let sum = &mut self.sums[member];
                let terms = cut
                    .iter()
                    .map(|c| gathered[c.slot][b].rgb(i) / c.drawn.probability);
                sum.radiance += terms.sum::<Rgb>();
                sum.terms = cut.len() as u32;
                sum.connections = gathered.len() as u64;
                let bound = cut.iter().map(|c| c.bounds[b][i]).fold(0.0, f32::max);
                if bound > 0.0 {
                    sum.cluster_error = bound / allowed[b][i] * self.limits.max_error;
                }
            }
        }
    }
}

/// The mean of the points.
fn middle(batches: &[Batch]) -> Vec3 {
    let places = |batch: &Batch| {
        (0..batch.members.len())
            .map(|i| batch.p.vec(i))
            .sum::<Vec3>()
    };
    let count: usize = batches.iter().map(|batch| batch.members.len()).sum();
    batches.iter().map(places).sum::<Vec3>() / count as f32
}

/// How many times too much the worst bound is.
#[inline(always)]
fn excess(bounds: &[Lanes; BATCHES], allowed: &[Lanes; BATCHES]) -> f32 {
    let mut worst = 0.0f32;
    for (bounds, allowed) in bounds.iter().zip(allowed) {
        for (&bound, &allowed) in bounds.iter().zip(allowed) {
            // Where nothing is allowed, nothing but 0 will do.
            let excess = if bound > 0.0 { bound / allowed } else { 0.0 };
            worst = worst.max(excess);
        }
    }
    worst
}
