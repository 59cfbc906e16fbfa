//! Streams of rays: groups of sixteen rays descend together, and the last rays of a group alone.

use super::beam::range;
use super::build::MAX_DEPTH;
use super::node::LEAF;
use super::ray_lanes::{AlignedLanes, CLASSES, RayLanes, class};
use super::traverse;
use super::triangle_block::{TreeParts, TriangleBlock, TriangleHit};
use super::watertight::{AnyTriangle, NearestHit, NearestTriangle, REACH_MARGIN};
use crate::geometry::{Ray, Segment};
use crate::lanes::{Float, LANES, Lanes3, Mask};
use crate::math::{Vec2, Vec3};
use crate::simd::{NARROW, Simd, set_bits};
use std::cell::Cell;

/// Largest number of rays of a group that are traced singly. Set by the sets of tiles of
/// `benches/visibility`: 4 costs late rays of staircase2 5 % of their rate, 8 costs its camera rays
/// 30 %.
const FEW: u32 = 6;

/// Largest number of rays of a group that are tested one by one against all triangles of a leaf.
/// From 3 to 8 the rates differ by 3 %.
const FEW_IN_LEAF: u32 = 6;

/// Largest number of children of a node in reach of a group for which the group is known to be
/// narrow: it descends into inner children without tests of its rays. A ray that enters a leaf
/// enters the nodes above it, so that the test before the leaf suffices. With 1 shadow rays are
/// slower by up to 20 %, with 3 or 4 bounces in kitchen by 5 to 15 %.
const NARROW_BEAM: u32 = 2;

/// Entries of a stack: each level pops one and pushes at most eight.
const CAPACITY: usize = (NARROW - 1) * MAX_DEPTH + 1;

/// Indices of a list of directions, sorted by [`class`], each class in the order of the list.
struct ByClass {
    indices: Vec<u32>,
    /// End of each class in `indices`.
    ends: [usize; CLASSES],
}

impl ByClass {
    fn new(directions: impl ExactSizeIterator<Item = Vec3> + Clone) -> Self {
        let mut ends = [0; CLASSES];
        let classes: Vec<u8> = directions.map(|d| class(d) as u8).collect();
        for &class in &classes {
            ends[class as usize] += 1;
        }
        let mut sum = 0;
        for end in &mut ends {
            (*end, sum) = (sum, sum + *end);
        }
        let mut indices = vec![0; classes.len()];
        for (i, &class) in (0..).zip(&classes) {
            let place = &mut ends[class as usize];
            indices[*place] = i;
            *place += 1;
        }
        ByClass { indices, ends }
    }

    /// Groups of up to sixteen indices of one class, with the class.
    fn groups(&self) -> impl Iterator<Item = (usize, &[u32])> {
        (0..CLASSES).flat_map(|class| {
            let first = class.checked_sub(1).map_or(0, |before| self.ends[before]);
            let indices = &self.indices[first..self.ends[class]];
            indices.chunks(LANES).map(move |group| (class, group))
        })
    }
}

/// Rays of a group in lanes: origins and directions.
#[inline(always)]
fn in_lanes(group: &[u32], ray: impl Fn(usize) -> (Vec3, Vec3)) -> [Lanes3; 2] {
    let mut lanes = [Lanes3::ZERO; 2];
    for lane in 0..LANES {
        let index = group[lane.min(group.len() - 1)];
        let (origin, direction) = ray(index as usize);
        lanes[0].set(lane, origin);
        lanes[1].set(lane, direction);
    }
    lanes
}

/// Bits of the first `count` lanes.
fn first_lanes(count: usize) -> u32 {
    (1 << count) - 1
}

/// The nearest hits so far of sixteen rays; see [`NearestHit`].
struct NearestLanes {
    t: AlignedLanes,
    /// The bits of the indices.
    ids: AlignedLanes,
    is_hit: u32,
    weights: [AlignedLanes; 3],
    reach: AlignedLanes,
    /// Largest `reach` of any ray.
    farthest: f32,
}

/// The nearest hits of up to sixteen rays.
pub(in crate::geometry) struct LaneHits {
    is_hit: u32,
    t: AlignedLanes,
    /// The bits of the indices.
    ids: AlignedLanes,
    coordinates: [AlignedLanes; 2],
}

impl LaneHits {
    /// The hit of the ray in `lane`.
    #[inline(always)]
    pub(in crate::geometry) fn get(&self, lane: usize) -> Option<TriangleHit> {
        let [x, y] = &self.coordinates;
        (self.is_hit >> lane & 1 != 0).then(|| TriangleHit {
            t: self.t.0[lane],
            id: self.ids.0[lane].to_bits(),
            coordinates: Vec2::new(x.0[lane], y.0[lane]),
        })
    }
}

/// Finds the nearest hit of each ray of a stream. Calls `found` with the indices of up to sixteen
/// rays, and their hits in lanes.
#[inline(always)]
pub(super) fn nearest_stream<S: Simd>(
    s: S,
    tree: TreeParts,
    rays: &[Ray],
    mut found: impl FnMut(&[u32], &LaneHits),
) {
    let order = ByClass::new(rays.iter().map(|ray| ray.d));
    let mut stack = STACK
        .take()
        .unwrap_or_else(|| Box::new(NearestStack::new()));
    for (class, group) in order.groups() {
        let best = nearest_of_group(s, tree, &mut stack, class, group, rays);
        found(group, &best.hits(s));
    }
    STACK.set(Some(stack));
}

thread_local! {
    /// What a thread takes from stream to stream: 16 kB, which small streams need not clear.
    static STACK: Cell<Option<Box<NearestStack>>> = const { Cell::new(None) };
}

/// Subtrees to visit with the parameters at which the rays of a group enter them, infinite for rays
/// that do not.
struct NearestStack {
    words: [u32; CAPACITY],
    near: [AlignedLanes; CAPACITY],
}

impl NearestStack {
    fn new() -> Self {
        NearestStack {
            words: [0; CAPACITY],
            near: [AlignedLanes::ZERO; CAPACITY],
        }
    }
}

#[inline(always)]
fn nearest_of_group<S: Simd>(
    s: S,
    tree: TreeParts,
    stack: &mut NearestStack,
    class: usize,
    group: &[u32],
    rays: &[Ray],
) -> NearestLanes {
    let w = s.wide();
    let [o, d] = in_lanes(group, |i| (rays[i].o, rays[i].d));
    let lanes = RayLanes::new(w, class, &o, &d);
    let mut best = NearestLanes {
        // Unused lanes enter no box.
        t: AlignedLanes(std::array::from_fn(|lane| {
            group
                .get(lane)
                .map_or(f32::NEG_INFINITY, |&i| rays[i as usize].t_max)
        })),
        ids: AlignedLanes::ZERO,
        is_hit: 0,
        weights: [AlignedLanes::ZERO; 3],
        reach: AlignedLanes::ZERO,
        farthest: f32::INFINITY,
    };
    best.reach = AlignedLanes::of(best.t.load(w) * REACH_MARGIN);
    best.trace(s, tree, stack, &lanes);
    best
}

impl NearestLanes {
    /// The hits, with the coordinates by the operations of [`NearestHit::hit`].
    #[inline(always)]
    fn hits<S: Simd>(&self, s: S) -> LaneHits {
        let w = s.wide();
        let [y, z, sum] = &self.weights;
        let sum = sum.load(w);
        LaneHits {
            is_hit: self.is_hit,
            t: self.t,
            ids: self.ids,
            coordinates: [
                AlignedLanes::of(y.load(w) / sum),
                AlignedLanes::of(z.load(w) / sum),
            ],
        }
    }

    #[inline(always)]
    fn single(&self, lane: usize) -> NearestHit {
        NearestHit {
            t: self.t.0[lane],
            id: (self.is_hit >> lane & 1 != 0).then_some(self.ids.0[lane].to_bits()),
            weights: [
                self.weights[0].0[lane],
                self.weights[1].0[lane],
                self.weights[2].0[lane],
            ],
        }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, hit: &NearestHit) {
        if let Some(id) = hit.id {
            self.t.0[lane] = hit.t;
            self.ids.0[lane] = f32::from_bits(id);
            self.is_hit |= 1 << lane;
            self.reach.0[lane] = hit.reach();
            for i in 0..3 {
                self.weights[i].0[lane] = hit.weights[i];
            }
        }
    }

    #[inline(always)]
    fn trace<S: Simd>(
        &mut self,
        s: S,
        tree: TreeParts,
        stack: &mut NearestStack,
        lanes: &RayLanes,
    ) {
        let w = s.wide();
        let mut top = 1;
        stack.words[0] = 0;
        stack.near[0] = AlignedLanes::ZERO;
        while top > 0 {
            top -= 1;
            let (word, near) = (stack.words[top], stack.near[top].load(w));
            let reach = self.reach.load(w);
            let active = near.lt(reach).bits();
            if active == 0 {
                continue;
            }
            if word & LEAF != 0 {
                self.test_leaf(s, &tree.blocks[(word & !LEAF) as usize], lanes, active);
                continue;
            }
            if active.count_ones() <= FEW {
                for lane in set_bits(active).map(|lane| lane % LANES) {
                    let (slabs, sheared) = lanes.single(lane);
                    let best = self.single(lane);
                    let mut leaves = NearestTriangle::new(tree.blocks, sheared, best);
                    traverse::nearest(s, tree.nodes, word, &slabs, best.reach(), &mut leaves);
                    self.set(lane, &leaves.best);
                }
                continue;
            }
            let node = &tree.nodes[word as usize];
            let order = lanes.order(node);
            let (first, last) = lanes.beam.cut_node(s, node, self.farthest);
            let met = first.le(last).bits();
            let reach = Mask::from_bits(w, active).select(reach, f32::NEG_INFINITY);
            let is_narrow = met.count_ones() <= NARROW_BEAM;
            for place in 0..NARROW {
                let lane = (order >> (3 * place) & 7) as usize;
                if met >> lane & 1 == 0 {
                    continue;
                }
                if is_narrow && node.children[lane] & LEAF == 0 {
                    stack.words[top] = node.children[lane];
                    stack.near[top] = AlignedLanes::of(near);
                    top += 1;
                    continue;
                }
                let (enter, entering) = lanes.enter(node, lane, reach);
                if entering != 0 {
                    stack.words[top] = node.children[lane];
                    let enter = Mask::from_bits(w, entering).select(enter, f32::INFINITY);
                    stack.near[top] = AlignedLanes::of(enter);
                    top += 1;
                }
            }
        }
    }

    #[inline(always)]
    fn test_leaf<S: Simd>(&mut self, s: S, block: &TriangleBlock, lanes: &RayLanes, rays: u32) {
        if rays.count_ones() <= FEW_IN_LEAF {
            for lane in set_bits(rays).map(|lane| lane % LANES) {
                let mut best = self.single(lane);
                lanes.sheared(lane).nearest(s, block, &mut best);
                self.set(lane, &best);
            }
            return;
        }
        let w = s.wide();
        let mut is_nearer = false;
        for place in set_bits(lanes.beam.meets(s, block, self.farthest)) {
            let place = place % NARROW;
            let reach = self.reach.load(w);
            let Some(crossing) = lanes.cross(block, place, rays, reach) else {
                continue;
            };
            let found = crossing.hit.bits() & rays;
            if found == 0 {
                continue;
            }
            let distance = crossing.distances();
            let (t, id) = (self.t.load(w), block.ids[place]);
            let mut nearer = distance.lt(t).bits() & found;
            let equal = distance.le(t).bits() & found & !nearer & self.is_hit;
            for lane in set_bits(equal).map(|lane| lane % LANES) {
                nearer |= u32::from(id < self.ids.0[lane].to_bits()) << lane;
            }
            let m = Mask::from_bits(w, nearer);
            self.t = AlignedLanes::of(m.select(distance, t));
            self.reach = AlignedLanes::of(m.select(distance * REACH_MARGIN, reach));
            self.ids = AlignedLanes::of(m.select(f32::from_bits(id), self.ids.load(w)));
            let weights = [crossing.edges[1], crossing.edges[2], crossing.det];
            for (own, weight) in self.weights.iter_mut().zip(weights) {
                *own = AlignedLanes::of(m.select(weight, own.load(w)));
            }
            self.is_hit |= nearer;
            is_nearer |= nearer != 0;
        }
        if is_nearer {
            self.farthest = range(&self.reach.0).1;
        }
    }
}

/// Finds for each segment of a stream whether a triangle cuts it.
#[inline(always)]
pub(super) fn any_stream<S: Simd>(
    s: S,
    tree: TreeParts,
    segments: &[Segment],
    blocked: &mut [bool],
) {
    let order = ByClass::new(segments.iter().map(|segment| segment.to - segment.from));
    let mut stack = [(0, 0); CAPACITY];
    for (class, group) in order.groups() {
        let ray = |i: usize| (segments[i].from, segments[i].to - segments[i].from);
        let [o, d] = in_lanes(group, ray);
        let lanes = RayLanes::new(s.wide(), class, &o, &d);
        let all = first_lanes(group.len());
        let open = open_of_group(s, tree, &mut stack, &lanes, all);
        for (lane, &index) in group.iter().enumerate() {
            blocked[index as usize] = open >> lane & 1 == 0;
        }
    }
}

/// The subset of `rays` that no triangle blocks.
#[inline(always)]
fn open_of_group<S: Simd>(
    s: S,
    tree: TreeParts,
    stack: &mut [(u32, u32); CAPACITY],
    lanes: &RayLanes,
    rays: u32,
) -> u32 {
    let w = s.wide();
    let mut open = rays;
    let mut top = 1;
    stack[0] = (0, rays);
    while top > 0 && open != 0 {
        top -= 1;
        let (word, active) = stack[top];
        let active = active & open;
        if active == 0 {
            continue;
        }
        if word & LEAF != 0 {
            let block = &tree.blocks[(word & !LEAF) as usize];
            open &= !blocked_in_leaf(s, block, lanes, active);
            continue;
        }
        if active.count_ones() <= FEW {
            for lane in set_bits(active).map(|lane| lane % LANES) {
                let (slabs, sheared) = lanes.single(lane);
                let leaves = AnyTriangle::sheared(tree.blocks, sheared);
                if traverse::any(s, tree.nodes, word, &slabs, &leaves) {
                    open &= !(1 << lane);
                }
            }
            continue;
        }
        let node = &tree.nodes[word as usize];
        let (near, far) = lanes.beam.cut_node(s, node, 1.0);
        let met = near.le(far).bits();
        let is_narrow = met.count_ones() <= NARROW_BEAM;
        for lane in set_bits(met) {
            let lane = lane % NARROW;
            if is_narrow && node.children[lane] & LEAF == 0 {
                stack[top] = (node.children[lane], active);
                top += 1;
                continue;
            }
            let (_, entering) = lanes.enter(node, lane, Float::splat(w, 1.0));
            if entering & active != 0 {
                stack[top] = (node.children[lane], entering & active);
                top += 1;
            }
        }
    }
    open
}

/// The subset of `rays` that a triangle of the leaf blocks.
#[inline(always)]
fn blocked_in_leaf<S: Simd>(s: S, block: &TriangleBlock, lanes: &RayLanes, rays: u32) -> u32 {
    let mut blocked = 0;
    if rays.count_ones() <= FEW_IN_LEAF {
        for lane in set_bits(rays).map(|lane| lane % LANES) {
            blocked |= u32::from(lanes.sheared(lane).any(s, block)) << lane;
        }
        return blocked;
    }
    let w = s.wide();
    for place in set_bits(lanes.beam.meets(s, block, 1.0)) {
        let place = place % NARROW;
        let limit = Float::splat(w, 1.0);
        let Some(crossing) = lanes.cross(block, place, rays & !blocked, limit) else {
            continue;
        };
        blocked |= crossing.hit.bits() & rays;
        if blocked == rays {
            break;
        }
    }
    blocked
}
