//! A balanced kd-tree over particles: nearest neighbors and everything within a radius.
//!
//! Leaves are runs of 16-wide blocks in structure-of-arrays form, so that the distance loops vectorize. Every node keeps
//! the tight box of its points: particles lie on surfaces, where boxes prune far better than splitting planes.
//! Costs 16 bytes per particle for the blocks and about 1 for the boxes.
//!
//! All answers are functions of the points alone: ties are broken by index, whatever the thread count.

use crate::math::{Aabb, Vec3};
use crate::particles::{Importon, Photon};
use rayon::prelude::*;

/// Points per block.
const WIDTH: usize = 16;
/// Most blocks in a leaf; all leaves have more than half as many, if there are enough points for two.
const LEAF_BLOCKS: usize = 4;
/// Blocks below which a subtree is built by one thread.
const SEQUENTIAL_BLOCKS: usize = 256;
/// Room for one pending node per level; 2^30 leaves are more than indices can name.
const MAX_LEVELS: usize = 32;

/// Something that has a place.
pub trait Located {
    /// Where it is; must be finite.
    fn position(&self) -> Vec3;
}

impl Located for Vec3 {
    #[inline]
    fn position(&self) -> Vec3 {
        *self
    }
}

impl Located for Photon {
    #[inline]
    fn position(&self) -> Vec3 {
        self.p
    }
}

impl Located for Importon {
    #[inline]
    fn position(&self) -> Vec3 {
        self.p
    }
}

/// Sixteen points; the last block is filled up with points infinitely far away.
#[derive(Clone, Debug)]
#[repr(align(64))]
struct Block {
    x: [f32; WIDTH],
    y: [f32; WIDTH],
    z: [f32; WIDTH],
    index: [u32; WIDTH],
}

impl Block {
    const EMPTY: Block = Block {
        x: [f32::INFINITY; WIDTH],
        y: [f32::INFINITY; WIDTH],
        z: [f32::INFINITY; WIDTH],
        index: [u32::MAX; WIDTH],
    };

    #[inline]
    fn distances_squared(&self, p: Vec3) -> [f32; WIDTH] {
        let mut d2 = [0.0; WIDTH];
        for i in 0..WIDTH {
            let (x, y, z) = (self.x[i] - p.x, self.y[i] - p.y, self.z[i] - p.z);
            d2[i] = x * x + y * y + z * z;
        }
        d2
    }
}

/// Bit `i` is set where `d2[i] <= bound`.
#[inline]
fn mask_within(d2: &[f32; WIDTH], bound: f32) -> u32 {
    let mut mask = 0;
    for (i, &d) in d2.iter().enumerate() {
        mask |= u32::from(d <= bound) << i;
    }
    mask
}

/// Positions of the set bits, lowest first.
#[inline]
fn set_bits(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = mask.trailing_zeros();
        mask &= mask.wrapping_sub(1);
        (bit < 32).then_some(bit as usize)
    })
}

/// A point on its way into a leaf.
#[derive(Clone, Copy)]
struct Entry {
    p: Vec3,
    index: u32,
}

/// Particles with an index over their positions.
#[derive(Clone, Debug)]
pub struct KdTree<T> {
    items: Vec<T>,
    blocks: Vec<Block>,
    /// Boxes in depth-first order; a node with `l` levels below it has its children at `+1` and `+2^l`.
    boxes: Vec<Aabb>,
    levels: u32,
}

/// A node on the way down: its box, the levels below it, its run of blocks.
#[derive(Clone, Copy, Default)]
struct Node {
    index: u32,
    levels: u32,
    first: u32,
    last: u32,
    distance_squared: f32,
}

/// Blocks of the lower child out of `count`.
#[inline]
fn lower_half(count: u32) -> u32 {
    count.div_ceil(2)
}

impl<T: Located + Sync> KdTree<T> {
    /// Builds the tree in parallel. Items keep their indices.
    pub fn build(items: Vec<T>) -> Self {
        let block_count = items.len().div_ceil(WIDTH);
        let mut levels = 0;
        while block_count.div_ceil(1 << levels) > LEAF_BLOCKS {
            levels += 1;
        }
        let mut entries: Vec<Entry> = items
            .par_iter()
            .enumerate()
            .map(|(i, item)| Entry {
                p: item.position(),
                index: i as u32,
            })
            .collect();
        let mut blocks = vec![Block::EMPTY; block_count];
        let mut boxes = vec![Aabb::EMPTY; (2 << levels) - 1];
        build_node(&mut entries, &mut blocks, &mut boxes, levels);
        KdTree {
            items,
            blocks,
            boxes,
            levels,
        }
    }
}

/// Sorts `entries` into the blocks and boxes of one subtree with `levels` levels below its root.
fn build_node(entries: &mut [Entry], blocks: &mut [Block], boxes: &mut [Aabb], levels: u32) {
    let bounds = Aabb::from_points(entries.iter().map(|e| e.p));
    boxes[0] = bounds;
    if levels == 0 {
        for (block, run) in blocks.iter_mut().zip(entries.chunks(WIDTH)) {
            for (i, e) in run.iter().enumerate() {
                (block.x[i], block.y[i], block.z[i], block.index[i]) =
                    (e.p.x, e.p.y, e.p.z, e.index);
            }
        }
        return;
    }
    let axis = bounds.extent().max_position();
    let lower = lower_half(blocks.len() as u32) as usize;
    // Whole blocks to the left, so that only the very last block of the tree is padded.
    let middle = lower * WIDTH;
    entries.select_nth_unstable_by(middle, |a, b| {
        a.p[axis].total_cmp(&b.p[axis]).then(a.index.cmp(&b.index))
    });
    let many = blocks.len() >= SEQUENTIAL_BLOCKS;
    let (left, right) = entries.split_at_mut(middle);
    let (left_blocks, right_blocks) = blocks.split_at_mut(lower);
    let (left_boxes, right_boxes) = boxes[1..].split_at_mut((1 << levels) - 1);
    let mut build_left = || build_node(left, left_blocks, left_boxes, levels - 1);
    let mut build_right = || build_node(right, right_blocks, right_boxes, levels - 1);
    if many {
        rayon::join(build_left, build_right);
    } else {
        build_left();
        build_right();
    }
}

impl<T> KdTree<T> {
    /// The particles, in the order in which they were given.
    pub fn items(&self) -> &[T] {
        &self.items
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    /// Bytes of particles and tree.
    pub fn bytes(&self) -> usize {
        size_of_val(self.items.as_slice())
            + size_of_val(self.blocks.as_slice())
            + size_of_val(self.boxes.as_slice())
    }

    /// Takes the particles out.
    pub fn into_items(self) -> Vec<T> {
        self.items
    }

    /// Shows `visit` every block that may hold points with squared distance `<= bound`, nearest boxes first.
    /// `visit` gets the block, its squared distances and the bound, and returns the bound from then on.
    ///
    /// Box and point distances are the same sums of the same rounded differences, so rounding never prunes a point.
    #[inline]
    fn search(
        &self,
        p: Vec3,
        mut bound: f32,
        mut visit: impl FnMut(&Block, &[f32; WIDTH], f32) -> f32,
    ) {
        let mut stack = [Node::default(); MAX_LEVELS];
        let mut pending = 0;
        let mut node = Node {
            index: 0,
            levels: self.levels,
            first: 0,
            last: self.blocks.len() as u32,
            distance_squared: self.boxes[0].distance_squared(p),
        };
        loop {
            if node.distance_squared <= bound {
                if node.levels > 0 {
                    let (near, far) = self.children(&node, p);
                    if far.distance_squared <= bound {
                        stack[pending] = far;
                        pending += 1;
                    }
                    node = near;
                    continue;
                }
                for block in &self.blocks[node.first as usize..node.last as usize] {
                    bound = visit(block, &block.distances_squared(p), bound);
                }
            }
            if pending == 0 {
                return;
            }
            pending -= 1;
            node = stack[pending];
        }
    }

    /// Both children of an inner node, the one whose box is nearer to `p` first.
    #[inline]
    fn children(&self, node: &Node, p: Vec3) -> (Node, Node) {
        let child = |index: u32, first: u32, last: u32| Node {
            index,
            levels: node.levels - 1,
            first,
            last,
            distance_squared: self.boxes[index as usize].distance_squared(p),
        };
        let middle = node.first + lower_half(node.last - node.first);
        let left = child(node.index + 1, node.first, middle);
        let right = child(node.index + (1 << node.levels), middle, node.last);
        if left.distance_squared <= right.distance_squared {
            (left, right)
        } else {
            (right, left)
        }
    }

    /// Finds the nearest particles within `max_radius` (which may be infinite) of `p`, as many as `found` keeps.
    #[inline]
    pub fn nearest(&self, p: Vec3, max_radius: f32, found: &mut Neighbors) {
        found.keys.clear();
        let limit = (max_radius * max_radius).min(f32::MAX);
        self.search(p, limit, |block, d2, bound| found.offer(block, d2, bound));
        found.finish(limit);
    }

    /// Calls `visit` with index and squared distance of every particle within `radius` of `p`.
    #[inline]
    pub fn within(&self, p: Vec3, radius: f32, mut visit: impl FnMut(u32, f32)) {
        self.search(p, (radius * radius).min(f32::MAX), |block, d2, bound| {
            for i in set_bits(mask_within(d2, bound)) {
                visit(block.index[i], d2[i]);
            }
            bound
        });
    }

    /// The particle with the lowest cost, and that cost. `cost` gets index and squared distance; it must return no less
    /// than the squared distance, or `None` for a particle that must not be taken. Costs above `max_cost` do not count.
    #[inline]
    pub fn cheapest(
        &self,
        p: Vec3,
        max_cost: f32,
        mut cost: impl FnMut(u32, f32) -> Option<f32>,
    ) -> Option<(u32, f32)> {
        let mut best: Option<(u32, f32)> = None;
        self.search(p, max_cost.min(f32::MAX), |block, d2, mut bound| {
            for i in set_bits(mask_within(d2, bound)) {
                let index = block.index[i];
                let Some(c) = cost(index, d2[i]).filter(|&c| c <= bound) else {
                    continue;
                };
                if best.is_none_or(|(b, cost)| c < cost || (c == cost && index < b)) {
                    best = Some((index, c));
                    bound = c;
                }
            }
            bound
        });
        best
    }
}

/// The answer to [`KdTree::nearest`], and its working memory: make one per thread and use it again.
#[derive(Clone, Debug)]
pub struct Neighbors {
    k: usize,
    /// Bits of the squared distance above the index: integer order is distance order with ties by index.
    keys: Vec<u64>,
    radius_squared: f32,
}

impl Neighbors {
    /// Keeps at most `k >= 1` neighbors.
    pub fn new(k: usize) -> Self {
        assert!(k >= 1, "at least one neighbor is asked for");
        Neighbors {
            k,
            keys: Vec::with_capacity(2 * k + 2 * WIDTH),
            radius_squared: 0.0,
        }
    }

    /// Index and squared distance of each neighbor, in no particular order.
    #[inline]
    pub fn iter(&self) -> impl Iterator<Item = (u32, f32)> + '_ {
        self.keys
            .iter()
            .map(|&key| (key as u32, distance_squared(key)))
    }

    /// Number of neighbors found.
    pub fn len(&self) -> usize {
        self.keys.len()
    }

    /// Whether none was found.
    pub fn is_empty(&self) -> bool {
        self.keys.is_empty()
    }

    /// Squared distance of the `k`-th neighbor, if there are as many; otherwise the square of the radius that was
    /// searched, or of the farthest neighbor if that was infinite.
    #[inline]
    pub fn radius_squared(&self) -> f32 {
        self.radius_squared
    }

    /// Takes the points of a block that are near enough; returns the bound from then on.
    #[inline]
    fn offer(&mut self, block: &Block, d2: &[f32; WIDTH], bound: f32) -> f32 {
        for i in set_bits(mask_within(d2, bound)) {
            self.keys
                .push(u64::from(d2[i].to_bits()) << 32 | u64::from(block.index[i]));
        }
        // Selecting only when twice too many have come costs constant time per candidate.
        if self.keys.len() < 2 * self.k + WIDTH {
            return bound;
        }
        self.keep_nearest()
    }

    /// Drops all but the `k` nearest and returns the distance of the last.
    fn keep_nearest(&mut self) -> f32 {
        let (_, &mut kth, _) = self.keys.select_nth_unstable(self.k - 1);
        self.keys.truncate(self.k);
        distance_squared(kth)
    }

    fn finish(&mut self, limit: f32) {
        self.radius_squared = if self.keys.len() >= self.k {
            self.keep_nearest()
        } else if limit < f32::MAX {
            limit
        } else {
            self.keys
                .iter()
                .max()
                .map_or(0.0, |&key| distance_squared(key))
        };
    }
}

#[inline]
fn distance_squared(key: u64) -> f32 {
    f32::from_bits((key >> 32) as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::rng::Pcg;

    fn points(count: usize, key: u64) -> Vec<Vec3> {
        let mut rng = Pcg::new(key);
        (0..count)
            .map(|i| {
                let p = Vec3::new(rng.next_f32(), rng.next_f32(), 0.1 * rng.next_f32());
                // Every fifth point stands at one of few places, so that there are many duplicates.
                if i % 5 == 0 {
                    (p * 3.0).round() / 3.0
                } else {
                    p
                }
            })
            .collect()
    }

    fn brute_force(points: &[Vec3], p: Vec3, k: usize, radius: f32) -> Vec<u64> {
        let mut keys: Vec<u64> = points
            .iter()
            .enumerate()
            .map(|(i, q)| {
                let d = *q - p;
                let d2 = d.x * d.x + d.y * d.y + d.z * d.z;
                u64::from(d2.to_bits()) << 32 | i as u64
            })
            .filter(|&key| distance_squared(key) <= radius * radius)
            .collect();
        keys.sort_unstable();
        keys.truncate(k);
        keys
    }

    #[test]
    fn nearest_equals_brute_force() {
        for count in [0, 1, 7, 16, 17, 64, 65, 100, 1000, 5000] {
            let points = points(count, count as u64);
            let tree = KdTree::build(points.clone());
            let mut rng = Pcg::new(99);
            for k in [1, 5, 64, 300] {
                let mut found = Neighbors::new(k);
                for radius in [0.05, 0.3, f32::INFINITY] {
                    let p = Vec3::new(rng.next_f32(), rng.next_f32(), 0.05) * 1.2;
                    tree.nearest(p, radius, &mut found);
                    let mut keys = found.keys.clone();
                    keys.sort_unstable();
                    let expected = brute_force(&points, p, k, radius);
                    assert_eq!(keys, expected, "{count} points, k = {k}, radius {radius}");
                    let radius_squared = match expected.last() {
                        Some(&last) if expected.len() == k || radius.is_infinite() => {
                            distance_squared(last)
                        }
                        None if radius.is_infinite() => 0.0,
                        _ => radius * radius,
                    };
                    assert_eq!(found.radius_squared(), radius_squared);
                }
            }
        }
    }

    #[test]
    fn within_and_cheapest_equal_brute_force() {
        let points = points(3000, 4);
        let tree = KdTree::build(points.clone());
        let mut rng = Pcg::new(5);
        for _ in 0..200 {
            let p = Vec3::new(rng.next_f32(), rng.next_f32(), 0.1 * rng.next_f32());
            let mut count = 0;
            tree.within(p, 0.1, |_, _| count += 1);
            assert_eq!(count, brute_force(&points, p, usize::MAX, 0.1).len());

            // A metric stretched along z, on every third point only.
            let cost = |i: u32, d2: f32| {
                let z = points[i as usize].z - p.z;
                (i % 3 == 1).then_some(d2 + 24.0 * z * z)
            };
            let expected = (0..points.len() as u32)
                .filter_map(|i| {
                    let d = points[i as usize] - p;
                    cost(i, d.x * d.x + d.y * d.y + d.z * d.z).map(|c| (i, c))
                })
                .min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
            assert_eq!(tree.cheapest(p, f32::INFINITY, cost), expected);
            assert_eq!(
                tree.cheapest(p, expected.map_or(0.0, |e| e.1 * 0.99), cost),
                None
            );
        }
    }

    #[test]
    fn the_tree_is_the_same_for_any_thread_count() {
        let points = points(60_000, 8);
        let blocks = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .expect("threads");
            pool.install(|| {
                KdTree::build(points.clone())
                    .blocks
                    .iter()
                    .map(|b| b.index)
                    .collect::<Vec<_>>()
            })
        };
        assert_eq!(blocks(1), blocks(3));
    }

    #[test]
    fn the_tree_costs_few_bytes_per_point() {
        let tree = KdTree::build(points(10_000, 1));
        let beside = tree.bytes() - 10_000 * size_of::<Vec3>();
        assert!(beside <= 20 * 10_000, "{beside}");
    }
}
