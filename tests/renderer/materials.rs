//! Textured materials in the G-buffer and in direct light, against the path tracer.

use std::sync::Arc;

use glam::{Affine3A, Vec2, Vec3};
use glowworm::scene::{Camera, Instance, Light, LightKind, Material, Mesh, Scene, Texture};

use super::support::golden::reference;
use super::support::{GpuFixture, exact, layer};

const SIZE: [u32; 2] = [96, 72];

/// A texture of 16 x 16 texels whose colour is `colour` of the place.
fn texture(name: &str, linear: bool, colour: impl Fn(Vec2) -> Vec3) -> Texture {
    let texel = |i: u32| {
        let c = (colour(Vec2::new((i % 16) as f32, (i / 16) as f32) / 15.0) * 255.0).round();
        [c.x as u8, c.y as u8, c.z as u8, 255]
    };
    let texels = (0..256).flat_map(texel).collect();
    let make = if linear { Texture::linear_from_rgba8 } else { Texture::from_rgba8 };
    make(name, 16, 16, texels)
}

/// A floor whose roughness rises to the right, metallic to the back, and which glows in a corner, under a light.
pub fn floor() -> Scene {
    let mut scene = Scene::new("floor");
    let base = texture("base", false, |at| Vec3::new(0.9, 0.3 + 0.6 * at.x, 0.9 - 0.7 * at.y));
    scene.textures.push(base.into());
    scene.textures.push(texture("data", true, |at| Vec3::new(1.0, 0.2 + 0.7 * at.x, at.y)).into());
    scene.textures.push(texture("glow", false, |at| Vec3::splat((at.x + at.y - 1.6).max(0.0))).into());
    scene.materials.push(Material {
        base_colour_texture: Some(0.into()),
        metallic: 0.9,
        roughness: 0.8,
        metallic_roughness_texture: Some(1.into()),
        f0: Vec3::splat(0.04),
        f90: 1.0,
        emission: Vec3::new(2.0, 1.0, 0.5),
        emission_texture: Some(2.into()),
        ..Material::lambertian("floor", Vec3::new(1.0, 0.9, 0.8))
    });
    let corners = [Vec2::new(0.0, 1.0), Vec2::ONE, Vec2::X, Vec2::ZERO];
    let uv = |at: Vec2| at * 0.9 + 0.05;
    scene.meshes.push(
        Mesh {
            name: "floor".into(),
            positions: corners.map(|at| Vec3::new(at.x * 4.0 - 2.0, 0.0, at.y * 4.0 - 2.0)).to_vec(),
            normals: vec![Vec3::Y; 4],
            uvs: corners.map(uv).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            triangle_materials: vec![0, 0],
            ..Mesh::default()
        }
        .into(),
    );
    scene.instances.push(Instance::fixed("floor", 0, Affine3A::IDENTITY));
    scene.add_area_light(0);
    scene.lights.push(Light {
        name: "lamp".into(),
        kind: LightKind::Point { intensity: Vec3::splat(9.0) },
        position: Vec3::new(0.3, 1.8, -1.5),
        direction: Vec3::NEG_Y,
        radius: 0.0,
        half_angle: 0.0,
        animation: None,
    });
    let camera = Camera::looking(Vec3::new(0.2, 2.4, 2.8), Vec3::new(0.0, -0.2, 0.0));
    scene.camera = Camera { vertical_fov: 0.9, ..camera };
    scene
}

#[test]
fn pixels_have_the_material_that_the_path_tracer_sees() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = floor();
    let expected = reference("floor", &scene, SIZE, 0, 1);
    let rendered = gpu.rendered(&Arc::new(scene), &exact(SIZE), 1).read_picture(true).unwrap();
    let covered = layer(&expected, "normal");
    for (name, share) in [("albedo", 0.02), ("direct", 0.04)] {
        let pairs = layer(&rendered, name).into_iter().zip(layer(&expected, name)).zip(&covered);
        let pairs: Vec<[Vec3; 2]> = pairs
            .filter(|(_, normal)| normal[1] > 0.5)
            .map(|((found, expected), _)| [Vec3::from(found), Vec3::from(expected)])
            .collect();
        assert!(pairs.len() > 3000, "{}", pairs.len());
        let [found, expected] = [0, 1].map(|of| pairs.iter().map(|pair| pair[of]).sum::<Vec3>());
        assert!((found / expected - 1.0).abs().max_element() < 0.01, "{name}: {found} {expected}");
        // Base colour and metallic have 8 bits.
        let far = pairs.iter().filter(|[found, expected]| {
            (*found - *expected).abs().max_element() > share * expected.max_element() + 0.01
        });
        let far = far.count();
        assert!(far * 100 < pairs.len(), "{name}: {far} of {} pixels differ", pairs.len());
    }
}
