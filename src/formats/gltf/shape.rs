//! The shape of a mesh at rest, where a node poses it: morph targets with their default weights, then the skin.
//!
//! ```text
//! p' = sum_j w_j J_j B_j (p + sum_t m_t d_t)      J: joint to world at rest, B: inverse bind matrix
//! ```
//!
//! In: vertices as the file has them. Out: posed ones; those of a skin in world space, whatever the node's transform.

use ::gltf::{Node, Semantic};
use glam::{Affine3A, Mat4, Vec3};

use super::attributes::Attributes;
use super::nodes::Tree;
use super::source::Source;
use crate::formats::error::SceneError;
use crate::scene::{Mesh, SurfaceTransform};

/// How a node poses its mesh.
#[derive(Default)]
pub(super) struct Shape {
    /// Of the morph targets.
    weights: Vec<f32>,
    /// Of each joint: from the bind pose to world; empty without a skin.
    joints: Vec<Affine3A>,
}

impl Shape {
    /// That of the mesh of `node`.
    pub fn of(source: &Source, tree: &Tree, node: &Node<'_>) -> Result<Self, SceneError> {
        let defaults = || node.mesh().and_then(|mesh| mesh.weights());
        let weights = node.weights().or_else(defaults).unwrap_or_default().to_vec();
        let Some(skin) = node.skin() else { return Ok(Self { weights, joints: Vec::new() }) };
        let mut joints: Vec<Affine3A> = skin.joints().map(|joint| tree.transforms[joint.index()]).collect();
        if let Some(accessor) = skin.inverse_bind_matrices() {
            let matrices = source.vectors::<16>(&accessor, "inverse bind matrices")?;
            if matrices.len() < joints.len() {
                return Err(source.error(format!(
                    "skin {} has {} joints, but {} inverse bind matrices; export the file again",
                    skin.index(),
                    joints.len(),
                    matrices.len()
                )));
            }
            for (joint, matrix) in joints.iter_mut().zip(&matrices) {
                *joint *= Affine3A::from_mat4(Mat4::from_cols_array(matrix));
            }
        }
        Ok(Self { weights, joints })
    }

    /// Whether it mirrors the mesh.
    pub fn mirrors(&self) -> bool {
        self.joints.first().is_some_and(|joint| joint.matrix3.determinant() < 0.0)
    }

    /// Poses the vertices of a primitive, with its normals and tangents where it has them.
    pub fn pose(&self, reader: &Attributes<'_>, piece: &mut Mesh) -> Result<(), SceneError> {
        for (target, weight) in reader.primitive.morph_targets().zip(&self.weights) {
            if *weight == 0.0 {
                continue;
            }
            let change = |accessor: Option<::gltf::Accessor<'_>>, what: &str| {
                let deltas = accessor.map(|accessor| reader.values::<3>(&accessor, what)).transpose()?;
                let weighted = |delta| Vec3::from_array(delta) * *weight;
                Ok(deltas.into_iter().flatten().map(weighted).collect::<Vec<Vec3>>())
            };
            let deltas = change(target.positions(), "morph positions")?;
            piece.positions.iter_mut().zip(deltas).for_each(|(position, delta)| *position += delta);
            let deltas = change(target.normals(), "morph normals")?;
            piece.normals.iter_mut().zip(deltas).for_each(|(normal, delta)| *normal += delta);
            let deltas = change(target.tangents(), "morph tangents")?;
            piece.tangents.iter_mut().zip(deltas).for_each(|(tangent, delta)| *tangent += delta.extend(0.0));
        }
        if self.joints.is_empty() { Ok(()) } else { self.pose_skin(reader, piece) }
    }

    fn pose_skin(&self, reader: &Attributes<'_>, piece: &mut Mesh) -> Result<(), SceneError> {
        // Blend the matrices of each vertex, of as many sets of four as there are.
        let mut blends = vec![Mat4::ZERO; piece.positions.len()];
        for set in 0.. {
            let [joints, weights] =
                [Semantic::Joints(set), Semantic::Weights(set)].map(|s| reader.read::<4>(&s, "skin"));
            let (Some(joints), Some(weights)) = (joints?, weights?) else { break };
            for ((blend, joints), weights) in blends.iter_mut().zip(joints).zip(weights) {
                for (joint, weight) in joints.into_iter().zip(weights).filter(|(_, weight)| *weight != 0.0) {
                    let matrix = self.joints.get(joint as usize).ok_or_else(|| {
                        let total = self.joints.len();
                        let problem =
                            format!("{} uses joint {joint}, but the skin has {total}", reader.place);
                        reader.source.error(format!("{problem}; export the file again"))
                    })?;
                    *blend += Mat4::from(*matrix) * weight;
                }
            }
        }
        for (vertex, blend) in blends.iter().enumerate() {
            // Weights should add up to 1. Without any, a vertex follows the first joint.
            let total = blend.w_axis.w;
            let blend =
                if total > 0.0 { Affine3A::from_mat4(*blend * (1.0 / total)) } else { self.joints[0] };
            piece.positions[vertex] = blend.transform_point3(piece.positions[vertex]);
            if let Some(normal) = piece.normals.get_mut(vertex) {
                *normal = SurfaceTransform::new(&blend).normal(*normal);
            }
            if let Some(tangent) = piece.tangents.get_mut(vertex) {
                let side = if self.mirrors() { -tangent.w } else { tangent.w };
                *tangent = blend.transform_vector3(tangent.truncate()).extend(side);
            }
        }
        Ok(())
    }
}
