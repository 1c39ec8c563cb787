//! Binary trees over boxes, which are collapsed into the wide ones.
//!
//! In: boxes. Out: obvhs's `Bvh2` with one box a leaf: PLOC (Meister and Bittner 2018, "Parallel
//! Locally-Ordered Clustering") with reinsertion (Meister and Bittner 2018, "Parallel Reinsertion"), or a
//! median split where that would be too deep.

use glam::Vec3A;
use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, node::Bvh2Node, reinsertion::ReinsertionOptimizer},
    ploc::PlocBuilder,
    splits::split_aabbs_preset,
    triangle::Triangle,
};

use super::traverse::SLAB_PADDING;
use crate::scene::repeats::{SLOTS, slot_of};

/// Build references: boxes, of which several may bound parts of one primitive (spatial splits).
#[derive(Clone, Debug, Default)]
pub(super) struct References {
    pub(super) boxes: Vec<Aabb>,
    /// The primitive of each box.
    pub(super) primitives: Vec<u32>,
}

impl References {
    /// One box for each triangle, and several for large triangles that fill their box poorly and that rays may meet more than
    /// once. Each box is padded by the rounding error of a hit on its triangle.
    pub(super) fn from_triangles(triangles: &[Triangle], may_split: impl Fn(u32) -> bool) -> Self {
        let mut boxes: Vec<Aabb> = triangles.iter().map(Triangle::aabb).collect();
        let mut primitives: Vec<u32> = (0..triangles.len() as u32).collect();
        let areas = || boxes.iter().map(Aabb::half_area);
        let (sum, largest) = (areas().sum::<f32>(), areas().fold(0.0, f32::max));
        let mean = sum / triangles.len() as f32;
        split_aabbs_preset(&mut boxes, &mut primitives, triangles, mean, largest);
        // The first box of each keeps its place.
        let whole = |(place, (bounds, primitive)): (usize, (Aabb, u32))| {
            if may_split(primitive) {
                return Some((bounds, primitive));
            }
            (place < triangles.len()).then(|| (triangles[primitive as usize].aabb(), primitive))
        };
        let all = boxes.into_iter().zip(primitives).enumerate();
        let (mut boxes, primitives): (Vec<Aabb>, Vec<u32>) = all.filter_map(whole).unzip();
        for (bounds, &primitive) in boxes.iter_mut().zip(&primitives) {
            // The triangle test runs on the whole triangle, not only on its part in the box.
            let Triangle { v0, v1, v2 } = triangles[primitive as usize];
            let reach = v0.abs().max(v1.abs()).max(v2.abs()).max_element();
            let padding = Vec3A::splat(SLAB_PADDING * reach);
            *bounds = Aabb::new(bounds.min - padding, bounds.max + padding);
        }
        Self { boxes, primitives }
    }
}

/// How many boxes may be alike: PLOC merges but few of them at a time, and takes quadratic time.
const MOST_ALIKE: usize = 4096;

/// Whether more boxes than PLOC can handle are alike.
fn are_many_alike(boxes: &[Aabb]) -> bool {
    let mut counts = vec![0u32; SLOTS];
    let most = MOST_ALIKE + boxes.len() / 1024;
    boxes.len() > most
        && boxes.iter().any(|bounds| {
            let corners = [bounds.min.to_array(), bounds.max.to_array()];
            let count = &mut counts[slot_of(corners.into_iter().flatten().map(f32::to_bits))];
            *count += 1;
            *count as usize > most
        })
}

/// Builds by PLOC with reinsertion over `boxes`, or by median splits where many are alike; `params` trades quality for build
/// time.
pub(super) fn build_ploc(boxes: &[Aabb], params: &BvhBuildParams) -> Bvh2 {
    if are_many_alike(boxes) {
        return median_split(boxes);
    }
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

/// Builds a balanced binary tree: each node splits its boxes at the median of the longest axis.
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
