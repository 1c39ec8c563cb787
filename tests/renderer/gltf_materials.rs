//! Materials of glTF files as the specification has them, by raster and by the path tracer: alpha, sides, filters, depth.

use glam::Vec3;
use glowworm::formats::load_scene;
use glowworm::scene::Camera;
use image::{DynamicImage, ImageBuffer};
use serde_json::json;

use super::gltf_files::{File, Pair, pictures};
use super::support::{channel, layer, mean};

const WHITE: u16 = u16::MAX;

fn alphas(left: u16, right: u16) -> Pair {
    [left, right].map(|alpha| [WHITE, WHITE, WHITE, alpha])
}

#[test]
fn masks_cut_where_alpha_is_below_the_cutoff() {
    let steps = Some(alphas(0, WHITE));
    let fades = Some([[1.0; 4], [1.0, 1.0, 1.0, 0.0]]);
    // Factor, cutoff, texture and whether its texels are nearest, vertices; from where to where the 2 m are there.
    for (factor, cutoff, texture, nearest, colours, [from, to]) in [
        (1.0, 0.5, None, false, fades, [0.0, 1.0]),
        (1.0, 0.25, None, false, fades, [0.0, 1.5]),
        (0.8, 0.32, Some(alphas(52_428, 52_428)), false, fades, [0.0, 1.0]),
        (1.0, 0.25, steps, false, None, [0.75, 2.0]),
        (1.0, 0.5, steps, false, None, [1.0, 2.0]),
        (1.0, 0.75, steps, false, None, [1.25, 2.0]),
        (1.0, 0.75, Some(alphas(1, WHITE)), false, None, [1.25, 2.0]),
        (0.5, 0.25, steps, false, None, [1.0, 2.0]),
        (1.0, 0.25, steps, true, None, [1.0, 2.0]),
        (1.0, 0.75, steps, true, None, [1.0, 2.0]),
        // Both alphas have the same 8 bits.
        (1.0, 0.5005, Some(alphas(0x8000, 0x8040)), true, None, [1.0, 2.0]),
        (1.0, 0.0, steps, false, fades, [0.0, 2.0]),
        (1.0, 1.0, Some(alphas(254 * 257, WHITE)), true, None, [1.0, 2.0]),
        (1.0, 1.1, steps, true, None, [0.0, 0.0]),
    ] {
        let name = format!("{factor} {texture:?} {nearest} {colours:?} at {cutoff}");
        let mut file = File::new();
        let mut pbr = json!({ "baseColorFactor": [0.5, 0.5, 0.5, factor], "metallicFactor": 0 });
        if let Some(pair) = texture {
            pbr["baseColorTexture"] = json!({ "index": file.texture(pair, nearest) });
        }
        let cut = json!({ "alphaMode": "MASK", "alphaCutoff": cutoff, "pbrMetallicRoughness": pbr });
        let cut = file.material(cut);
        let wall = file.material(json!({ "doubleSided": true }));
        file.quad(Vec3::ZERO, 1.0, cut, colours, json!({}));
        file.quad(Vec3::new(0.0, 0.0, -1.0), 4.0, wall, None, json!({}));
        // Light travels half a metre to the right on its way to the wall.
        let half = 0.5 * 0.5f32.atan();
        let turn = [0.0, -half.sin(), 0.0, half.cos()];
        file.node(json!({ "name": "sun", "rotation": turn, "extensions": { "KHR_lights_punctual": { "light": 0 } } }));
        for (who, picture) in pictures(file.scene(Vec3::new(0.0, 0.0, 6.0), 0.3), [64, 24], 1) {
            // Whether the quad is there at a place; none too near to an edge to tell.
            let there = |x: f32, y: f32| {
                let edges = [x + 1.0 - from, x + 1.0 - to, x - 1.0, x + 1.0, y.abs() - 0.5];
                let near = edges.iter().any(|edge| edge.abs() < 0.03);
                (!near).then_some(y.abs() < 0.5 && x + 1.0 > from && x + 1.0 < to)
            };
            let places = layer(&picture, "position").into_iter().zip(layer(&picture, "direct"));
            let mut known = 0;
            for ([x, y, z], [direct, _, _]) in places {
                let (at, is_quad) =
                    if z > -0.5 { ([x, y], true) } else { ([x * 6.0 / 7.0, y * 6.0 / 7.0], false) };
                known += usize::from(there(at[0], at[1]).is_some());
                assert!(
                    there(at[0], at[1]).is_none_or(|there| there == is_quad),
                    "{who}, {name}: seen at {at:?}"
                );
                if !is_quad && let Some(there) = there(x - 0.5, y) {
                    assert_eq!(direct == 0.0, there, "{who}, {name}: shadow at {x} {y}");
                }
            }
            assert!(known > 1200, "{known}");
        }
    }
}

#[test]
fn blended_surfaces_fade_by_factor_texture_and_vertices() {
    let fades = Some([[1.0; 4], [1.0, 1.0, 1.0, 0.0]]);
    // Alpha at the left and at the right end.
    for (factor, texture, colours, ends) in [
        (1.0, None, fades, [1.0, 0.0]),
        (0.999, None, fades, [0.999, 0.0]),
        (1.0, Some(alphas(20_000, 20_000)), None, [0.305; 2]),
        (0.5, Some(alphas(257 * 128, 257 * 128)), fades, [0.251, 0.0]),
    ] {
        let mut file = File::new();
        let mut pbr = json!({ "baseColorFactor": [0, 0, 0, factor], "metallicFactor": 0 });
        if let Some(pair) = texture {
            pbr["baseColorTexture"] = json!({ "index": file.texture(pair, false) });
        }
        let veil = file.material(json!({ "alphaMode": "BLEND", "pbrMetallicRoughness": pbr }));
        let sign = file.material(json!({ "extensions": { "KHR_materials_unlit": {} } }));
        file.quad(Vec3::ZERO, 1.0, veil, colours, json!({}));
        file.quad(Vec3::new(0.0, 0.0, -1.0), 4.0, sign, None, json!({}));
        for (who, picture) in pictures(file.scene(Vec3::new(0.0, 0.0, 6.0), 0.1), [32, 10], 64) {
            for column in 0..32 {
                let shown = mean((0..10).map(|row| picture.colour[32 * row + column][0]));
                let x = 6.0 * 0.05f32.tan() * 3.2 * ((column as f32 + 0.5) / 16.0 - 1.0);
                let part = 0.5 * (x + 1.0);
                let expected = 1.0 - (ends[0] + (ends[1] - ends[0]) * part);
                assert!(
                    (shown - expected).abs() < 0.06,
                    "{who}, {factor} {texture:?} at {x}: {shown} {expected}"
                );
            }
        }
    }
}

/// Sides: how an emitter or a sign looks from its front and from its back, and how much light arrives on both sides.
#[test]
fn emitters_shine_from_the_sides_that_the_material_shows() {
    let lit =
        json!({ "emissiveFactor": [1, 1, 1], "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1] } });
    let sign = json!({ "extensions": { "KHR_materials_unlit": {} } });
    for (what, material, double, mirrored) in [
        ("emitter", &lit, false, false),
        ("emitter", &lit, true, false),
        ("emitter", &lit, false, true),
        ("emitter", &lit, true, true),
        ("sign", &sign, false, false),
        ("sign", &sign, true, true),
    ] {
        let mut file = File::new();
        let mut material = material.clone();
        material["doubleSided"] = json!(double);
        let glow = file.material(material);
        // Black walls that face the emitter, so that the one before it does not show.
        let wall = file.material(
            json!({ "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0 } }),
        );
        let scale = if mirrored { [-1.0, 1.0, 1.0] } else { [1.0, 1.0, 1.0] };
        file.quad(Vec3::ZERO, 0.4, glow, None, json!({ "scale": scale }));
        file.quad(Vec3::new(0.0, 0.0, -0.5), 3.0, wall, None, json!({}));
        let turned = json!({ "rotation": [0, 1, 0, 0] });
        file.quad(Vec3::new(0.0, 0.0, -0.5), 3.0, wall, None, turned);
        let name = format!("{what}, double {double}, mirrored {mirrored}");
        let mut on_walls = Vec::new();
        for side in [1.0, -1.0] {
            for (who, picture) in pictures(file.scene(Vec3::new(0.0, 0.0, 4.0 * side), 0.25), [24, 24], 64) {
                let front = double || side > 0.0;
                let middle = picture.colour[24 * 12 + 12][0];
                let expected = if front { 0.99..1.01 } else { 0.0..0.5 };
                assert!(expected.contains(&middle), "{who}, {name}, from {side}: {middle}");
                assert_eq!(channel(&picture, "instance")[24 * 12 + 12] == 0.0, front, "{who}, {name}");
                // The wall behind the emitter, above it.
                let walls = layer(&picture, "indirect");
                on_walls.push((who, side, mean(walls[..24 * 4].iter().map(|irradiance| irradiance[0]))));
            }
        }
        let expected = on_walls.iter().find(|(who, side, _)| *who == "reference" && *side < 0.0).unwrap().2;
        assert!(expected > 0.05, "{name}: {expected}");
        for (who, side, irradiance) in on_walls {
            let ratio = irradiance / expected;
            let lit = double || side < 0.0;
            assert!(
                if lit { (ratio - 1.0).abs() < 0.08 } else { ratio < 1e-4 },
                "{who}, {name}: {ratio} on the wall that {side} sees"
            );
        }
    }
}

#[test]
fn backs_of_single_sided_surfaces_do_not_show_but_cast_shadows() {
    for (double, mirrored) in [(false, false), (true, false), (false, true), (true, true)] {
        let mut file = File::new();
        let pane = file.material(json!({ "doubleSided": double }));
        let wall = file.material(json!({}));
        let mut turned = json!({ "rotation": [0, 1, 0, 0] });
        if mirrored {
            // Mirrored through the origin: its back is where its front was.
            turned = json!({ "scale": [1, 1, -1] });
        }
        file.quad(Vec3::new(0.0, 0.0, -0.1), 0.3, pane, None, turned);
        file.quad(Vec3::new(0.0, 0.0, -1.0), 4.0, wall, None, json!({}));
        file.node(json!({ "name": "sun", "extensions": { "KHR_lights_punctual": { "light": 0 } } }));
        for (who, picture) in pictures(file.scene(Vec3::new(0.0, 0.0, 6.0), 0.2), [16, 16], 1) {
            let at = 16 * 8 + 8;
            let shown = channel(&picture, "instance")[at];
            assert_eq!(shown, if double { 0.0 } else { 1.0 }, "{who}, double {double}, mirrored {mirrored}");
            let direct = layer(&picture, "direct");
            assert_eq!(direct[at][0] > 0.0, double, "{who}: {:?}", direct[at]);
            assert!(direct[0][0] > 0.1, "{who}: {:?}", direct[0]);
        }
    }
}

/// Values of the left and the right texel of a texture in one use, in a layer of the picture.
fn halves_of(use_of: &str, pair: Pair, nearest: bool, layer_name: &str) -> Vec<(&'static str, Vec<f32>)> {
    let mut file = File::new();
    let texture = json!({ "index": file.texture(pair, nearest) });
    let mut material = json!({ "pbrMetallicRoughness": { "metallicFactor": 0 } });
    match use_of {
        "baseColorTexture" => material["pbrMetallicRoughness"][use_of] = texture,
        "metallicRoughnessTexture" => {
            material["pbrMetallicRoughness"] =
                json!({ "metallicFactor": 1, "metallicRoughnessTexture": texture });
        }
        _ => material[use_of] = texture,
    }
    material["emissiveFactor"] =
        if use_of == "emissiveTexture" { json!([1, 1, 1]) } else { json!([0, 0, 0]) };
    let material = file.material(material);
    file.quad(Vec3::ZERO, 1.0, material, None, json!({}));
    let rows =
        pictures(file.scene(Vec3::new(0.0, 0.0, 6.0), 0.02), [32, 4], 1).into_iter().map(|(who, picture)| {
            let row = match layer_name {
                "colour" => picture.colour[32..64].to_vec(),
                name => layer(&picture, name)[32..64].to_vec(),
            };
            (who, row.into_iter().map(|value| value[0]).collect())
        });
    rows.collect()
}

#[test]
fn nearest_filters_make_steps_in_every_use() {
    let (dark, light) = ([0x4040, 0x4040, 0x4040, WHITE], [0xc0c0, 0xc0c0, 0xc0c0, WHITE]);
    let lean = |red: u16| [red, 0x8080, 0xf0f0, WHITE];
    for (use_of, pair, name) in [
        ("baseColorTexture", [dark, light], "albedo"),
        ("emissiveTexture", [dark, light], "colour"),
        ("metallicRoughnessTexture", [dark, light], "albedo"),
        ("normalTexture", [lean(0x4040), lean(0xc0c0)], "normal"),
    ] {
        for nearest in [true, false] {
            for (who, row) in halves_of(use_of, pair, nearest, name) {
                let far = (row[0] - row[31]).abs();
                // The picture shows the middle of the two texels.
                let is_between =
                    |value: f32| [row[0], row[31]].iter().all(|end| (value - end).abs() > 0.1 * far);
                let between = row.iter().filter(|&&value| is_between(value)).count();
                assert!(far > 0.02, "{who}, {use_of}: {row:?}");
                assert!(
                    if nearest { between == 0 } else { between > 12 },
                    "{who}, {use_of}, {nearest}: {row:?}"
                );
            }
        }
    }
}

#[test]
fn images_go_on_beyond_their_borders_as_samplers_say() {
    let (dark, light) = ([0x4040, 0x4040, 0x4040, WHITE], [0xc0c0, 0xc0c0, 0xc0c0, WHITE]);
    // Which half is seen from one width of the image to its left to one to its right.
    for (wrap, halves) in [(10497, "DLDLDL"), (33648, "LDDLLD"), (33071, "DDDLLL")] {
        let mut file = File::new();
        let texture = file.wrapped_texture([dark, light], wrap);
        let transform = json!({ "scale": [3, 1], "offset": [-1, 0] });
        let texture = json!({ "index": texture, "extensions": { "KHR_texture_transform": transform } });
        let pbr = json!({ "metallicFactor": 0, "baseColorTexture": texture });
        let material = file.material(json!({ "pbrMetallicRoughness": pbr }));
        file.quad(Vec3::ZERO, 1.0, material, None, json!({}));
        // Two pixels see a texel.
        let eye = Vec3::new(0.0, 0.0, 6.0);
        for (who, picture) in pictures(file.scene(eye, 2.0 * (1.0f32 / 36.0).atan()), [12, 2], 1) {
            let row: Vec<f32> = layer(&picture, "albedo")[..12].iter().map(|albedo| albedo[0]).collect();
            let seen: String =
                row.iter().step_by(2).map(|&albedo| if albedo < 0.2 { 'D' } else { 'L' }).collect();
            assert_eq!(seen, halves, "{who}, {wrap}: {row:?}");
        }
    }
}

#[test]
fn colours_of_vertices_keep_the_dark() {
    let mut file = File::new();
    let white = file.material(json!({ "pbrMetallicRoughness": { "metallicFactor": 0 } }));
    let sign = file.material(json!({ "extensions": { "KHR_materials_unlit": {} } }));
    let greys = [0.2, 0.02, 0.002, 0.001];
    for (x, grey) in [-0.75, -0.25, 0.25, 0.75].into_iter().zip(greys) {
        let colours = Some([[grey, grey, grey, 1.0]; 2]);
        file.quad(Vec3::new(x, 0.125, 0.0), 0.25, white, colours, json!({}));
        file.quad(Vec3::new(x, -0.125, 0.0), 0.25, sign, colours, json!({}));
    }
    for (who, picture) in pictures(file.scene(Vec3::new(0.0, 0.0, 6.0), 0.02), [32, 2], 1) {
        // The upper row reflects, the lower one is unlit: emission has 9 bits.
        let shown = layer(&picture, "albedo").into_iter().take(32).zip(&picture.colour[32..]);
        for (column, (albedo, sign)) in shown.enumerate() {
            let x = 0.06 * 16.0 * ((column as f32 + 0.5) / 16.0 - 1.0);
            let expected = greys[((x + 1.0) * 2.0) as usize];
            assert!((albedo[0] / expected - 1.0).abs() < 2e-3, "{who} at {x}: {albedo:?} {expected}");
            assert!((sign[0] / expected - 1.0).abs() < 1e-2, "{who} at {x}: {sign:?} {expected}");
        }
    }
}

#[test]
fn images_keep_their_depth() {
    // 64 levels within 8 of those of 8 bits.
    let mut file = File::new();
    let ramp = ImageBuffer::from_fn(64, 1, |x, _| image::Luma([0x8000 + 32 * x as u16]));
    let ramp = file.image(&DynamicImage::ImageLuma16(ramp), true);
    let pbr = json!({ "metallicFactor": 0, "baseColorTexture": { "index": ramp } });
    let material = file.material(json!({ "pbrMetallicRoughness": pbr }));
    file.quad(Vec3::ZERO, 1.0, material, None, json!({}));
    for (who, picture) in
        pictures(file.scene(Vec3::new(0.0, 0.0, 6.0), 2.0 * (1.0f32 / 6.0 / 64.0).atan()), [64, 1], 1)
    {
        let levels: Vec<f32> = layer(&picture, "albedo").into_iter().map(|albedo| albedo[0]).collect();
        assert!(levels.is_sorted_by(|a, b| a < b), "{who}: {levels:?}");
        assert!((levels[0] - 0.214).abs() < 1e-3 && (levels[63] - 0.243).abs() < 1e-3, "{who}: {levels:?}");
    }
    let folder = tempfile::tempdir().unwrap();
    let glow = image::Rgb32FImage::from_pixel(2, 2, image::Rgb([8.0, 0.5, 0.02]));
    for name in ["glow.hdr", "glow.exr"] {
        DynamicImage::ImageRgb32F(glow.clone()).save(folder.path().join(name)).unwrap();
        let mtl = format!("newmtl a\nKd 0 0 0\nKe 2 2 2\nmap_Ke {name}\n");
        std::fs::write(folder.path().join("m.mtl"), mtl).unwrap();
        let obj = "mtllib m.mtl\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\nvt .5 .5\nusemtl a\nf 1/1 2/1 3/1\n";
        std::fs::write(folder.path().join("m.obj"), obj).unwrap();
        let mut scene = load_scene(folder.path().join("m.obj").to_str().unwrap(), None).unwrap();
        scene.environment = None;
        scene.camera = Camera::looking(Vec3::Z, Vec3::ZERO);
        for (who, picture) in pictures(scene, [8, 8], 1) {
            let shown = Vec3::from(picture.colour[36]);
            assert!(shown.distance(Vec3::new(16.0, 1.0, 0.04)) < 0.05, "{who}, {name}: {shown}");
        }
    }
}
