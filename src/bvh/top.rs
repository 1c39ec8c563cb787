//! A top level: one CWBVH over the world bounds of some instances.
//!
//! In: instances with their object-to-world transforms and the roots of their meshes. Out: nodes whose
//! primitives are placed instances in leaf order.

use glam::{Affine3A, Mat3A, Vec3A};
use obvhs::{BvhBuildParams, aabb::Aabb, cwbvh::node::CwBvhNode};

use super::{
    bottom::MeshRoot,
    traverse::SLAB_PADDING,
    wide::{TOP_DEPTH, build_wide},
};

/// A mesh's BVH in its place.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedInstance {
    pub(super) world_to_object: Affine3A,
    /// Root of the mesh's bottom level.
    pub(super) root: u32,
    /// Index into `Scene::instances`.
    pub(super) instance: u32,
}

/// A BVH over placed instances.
#[derive(Clone, Debug, Default)]
pub(super) struct TopLevel {
    /// Empty when there is nothing to hit.
    pub(super) nodes: Vec<CwBvhNode>,
    /// In leaf order.
    pub(super) placed: Vec<PlacedInstance>,
    /// World bounds, without padding; none when there is nothing to hit.
    pub(super) bounds: Option<Aabb>,
}

impl TopLevel {
    /// Builds over `members`: (instance, its mesh's root, its transform). Leaves out instances
    /// whose transform is not finite or cannot be inverted.
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
            placed.push(PlacedInstance { world_to_object, root: mesh.root, instance });
        }
        let params = BvhBuildParams { max_prims_per_leaf: 1, ..BvhBuildParams::fast_build() };
        let bvh = build_wide(&boxes, params, TOP_DEPTH);
        let in_leaf_order = bvh.primitive_indices.iter();
        Self { placed: in_leaf_order.map(|&i| placed[i as usize]).collect(), nodes: bvh.nodes, bounds }
    }
}

/// Bounds of a transformed box.
fn transformed(bounds: &Aabb, transform: &Affine3A) -> Aabb {
    let centre = transform.transform_point3a(bounds.center());
    let extent = absolute(&transform.matrix3) * (bounds.diagonal() * 0.5);
    Aabb::new(centre - extent, centre + extent)
}

/// Grows bounds by what rounding may move a ray when it is taken into object space and back.
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
