//! Top-down construction: sets of lights are split at the plane, in position or normal, at which
//! the two parts cost least.

use super::node::{LightNode, NodeContent};
use crate::ids::LightId;
use crate::math::{Aabb, Cone};
use crate::virtual_lights::{IntensityBound, VirtualLight, VirtualLights};

/// Distance that corresponds to a unit distance between normals, relative to the diagonal of all
/// lights; the factor `c` of Walter et al. 2005, section 3.1. Larger values group lights by
/// orientation rather than by position. At 0.125 and 0.5 (a pass of 4096 lights at 72x40, 3 seeds;
/// Glossy Room, Kitchen): relMSE +2.5 and +1.0 % (standard error 3 %).
const NORMAL_SCALE: f32 = 0.25;
/// Number of bins along the longest axis; the planes between them are the candidates.
const BINS: usize = 16;
/// Depth below which sets are split at the median, which bounds the depth of recursion for any
/// input.
const MEDIAN_SPLIT_DEPTH: u32 = 48;
/// Number of lights above which the two parts are built in parallel.
const PARALLEL: usize = 512;

/// A light during construction.
#[derive(Clone, Copy, Debug)]
struct TreeItem {
    id: LightId,
    flux: f32,
    bounds: Aabb,
    /// See [`LightNode::normals`] and [`LightNode::offset`].
    normals: Cone,
    offset: f32,
    /// Position, in m, and normal scaled by [`NORMAL_SCALE`] times the diagonal.
    at: [f32; 6],
}

/// Bounding box in the space of positions and normals, with the flux inside.
#[derive(Clone, Copy, Debug)]
struct BinBounds {
    low: [f32; 6],
    high: [f32; 6],
    flux: f32,
}

impl BinBounds {
    /// The bounds of no light.
    const EMPTY: BinBounds = BinBounds {
        low: [f32::INFINITY; 6],
        high: [f32::NEG_INFINITY; 6],
        flux: 0.0,
    };

    fn including(mut self, item: &TreeItem) -> Self {
        for (k, &x) in item.at.iter().enumerate() {
            self.low[k] = self.low[k].min(x);
            self.high[k] = self.high[k].max(x);
        }
        self.flux += item.flux;
        self
    }

    fn union(mut self, o: &BinBounds) -> Self {
        for k in 0..6 {
            self.low[k] = self.low[k].min(o.low[k]);
            self.high[k] = self.high[k].max(o.high[k]);
        }
        self.flux += o.flux;
        self
    }

    fn size(&self, axis: usize) -> f32 {
        (self.high[axis] - self.low[axis]).max(0.0)
    }

    /// Flux times the squared diagonal: the metric of Walter et al. 2005, section 3.1, with the
    /// chord between normals instead of their angle.
    fn cost(&self) -> f32 {
        let diagonal2: f32 = (0..6).map(|axis| self.size(axis).powi(2)).sum();
        self.flux * diagonal2
    }
}

/// The nodes of the tree over the lights with flux for which `is_used` is true, in depth-first
/// order.
pub(super) fn nodes(set: &VirtualLights, is_used: impl Fn(LightId) -> bool) -> Vec<LightNode> {
    let lights = set.lights();
    let used = (0..lights.len() as u32).map(LightId).filter(|&id| {
        let flux = lights[id.index()].flux.luminance();
        flux > 0.0 && is_used(id)
    });
    let ids: Vec<LightId> = used.collect();
    if ids.is_empty() {
        return Vec::new();
    }
    let bounds = Aabb::from_points(ids.iter().map(|id| lights[id.index()].p));
    let scale = NORMAL_SCALE * bounds.diagonal();
    let item = |&id: &LightId| TreeItem::new(id, &lights[id.index()], scale);
    let mut items: Vec<TreeItem> = ids.iter().map(item).collect();
    let mut nodes = vec![EMPTY; 2 * items.len() - 1];
    build(set, &mut items, &mut nodes, 0, 0);
    nodes
}

impl TreeItem {
    fn new(id: LightId, light: &VirtualLight, normal_scale: f32) -> Self {
        let (p, n) = (light.p, light.n * normal_scale);
        TreeItem {
            id,
            flux: light.flux.luminance(),
            bounds: Aabb::from_points(light.points).include(p),
            offset: light.offset,
            normals: if light.one_sided {
                Cone::from_axis(light.n)
            } else {
                Cone::FULL
            },
            at: [p.x, p.y, p.z, n.x, n.y, n.z],
        }
    }
}

/// A node before it is filled.
const EMPTY: LightNode = LightNode {
    bounds: Aabb::EMPTY,
    normals: Cone::EMPTY,
    offset: 0.0,
    flux: 0.0,
    intensity: IntensityBound::NONE,
    content: NodeContent::Light(LightId(0)),
};

/// Builds the tree over `items` into `nodes`, the first of which has the index `first` in the tree.
/// Returns the bound of its intensity.
fn build(
    lights: &VirtualLights,
    items: &mut [TreeItem],
    nodes: &mut [LightNode],
    first: u32,
    depth: u32,
) -> IntensityBound {
    if let [item] = items {
        nodes[0] = LightNode {
            bounds: item.bounds,
            normals: item.normals,
            offset: item.offset,
            flux: item.flux,
            content: NodeContent::Light(item.id),
            ..EMPTY
        };
        return IntensityBound::of(lights, item.id);
    }
    let middle = split(items, depth);
    let (left, right) = items.split_at_mut(middle);
    let (node, below) = nodes.split_at_mut(1);
    let (left_nodes, right_nodes) = below.split_at_mut(2 * left.len() - 1);
    let second = first + 1 + left_nodes.len() as u32;
    let is_large = left.len() + right.len() > PARALLEL;
    let mut build_left = || build(lights, left, left_nodes, first + 1, depth + 1);
    let mut build_right = || build(lights, right, right_nodes, second, depth + 1);
    let (mut intensity, other) = if is_large {
        rayon::join(build_left, build_right)
    } else {
        (build_left(), build_right())
    };
    intensity.add(&other);
    let [a, b] = [&left_nodes[0], &right_nodes[0]];
    node[0] = LightNode {
        bounds: a.bounds.union(b.bounds),
        normals: a.normals.union(b.normals),
        offset: a.offset.max(b.offset),
        flux: a.flux + b.flux,
        intensity: intensity.clone(),
        content: NodeContent::Nodes { second },
    };
    intensity
}

/// Partitions the items in place into two non-empty sets; returns the size of the first.
fn split(items: &mut [TreeItem], depth: u32) -> usize {
    let half = items.len() / 2;
    let whole = items.iter().fold(BinBounds::EMPTY, BinBounds::including);
    let axis = (0..6).max_by(|&a, &b| whole.size(a).total_cmp(&whole.size(b)));
    let axis = axis.unwrap_or(0);
    let (low, size) = (whole.low[axis], whole.size(axis));
    if items.len() > 2 && size > 0.0 && depth < MEDIAN_SPLIT_DEPTH {
        let bin_of = |item: &TreeItem| {
            let along = (item.at[axis] - low) / size;
            ((along * BINS as f32) as usize).min(BINS - 1)
        };
        let mut bins = [BinBounds::EMPTY; BINS];
        for item in items.iter() {
            let bin = &mut bins[bin_of(item)];
            *bin = bin.including(item);
        }
        let last = best_plane(&bins);
        let mut first = 0;
        for i in 0..items.len() {
            if bin_of(&items[i]) <= last {
                items.swap(first, i);
                first += 1;
            }
        }
        if (1..items.len()).contains(&first) {
            return first;
        }
    }
    items.select_nth_unstable_by(half, |a, b| {
        a.at[axis].total_cmp(&b.at[axis]).then(a.id.cmp(&b.id))
    });
    half
}

/// The last bin before the plane with the least sum of the costs of both sides.
fn best_plane(bins: &[BinBounds; BINS]) -> usize {
    let mut beyond = [BinBounds::EMPTY; BINS];
    let mut sum = BinBounds::EMPTY;
    for (k, bin) in bins.iter().enumerate().rev() {
        beyond[k] = sum;
        sum = sum.union(bin);
    }
    let (mut best, mut least, mut sum) = (BINS / 2 - 1, f32::INFINITY, BinBounds::EMPTY);
    for (k, bin) in bins[..BINS - 1].iter().enumerate() {
        sum = sum.union(bin);
        if sum.flux == 0.0 || beyond[k].flux == 0.0 {
            continue;
        }
        let cost = sum.cost() + beyond[k].cost();
        if cost < least {
            (best, least) = (k, cost);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    #[test]
    fn sets_are_split_at_gaps() {
        let item = |k: u32, x: f32| TreeItem {
            id: LightId(k),
            flux: 1.0,
            bounds: Aabb::from_points([Vec3::X * x]),
            normals: Cone::FULL,
            offset: 0.0,
            at: [x, 0.0, 0.0, 0.0, 0.0, 0.0],
        };
        let mut items: Vec<TreeItem> = (0..30)
            .map(|k| {
                item(
                    k,
                    if k % 3 == 0 { 0.01 } else { 5.0 } * (1.0 + k as f32 / 100.0),
                )
            })
            .collect();
        assert_eq!(split(&mut items, 0), 10);
        assert!(items[..10].iter().all(|item| item.at[0] < 1.0));
        // All at one position.
        let mut items: Vec<TreeItem> = (0..5).map(|k| item(k, 1.0)).collect();
        assert_eq!(split(&mut items, 0), 2);
    }
}
