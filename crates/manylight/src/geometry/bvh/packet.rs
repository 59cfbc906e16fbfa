//! Visibility from one origin to up to 64 targets at once.
//!
//! Boxes and edge functions relative to the common origin serve all rays. Nodes outside of the
//! pyramid over the targets are culled for the whole packet, the others are tested against sixteen
//! rays at a time. Blocked rays leave the packet. The last rays are traced singly.

use super::build::MAX_DEPTH;
use super::edge_volumes::{EdgeVolumes, SegmentDirections};
use super::node::{LEAF, WideNode};
use super::shaft::{Shaft, middle_and_half};
use super::traverse::{self, BoxRay, FAR_MARGIN, slab_reciprocals};
use super::triangle_block::{TreeParts, TriangleBlock};
use super::watertight::AnyTriangle;
use crate::lanes::{Float, LANES, Mask, Sixteen, Vector, lane};
use crate::math::{Aabb, Vec3};
use crate::simd::{NARROW, Simd};
use glam::BVec3;

/// Largest number of rays in a packet.
pub(super) const RAYS: usize = 64;
/// Number of groups of [`LANES`] rays.
const GROUPS: usize = RAYS / LANES;
/// Mask of all rays of a group.
const ALL: u64 = (1 << LANES) - 1;

/// Largest number of rays that are traced singly: for few rays, testing eight boxes per ray costs
/// less than sixteen rays per box.
const FEW: u32 = 4;

/// Child words to visit, with their rays. Reused over packets, because initializing it costs more
/// than many traversals.
pub(super) type PacketStack = [(u32, u64); (NARROW - 1) * MAX_DEPTH + 1];
/// A stack before traversal.
pub(super) const EMPTY_STACK: PacketStack = [(0, 0); (NARROW - 1) * MAX_DEPTH + 1];

/// Up to 64 targets of rays.
pub(super) struct Targets<'a> {
    points: &'a [Vec3],
    /// Indices: group, axis, lane. Unused lanes are zero.
    lanes: [[[f32; LANES]; 3]; GROUPS],
}

impl<'a> Targets<'a> {
    #[inline(always)]
    pub(super) fn new(points: &'a [Vec3]) -> Self {
        let mut lanes = [[[0.0; LANES]; 3]; GROUPS];
        for (i, p) in points.iter().enumerate() {
            let [x, y, z] = &mut lanes[i / LANES];
            (x[i % LANES], y[i % LANES], z[i % LANES]) = (p.x, p.y, p.z);
        }
        Targets { points, lanes }
    }
}

/// Segments with a common origin.
pub(super) struct Packet<'a> {
    nodes: &'a [WideNode],
    blocks: &'a [TriangleBlock],
    from: Vec3,
    to: &'a [Vec3],
    /// Directions. Indices: group, axis, lane. Lanes without a ray are arbitrary, groups without
    /// one zero.
    d: [[[f32; LANES]; 3]; GROUPS],
    /// Reciprocals of `d`, for slab tests.
    reciprocal: [[[f32; LANES]; 3]; GROUPS],
    /// Magnitude of the largest component of `d`.
    size: [[f32; LANES]; GROUPS],
    /// Largest `size` of any ray.
    largest: f32,
    /// The axes along which all directions are negative.
    falling: BVec3,
    /// The axes along which directions may have both signs.
    mixed: [bool; 3],
    /// Shaft from the origin to the box of the targets.
    pyramid: Shaft,
    /// Center and half extents of the box of the directions.
    middle: Vec3,
    half: Vec3,
    /// Rays not blocked so far.
    pub(super) open: u64,
}

impl<'a> Packet<'a> {
    /// The rays to the targets with set bits in `rays`.
    #[inline(always)]
    pub(super) fn new<S: Simd>(
        s: S,
        TreeParts { nodes, blocks }: TreeParts<'a>,
        from: Vec3,
        targets: &Targets<'a>,
        rays: u64,
    ) -> Self {
        let w = s.wide();
        let mut d = [[[0.0; LANES]; 3]; GROUPS];
        let mut reciprocal = [[[0.0; LANES]; 3]; GROUPS];
        let mut size = [[0.0; LANES]; GROUPS];
        let origin = Vector::splat(w, from);
        let nowhere = Vector::splat(w, Vec3::INFINITY);
        // Minima of the targets, and of their negatives.
        let (mut lower, mut upper) = (nowhere, nowhere);
        for group in 0..GROUPS {
            let members = (rays >> (group * LANES) & ALL) as u32;
            if members == 0 {
                continue;
            }
            let members = Mask::from_bits(w, members);
            let target = Vector::load(w, &targets.lanes[group]);
            let negative = Vector::splat(w, Vec3::ZERO) - target;
            lower = lower.min(Vector::select(members, target, nowhere));
            upper = upper.min(Vector::select(members, negative, nowhere));
            let to_target = target - origin;
            d[group] = to_target.store();
            reciprocal[group] = slab_reciprocals(to_target).store();
            size[group] = to_target.abs().max_component().store();
        }
        let bounds = Aabb {
            min: lowest_of_each(lower),
            max: -lowest_of_each(upper),
        };
        let (middle, half) = middle_and_half(&bounds);
        let farthest = (bounds.min - from).abs().max((bounds.max - from).abs());
        Packet {
            nodes,
            blocks,
            from,
            to: targets.points,
            d,
            reciprocal,
            size,
            largest: farthest.max_element(),
            falling: bounds.max.cmplt(from),
            mixed: (bounds.min.cmple(from) & bounds.max.cmpge(from)).into(),
            pyramid: Shaft::new(Aabb::from_point(from), bounds),
            middle: middle - from,
            half,
            open: rays,
        }
    }

    /// Removes from the open rays those of `rays` that a triangle below the node `root` blocks.
    #[inline(always)]
    pub(super) fn trace<S: Simd>(&mut self, s: S, stack: &mut PacketStack, root: u32, rays: u64) {
        let mut top = 1;
        stack[0] = (root, rays);
        while top > 0 {
            top -= 1;
            let (word, rays) = stack[top];
            let rays = rays & self.open;
            if rays.count_ones() <= FEW {
                self.trace_alone(s, word, rays);
            } else {
                let node = &self.nodes[word as usize];
                let (_, _, mut children) = self.pyramid.cut(s, &node.bounds);
                while children != 0 {
                    let lane = children.trailing_zeros() as usize % NARROW;
                    children &= children - 1;
                    let rays = self.enter(s, node.child_bounds(lane), rays);
                    if rays != 0 {
                        let child = node.children[lane];
                        if child & LEAF != 0 {
                            self.test_leaf(s, (child & !LEAF) as usize, rays & self.open);
                            continue;
                        }
                        stack[top] = (child, rays);
                        top += 1;
                    }
                }
            }
        }
    }

    /// Traces `rays` one by one below the child word `word`.
    #[inline(always)]
    fn trace_alone<S: Simd>(&mut self, s: S, word: u32, mut rays: u64) {
        while rays != 0 {
            let ray = rays.trailing_zeros() as usize;
            rays &= rays - 1;
            let d = self.to[ray] - self.from;
            let [x, y, z] = &self.reciprocal[ray / LANES];
            let lane = ray % LANES;
            let scale = Vec3::new(x[lane], y[lane], z[lane]);
            let leaves = AnyTriangle::new(self.blocks, self.from, d);
            let slabs = BoxRay::new(self.from, scale);
            if traverse::any(s, self.nodes, word, &slabs, &leaves) {
                self.open &= !(1 << ray);
            }
        }
    }

    /// The subset of `rays` that enters a box.
    #[inline(always)]
    fn enter<S: Simd>(&self, s: S, bounds: Aabb, rays: u64) -> u64 {
        let w = s.wide();
        // Near and far planes, for axes along which all directions have the same sign.
        let (lower, upper) = (bounds.min - self.from, bounds.max - self.from);
        let first = Vector::splat(w, Vec3::select(self.falling, upper, lower)).to_array();
        let last = Vector::splat(w, Vec3::select(self.falling, lower, upper)).to_array();
        let mut entering = 0;
        for group in 0..GROUPS {
            if rays >> (group * LANES) & ALL == 0 {
                continue;
            }
            let (mut near, mut far) = (Float::splat(w, 0.0), Float::splat(w, 1.0));
            for axis in 0..3 {
                let reciprocal = Float::load(w, &self.reciprocal[group][axis]);
                let (mut t0, mut t1) = (first[axis] * reciprocal, last[axis] * reciprocal);
                if self.mixed[axis] {
                    (t0, t1) = (t0.min(t1), t0.max(t1));
                }
                near = near.max(t0);
                far = far.min(t1);
            }
            let hit = near.le(far * FAR_MARGIN);
            entering |= u64::from(hit.bits()) << (group * LANES);
        }
        entering & rays
    }

    /// Removes from the open rays those of `rays` that the triangles of a leaf block.
    #[inline(always)]
    fn test_leaf<S: Simd>(&mut self, s: S, leaf: usize, mut rays: u64) {
        let tested = rays;
        let volumes = EdgeVolumes::new(s, &self.blocks[leaf], Vector::splat(s, self.from));
        let (middle, half) = (Vector::splat(s, self.middle), Vector::splat(s, self.half));
        let mut triangles = volumes.within(middle, half, self.largest);
        if triangles == 0 {
            return;
        }
        let edges = [
            volumes.edges[0].store(),
            volumes.edges[1].store(),
            volumes.edges[2].store(),
        ];
        let tolerances = [
            volumes.tolerances[0].store(),
            volumes.tolerances[1].store(),
            volumes.tolerances[2].store(),
        ];
        let (normal, height) = (volumes.normal.store(), volumes.height.store());
        let w = s.wide();
        while triangles != 0 && rays != 0 {
            let place = triangles.trailing_zeros() as usize % NARROW;
            triangles &= triangles - 1;
            let triangle = EdgeVolumes {
                edges: [
                    Vector::splat(w, lane(&edges[0], place).into()),
                    Vector::splat(w, lane(&edges[1], place).into()),
                    Vector::splat(w, lane(&edges[2], place).into()),
                ],
                tolerances: [
                    Float::splat(w, tolerances[0][place]),
                    Float::splat(w, tolerances[1][place]),
                    Float::splat(w, tolerances[2][place]),
                ],
                normal: Vector::splat(w, lane(&normal, place).into()),
                height: Float::splat(w, height[place]),
            };
            for group in 0..GROUPS {
                if rays >> (group * LANES) & ALL == 0 {
                    continue;
                }
                let segments = SegmentDirections {
                    d: Vector::load(w, &self.d[group]),
                    size: Float::load(w, &self.size[group]),
                };
                let hit = u64::from(triangle.hit_by(&segments).bits());
                rays &= !(hit << (group * LANES));
            }
        }
        self.open &= rays | !tested;
    }
}

/// The lowest lane of each component.
#[inline(always)]
fn lowest_of_each<S: Sixteen>(v: Vector<S>) -> Vec3 {
    Vec3::new(lowest(v.x), lowest(v.y), lowest(v.z))
}

/// The lowest lane. Not a closure, which might not become part of the kernel.
#[inline(always)]
fn lowest<S: Sixteen>(x: Float<S>) -> f32 {
    x.store()[x.lowest(ALL as u32) % LANES]
}
