//! Choice of one emitter among many for a receiving point.
//!
//! A binary tree over the parts of all local emitters; each node bounds positions, normals and power of what is below it.
//! A choice descends from the root and takes each child in proportion to a bound-based estimate of what it sends to the
//! receiver. Source: Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", 2018.
//!
//! Deviations: estimates never reach 0 by the receiver's normal (shading normals may look elsewhere), nor by the emitter's
//! normals before its whole range of directions is left behind, so that nothing that can contribute is ever lost.

use super::Strength;
use super::parts::PartBounds;
use super::warp_within::split;
use crate::math::{Aabb, Cone, Vec3, float::safe_sqrt};
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
    parent: u32,
    /// First of two neighboring children, or the part.
    content: u32,
    is_leaf: bool,
}

/// The tree. Pieces are named by their index in the list it was built from.
#[derive(Clone, Debug, Default)]
pub(super) struct LightTree {
    nodes: Vec<Node>,
    /// The leaf of each part; [`NO_LEAF`] without power.
    leaf_of: Vec<u32>,
}

const NO_LEAF: u32 = u32::MAX;

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
    tree: LightTree,
}

impl LightTree {
    pub(super) fn new(parts: &[PartBounds]) -> Self {
        let tree = LightTree {
            nodes: Vec::new(),
            leaf_of: vec![NO_LEAF; parts.len()],
        };
        let mut items: Vec<u32> = (0..parts.len() as u32)
            .filter(|&i| parts[i as usize].power.strength() > 0.0)
            .collect();
        if items.is_empty() {
            return tree;
        }
        let mut builder = Builder { parts, tree };
        builder.tree.nodes.push(Node::new(&Cluster::EMPTY, 0));
        builder.fill(0, &mut items, 0);
        builder.tree
    }

    pub(super) fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// A part for the receiver `p` with normal `n`, and the probability of the choice. `None` if nothing can shine there.
    pub(super) fn sample(&self, p: Vec3, n: Option<Vec3>, mut u: f32) -> Option<(usize, f32)> {
        let mut node = self.nodes.first()?;
        let mut pmf = 1.0;
        while !node.is_leaf {
            let children = node.content as usize;
            let left = self.share_of_left(children, p, n)?;
            let (is_left, rest) = split(u, left);
            u = rest;
            pmf *= if is_left { left } else { 1.0 - left };
            node = &self.nodes[if is_left { children } else { children + 1 }];
        }
        Some((node.content as usize, pmf))
    }

    /// Probability with which [`LightTree::sample`] chooses `part`.
    pub(super) fn pmf(&self, p: Vec3, n: Option<Vec3>, part: usize) -> f32 {
        let mut index = self.leaf_of[part];
        if index == NO_LEAF {
            return 0.0;
        }
        let mut pmf = 1.0;
        while index != 0 {
            let parent = self.nodes[index as usize].parent;
            let children = self.nodes[parent as usize].content;
            let Some(left) = self.share_of_left(children as usize, p, n) else {
                return 0.0;
            };
            pmf *= if index == children { left } else { 1.0 - left };
            index = parent;
        }
        pmf
    }

    fn share_of_left(&self, children: usize, p: Vec3, n: Option<Vec3>) -> Option<f32> {
        let (left, right) = (
            self.nodes[children].importance(p, n),
            self.nodes[children + 1].importance(p, n),
        );
        let sum = left + right;
        (sum > 0.0).then(|| left / sum)
    }
}

impl Node {
    fn new(cluster: &Cluster, parent: u32) -> Self {
        let half_angle = cluster.normals.half_angle.max(0.0);
        Node {
            center: cluster.bounds.center(),
            radius: 0.5 * cluster.bounds.extent().length(),
            axis: cluster.normals.axis,
            cos_normals: half_angle.cos(),
            sin_normals: safe_sqrt(1.0 - half_angle.cos().powi(2)),
            cos_emission: cluster.emission.min(PI).cos(),
            power: cluster.power,
            parent,
            content: 0,
            is_leaf: false,
        }
    }

    /// Estimate of what arrives at `p`: power · cosine at the emitter · cosine at the receiver / distance², each cosine the
    /// largest that the bounds allow. 0 only if no direction to `p` is within the range of emission.
    #[inline]
    fn importance(&self, p: Vec3, n: Option<Vec3>) -> f32 {
        let to_center = self.center - p;
        let d2 = to_center.length_squared();
        let r2 = self.radius * self.radius;
        if d2 <= r2 || d2 == 0.0 {
            // Inside the bounding sphere every angle is possible.
            return self.power / r2.max(1e-20);
        }
        let inverse = 1.0 / d2.sqrt();
        let w = to_center * inverse;
        let sin_extent = self.radius * inverse;
        let cos_extent = safe_sqrt(1.0 - sin_extent * sin_extent);

        let at_emitter = -self.axis.dot(w);
        let (cos, sin) = less_angle(
            at_emitter,
            safe_sqrt(1.0 - at_emitter * at_emitter),
            self.cos_normals,
            self.sin_normals,
        );
        let (cos, _) = less_angle(cos, sin, cos_extent, sin_extent);
        if cos < self.cos_emission - COSINE_SLACK {
            return 0.0;
        }
        let mut importance = self.power * cos.max(COSINE_FLOOR) * (inverse * inverse);
        if let Some(n) = n {
            let at_receiver = n.dot(w);
            let sin = safe_sqrt(1.0 - at_receiver * at_receiver);
            importance *= less_angle(at_receiver, sin, cos_extent, sin_extent)
                .0
                .max(COSINE_FLOOR);
        }
        importance
    }
}

/// Cosine and sine of max(0, a - b) from those of a and b, both in [0, π].
#[inline]
fn less_angle(cos_a: f32, sin_a: f32, cos_b: f32, sin_b: f32) -> (f32, f32) {
    if cos_a >= cos_b {
        (1.0, 0.0)
    } else {
        (cos_a * cos_b + sin_a * sin_b, sin_a * cos_b - cos_a * sin_b)
    }
}

impl Builder<'_> {
    /// Builds the node `index` over `items`, children first, and returns what it holds.
    fn fill(&mut self, index: u32, items: &mut [u32], depth: u32) -> Cluster {
        let parent = self.tree.nodes[index as usize].parent;
        if let [part] = *items {
            let cluster = Cluster::of(&self.parts[part as usize]);
            let node = Node {
                content: part,
                is_leaf: true,
                ..Node::new(&cluster, parent)
            };
            self.tree.nodes[index as usize] = node;
            self.tree.leaf_of[part as usize] = index;
            return cluster;
        }
        let middle = self.partition(items, depth);
        let children = self.tree.nodes.len() as u32;
        self.tree
            .nodes
            .extend([Node::new(&Cluster::EMPTY, index); 2]);
        let (left, right) = items.split_at_mut(middle);
        let left = self.fill(children, left, depth + 1);
        let right = self.fill(children + 1, right, depth + 1);
        let cluster = left.union(right);
        self.tree.nodes[index as usize] = Node {
            content: children,
            ..Node::new(&cluster, parent)
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
