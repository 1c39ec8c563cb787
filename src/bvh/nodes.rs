//! The wide BVH that the CPU traverses: four children a node, their boxes side by side as floats.
//!
//! In: a binary tree over boxes. Out: nodes in depth-first order. Which nodes of the binary tree stay, and
//! where leaves begin, is the choice of least cost by the surface area heuristic (Ylitie et al. 2017,
//! section 3.1), found by dynamic programming.

use obvhs::{aabb::Aabb, bvh2::Bvh2};

use super::simd::Eight;

/// Children of a node.
pub(super) const WIDTH: usize = 8;

/// What a node's child is: a node, or a run of things in leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub(super) struct Child(u32);

impl Child {
    const LEAF: u32 = 1 << 31;
    const COUNT_BITS: u32 = 3;

    /// A leaf without anything in it.
    pub(super) const NOTHING: Self = Self(Self::LEAF);

    /// Most things in a leaf.
    pub(super) const MOST: usize = (1 << Self::COUNT_BITS) - 1;

    pub(super) fn node(index: usize) -> Self {
        assert!(index < Self::LEAF as usize, "more nodes than an index can count");
        Self(index as u32)
    }

    pub(super) fn leaf(first: usize, count: usize) -> Self {
        assert!(first < (Self::LEAF >> Self::COUNT_BITS) as usize, "more leaves than an index can count");
        assert!(count <= Self::MOST);
        Self(Self::LEAF | (first as u32) << Self::COUNT_BITS | count as u32)
    }

    #[inline(always)]
    pub(super) fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }

    /// Index of the node that it is.
    #[inline(always)]
    pub(super) fn index(self) -> usize {
        self.0 as usize
    }

    /// What lies in the leaf that it is.
    #[inline(always)]
    pub(super) fn run(self) -> std::ops::Range<usize> {
        let first = ((self.0 & !Self::LEAF) >> Self::COUNT_BITS) as usize;
        first..first + (self.0 as usize & Self::MOST)
    }

    /// The same child after `nodes` more nodes and `things` more things.
    pub(super) fn moved(self, nodes: usize, things: usize) -> Self {
        if self.is_leaf() {
            let run = self.run();
            Self::leaf(run.start + things, run.len())
        } else {
            Self::node(self.index() + nodes)
        }
    }
}

/// A node: the boxes of its children, and the children.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// Lower and upper planes of each axis. A child that is not there has an empty box.
    pub(super) planes: [[Eight; 2]; 3],
    pub(super) children: [Child; WIDTH],
    /// Up to four cache lines.
    padding: [u32; 8],
}

impl Node {
    const EMPTY: Self = Self {
        planes: [[[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]]; 3],
        children: [Child::NOTHING; WIDTH],
        padding: [0; 8],
    };

    fn set(&mut self, lane: usize, bounds: &Aabb) {
        for axis in 0..3 {
            self.planes[axis][0][lane] = bounds.min[axis];
            self.planes[axis][1][lane] = bounds.max[axis];
        }
    }
}

/// What a leaf costs, where testing the boxes of a node costs 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct LeafCost {
    /// Things that are tested at a time.
    pub(super) at_a_time: usize,
    /// Most of these in a leaf.
    pub(super) most: usize,
    /// Cost of a test.
    pub(super) cost: f32,
}

/// A wide BVH; indices of its nodes from zero.
#[derive(Clone, Debug)]
pub(super) struct WideTree {
    pub(super) nodes: Vec<Node>,
    /// Where to start; a leaf if there is only one.
    pub(super) root: Child,
    /// Most nodes on the way from the root to a leaf.
    pub(super) depth: usize,
}

/// Widens `tree`, a tree of at least one leaf. `make_leaf` lays out a leaf's primitives and returns where.
pub(super) fn widen(tree: &Bvh2, cost: LeafCost, mut make_leaf: impl FnMut(&[u32]) -> Child) -> WideTree {
    let plan = Plan::new(tree, cost);
    let mut wide = WideTree { nodes: Vec::new(), root: Child::NOTHING, depth: 0 };
    let mut primitives = Vec::new();
    // Nodes still to be made: (node of the binary tree, where to note its index, depth).
    let mut pending = vec![(0, None, 1)];
    while let Some((index, parent, depth)) = pending.pop() {
        let child = if plan.0[index].is_leaf {
            primitives.clear();
            gather(tree, index, &mut primitives);
            make_leaf(&primitives)
        } else {
            let mut members = plan.members(tree, index);
            let area = |&member: &usize| tree.nodes[member].aabb().half_area();
            members.sort_by(|a, b| area(b).total_cmp(&area(a)));
            let made = wide.nodes.len();
            let mut node = Node::EMPTY;
            for (lane, &member) in members.iter().enumerate() {
                node.set(lane, tree.nodes[member].aabb());
            }
            let members = members.into_iter().enumerate();
            pending.extend(members.map(|(lane, member)| (member, Some((made, lane)), depth + 1)).rev());
            wide.nodes.push(node);
            wide.depth = wide.depth.max(depth);
            Child::node(made)
        };
        match parent {
            Some((node, lane)) => wide.nodes[node].children[lane] = child,
            None => wide.root = child,
        }
    }
    wide
}

/// Primitives below a node of the binary tree.
fn gather(tree: &Bvh2, root: usize, primitives: &mut Vec<u32>) {
    let mut pending = vec![root];
    while let Some(index) = pending.pop() {
        let node = &tree.nodes[index];
        let first = node.first_index as usize;
        if node.is_leaf() {
            primitives.extend(&tree.primitive_indices[first..first + node.prim_count as usize]);
        } else {
            pending.extend([first + 1, first]);
        }
    }
}

/// The cheapest way to widen a binary tree.
struct Plan(Vec<Choice>);

/// What the cheapest way does with a subtree.
#[derive(Clone, Copy, Debug, Default)]
struct Choice {
    /// Where it must be one child: whether that is a leaf.
    is_leaf: bool,
    /// Where it may be k children, from 2 to [`WIDTH`]: whether fewer are as cheap.
    fewer: [bool; WIDTH + 1],
    /// If not: how many of the k its left half gets.
    to_left: [u8; WIDTH + 1],
}

impl Plan {
    fn new(tree: &Bvh2, leaf: LeafCost) -> Self {
        let mut choices = vec![Choice::default(); tree.nodes.len()];
        // The cost of a subtree as at most k children, by k.
        let mut costs = vec![[0.0f32; WIDTH + 1]; tree.nodes.len()];
        let mut sizes = vec![0usize; tree.nodes.len()];
        for index in children_first(tree) {
            let node = &tree.nodes[index];
            let area = node.aabb().half_area();
            let left = node.first_index as usize;
            sizes[index] =
                if node.is_leaf() { node.prim_count as usize } else { sizes[left] + sizes[left + 1] };
            let tests = sizes[index].div_ceil(leaf.at_a_time);
            let as_leaf = area * leaf.cost * tests as f32;
            if node.is_leaf() {
                choices[index].is_leaf = true;
                costs[index] = [as_leaf; WIDTH + 1];
                continue;
            }
            let choice = &mut choices[index];
            let mut cost = [0.0; WIDTH + 1];
            for k in 2..=WIDTH {
                let split = |to_left: usize| costs[left][to_left] + costs[left + 1][k - to_left];
                let best = (1..k).min_by(|&a, &b| split(a).total_cmp(&split(b))).unwrap_or(1);
                choice.to_left[k] = best as u8;
                cost[k] = split(best);
            }
            let as_node = area + cost[WIDTH];
            choice.is_leaf = tests <= leaf.most && as_leaf <= as_node;
            cost[1] = if choice.is_leaf { as_leaf } else { as_node };
            for k in 2..=WIDTH {
                choice.fewer[k] = cost[k - 1] <= cost[k];
                cost[k] = cost[k].min(cost[k - 1]);
            }
            costs[index] = cost;
        }
        Self(choices)
    }

    /// The children of the wide node that stands for the binary tree's inner node `index`.
    fn members(&self, tree: &Bvh2, index: usize) -> Vec<usize> {
        let mut members = Vec::with_capacity(WIDTH);
        let split = |index: usize, k: usize| {
            let (left, to_left) = (tree.nodes[index].first_index as usize, self.0[index].to_left[k] as usize);
            [(left + 1, k - to_left), (left, to_left)]
        };
        let mut pending = split(index, WIDTH).to_vec();
        while let Some((index, k)) = pending.pop() {
            if k == 1 || tree.nodes[index].is_leaf() {
                members.push(index);
            } else if self.0[index].fewer[k] {
                pending.push((index, k - 1));
            } else {
                pending.extend(split(index, k));
            }
        }
        members
    }
}

/// All nodes of a binary tree, each after its children.
fn children_first(tree: &Bvh2) -> Vec<usize> {
    let mut order = Vec::with_capacity(tree.nodes.len());
    let mut pending = vec![0];
    while let Some(index) = pending.pop() {
        order.push(index);
        let node = &tree.nodes[index];
        if !node.is_leaf() {
            let first = node.first_index as usize;
            pending.extend([first, first + 1]);
        }
    }
    order.reverse();
    order
}
