//! Many surfaces of which a share is there, one behind the other.

use std::sync::Arc;

use glam::{Affine3A, Vec2, Vec3};
use glowworm::output::Picture;
use glowworm::scene::{Alpha, Camera, Instance, Light, LightKind, Material, Mesh, Scene};
use glowworm::settings::{Indirect, Settings};

use super::support::golden::reference;
use super::support::{GpuFixture, exact, layer, luminance, mean};

const SIZE: [u32; 2] = [16, 16];

fn veil(opacity: f32, material: Material) -> Material {
    Material { alpha: Alpha::Blend, opacity, ..material }
}

/// Adds a square from -1 to 1 in the plane z = 0, whose front faces +z.
fn add_square(scene: &mut Scene, material: Material, place: Affine3A) -> usize {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
    let mut mesh = Mesh::polygon("square", &corners, scene.materials.len() as u32);
    mesh.uvs = corners.map(|corner| Vec2::new(0.5 + 0.5 * corner.x, 0.5)).to_vec();
    scene.instances.push(Instance::fixed("square", scene.meshes.len(), place));
    scene.meshes.push(mesh.into());
    scene.materials.push(material);
    scene.instances.len() - 1
}

fn light_of(picture: &Picture, name: &str) -> f32 {
    mean(layer(picture, name).iter().map(luminance))
}

#[test]
fn all_of_many_veils_are_there() {
    const VEILS: i32 = 20;
    let Some(gpu) = GpuFixture::open() else { return };
    for albedo in [0.0, 1.0] {
        let mut scene = Scene::new("veils");
        add_square(&mut scene, Material::emitter("wall", Vec3::ONE), Affine3A::from_scale(Vec3::splat(9.0)));
        for index in 1..=VEILS {
            let place = Affine3A::from_translation(Vec3::Z * 0.02 * index as f32)
                * Affine3A::from_scale(Vec3::splat(9.0));
            let paper = Material {
                double_sided: index % 2 == 0,
                ..Material::lambertian("veil", Vec3::splat(albedo))
            };
            add_square(&mut scene, veil(0.05, paper), place);
        }
        scene.lights.push(Light {
            name: "sun".into(),
            kind: LightKind::Directional { irradiance: Vec3::splat(3.0) },
            position: Vec3::ZERO,
            direction: Vec3::new(0.3, 0.2, -1.0).normalize(),
            radius: 0.0,
            half_angle: 0.0,
            animation: None,
        });
        scene.camera = Camera { vertical_fov: 0.3, ..Camera::looking(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO) };
        let expected = light_of(&reference("veils", &scene, SIZE, 0, 256), "direct");
        if albedo == 0.0 {
            assert!((expected / 0.95f32.powi(VEILS) - 1.0).abs() < 0.01, "{expected}");
        }
        let settings = Settings { indirect: Indirect::NONE, ..exact(SIZE) };
        let found = gpu.rendered(&Arc::new(scene), &settings, 1).read_picture(true).unwrap();
        let found = mean(found.colour.iter().map(luminance));
        assert!((found / expected - 1.0).abs() < 0.01, "albedo {albedo}: {found} for {expected}");
    }
}
