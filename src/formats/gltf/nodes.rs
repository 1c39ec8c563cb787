//! The node tree.
//!
//! In: the nodes of the scene that a file shows. Out: what they place, each with the chain of nodes above it; or an error
//! for a tree that is none.

use ::gltf::{Document, Node};
use glam::{Affine3A, Mat4};

use super::source::Source;
use crate::formats::error::SceneError;
use crate::scene::MAX_COORDINATE;

/// A node that places a mesh, a camera or a light.
pub(super) struct Placed {
    /// Its index.
    pub node: usize,
    /// Its own index after those of all nodes above it, from the root.
    pub chain: Vec<usize>,
    /// Node to world at rest.
    pub transform: Affine3A,
}

impl Placed {
    /// The node.
    pub fn in_document<'a>(&self, document: &'a Document) -> Node<'a> {
        document.nodes().nth(self.node).expect("the node was found in this document")
    }
}

/// All nodes of the shown scene that place something, in the order of the tree.
pub(super) fn placed(source: &mut Source) -> Result<Vec<Placed>, SceneError> {
    let document = source.document.clone();
    let shown = document.default_scene().or_else(|| document.scenes().next());
    let Some(shown) = shown else {
        return Err(source.error("has no scene; export one with objects in it"));
    };
    if document.scenes().len() > 1 {
        source.not_shown.insert("scenes but the first or default one".to_owned());
    }
    let mut placed = Vec::new();
    let mut visited = vec![false; document.nodes().len()];
    let mut open: Vec<(Node<'_>, Vec<usize>, Affine3A)> =
        shown.nodes().map(|node| (node, Vec::new(), Affine3A::IDENTITY)).collect();
    open.reverse();
    while let Some((node, above, parent)) = open.pop() {
        // In a tree each node is met once.
        if std::mem::replace(&mut visited[node.index()], true) {
            return Err(source.error(format!(
                "node {} is below itself or has two parents; export the file again",
                node.index()
            )));
        }
        let transform = parent * Affine3A::from_mat4(Mat4::from_cols_array_2d(&node.transform().matrix()));
        let largest = transform.to_cols_array().into_iter().fold(0.0, |most: f32, v| most.max(v.abs()));
        if !transform.is_finite() || largest > MAX_COORDINATE {
            return Err(source.error(format!(
                "the transform of node {} is not finite or beyond +-{MAX_COORDINATE:e}; export the file again",
                node.index()
            )));
        }
        let chain: Vec<usize> = above.iter().copied().chain([node.index()]).collect();
        if node.skin().is_some() {
            source.not_shown.insert("skins (the shape at rest is)".to_owned());
        }
        let children: Vec<_> = node.children().map(|child| (child, chain.clone(), transform)).collect();
        open.extend(children.into_iter().rev());
        if node.mesh().is_some() || node.camera().is_some() || node.light().is_some() {
            placed.push(Placed { node: node.index(), chain, transform });
        }
    }
    Ok(placed)
}
