//! Pictures of glTF files: lights against their equations, and a turning node against the same mesh, turned.

use std::f32::consts::PI;
use std::sync::atomic::AtomicBool;

use glam::Quat;
use glowworm::reference::{PixelFilter, Reference, ReferenceSettings};
use glowworm::scene::Camera;
use serde_json::{Value, json};

use super::gltf_files::{add_accessor, buffer, document, glb, load_glb};
use super::*;

/// Radiance of each pixel, without indirect light.
fn picture(scene: &Scene, time: f64, size: [u32; 2], samples: u32) -> Vec<Vec3> {
    let settings =
        ReferenceSettings { size, bounces: Some(0), seed: 1, filter: PixelFilter::Center, layers: false };
    let pose = scene.pose(time);
    let reference = Reference::new(scene, &pose, &settings);
    let mut film = reference.film().unwrap();
    for _ in 0..samples {
        assert!(reference.add_sample(&mut film, &AtomicBool::new(false)));
    }
    film.picture().colour.iter().map(|&colour| Vec3::from(colour)).collect()
}

/// The document of a Lambertian triangle of this base colour.
fn matte(base: [f32; 3]) -> Value {
    let mut document = document();
    document["extensionsUsed"] = json!(["KHR_lights_punctual", "KHR_materials_specular"]);
    document["materials"] = json!([{
        "pbrMetallicRoughness": { "baseColorFactor": [base[0], base[1], base[2], 1], "metallicFactor": 0 },
        "extensions": { "KHR_materials_specular": { "specularFactor": 0 } }
    }]);
    document["meshes"][0]["primitives"][0]["material"] = json!(0);
    document
}

/// The point of the triangle that is looked at.
const POINT: Vec3 = Vec3::new(0.25, 0.25, 0.0);

#[test]
fn punctual_lights_bring_the_irradiance_that_their_units_say() {
    let base = Vec3::new(0.8, 0.5, 0.2);
    let colour = Vec3::new(1.0, 0.5, 0.25);
    // Candela and lux over 683 lm/W.
    let intensity = colour * 2.0;
    let tilt = Quat::from_rotation_y(0.6);
    let aside = Vec3::new(1.0, 0.0, 2.0);
    let spot = json!({ "innerConeAngle": 0.4, "outerConeAngle": 0.8 });
    for (what, light, place, turn, expected) in [
        (
            "point",
            json!({ "type": "point" }),
            POINT + aside,
            Quat::IDENTITY,
            intensity * (aside.z / aside.length()) / aside.length_squared(),
        ),
        ("directional", json!({ "type": "directional" }), Vec3::ZERO, tilt, intensity * 0.6f32.cos()),
        (
            "spot on its axis",
            json!({ "type": "spot", "spot": spot }),
            POINT + Vec3::Z * 2.0,
            Quat::IDENTITY,
            intensity / 4.0,
        ),
        (
            "spot in its falloff",
            json!({ "type": "spot", "spot": spot }),
            POINT + Vec3::Z * 2.0,
            tilt,
            intensity / 4.0 * ((0.6f32.cos() - 0.8f32.cos()) / (0.4f32.cos() - 0.8f32.cos())).powi(2),
        ),
        (
            "spot beyond its cone",
            json!({ "type": "spot", "spot": spot }),
            POINT + Vec3::Z * 2.0,
            Quat::from_rotation_x(0.9),
            Vec3::ZERO,
        ),
    ] {
        let mut document = matte(base.to_array());
        let mut light = light;
        light["color"] = json!(colour.to_array());
        light["intensity"] = json!(2.0 * 683.0);
        document["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
        document["cameras"] =
            json!([{ "type": "perspective", "perspective": { "yfov": 0.001, "znear": 0.1, "zfar": 50 } }]);
        document["scenes"][0]["nodes"] = json!([0, 1, 2]);
        document["nodes"] = json!([
            { "mesh": 0 },
            {
                "extensions": { "KHR_lights_punctual": { "light": 0 } },
                "translation": place.to_array(), "rotation": turn.to_array()
            },
            { "camera": 0, "translation": (POINT + Vec3::new(0.0, 0.0, 4.0)).to_array() }
        ]);
        let mut scene = load_glb(&document, &buffer());
        // A sky is made up where they light nothing that is seen.
        let is_dark = expected == Vec3::ZERO;
        assert_eq!(
            (scene.environment.take().is_some(), !scene.warnings.is_empty()),
            (is_dark, is_dark),
            "{what}"
        );
        let seen = picture(&scene, 0.0, [4, 4], 4);
        for radiance in seen {
            let irradiance = radiance / base * PI;
            assert!(irradiance.distance(expected) < 3e-3, "{what}: {irradiance} instead of {expected}");
        }
    }
}

#[test]
fn a_frame_of_a_turning_node_is_the_picture_of_the_turned_mesh() {
    let (mut document, mut bytes) = (matte([0.7, 0.6, 0.5]), buffer());
    let times = add_accessor(&mut document, &mut bytes, &[0.0, 2.0], "SCALAR", 2);
    let end = Quat::from_rotation_y(2.0);
    let turns =
        add_accessor(&mut document, &mut bytes, &[[0.0, 0.0, 0.0, 1.0], end.to_array()].concat(), "VEC4", 2);
    document["animations"] = json!([{
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": "rotation" } }],
        "samplers": [{ "input": times, "output": turns }]
    }]);
    document["extensions"] =
        json!({ "KHR_lights_punctual": { "lights": [{ "type": "directional", "intensity": 2000 }] } });
    document["scenes"][0]["nodes"] = json!([0, 1]);
    document["nodes"] = json!([
        { "mesh": 0, "translation": [0.5, 0, 0] },
        { "extensions": { "KHR_lights_punctual": { "light": 0 } } }
    ]);
    let mut turning = load_glb(&document, &bytes);
    turning.camera = Camera::looking(Vec3::new(0.5, 0.5, 3.0), Vec3::new(0.5, 0.5, 0.0));
    let frames_per_second = 30.0;
    for frame in [0, 7, 22] {
        let time = f64::from(frame) / frames_per_second;
        // The file at rest, moved back to the origin, turned and put where its node is.
        let mut still = document.clone();
        still["nodes"][0] = json!({ "mesh": 0 });
        still.as_object_mut().unwrap().remove("animations");
        let degrees = (time as f32).to_degrees();
        let text = format!(
            "[[models]]\nname = \"m\"\npath = \"m.glb\"\n[[instances]]\nmodel = \"m\"\ntranslation = [0.5, 0, 0]\n\
             rotation = [0, {degrees}, 0]\n[camera]\neye = [0.5, 0.5, 3]\ntarget = [0.5, 0.5, 0]\nvfov_deg = 40\n\
             [[lights]]\ntype = \"directional\"\ndirection = [0, 0, -1]\nirradiance = [{0}, {0}, {0}]\n",
            2000.0 / 683.0
        );
        let turned =
            Folder::new().with("m.glb", glb(&still, &bytes)).with("s.toml", text).load("s.toml").unwrap();
        let [a, b] = [picture(&turning, time, [48, 48], 1), picture(&turned, 0.0, [48, 48], 1)];
        let lit = a.iter().filter(|radiance| radiance.x > 0.1).count();
        assert!(lit > 100, "frame {frame}: {lit} pixels");
        let different = a.iter().zip(&b).filter(|(a, b)| a.distance(**b) > 1e-3).count();
        assert!(different <= 2, "frame {frame}: {different} pixels differ");
    }
}
