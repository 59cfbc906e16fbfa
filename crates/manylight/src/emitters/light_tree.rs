//! Choice of one emitter among many for a receiving point.
//!
//! A tree over the parts of all local emitters; each node bounds positions, normals and power of what is below it.
//! A choice descends from the root and takes each child in proportion to a bound-based estimate of what it sends to the
//! receiver. Source: Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", 2018.
//! The tree is built with two children per node, then widened to sixteen, whose estimates are computed side by side.
//!
//! Deviations: estimates never reach 0 by the receiver's normal (shading normals may look elsewhere), nor by the emitter's
//! normals before its whole range of directions is left behind, so that nothing that can contribute is ever lost.

use super::Strength;
use super::parts::PartBounds;
use crate::lanes::{LANES, Lanes, Lanes3};
use crate::math::{Aabb, Cone, Vec3, float::safe_sqrt};
use crate::simd::{Isa, Simd, SimdKernel};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// Cosines below this count as this much: estimates by bounds are rough near horizons.
const COSINE_FLOOR: f32 = 0.05;

/// Rounding of cosines that must not exclude anything.
const COSINE_SLACK: f32 = 1e-3;

/// Candidate planes per axis and split.
const BINS: usize = 12;

/// So many parts of a node are asked for the best plane.
const BINNED_PARTS: usize = 1024;

/// Below this depth nodes are halved by count, so that no input makes the recursion deep.
const BALANCED_BELOW: u32 = 48;

/// A node of the binary tree.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// Of the bounding sphere of the box.
    center: Vec3,
    radius: f32,
    axis: Vec3,
    cos_normals: f32,
    sin_normals: f32,
    /// Cosine of the angle between a direction and the nearest normal up to which light leaves.
    cos_emission: f32,
    power: f32,
    /// First of two neighboring children, or the part.
    content: u32,
    is_leaf: bool,
}

/// The children of a node of the wide tree, side by side. Lanes that are not used have no power.
#[derive(Clone, Debug)]
struct Family {
    center: Lanes3,
    radius: Lanes,
    axis: Lanes3,
    cos_normals: Lanes,
    sin_normals: Lanes,
    cos_emission: Lanes,
    power: Lanes,
    /// The family below, or the part.
    content: [u32; LANES],
    is_leaf: [bool; LANES],
    count: usize,
    /// Whose children these are; not set for the root's.
    parent: Option<Place>,
}

/// A lane of a family.
#[derive(Clone, Copy, Debug)]
struct Place {
    family: u32,
    lane: u32,
}

/// The tree. Pieces are named by their index in the list it was built from.
#[derive(Clone, Debug)]
pub(super) struct LightTree {
    /// The root's children come first.
    families: Vec<Family>,
    /// Of each part; `None` without power.
    place_of: Vec<Option<Place>>,
    isa: Isa,
}

/// What a set of parts looks like together.
#[derive(Clone, Copy, Debug)]
struct Cluster {
    bounds: Aabb,
    normals: Cone,
    emission: f32,
    power: f32,
}

impl Cluster {
    const EMPTY: Cluster = Cluster {
        bounds: Aabb::EMPTY,
        normals: Cone::EMPTY,
        emission: 0.0,
        power: 0.0,
    };

    fn of(part: &PartBounds) -> Self {
        Cluster {
            bounds: part.bounds,
            normals: part.normals,
            emission: part.emission,
            power: part.power.strength(),
        }
    }

    fn union(self, o: Cluster) -> Self {
        Cluster {
            bounds: self.bounds.union(o.bounds),
            normals: self.normals.union(o.normals),
            emission: self.emission.max(o.emission),
            power: self.power + o.power,
        }
    }

    /// Power times the measures of positions and of directions: eq. (2) of the source without its regularization.
    fn cost(&self) -> f32 {
        if self.bounds.is_empty() {
            return 0.0;
        }
        // A thin box still costs something, so that lines and pairs of points are split as well.
        let area = self
            .bounds
            .area()
            .max(1e-3 * self.bounds.extent().length_squared());
        self.power * self.direction_measure() * area
    }

    /// Solid angle of all emitting directions, weighted by the cosine beyond the normals; eq. (1) of the source.
    fn direction_measure(&self) -> f32 {
        let o = self.normals.half_angle.max(0.0);
        let w = (o + self.emission).min(PI);
        let rim = 2.0 * w * o.sin() - (o - 2.0 * w).cos() - 2.0 * o * o.sin() + o.cos();
        (TAU * (1.0 - o.cos()) + FRAC_PI_2 * rim).max(1e-3)
    }
}

struct Builder<'a> {
    parts: &'a [PartBounds],
    nodes: Vec<Node>,
}

impl LightTree {
    pub(super) fn new(parts: &[PartBounds]) -> Self {
        let mut tree = LightTree {
            families: Vec::new(),
            place_of: vec![None; parts.len()],
            isa: Isa::best(),
        };
        let mut items: Vec<u32> = (0..parts.len() as u32)
            .filter(|&i| parts[i as usize].power.strength() > 0.0)
            .collect();
        if items.is_empty() {
            return tree;
        }
        let mut builder = Builder {
            parts,
            nodes: vec![Node::new(&Cluster::EMPTY)],
        };
        builder.fill(0, &mut items, 0);
        tree.add_family(&builder.nodes, 0, None);
        tree
    }

    /// Adds what is below the node `root` of the binary tree: a family, and then those of its members.
    fn add_family(&mut self, nodes: &[Node], root: usize, parent: Option<Place>) -> u32 {
        let mut members = vec![root];
        while members.len() < LANES {
            // Opens what its bounds say the least about.
            let vagueness = |&i: &usize| nodes[members[i]].power * nodes[members[i]].radius;
            let inner = (0..members.len()).filter(|&i| !nodes[members[i]].is_leaf);
            let Some(widest) = inner.max_by(|a, b| vagueness(a).total_cmp(&vagueness(b))) else {
                break;
            };
            let children = nodes[members[widest]].content as usize;
            members[widest] = children;
            members.push(children + 1);
        }
        let family = self.families.len() as u32;
        self.families.push(Family::new(nodes, &members, parent));
        for (lane, &member) in members.iter().enumerate() {
            let place = Place {
                family,
                lane: lane as u32,
            };
            if nodes[member].is_leaf {
                self.place_of[nodes[member].content as usize] = Some(place);
            } else {
                let below = self.add_family(nodes, member, Some(place));
                self.families[family as usize].content[lane] = below;
            }
        }
        family
    }

    pub(super) fn is_empty(&self) -> bool {
        self.families.is_empty()
    }

    /// A part for the receiver `p` with normal `n`, and the probability of the choice. `None` if nothing can shine there.
    pub(super) fn sample(&self, p: Vec3, n: Option<Vec3>, mut u: f32) -> Option<(usize, f32)> {
        let mut family = self.families.first()?;
        if family.count == 1 {
            return Some((family.content[0] as usize, 1.0));
        }
        let mut pmf = 1.0;
        loop {
            let shares = self.isa.run(Shares { family, p, n });
            let (lane, share, rest) = choose(&shares[..family.count], u)?;
            pmf *= share;
            if family.is_leaf[lane] {
                return Some((family.content[lane] as usize, pmf));
            }
            u = rest;
            family = &self.families[family.content[lane] as usize];
        }
    }

    /// Probability with which [`LightTree::sample`] chooses `part`.
    pub(super) fn pmf(&self, p: Vec3, n: Option<Vec3>, part: usize) -> f32 {
        let mut pmf = 1.0;
        let mut place = self.place_of[part];
        if place.is_none() {
            return 0.0;
        }
        while let Some(Place {
            family: index,
            lane,
        }) = place
        {
            let family = &self.families[index as usize];
            if family.count > 1 {
                let shares = self.isa.run(Shares { family, p, n });
                let share = shares[lane as usize];
                if share <= 0.0 {
                    return 0.0;
                }
                pmf *= share / shares[..family.count].iter().sum::<f32>();
            }
            place = family.parent;
        }
        pmf
    }
}

/// One of the items in proportion to its share, its probability, and what is left of `u`. `None` if all shares are 0.
#[inline]
fn choose(shares: &[f32], u: f32) -> Option<(usize, f32, f32)> {
    const LARGEST: f32 = 1.0 - f32::EPSILON * 0.5;
    let mut ends = [0.0; LANES];
    let mut total = 0.0;
    for (end, share) in ends.iter_mut().zip(shares) {
        total += share;
        *end = total;
    }
    if total <= 0.0 {
        return None;
    }
    let target = u * total;
    // Items without a share are never chosen, whatever the rounding.
    let is_passed = |end: f32| end <= target && end < total;
    let chosen: usize = ends[..shares.len()]
        .iter()
        .map(|&end| usize::from(is_passed(end)))
        .sum();
    let share = shares[chosen];
    let before = if chosen == 0 { 0.0 } else { ends[chosen - 1] };
    let rest = ((target - before) / share).clamp(0.0, LARGEST);
    Some((chosen, share / total, rest))
}

/// Estimates of what the members of a family send to a receiver.
struct Shares<'a> {
    family: &'a Family,
    p: Vec3,
    n: Option<Vec3>,
}

impl SimdKernel for Shares<'_> {
    type Output = Lanes;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Lanes {
        let Shares { family, p, n } = self;
        // Without a normal all receivers are alike.
        let (n, least) = n.map_or((Vec3::ZERO, 1.0), |n| (n, COSINE_FLOOR));
        let mut shares = [0.0; LANES];
        for (i, share) in shares.iter_mut().enumerate() {
            *share = family.importance(i, p, n, least);
        }
        shares
    }
}

impl Family {
    fn new(nodes: &[Node], members: &[usize], parent: Option<Place>) -> Self {
        let mut family = Family {
            center: Lanes3::ZERO,
            radius: [0.0; LANES],
            axis: Lanes3::ZERO,
            cos_normals: [1.0; LANES],
            sin_normals: [0.0; LANES],
            cos_emission: [1.0; LANES],
            power: [0.0; LANES],
            content: [0; LANES],
            is_leaf: [true; LANES],
            count: members.len(),
            parent,
        };
        for (lane, &member) in members.iter().enumerate() {
            let node = &nodes[member];
            family.center.set(lane, node.center);
            family.radius[lane] = node.radius;
            family.axis.set(lane, node.axis);
            family.cos_normals[lane] = node.cos_normals;
            family.sin_normals[lane] = node.sin_normals;
            family.cos_emission[lane] = node.cos_emission;
            family.power[lane] = node.power;
            family.content[lane] = node.content;
            family.is_leaf[lane] = node.is_leaf;
        }
        family
    }

    /// Estimate of what arrives at `p`: power · cosine at the emitter · cosine at the receiver / distance², each cosine the
    /// largest that the bounds allow, and that at the receiver at least `least`. 0 only if no direction to `p` is within the range of
    /// emission.
    #[inline(always)]
    fn importance(&self, i: usize, p: Vec3, n: Vec3, least: f32) -> f32 {
        let to_center = self.center.vec(i) - p;
        let d2 = to_center.length_squared();
        let r2 = self.radius[i] * self.radius[i];
        let inverse = 1.0 / d2.max(f32::MIN_POSITIVE).sqrt();
        let w = to_center * inverse;
        let sin_extent = (self.radius[i] * inverse).min(1.0);
        let cos_extent = safe_sqrt(1.0 - sin_extent * sin_extent);

        let at_emitter = -self.axis.vec(i).dot(w);
        let (cos, sin) = less_angle(
            at_emitter,
            safe_sqrt(1.0 - at_emitter * at_emitter),
            self.cos_normals[i],
            self.sin_normals[i],
        );
        let (cos, _) = less_angle(cos, sin, cos_extent, sin_extent);
        let at_receiver = n.dot(w);
        let sin = safe_sqrt(1.0 - at_receiver * at_receiver);
        let (cos_receiver, _) = less_angle(at_receiver, sin, cos_extent, sin_extent);
        let outside =
            self.power[i] * cos.max(COSINE_FLOOR) * cos_receiver.max(least) * (inverse * inverse);
        let reached = if cos < self.cos_emission[i] - COSINE_SLACK {
            0.0
        } else {
            outside
        };
        // Inside the bounding sphere every angle is possible.
        if d2 <= r2 {
            self.power[i] / r2.max(1e-20)
        } else {
            reached
        }
    }
}

impl Node {
    fn new(cluster: &Cluster) -> Self {
        let half_angle = cluster.normals.half_angle.max(0.0);
        Node {
            center: cluster.bounds.center(),
            radius: 0.5 * cluster.bounds.extent().length(),
            axis: cluster.normals.axis,
            cos_normals: half_angle.cos(),
            sin_normals: safe_sqrt(1.0 - half_angle.cos().powi(2)),
            cos_emission: cluster.emission.min(PI).cos(),
            power: cluster.power,
            content: 0,
            is_leaf: false,
        }
    }
}

/// Cosine and sine of max(0, a - b) from those of a and b, both in [0, π].
#[inline(always)]
fn less_angle(cos_a: f32, sin_a: f32, cos_b: f32, sin_b: f32) -> (f32, f32) {
    let is_less = cos_a < cos_b;
    let (cos, sin) = (cos_a * cos_b + sin_a * sin_b, sin_a * cos_b - cos_a * sin_b);
    (
        if is_less { cos } else { 1.0 },
        if is_less { sin } else { 0.0 },
    )
}

impl Builder<'_> {
    /// Builds the node `index` over `items`, children first, and returns what it holds.
    fn fill(&mut self, index: u32, items: &mut [u32], depth: u32) -> Cluster {
        if let [part] = *items {
            let cluster = Cluster::of(&self.parts[part as usize]);
            let node = Node {
                content: part,
                is_leaf: true,
                ..Node::new(&cluster)
            };
            self.nodes[index as usize] = node;
            return cluster;
        }
        let middle = self.partition(items, depth);
        let children = self.nodes.len() as u32;
        self.nodes.extend([Node::new(&Cluster::EMPTY); 2]);
        let (left, right) = items.split_at_mut(middle);
        let left = self.fill(children, left, depth + 1);
        let right = self.fill(children + 1, right, depth + 1);
        let cluster = left.union(right);
        self.nodes[index as usize] = Node {
            content: children,
            ..Node::new(&cluster)
        };
        cluster
    }

    /// Reorders `items` and returns how many go to the left; at least one, not all.
    fn partition(&self, items: &mut [u32], depth: u32) -> usize {
        let center = |i: u32| self.parts[i as usize].bounds.center();
        let centers = Aabb::from_points(items.iter().map(|&i| center(i)));
        let half = items.len() / 2;
        if depth >= BALANCED_BELOW || items.len() == 2 {
            return half;
        }
        let Some((axis, plane)) = self.best_plane(items, centers) else {
            return half;
        };
        let mut middle = 0;
        for k in 0..items.len() {
            if bin(center(items[k])[axis], axis, centers) < plane {
                items.swap(k, middle);
                middle += 1;
            }
        }
        middle
    }

    /// The axis and the bin before which to split, by the surface area orientation heuristic.
    fn best_plane(&self, items: &[u32], centers: Aabb) -> Option<(usize, usize)> {
        let extent = centers.extent();
        let stride = items.len().div_ceil(BINNED_PARTS);
        let mut best = None;
        let mut best_cost = f32::INFINITY;
        for axis in (0..3).filter(|&axis| extent[axis] > 0.0) {
            let mut bins = [Cluster::EMPTY; BINS];
            for &i in items.iter().step_by(stride) {
                let part = &self.parts[i as usize];
                let b = bin(part.bounds.center()[axis], axis, centers);
                bins[b] = bins[b].union(Cluster::of(part));
            }
            // Against long thin boxes; the factor of the source.
            let regularization = extent.max_element() / extent[axis];
            // What lies at and beyond each plane, then what lies before it.
            let mut beyond = bins;
            for plane in (0..BINS - 1).rev() {
                beyond[plane] = bins[plane].union(beyond[plane + 1]);
            }
            let mut left = Cluster::EMPTY;
            for plane in 1..BINS {
                left = left.union(bins[plane - 1]);
                let right = beyond[plane];
                if left.bounds.is_empty() || right.bounds.is_empty() {
                    continue;
                }
                let cost = regularization * (left.cost() + right.cost());
                if cost < best_cost {
                    best_cost = cost;
                    best = Some((axis, plane));
                }
            }
        }
        best
    }
}

fn bin(x: f32, axis: usize, centers: Aabb) -> usize {
    let fraction = (x - centers.min[axis]) / centers.extent()[axis];
    ((fraction * BINS as f32) as usize).min(BINS - 1)
}
