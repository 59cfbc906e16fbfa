//! Visibility between up to 64 points and up to 64 lights: up to 4096 segments at once.
//!
//! Four groups of sixteen points and four groups of sixteen lights define sixteen shafts, one per
//! lane of a wide vector. The traversal keeps for each subtree the shafts that meet it. Triangles
//! are tested against whole shafts, rows and single segments ([`Rows`]). A subtree with many
//! triangles that is small against the shafts' cross-section would be tested by all of them. Such
//! subtrees are deferred. Packets trace the segments that are still open through them afterwards,
//! starting from the points or from the lights: the packets that are narrower at the subtree.

mod ends;
mod rows;
mod triangle;

pub(super) use ends::SIDE;

use super::build::MAX_DEPTH;
use super::node::{LEAF, WideNode};
use super::packet::{EMPTY_STACK, Packet, Targets};
use super::shaft::{Shaft, Shafts};
use super::triangle_block::{TreeParts, TriangleBlock};
use crate::lanes::{Float, LANES};
use crate::math::bits::transpose;
use crate::math::{Aabb, Vec3};
use crate::simd::{NARROW, Simd};
use ends::{EndGroups, GROUPS};
use rows::Rows;
use triangle::LeafTriangles;

/// Largest number of deferred subtrees per direction of packets; further ones are traversed at
/// once.
const DEFERRED: usize = 128;

/// Smallest number of triangles of a deferred subtree. Measured.
const MANY: f32 = 16.0;

/// Density of triangles at which a subtree is deferred: its number of triangles, times the
/// cross-section of the shaft, over its own cross-section. Measured.
const CROWD: f32 = 128.0;

/// Entries of the traversal stack: each level pops one and pushes at most eight.
const CAPACITY: usize = (NARROW - 1) * MAX_DEPTH + 1;

/// Deferred subtrees, with the shafts that meet them.
struct DeferredSubtrees {
    len: usize,
    subtrees: [(u32, u32); DEFERRED],
}

/// The segments between the points and lights of a tile.
pub(super) struct VisibilityTile<'a> {
    nodes: &'a [WideNode],
    blocks: &'a [TriangleBlock],
    points: &'a [Vec3],
    lights: &'a [Vec3],
    shaft: Shaft,
    shafts: Shafts,
    rows: Rows,
    /// Mean half extents of the groups of points, and of lights.
    half: [Vec3; 2],
    /// Diagonals of the boxes of all points, and of all lights.
    spread: [f32; 2],
    /// Deferred subtrees for packets from the points (0) and from the lights (1).
    deferred: [DeferredSubtrees; 2],
}

impl<'a> VisibilityTile<'a> {
    /// `wanted` has one mask of lights per point; at least one mask is not zero.
    #[inline(always)]
    pub(super) fn new<S: Simd>(
        s: S,
        TreeParts { nodes, blocks }: TreeParts<'a>,
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
        let deferred = || DeferredSubtrees {
            len: 0,
            subtrees: [(0, 0); DEFERRED],
        };
        VisibilityTile {
            nodes,
            blocks,
            points,
            lights,
            shaft: Shaft::new(p.all, l.all),
            shafts: Shafts::new(s.wide(), &p.bounds, &l.bounds, (p.all, l.all)),
            half: [p.mean_half(), l.mean_half()],
            spread: [p.all.diagonal(), l.all.diagonal()],
            rows: Rows::new(s, p, l, wanted),
            deferred: [deferred(), deferred()],
        }
    }

    /// For each point the wanted lights that are not blocked.
    #[inline(always)]
    pub(super) fn trace<S: Simd>(mut self, s: S) -> [u64; SIDE] {
        self.traverse(s);
        let mut open = self.rows.open_by_point();
        if self.deferred[0].len > 0 {
            self.trace_packets(s, 0, &mut open);
        }
        if self.deferred[1].len > 0 {
            transpose(&mut open);
            self.trace_packets(s, 1, &mut open);
            transpose(&mut open);
        }
        open
    }

    /// Traverses the tree; closes blocked segments, defers dense subtrees.
    #[inline(always)]
    fn traverse<S: Simd>(&mut self, s: S) {
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
            let (near, far) = (near.store(), far.store());
            while children != 0 {
                let lane = children.trailing_zeros() as usize % NARROW;
                children &= children - 1;
                let b = &node.bounds;
                let planes = [
                    b[0][lane], b[1][lane], b[2][lane], b[3][lane], b[4][lane], b[5][lane],
                ];
                let shafts = self.shafts.meeting(s.wide(), planes) & shafts;
                if shafts == 0 {
                    continue;
                }
                let child = node.children[lane];
                let t = 0.5 * (near[lane] + far[lane]);
                if child & LEAF == 0
                    && self.is_dense(node.items_below(lane), node.child_bounds(lane), t)
                {
                    // The width of a packet at the subtree: the extent of its targets times the
                    // relative distance from its origin.
                    let from_lights = (1.0 - t) * self.spread[0] < t * self.spread[1];
                    let deferred = &mut self.deferred[usize::from(from_lights)];
                    if deferred.len < DEFERRED {
                        deferred.subtrees[deferred.len] = (child, shafts);
                        deferred.len += 1;
                        continue;
                    }
                }
                stack[top] = (child, shafts);
                top += 1;
            }
        }
    }

    /// Whether the subtree is dense: many triangles in a small part of the cross-section of the
    /// mean shaft at `t`.
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

    /// Closes the segments of `shafts` that the triangles of a leaf block.
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
            let shafts = self.shafts.meeting(s.wide(), planes) & shafts & self.rows.active;
            if shafts != 0 {
                self.rows.block(s.wide(), &triangles, lane, shafts);
            }
        }
    }

    /// Traces one packet per point, or per light with `role` 1, through the deferred subtrees.
    /// `open` has one mask per packet.
    #[inline(always)]
    fn trace_packets<S: Simd>(&self, s: S, role: usize, open: &mut [u64; SIDE]) {
        let (from, to) = if role == 0 {
            (self.points, self.lights)
        } else {
            (self.lights, self.points)
        };
        let deferred = &self.deferred[role];
        let targets = Targets::new(to);
        let mut stack = EMPTY_STACK;
        for (i, (&from, open)) in from.iter().zip(open).enumerate() {
            if *open == 0 {
                continue;
            }
            let tree = TreeParts {
                nodes: self.nodes,
                blocks: self.blocks,
            };
            let mut packet = Packet::new(s, tree, from, &targets, *open);
            for &(word, shafts) in &deferred.subtrees[..deferred.len] {
                let rays = groups_of(shafts, i / LANES, role) & packet.open;
                if rays != 0 {
                    packet.trace(s, &mut stack, word, rays);
                }
            }
            *open = packet.open;
        }
    }
}

/// The rays of `shafts` that start in `group`, as bits over their targets.
#[inline(always)]
fn groups_of(shafts: u32, group: usize, role: usize) -> u64 {
    let mut rays = 0;
    for other in 0..GROUPS {
        let shaft = if role == 0 {
            GROUPS * group + other
        } else {
            GROUPS * other + group
        };
        rays |= (u64::from(shafts >> shaft & 1) * 0xffff) << (LANES * other);
    }
    rays
}

/// Bounds of the triangles of a block, in the layout of [`WideNode::bounds`].
#[inline(always)]
fn block_bounds<S: Simd>(s: S, block: &TriangleBlock) -> [[f32; NARROW]; 6] {
    let mut bounds = [[0.0; NARROW]; 6];
    for axis in 0..3 {
        let corner = |i: usize| Float::load(s, &block.corners[i][axis]);
        let (a, b, c) = (corner(0), corner(1), corner(2));
        bounds[axis] = a.min(b).min(c).store();
        bounds[axis + 3] = a.max(b).max(c).store();
    }
    bounds
}
