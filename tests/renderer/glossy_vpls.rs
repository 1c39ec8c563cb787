//! VPLs on glossy surfaces, against the path tracer.

use std::sync::Arc;

use glam::{Affine3A, Vec2, Vec3};
use glowworm::scene::{Camera, Instance, Light, LightKind, Material, Mesh, Scene, SpotFalloff};

use super::support::golden::reference;
use super::support::{GpuFixture, exact, layer, luminance, mean};

const SIZE: [u32; 2] = [48, 48];

/// A wall behind a floor, onto which a spot light shines at a slant, so that a glossy floor mirrors it to the wall.
fn wall_behind(floor: Material) -> Scene {
    let mut scene = Scene::new("wall");
    scene.materials = vec![floor, Material::lambertian("wall", Vec3::splat(0.5))];
    let corners = |[x, y, z]: [f32; 3], depth: Vec3| {
        let origin = Vec3::new(x, y, z);
        [origin, origin + Vec3::X * 4.0, origin + Vec3::X * 4.0 + depth, origin + depth]
    };
    let floor = corners([-2.0, 0.0, 2.0], Vec3::NEG_Z * 4.0);
    let wall = corners([-2.0, 0.0, -2.0], Vec3::Y * 4.0);
    scene.meshes.push(
        Mesh {
            name: "wall and floor".into(),
            positions: [floor, wall].concat(),
            normals: [[Vec3::Y; 4], [Vec3::Z; 4]].concat(),
            uvs: vec![Vec2::ZERO; 8],
            triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
            triangle_materials: vec![0, 0, 1, 1],
            ..Mesh::default()
        }
        .into(),
    );
    scene.instances.push(Instance::fixed("wall and floor", 0, Affine3A::IDENTITY));
    scene.lights.push(Light {
        name: "spot".into(),
        kind: LightKind::Spot {
            intensity: Vec3::splat(50.0),
            inner_angle: 0.15,
            outer_angle: 0.2,
            falloff: SpotFalloff::default(),
        },
        position: Vec3::new(0.0, 2.5, 3.0),
        direction: Vec3::new(0.0, -2.5, -3.0).normalize(),
        radius: 0.0,
        half_angle: 0.0,
        animation: None,
    });
    scene.camera = Camera::looking(Vec3::new(0.0, 2.0, 4.0), Vec3::new(0.0, 2.0, -2.0));
    scene
}

#[test]
fn glossy_floors_light_the_wall_where_they_mirror_the_light() {
    let Some(gpu) = GpuFixture::open() else { return };
    let glossy = Material {
        f0: Vec3::splat(0.04),
        f90: 1.0,
        roughness: 0.5,
        ..Material::lambertian("floor", Vec3::new(0.8, 0.6, 0.3))
    };
    let brass = Material { metallic: 1.0, ..glossy.clone() };
    for (floor, name) in [(glossy, "varnish"), (brass, "brass")] {
        let scene = wall_behind(floor);
        let expected = reference(&format!("glossy-floor-{name}"), &scene, SIZE, 1, 400);
        let found = gpu.rendered(&Arc::new(scene), &exact(SIZE), 1).read_picture(true).unwrap();
        // The wall alone counts; its upper and lower half apart.
        let is_wall: Vec<bool> = layer(&found, "normal").iter().map(|normal| normal[2] > 0.5).collect();
        let half = is_wall.len() / 2;
        let light = |picture, rows: std::ops::Range<usize>| {
            let pixels = layer(picture, "indirect");
            mean(rows.filter(|&at| is_wall[at]).map(|at| luminance(&pixels[at])))
        };
        let ratio = |rows: std::ops::Range<usize>| light(&found, rows.clone()) / light(&expected, rows);
        let [above, below] = [ratio(0..half), ratio(half..2 * half)];
        assert!(
            (above - 1.0).abs() < 0.05 && (below - 1.0).abs() < 0.05,
            "{name}: {above} above, {below} below"
        );
    }
}
