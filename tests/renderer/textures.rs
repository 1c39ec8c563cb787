//! Textures of the picture against the path tracer's, which averages the full image over each pixel: contrast at grazing angles, atlases
//! of blocks that are not interpolated.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{Affine3A, Vec2, Vec3};
use glowworm::reference::{PixelFilter, Reference, ReferenceSettings};
use glowworm::scene::{
    Camera, Instance, Material, Mesh, Minified, MipLevels, Scene, Texture, TextureUse, luminance,
};
use glowworm::settings::{Antialiasing, Indirect, Settings};

use super::support::depth::quick_or_all;
use super::support::{GpuFixture, layer, mean, plain};

/// A horizontal scene of side 20 about the origin, seen at so many degrees from its normal.
fn floor(mesh: Mesh, texture: Texture, used: TextureUse, degrees: f32) -> Arc<Scene> {
    let mut scene = Scene::new("floor");
    scene.textures.push(texture.into());
    let white = Material::lambertian("floor", Vec3::ONE);
    scene.materials.push(Material { base_colour_texture: Some(used), ..white });
    scene.meshes.push(mesh.into());
    scene.instances.push(Instance::fixed("floor", 0, Affine3A::IDENTITY));
    let (sin, cos) = degrees.to_radians().sin_cos();
    let camera = Camera::looking(6.0 * Vec3::new(0.0, cos, sin), Vec3::ZERO);
    scene.camera = Camera { vertical_fov: 0.52, ..camera };
    scene.into()
}

const CORNERS: [[f32; 2]; 4] = [[-10.0, 10.0], [10.0, 10.0], [10.0, -10.0], [-10.0, -10.0]];

fn checkerboard(degrees: f32) -> Arc<Scene> {
    let mut mesh = Mesh::polygon("floor", &CORNERS.map(|[x, z]| Vec3::new(x, 0.0, z)), 0);
    mesh.uvs.iter_mut().for_each(|uv| *uv *= 10.0);
    let texels = (0u32..256 * 256).flat_map(|i| {
        let grey = if (i / 32 + i / 256 / 32).is_multiple_of(2) { 40 } else { 230 };
        [grey, grey, grey, 255]
    });
    floor(mesh, Texture::from_rgba8("checkerboard", 256, 256, texels.collect()), 0.into(), degrees)
}

/// Frames after which antialiasing has sampled each pixel at all positions.
const POSITIONS: u32 = 16;

/// Albedo by raster, the mean of all positions in the pixel where antialiasing averages them, and by the path tracer.
fn albedos(
    gpu: &GpuFixture,
    scene: &Arc<Scene>,
    size: [u32; 2],
    antialiasing: Antialiasing,
) -> [Vec<f32>; 2] {
    let settings = Settings { size, indirect: Indirect::NONE, antialiasing, ..plain() };
    let frames = if antialiasing == Antialiasing::Taa { POSITIONS } else { 1 };
    let drawn = gpu.mean_of_frames(scene, &settings, frames, |picture| layer(picture, "albedo"));
    let settings =
        ReferenceSettings { size, bounces: Some(0), seed: 1, filter: PixelFilter::Box, layers: true };
    let pose = scene.pose(0.0);
    let reference = Reference::new(scene, &pose, &settings);
    let mut film = reference.film().unwrap();
    for _ in 0..64 {
        assert!(reference.add_sample(&mut film, &AtomicBool::new(false)));
    }
    [drawn, layer(&film.picture(), "albedo")]
        .map(|albedo| albedo.into_iter().map(|albedo| luminance(albedo.into())).collect())
}

/// The mean deviation of the 3 x 3 pixels around each.
fn contrast(albedo: &[f32], [width, height]: [u32; 2]) -> f32 {
    let (width, height) = (width as usize, height as usize);
    let places = (1..height - 1).flat_map(|y| (1..width - 1).map(move |x| y * width + x));
    let deviation = |at: usize| {
        let around = || (0..9).map(|i| albedo[at + i / 3 * width + i % 3 - width - 1]);
        let middle = mean(around());
        mean(around().map(|value| (value - middle).powi(2))).sqrt()
    };
    mean(places.map(deviation))
}

#[test]
fn floors_keep_their_contrast_at_any_angle() {
    const SIZE: [u32; 2] = [240, 136];
    let Some(gpu) = GpuFixture::open() else { return };
    for &degrees in quick_or_all(&[1.0, 70.0, 84.0][..], &[1.0, 45.0, 70.0, 80.0, 84.0]) {
        let scene = checkerboard(degrees);
        for antialiasing in [Antialiasing::None, Antialiasing::Taa] {
            let [drawn, expected] = albedos(&gpu, &scene, SIZE, antialiasing);
            let ratio = contrast(&drawn, SIZE) / contrast(&expected, SIZE);
            assert!((0.95..1.05).contains(&ratio), "{degrees} degrees, {antialiasing:?}: {ratio}");
        }
    }
}

/// A floor of 256 x 256 blocks, all with the same of 4 x 4 images of 16 x 16 texels.
fn blocks(minified: Minified) -> Arc<Scene> {
    const COUNT: usize = 256;
    let hash = |n: usize| (n.wrapping_mul(0x9e37_79b9) >> 7) % 1024;
    let texels = (0..64 * 64).flat_map(|i| {
        let tile = i / 64 / 16 * 4 + i % 64 / 16;
        let value = |channel: usize| {
            let base = 16 + hash(3 * tile + channel) % 200;
            (base + hash(i * i + 7 * channel) % 32) as u8
        };
        [value(0), value(1), value(2), 255]
    });
    let (mut mesh, mut normals) = (Mesh::default(), Vec::new());
    for block in 0..COUNT * COUNT {
        let (x, z) = (block % COUNT, block / COUNT);
        let first = mesh.positions.len() as u32;
        for [u, v] in [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]] {
            let at = Vec2::new(x as f32 + u, z as f32 + v) / COUNT as f32 * 20.0 - 10.0;
            mesh.positions.push(Vec3::new(at.x, 0.0, at.y));
            mesh.uvs.push(Vec2::new(1.0 + u, 1.0 + v) / 4.0);
            normals.push(Vec3::Y);
        }
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        mesh.triangle_materials.extend([0; 2]);
    }
    mesh.normals = normals;
    let used = TextureUse { nearest: true, minified, ..0.into() };
    floor(mesh, Texture::from_rgba8("atlas", 64, 64, texels.collect()), used, 45.0)
}

#[test]
fn atlases_of_blocks_do_not_bleed() {
    const SIZE: [u32; 2] = [160, 96];
    let Some(gpu) = GpuFixture::open() else { return };
    for levels in [MipLevels::First, MipLevels::Nearest, MipLevels::Interpolated] {
        let scene = blocks(Minified { nearest: true, levels });
        for antialiasing in [Antialiasing::None, Antialiasing::Taa] {
            let [drawn, expected] = albedos(&gpu, &scene, SIZE, antialiasing);
            let of_block = |albedo: &[f32], block: usize| {
                let first = block / 10 * 16 * 160 + block % 10 * 16;
                mean((0..256).map(|i| albedo[first + i / 16 * 160 + i % 16]))
            };
            let error = |block| (of_block(&drawn, block) / of_block(&expected, block) - 1.0).abs();
            let worst = (0..60).map(error).fold(0.0, f32::max);
            assert!(worst < 0.04, "{levels:?}, {antialiasing:?}: {worst}");
        }
    }
}
