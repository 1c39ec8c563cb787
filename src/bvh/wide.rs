//! Builds one compressed wide BVH over boxes, with a bound on its depth.
//!
//! In: boxes. Out: obvhs's CWBVH, made from a PLOC tree (Meister and Bittner 2018, "Parallel
//! Locally-Ordered Clustering"). Boxes nested in each other can drive that tree arbitrarily deep; then a
//! median-split tree takes its place, so that traversal stacks have a fixed size.

use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, node::Bvh2Node},
    cwbvh::{CwBvh, builder::build_cwbvh, bvh2_to_cwbvh::bvh2_to_cwbvh, node::CwBvhNode},
};

/// Most nodes on the way from a bottom level's root to a leaf.
pub(super) const BOTTOM_DEPTH: usize = 24;

/// Most nodes on the way from a top level's root to a leaf.
pub(super) const TOP_DEPTH: usize = 14;

/// Builds over `boxes`; without boxes the result has no nodes.
pub(super) fn build_wide(boxes: &[Aabb], params: BvhBuildParams, max_depth: usize) -> CwBvh {
    if boxes.is_empty() {
        return CwBvh::default();
    }
    let bvh = build_cwbvh(boxes, params, &mut std::time::Duration::default());
    if depth(&bvh.nodes) <= max_depth {
        return bvh;
    }
    let bvh = bvh2_to_cwbvh(&median_split(boxes), params.max_prims_per_leaf.clamp(1, 3), true, false);
    assert!(depth(&bvh.nodes) <= max_depth, "a balanced tree is shallow");
    bvh
}

/// Nodes on the longest way from the root to a leaf.
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

/// A binary tree whose every node halves its boxes at the median of the longest axis.
fn median_split(boxes: &[Aabb]) -> Bvh2 {
    let mut bvh = Bvh2 {
        nodes: vec![Bvh2Node::default()],
        primitive_indices: (0..boxes.len() as u32).collect(),
        ..Bvh2::default()
    };
    let mut pending = vec![(0, 0..boxes.len())];
    while let Some((index, range)) = pending.pop() {
        let primitives = &mut bvh.primitive_indices[range.clone()];
        let bounds = primitives.iter().fold(Aabb::empty(), |sum, &i| sum.union(&boxes[i as usize]));
        if primitives.len() == 1 {
            bvh.nodes[index] = Bvh2Node::new(bounds, 1, range.start as u32);
            continue;
        }
        let size = bounds.diagonal();
        let axis = (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(0);
        let middle = primitives.len() / 2;
        let centre = |i: u32| boxes[i as usize].center()[axis];
        primitives.select_nth_unstable_by(middle, |&a, &b| centre(a).total_cmp(&centre(b)).then(a.cmp(&b)));
        let children = bvh.nodes.len();
        bvh.nodes[index] = Bvh2Node::new(bounds, 0, children as u32);
        bvh.nodes.extend([Bvh2Node::default(); 2]);
        pending.push((children, range.start..range.start + middle));
        pending.push((children + 1, range.start + middle..range.end));
    }
    bvh
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;

    use super::*;

    fn shells(count: usize) -> Vec<Aabb> {
        (0..count)
            .map(|i| {
                let radius = 1.01f32.powi(i as i32);
                Aabb::new(Vec3A::splat(-radius), Vec3A::splat(radius))
            })
            .collect()
    }

    #[test]
    fn nested_boxes_stay_shallow() {
        let bvh = build_wide(&shells(3000), BvhBuildParams::medium_build(), TOP_DEPTH);
        assert!(depth(&bvh.nodes) <= TOP_DEPTH);
        let mut primitives = bvh.primitive_indices.clone();
        primitives.sort_unstable();
        assert_eq!(primitives, (0..3000).collect::<Vec<_>>());
    }

    #[test]
    fn median_split_holds_every_box_once() {
        let boxes = shells(100);
        let bvh = bvh2_to_cwbvh(&median_split(&boxes), 1, true, false);
        let mut primitives = bvh.primitive_indices.clone();
        primitives.sort_unstable();
        assert_eq!(primitives, (0..100).collect::<Vec<_>>());
        assert!(depth(&bvh.nodes) <= 7);
    }
}
