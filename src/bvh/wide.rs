//! The compressed wide BVH that shaders traverse (Ylitie et al. 2017), with a bound on its depth.
//!
//! In: boxes and a binary tree over them. Out: obvhs's CWBVH. Nested boxes can make a tree arbitrarily deep; then a
//! median-split tree replaces it, so that traversal stacks have a fixed size.

use obvhs::{
    aabb::Aabb,
    bvh2::Bvh2,
    cwbvh::{CwBvh, bvh2_to_cwbvh::bvh2_to_cwbvh, node::CwBvhNode},
};

use super::tree::median_split;

/// Most nodes on a path from a bottom level's root to a leaf.
pub(super) const BOTTOM_DEPTH: usize = 24;

/// Most nodes on a path from a top level's root to a leaf.
pub(super) const TOP_DEPTH: usize = 14;

/// Most primitives in a leaf.
const LEAF_SIZE: u32 = 3;

/// Collapses and compresses `tree`, which is over `boxes`; without boxes the result has no nodes.
pub(super) fn compress(tree: &Bvh2, boxes: &[Aabb], leaf_size: u32, max_depth: usize) -> CwBvh {
    if boxes.is_empty() {
        return CwBvh::default();
    }
    let leaf_size = leaf_size.min(LEAF_SIZE);
    let bvh = bvh2_to_cwbvh(tree, leaf_size, true, false);
    if depth(&bvh.nodes) <= max_depth {
        return bvh;
    }
    let bvh = bvh2_to_cwbvh(&median_split(boxes), leaf_size, true, false);
    assert!(depth(&bvh.nodes) <= max_depth, "a balanced tree is shallow");
    bvh
}

/// Nodes on the longest path from the root to a leaf.
fn depth(nodes: &[CwBvhNode]) -> usize {
    let mut deepest = 0;
    let mut pending = vec![(0u32, 1)];
    while let Some((index, depth)) = pending.pop() {
        deepest = deepest.max(depth);
        let node = &nodes[index as usize];
        let children = u32::from(node.imask).count_ones();
        pending.extend((0..children).map(|child| (node.child_base_idx + child, depth + 1)));
    }
    deepest
}
