//! Visibility between up to 64 points and up to 64 lights: 4096 segments at once.
//!
//! Four by four groups of sixteen span sixteen shafts, one per lane of a wide vector. A walk through the tree keeps for each
//! subtree the shafts that meet it, and settles triangles against whole shafts, rows and single segments in turn ([`Rows`]).
//! A subtree of many triangles that is smaller than the shafts would be tested by all of them: such subtrees wait, and packets
//! from the points or from the lights, whichever are narrower there, deal with the segments that are still open then.

use super::build::{LEAF, MAX_DEPTH, WideNode};
use super::packet::{EMPTY_STACK, Packet, Targets};
use super::rows::{EndGroups, GROUPS, LeafTriangles, Rows};
use super::shaft::{Shaft, Shafts};
use super::triangles::TriangleBlock;
use crate::math::bits::transpose;
use crate::math::{Aabb, Vec3};
use crate::simd::{NARROW, Simd, WIDE};

/// Points, and lights.
pub(super) const SIDE: usize = 64;

/// Room for the subtrees that wait; more of them do not.
const WAITING: usize = 128;

/// A subtree waits only if it holds so many triangles,
const MANY: f32 = 16.0;

/// and its share of the shafts' cross-section is smaller than its number of triangles over this. Both measured.
const CROWD: f32 = 128.0;

const CAPACITY: usize = (NARROW - 1) * MAX_DEPTH + 1;

/// Subtrees with the shafts that meet them.
struct Waiting {
    len: usize,
    subtrees: [(u32, u32); WAITING],
}

/// The segments between points and lights.
pub(super) struct VisibilityTile<'a> {
    nodes: &'a [WideNode],
    blocks: &'a [TriangleBlock],
    points: &'a [Vec3],
    lights: &'a [Vec3],
    shaft: Shaft,
    shafts: Shafts,
    rows: Rows,
    /// Mean half extents of the groups, at the points and at the lights.
    half: [Vec3; 2],
    /// Extents of all points, and of all lights.
    spread: [f32; 2],
    /// By whether the packets start at the lights.
    waiting: [Waiting; 2],
}

impl<'a> VisibilityTile<'a> {
    /// `wanted` has one mask of lights per point, at least one of them not zero.
    #[inline(always)]
    pub(super) fn new<S: Simd>(
        s: S,
        (nodes, blocks): (&'a [WideNode], &'a [TriangleBlock]),
        (points, lights): (&'a [Vec3], &'a [Vec3]),
        wanted: &[u64],
    ) -> Self {
        let (mut used_points, mut used_lights) = (0u64, 0);
        for (i, &mask) in wanted.iter().enumerate() {
            used_points |= u64::from(mask != 0) << i;
            used_lights |= mask;
        }
        let (p, l) = (
            EndGroups::new(points, used_points),
            EndGroups::new(lights, used_lights),
        );
        let waiting = || Waiting {
            len: 0,
            subtrees: [(0, 0); WAITING],
        };
        VisibilityTile {
            nodes,
            blocks,
            points,
            lights,
            shaft: Shaft::new(p.all, l.all),
            shafts: Shafts::new(s, &p.bounds, &l.bounds, (p.all, l.all)),
            half: [p.mean_half(), l.mean_half()],
            spread: [p.all.diagonal(), l.all.diagonal()],
            rows: Rows::new(s, p, l, wanted),
            waiting: [waiting(), waiting()],
        }
    }

    /// For each point the lights among the wanted ones that are not blocked.
    #[inline(always)]
    pub(super) fn trace<S: Simd>(mut self, s: S) -> [u64; SIDE] {
        self.walk(s);
        let mut open = self.rows.open_by_point();
        if self.waiting[0].len > 0 {
            self.trace_packets(s, 0, &mut open);
        }
        if self.waiting[1].len > 0 {
            transpose(&mut open);
            self.trace_packets(s, 1, &mut open);
            transpose(&mut open);
        }
        open
    }

    #[inline(always)]
    fn walk<S: Simd>(&mut self, s: S) {
        let mut stack = [(0u32, 0u32); CAPACITY];
        let mut top = 1;
        stack[0] = (0, u32::MAX);
        while top > 0 {
            top -= 1;
            let (word, shafts) = stack[top];
            let shafts = shafts & self.rows.active;
            if shafts == 0 {
                continue;
            }
            if word & LEAF != 0 {
                self.test_leaf(s, (word & !LEAF) as usize, shafts);
                continue;
            }
            let node = &self.nodes[word as usize];
            let (near, far, mut children) = self.shaft.cut(s, &node.bounds);
            let (near, far) = (s.store(near), s.store(far));
            while children != 0 {
                let lane = children.trailing_zeros() as usize % NARROW;
                children &= children - 1;
                let b = &node.bounds;
                let planes = [
                    b[0][lane], b[1][lane], b[2][lane], b[3][lane], b[4][lane], b[5][lane],
                ];
                let shafts = self.shafts.meeting(s, planes) & shafts;
                if shafts == 0 {
                    continue;
                }
                let child = node.children[lane];
                let t = 0.5 * (near[lane] + far[lane]);
                if child & LEAF == 0
                    && self.is_dense(node.items_below(lane), node.child_bounds(lane), t)
                {
                    // Packets are as narrow there as the ends that they lead to, times the distance from where they start.
                    let from_lights = (1.0 - t) * self.spread[0] < t * self.spread[1];
                    let waiting = &mut self.waiting[usize::from(from_lights)];
                    if waiting.len < WAITING {
                        waiting.subtrees[waiting.len] = (child, shafts);
                        waiting.len += 1;
                        continue;
                    }
                }
                stack[top] = (child, shafts);
                top += 1;
            }
        }
    }

    /// Whether many triangles stand in a small part of a shaft's cross-section.
    #[inline(always)]
    fn is_dense(&self, triangles: f32, bounds: Aabb, t: f32) -> bool {
        if triangles < MANY {
            return false;
        }
        let half = 0.5 * (bounds.max - bounds.min);
        let shaft = self.half[0] + (self.half[1] - self.half[0]) * t;
        let area = |v: Vec3| v.x * v.y + v.y * v.z + v.z * v.x;
        area(half) * CROWD < area(shaft) * triangles
    }

    #[inline(always)]
    fn test_leaf<S: Simd>(&mut self, s: S, leaf: usize, shafts: u32) {
        let block = &self.blocks[leaf];
        let (bounds, met) = {
            let bounds = block_bounds(s, block);
            let (_, _, met) = self.shaft.cut(s, &bounds);
            (bounds, met)
        };
        if met == 0 {
            return;
        }
        let triangles = LeafTriangles::new(s, block, self.rows.origin);
        let mut crossed = met & self.rows.crossed(s, &triangles);
        while crossed != 0 {
            let lane = crossed.trailing_zeros() as usize % NARROW;
            crossed &= crossed - 1;
            let planes = [
                bounds[0][lane],
                bounds[1][lane],
                bounds[2][lane],
                bounds[3][lane],
                bounds[4][lane],
                bounds[5][lane],
            ];
            let shafts = self.shafts.meeting(s, planes) & shafts & self.rows.active;
            if shafts != 0 {
                self.rows.block(s.wide(), &triangles, lane, shafts);
            }
        }
    }

    /// One packet per point, or per light with `role` 1: `open` has one mask for each of them.
    #[inline(always)]
    fn trace_packets<S: Simd>(&self, s: S, role: usize, open: &mut [u64; SIDE]) {
        let (from, to) = if role == 0 {
            (self.points, self.lights)
        } else {
            (self.lights, self.points)
        };
        let waiting = &self.waiting[role];
        let targets = Targets::new(to);
        let mut stack = EMPTY_STACK;
        for (i, (&from, open)) in from.iter().zip(open).enumerate() {
            if *open == 0 {
                continue;
            }
            let tree = (self.nodes, self.blocks);
            let mut packet = Packet::new(s, tree, from, &targets, *open);
            for &(word, shafts) in &waiting.subtrees[..waiting.len] {
                let rays = groups_of(shafts, i / WIDE, role) & packet.open;
                if rays != 0 {
                    packet.trace(s, &mut stack, word, rays);
                }
            }
            *open = packet.open;
        }
    }
}

/// The rays of the shafts from `group`, as bits over the other ends.
#[inline(always)]
fn groups_of(shafts: u32, group: usize, role: usize) -> u64 {
    let mut rays = 0;
    for other in 0..GROUPS {
        let shaft = if role == 0 {
            GROUPS * group + other
        } else {
            GROUPS * other + group
        };
        rays |= (u64::from(shafts >> shaft & 1) * 0xffff) << (WIDE * other);
    }
    rays
}

#[inline(always)]
fn block_bounds<S: Simd>(s: S, block: &TriangleBlock) -> [[f32; NARROW]; 6] {
    let mut bounds = [[0.0; NARROW]; 6];
    for axis in 0..3 {
        let a = s.load(&block.corners[0][axis]);
        let b = s.load(&block.corners[1][axis]);
        let c = s.load(&block.corners[2][axis]);
        bounds[axis] = s.store(s.min(s.min(a, b), c));
        bounds[axis + 3] = s.store(s.max(s.max(a, b), c));
    }
    bounds
}
