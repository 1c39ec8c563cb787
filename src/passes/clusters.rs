//! Runs of neighbouring triangles with their bounds, so that raster passes draw only what a view can see.
//!
//! In: meshes, instances and a view's matrix. Out: for the index buffer, an order of triangles in which
//! neighbours in space are neighbours; for a view, the runs of indices that its frustum may touch; for a part of a view, its
//! own frustum; for boxes, the part of a view that they may touch.

use glam::{Mat4, Vec2, Vec3, Vec4};

use crate::scene::{Mesh, Pose};
use crate::vulkan::Area;

/// Most triangles of a cluster: few enough that culling pays, many enough that draws stay few.
const MAX_TRIANGLES: usize = 256;

/// Most boxes that bound a mesh where it is drawn: more of them are closer to it, but each is looked at in every frame in
/// which the mesh moves.
const MAX_BOXES: usize = 32;

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

/// Boxes that hold all of a mesh's triangles, in the order of [`cluster`], and little else.
pub fn boxes_of(mesh: &Mesh, triangles: &[[u32; 3]]) -> Vec<(Vec3, Vec3)> {
    let corner = |vertex: &u32| mesh.positions[*vertex as usize];
    let runs = triangles.chunks(triangles.len().div_ceil(MAX_BOXES).max(1));
    runs.map(|run| bounds_of(run.iter().flatten().map(corner))).collect()
}

/// The draws that the frustum of `view_projection` (world to clip space) may touch. Draws that follow one
/// another in the index buffer become one where `joins` allows it.
pub fn visible<'a>(
    draws: impl IntoIterator<Item = &'a Draw>,
    pose: &Pose,
    view_projection: &Mat4,
    joins: impl Fn(&Draw, &Draw) -> bool,
) -> Vec<Draw> {
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
                    && joins(last, draw) =>
            {
                last.count += draw.count;
            }
            _ => seen.push(*draw),
        }
    }
    seen
}

/// From object space to the clip space of a part of a view: `matrix` leads to that of the whole view, of `extent` texels.
/// What touches the area, or nearly, lies in the part's frustum.
pub fn part_of_view(matrix: &Mat4, area: Area, extent: [u32; 2]) -> Mat4 {
    // Rounding must not cull what covers a texel at the edge.
    let area = area.grown(1, extent);
    let end = area.end();
    let [x, y] = [0, 1].map(|axis| {
        let ndc = |texel: u32| 2.0 * texel as f32 / extent[axis] as f32 - 1.0;
        let (low, high) = (ndc(area.offset[axis]), ndc(end[axis]));
        (2.0 / (high - low), -(low + high) / (high - low))
    });
    let crop = Mat4::from_cols(
        Vec4::new(x.0, 0.0, 0.0, 0.0),
        Vec4::new(0.0, y.0, 0.0, 0.0),
        Vec4::Z,
        Vec4::new(x.1, y.1, 0.0, 1.0),
    );
    crop * *matrix
}

/// The part of a view of `extent` texels that boxes may touch; `matrix` leads from their space to the view's clip space.
pub fn area_of_boxes(matrix: &Mat4, boxes: &[(Vec3, Vec3)], extent: [u32; 2]) -> Area {
    let planes = frustum_planes(matrix);
    let seen = boxes.iter().filter(|bounds| touches(&planes, **bounds));
    seen.map(|bounds| {
        area_of_corners(&box_corners(*bounds).map(|corner| *matrix * corner.extend(1.0)), extent)
    })
    .fold(Area::default(), Area::union)
}

/// The part of a view that may be touched by what has these corners in clip space.
fn area_of_corners(corners: &[Vec4], extent: [u32; 2]) -> Area {
    let nearest = corners.iter().map(|corner| corner.w).fold(f32::INFINITY, f32::min);
    let farthest = corners.iter().map(|corner| corner.w).fold(0.0, f32::max);
    // What reaches behind the eye has no bounds in the picture; NaNs have none either.
    let in_front = nearest > 1e-6 * farthest;
    if !in_front {
        return Area::whole(extent);
    }
    let texels =
        corners.iter().map(|corner| (corner.truncate().truncate() / corner.w * 0.5 + 0.5) * vec2(extent));
    let (low, high) = texels
        .fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(low, high), texel| (low.min(texel), high.max(texel)));
    // As numbers saturate, so do these at 0.
    let first = (low.floor() - 1.0).min(vec2(extent));
    let end = (high.ceil() + 1.0).min(vec2(extent));
    let first = [first.x as u32, first.y as u32];
    Area {
        offset: first,
        extent: [(end.x as u32).saturating_sub(first[0]), (end.y as u32).saturating_sub(first[1])],
    }
}

fn vec2(extent: [u32; 2]) -> Vec2 {
    Vec2::from(extent.map(|side| side as f32))
}

/// The corners of a box.
pub fn box_corners((low, high): (Vec3, Vec3)) -> [Vec3; 8] {
    std::array::from_fn(|corner| {
        Vec3::new(
            if corner & 1 == 0 { low.x } else { high.x },
            if corner & 2 == 0 { low.y } else { high.y },
            if corner & 4 == 0 { low.z } else { high.z },
        )
    })
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
        let boxes = boxes_of(&mesh, &triangles);
        let held = |p: Vec3| boxes.iter().any(|(low, high)| p.cmpge(*low).all() && p.cmple(*high).all());
        assert!(boxes.len() > 10 && boxes.len() <= MAX_BOXES && mesh.positions.iter().all(|p| held(*p)));
        assert!(clusters.len() > 10 && clusters.is_sorted_by_key(|cluster| cluster.material));
    }

    #[test]
    fn views_keep_what_they_see_and_drop_what_lies_behind() {
        let scene = Scene::new("empty");
        let mut pose = scene.pose(0.0);
        pose.instances = vec![glam::Affine3A::from_translation(Vec3::new(0.0, 0.0, -5.0))];
        let camera = Camera::looking(Vec3::ZERO, Vec3::NEG_Z);
        let reversed = Camera { near: 100.0, far: 0.1, ..camera };
        let matrix = reversed.projection_matrix(1.0) * camera.view_matrix();
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
        let seen = visible(&draws, &pose, &matrix, |_, _| true);
        let runs: Vec<_> = seen.iter().map(|draw| (draw.first, draw.count)).collect();
        assert_eq!(runs, [(0, 6), (12, 3)]);
    }

    #[test]
    fn boxes_lie_within_their_part_of_the_view() {
        let camera = Camera::looking(Vec3::ZERO, Vec3::NEG_Z);
        let reversed = Camera { near: 100.0, far: 0.1, ..camera };
        let matrix = reversed.projection_matrix(1.5) * camera.view_matrix();
        let extent = [90, 60];
        let texel = |p: Vec3| {
            let clip = matrix * p.extend(1.0);
            (clip.truncate().truncate() / clip.w * 0.5 + 0.5) * vec2(extent)
        };
        let seen =
            |centre: Vec3, half: f32| area_of_boxes(&matrix, &[(centre - half, centre + half)], extent);
        let area = seen(Vec3::new(0.5, -0.3, -4.0), 0.4);
        for corner in box_corners((Vec3::new(0.1, -0.7, -4.4), Vec3::new(0.9, 0.1, -3.6))) {
            let (at, [first, end]) = (texel(corner), [area.offset, area.end()].map(vec2));
            assert!(at.cmpge(first).all() && at.cmple(end).all(), "{at} is not in {area:?}");
        }
        assert!(area.extent[0] < 40 && area.extent[1] < 40, "{area:?} is larger than it need be");
        assert!(seen(Vec3::new(90.0, 0.0, -4.0), 0.4).is_empty(), "beside the view");
        assert!(seen(Vec3::new(0.0, 0.0, 4.0), 0.4).is_empty(), "behind the eye");
        assert_eq!(seen(Vec3::new(0.0, 0.0, -0.2), 0.4), Area::whole(extent), "around the eye");
        // What lies in the area lies in the frustum of that part, and little else does.
        let part = part_of_view(&matrix, area, extent);
        let planes = frustum_planes(&part);
        let inside = |p: Vec3| touches(&planes, (p, p));
        assert!(inside(Vec3::new(0.5, -0.3, -4.0)) && inside(Vec3::new(0.1, 0.1, -4.4)));
        assert!(!inside(Vec3::new(-0.5, -0.3, -4.0)) && !inside(Vec3::new(0.5, 1.2, -4.0)));
    }
}
