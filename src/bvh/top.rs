//! A top level: a BVH over the world bounds of instances.
//!
//! In: instances with their object-to-world transforms and the roots of their meshes. Out: nodes whose
//! leaves are placed instances, for the CPU and for shaders.

use glam::{Affine3A, Mat3A, Vec3A};
use obvhs::{BvhBuildParams, aabb::Aabb, bvh2::Bvh2, cwbvh::CwBvh};

use super::{
    bottom::MeshRoot,
    nodes::{Child, LeafCost, Node, WideTree, collapse},
    traverse::{self, SLAB_PADDING},
    tree::{build_ploc, median_split},
    wide,
};

/// Quality of the binary tree.
const PARAMS: BvhBuildParams = BvhBuildParams::fast_build();

/// One instance a leaf.
const LEAF_COST: LeafCost = LeafCost { batch: 1, max_tests: 1, cost: 1.0 };

/// An instance as a leaf of the top level.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedInstance {
    pub(super) world_to_object: Affine3A,
    pub(super) mesh: MeshRoot,
    /// Index into `Scene::instances`.
    pub(super) instance: u32,
}

/// A BVH over placed instances.
#[derive(Clone, Debug)]
pub(super) struct TopLevel {
    pub(super) nodes: Vec<Node>,
    pub(super) root: Child,
    /// For shaders. Without nodes if there are no instances.
    pub(super) gpu: CwBvh,
    pub(super) placed: Vec<PlacedInstance>,
    /// World bounds, without padding; none if there are no instances.
    pub(super) bounds: Option<Aabb>,
}

impl TopLevel {
    /// Builds over `members`: (instance, root of its mesh, object to world). Skips instances whose transform is not
    /// finite or not invertible.
    pub(super) fn build(members: impl Iterator<Item = (u32, MeshRoot, Affine3A)>) -> Self {
        let mut placed = Vec::new();
        let mut boxes = Vec::new();
        let mut bounds: Option<Aabb> = None;
        for (instance, mesh, transform) in members {
            let world_to_object = transform.inverse();
            if !(transform.is_finite() && world_to_object.is_finite()) {
                continue;
            }
            let tight = transformed(&mesh.bounds, &transform);
            boxes.push(padded(tight, &transform, &world_to_object));
            bounds = Some(bounds.map_or(tight, |sum| sum.union(&tight)));
            placed.push(PlacedInstance { world_to_object, mesh, instance });
        }
        let mut level = Self { nodes: Vec::new(), root: Child::EMPTY, gpu: CwBvh::default(), placed, bounds };
        if !boxes.is_empty() {
            let binary = build_ploc(&boxes, &PARAMS);
            let mut tree = collapse_top(&binary);
            if tree.depth > traverse::TOP_DEPTH {
                tree = collapse_top(&median_split(&boxes));
            }
            assert!(tree.depth <= traverse::TOP_DEPTH, "a balanced tree is shallow");
            level.nodes = tree.nodes;
            level.root = tree.root;
            level.gpu = wide::compress(&binary, &boxes, 1, wide::TOP_DEPTH);
        }
        level
    }
}

fn collapse_top(binary: &Bvh2) -> WideTree {
    collapse(binary, LEAF_COST, |members| Child::leaf(members[0] as usize, members.len()))
}

/// Bounds of a transformed box.
pub(crate) fn transformed(bounds: &Aabb, transform: &Affine3A) -> Aabb {
    let centre = transform.transform_point3a(bounds.center());
    let extent = absolute(&transform.matrix3) * (bounds.diagonal() * 0.5);
    Aabb::new(centre - extent, centre + extent)
}

/// Pads bounds by the rounding error of transforming a ray to object space.
fn padded(bounds: Aabb, transform: &Affine3A, world_to_object: &Affine3A) -> Aabb {
    let reach = bounds.min.abs().max(bounds.max.abs()) + transform.translation.abs();
    let in_object = absolute(&world_to_object.matrix3) * reach + world_to_object.translation.abs();
    let padding = SLAB_PADDING * (absolute(&transform.matrix3) * in_object + reach);
    Aabb::new(bounds.min - padding, bounds.max + padding)
}

fn absolute(matrix: &Mat3A) -> Mat3A {
    let absolute = |axis: Vec3A| axis.abs();
    Mat3A::from_cols(absolute(matrix.x_axis), absolute(matrix.y_axis), absolute(matrix.z_axis))
}
