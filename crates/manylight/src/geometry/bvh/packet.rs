//! Visibility from one origin to up to 64 targets at once.
//!
//! Boxes and edge functions relative to the common origin serve all rays. Nodes outside of the pyramid over the targets are culled for the
//! whole packet, the others are tested against sixteen rays at a time. Blocked rays leave the packet. The last rays are traced singly.

use super::build::MAX_DEPTH;
use super::edge_volumes::{EdgeVolumes, SegmentDirections};
use super::node::{LEAF, WideNode};
use super::shaft::{Shaft, middle_and_half};
use super::traverse::{self, BoxRay, FAR_MARGIN};
use super::triangle_block::{TreeParts, TriangleBlock};
use super::watertight::AnyTriangle;
use crate::lanes::vectors::{broadcast3, load3, splat3, store3, sub3};
use crate::math::{Aabb, Vec3};
use crate::simd::{LANES, NARROW, Simd, Sixteen, Width};
use glam::BVec3;

/// Largest number of rays in a packet.
pub(super) const RAYS: usize = 64;
/// Number of groups of [`LANES`] rays.
const GROUPS: usize = RAYS / LANES;
/// Mask of all rays of a group.
const ALL: u64 = (1 << LANES) - 1;

/// Largest number of rays that are traced singly: for few rays, testing eight boxes per ray costs less than sixteen rays per box.
const FEW: u32 = 4;

/// Child words to visit, with their rays. Reused over packets, because initializing it costs more than many traversals.
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
    /// Directions. Indices: group, axis, lane. Lanes without a ray are arbitrary, groups without one zero.
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
        let origin = splat3(w, from);
        let nowhere = w.splat(f32::INFINITY);
        // Minima of the targets, and of their negatives.
        let (mut lower, mut upper) = ([nowhere; 3], [nowhere; 3]);
        for group in 0..GROUPS {
            let members = (rays >> (group * LANES) & ALL) as u32;
            if members == 0 {
                continue;
            }
            let members = w.mask(members);
            let target = load3(w, &targets.lanes[group]);
            for axis in 0..3 {
                let p = target[axis];
                let negative = w.sub(w.splat(0.0), p);
                lower[axis] = w.min(lower[axis], w.select(members, p, nowhere));
                upper[axis] = w.min(upper[axis], w.select(members, negative, nowhere));
            }
            let [x, y, z] = sub3(w, target, origin);
            d[group] = store3(w, [x, y, z]);
            let largest = w.max(w.max(w.abs(x), w.abs(y)), w.abs(z));
            reciprocal[group] = store3(w, inverse3(w, [x, y, z], largest));
            size[group] = w.store(largest);
        }
        let bounds = Aabb {
            min: lowest3(w, lower),
            max: -lowest3(w, upper),
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
        let first = splat3(w, Vec3::select(self.falling, upper, lower));
        let last = splat3(w, Vec3::select(self.falling, lower, upper));
        let mut entering = 0;
        for group in 0..GROUPS {
            if rays >> (group * LANES) & ALL == 0 {
                continue;
            }
            let (mut near, mut far) = (w.splat(0.0), w.splat(1.0));
            for axis in 0..3 {
                let reciprocal = w.load(&self.reciprocal[group][axis]);
                let (mut t0, mut t1) = (
                    w.mul(first[axis], reciprocal),
                    w.mul(last[axis], reciprocal),
                );
                if self.mixed[axis] {
                    (t0, t1) = (w.min(t0, t1), w.max(t0, t1));
                }
                near = w.max(near, t0);
                far = w.min(far, t1);
            }
            let hit = w.le(near, w.mul(far, w.splat(FAR_MARGIN)));
            entering |= u64::from(w.bits(hit)) << (group * LANES);
        }
        entering & rays
    }

    /// Removes from the open rays those of `rays` that the triangles of a leaf block.
    #[inline(always)]
    fn test_leaf<S: Simd>(&mut self, s: S, leaf: usize, mut rays: u64) {
        let tested = rays;
        let volumes = EdgeVolumes::new(s, &self.blocks[leaf], splat3(s, self.from));
        let (middle, half) = (splat3(s, self.middle), splat3(s, self.half));
        let mut triangles = volumes.within(s, middle, half, s.splat(self.largest));
        if triangles == 0 {
            return;
        }
        let edges = [
            store3(s, volumes.edges[0]),
            store3(s, volumes.edges[1]),
            store3(s, volumes.edges[2]),
        ];
        let (normal, tolerances) = (store3(s, volumes.normal), store3(s, volumes.tolerances));
        let height = s.store(volumes.height);
        let w = s.wide();
        while triangles != 0 && rays != 0 {
            let lane = triangles.trailing_zeros() as usize % NARROW;
            triangles &= triangles - 1;
            let triangle = EdgeVolumes {
                edges: [
                    broadcast3(w, &edges[0], lane),
                    broadcast3(w, &edges[1], lane),
                    broadcast3(w, &edges[2], lane),
                ],
                tolerances: broadcast3(w, &tolerances, lane),
                normal: broadcast3(w, &normal, lane),
                height: w.splat(height[lane]),
            };
            for group in 0..GROUPS {
                if rays >> (group * LANES) & ALL == 0 {
                    continue;
                }
                let segments = SegmentDirections {
                    d: load3(w, &self.d[group]),
                    size: w.load(&self.size[group]),
                };
                let hit = u64::from(w.bits(triangle.hit_by(w, &segments)));
                rays &= !(hit << (group * LANES));
            }
        }
        self.open &= rays | !tested;
    }
}

/// The lowest lane of each coordinate.
#[inline(always)]
fn lowest3<W: Sixteen>(w: W, v: [W::F; 3]) -> Vec3 {
    Vec3::new(lowest(w, v[0]), lowest(w, v[1]), lowest(w, v[2]))
}

#[inline(always)]
fn lowest<W: Sixteen>(w: W, x: W::F) -> f32 {
    let lane = w.lowest(ALL as u32, x) as usize;
    w.store(x)[lane % LANES]
}

/// [`inverse`] of each component.
#[inline(always)]
fn inverse3<W: Sixteen>(w: W, [x, y, z]: [W::F; 3], largest: W::F) -> [W::F; 3] {
    [
        inverse(w, x, largest),
        inverse(w, y, largest),
        inverse(w, z, largest),
    ]
}

/// `1 / x`. As in [`traverse::slab_reciprocal`], components far below the rounding of the `largest` count as a tiny value of their sign.
#[inline(always)]
fn inverse<W: Sixteen>(w: W, x: W::F, largest: W::F) -> W::F {
    let negligible = w.mul(largest, w.splat(traverse::NEGLIGIBLE));
    let tiny = w.max(negligible, w.splat(f32::MIN_POSITIVE));
    w.div(w.splat(1.0), w.mul_sign(w.max(w.abs(x), tiny), x))
}
