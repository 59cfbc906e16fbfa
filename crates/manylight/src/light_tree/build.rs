//! From the top down: a set of lights is divided where its two parts are tightest in place and normal.

use super::{Content, LightTree, Node};
use crate::ids::LightId;
use crate::math::{Aabb, Cone};
use crate::virtual_lights::{IntensityBound, VirtualLight, VirtualLights};

/// Normals count as places at this part of the diagonal of all lights.
const NORMAL_SCALE: f32 = 0.25;
/// Candidate planes across the widest extent.
const BINS: usize = 16;
/// Below this depth sets are halved, so that no input makes the recursion deep.
const HALVED_BELOW: u32 = 48;
/// Sets larger than this are built by two threads.
const PARALLEL: usize = 512;

/// A light on its way into the tree.
#[derive(Clone, Copy, Debug)]
struct Item {
    id: LightId,
    flux: f32,
    bounds: Aabb,
    /// See [`Node::normals`] and [`Node::offset`].
    normals: Cone,
    offset: f32,
    /// Place and scaled normal.
    at: [f32; 6],
}

/// A box in the space of places and normals.
#[derive(Clone, Copy, Debug)]
struct Extent {
    low: [f32; 6],
    high: [f32; 6],
    flux: f32,
}

impl Extent {
    const EMPTY: Extent = Extent {
        low: [f32::INFINITY; 6],
        high: [f32::NEG_INFINITY; 6],
        flux: 0.0,
    };

    fn including(mut self, item: &Item) -> Self {
        for (k, &x) in item.at.iter().enumerate() {
            self.low[k] = self.low[k].min(x);
            self.high[k] = self.high[k].max(x);
        }
        self.flux += item.flux;
        self
    }

    fn union(mut self, o: &Extent) -> Self {
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

    /// Flux times the squared diagonal: the metric of the source, section 3.1, with the chord between normals for their angle.
    fn cost(&self) -> f32 {
        let diagonal2: f32 = (0..6).map(|axis| self.size(axis).powi(2)).sum();
        self.flux * diagonal2
    }
}

impl LightTree {
    /// The tree over those of the lights that `is_used` names and that have flux.
    pub fn new(field: &VirtualLights, is_used: impl Fn(LightId) -> bool) -> Self {
        let lights = field.lights();
        let used = (0..lights.len() as u32).map(LightId).filter(|&id| {
            let flux = lights[id.index()].flux.luminance();
            flux > 0.0 && is_used(id)
        });
        let ids: Vec<LightId> = used.collect();
        if ids.is_empty() {
            return LightTree::default();
        }
        let places = Aabb::from_points(ids.iter().map(|id| lights[id.index()].p));
        let scale = NORMAL_SCALE * places.diagonal();
        let item = |&id: &LightId| Item::new(id, &lights[id.index()], scale);
        let mut items: Vec<Item> = ids.iter().map(item).collect();
        let mut nodes = vec![Node::EMPTY; 2 * items.len() - 1];
        build(field, &mut items, &mut nodes, 0, 0);
        LightTree { nodes }
    }
}

impl Item {
    fn new(id: LightId, light: &VirtualLight, normal_scale: f32) -> Self {
        let (p, n) = (light.p, light.n * normal_scale);
        Item {
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

impl Node {
    const EMPTY: Node = Node {
        bounds: Aabb::EMPTY,
        normals: Cone::EMPTY,
        offset: 0.0,
        flux: 0.0,
        intensity: IntensityBound::NONE,
        content: Content::Light(LightId(0)),
    };
}

/// Fills `nodes`, of which the first has index `first`; returns what the lights shine.
fn build(
    field: &VirtualLights,
    items: &mut [Item],
    nodes: &mut [Node],
    first: u32,
    depth: u32,
) -> IntensityBound {
    if let [item] = items {
        nodes[0] = Node {
            bounds: item.bounds,
            normals: item.normals,
            offset: item.offset,
            flux: item.flux,
            content: Content::Light(item.id),
            ..Node::EMPTY
        };
        return field.intensity_bound(item.id);
    }
    let middle = divide(items, depth);
    let (left, right) = items.split_at_mut(middle);
    let (node, below) = nodes.split_at_mut(1);
    let (left_nodes, right_nodes) = below.split_at_mut(2 * left.len() - 1);
    let second = first + 1 + left_nodes.len() as u32;
    let is_large = left.len() + right.len() > PARALLEL;
    let mut build_left = || build(field, left, left_nodes, first + 1, depth + 1);
    let mut build_right = || build(field, right, right_nodes, second, depth + 1);
    let (mut intensity, other) = if is_large {
        rayon::join(build_left, build_right)
    } else {
        (build_left(), build_right())
    };
    intensity.add(&other);
    let [a, b] = [&left_nodes[0], &right_nodes[0]];
    node[0] = Node {
        bounds: a.bounds.union(b.bounds),
        normals: a.normals.union(b.normals),
        offset: a.offset.max(b.offset),
        flux: a.flux + b.flux,
        intensity: intensity.clone(),
        content: Content::Nodes { second },
    };
    intensity
}

/// Sorts the items into two sets that are not empty; returns the length of the first.
fn divide(items: &mut [Item], depth: u32) -> usize {
    let half = items.len() / 2;
    let whole = items.iter().fold(Extent::EMPTY, Extent::including);
    let axis = (0..6).max_by(|&a, &b| whole.size(a).total_cmp(&whole.size(b)));
    let axis = axis.unwrap_or(0);
    let (low, size) = (whole.low[axis], whole.size(axis));
    if items.len() > 2 && size > 0.0 && depth < HALVED_BELOW {
        let bin_of = |item: &Item| {
            let along = (item.at[axis] - low) / size;
            ((along * BINS as f32) as usize).min(BINS - 1)
        };
        let mut bins = [Extent::EMPTY; BINS];
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

/// The last bin before the plane at which both sides cost least.
fn best_plane(bins: &[Extent; BINS]) -> usize {
    let mut beyond = [Extent::EMPTY; BINS];
    let mut sum = Extent::EMPTY;
    for (k, bin) in bins.iter().enumerate().rev() {
        beyond[k] = sum;
        sum = sum.union(bin);
    }
    let (mut best, mut least, mut sum) = (BINS / 2 - 1, f32::INFINITY, Extent::EMPTY);
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
    fn sets_fall_apart_at_gaps() {
        let item = |k: u32, x: f32| Item {
            id: LightId(k),
            flux: 1.0,
            bounds: Aabb::from_points([Vec3::X * x]),
            normals: Cone::FULL,
            offset: 0.0,
            at: [x, 0.0, 0.0, 0.0, 0.0, 0.0],
        };
        let mut items: Vec<Item> = (0..30)
            .map(|k| {
                item(
                    k,
                    if k % 3 == 0 { 0.01 } else { 5.0 } * (1.0 + k as f32 / 100.0),
                )
            })
            .collect();
        assert_eq!(divide(&mut items, 0), 10);
        assert!(items[..10].iter().all(|item| item.at[0] < 1.0));
        // All in one place.
        let mut items: Vec<Item> = (0..5).map(|k| item(k, 1.0)).collect();
        assert_eq!(divide(&mut items, 0), 2);
    }
}
