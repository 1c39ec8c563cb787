//! How large the parts of a model are.

use glam::{Affine3A, Vec3};

use crate::scene::{Instance, Mesh, Pose, Scene};

/// Most parts of a mesh that count.
const MOST: usize = 4096;

/// Radius of the bounds of each part of a model: of triangles that share vertices.
pub(super) fn radii(scene: &Scene, pose: &Pose) -> Vec<f32> {
    let of_meshes: Vec<Vec<f32>> = scene.meshes.iter().map(|mesh| radii_of(mesh)).collect();
    let visible = scene.instances.iter().zip(&pose.instances).filter(|(instance, _)| instance.visible);
    let scaled = |(instance, transform): (&Instance, &Affine3A)| {
        let scale = transform.matrix3.determinant().abs().cbrt();
        of_meshes[instance.mesh].iter().map(move |radius| scale * radius).collect::<Vec<_>>()
    };
    visible.flat_map(scaled).collect()
}

fn radii_of(mesh: &Mesh) -> Vec<f32> {
    // Union-find with path halving; the least vertex of a part stands for it.
    let mut parents: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    let root = |parents: &mut Vec<u32>, mut vertex: u32| {
        while parents[vertex as usize] != vertex {
            parents[vertex as usize] = parents[parents[vertex as usize] as usize];
            vertex = parents[vertex as usize];
        }
        vertex
    };
    for &[a, b, c] in &mesh.triangles {
        for other in [b, c] {
            let (first, second) = (root(&mut parents, a), root(&mut parents, other));
            parents[first.max(second) as usize] = first.min(second);
        }
    }
    let mut bounds = vec![(Vec3::INFINITY, Vec3::NEG_INFINITY); parents.len()];
    for vertex in 0..parents.len() as u32 {
        let (low, high) = &mut bounds[root(&mut parents, vertex) as usize];
        let at = mesh.positions[vertex as usize];
        (*low, *high) = (low.min(at), high.max(at));
    }
    let parts: Vec<f32> = bounds
        .iter()
        .filter(|(low, high)| low.cmplt(*high).any())
        .map(|(low, high)| 0.5 * low.distance(*high))
        .collect();
    parts.iter().step_by(parts.len().div_ceil(MOST).max(1)).copied().collect()
}
