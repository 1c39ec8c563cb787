//! Clusters of neighbouring triangles with their bounds, so that raster passes draw only what a view can see.
//!
//! In: meshes, instances and a view's matrix. Out: for the index buffer, an order of triangles in which
//! neighbours in space are neighbours; for a view, the runs of indices that its frustum may touch.

use glam::{Mat4, Vec3, Vec4};

use crate::scene::{Mesh, Pose};

/// Most triangles of a cluster: few enough that culling pays, many enough that draws stay few.
const MAX_TRIANGLES: usize = 256;

/// Neighbouring triangles of one material on one mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cluster {
    /// Index into the scene's materials.
    pub material: u32,
    /// First index, counted from the mesh's first.
    pub first: u32,
    /// Number of indices.
    pub count: u32,
    /// Object-space bounds.
    pub bounds: (Vec3, Vec3),
}

/// A cluster on an instance, or several that lie one after the other in the index buffer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Draw {
    /// Index into the scene's instances.
    pub instance: u32,
    /// Index into the scene's materials.
    pub material: u32,
    /// First index.
    pub first: u32,
    /// Number of indices.
    pub count: u32,
    /// Object-space bounds.
    pub bounds: (Vec3, Vec3),
}

/// Cuts a mesh into clusters; gives its triangles in their order. Materials stay in order.
pub fn cluster(mesh: &Mesh) -> (Vec<Cluster>, Vec<[u32; 3]>) {
    let mut order: Vec<usize> = (0..mesh.triangles.len()).collect();
    let centre = |triangle: usize| {
        mesh.triangles[triangle].iter().map(|&vertex| mesh.positions[vertex as usize]).sum::<Vec3>() / 3.0
    };
    let (low, high) = bounds_of((0..mesh.triangles.len()).map(centre));
    let scale = 1023.0 / (high - low).max(Vec3::splat(f32::MIN_POSITIVE));
    order.sort_by_cached_key(|&triangle| {
        (mesh.triangle_materials[triangle], morton((centre(triangle) - low) * scale))
    });
    let mut clusters = Vec::new();
    for run in order.chunk_by(|a, b| mesh.triangle_materials[*a] == mesh.triangle_materials[*b]) {
        for triangles in run.chunks(MAX_TRIANGLES) {
            let corners = triangles.iter().flat_map(|&triangle| mesh.triangles[triangle]);
            let first = clusters.last().map_or(0, |last: &Cluster| last.first + last.count);
            clusters.push(Cluster {
                material: mesh.triangle_materials[triangles[0]],
                first,
                count: 3 * u32::try_from(triangles.len()).unwrap_or(0),
                bounds: bounds_of(corners.map(|vertex| mesh.positions[vertex as usize])),
            });
        }
    }
    (clusters, order.into_iter().map(|triangle| mesh.triangles[triangle]).collect())
}

/// The draws that the frustum of `view_projection` (world to clip space) may touch. Draws that follow one
/// another in the index buffer become one where they have the same material.
pub fn visible(draws: &[Draw], pose: &Pose, view_projection: &Mat4) -> Vec<Draw> {
    let mut seen: Vec<Draw> = Vec::new();
    let mut planes = (u32::MAX, [Vec4::ZERO; 6]);
    for draw in draws {
        if planes.0 != draw.instance {
            let object_to_world = Mat4::from(pose.instances[draw.instance as usize]);
            planes = (draw.instance, frustum_planes(&(*view_projection * object_to_world)));
        }
        if !touches(&planes.1, draw.bounds) {
            continue;
        }
        match seen.last_mut() {
            Some(last)
                if last.instance == draw.instance
                    && last.first + last.count == draw.first
                    && last.material == draw.material =>
            {
                last.count += draw.count;
            }
            _ => seen.push(*draw),
        }
    }
    seen
}

/// The planes of the clip volume -w <= x, y <= w, 0 <= z <= w in the space that `matrix` comes from; inside
/// is positive (Gribb and Hartmann 2001).
fn frustum_planes(matrix: &Mat4) -> [Vec4; 6] {
    let [x, y, z, w] = [0, 1, 2, 3].map(|row| matrix.row(row));
    [w + x, w - x, w + y, w - y, z, w - z]
}

/// Whether a box lies on the positive side of every plane, at least in part.
fn touches(planes: &[Vec4; 6], (low, high): (Vec3, Vec3)) -> bool {
    planes.iter().all(|plane| {
        let normal = plane.truncate();
        let farthest = Vec3::select(normal.cmpge(Vec3::ZERO), high, low);
        normal.dot(farthest) + plane.w >= 0.0
    })
}

fn bounds_of(points: impl Iterator<Item = Vec3>) -> (Vec3, Vec3) {
    points.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), point| (low.min(point), high.max(point)))
}

/// Interleaves ten bits of each coordinate.
fn morton(p: Vec3) -> u32 {
    let spread = |x: f32| (0..10).fold(0u32, |code, bit| code | ((x as u32 >> bit) & 1) << (3 * bit));
    spread(p.x) | spread(p.y) << 1 | spread(p.z) << 2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, Scene};

    #[test]
    fn clusters_hold_every_triangle_once_and_bound_it() {
        let mut mesh = Mesh::sphere("sphere", 1.0, 4, 0);
        let half = mesh.triangles.len() / 2;
        mesh.triangle_materials[half..].fill(3);
        let (clusters, triangles) = cluster(&mesh);
        let mut sorted = (triangles.clone(), mesh.triangles.clone());
        sorted.0.sort_unstable();
        sorted.1.sort_unstable();
        assert_eq!(sorted.0, sorted.1);
        let mut next = 0;
        for cluster in &clusters {
            assert_eq!(cluster.first, next);
            next += cluster.count;
            let range = cluster.first as usize / 3..next as usize / 3;
            for vertex in triangles[range].iter().flatten() {
                let p = mesh.positions[*vertex as usize];
                assert!(p.cmpge(cluster.bounds.0).all() && p.cmple(cluster.bounds.1).all());
            }
        }
        assert_eq!(next as usize, 3 * triangles.len());
        assert!(clusters.len() > 10 && clusters.is_sorted_by_key(|cluster| cluster.material));
    }

    #[test]
    fn views_keep_what_they_see_and_drop_what_lies_behind() {
        let scene = Scene::new("empty");
        let mut pose = scene.pose(0.0);
        pose.instances = vec![glam::Affine3A::from_translation(Vec3::new(0.0, 0.0, -5.0))];
        let camera = Camera::looking(Vec3::ZERO, Vec3::NEG_Z);
        let matrix = camera.projection_matrix(1.0) * camera.view_matrix();
        let draw = |first: u32, x: f32, z: f32| {
            let centre = Vec3::new(x, 0.0, z);
            Draw { instance: 0, material: 0, first, count: 3, bounds: (centre - 0.5, centre + 0.5) }
        };
        let draws = [
            draw(0, 0.0, 0.0),
            draw(3, 0.1, 0.0),
            draw(6, 50.0, 0.0),
            draw(9, 0.0, 9.0),
            draw(12, 0.0, -1.0),
        ];
        let seen = visible(&draws, &pose, &matrix);
        let runs: Vec<_> = seen.iter().map(|draw| (draw.first, draw.count)).collect();
        assert_eq!(runs, [(0, 6), (12, 3)]);
    }
}
