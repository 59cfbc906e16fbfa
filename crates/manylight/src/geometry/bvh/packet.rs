//! Visibility from one origin to up to 64 targets at once.
//!
//! Relative to the common origin, boxes and edge volumes are the same for all rays. A node's children are first tested
//! together against the interval of all directions, then each one that is left against eight rays at a time.
//! Rays that are blocked leave the packet; when few are left, they go on alone.

use super::build::{LEAF, MAX_DEPTH, Node};
use super::simd::{LANES, Simd};
use super::traverse::{self, FAR_MARGIN, slab_reciprocal};
use super::triangles::{AnyTriangle, Block, Directions, EdgeVolumes, load3, splat3};
use crate::math::Vec3;

/// Rays in a packet.
pub(super) const RAYS: usize = 64;
const GROUPS: usize = RAYS / LANES;

/// With this many rays left, eight boxes per ray are cheaper than eight rays per box.
const FEW: u32 = 3;

const CAPACITY: usize = (LANES - 1) * MAX_DEPTH + 1;

/// Segments with a common origin.
pub(super) struct Packet<'a> {
    nodes: &'a [Node],
    blocks: &'a [Block],
    from: Vec3,
    to: &'a [Vec3],
    /// Group, axis, lane. Lanes beyond the last target are zero.
    d: [[[f32; LANES]; 3]; GROUPS],
    reciprocal: [[[f32; LANES]; 3]; GROUPS],
    /// Largest component of `d`.
    size: [[f32; LANES]; GROUPS],
    /// Least and greatest reciprocal, per axis.
    least: Vec3,
    greatest: Vec3,
    /// Rays not blocked so far.
    open: u64,
}

impl<'a> Packet<'a> {
    #[inline(always)]
    pub(super) fn new(nodes: &'a [Node], blocks: &'a [Block], from: Vec3, to: &'a [Vec3]) -> Self {
        let mut packet = Packet {
            nodes,
            blocks,
            from,
            to,
            d: [[[0.0; LANES]; 3]; GROUPS],
            reciprocal: [[[0.0; LANES]; 3]; GROUPS],
            size: [[0.0; LANES]; GROUPS],
            least: Vec3::INFINITY,
            greatest: Vec3::NEG_INFINITY,
            open: u64::MAX >> (RAYS - to.len()),
        };
        for (i, &target) in to.iter().enumerate() {
            let d = target - from;
            let reciprocal = slab_reciprocal(d);
            packet.least = packet.least.min(reciprocal);
            packet.greatest = packet.greatest.max(reciprocal);
            packet.size[i / LANES][i % LANES] = d.abs().max_element();
            for axis in 0..3 {
                packet.d[i / LANES][axis][i % LANES] = d[axis];
                packet.reciprocal[i / LANES][axis][i % LANES] = reciprocal[axis];
            }
        }
        packet
    }

    /// The blocked rays, as bits.
    #[inline(always)]
    pub(super) fn trace<S: Simd>(mut self, s: S) -> u64 {
        let all = self.open;
        let mut stack = [(0u32, 0u64); CAPACITY];
        let mut top = 1;
        stack[0] = (0, all);
        while top > 0 {
            top -= 1;
            let (word, rays) = stack[top];
            let rays = rays & self.open;
            if rays.count_ones() <= FEW {
                self.trace_alone(s, word, rays);
            } else if word & LEAF != 0 {
                self.test_leaf(s, (word & !LEAF) as usize, rays);
            } else {
                let node = &self.nodes[word as usize];
                let mut children = self.enter_together(s, node);
                let relative = self.relative_bounds(s, node);
                while children != 0 {
                    let lane = children.trailing_zeros() as usize % LANES;
                    children &= children - 1;
                    let rays = self.enter(s, &relative, lane, rays);
                    if rays != 0 {
                        stack[top] = (node.children[lane], rays);
                        top += 1;
                    }
                }
            }
        }
        all & !self.open
    }

    #[inline(always)]
    fn trace_alone<S: Simd>(&mut self, s: S, word: u32, mut rays: u64) {
        while rays != 0 {
            let ray = rays.trailing_zeros() as usize;
            rays &= rays - 1;
            let d = self.to[ray] - self.from;
            let leaves = AnyTriangle::new(s, self.blocks, self.from, d);
            if traverse::any(s, self.nodes, word, self.from, d, &leaves) {
                self.open &= !(1 << ray);
            }
        }
    }

    #[inline(always)]
    fn relative_bounds<S: Simd>(&self, s: S, node: &Node) -> [[f32; LANES]; 6] {
        std::array::from_fn(|plane| {
            s.store(s.sub(s.load(&node.bounds[plane]), s.splat(self.from[plane % 3])))
        })
    }

    /// The children that some direction between the least and the greatest may enter.
    #[inline(always)]
    fn enter_together<S: Simd>(&self, s: S, node: &Node) -> u32 {
        let (mut near, mut far) = (s.splat(0.0), s.splat(1.0));
        for axis in 0..3 {
            let (least, greatest) = (self.least[axis], self.greatest[axis]);
            if least < 0.0 && greatest > 0.0 {
                continue;
            }
            let turned = usize::from(greatest < 0.0);
            let o = s.splat(self.from[axis]);
            let n = s.sub(s.load(&node.bounds[axis + 3 * turned]), o);
            let f = s.sub(s.load(&node.bounds[axis + 3 - 3 * turned]), o);
            let (least, greatest) = (s.splat(least), s.splat(greatest));
            near = s.max(near, s.min(s.mul(n, least), s.mul(n, greatest)));
            far = s.min(
                far,
                s.mul(
                    s.max(s.mul(f, least), s.mul(f, greatest)),
                    s.splat(FAR_MARGIN),
                ),
            );
        }
        let occupied = node
            .children
            .iter()
            .rev()
            .fold(0, |bits, &word| bits << 1 | u32::from(word != 0));
        s.bits(s.le(near, far)) & occupied
    }

    /// Those of `rays` that enter the child `lane`.
    #[inline(always)]
    fn enter<S: Simd>(&self, s: S, relative: &[[f32; LANES]; 6], lane: usize, rays: u64) -> u64 {
        let planes: [S::F; 6] = std::array::from_fn(|plane| s.splat(relative[plane][lane]));
        let mut entering = 0;
        for group in 0..GROUPS {
            if rays >> (group * LANES) & 0xff == 0 {
                continue;
            }
            let (mut near, mut far) = (s.splat(0.0), s.splat(1.0));
            for axis in 0..3 {
                let reciprocal = s.load(&self.reciprocal[group][axis]);
                let (t0, t1) = (
                    s.mul(planes[axis], reciprocal),
                    s.mul(planes[axis + 3], reciprocal),
                );
                near = s.max(near, s.min(t0, t1));
                far = s.min(far, s.mul(s.max(t0, t1), s.splat(FAR_MARGIN)));
            }
            entering |= u64::from(s.bits(s.le(near, far))) << (group * LANES);
        }
        entering & rays
    }

    #[inline(always)]
    fn test_leaf<S: Simd>(&mut self, s: S, leaf: usize, mut rays: u64) {
        let tested = rays;
        let volumes = EdgeVolumes::new(s, &self.blocks[leaf], splat3(s, self.from));
        let store3 = |v: [S::F; 3]| [s.store(v[0]), s.store(v[1]), s.store(v[2])];
        let edges = [
            store3(volumes.edges[0]),
            store3(volumes.edges[1]),
            store3(volumes.edges[2]),
        ];
        let (normal, tolerances) = (store3(volumes.normal), store3(volumes.tolerances));
        let height = s.store(volumes.height);
        for lane in 0..LANES {
            // No ray hits a triangle whose plane holds the origin; empty lanes are such triangles.
            if height[lane] == 0.0 {
                continue;
            }
            let lane3 = |v: &[[f32; LANES]; 3]| {
                [
                    s.splat(v[0][lane]),
                    s.splat(v[1][lane]),
                    s.splat(v[2][lane]),
                ]
            };
            let triangle = EdgeVolumes {
                edges: [lane3(&edges[0]), lane3(&edges[1]), lane3(&edges[2])],
                tolerances: lane3(&tolerances),
                normal: lane3(&normal),
                height: s.splat(height[lane]),
            };
            for group in 0..GROUPS {
                if rays >> (group * LANES) & 0xff == 0 {
                    continue;
                }
                let segments = Directions {
                    d: load3(s, &self.d[group]),
                    size: s.load(&self.size[group]),
                };
                rays &= !(u64::from(s.bits(triangle.hit_by(s, &segments))) << (group * LANES));
            }
            if rays == 0 {
                break;
            }
        }
        self.open &= rays | !tested;
    }
}
