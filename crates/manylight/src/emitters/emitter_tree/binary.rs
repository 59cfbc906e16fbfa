//! The binary tree over emitter elements, built top-down with the surface area orientation
//! heuristic.

use crate::emitters::elements::ElementBounds;
use crate::math::{Aabb, Cone, Vec3, float::safe_sqrt};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// Candidate planes per axis and split, plus one. In the Garage, 6 has 1.04 of the variance of path
/// tracing, 24 has 0.99.
const BINS: usize = 12;

/// Most elements of a node that are put into bins to find its plane: a bound on the time for large
/// nodes. In the Garage, 256 has 1.00 of the variance of path tracing, 4096 has 0.99.
const MAX_BINNED_ELEMENTS: usize = 1024;

/// Depth from which nodes are halved by number of elements, which bounds the depth of the recursion
/// for all inputs.
const BALANCED_DEPTH: u32 = 48;

/// Area of a box over its squared diagonal, at least: lines and pairs of points have a cost as
/// well.
const MIN_RELATIVE_AREA: f32 = 1e-3;

/// Lower bound of the direction measure in sr: parallel emission has a cost as well.
const MIN_DIRECTION_MEASURE: f32 = 1e-3;

/// A node of the binary tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClusterNode {
    /// Center of the bounding sphere of the bounding box.
    pub(super) center: Vec3,
    /// Its radius.
    pub(super) radius: f32,
    /// Axis of the cone of normals.
    pub(super) axis: Vec3,
    /// Cosine and sine of its half-angle.
    pub(super) cos_normals: f32,
    pub(super) sin_normals: f32,
    /// Cosine of the largest angle between a direction of emission and the nearest normal.
    pub(super) cos_emission: f32,
    /// Selection weight of the emitted flux.
    pub(super) power: f32,
    /// Index of the first of two neighboring children, or of the element of a leaf.
    pub(super) content: u32,
    pub(super) is_leaf: bool,
}

/// Bounds of a set of elements.
#[derive(Clone, Copy, Debug)]
struct ClusterBounds {
    bounds: Aabb,
    normals: Cone,
    emission: f32,
    power: f32,
}

/// The nodes of a tree over the `items` (indices into `elements`, not empty), the root first.
pub(super) fn build(elements: &[ElementBounds], items: &mut [u32]) -> Vec<ClusterNode> {
    let mut builder = BinaryTreeBuilder {
        elements,
        nodes: vec![ClusterNode::new(&ClusterBounds::EMPTY)],
    };
    builder.fill(0, items, 0);
    builder.nodes
}

impl ClusterNode {
    fn new(cluster: &ClusterBounds) -> Self {
        let half_angle = cluster.normals.half_angle.max(0.0);
        ClusterNode {
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

impl ClusterBounds {
    /// A node without elements.
    const EMPTY: ClusterBounds = ClusterBounds {
        bounds: Aabb::EMPTY,
        normals: Cone::EMPTY,
        emission: 0.0,
        power: 0.0,
    };

    fn of(element: &ElementBounds) -> Self {
        ClusterBounds {
            bounds: element.bounds,
            normals: element.normals,
            emission: element.emission,
            power: element.power.selection_weight(),
        }
    }

    fn union(self, o: ClusterBounds) -> Self {
        ClusterBounds {
            bounds: self.bounds.union(o.bounds),
            normals: self.normals.union(o.normals),
            emission: self.emission.max(o.emission),
            power: self.power + o.power,
        }
    }

    /// Power times area times direction measure: Conty Estevez and Kulla 2018, eq. (2), without the
    /// regularization.
    fn cost(&self) -> f32 {
        if self.bounds.is_empty() {
            return 0.0;
        }
        let area = self
            .bounds
            .area()
            .max(MIN_RELATIVE_AREA * self.bounds.extent().length_squared());
        self.power * self.direction_measure() * area
    }

    /// Solid angle of the directions of emission, weighted by the cosine to the nearest normal; eq.
    /// (1) of the source.
    fn direction_measure(&self) -> f32 {
        let o = self.normals.half_angle.max(0.0);
        let w = (o + self.emission).min(PI);
        let rim = 2.0 * w * o.sin() - (o - 2.0 * w).cos() - 2.0 * o * o.sin() + o.cos();
        (TAU * (1.0 - o.cos()) + FRAC_PI_2 * rim).max(MIN_DIRECTION_MEASURE)
    }
}

struct BinaryTreeBuilder<'a> {
    elements: &'a [ElementBounds],
    nodes: Vec<ClusterNode>,
}

impl BinaryTreeBuilder<'_> {
    /// Fills the node `index` and its subtree from `items`. Returns the bounds of the items.
    fn fill(&mut self, index: u32, items: &mut [u32], depth: u32) -> ClusterBounds {
        if let [element] = *items {
            let cluster = ClusterBounds::of(&self.elements[element as usize]);
            let node = ClusterNode {
                content: element,
                is_leaf: true,
                ..ClusterNode::new(&cluster)
            };
            self.nodes[index as usize] = node;
            return cluster;
        }
        let middle = self.partition(items, depth);
        let children = self.nodes.len() as u32;
        self.nodes
            .extend([ClusterNode::new(&ClusterBounds::EMPTY); 2]);
        let (left, right) = items.split_at_mut(middle);
        let left = self.fill(children, left, depth + 1);
        let right = self.fill(children + 1, right, depth + 1);
        let cluster = left.union(right);
        self.nodes[index as usize] = ClusterNode {
            content: children,
            ..ClusterNode::new(&cluster)
        };
        cluster
    }

    /// Reorders `items` and returns the number of those of the left child: at least one, and not
    /// all.
    fn partition(&self, items: &mut [u32], depth: u32) -> usize {
        let center = |i: u32| self.elements[i as usize].bounds.center();
        let centers = Aabb::from_points(items.iter().map(|&i| center(i)));
        let half = items.len() / 2;
        if depth >= BALANCED_DEPTH || items.len() == 2 {
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

    /// The axis, and the bin before which to split, with the lowest cost.
    fn best_plane(&self, items: &[u32], centers: Aabb) -> Option<(usize, usize)> {
        let extent = centers.extent();
        let stride = items.len().div_ceil(MAX_BINNED_ELEMENTS);
        let mut best = None;
        let mut best_cost = f32::INFINITY;
        for axis in (0..3).filter(|&axis| extent[axis] > 0.0) {
            let mut bins = [ClusterBounds::EMPTY; BINS];
            for &i in items.iter().step_by(stride) {
                let element = &self.elements[i as usize];
                let b = bin(element.bounds.center()[axis], axis, centers);
                bins[b] = bins[b].union(ClusterBounds::of(element));
            }
            // The regularization of the source, against long thin boxes.
            let regularization = extent.max_element() / extent[axis];
            // Suffix unions: the bins at and beyond each plane.
            let mut beyond = bins;
            for plane in (0..BINS - 1).rev() {
                beyond[plane] = bins[plane].union(beyond[plane + 1]);
            }
            let mut left = ClusterBounds::EMPTY;
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

/// The bin of the coordinate `x`, among bins over the bounding box of the centers.
fn bin(x: f32, axis: usize, centers: Aabb) -> usize {
    let fraction = (x - centers.min[axis]) / centers.extent()[axis];
    ((fraction * BINS as f32) as usize).min(BINS - 1)
}
