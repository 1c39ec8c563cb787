//! Furnace tests: closed rooms with analytic radiance.

use std::sync::Arc;

use glam::{Affine3A, Vec3};
use glowworm::scene::{Camera, Instance, Material, Mesh, Scene, Texture};

use super::support::{assert_near, colour, layer, mean, picture, scene, settings};

/// A closed box of albedo `albedo` whose walls emit a radiance of 1, seen from inside.
fn furnace(albedo: f32) -> Scene {
    let mut scene = Scene::new("furnace");
    scene
        .materials
        .push(Material { emission: Vec3::ONE, ..Material::lambertian("wall", Vec3::splat(albedo)) });
    scene.meshes.push(Mesh::cuboid("box", Vec3::new(2.0, 1.0, 3.0), 0).turned_inside_out().into());
    scene.instances.push(Instance::fixed("box", 0, Affine3A::IDENTITY));
    scene.add_area_light(0);
    scene.camera = Camera { vertical_fov: 1.5, ..Camera::looking(Vec3::new(0.5, 0.1, 1.0), Vec3::ZERO) };
    scene
}

#[test]
fn an_emissive_box_has_the_radiance_of_its_series() {
    // Emission, and light scattered at 0 to B surfaces before the visible one.
    let series = |albedo: f32, bounces: i32| (0..=bounces + 1).map(|k| albedo.powi(k)).sum::<f32>();
    for (albedo, bounces, expected) in [
        (1.0, Some(0), 2.0),
        (1.0, Some(2), 4.0),
        (1.0, Some(6), 8.0),
        (0.5, Some(2), series(0.5, 2)),
        (0.5, None, 2.0),
        (0.8, None, 5.0),
    ] {
        let found = colour(&picture(&furnace(albedo), &settings(16, bounces), 512));
        assert_near(mean(&found).x, expected, 0.002);
        let mut worst: Vec<f32> = found.iter().map(|pixel| (pixel.y / expected - 1.0).abs()).collect();
        worst.sort_by(f32::total_cmp);
        let most = worst[worst.len() * 95 / 100];
        assert!(most < 0.03, "albedo {albedo}, {bounces:?} bounces: 5 % of the pixels are off by {most}");
    }
}

/// Rays that leaning normals send below the triangle are mirrored by it.
#[test]
fn leaning_normals_neither_make_light_nor_let_it_through() {
    for (texel, metallic) in [([128u8, 128, 255], 0.0), ([217, 128, 217], 0.0), ([217, 128, 217], 1.0)] {
        let mut scene = furnace(0.8);
        let [r, g, b] = texel;
        scene.textures.push(Texture::linear_from_rgba8("lean", 1, 1, vec![r, g, b, 255]).into());
        let wall = &mut scene.materials[0];
        (wall.normal_texture, wall.metallic, wall.roughness) = (Some(0.into()), metallic, 0.5);
        let mesh = Arc::make_mut(&mut scene.meshes[0]);
        mesh.tangents =
            mesh.normals.iter().map(|normal| normal.any_orthonormal_vector().extend(1.0)).collect();
        let found = colour(&picture(&scene, &settings(16, Some(0)), 256));
        if metallic == 0.0 {
            assert_near(mean(&found).x, 1.8, 0.005);
        } else {
            let reflected = mean(&found).x - 1.0;
            assert!((0.5..0.81).contains(&reflected), "{reflected}");
        }
        assert!(found.iter().all(|pixel| pixel.is_finite() && pixel.min_element() > 1.2));
    }
}

#[test]
fn the_integrating_sphere_is_lit_alike_everywhere() {
    // From a point light in the middle, (I/R^2)(rho + ... + rho^B) at every scale.
    const INTENSITY: f32 = 7.0;
    const ALBEDO: f32 = 0.6;
    for (radius, bounces) in
        [(2.0f32, Some(1)), (2.0, Some(4)), (200.0, Some(2)), (0.02, Some(2)), (2.0, None)]
    {
        let intensity = INTENSITY * radius * radius;
        let sphere = scene(&format!(
            r#"
            [[models]]
            name = "sphere"
            primitive = "sphere"
            size = [{radius}, {radius}, {radius}]
            subdivisions = 6
            material = {{ albedo = [{ALBEDO}, {ALBEDO}, {ALBEDO}] }}
            [[instances]]
            model = "sphere"
            [[lights]]
            type = "point"
            position = [0, 0, 0]
            intensity = [{intensity}, {intensity}, {intensity}]
            [camera]
            eye = [{eye}, 0, 0]
            target = [-{radius}, {eye}, 0]
            vfov_deg = 70
            "#,
            eye = radius * 0.3
        ));
        let rendered = picture(&sphere, &settings(16, bounces), 256);
        let passed_on = match bounces {
            Some(limit) => (1..=limit as i32).map(|bounce| ALBEDO.powi(bounce)).sum::<f32>(),
            None => ALBEDO / (1.0 - ALBEDO),
        };
        assert_near(mean(&layer(&rendered, "indirect")).x, INTENSITY * passed_on, 0.003);
        let direct = INTENSITY * ALBEDO / std::f32::consts::PI;
        assert_near(mean(&layer(&rendered, "direct")).x, direct, 0.003);
    }
}
