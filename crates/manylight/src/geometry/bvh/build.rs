//! From boxes to a tree of eight-wide nodes.
//!
//! Which nodes of a binary tree become wide nodes and which leaves is decided by dynamic programming over the surface area
//! heuristic: Ylitie et al., "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017, section 3.1.
//! A leaf costs the same for one item as for eight.
//! Subtrees are decided and written in parallel; where they are cut off does not depend on the number of threads.

use super::binary::{BinaryNode, binary_tree};
use crate::math::{Aabb, Vec3};
use crate::simd::NARROW;
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::atomic::{AtomicU32, Ordering};

/// A child word with this bit names a leaf, without it a node. 0 is no child: the root is nobody's child.
pub(super) const LEAF: u32 = 1 << 31;

/// Most levels of nodes; the size of the traversal stack follows from it.
pub(super) const MAX_DEPTH: usize = 36;

/// Below this depth subtrees are split evenly: eleven more levels hold 2^33 items.
const BALANCED_DEPTH: usize = MAX_DEPTH - 11;

/// Cost of testing a leaf in units of the cost of testing a node.
const LEAF_COST: f32 = 1.2;

/// Eight boxes and what is in them, in four cache lines.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct WideNode {
    /// Lower x, y, z, upper x, y, z of the children. Empty places have lower = +∞ and upper = -∞.
    pub(super) bounds: [[f32; NARROW]; 6],
    /// See [`LEAF`].
    pub(super) children: [u32; NARROW],
    /// For each octant of directions (bit a set: component a is negative) the children from far to near, three bits each.
    /// The eight bits that are left belong to one child each, see [`WideNode::items_below`].
    pub(super) order: [u32; NARROW],
}

impl WideNode {
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
pub(super) struct WideTree {
    /// The root is the first, if there is any.
    pub(super) nodes: Vec<WideNode>,
    /// The items in leaf order.
    pub(super) items: Vec<u32>,
    /// Leaf `i` holds `items[leaves[i]..leaves[i + 1]]`.
    pub(super) leaves: Vec<u32>,
    /// Box around everything.
    pub(super) bounds: Option<Aabb>,
}

impl WideTree {
    /// Builds a tree with at most `max_leaf` items per leaf. All boxes must be finite and not empty.
    pub(super) fn new(boxes: &[Aabb], max_leaf: usize) -> Self {
        if boxes.is_empty() {
            return WideTree::default();
        }
        let binary = binary_tree(boxes);
        let emitter = TreeWriter {
            binary: &binary,
            plan: CollapsePlan::new(&binary, max_leaf),
            boxes,
            max_leaf,
        };
        let mut tree = emitter.tree();
        tree.leaves.push(tree.items.len() as u32);
        tree.note_items_below();
        tree.bounds = Some(binary[0].bounds);
        tree
    }

    /// The word for a leaf that holds the items added from now on.
    fn begin_leaf(&mut self) -> u32 {
        self.leaves.push(self.items.len() as u32);
        LEAF | (self.leaves.len() - 1) as u32
    }

    /// Appends a subtree, and says where its root stands now.
    fn append(&mut self, mut part: WideTree) -> u32 {
        let (nodes, leaves) = (self.nodes.len() as u32, self.leaves.len() as u32);
        let items = self.items.len() as u32;
        for word in part.nodes.iter_mut().flat_map(|node| &mut node.children) {
            *word += match *word {
                0 => 0,
                leaf if leaf & LEAF != 0 => leaves,
                _ => nodes,
            };
        }
        self.nodes.append(&mut part.nodes);
        self.leaves
            .extend(part.leaves.iter().map(|first| first + items));
        self.items.append(&mut part.items);
        nodes
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

/// For each binary node the cheapest way to represent it by up to `i` wide subtrees, for `i` = 1 to 8: words of [`Choices`],
/// atomic because several threads write, each to nodes of its own.
struct CollapsePlan(Vec<AtomicU32>);

/// The choices at a binary node, in one word.
#[derive(Clone, Copy)]
struct Choices(u32);

/// What a parent must know of a subtree to choose.
#[derive(Clone, Copy)]
struct Priced {
    /// At `i - 1`: cost of up to `i` wide subtrees.
    cost: [f32; NARROW],
    items: u32,
}

impl Choices {
    /// `share[i - 1]` of the `i` subtrees go to the left child. Bit `i - 1` of `fewer`: `i - 1` subtrees are no dearer than
    /// `i`. Its bit 0: this node becomes a leaf.
    fn new(share: [u32; NARROW], fewer: u32) -> Self {
        // One subtree has nothing to share: the first place is that of `fewer`.
        let shares = (1..NARROW).fold(0, |word, i| word | share[i] << (3 * i + 5));
        Choices(shares | fewer)
    }

    fn is_leaf(self) -> bool {
        self.0 & 1 != 0
    }

    fn takes_fewer(self, slots: usize) -> bool {
        self.0 >> (slots - 1) & 1 != 0
    }

    fn share(self, slots: usize) -> usize {
        (self.0 >> (3 * slots + 2) & 7) as usize
    }
}

impl CollapsePlan {
    fn new(binary: &[BinaryNode], max_leaf: usize) -> Self {
        let leaf = Choices::new([0; NARROW], u32::from(u8::MAX));
        let words = binary.par_iter().map(|_| AtomicU32::new(leaf.0));
        let plan = CollapsePlan(words.collect());
        let subtrees = subtrees(binary);
        let below: HashMap<usize, Priced> = subtrees
            .into_par_iter()
            .map(|root| (root, plan.price(binary, root, max_leaf, |_| None)))
            .collect();
        plan.price(binary, 0, max_leaf, |index| below.get(&index).copied());
        plan
    }

    /// Chooses at all nodes below `root`, down to those that are `known`.
    fn price(
        &self,
        binary: &[BinaryNode],
        root: usize,
        max_leaf: usize,
        known: impl Fn(usize) -> Option<Priced>,
    ) -> Priced {
        // Each node, its right subtree, its left subtree: from the end, both children come right before their parent.
        let (mut order, mut pending) = (Vec::new(), vec![root]);
        while let Some(index) = pending.pop() {
            order.push(index);
            let children = binary[index].children().into_iter().flatten();
            pending.extend(children.filter(|_| known(index).is_none()));
        }
        let mut priced: Vec<Priced> = Vec::new();
        for index in order.into_iter().rev() {
            let node = &binary[index];
            let price = if let Some(price) = known(index) {
                price
            } else if node.item().is_some() {
                Priced {
                    cost: [node.half_area() * LEAF_COST; NARROW],
                    items: 1,
                }
            } else {
                let [.., left, right] = &priced[..] else {
                    unreachable!("invariant: children come before their parent")
                };
                let (price, choices) = choose(node, left, right, max_leaf);
                self.0[index].store(choices.0, Ordering::Relaxed);
                priced.truncate(priced.len() - 2);
                price
            };
            priced.push(price);
        }
        priced[0]
    }

    fn at(&self, index: usize) -> Choices {
        Choices(self.0[index].load(Ordering::Relaxed))
    }

    /// The binary nodes that become the children of the wide node at the inner binary node `index`.
    fn children(&self, binary: &[BinaryNode], index: usize) -> Vec<usize> {
        let mut children = Vec::with_capacity(NARROW);
        let mut pending = self.halves(binary, index, NARROW).to_vec();
        while let Some((node, mut slots)) = pending.pop() {
            while slots > 1 && self.at(node).takes_fewer(slots) {
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

    fn halves(&self, binary: &[BinaryNode], index: usize, slots: usize) -> [(usize, usize); 2] {
        let share = self.at(index).share(slots);
        let [left, right] = binary[index]
            .children()
            .expect("invariant: only inner nodes take several slots");
        [(left, share), (right, slots - share)]
    }
}

fn choose(node: &BinaryNode, left: &Priced, right: &Priced, max_leaf: usize) -> (Priced, Choices) {
    let (area, items) = (node.half_area(), left.items.saturating_add(right.items));
    let mut cost = [f32::INFINITY; NARROW];
    let (mut share, mut fewer) = ([0; NARROW], 0);
    for k in 1..NARROW {
        for i in k..NARROW {
            let c = left.cost[k - 1] + right.cost[i - k];
            if c < cost[i] {
                (cost[i], share[i]) = (c, k as u32);
            }
        }
    }
    // A node around the best eight, or a leaf.
    cost[0] = area + cost[NARROW - 1];
    if items as usize <= max_leaf && area * LEAF_COST <= cost[0] {
        cost[0] = area * LEAF_COST;
        fewer |= 1;
    }
    for i in 1..NARROW {
        if cost[i - 1] <= cost[i] {
            cost[i] = cost[i - 1];
            fewer |= 1 << i;
        }
    }
    (Priced { cost, items }, Choices::new(share, fewer))
}

/// Roots of disjoint subtrees that hold all leaves, enough of them to keep many threads busy.
fn subtrees(binary: &[BinaryNode]) -> Vec<usize> {
    const ENOUGH: usize = 1024;
    /// Bounds the effort where the tree is more of a list.
    const LEVELS: usize = 16;
    let mut level = vec![0];
    for _ in 0..LEVELS {
        if level.len() >= ENOUGH {
            break;
        }
        let below = level.iter().flat_map(|&index| {
            let [left, right] = binary[index].children().unwrap_or([index; 2]);
            left..=right
        });
        level = below.collect();
    }
    level
}

/// Writes the wide nodes.
struct TreeWriter<'a> {
    binary: &'a [BinaryNode],
    plan: CollapsePlan,
    boxes: &'a [Aabb],
    max_leaf: usize,
}

/// Subtrees below nodes of this depth are written in parallel.
const CUT_DEPTH: usize = 3;

/// A place in the upper part of the tree for a subtree that is written apart.
struct Cut {
    slot: usize,
    lane: usize,
    /// The binary node of its root.
    root: usize,
}

impl TreeWriter<'_> {
    fn tree(&self) -> WideTree {
        let mut tree = WideTree::default();
        // The root is always a node, even over a single leaf: traversal has one case less.
        let children = if self.binary[0].item().is_some() {
            vec![0]
        } else {
            self.plan.children(self.binary, 0)
        };
        let mut cuts = Vec::new();
        tree.nodes.push(empty_node());
        self.fill_node(&mut tree, 0, &children, 1, &mut cuts);
        let parts: Vec<WideTree> = cuts.par_iter().map(|cut| self.part(cut)).collect();
        for (cut, part) in cuts.iter().zip(parts) {
            let root = tree.append(part);
            tree.nodes[cut.slot].children[cut.lane] = root;
        }
        tree
    }

    fn part(&self, cut: &Cut) -> WideTree {
        let mut part = WideTree::default();
        let children = self.plan.children(self.binary, cut.root);
        part.nodes.push(empty_node());
        self.fill_node(&mut part, 0, &children, CUT_DEPTH + 1, &mut Vec::new());
        part
    }

    fn fill_node(
        &self,
        tree: &mut WideTree,
        slot: usize,
        children: &[usize],
        depth: usize,
        cuts: &mut Vec<Cut>,
    ) {
        let mut node = empty_node();
        for (lane, &child) in children.iter().enumerate() {
            set_child(&mut node, lane, self.binary[child].bounds);
        }
        set_order(&mut node, children.len());
        // Siblings stand side by side, so the words of all are known before any is filled.
        for (lane, &child) in children.iter().enumerate() {
            node.children[lane] = if self.plan.at(child).is_leaf() {
                self.add_leaf(tree, child)
            } else if depth == CUT_DEPTH {
                let root = child;
                cuts.push(Cut { slot, lane, root });
                0
            } else {
                tree.nodes.push(empty_node());
                (tree.nodes.len() - 1) as u32
            };
        }
        for (lane, &child) in children.iter().enumerate() {
            let word = node.children[lane];
            if word == 0 || word & LEAF != 0 {
                continue;
            }
            if depth < BALANCED_DEPTH {
                let grandchildren = self.plan.children(self.binary, child);
                self.fill_node(tree, word as usize, &grandchildren, depth + 1, cuts);
            } else {
                let mut items = Vec::new();
                self.collect_items(child, &mut items);
                self.fill_balanced(tree, word as usize, &items);
            }
        }
        tree.nodes[slot] = node;
    }

    /// Bounds the depth where the binary tree is pathologically deep (coincident or nested items).
    fn fill_balanced(&self, tree: &mut WideTree, slot: usize, items: &[u32]) {
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
                let word = tree.begin_leaf();
                tree.items.extend_from_slice(part);
                word
            } else {
                tree.nodes.push(empty_node());
                let child = tree.nodes.len() - 1;
                self.fill_balanced(tree, child, part);
                child as u32
            };
        }
        set_order(&mut node, count);
        tree.nodes[slot] = node;
    }

    fn add_leaf(&self, tree: &mut WideTree, index: usize) -> u32 {
        let word = tree.begin_leaf();
        self.collect_items(index, &mut tree.items);
        word
    }

    /// Appends the items below a binary node.
    fn collect_items(&self, index: usize, items: &mut Vec<u32>) {
        let mut pending = vec![index];
        while let Some(index) = pending.pop() {
            let node = &self.binary[index];
            items.extend(node.item());
            pending.extend(node.children().into_iter().flatten());
        }
    }
}

fn empty_node() -> WideNode {
    let mut bounds = [[f32::INFINITY; NARROW]; 6];
    bounds[3..].fill([f32::NEG_INFINITY; NARROW]);
    WideNode {
        bounds,
        children: [0; NARROW],
        order: [0; NARROW],
    }
}

fn set_child(node: &mut WideNode, lane: usize, bounds: Aabb) {
    for axis in 0..3 {
        node.bounds[axis][lane] = bounds.min[axis];
        node.bounds[axis + 3][lane] = bounds.max[axis];
    }
}

fn set_order(node: &mut WideNode, count: usize) {
    let center = |i: usize| {
        Vec3::from_array(std::array::from_fn(|a| {
            0.5 * node.bounds[a][i] + 0.5 * node.bounds[a + 3][i]
        }))
    };
    let centers: [Vec3; NARROW] = std::array::from_fn(center);
    node.order = std::array::from_fn(|octant| {
        let direction = Vec3::from_array(std::array::from_fn(|a| {
            if octant >> a & 1 == 0 { 1.0 } else { -1.0 }
        }));
        let distances = centers.map(|center| center.dot(direction));
        let mut lanes: [usize; NARROW] = std::array::from_fn(|i| i);
        lanes[..count].sort_by(|&i, &j| distances[j].total_cmp(&distances[i]));
        lanes
            .iter()
            .rev()
            .fold(0, |word, &lane| word << 3 | lane as u32)
    });
}
