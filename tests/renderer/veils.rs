//! Surfaces of which a share is there: many one behind the other, and such as emit.

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec2, Vec3, Vec4};
use glowworm::output::Picture;
use glowworm::scene::{Alpha, Camera, Instance, Light, LightKind, Material, Mesh, Scene, Texture};
use glowworm::settings::{Denoise, EffectSettings, Indirect, PathSettings, Settings, VplSettings};

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

/// What makes 0.4 of an emitter be there.
#[derive(Clone, Copy, Debug)]
enum By {
    Opacity,
    Texture,
    Vertices,
}

/// A floor under an emitter; `by`: of which 0.4 is there.
fn lit_by(by: Option<By>) -> Scene {
    let mut scene = Scene::new("floor");
    let level = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let floor = Affine3A::from_scale_rotation_translation(Vec3::splat(3.0), level, Vec3::ZERO);
    add_square(&mut scene, Material::lambertian("floor", Vec3::ONE), floor);
    let above = Affine3A::from_scale_rotation_translation(Vec3::splat(0.5), level.inverse(), Vec3::Y);
    let glowing = Material::emitter("glowing", Vec3::splat(10.0));
    let material = if by.is_some() { veil(1.0, glowing) } else { glowing };
    let emitter = add_square(&mut scene, material, above);
    match by {
        Some(By::Opacity) => scene.materials[1].opacity = 0.4,
        Some(By::Texture) => {
            let alphas = (0..8).flat_map(|texel| [255, 255, 255, [0, 204][texel / 4]]).collect();
            scene.materials[1].base_colour_texture = Some(scene.textures.len().into());
            scene.textures.push(Texture::from_rgba8("alpha", 8, 1, alphas).into());
        }
        Some(By::Vertices) => {
            let mesh = Arc::make_mut(&mut scene.meshes[1]);
            mesh.colours = mesh.uvs.iter().map(|uv| Vec4::new(1.0, 1.0, 1.0, 0.8 * uv.x)).collect();
        }
        None => {}
    }
    scene.add_area_light(emitter);
    // From beside the emitter.
    scene.camera = Camera { vertical_fov: 0.8, ..Camera::looking(Vec3::new(0.0, 0.8, 2.0), Vec3::ZERO) };
    scene
}

#[test]
fn emitters_that_blend_send_their_share() {
    let Some(gpu) = GpuFixture::open() else { return };
    let effects = EffectSettings { denoise: Denoise::NONE, ..EffectSettings::default() };
    let paths = PathSettings { samples: 16, ..PathSettings::default() };
    let paths = Settings { indirect: Indirect::PATHS, effects, paths, ..exact(SIZE) };
    let vpl = VplSettings { slots: 1024, pool: 1024, ..exact(SIZE).vpl };
    let vpls = Settings { vpl, ..exact(SIZE) };
    let light = |scene: Scene| {
        let traced = light_of(&reference("emitter", &scene, SIZE, 1, 512), "indirect");
        let scene = Arc::new(scene);
        let drawn = |settings: &Settings| {
            light_of(&gpu.rendered(&scene, settings, 1).read_picture(true).unwrap(), "indirect")
        };
        [("reference", traced), ("vpls", drawn(&vpls)), ("paths", drawn(&paths))]
    };
    let opaque = light(lit_by(None));
    for by in [By::Opacity, By::Texture, By::Vertices] {
        for ((method, found), (_, expected)) in light(lit_by(Some(by))).into_iter().zip(opaque) {
            let ratio = found / (0.4 * expected);
            assert!(expected > 0.1 && (ratio - 1.0).abs() < 0.02, "{by:?}, {method}: {ratio}");
        }
    }
}
