//! VPLs on flat surfaces with steep normal maps: no light passes below a triangle, and none is lost.

use std::sync::Arc;

use glam::{Affine3A, Vec3};
use glowworm::scene::{Camera, Instance, Light, LightKind, Material, Mesh, Scene, Texture};
use glowworm::settings::{Preset, Settings, VplSettings};

use super::support::{GpuFixture, exact, layer, luminance, mean, plain};

const SIZE: [u32; 2] = [16, 16];

/// A box, turned inside out where `inside`, whose walls have two slopes, left and right by so many degrees.
fn bumpy_box(degrees: f32, size: Vec3, inside: bool, wall: Material) -> Scene {
    let mut scene = Scene::new("bumps");
    let texels = [degrees, -degrees].map(|degrees| {
        let normal = Vec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos());
        (normal * 127.5 + 127.5).round().extend(255.0).to_array().map(|value| value as u8)
    });
    scene.textures.push(Texture::linear_from_rgba8("slopes", 2, 1, texels.concat()).into());
    scene.materials.push(Material { normal_texture: Some(0.into()), ..wall });
    let mut mesh = Mesh::cuboid("box", size, 0);
    if inside {
        mesh = mesh.turned_inside_out();
    }
    mesh.tangents = mesh.normals.iter().map(|normal| normal.any_orthonormal_vector().extend(1.0)).collect();
    mesh.uvs.iter_mut().for_each(|uv| *uv *= 4.0);
    scene.meshes.push(mesh.into());
    scene.instances.push(Instance::fixed("box", 0, Affine3A::IDENTITY));
    scene
}

/// The mean of the luminance of a layer over that of the colour.
fn share(picture: &glowworm::output::Picture, name: &str) -> f32 {
    let of = |pixels: &[[f32; 3]]| mean(pixels.iter().map(luminance));
    of(&layer(picture, name)) / of(&picture.colour)
}

#[test]
fn a_flat_floor_sees_nothing_of_itself() {
    let Some(gpu) = GpuFixture::open() else { return };
    let glossy = Material { f0: Vec3::splat(0.04), f90: 1.0, roughness: 0.6, ..Material::grey("glossy") };
    for wall in [Material::lambertian("white", Vec3::splat(0.8)), glossy] {
        let mut scene = bumpy_box(45.0, Vec3::new(4.0, 0.1, 4.0), false, wall);
        scene.camera = Camera::looking(Vec3::new(0.0, 3.0, 0.1), Vec3::ZERO);
        scene.lights.push(Light {
            name: "sun".into(),
            kind: LightKind::Directional { irradiance: Vec3::ONE },
            position: Vec3::ZERO,
            direction: Vec3::new(0.3, -1.0, 0.1).normalize(),
            radius: 0.0,
            half_angle: 0.0,
            animation: None,
        });
        let scene = Arc::new(scene);
        let tonna = Settings { size: SIZE, ..Settings::default() }.with_preset(Preset::Tonna);
        let vpl = VplSettings { slots: 128, pool: 1024, ..VplSettings::default() };
        for settings in [exact(SIZE), Settings { size: SIZE, vpl, ..plain() }, tonna] {
            let picture = gpu.rendered(&scene, &settings, 2).read_picture(true).unwrap();
            assert!(mean(picture.colour.iter().map(luminance)) > 0.05);
            let own = share(&picture, "indirect");
            assert!(own < 1e-3, "{:?}: {own}", settings.preset);
        }
    }
}

/// Within walls of one radiance, every slope receives all of it. Takes 6 s: every VPL lights every pixel.
#[test]
fn bumpy_furnaces_keep_their_light() {
    const ALBEDO: f32 = 0.8;
    let Some(gpu) = GpuFixture::open() else { return };
    for degrees in [10.0, 30.0, 60.0] {
        let wall = Material { emission: Vec3::ONE, ..Material::lambertian("wall", Vec3::splat(ALBEDO)) };
        let mut scene = bumpy_box(degrees, Vec3::new(2.0, 1.0, 3.0), true, wall);
        scene.add_area_light(0);
        scene.camera = Camera { vertical_fov: 1.5, ..Camera::looking(Vec3::new(0.5, 0.1, 1.0), Vec3::ZERO) };
        let vpl = VplSettings { slots: 2048, pool: 2048, ..exact(SIZE).vpl };
        let settings = Settings { bounces: 2, vpl, ..exact(SIZE) };
        let found = gpu.rendered(&Arc::new(scene), &settings, 1).read_picture(true).unwrap();
        let expected = (0..=3).map(|bounce| ALBEDO.powi(bounce)).sum::<f32>();
        let ratio = mean(found.colour.iter().map(luminance)) / expected;
        assert!((ratio - 1.0).abs() < 0.01, "{degrees} degrees: {ratio}");
    }
}
