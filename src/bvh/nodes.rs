//! The wide BVH that the CPU traverses: eight children a node, their boxes as floats in SIMD layout.
//!
//! In: a binary tree over boxes. Out: nodes in depth-first order. The collapse minimises the cost by the surface area
//! heuristic with dynamic programming (Ylitie et al. 2017, section 3.1).

use obvhs::{aabb::Aabb, bvh2::Bvh2};

use super::simd::Eight;

/// Most children of a node.
pub(super) const WIDTH: usize = 8;

/// A reference to a child: an inner node, or the contiguous primitives of a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub(super) struct Child(u32);

impl Child {
    const LEAF: u32 = 1 << 31;
    const COUNT_BITS: u32 = 3;

    /// A leaf without primitives.
    pub(super) const EMPTY: Self = Self(Self::LEAF);

    /// Most primitives in a leaf.
    pub(super) const MAX_COUNT: usize = (1 << Self::COUNT_BITS) - 1;

    pub(super) fn node(index: usize) -> Self {
        assert!(index < Self::LEAF as usize, "node index out of range");
        Self(index as u32)
    }

    pub(super) fn leaf(first: usize, count: usize) -> Self {
        assert!(first < (Self::LEAF >> Self::COUNT_BITS) as usize, "primitive index out of range");
        assert!(count <= Self::MAX_COUNT);
        Self(Self::LEAF | (first as u32) << Self::COUNT_BITS | count as u32)
    }

    #[inline(always)]
    pub(super) fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }

    /// Index of the inner node.
    #[inline(always)]
    pub(super) fn index(self) -> usize {
        self.0 as usize
    }

    /// Primitives of the leaf.
    #[inline(always)]
    pub(super) fn range(self) -> std::ops::Range<usize> {
        let first = ((self.0 & !Self::LEAF) >> Self::COUNT_BITS) as usize;
        first..first + (self.0 as usize & Self::MAX_COUNT)
    }

    /// This child after `nodes` and `primitives` are inserted before it.
    pub(super) fn offset(self, nodes: usize, primitives: usize) -> Self {
        if self.is_leaf() {
            let range = self.range();
            Self::leaf(range.start + primitives, range.len())
        } else {
            Self::node(self.index() + nodes)
        }
    }
}

/// A node: the boxes of its children, and the children.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// Lower and upper planes of each axis. Unused lanes have empty boxes.
    pub(super) planes: [[Eight; 2]; 3],
    pub(super) children: [Child; WIDTH],
    /// Pads to four cache lines.
    padding: [u32; 8],
}

impl Node {
    const EMPTY: Self = Self {
        planes: [[[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]]; 3],
        children: [Child::EMPTY; WIDTH],
        padding: [0; 8],
    };

    fn set(&mut self, lane: usize, bounds: &Aabb) {
        for axis in 0..3 {
            self.planes[axis][0][lane] = bounds.min[axis];
            self.planes[axis][1][lane] = bounds.max[axis];
        }
    }
}

/// Cost of a leaf, relative to testing the boxes of a node.
#[derive(Clone, Copy, Debug)]
pub(super) struct LeafCost {
    /// Primitives per test.
    pub(super) batch: usize,
    /// Most tests per leaf.
    pub(super) max_tests: usize,
    /// Cost of a test.
    pub(super) cost: f32,
}

/// A wide BVH; node indices start at zero.
#[derive(Clone, Debug)]
pub(super) struct WideTree {
    pub(super) nodes: Vec<Node>,
    /// A leaf if the tree is a single leaf.
    pub(super) root: Child,
    /// Most nodes on a path from the root to a leaf.
    pub(super) depth: usize,
}

/// Collapses a non-empty binary tree. `make_leaf` stores a leaf's primitives and returns the leaf.
pub(super) fn collapse(tree: &Bvh2, cost: LeafCost, mut make_leaf: impl FnMut(&[u32]) -> Child) -> WideTree {
    let plan = Plan::new(tree, cost);
    let mut wide = WideTree { nodes: Vec::new(), root: Child::EMPTY, depth: 0 };
    let mut primitives = Vec::new();
    // Pending nodes: (index in the binary tree, parent and lane, depth).
    let mut pending = vec![(0, None, 1)];
    while let Some((index, parent, depth)) = pending.pop() {
        let child = if plan.0[index].is_leaf {
            primitives.clear();
            collect_primitives(tree, index, &mut primitives);
            make_leaf(&primitives)
        } else {
            let mut children = plan.children(tree, index);
            let area = |&child: &usize| tree.nodes[child].aabb().half_area();
            children.sort_by(|a, b| area(b).total_cmp(&area(a)));
            let new_index = wide.nodes.len();
            let mut node = Node::EMPTY;
            for (lane, &child) in children.iter().enumerate() {
                node.set(lane, tree.nodes[child].aabb());
            }
            let children = children.into_iter().enumerate();
            pending.extend(children.map(|(lane, child)| (child, Some((new_index, lane)), depth + 1)).rev());
            wide.nodes.push(node);
            wide.depth = wide.depth.max(depth);
            Child::node(new_index)
        };
        match parent {
            Some((node, lane)) => wide.nodes[node].children[lane] = child,
            None => wide.root = child,
        }
    }
    wide
}

/// Collects the primitives below a node of the binary tree.
fn collect_primitives(tree: &Bvh2, root: usize, primitives: &mut Vec<u32>) {
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

/// The optimal collapse of a binary tree: a decision for each of its nodes.
struct Plan(Vec<Decision>);

/// The optimal collapse of a subtree.
#[derive(Clone, Copy, Debug, Default)]
struct Decision {
    /// As a single child: whether to make a leaf.
    is_leaf: bool,
    /// As up to k children, k from 2 to [`WIDTH`]: whether k - 1 cost no more.
    fewer: [bool; WIDTH + 1],
    /// Otherwise: how many of the k go to the left subtree.
    to_left: [u8; WIDTH + 1],
}

impl Plan {
    fn new(tree: &Bvh2, leaf: LeafCost) -> Self {
        let mut decisions = vec![Decision::default(); tree.nodes.len()];
        // The cost of each subtree as at most k children, by k.
        let mut costs = vec![[0.0f32; WIDTH + 1]; tree.nodes.len()];
        let mut sizes = vec![0usize; tree.nodes.len()];
        for index in post_order(tree) {
            let node = &tree.nodes[index];
            let area = node.aabb().half_area();
            let left = node.first_index as usize;
            sizes[index] =
                if node.is_leaf() { node.prim_count as usize } else { sizes[left] + sizes[left + 1] };
            let tests = sizes[index].div_ceil(leaf.batch);
            let as_leaf = area * leaf.cost * tests as f32;
            if node.is_leaf() {
                decisions[index].is_leaf = true;
                costs[index] = [as_leaf; WIDTH + 1];
                continue;
            }
            let decision = &mut decisions[index];
            let mut cost = [0.0; WIDTH + 1];
            for k in 2..=WIDTH {
                let split = |to_left: usize| costs[left][to_left] + costs[left + 1][k - to_left];
                let best = (1..k).min_by(|&a, &b| split(a).total_cmp(&split(b))).unwrap_or(1);
                decision.to_left[k] = best as u8;
                cost[k] = split(best);
            }
            let as_node = area + cost[WIDTH];
            decision.is_leaf = tests <= leaf.max_tests && as_leaf <= as_node;
            cost[1] = if decision.is_leaf { as_leaf } else { as_node };
            for k in 2..=WIDTH {
                decision.fewer[k] = cost[k - 1] <= cost[k];
                cost[k] = cost[k].min(cost[k - 1]);
            }
            costs[index] = cost;
        }
        Self(decisions)
    }

    /// The children of the wide node that replaces the binary tree's inner node `index`.
    fn children(&self, tree: &Bvh2, index: usize) -> Vec<usize> {
        let mut children = Vec::with_capacity(WIDTH);
        let split = |index: usize, k: usize| {
            let (left, to_left) = (tree.nodes[index].first_index as usize, self.0[index].to_left[k] as usize);
            [(left + 1, k - to_left), (left, to_left)]
        };
        let mut pending = split(index, WIDTH).to_vec();
        while let Some((index, k)) = pending.pop() {
            if k == 1 || tree.nodes[index].is_leaf() {
                children.push(index);
            } else if self.0[index].fewer[k] {
                pending.push((index, k - 1));
            } else {
                pending.extend(split(index, k));
            }
        }
        children
    }
}

/// The nodes of a binary tree in post-order: each after its children.
fn post_order(tree: &Bvh2) -> Vec<usize> {
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
