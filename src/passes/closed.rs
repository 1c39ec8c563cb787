//! Closed meshes, of which a view from outside sees one side of the triangles only.
//!
//! In: a mesh. Out: which side of its triangles is seen from outside. For an instance in a view: the side that raster need not
//! draw.

use glam::{DMat3, DVec2, DVec3, EulerRot, Mat4, Vec3};
use rayon::prelude::*;

use super::clusters::box_corners;
use crate::scene::Mesh;
use crate::vulkan::vk::CullModeFlags;

/// Most cells that a triangle may lie in, on average: what overlaps more is not worth the time.
const CROWD: usize = 64;

/// What is seen of a mesh from outside of its bounds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outside {
    /// Maybe both sides of its triangles.
    #[default]
    Both,
    /// Only front sides, from where corners are counter-clockwise.
    Front,
    /// Only back sides.
    Back,
}

impl Outside {
    /// What is seen of `mesh`. A closed mesh divides space into parts, each with its winding number, 0 outside of all. Where
    /// the parts behind all triangles have one of at least 1, the first thing that a ray from outside meets is a front side;
    /// where those in front have one of at most -1, a back side. The number is looked at behind the middle of each triangle.
    pub fn of(mesh: &Mesh) -> Self {
        if mesh.triangles.is_empty() || !is_closed(mesh) {
            return Self::Both;
        }
        let Some(behind) = windings_behind(mesh) else { return Self::Both };
        if behind.iter().all(|winding| *winding >= 1) {
            Self::Front
        } else if behind.iter().all(|winding| *winding <= 0) {
            Self::Back
        } else {
            Self::Both
        }
    }

    /// What raster may leave out of an instance; `matrix` leads from its object space to clip space, with reversed depth.
    pub fn culled(self, bounds: (Vec3, Vec3), matrix: &Mat4) -> CullModeFlags {
        // Neither does the eye lie in the bounds then, nor does the near plane cut what is nearest off.
        let is_outside = |corner: &Vec3| {
            let clip = *matrix * corner.extend(1.0);
            clip.w > 0.0 && clip.z < clip.w
        };
        if self == Self::Both || !box_corners(bounds).iter().all(is_outside) {
            return CullModeFlags::NONE;
        }
        // As a picture shows corners: counter-clockwise where the eye sees them so, unless something mirrors them. Vulkan's y
        // goes down, so a camera itself does.
        let mirrored = matrix.determinant() > 0.0;
        if (self == Self::Front) == mirrored { CullModeFlags::FRONT } else { CullModeFlags::BACK }
    }
}

/// Whether each edge belongs to two triangles, which run along it in opposite directions. Vertices in one place are one.
fn is_closed(mesh: &Mesh) -> bool {
    if !mesh.positions.iter().all(|position| position.is_finite()) {
        return false;
    }
    let (_, places) = places(&mesh.positions);
    let edges = |turned: bool| {
        let along = |[from, to]: [u32; 2]| u64::from(from) << 32 | u64::from(to);
        let mut edges: Vec<u64> = mesh
            .triangles
            .iter()
            .flat_map(|triangle| {
                let [a, b, c] = triangle.map(|vertex| places[vertex as usize]);
                if turned { [[b, a], [c, b], [a, c]] } else { [[a, b], [b, c], [c, a]] }
            })
            .map(along)
            .collect();
        edges.par_sort_unstable();
        edges
    };
    let there = edges(false);
    let once = there.is_sorted_by(|edge, next| edge < next);
    once && there == edges(true)
}

/// Where vertices are, each place once; and the place of each vertex.
pub(super) fn places(positions: &[Vec3]) -> (Vec<Vec3>, Vec<u32>) {
    // To add zero makes -0 and 0 one.
    let key = |vertex: u32| positions[vertex as usize].to_array().map(|x| (x + 0.0).to_bits());
    let mut order: Vec<u32> = (0..).take(positions.len()).collect();
    order.par_sort_unstable_by_key(|&vertex| key(vertex));
    let mut places = Vec::new();
    let mut of_vertices = vec![0; positions.len()];
    for (place, run) in (0..).zip(order.chunk_by(|a, b| key(*a) == key(*b))) {
        places.push(positions[run[0] as usize]);
        for vertex in run {
            of_vertices[*vertex as usize] = place;
        }
    }
    (places, of_vertices)
}

/// The winding number behind the middle of each triangle of a closed mesh; none where that is hard to say.
fn windings_behind(mesh: &Mesh) -> Option<Vec<i32>> {
    let crowd = Crowd::of(mesh)?;
    (0..crowd.triangles.len()).into_par_iter().map(|index| crowd.winding_behind(index)).collect()
}

/// Triangles by where they lie in a picture along z: what lies above what.
struct Crowd {
    triangles: Vec<[DVec3; 3]>,
    /// The least x and y.
    low: DVec2,
    /// Cells for a unit of x and y.
    cells_a_unit: DVec2,
    /// Across and down.
    side: usize,
    /// The triangles of each cell, row by row.
    cells: Vec<Vec<u32>>,
}

impl Crowd {
    /// None for what overlaps too much.
    fn of(mesh: &Mesh) -> Option<Self> {
        // Turned so that hardly a face of anything that people make stands upright.
        let turn = DMat3::from_euler(EulerRot::XYZ, 0.6271, 0.3847, 0.9113);
        let triangles: Vec<[DVec3; 3]> = (0..)
            .take(mesh.triangles.len())
            .map(|triangle| mesh.triangle_positions(triangle).map(|corner| turn * corner.as_dvec3()))
            .collect();
        let corners = || triangles.iter().flatten().map(|corner| corner.truncate());
        let low = corners().fold(DVec2::INFINITY, DVec2::min);
        let high = corners().fold(DVec2::NEG_INFINITY, DVec2::max);
        let side = triangles.len().isqrt().max(1);
        let cells_a_unit = side as f64 / (high - low);
        let mut crowd = Self { triangles, low, cells_a_unit, side, cells: vec![Vec::new(); side * side] };
        let mut room = CROWD * crowd.triangles.len();
        for (index, triangle) in (0..).zip(&crowd.triangles) {
            let cells = triangle.map(|corner| crowd.cell_of(corner));
            let [first, last] = [usize::min, usize::max].map(|of| {
                [0, 1].map(|axis| cells.map(|cell| cell[axis]).into_iter().reduce(of).unwrap_or_default())
            });
            room = room.checked_sub((last[0] - first[0] + 1) * (last[1] - first[1] + 1))?;
            for y in first[1]..=last[1] {
                crowd.cells[y * side + first[0]..=y * side + last[0]]
                    .iter_mut()
                    .for_each(|cell| cell.push(index));
            }
        }
        Some(crowd)
    }

    fn cell_of(&self, point: DVec3) -> [usize; 2] {
        let cell = (point.truncate() - self.low) * self.cells_a_unit;
        // As numbers saturate, so do these at 0.
        [cell.x, cell.y].map(|at| (at as usize).min(self.side - 1))
    }

    /// A ray goes upwards from just behind the middle of a triangle; each front side that it leaves the mesh by counts 1, each
    /// back side -1. None where it meets an edge, or a triangle where it begins.
    fn winding_behind(&self, index: usize) -> Option<i32> {
        let corners = self.triangles[index];
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let facing = upward(&corners)?;
        let [x, y] = self.cell_of(middle);
        let others = self.cells[y * self.side + x].iter().filter(|&&other| other as usize != index);
        // From behind a triangle that faces up the ray leaves by it.
        others
            .map(|&other| crossing(&self.triangles[other as usize], middle))
            .sum::<Option<i32>>()
            .map(|above| above + facing.max(0))
    }
}

/// 1 for a triangle that faces up, -1 for one that faces down.
fn upward(&[a, b, c]: &[DVec3; 3]) -> Option<i32> {
    sign((b - a).truncate().perp_dot((c - a).truncate()))
}

/// 1 or -1 for a triangle above a point, as it faces up or down; 0 for any other.
fn crossing(triangle: &[DVec3; 3], point: DVec3) -> Option<i32> {
    let [a, b, c] = triangle.map(|corner| corner - point);
    let beside = |from: DVec3, to: DVec3| from.truncate().perp_dot(to.truncate());
    let sides = [beside(b, c), beside(c, a), beside(a, b)];
    if sides.iter().any(|side| *side > 0.0) && sides.iter().any(|side| *side < 0.0) {
        return Some(0);
    }
    let facing = sides.into_iter().map(sign).collect::<Option<Vec<_>>>()?[0];
    let height = (a.z * sides[0] + b.z * sides[1] + c.z * sides[2]) / (sides[0] + sides[1] + sides[2]);
    Some(if sign(height)? > 0 { facing } else { 0 })
}

/// None for zero and what is no number.
fn sign(x: f64) -> Option<i32> {
    match x {
        x if x > 0.0 => Some(1),
        x if x < 0.0 => Some(-1),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Quat};

    use super::*;
    use crate::scene::Camera;

    fn joined(meshes: &[Mesh]) -> Mesh {
        let mut all = Mesh::default();
        for mesh in meshes {
            let first = all.positions.len() as u32;
            all.positions.extend(&mesh.positions);
            all.triangles.extend(mesh.triangles.iter().map(|triangle| triangle.map(|vertex| first + vertex)));
        }
        all
    }

    fn moved(mut mesh: Mesh, by: Vec3) -> Mesh {
        mesh.positions.iter_mut().for_each(|position| *position += by);
        mesh
    }

    #[test]
    fn other_meshes_show_both() {
        let cuboid = || Mesh::cuboid("box", Vec3::ONE, 0);
        let mut open = cuboid();
        open.triangles.pop();
        assert_eq!(Outside::of(&open), Outside::Both, "with a hole");
        let mut twisted = cuboid();
        twisted.triangles[0].swap(0, 1);
        assert_eq!(Outside::of(&twisted), Outside::Both, "one triangle turned round");
        let beside = joined(&[cuboid(), moved(cuboid(), Vec3::X * 3.0).turned_inside_out()]);
        assert_eq!(Outside::of(&beside), Outside::Both, "one of two inside out");
        let twice = joined(&[cuboid(), cuboid()]);
        assert_eq!(Outside::of(&twice), Outside::Both, "each edge four times");
        assert_eq!(Outside::of(&Mesh::default()), Outside::Both);
        let mut broken = cuboid();
        broken.positions[3].x = f32::NAN;
        assert_eq!(Outside::of(&broken), Outside::Both);

        // A bow tie: closed, but what lies beyond its knot is inside out.
        let mut bow = Mesh::sphere("bow", 1.0, 3, 0);
        for position in &mut bow.positions {
            *position *= Vec3::new(1.0, position.x + 0.013, 1.0);
        }
        assert!(is_closed(&bow));
        assert_eq!(Outside::of(&bow), Outside::Both, "half inside out");
    }

    #[test]
    fn closed_meshes_show_one_side() {
        let sphere = Mesh::sphere("sphere", 1.0, 3, 0);
        let cuboid = Mesh::cuboid("box", Vec3::new(1.0, 2.0, 3.0), 0);
        assert_eq!(Outside::of(&sphere), Outside::Front);
        assert_eq!(Outside::of(&cuboid), Outside::Front, "vertices in one place are one");
        assert_eq!(Outside::of(&cuboid.clone().turned_inside_out()), Outside::Back);
        let shell = joined(&[sphere.clone(), Mesh::sphere("hollow", 0.5, 2, 0).turned_inside_out()]);
        assert_eq!(Outside::of(&shell), Outside::Front, "with a hollow");
        let crossing = joined(&[sphere.clone(), moved(cuboid.clone(), Vec3::new(0.6, 0.1, 0.2))]);
        assert_eq!(Outside::of(&crossing), Outside::Front, "two that cross");
    }

    /// Whether triangles of a sphere that a view sees the front of are counter-clockwise in the picture: y goes down.
    fn is_culled_well(instance: &Affine3A, view: &Mat4) -> bool {
        let matrix = *view * Mat4::from(*instance);
        let mesh = Mesh::sphere("sphere", 1.0, 1, 0);
        let culled = Outside::of(&mesh).culled(mesh.bounds(), &matrix);
        let eye = matrix.inverse() * glam::Vec4::Z;
        let eye = eye.truncate() / eye.w;
        (0..mesh.triangles.len() as u32).all(|triangle| {
            let corners = mesh.triangle_positions(triangle);
            let [a, b, c] = corners.map(|corner| matrix.project_point3(corner).truncate());
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            let seen = normal.dot(eye - corners[0]) > 0.0;
            // Vulkan 1.3, 28.11.1 (polygons): the area is negative where corners go counter-clockwise.
            let counter_clockwise = (b - a).perp_dot(c - a) < 0.0;
            let drawn = culled != if counter_clockwise { CullModeFlags::FRONT } else { CullModeFlags::BACK };
            culled != CullModeFlags::NONE && drawn == seen
        })
    }

    #[test]
    fn what_is_culled_is_what_is_not_seen() {
        let camera =
            Camera { near: 100.0, far: 0.1, ..Camera::looking(Vec3::new(1.0, 2.0, 6.0), Vec3::ZERO) };
        let view = camera.projection_matrix(1.5) * camera.view_matrix();
        let turned =
            Affine3A::from_rotation_translation(Quat::from_rotation_x(0.4), Vec3::new(0.3, 0.2, 0.1));
        let mirrored = turned * Affine3A::from_scale(Vec3::new(-1.0, 0.5, 1.0));
        let flipped = Mat4::from_scale(Vec3::new(1.0, -1.0, 1.0)) * view;
        for (instance, view) in [(turned, view), (mirrored, view), (turned, flipped), (mirrored, flipped)] {
            assert!(is_culled_well(&instance, &view));
        }
        let bounds = (Vec3::splat(-1.0), Vec3::ONE);
        let culled = |at: Vec3| Outside::Front.culled(bounds, &(view * Mat4::from_translation(at)));
        assert_ne!(culled(Vec3::ZERO), CullModeFlags::NONE);
        assert_eq!(culled(camera.eye), CullModeFlags::NONE, "from inside");
        let nearly = camera.eye + (Vec3::ZERO - camera.eye).normalize() * 1.45;
        assert_eq!(culled(nearly), CullModeFlags::NONE, "the near plane may cut it");
    }
}
