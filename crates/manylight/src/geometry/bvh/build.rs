//! From boxes to a tree of eight-wide nodes.
//!
//! `obvhs` makes a binary tree (PLOC, then reinsertion). Which of its nodes become wide nodes and which leaves is decided
//! by dynamic programming over the surface area heuristic: Ylitie et al., "Efficient Incoherent Ray Traversal on GPUs
//! Through Compressed Wide BVHs", HPG 2017, section 3.1. A leaf costs the same for one item as for eight.

use crate::math::{Aabb, Vec3};
use crate::simd::NARROW;
use obvhs::bvh2::{Bvh2, node::Bvh2Node, reinsertion::ReinsertionOptimizer};
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

/// A child word with this bit names a leaf, without it a node. 0 is no child: the root is nobody's child.
pub(super) const LEAF: u32 = 1 << 31;

/// Most levels of nodes; the size of the traversal stack follows from it.
pub(super) const MAX_DEPTH: usize = 36;

/// Below this depth subtrees are split evenly: eleven more levels hold 2^33 items.
const BALANCED_DEPTH: usize = MAX_DEPTH - 11;

/// Share of the binary nodes that each round of reinsertion considers.
const REINSERTED_SHARE: f32 = 0.15;

/// Cost of testing a leaf in units of the cost of testing a node.
const LEAF_COST: f32 = 1.2;

/// Eight boxes and what is in them, in four cache lines.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// Lower x, y, z, upper x, y, z of the children. Empty places have lower = +∞ and upper = -∞.
    pub(super) bounds: [[f32; NARROW]; 6],
    /// See [`LEAF`].
    pub(super) children: [u32; NARROW],
    /// For each octant of directions (bit a set: component a is negative) the children from far to near, three bits each.
    /// The eight bits that are left belong to one child each, see [`Node::items_below`].
    pub(super) order: [u32; NARROW],
}

impl Node {
    /// Items below a child, rounded up to a power of two.
    #[inline(always)]
    pub(super) fn items_below(&self, lane: usize) -> f32 {
        (1u64 << (self.order[lane] >> 24)) as f32
    }

    #[inline(always)]
    pub(super) fn child_bounds(&self, lane: usize) -> Aabb {
        let b = &self.bounds;
        Aabb {
            min: Vec3::new(b[0][lane], b[1][lane], b[2][lane]),
            max: Vec3::new(b[3][lane], b[4][lane], b[5][lane]),
        }
    }
}

/// The nodes over a list of items.
#[derive(Debug, Default)]
pub(super) struct Tree {
    /// The root is the first, if there is any.
    pub(super) nodes: Vec<Node>,
    /// The items in leaf order.
    pub(super) items: Vec<u32>,
    /// Leaf `i` holds `items[leaves[i]..leaves[i + 1]]`.
    pub(super) leaves: Vec<u32>,
    /// Box around everything.
    pub(super) bounds: Option<Aabb>,
}

impl Tree {
    /// Builds a tree with at most `max_leaf` items per leaf. All boxes must be finite and not empty.
    pub(super) fn new(boxes: &[Aabb], max_leaf: usize) -> Self {
        if boxes.is_empty() {
            return Tree::default();
        }
        let binary = binary_tree(boxes);
        let plan = Plan::new(&binary, max_leaf);
        let mut emitter = Emitter {
            binary: &binary,
            plan,
            boxes,
            max_leaf,
            tree: Tree::default(),
        };
        // The root is always a node, even over a single leaf: traversal has one case less.
        emitter.tree.nodes.push(empty_node());
        let children = if binary.nodes[0].is_leaf() {
            vec![0]
        } else {
            emitter.plan.children(&binary, 0)
        };
        emitter.fill_node(0, &children, 1);
        let mut tree = emitter.tree;
        tree.leaves.push(tree.items.len() as u32);
        tree.note_items_below();
        tree.bounds = Some(boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(*b)));
        tree
    }

    /// Children stand behind their parents, so one walk from the end counts all.
    fn note_items_below(&mut self) {
        let mut counts = vec![0u32; self.nodes.len()];
        for index in (0..self.nodes.len()).rev() {
            for lane in 0..NARROW {
                let word = self.nodes[index].children[lane];
                let place = (word & !LEAF) as usize;
                let count = match word {
                    0 => continue,
                    _ if word & LEAF != 0 => self.leaves[place + 1] - self.leaves[place],
                    _ => counts[place],
                };
                self.nodes[index].order[lane] |= count.next_power_of_two().trailing_zeros() << 24;
                counts[index] = counts[index].saturating_add(count);
            }
        }
    }

    /// Bytes used.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.nodes)
    }
}

fn binary_tree(boxes: &[Aabb]) -> Bvh2 {
    let boxes: Vec<obvhs::aabb::Aabb> = boxes
        .iter()
        .map(|b| obvhs::aabb::Aabb::new(b.min.to_vec3a(), b.max.to_vec3a()))
        .collect();
    let indices = (0..boxes.len() as u32).collect();
    let mut binary = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::Medium,
        &boxes,
        indices,
        SortPrecision::U64,
        3,
    );
    ReinsertionOptimizer::default().run(&mut binary, REINSERTED_SHARE, None);
    binary
}

fn left(node: &Bvh2Node) -> usize {
    node.first_index as usize
}

/// For each binary node: the cheapest way to represent it by up to `i` wide subtrees, for `i` = 1 to 8.
struct Plan {
    cost: Vec<[f32; NARROW]>,
    /// At `i - 1`: how many of the `i` subtrees the left child gets.
    share: Vec<[u8; NARROW]>,
    /// Bit `i - 1`: `i - 1` subtrees are no dearer than `i`. Bit 0: this node becomes a leaf.
    fewer: Vec<u8>,
}

impl Plan {
    fn new(binary: &Bvh2, max_leaf: usize) -> Self {
        let n = binary.nodes.len();
        let mut plan = Plan {
            cost: vec![[0.0; NARROW]; n],
            share: vec![[0; NARROW]; n],
            fewer: vec![0; n],
        };
        let mut counts = vec![0u32; n];
        for index in parents_first(binary).into_iter().rev() {
            let node = &binary.nodes[index];
            let area = node.aabb().half_area();
            if node.is_leaf() {
                counts[index] = node.prim_count;
                plan.cost[index] = [area * LEAF_COST; NARROW];
                plan.fewer[index] = u8::MAX;
                continue;
            }
            counts[index] = counts[left(node)].saturating_add(counts[left(node) + 1]);
            plan.decide(index, left(node), area, counts[index] as usize <= max_leaf);
        }
        plan
    }

    fn decide(&mut self, index: usize, left: usize, area: f32, fits_leaf: bool) {
        let (l, r) = (self.cost[left], self.cost[left + 1]);
        let mut cost = [f32::INFINITY; NARROW];
        for i in 2..=NARROW {
            for k in 1..i {
                let c = l[k - 1] + r[i - k - 1];
                if c < cost[i - 1] {
                    cost[i - 1] = c;
                    self.share[index][i - 1] = k as u8;
                }
            }
        }
        // A node around the best eight, or a leaf.
        cost[0] = area + cost[NARROW - 1];
        if fits_leaf && area * LEAF_COST <= cost[0] {
            cost[0] = area * LEAF_COST;
            self.fewer[index] |= 1;
        }
        for i in 1..NARROW {
            if cost[i - 1] <= cost[i] {
                cost[i] = cost[i - 1];
                self.fewer[index] |= 1 << i;
            }
        }
        self.cost[index] = cost;
    }

    fn is_leaf(&self, index: usize) -> bool {
        self.fewer[index] & 1 != 0
    }

    /// The binary nodes that become the children of the wide node at the inner binary node `index`.
    fn children(&self, binary: &Bvh2, index: usize) -> Vec<usize> {
        let mut children = Vec::with_capacity(NARROW);
        let mut pending = self.halves(binary, index, NARROW).to_vec();
        while let Some((node, mut slots)) = pending.pop() {
            while slots > 1 && self.fewer[node] >> (slots - 1) & 1 != 0 {
                slots -= 1;
            }
            if slots == 1 {
                children.push(node);
            } else {
                pending.extend(self.halves(binary, node, slots));
            }
        }
        children
    }

    fn halves(&self, binary: &Bvh2, index: usize, slots: usize) -> [(usize, usize); 2] {
        let share = self.share[index][slots - 1] as usize;
        let left = left(&binary.nodes[index]);
        [(left, share), (left + 1, slots - share)]
    }
}

fn parents_first(binary: &Bvh2) -> Vec<usize> {
    let mut order = Vec::with_capacity(binary.nodes.len());
    let mut pending = vec![0];
    while let Some(index) = pending.pop() {
        order.push(index);
        let node = &binary.nodes[index];
        if !node.is_leaf() {
            pending.extend([left(node), left(node) + 1]);
        }
    }
    order
}

struct Emitter<'a> {
    binary: &'a Bvh2,
    plan: Plan,
    boxes: &'a [Aabb],
    max_leaf: usize,
    tree: Tree,
}

impl Emitter<'_> {
    fn fill_node(&mut self, slot: usize, children: &[usize], depth: usize) {
        let mut node = empty_node();
        for (lane, &child) in children.iter().enumerate() {
            let b = self.binary.nodes[child].aabb();
            set_child(
                &mut node,
                lane,
                Aabb {
                    min: b.min.into(),
                    max: b.max.into(),
                },
            );
        }
        set_order(&mut node, children.len());
        // Siblings stand side by side, so the words of all are known before any is filled.
        for (lane, &child) in children.iter().enumerate() {
            node.children[lane] = if self.plan.is_leaf(child) {
                let items = self.items_below(child);
                self.add_leaf(&items)
            } else {
                self.tree.nodes.push(empty_node());
                (self.tree.nodes.len() - 1) as u32
            };
        }
        for (lane, &child) in children.iter().enumerate() {
            let word = node.children[lane];
            if word & LEAF != 0 {
                continue;
            }
            if depth < BALANCED_DEPTH {
                let grandchildren = self.plan.children(self.binary, child);
                self.fill_node(word as usize, &grandchildren, depth + 1);
            } else {
                let items = self.items_below(child);
                self.fill_balanced(word as usize, &items);
            }
        }
        self.tree.nodes[slot] = node;
    }

    /// Bounds the depth where the binary tree is pathologically deep (coincident or nested items).
    fn fill_balanced(&mut self, slot: usize, items: &[u32]) {
        let mut node = empty_node();
        let chunk = items.len().div_ceil(NARROW).max(self.max_leaf);
        let mut count = 0;
        for (lane, part) in items.chunks(chunk).enumerate() {
            let bounds = part
                .iter()
                .fold(Aabb::EMPTY, |all, &i| all.union(self.boxes[i as usize]));
            set_child(&mut node, lane, bounds);
            count = lane + 1;
            node.children[lane] = if part.len() <= self.max_leaf {
                self.add_leaf(part)
            } else {
                self.tree.nodes.push(empty_node());
                let child = self.tree.nodes.len() - 1;
                self.fill_balanced(child, part);
                child as u32
            };
        }
        set_order(&mut node, count);
        self.tree.nodes[slot] = node;
    }

    fn add_leaf(&mut self, items: &[u32]) -> u32 {
        self.tree.leaves.push(self.tree.items.len() as u32);
        self.tree.items.extend_from_slice(items);
        LEAF | (self.tree.leaves.len() - 1) as u32
    }

    fn items_below(&self, index: usize) -> Vec<u32> {
        let mut items = Vec::new();
        let mut pending = vec![index];
        while let Some(index) = pending.pop() {
            let node = &self.binary.nodes[index];
            if node.is_leaf() {
                let first = left(node);
                items.extend_from_slice(
                    &self.binary.primitive_indices[first..first + node.prim_count as usize],
                );
            } else {
                pending.extend([left(node), left(node) + 1]);
            }
        }
        items
    }
}

fn empty_node() -> Node {
    let mut bounds = [[f32::INFINITY; NARROW]; 6];
    bounds[3..].fill([f32::NEG_INFINITY; NARROW]);
    Node {
        bounds,
        children: [0; NARROW],
        order: [0; NARROW],
    }
}

fn set_child(node: &mut Node, lane: usize, bounds: Aabb) {
    for axis in 0..3 {
        node.bounds[axis][lane] = bounds.min[axis];
        node.bounds[axis + 3][lane] = bounds.max[axis];
    }
}

fn set_order(node: &mut Node, count: usize) {
    let center = |i: usize| {
        Vec3::from_array(std::array::from_fn(|a| {
            0.5 * node.bounds[a][i] + 0.5 * node.bounds[a + 3][i]
        }))
    };
    node.order = std::array::from_fn(|octant| {
        let direction = Vec3::from_array(std::array::from_fn(|a| {
            if octant >> a & 1 == 0 { 1.0 } else { -1.0 }
        }));
        let mut lanes: [usize; NARROW] = std::array::from_fn(|i| i);
        lanes[..count].sort_by(|&i, &j| {
            center(j)
                .dot(direction)
                .total_cmp(&center(i).dot(direction))
        });
        lanes
            .iter()
            .rev()
            .fold(0, |word, &lane| word << 3 | lane as u32)
    });
}
