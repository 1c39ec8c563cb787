//! Binary trees over boxes, from which the wide ones are made.
//!
//! In: boxes. Out: obvhs's `Bvh2` with one box a leaf: PLOC (Meister and Bittner 2018, "Parallel
//! Locally-Ordered Clustering") with reinsertion (Meister and Bittner 2018, "Parallel Reinsertion"), or, where that
//! would be too deep, a median split.

use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, node::Bvh2Node, reinsertion::ReinsertionOptimizer},
    ploc::PlocBuilder,
};

/// Builds over `boxes`; `params` decides on quality against time.
pub(super) fn clustered(boxes: &[Aabb], params: &BvhBuildParams) -> Bvh2 {
    let mut bvh = PlocBuilder::with_capacity(boxes.len()).build(
        params.ploc_search_distance,
        boxes,
        (0..boxes.len() as u32).collect(),
        params.sort_precision,
        params.search_depth_threshold,
    );
    ReinsertionOptimizer::default().run(&mut bvh, params.reinsertion_batch_ratio, None);
    bvh
}

/// A binary tree whose every node halves its boxes at the median of the longest axis.
pub(super) fn median_split(boxes: &[Aabb]) -> Bvh2 {
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
