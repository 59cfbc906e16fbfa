//! A cut through the light tree for up to 64 points together, refined until no cluster can be far off at any of them.
//!
//! Source: Walter et al., "Lightcuts: A Scalable Approach to Illumination", SIGGRAPH 2005. Deviations: one cut serves many points,
//! at each of which clusters are bounded; many clusters are refined at once, so that the shadow rays of new representatives are
//! traced together; representatives are sampled by the light that they send to the points.

use super::connect::BatchSums;
use super::occlusion::Occluders;
use super::points::{BATCHES, Batch};
use super::{Gather, Gathered, LightIndex};
use crate::lanes::vectors::luminance;
use crate::lanes::{LANES, LaneMask, Lanes, Lanes3, lanes_of};
use crate::light_tree::{DrawnLight, LightTree, Sent};
use crate::math::Vec3;
use crate::sampling::rng::{self, Pcg};
use crate::scene::Scene;
use crate::simd::{self, Isa, Simd, Sixteen};

/// When the refinement of a cut ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutLimits {
    /// Largest error of a cluster, relative to the radiance that the point reflects, or that the pixel receives.
    pub max_error: f32,
    /// Most lights and clusters of a cut, whatever their error.
    pub max_lights: u32,
}

impl Default for CutLimits {
    /// The values of Walter et al. 2005.
    fn default() -> Self {
        CutLimits {
            max_error: 0.02,
            max_lights: 1000,
        }
    }
}

/// Clusters that are refined in a round, at least. Unmeasured: as many representatives as a block of shadow rays holds.
const ROUND: usize = 64;
/// In a round, this fraction of a large cut is refined (one over the number), so that it needs no more rounds than a small one.
const ROUND_DIVISOR: usize = 4;
/// A point counts as no darker than this fraction of the brightest point that shares its cut. Unmeasured.
const DARKEST_POINT: f32 = 0.01;

/// A node of the cut.
struct CutNode {
    node: usize,
    /// Slot of the light of its representative.
    slot: usize,
    /// Its representative: a light below the node.
    drawn: DrawnLight,
    /// Bounds of the light of all its lights at each point; 0 for single lights, which are exact.
    sent: [Sent; BATCHES],
}

/// See [`Gather::add_cut`].
struct AddCut<'a> {
    gather: &'a Gather,
    scene: &'a Scene,
    lights: &'a LightIndex<'a>,
    tree: &'a LightTree,
    limits: CutLimits,
    batches: &'a [Batch<'a, 'a>],
    sums: &'a mut [Gathered],
    /// Mean position of the points.
    middle: Vec3,
    rng: Pcg,
}

impl Gather {
    /// Adds a cut through the light tree to the sums of the points of up to [`BATCHES`] batches.
    pub(super) fn add_cut(
        &self,
        scene: &Scene,
        lights: &LightIndex,
        limits: CutLimits,
        batches: &[Batch],
        sums: &mut [Gathered],
    ) {
        let tree = lights.tree.as_ref();
        let tree = tree.expect("invariant: lights have a tree where cuts are asked for");
        let part = batches[0].lights.lights_per_member() as u32;
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

impl simd::SimdKernel for AddCut<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, s: S) {
        let w = s.wide();
        let mut sum = BatchSums::new(w, self.gather, self.scene, self.lights, self.batches, 0);
        let mut cut = Vec::new();
        if let Some(root) = self.tree.root() {
            self.put(w, None, root, &mut cut, &mut sum);
        }
        sum.flush(w, self.sums);
        let mut allowed = self.allowed(w, &cut, &sum.gathered);
        let mut occluders = Occluders::new(self.scene, self.batches);
        let mut coarse = Vec::new();
        loop {
            coarse.clear();
            let inverses = allowed.map(|allowed| inverse(w, &allowed));
            for (k, cluster) in cut.iter().enumerate() {
                if is_beyond(w, &cluster.sent, &allowed) {
                    coarse.push((likeliest(w, &cluster.sent, &inverses), k));
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
                if self.is_hidden(w, &cut[k], &sum.gathered, &mut occluders) {
                    cut.swap_remove(k);
                    continue;
                }
                let parent = cut.swap_remove(k);
                let set = &self.lights.set;
                let (heir, drawn) = (self.tree).inherit(set, children, parent.drawn, self.middle);
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
    /// Samples a representative of a node.
    fn draw(&mut self, node: usize) -> DrawnLight {
        (self.tree).draw(&self.lights.set, node, self.middle, &mut self.rng)
    }

    /// Whether one surface hides all of a cluster from all points. Tested only if no light of its representative arrives.
    #[inline(always)]
    fn is_hidden<W: Sixteen>(
        &self,
        w: W,
        cluster: &CutNode,
        gathered: &[[Lanes3; BATCHES]],
        occluders: &mut Occluders,
    ) -> bool {
        let arrived = gathered[cluster.slot].iter().flat_map(|lanes| &lanes.0);
        let target = self.lights.set.lights()[cluster.drawn.id.index()].p;
        let node = &self.tree.nodes()[cluster.node];
        arrived.flatten().all(|&x| x == 0.0)
            && occluders.hide(w, &node.bounds.grown(node.offset), target)
    }

    /// Puts a node into the cut, unless no point can receive light from it. Its representative is `inherited` from its parent with
    /// the slot of that, or sampled anew.
    #[inline(always)]
    fn put<W: Sixteen>(
        &mut self,
        w: W,
        inherited: Option<(usize, DrawnLight)>,
        node: usize,
        cut: &mut Vec<CutNode>,
        sum: &mut BatchSums,
    ) {
        let sent = self.sent(w, node);
        let is_leaf = self.tree.children(node).is_none();
        let bounds = sent.iter().flat_map(|sent| &sent.bounds);
        if !is_leaf && bounds.copied().all(|bound| bound == 0.0) {
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
        cut.push(CutNode {
            node,
            slot,
            drawn,
            sent,
        });
    }

    /// [`LightNode::sent`] for each point.
    #[inline(always)]
    fn sent<W: Sixteen>(&self, w: W, node: usize) -> [Sent; BATCHES] {
        let mut sent = [Sent::NOTHING; BATCHES];
        if self.tree.children(node).is_none() {
            return sent;
        }
        let node = &self.tree.nodes()[node];
        for (sent, batch) in sent.iter_mut().zip(self.batches) {
            let facing = batch.facing_cluster(w, &node.bounds, &node.normals);
            if facing == 0 {
                continue;
            }
            let all = node.sent(w, &batch.p, &batch.receivers, facing);
            for i in lanes_of(facing) {
                sent.bounds[i] = all.bounds[i];
                sent.likely[i] = all.likely[i];
            }
        }
        sent
    }

    /// Largest error of a cluster at each point, luminance in W/(m² sr): relative to the sum there, or the tolerance of the point.
    #[inline(always)]
    fn allowed<W: Sixteen>(
        &self,
        w: W,
        cut: &[CutNode],
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
        let mut allowed = totals
            .map(|total| total.map(|x| self.limits.max_error * x.max(DARKEST_POINT * brightest)));
        for (allowed, batch) in allowed.iter_mut().zip(self.batches) {
            *allowed = w.store(w.max(w.load(allowed), w.load(&batch.tolerance)));
        }
        allowed
    }

    /// Adds the terms of the cut to the sums.
    fn finish(self, cut: &[CutNode], gathered: &[[Lanes3; BATCHES]], allowed: &[Lanes; BATCHES]) {
        for (b, batch) in self.batches.iter().enumerate() {
            for (i, &member) in batch.members.iter().enumerate() {
                let sum = &mut self.sums[member];
                for c in cut {
                    sum.radiance += gathered[c.slot][b].rgb(i) / c.drawn.probability;
                }
                sum.terms = cut.len() as u32;
                sum.connections = gathered.len() as u64;
                let bound = cut.iter().map(|c| c.sent[b].bounds[i]).fold(0.0, f32::max);
                if bound > 0.0 {
                    sum.cluster_error = bound / allowed[b][i] * self.limits.max_error;
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
fn inverse<W: Sixteen>(w: W, allowed: &Lanes) -> Lanes {
    let least = w.splat(f32::MIN_POSITIVE);
    w.store(w.div(w.splat(1.0), w.max(w.load(allowed), least)))
}

/// Whether the bound of a cluster is larger than the allowed error at any of the points.
#[inline(always)]
fn is_beyond<W: Sixteen>(w: W, sent: &[Sent; BATCHES], allowed: &[Lanes; BATCHES]) -> bool {
    let beyond =
        |(sent, allowed): (&Sent, &Lanes)| w.bits(w.lt(w.load(allowed), w.load(&sent.bounds))) != 0;
    sent.iter().zip(allowed).any(beyond)
}

/// Largest ratio, over the points, of the light that a cluster is likely to send and the allowed error.
#[inline(always)]
fn likeliest<W: Sixteen>(w: W, sent: &[Sent; BATCHES], inverses: &[Lanes; BATCHES]) -> f32 {
    let mut least = w.splat(0.0);
    for (sent, inverse) in sent.iter().zip(inverses) {
        let negative = w.mul(w.load(&sent.likely), w.sub(w.splat(0.0), w.load(inverse)));
        least = w.min(least, negative);
    }
    -w.store(least)[w.lowest(u32::from(LaneMask::MAX), least) as usize]
}
