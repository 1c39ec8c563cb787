//! A hall with columns, rings around them and curtains, and rays as a frame has them.
//!
//! As in most scenes, walls and columns are few large triangles, some of them long and thin, and the rest are many
//! small ones. Rays go from patches of the walls to a point of another wall, as those of neighbouring pixels to a light.

use std::f32::consts::TAU;

use glam::{Affine3A, Vec3, vec3};

use crate::bvh::Ray;
use crate::scene::{Instance, Material, Mesh, Scene};

/// Half of the hall's length, its height, half of its width.
const SIZE: Vec3 = vec3(15.0, 10.0, 6.0);
/// Columns of each of the two rows, as far apart as is left of the length.
const COLUMNS: u32 = 10;
/// Where the rows stand.
const ROW: f32 = 3.2;
/// Patches of rays.
const PATCHES: u32 = 1024;
/// Rays along a side of a patch, and how far from one to the next, as a share of the wall.
const PATCH: u32 = 8;
const STEP: f32 = 0.003;

/// The hall, one mesh.
pub(super) fn scene() -> Scene {
    Scene {
        meshes: vec![mesh().into()],
        materials: vec![Material::grey("")],
        instances: vec![Instance::fixed("", 0, Affine3A::IDENTITY)],
        ..Scene::new("")
    }
}

fn mesh() -> Mesh {
    let mut mesh = Mesh::default();
    for wall in 0..6 {
        push_grid(&mut mesh, [1, 1], |u, v| on_wall(wall, u, v));
    }
    for column in 0..2 * COLUMNS {
        let foot = foot(column);
        let around = |angle: f32, radius: f32| foot + vec3(radius * angle.cos(), 0.0, radius * angle.sin());
        push_grid(&mut mesh, [48, 1], |u, v| around(TAU * u, 0.4) + Vec3::Y * (SIZE.y * v));
        for height in [0.3, 7.0] {
            push_grid(&mut mesh, [32, 12], |u, v| {
                let (up, out) = (TAU * v).sin_cos();
                let thick = 0.2 + 0.03 * (5.0 * TAU * u).sin();
                around(TAU * u, 0.45 + thick * out) + Vec3::Y * (height + thick * up)
            });
        }
        if column.is_multiple_of(5) {
            push_grid(&mut mesh, [48, 48], |u, v| {
                let fold = 0.25 * v * (40.0 * u).sin() + 0.05 * (17.0 * v + 9.0 * u).sin();
                foot + vec3(0.5 + 2.0 * u, 6.5 - 5.0 * v, fold)
            });
        }
    }
    mesh.normals = vec![Vec3::Y; mesh.positions.len()];
    mesh.triangle_materials = vec![0; mesh.triangles.len()];
    mesh
}

/// Where a column stands.
fn foot(column: u32) -> Vec3 {
    let along = (column / 2) as f32 + 0.5;
    let side = if column.is_multiple_of(2) { ROW } else { -ROW };
    vec3(SIZE.x * (2.0 * along / COLUMNS as f32 - 1.0), 0.0, side)
}

/// A point of the floor, the ceiling or one of the four walls; u and v from 0 to 1.
fn on_wall(wall: u32, u: f32, v: f32) -> Vec3 {
    let [x, z] = [u, v].map(|share| 2.0 * share - 1.0);
    SIZE * match wall {
        0 => vec3(x, 0.0, z),
        1 => vec3(x, 1.0, z),
        2 => vec3(x, v, 1.0),
        3 => vec3(x, v, -1.0),
        4 => vec3(1.0, v, x),
        _ => vec3(-1.0, v, x),
    }
}

/// A surface over u and v from 0 to 1, in so many quads each way.
fn push_grid(mesh: &mut Mesh, [across, up]: [u32; 2], point: impl Fn(f32, f32) -> Vec3) {
    let first = mesh.positions.len() as u32;
    let at = |i: u32, j: u32| first + j * (across + 1) + i;
    for j in 0..=up {
        for i in 0..=across {
            mesh.positions.push(point(i as f32 / across as f32, j as f32 / up as f32));
        }
    }
    for j in 0..up {
        for i in 0..across {
            mesh.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
}

/// The rays, patch by patch, without their ends, which lie on walls.
pub(super) fn rays() -> Vec<Ray> {
    // Any well-spread numbers will do: a Weyl sequence.
    let spread = |index: u32, step: f64| (f64::from(index) * step).fract() as f32;
    (0..PATCHES)
        .flat_map(|patch| {
            let [from, to] = [patch % 6, (patch + 1 + patch / 6 % 5) % 6];
            let end = on_wall(to, spread(patch, 0.819_172_5), spread(patch, 0.671_043_6));
            let [u, v] = [spread(patch, 0.754_877_7), spread(patch, 0.569_840_3)];
            (0..PATCH * PATCH).map(move |ray| {
                let [i, j] = [ray % PATCH, ray / PATCH].map(|step| step as f32 * STEP);
                let start = on_wall(from, 0.95 * u + i, 0.95 * v + j);
                Ray { origin: start, direction: end - start, t_min: 0.001, t_max: 0.999 }
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::TwoLevelBvh;

    #[test]
    fn some_rays_are_blocked_and_some_are_not() {
        let bvh = TwoLevelBvh::build(&scene(), &[Affine3A::IDENTITY]);
        let rays = rays();
        assert_eq!(rays.len(), 65_536);
        let blocked = bvh.occluded_batch(&rays).into_iter().filter(|occluded| *occluded).count();
        let share = blocked as f64 / rays.len() as f64;
        assert!((0.3..0.8).contains(&share), "{share}");
    }
}
