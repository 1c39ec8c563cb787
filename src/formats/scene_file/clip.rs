//! Clips a mesh to a box (Sutherland and Hodgman 1974).
//!
//! In: a mesh and a box, object space. Out: the part of the mesh in the box, so that distant scenery does not extend
//! the scene's bounds.

use glam::{Vec2, Vec3, Vec4};

use crate::scene::Mesh;

/// A vertex of the clipped polygon.
#[derive(Clone, Copy)]
struct Corner {
    position: Vec3,
    normal: Vec3,
    uv: Vec2,
    // Where the mesh has them.
    second_uv: Option<Vec2>,
    tangent: Option<Vec4>,
    colour: Option<Vec4>,
}

impl Corner {
    fn lerp(self, other: Self, t: f32) -> Self {
        Self {
            position: self.position.lerp(other.position, t),
            normal: self.normal.lerp(other.normal, t).normalize_or(self.normal),
            uv: self.uv.lerp(other.uv, t),
            second_uv: self.second_uv.zip(other.second_uv).map(|(a, b)| a.lerp(b, t)),
            tangent: self.tangent.zip(other.tangent).map(|(a, b)| between(a, b, t)),
            colour: self.colour.zip(other.colour).map(|(a, b)| a.lerp(b, t)),
        }
    }
}

/// The tangent between two, on the side of the first.
fn between(a: Vec4, b: Vec4, t: f32) -> Vec4 {
    let direction = a.truncate().lerp(b.truncate(), t);
    direction.normalize_or(a.truncate()).extend(a.w)
}

/// Clips `mesh` to the box from `min` to `max`. Triangles inside are unchanged.
pub(crate) fn clip_to_box(mesh: &mut Mesh, min: Vec3, max: Vec3) {
    let triangles = std::mem::take(&mut mesh.triangles);
    let materials = std::mem::take(&mut mesh.triangle_materials);
    for (triangle, material) in triangles.into_iter().zip(materials) {
        let corners = triangle.map(|vertex| corner(mesh, vertex));
        let inside = |c: &Corner| c.position.cmpge(min).all() && c.position.cmple(max).all();
        if corners.iter().all(inside) {
            mesh.triangles.push(triangle);
            mesh.triangle_materials.push(material);
            continue;
        }
        let polygon = clip_polygon(corners.to_vec(), min, max);
        let first = mesh.positions.len() as u32;
        if polygon.len() < 3 {
            continue;
        }
        for corner in &polygon {
            mesh.positions.push(corner.position);
            mesh.normals.push(corner.normal);
            mesh.uvs.push(corner.uv);
            mesh.second_uvs.extend(corner.second_uv);
            mesh.tangents.extend(corner.tangent);
            mesh.colours.extend(corner.colour);
        }
        for i in 1..polygon.len() as u32 - 1 {
            mesh.triangles.push([first, first + i, first + i + 1]);
            mesh.triangle_materials.push(material);
        }
    }
    mesh.drop_degenerate_triangles();
    mesh.drop_unused_vertices();
}

fn corner(mesh: &Mesh, vertex: u32) -> Corner {
    let i = vertex as usize;
    Corner {
        position: mesh.positions[i],
        normal: mesh.normals[i],
        uv: mesh.uvs[i],
        second_uv: mesh.second_uvs.get(i).copied(),
        tangent: mesh.tangents.get(i).copied(),
        colour: mesh.colours.get(i).copied(),
    }
}

fn clip_polygon(mut polygon: Vec<Corner>, min: Vec3, max: Vec3) -> Vec<Corner> {
    for axis in 0..3 {
        polygon = clip_half_space(&polygon, |corner| corner.position[axis] - min[axis]);
        polygon = clip_half_space(&polygon, |corner| max[axis] - corner.position[axis]);
    }
    for corner in &mut polygon {
        // Rounding must not extend the bounds.
        corner.position = corner.position.clamp(min, max);
    }
    polygon
}

/// Keeps the part of a polygon with `distance` >= 0.
fn clip_half_space(polygon: &[Corner], distance: impl Fn(&Corner) -> f32) -> Vec<Corner> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, here) in polygon.iter().enumerate() {
        let next = &polygon[(i + 1) % polygon.len()];
        let (d_here, d_next) = (distance(here), distance(next));
        if d_here >= 0.0 {
            kept.push(*here);
        }
        if (d_here < 0.0) != (d_next < 0.0) {
            kept.push(here.lerp(*next, d_here / (d_here - d_next)));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_large_plane_is_clipped_to_the_box() {
        let corners = [[-9.0, 9.0], [9.0, 9.0], [9.0, -9.0], [-9.0, -9.0]].map(|[x, z]| Vec3::new(x, 0.0, z));
        let mut mesh = Mesh::polygon("plane", &corners, 3);
        clip_to_box(&mut mesh, Vec3::new(-1.0, -1.0, -2.0), Vec3::new(1.0, 1.0, 3.0));
        let area: f32 = (0..mesh.triangles.len() as u32).map(|i| mesh.triangle_area(i)).sum();
        assert!((area - 10.0).abs() < 1e-4);
        assert_eq!(mesh.bounds(), (Vec3::new(-1.0, 0.0, -2.0), Vec3::new(1.0, 0.0, 3.0)));
        for (i, uv) in mesh.uvs.iter().enumerate() {
            let expected = Vec2::new(mesh.positions[i].x + 9.0, mesh.positions[i].z + 9.0) / 18.0;
            assert!(uv.distance(expected) < 1e-5);
        }
        assert!((0..mesh.triangles.len() as u32).all(|i| {
            let [a, b, c] = mesh.triangle_positions(i);
            (b - a).cross(c - a).y > 0.0
        }));
    }

    #[test]
    fn meshes_inside_are_kept_and_outside_removed() {
        let mesh = Mesh::sphere("sphere", 1.0, 2, 0);
        let mut inside = mesh.clone();
        clip_to_box(&mut inside, Vec3::splat(-1.0), Vec3::ONE);
        assert_eq!(inside.triangles.len(), mesh.triangles.len());
        let mut outside = mesh;
        clip_to_box(&mut outside, Vec3::splat(2.0), Vec3::splat(3.0));
        assert!(outside.triangles.is_empty() && outside.positions.is_empty());
    }
}
