//! The node tree.
//!
//! In: the nodes of a file. Out: where they are at rest, and what those of the shown scene place; or an error for a tree
//! that is none.

use ::gltf::{Document, Node};
use glam::{Affine3A, Mat3A, Mat4, Quat, Vec3};
use serde_json::Value;

use super::source::Source;
use crate::formats::error::SceneError;
use crate::scene::{MAX_COORDINATE, invertible};

/// All nodes.
#[derive(Default)]
pub(super) struct Tree {
    /// Nodes in an order in which each follows its parent, with that.
    pub order: Vec<(usize, Option<usize>)>,
    /// Node to world at rest, by node.
    pub transforms: Vec<Affine3A>,
    /// The product of the rotations of a node and those above it.
    pub rotations: Vec<Quat>,
}

/// What a node of the shown scene places: a mesh, a camera or a light.
pub(super) struct Placed {
    /// The node.
    pub node: usize,
    /// To the node, of one of its instances (EXT_mesh_gpu_instancing).
    pub local: Affine3A,
    /// To world at rest. What is scaled to nothing is a little larger, so that there is an inverse.
    pub transform: Affine3A,
    /// Whether it is scaled to a point.
    pub is_nothing: bool,
}

impl Placed {
    /// The node.
    pub fn in_document<'a>(&self, document: &'a Document) -> Node<'a> {
        document.nodes().nth(self.node).expect("the node was found in this document")
    }
}

/// The roots of the shown scene: that which the file names, or the first one with nodes; without scenes all.
fn roots_of<'a>(source: &mut Source, document: &'a Document, is_child: &[bool]) -> Vec<Node<'a>> {
    if document.scenes().len() > 1 {
        source.not_shown.insert("scenes but the first or default one".to_owned());
    }
    let shown = document.default_scene().or_else(|| document.scenes().find(|s| s.nodes().len() > 0));
    match shown {
        Some(scene) => scene.nodes().collect(),
        None => document.nodes().filter(|node| !is_child[node.index()]).collect(),
    }
}

/// Visits all nodes: those of the shown scene, whose visible ones place something, then the others, which may be joints.
pub(super) fn read(source: &mut Source) -> Result<(Tree, Vec<Placed>), SceneError> {
    let document = source.document.clone();
    let mut is_child = vec![false; document.nodes().len()];
    document.nodes().flat_map(|node| node.children()).for_each(|child| is_child[child.index()] = true);
    let mut tree = Tree {
        order: Vec::new(),
        transforms: vec![Affine3A::IDENTITY; is_child.len()],
        rotations: vec![Quat::IDENTITY; is_child.len()],
    };
    let (mut placed, mut visited) = (Vec::new(), vec![false; is_child.len()]);
    let shown = roots_of(source, &document, &is_child);
    let others = document.nodes().filter(|node| !is_child[node.index()]);
    let mut open: Vec<_> = others.map(|node| (node, None, [false; 2])).collect();
    open.extend(shown.into_iter().rev().map(|node| (node, None, [true; 2])));
    while let Some((node, parent, [is_shown, mut visible])) = open.pop() {
        let index = node.index();
        // In a tree each node is met once.
        if std::mem::replace(&mut visited[index], true) {
            if !is_shown {
                continue;
            }
            return Err(source
                .error(format!("node {index} is below itself or has two parents; export the file again")));
        }
        let (above, turned) = parent.map_or((Affine3A::IDENTITY, Quat::IDENTITY), |parent: usize| {
            (tree.transforms[parent], tree.rotations[parent])
        });
        let transform = above * Affine3A::from_mat4(Mat4::from_cols_array_2d(&node.transform().matrix()));
        check(source, &transform, index)?;
        tree.transforms[index] = transform;
        let rotation = unit(Quat::from_array(node.transform().decomposed().1));
        tree.rotations[index] = (turned * rotation).normalize();
        tree.order.push((index, parent));
        let visibility = node.extension_value("KHR_node_visibility").and_then(|value| value.get("visible"));
        visible &= visibility.and_then(Value::as_bool).unwrap_or(true);
        open.extend(node.children().map(|child| (child, Some(index), [is_shown, visible])));
        let below = open.len() - node.children().len();
        open[below..].reverse();
        if visible && (node.mesh().is_some() || node.camera().is_some() || node.light().is_some()) {
            for local in copies(source, &node)? {
                let mut transform = transform * local;
                check(source, &transform, index)?;
                let is_nothing = transform.matrix3 == Mat3A::ZERO;
                let rotation = Mat3A::from_quat(tree.rotations[index]);
                transform.matrix3 = invertible(transform.matrix3, rotation);
                placed.push(Placed { node: index, local, transform, is_nothing });
            }
        }
    }
    Ok((tree, placed))
}

fn check(source: &Source, transform: &Affine3A, node: usize) -> Result<(), SceneError> {
    let largest = transform.to_cols_array().into_iter().fold(0.0, |most: f32, v| most.max(v.abs()));
    if transform.is_finite() && largest <= MAX_COORDINATE {
        return Ok(());
    }
    Err(source.error(format!(
        "the transform of node {node} is not finite or beyond +-{MAX_COORDINATE:e}; export the file again"
    )))
}

/// The instances of a node's mesh (EXT_mesh_gpu_instancing), or the node itself.
fn copies(source: &Source, node: &Node<'_>) -> Result<Vec<Affine3A>, SceneError> {
    let Some(attributes) = node.extension_value("EXT_mesh_gpu_instancing").and_then(|v| v.get("attributes"))
    else {
        return Ok(vec![Affine3A::IDENTITY]);
    };
    let accessor = |name: &str| -> Result<_, SceneError> {
        let Some(value) = attributes.get(name) else { return Ok(None) };
        let index = value.as_u64().and_then(|index| usize::try_from(index).ok());
        let found = index.and_then(|index| source.document.accessors().nth(index));
        let place = format!("node {}: EXT_mesh_gpu_instancing: {name}", node.index());
        found.map(Some).ok_or_else(|| source.error(format!("{place} is no accessor; export the file again")))
    };
    let [translations, scales] = ["TRANSLATION", "SCALE"]
        .map(|name| accessor(name)?.map(|accessor| source.vectors::<3>(&accessor, name)).transpose());
    let rotations = accessor("ROTATION")?.map(|a| source.vectors::<4>(&a, "ROTATION")).transpose()?;
    let (translations, scales) = (translations?, scales?);
    let lengths = [&translations, &scales].map(|list| list.as_ref().map(Vec::len));
    let count = lengths.into_iter().chain([rotations.as_ref().map(Vec::len)]).flatten().min().unwrap_or(1);
    let vector = |list: &Option<Vec<[f32; 3]>>, i: usize, or: Vec3| {
        list.as_ref().map_or(or, |list| Vec3::from_array(list[i]))
    };
    let copy = |i: usize| {
        let rotation = rotations.as_ref().map_or(Quat::IDENTITY, |list| unit(Quat::from_array(list[i])));
        let (scale, translation) = (vector(&scales, i, Vec3::ONE), vector(&translations, i, Vec3::ZERO));
        Affine3A::from_scale_rotation_translation(scale, rotation, translation)
    };
    Ok((0..count).map(copy).collect())
}

/// A rotation of length 1; none if it has no length.
pub(super) fn unit(rotation: Quat) -> Quat {
    let unit = rotation.normalize();
    if unit.is_finite() { unit } else { Quat::IDENTITY }
}
