//! Reflection and transmission by surfaces: white furnaces, mirrors, thin surfaces.

use glam::{Affine3A, Vec3};
use glowworm::scene::{
    Alpha, Camera, Environment, EnvironmentMap, Instance, Light, LightKind, Material, Mesh, Scene,
};

use super::support::{assert_near, colour, layer, mean, picture, settings};

fn sphere(material: Material) -> Scene {
    let mut scene = Scene::new("sphere");
    scene.materials.push(material);
    scene.meshes.push(Mesh::sphere("sphere", 1.0, 6, 0).into());
    scene.instances.push(Instance::fixed("sphere", 0, Affine3A::IDENTITY));
    scene.camera = Camera { vertical_fov: 0.75, ..Camera::looking(Vec3::Z * 3.0, Vec3::ZERO) };
    scene
}

#[test]
fn a_white_sphere_in_a_white_environment_cannot_be_seen() {
    for step in (0..=10).step_by(crate::depth::quick_or_all(5, 1)) {
        for metallic in [0.0, 1.0] {
            let roughness = step as f32 / 10.0;
            let white = Material {
                metallic,
                roughness,
                f0: Vec3::splat(0.04),
                f90: 1.0,
                ..Material::lambertian("white", Vec3::ONE)
            };
            let mut scene = sphere(white);
            scene.environment = Some(Environment::constant(Vec3::ONE));
            let rendered = picture(&scene, &settings(8, Some(1)), 8192);
            for (pixel, found) in colour(&rendered).into_iter().enumerate() {
                assert!(
                    (found - 1.0).abs().max_element() < 0.02,
                    "roughness {roughness}, metallic {metallic}, pixel {pixel}: {found}"
                );
            }
            let [direct, reflected] = ["direct", "reflected"].map(|name| mean(&layer(&rendered, name)).x);
            // The background is direct light; a metal has nothing but its GGX lobe.
            if metallic == 1.0 {
                assert_near(direct + reflected, 1.0, 0.01);
            }
            let middle = layer(&rendered, "indirect")[4 * 8 + 4].x;
            assert_near(middle, std::f32::consts::PI, 0.01);
        }
    }
}

/// A floor of `material` under a light, seen from above.
/// Rays that smooth normals send below the triangle are mirrored by it, so that the rim of a coarse sphere is as bright.
#[test]
fn a_coarse_white_sphere_cannot_be_seen_either() {
    for (roughness, metallic) in [(0.0, 1.0), (0.5, 1.0), (1.0, 0.0)] {
        let white = Material { metallic, roughness, ..Material::lambertian("white", Vec3::ONE) };
        let mut scene = sphere(white);
        scene.meshes[0] = Mesh::sphere("sphere", 1.0, 1, 0).into();
        scene.environment = Some(Environment::constant(Vec3::ONE));
        for found in colour(&picture(&scene, &settings(16, Some(4)), 512)) {
            assert!(found.min_element() > 0.9, "roughness {roughness}, metallic {metallic}: {found}");
        }
    }
}

fn lit_floor(material: Material) -> Scene {
    let mut scene = Scene::new("floor");
    scene.materials.push(material);
    let corners = [[-9.0, 9.0], [9.0, 9.0], [9.0, -9.0], [-9.0, -9.0]].map(|[x, z]| Vec3::new(x, 0.0, z));
    scene.meshes.push(Mesh::polygon("floor", &corners, 0).into());
    scene.instances.push(Instance::fixed("floor", 0, Affine3A::IDENTITY));
    let camera = Camera::looking(Vec3::new(0.0, 1.0, 3.0), Vec3::ZERO);
    scene.camera = Camera { vertical_fov: 0.02, ..camera };
    scene.lights.push(Light {
        name: "lamp".into(),
        kind: LightKind::Point { intensity: Vec3::splat(8.0) },
        position: Vec3::Y * 2.0,
        direction: Vec3::NEG_Y,
        radius: 0.0,
        half_angle: 0.0,
        animation: None,
    });
    scene
}

/// Adds a horizontal thin surface of `material` at height `y`.
fn add_thin_surface(scene: &mut Scene, material: Material, y: f32) {
    scene.materials.push(material);
    let material = scene.materials.len() as u32 - 1;
    let corners = [[-9.0, 9.0], [9.0, 9.0], [9.0, -9.0], [-9.0, -9.0]].map(|[x, z]| Vec3::new(x, y, z));
    scene.meshes.push(Mesh::polygon("thin surface", &corners, material).into());
    let mesh = scene.meshes.len() - 1;
    scene.instances.push(Instance::fixed("thin surface", mesh, Affine3A::IDENTITY));
}

#[test]
fn a_mirror_shows_what_it_faces() {
    let mirror = Material {
        metallic: 1.0,
        roughness: 0.0,
        ..Material::lambertian("mirror", Vec3::new(0.9, 0.6, 0.3))
    };
    let mut scene = lit_floor(mirror);
    // A glowing ceiling; the light, which has no size, is not seen in a mirror.
    scene.materials.push(Material::emitter("glow", Vec3::splat(2.0)));
    let corners =
        [[-99.0, -99.0], [99.0, -99.0], [99.0, 99.0], [-99.0, 99.0]].map(|[x, z]| Vec3::new(x, 5.0, z));
    scene.meshes.push(Mesh::polygon("ceiling", &corners, 1).into());
    scene.instances.push(Instance::fixed("ceiling", 1, Affine3A::IDENTITY));
    scene.add_area_light(1);
    scene.camera.vertical_fov = 0.002;
    let rendered = picture(&scene, &settings(8, Some(0)), 16);
    // Schlick: the cosine is 1 / sqrt(10).
    let base = Vec3::new(0.9, 0.6, 0.3);
    let fresnel = base + (1.0 - base) * (1.0 - 1.0 / 10f32.sqrt()).powi(5);
    for found in colour(&rendered) {
        assert!(found.distance(2.0 * fresnel) < 5e-3, "{found} {fresnel}");
    }
    assert_eq!(mean(&layer(&rendered, "direct")), Vec3::ZERO);
}

#[test]
fn glossy_surfaces_reflect_glossy_surfaces() {
    // Between two white metal plates light goes back and forth: every bounce adds as much again.
    let plate =
        |roughness: f32| Material { metallic: 1.0, roughness, ..Material::lambertian("plate", Vec3::ONE) };
    for roughness in [0.0, 0.4] {
        let mut scene = Scene::new("plates");
        scene.materials.push(Material { emission: Vec3::ONE, ..plate(roughness) });
        scene.meshes.push(Mesh::cuboid("box", Vec3::new(2.0, 1.0, 3.0), 0).turned_inside_out().into());
        scene.instances.push(Instance::fixed("box", 0, Affine3A::IDENTITY));
        scene.add_area_light(0);
        scene.camera = Camera { vertical_fov: 1.2, ..Camera::looking(Vec3::new(0.5, 0.1, 1.0), Vec3::ZERO) };
        for (bounces, expected) in [(0, 2.0), (3, 5.0)] {
            let found = mean(&colour(&picture(&scene, &settings(12, Some(bounces)), 256)));
            assert_near(found.x, expected, 0.02);
        }
    }
}

#[test]
fn light_passes_a_thin_surface_tinted() {
    let floor = || lit_floor(Material::lambertian("floor", Vec3::splat(0.5)));
    let bare = mean(&colour(&picture(&floor(), &settings(4, Some(0)), 16)));
    // A tinted pane without reflection between light and floor, above the eye.
    let tint = Vec3::new(0.8, 0.5, 0.1);
    let pane = Material { transmission: 1.0, ..Material::lambertian("pane", tint) };
    let mut scene = floor();
    add_thin_surface(&mut scene, pane.clone(), 1.5);
    let found = mean(&colour(&picture(&scene, &settings(4, Some(0)), 64)));
    assert!(found.distance(bare * tint) < 1e-3 * bare.x, "{found} {bare}");
    // Between eye and floor as well: the light passes twice.
    let mut scene = floor();
    add_thin_surface(&mut scene, pane, 0.5);
    let found = mean(&colour(&picture(&scene, &settings(4, Some(0)), 4096)));
    assert!(found.distance(bare * tint * tint) < 0.02 * bare.x, "{found} {bare}");
    // A veil that is there in part: black, so what passes is the rest.
    let veil = Material { alpha: Alpha::Blend, opacity: 0.25, ..Material::lambertian("veil", Vec3::ZERO) };
    let mut scene = floor();
    add_thin_surface(&mut scene, veil.clone(), 1.5);
    add_thin_surface(&mut scene, veil, 1.6);
    let found = mean(&colour(&picture(&scene, &settings(4, Some(0)), 64)));
    assert_near(found.x, bare.x * 0.75 * 0.75, 1e-3);
}

#[test]
fn a_pane_of_glass_reflects_what_it_does_not_let_pass() {
    // In a white environment a clear pane cannot be seen, whatever its coat reflects.
    let clear = Material {
        transmission: 1.0,
        roughness: 0.0,
        f0: Vec3::splat(0.04),
        f90: 1.0,
        ..Material::lambertian("pane", Vec3::ONE)
    };
    let mut scene = Scene::new("pane");
    add_thin_surface(&mut scene, clear, 0.0);
    scene.environment = Some(Environment::constant(Vec3::ONE));
    scene.camera = Camera { vertical_fov: 0.5, ..Camera::looking(Vec3::new(0.0, 1.0, 3.0), Vec3::ZERO) };
    let rendered = picture(&scene, &settings(8, Some(1)), 4096);
    assert_near(mean(&colour(&rendered)).x, 1.0, 0.01);
    let reflected = mean(&layer(&rendered, "reflected")).x;
    assert!((0.1..0.3).contains(&reflected), "{reflected}");
}

/// A sky of a constant radiance in a map with a sun of 2 x 2 texels.
fn sky(sun: f32) -> Environment {
    let texel = |i: usize| if [20, 21].contains(&(i % 64)) && [8, 9].contains(&(i / 64)) { sun } else { 0.5 };
    let texels = (0..2048).map(|i| Vec3::splat(texel(i))).collect();
    Environment {
        radiance: Vec3::ONE,
        map: Some(std::sync::Arc::new(EnvironmentMap::new(64, 32, texels))),
        rotation: 0.3,
    }
}

#[test]
fn a_floor_under_a_sky_has_its_irradiance() {
    for sun in [0.5, 3000.0] {
        let mut scene = lit_floor(Material::lambertian("floor", Vec3::splat(0.5)));
        scene.lights.clear();
        let sky = sky(sun);
        // The integral over the upper hemisphere, on a fine grid.
        let (mut expected, steps) = (0.0f64, 2000);
        for i in 0..steps {
            let cosine = (i as f32 + 0.5) / steps as f32;
            let radius = (1.0 - cosine * cosine).sqrt();
            for j in 0..steps {
                let (sin, cos) = (std::f32::consts::TAU * (j as f32 + 0.5) / steps as f32).sin_cos();
                expected += f64::from(sky.radiance(Vec3::new(radius * sin, cosine, radius * cos)).x * cosine);
            }
        }
        expected *= std::f64::consts::TAU / f64::from(steps) / f64::from(steps);
        scene.environment = Some(sky);
        let rendered = picture(&scene, &settings(8, Some(0)), 4096);
        let found: Vec<f32> = layer(&rendered, "indirect").iter().map(|e| e.x).collect();
        let total: f32 = found.iter().sum::<f32>() / found.len() as f32;
        assert_near(total, expected as f32, 0.005);
        // No pixel is far off: the sun is found by sampling the map.
        assert!(found.iter().all(|e| (e / expected as f32 - 1.0).abs() < 0.1), "{found:?} {expected}");
    }
}

#[test]
fn a_white_sphere_under_an_uneven_sky_loses_no_light() {
    // Both strategies, weighted: a rough white metal sphere sends back all that arrives.
    for roughness in [0.2, 0.6] {
        let white = Material { metallic: 1.0, roughness, ..Material::lambertian("white", Vec3::ONE) };
        let mut scene = sphere(white);
        scene.environment = Some(sky(0.5));
        let rendered = picture(&scene, &settings(8, Some(0)), 4096);
        assert_near(mean(&colour(&rendered)).x, 0.5, 0.01);
    }
}
