//! Each type of light against its equation, and all types together.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::Vec3;
use glowworm::bsdf::Bsdf;
use glowworm::output::Picture;
use glowworm::scene::{AlphaMask, LightKind, Scene, Texture};

use super::support::{assert_near, colour, layer, mean, picture, scene, settings};

/// A grey floor of albedo 0.5 seen from 4 above, with `more` of a scene file.
pub fn floor(more: &str) -> Scene {
    scene(&format!(
        r#"
        [[models]]
        name = "floor"
        primitive = "quad"
        size = [20, 1, 20]
        material = {{ albedo = [0.5, 0.5, 0.5] }}
        [[instances]]
        model = "floor"
        [camera]
        eye = [0, 4, 0]
        target = [0, 0, 0]
        up = [0, 0, -1]
        vfov_deg = 60
        {more}
        "#
    ))
}

/// Compares a layer with `expected` of the floor's points (x, z), pixel by pixel.
#[track_caller]
pub fn assert_floor(rendered: &Picture, values: &[Vec3], expected: impl Fn(Vec3) -> f32, tolerance: f32) {
    let positions = layer(rendered, "position");
    let peak = positions.iter().map(|&p| expected(p)).fold(0.0, f32::max);
    assert!(peak > 0.0);
    for (&position, value) in positions.iter().zip(values) {
        let expected = expected(position);
        let error = (value.x - expected).abs();
        assert!(error <= tolerance * peak, "{value} instead of {expected} at {position}");
    }
}

#[test]
fn a_point_light_falls_off_with_the_square() {
    let scene = floor("[[lights]]\ntype = \"point\"\nposition = [0.5, 2, 0]\nintensity = [3, 3, 3]");
    let rendered = picture(&scene, &settings(32, Some(2)), 64);
    let expected = |p: Vec3| {
        let d = Vec3::new(0.5, 2.0, 0.0) - p;
        0.5 / PI * 3.0 * (d.y / d.length()) / d.length_squared()
    };
    assert_floor(&rendered, &colour(&rendered), expected, 0.01);
    // A single flat floor has no indirect light.
    assert_eq!(mean(&layer(&rendered, "indirect")), Vec3::ZERO);
}

#[test]
fn a_spot_falls_off_by_smoothstep_in_the_cosine() {
    let scene = floor(
        "[[lights]]\ntype = \"spot\"\nposition = [0, 2, 0]\ndirection = [0, -1, 0]\nintensity = [3, 3, 3]\n\
         inner_deg = 20\nouter_deg = 40",
    );
    let rendered = picture(&scene, &settings(32, Some(2)), 256);
    let expected = |p: Vec3| {
        let d = Vec3::new(0.0, 2.0, 0.0) - p;
        let cosine = d.y / d.length();
        let (inner, outer) = (20f32.to_radians().cos(), 40f32.to_radians().cos());
        let t = ((cosine - outer) / (inner - outer)).clamp(0.0, 1.0);
        0.5 / PI * 3.0 * t * t * (3.0 - 2.0 * t) * cosine / d.length_squared()
    };
    assert_floor(&rendered, &colour(&rendered), expected, 0.015);
}

#[test]
fn a_directional_light_shines_along_its_direction_with_a_highlight() {
    let mut scene =
        floor("[[lights]]\ntype = \"directional\"\ndirection = [1, -1, 0]\nirradiance = [2, 2, 2]");
    let rendered = picture(&scene, &settings(16, Some(0)), 16);
    assert_floor(&rendered, &colour(&rendered), |_| 0.5 / PI * 2.0 * 0.5f32.sqrt(), 1e-4);

    for material in &mut scene.materials {
        (material.f0, material.f90, material.roughness) = (Vec3::splat(0.3), 1.0, 0.6);
    }
    // Written down once more, from the equations.
    let alpha: f32 = 0.36;
    let long = |cosine: f32| (alpha * alpha + (1.0 - alpha * alpha) * cosine * cosine).sqrt();
    let rendered = picture(&scene, &settings(16, Some(0)), 64);
    let expected = |p: Vec3| {
        let (to_light, to_eye) = (Vec3::new(-1.0, 1.0, 0.0).normalize(), (Vec3::Y * 4.0 - p).normalize());
        let half = (to_light + to_eye).normalize();
        let d = (alpha / (half.y * half.y * (alpha * alpha - 1.0) + 1.0)).powi(2) / PI;
        let v = 0.5 / (to_light.y * long(to_eye.y) + to_eye.y * long(to_light.y));
        let fresnel = 0.3 + 0.7 * (1.0 - half.dot(to_eye)).powi(5);
        // Light that is scattered twice adds little here: the floor is seen from above.
        let bsdf =
            Bsdf { base: Vec3::splat(0.5), metallic: 0.0, roughness: 0.6, f0: Vec3::splat(0.3), f90: 1.0 };
        let reflection = bsdf.prepare(Vec3::Y, to_eye);
        let again = reflection.evaluate(to_light).reflected.x / (fresnel * d * v);
        assert!((1.0..1.1).contains(&again), "{again}");
        (reflection.diffuse_albedo().x / PI + fresnel * d * v * again) * 2.0 * to_light.y
    };
    assert_floor(&rendered, &colour(&rendered), expected, 0.01);
}

const EMITTER: &str = "[[lights]]\ntype = \"area\"\nradiance = [5, 5, 5]\n\
                    polygon = [[-1, 2, -1], [1, 2, -1], [1, 2, 1], [-1, 2, 1]]";

#[test]
fn an_area_light_lights_by_its_form_factor_seen_or_not() {
    // Below the middle of a square of half edge a at height h: E = 4 L a/sqrt(a^2+h^2) atan(a/sqrt(a^2+h^2)) .
    let slant = (1.0f32 + 4.0).sqrt();
    let below = 5.0 * 4.0 / slant * (1.0 / slant).atan();
    for visible in [true, false] {
        let mut scene = floor(&format!("{EMITTER}\nvisible = {visible}"));
        // From the side, below the light.
        scene.camera.eye = Vec3::new(0.0, 0.5, 3.0);
        scene.camera.up = Vec3::Y;
        scene.camera.vertical_fov = 0.02;
        let rendered = picture(&scene, &settings(8, Some(0)), 1024);
        assert_near(mean(&layer(&rendered, "indirect")).x, below, 0.01);
    }
}

#[test]
fn an_area_light_shines_from_its_front_only() {
    // The polygon above faces down: from above it is black, and surfaces above it stay dark.
    let scene = floor(EMITTER);
    let rendered = picture(&scene, &settings(16, Some(0)), 16);
    let positions = layer(&rendered, "position");
    let on_lamp: Vec<Vec3> = colour(&rendered)
        .into_iter()
        .zip(&positions)
        .filter(|(_, p)| (p.y - 2.0).abs() < 1e-3)
        .map(|(colour, _)| colour)
        .collect();
    assert!(on_lamp.len() > 20 && on_lamp.iter().all(|&colour| colour == Vec3::ZERO));

    // An emissive quad faces up; rotated by 180 degrees, it lights the floor.
    let quad = |rotation: &str| {
        floor(&format!(
            "[[models]]\nname = \"glow\"\nprimitive = \"quad\"\nsize = [1, 1, 1]\n\
             material = {{ albedo = [0, 0, 0], emission = [9, 9, 9] }}\n\
             [[instances]]\nmodel = \"glow\"\ntranslation = [0, 1, 0]\nrotation = {rotation}"
        ))
    };
    let lit = |rotation| mean(&layer(&picture(&quad(rotation), &settings(16, Some(0)), 64), "indirect")).x;
    assert_eq!(lit("[0, 0, 0]"), 0.0);
    assert!(lit("[180, 0, 0]") > 0.1);
}

#[test]
fn lights_of_all_kinds_add_up() {
    let lights = [
        "[[lights]]\ntype = \"point\"\nposition = [0.5, 2, 0]\nintensity = [30, 3, 3]",
        "[[lights]]\ntype = \"spot\"\nposition = [-1, 2, 0]\ndirection = [0.2, -1, 0]\nintensity = [0.3, 3, 3]\nouter_deg = 40",
        "[[lights]]\ntype = \"directional\"\ndirection = [1, -1, 0.3]\nirradiance = [0.2, 0.2, 2]",
        // If visible, it would occlude the others.
        &format!("{EMITTER}\nvisible = false"),
    ];
    let wall = "[[models]]\nname = \"wall\"\nprimitive = \"box\"\nsize = [0.2, 3, 8]\n\
                material = { albedo = [0.8, 0.8, 0.8] }\n\
                [[instances]]\nmodel = \"wall\"\ntranslation = [2, 1.5, 0]";
    let rendered = |lights: &str| {
        let picture = picture(&floor(&format!("{wall}\n{lights}")), &settings(16, Some(2)), 1024);
        [mean(&layer(&picture, "direct")), mean(&layer(&picture, "indirect")), mean(&colour(&picture))]
    };
    let together = rendered(&lights.join("\n"));
    let apart = lights.map(rendered);
    for part in 0..3 {
        let sum: Vec3 = apart.iter().map(|parts| parts[part]).sum();
        for channel in 0..3 {
            assert_near(together[part][channel], sum[channel], 0.01);
        }
    }
}

/// An area light with half of it masked equals one of half the size, for light samples and for scattered rays.
#[test]
fn holes_in_an_area_light_emit_nothing() {
    let panel = |left: f32, right: f32| {
        floor(&format!(
            "[[lights]]\ntype = \"area\"\nradiance = [1, 1, 1]\n\
             polygon = [[{left}, 3, -1], [{right}, 3, -1], [{right}, 3, 1], [{left}, 3, 1]]"
        ))
    };
    let mut masked = panel(-1.0, 1.0);
    masked.alpha_masks.push(AlphaMask { nearest: true, ..AlphaMask::new([2, 1], vec![255, 0]) });
    let mesh = Arc::make_mut(masked.meshes.last_mut().unwrap());
    for (uv, position) in mesh.uvs.iter_mut().zip(&mesh.positions) {
        uv.x = (0.5 * (position.x + 1.0)).clamp(0.0, 0.999);
    }
    let material = mesh.triangle_materials[0] as usize;
    masked.materials[material].alpha_mask = Some(0);
    let irradiance = |scene: &Scene| mean(&layer(&picture(scene, &settings(16, Some(1)), 256), "indirect")).x;
    let (ours, expected) = (irradiance(&masked), irradiance(&panel(-1.0, 0.0)));
    assert!(expected > 0.0);
    assert_near(ours, expected, 0.02);
}

#[test]
fn a_textured_area_light_shines_where_its_texture_does() {
    let panel = |left: f32, right: f32| {
        floor(&format!(
            "[[lights]]\ntype = \"area\"\nradiance = [1, 1, 1]\n\
             polygon = [[{left}, 0.5, -1], [{right}, 0.5, -1], [{right}, 0.5, 1], [{left}, 0.5, 1]]"
        ))
    };
    let mut textured = panel(-1.0, 1.0);
    let texels: Vec<u8> =
        (0..64).flat_map(|texel| if texel < 32 { [255; 4] } else { [0, 0, 0, 255] }).collect();
    textured.textures.push(Texture::from_rgba8("half", 64, 1, texels).into());
    let mesh = Arc::make_mut(textured.meshes.last_mut().unwrap());
    for (uv, position) in mesh.uvs.iter_mut().zip(&mesh.positions) {
        uv.x = (0.5 * (position.x + 1.0)).clamp(0.001, 0.999);
    }
    let material = mesh.triangle_materials[0] as usize;
    textured.materials[material].emission_texture = Some((textured.textures.len() - 1).into());
    textured.lights.clear();
    textured.add_area_light(textured.instances.len() - 1);
    // The light is spread over pieces of its triangles, of which those on the dark half emit nothing.
    let LightKind::Area { triangles, .. } = &textured.lights[0].kind else { panic!("an area light") };
    assert!(triangles.len() > 8, "{} pieces", triangles.len());
    let irradiance = |scene: &Scene| layer(&picture(scene, &settings(16, Some(1)), 1024), "indirect");
    let (ours, expected) = (irradiance(&textured), irradiance(&panel(-1.0, 0.0)));
    let columns = |values: &[Vec3], from: usize| {
        let part = values.iter().enumerate().filter(|(pixel, _)| pixel % 16 / 4 == from);
        mean(&part.map(|(_, value)| *value).collect::<Vec<_>>()).x
    };
    // The floor beside the panel.
    for from in [0, 3] {
        assert_near(columns(&ours, from), columns(&expected, from), if from == 0 { 0.02 } else { 0.1 });
    }
}
