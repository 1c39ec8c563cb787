//! glTF files, made by code, and the scenes that they become.

use glam::{Quat, Vec2, Vec4};
use glowworm::scene::{Alpha, Minified, MipLevels, SpotFalloff, SurfacePoint, Wrap};
use serde_json::{Value, json};

use super::gltf_files::{add_accessor, buffer, data_uri, document, glb, load_glb, png};
use super::*;

#[test]
fn a_triangle_is_a_triangle_however_it_is_stored() {
    let mut external = document();
    external["buffers"][0]["uri"] = json!("my%20data.bin");
    let mut inline = document();
    inline["buffers"][0]["uri"] = json!(data_uri(&buffer()));
    let folder = Folder::new()
        .with("a.glb", glb(&document(), &buffer()))
        .with("b.gltf", external.to_string())
        .with("my data.bin", buffer())
        .with("c.gltf", inline.to_string());
    for name in ["a.glb", "b.gltf", "c.gltf"] {
        let scene = folder.load(name).unwrap();
        check_consistency(&scene);
        let mesh = &scene.meshes[0];
        assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
        assert!(mesh.normals.iter().all(|normal| *normal == Vec3::Z));
        assert_eq!(mesh.uvs, [Vec2::ZERO, Vec2::X, Vec2::Y]);
        assert_eq!(scene.instances[0].name, "n");
        // A camera and a sky are made up, as for an .obj.
        assert!(scene.lights.is_empty() && scene.environment.is_some());
        assert_eq!(scene.warnings.len(), 2, "{:?}", scene.warnings);
        let material = &scene.materials[mesh.triangle_materials[0] as usize];
        assert_eq!((material.metallic, material.roughness, material.f90), (1.0, 1.0, 1.0));
    }
    // As a model of a scene file, moved by its node.
    let mut moved = document();
    moved["nodes"][0]["translation"] = json!([0, 0, 5]);
    moved["nodes"][0]["scale"] = json!([-2, 1, 1]);
    let text = "[[models]]\nname = \"m\"\npath = \"m.glb\"\n[[instances]]\nmodel = \"m\"\n";
    let folder = folder.with("m.glb", glb(&moved, &buffer())).with("s.toml", text);
    let scene = folder.load("s.toml").unwrap();
    assert_eq!(scene.meshes[0].bounds(), (Vec3::new(-2.0, 0.0, 5.0), Vec3::new(0.0, 1.0, 5.0)));
    let front = scene.meshes[0].triangle_surface(0).interpolate(Vec2::splat(0.3));
    assert!(front.geometric_normal.z > 0.9 && front.normal.z > 0.9, "{front:?}");
}

#[test]
fn materials_are_read_with_their_textures() {
    let (mut document, bytes) = (document(), buffer());
    let colour = data_uri(&png(&[[255, 0, 0, 255], [255, 0, 0, 0]]));
    let data = data_uri(&png(&[[0, 128, 255, 255]]));
    document["images"] = json!([{ "uri": colour }, { "uri": data }]);
    document["textures"] = json!([{ "source": 0 }, { "source": 1 }]);
    document["extensionsUsed"] = json!([
        "KHR_materials_emissive_strength",
        "KHR_materials_specular",
        "KHR_materials_transmission",
        "KHR_materials_unlit",
        "EXT_something",
        "KHR_texture_transform"
    ]);
    document["materials"] = json!([
        {
            "name": "leaf",
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.5, 1, 1, 1], "metallicFactor": 0.5, "roughnessFactor": 0.8,
                "baseColorTexture": { "index": 0 }, "metallicRoughnessTexture": { "index": 1 }
            },
            "alphaMode": "MASK", "doubleSided": true,
            "emissiveFactor": [1, 0.5, 0],
            "extensions": {
                "KHR_materials_emissive_strength": { "emissiveStrength": 4 },
                "KHR_materials_specular": { "specularFactor": 0.5 }
            }
        },
        { "alphaMode": "BLEND", "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, 0.25] } },
        { "extensions": { "KHR_materials_transmission": { "transmissionFactor": 1 } }, "pbrMetallicRoughness": { "metallicFactor": 0 } },
        { "extensions": { "KHR_materials_unlit": {} }, "pbrMetallicRoughness": { "baseColorFactor": [0.2, 0.3, 0.4, 1] } }
    ]);
    document["meshes"][0]["primitives"][0]["material"] = json!(0);
    let scene = load_glb(&document, &bytes);
    check_consistency(&scene);
    let [leaf, veil, glass, sign] = std::array::from_fn(|index| &scene.materials[index]);
    assert_eq!((leaf.alpha, leaf.double_sided), (Alpha::Mask(0.5), true));
    assert!(scene.opaque_at(0, Vec2::new(0.25, 0.5)) && !scene.opaque_at(0, Vec2::new(0.75, 0.5)));
    let bsdf = leaf.bsdf_at(&scene, Vec2::new(0.25, 0.5));
    assert!(bsdf.base.distance(Vec3::new(0.5, 0.0, 0.0)) < 1e-5, "{bsdf:?}");
    assert!((bsdf.roughness - 0.8 * 128.0 / 255.0).abs() < 1e-5 && (bsdf.metallic - 0.5).abs() < 1e-5);
    assert_eq!((bsdf.f0, bsdf.f90), (Vec3::splat(0.02), 0.5));
    assert_eq!(leaf.emission, Vec3::new(4.0, 2.0, 0.0));
    assert!(scene.lights.iter().any(|light| matches!(light.kind, LightKind::Area { .. })));
    assert_eq!((veil.alpha, veil.opacity), (Alpha::Blend, 0.25));
    assert!(veil.is_thin_surface() && glass.is_thin_surface() && glass.transmission == 1.0);
    assert_eq!((sign.emission, sign.base_colour), (Vec3::new(0.2, 0.3, 0.4), Vec3::ZERO));
    let warning = scene.warnings.iter().find(|warning| warning.contains("not shown")).unwrap();
    assert!(warning.contains("EXT_something") && !warning.contains("KHR_"), "{warning}");
}

#[test]
fn images_of_other_formats_come_by_their_extensions() {
    let (mut document, bytes) = (document(), buffer());
    let mut webp = std::io::Cursor::new(Vec::new());
    let image = image::RgbaImage::from_pixel(2, 2, image::Rgba([10, 200, 30, 255]));
    image.write_to(&mut webp, image::ImageFormat::WebP).unwrap();
    document["images"] = json!([{ "uri": data_uri(webp.get_ref()), "mimeType": "image/webp" }]);
    document["textures"] = json!([{ "extensions": { "EXT_texture_webp": { "source": 0 } } }]);
    document["extensionsUsed"] = json!(["EXT_texture_webp"]);
    document["extensionsRequired"] = json!(["EXT_texture_webp"]);
    document["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
    document["meshes"][0]["primitives"][0]["material"] = json!(0);
    let scene = load_glb(&document, &bytes);
    assert_eq!(scene.textures[0].levels[0].2[..4], [10, 200, 30, 255]);
    // Nor is an index past the end a panic.
    document["textures"][0]["extensions"]["EXT_texture_webp"]["source"] = json!(7);
    expect_error("bad.glb", glb(&document, &bytes), &["textures[0].source", "past the end"]);
}

#[test]
fn texture_coordinates_are_transformed() {
    let (mut document, bytes) = (document(), buffer());
    document["images"] = json!([{ "uri": data_uri(&png(&[[255; 4]])) }]);
    document["textures"] = json!([{ "source": 0 }]);
    document["extensionsUsed"] = json!(["KHR_texture_transform"]);
    let transform =
        json!({ "offset": [0.5, 0.25], "scale": [2, 3], "rotation": std::f32::consts::FRAC_PI_2 });
    document["materials"] = json!([{ "pbrMetallicRoughness": {
        "baseColorTexture": { "index": 0, "extensions": { "KHR_texture_transform": transform } }
    } }]);
    document["meshes"][0]["primitives"][0]["material"] = json!(0);
    // The specification's matrix: translation * rotation * scale, with (c, -s; s, c) by columns.
    let scene = load_glb(&document, &bytes);
    let texture = scene.materials[0].base_colour_texture.unwrap();
    let uvs: Vec<Vec2> = scene.meshes[0].uvs.iter().map(|uv| texture.coordinates([*uv; 2])).collect();
    for (found, expected) in uvs.iter().zip([[0.5, 0.25], [0.5, -1.75], [3.5, 0.25]]) {
        assert!(found.distance(Vec2::from_array(expected)) < 1e-5, "{uvs:?}");
    }
}

#[test]
fn vertices_have_colours_tangents_and_two_sets_of_coordinates() {
    let (mut document, mut bytes) = (document(), buffer());
    let second = add_accessor(&mut document, &mut bytes, &[0.5, 0.0, 2.0, 0.0, 0.0, 3.0], "VEC2", 3);
    let tangents = [0.0f32, 2.0, 0.0, 1.0].repeat(3);
    let tangents = add_accessor(&mut document, &mut bytes, &tangents, "VEC4", 3);
    let colours =
        add_accessor(&mut document, &mut bytes, &[1.0, 0.0, 0.5, 0.0, 1.0, 0.0, 2.0, -1.0, 0.2], "VEC3", 3);
    let attributes = &mut document["meshes"][0]["primitives"][0]["attributes"];
    attributes["TEXCOORD_1"] = json!(second);
    attributes["TANGENT"] = json!(tangents);
    attributes["COLOR_0"] = json!(colours);
    document["meshes"][0]["primitives"][0]["material"] = json!(0);
    document["images"] = json!([{ "uri": data_uri(&png(&[[255, 0, 0, 255], [0, 255, 0, 255]])) }]);
    document["samplers"] = json!([{ "wrapS": 33071, "wrapT": 33648 }]);
    document["textures"] = json!([{ "source": 0, "sampler": 0 }, { "source": 0 }]);
    document["materials"] = json!([{
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0, "texCoord": 1 }, "metallicFactor": 0 },
        "normalTexture": { "index": 1 }
    }]);
    // Normals of their own, since the specification drops the tangents of those without.
    let normals = add_accessor(&mut document, &mut bytes, &[0.0f32, 0.0, 1.0].repeat(3), "VEC3", 3);
    document["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    let scene = load_glb(&document, &bytes);
    check_consistency(&scene);
    assert!(scene.warnings.iter().all(|warning| !warning.contains("not shown")), "{:?}", scene.warnings);
    let (mesh, material) = (&scene.meshes[0], &scene.materials[0]);
    assert_eq!(mesh.second_uvs[1], Vec2::new(2.0, 0.0));
    assert_eq!(mesh.tangents[0], Vec4::new(0.0, 1.0, 0.0, 1.0));
    assert_eq!(
        mesh.colours,
        [[1.0, 0.0, 0.5, 1.0], [0.0, 1.0, 0.0, 1.0], [1.0, 0.0, 0.2, 1.0]].map(Vec4::from_array)
    );
    let texture = material.base_colour_texture.unwrap();
    assert_eq!((texture.set, texture.wrap), (1, [Wrap::Clamp, Wrap::Mirror]));
    assert_eq!(material.normal_texture.unwrap().wrap, Wrap::REPEAT);
    // At the second corner u is 2, which is clamped to the green texel; so is the vertex.
    let point = SurfacePoint { triangle: 0, barycentrics: Vec2::X };
    let base = material.bsdf_at(&scene, mesh.interpolate(point).attributes).base;
    assert!(base.distance(Vec3::Y) < 1e-5, "{base}");
    // As integers of 8 bits, and without its own tangents in flat shading.
    let place = bytes.len().next_multiple_of(4);
    bytes.resize(place, 0);
    bytes.extend([[9u8, 8, 7, 255], [1, 2, 3, 4], [0; 4]].concat());
    document["buffers"][0]["byteLength"] = json!(bytes.len());
    document["bufferViews"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "buffer": 0, "byteOffset": place, "byteLength": 12 }));
    let view = document["bufferViews"].as_array().unwrap().len() - 1;
    document["accessors"][colours] =
        json!({ "bufferView": view, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC4" });
    document["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("NORMAL");
    let mesh = &load_glb(&document, &bytes).meshes[0];
    let bytes = [[9.0, 8.0, 7.0, 255.0], [1.0, 2.0, 3.0, 4.0], [0.0; 4]];
    assert_eq!(mesh.colours, bytes.map(|bytes| Vec4::from_array(bytes.map(|byte: f32| byte / 255.0))));
    assert!(mesh.tangents[0].distance(Vec4::new(1.0, 0.0, 0.0, -1.0)) < 1e-5, "{}", mesh.tangents[0]);
}

#[test]
fn quantised_vertices_are_what_they_stand_for() {
    let mut document = document();
    let mut bytes: Vec<u8> =
        [0u16, 0, 0, 0, 65_535, 0, 0, 0, 0, 32_768, 0, 0].iter().flat_map(|v| v.to_le_bytes()).collect();
    bytes.extend([0u16, 1, 2].iter().flat_map(|v| v.to_le_bytes()));
    document["bufferViews"] = json!([
        { "buffer": 0, "byteLength": 24, "byteStride": 8 },
        { "buffer": 0, "byteOffset": 24, "byteLength": 6 }
    ]);
    document["buffers"][0]["byteLength"] = json!(30);
    document["accessors"] = json!([
        { "bufferView": 0, "componentType": 5123, "normalized": true, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
        { "bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR" }
    ]);
    document["meshes"][0]["primitives"][0] = json!({ "attributes": { "POSITION": 0 }, "indices": 1 });
    document["nodes"][0]["scale"] = json!([4, 4, 4]);
    let file = |document: &Value| Folder::new().with("m.glb", glb(document, &bytes)).load("m.glb");
    assert!(file(&document).unwrap_err().to_string().contains("not of floats"));
    document["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    document["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let scene = file(&document).unwrap();
    let (_, max) = scene.bounds(&scene.pose(0.0));
    assert!(max.distance(Vec3::new(4.0, 4.0 * 32_768.0 / 65_535.0, 0.0)) < 1e-5, "{max}");
}

#[test]
fn lights_and_cameras_land_where_they_should() {
    let (mut document, bytes) = (document(), buffer());
    document["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    document["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "point", "intensity": 683, "color": [1, 0.5, 0] },
        { "type": "directional", "intensity": 1366 },
        { "type": "spot", "intensity": 683, "spot": { "innerConeAngle": 0.2, "outerConeAngle": 0.5 } }
    ] } });
    document["cameras"] =
        json!([{ "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1, "zfar": 50 } }]);
    let quarter = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2).to_array();
    let light = |light: u32| json!({ "KHR_lights_punctual": { "light": light } });
    document["nodes"] = json!([
        { "mesh": 0, "children": [1] },
        { "translation": [1, 2, 3], "children": [2, 3, 4, 5] },
        { "extensions": light(0), "translation": [1, 0, 0] },
        { "extensions": light(1), "rotation": quarter },
        { "extensions": light(2), "rotation": quarter, "scale": [2, 2, 2] },
        { "camera": 0, "translation": [0, 0, 4] }
    ]);
    let scene = load_glb(&document, &bytes);
    let [point, sun, spot] = std::array::from_fn(|index| &scene.lights[index]);
    assert_eq!(scene.lights.len(), 3);
    assert_eq!(point.kind, LightKind::Point { intensity: Vec3::new(1.0, 0.5, 0.0) });
    assert_eq!(point.position, Vec3::new(2.0, 2.0, 3.0));
    assert_eq!(sun.kind, LightKind::Directional { irradiance: Vec3::splat(2.0) });
    assert!(sun.direction.distance(Vec3::NEG_Y) < 1e-6 && spot.direction.distance(Vec3::NEG_Y) < 1e-6);
    let falloff = SpotFalloff::Square;
    assert_eq!(
        spot.kind,
        LightKind::Spot { intensity: Vec3::ONE, inner_angle: 0.2, outer_angle: 0.5, falloff }
    );
    assert_eq!(spot.position, Vec3::new(1.0, 2.0, 3.0));
    let camera = scene.camera;
    assert_eq!((camera.eye, camera.vertical_fov), (Vec3::new(1.0, 2.0, 7.0), 0.7));
    assert!(camera.forward().distance(Vec3::NEG_Z) < 1e-6 && camera.up == Vec3::Y);
    assert_eq!((camera.near, camera.far), (0.1, 50.0));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

#[test]
fn a_turning_node_is_the_turned_mesh() {
    let (mut document, mut bytes) = (document(), buffer());
    let times = add_accessor(&mut document, &mut bytes, &[0.5, 1.5], "SCALAR", 2);
    let turned = Quat::from_rotation_y(2.0).to_array();
    let turns =
        add_accessor(&mut document, &mut bytes, &[&[0.0, 0.0, 0.0, 1.0], &turned[..]].concat(), "VEC4", 2);
    let moves = add_accessor(&mut document, &mut bytes, &[0.0, 0.0, 0.0, 0.0, 3.0, 0.0], "VEC3", 2);
    document["nodes"] =
        json!([{ "children": [1], "scale": [2, 2, 2] }, { "mesh": 0, "translation": [1, 0, 0] }]);
    document["animations"] = json!([{
        "channels": [
            { "sampler": 0, "target": { "node": 0, "path": "rotation" } },
            { "sampler": 1, "target": { "node": 0, "path": "translation" } }
        ],
        "samplers": [{ "input": times, "output": turns }, { "input": times, "output": moves, "interpolation": "STEP" }]
    }]);
    let scene = load_glb(&document, &bytes);
    assert!(scene.instances[0].dynamic);
    for time in [0.0, 0.3, 0.5, 0.77, 1.1, 1.4999] {
        let share = ((time - 0.5) as f32).clamp(0.0, 1.0);
        let turn = Quat::from_rotation_y(2.0 * share);
        let expected = |p: Vec3| turn * (2.0 * (p + Vec3::X));
        let found = scene.pose(time).instances[0];
        for corner in [Vec3::ZERO, Vec3::X, Vec3::Y] {
            let (found, expected) = (found.transform_point3(corner), expected(corner));
            assert!(found.distance(expected) < 1e-4, "{time}: {found} {expected}");
        }
    }
}

#[test]
fn the_damaged_helmet_loads() {
    let Some(assets) = assets() else { return };
    let file = assets.join("damaged-helmet/DamagedHelmet.glb");
    if !file.is_file() {
        return;
    }
    let scene = load_scene(file.to_str().unwrap(), None).unwrap();
    check_consistency(&scene);
    assert_eq!(scene.triangle_count(), 15_452);
    let material = &scene.materials[0];
    assert!(material.base_colour_texture.is_some() && material.metallic_roughness_texture.is_some());
    // Its visor glows, most of it does not.
    let glowing: usize = scene
        .lights
        .iter()
        .map(|light| match &light.kind {
            LightKind::Area { triangles, .. } => triangles.len(),
            _ => 0,
        })
        .sum();
    assert!((100..8_000).contains(&glowing), "{glowing}");
    // Where an image is stretched to nothing there is no tangent.
    let without = scene.meshes[0].tangents.iter().filter(|tangent| tangent.w == 0.0).count();
    assert!(without * 100 < scene.meshes[0].tangents.len(), "{without}");
    let warning = scene.warnings.iter().find(|warning| warning.contains("not shown"));
    assert!(warning.is_some_and(|warning| warning.contains("occlusion")), "{:?}", scene.warnings);
    let mean = material.mean_bsdf(&scene);
    assert!((0.2..0.9).contains(&mean.roughness) && (0.1..1.0).contains(&mean.metallic), "{mean:?}");
}

#[test]
fn samplers_say_how_images_are_filtered() {
    use MipLevels::{First, Interpolated, Nearest};
    for (mag, min, nearest, minified) in [
        (None, None, false, (false, Interpolated)),
        (Some(9728), None, true, (true, Interpolated)),
        (None, Some(9728), true, (true, First)),
        (Some(9729), Some(9728), false, (true, First)),
        (Some(9728), Some(9729), true, (false, First)),
        (Some(9728), Some(9984), true, (true, Nearest)),
        (Some(9729), Some(9985), false, (false, Nearest)),
        (Some(9728), Some(9986), true, (true, Interpolated)),
        (Some(9728), Some(9987), true, (false, Interpolated)),
    ] {
        let mut document = document();
        document["images"] = json!([{ "uri": data_uri(&png(&[[255; 4]; 4])) }]);
        let mut sampler = json!({});
        for (key, value) in [("magFilter", mag), ("minFilter", min)] {
            if let Some(value) = value {
                sampler[key] = json!(value);
            }
        }
        document["samplers"] = json!([sampler]);
        document["textures"] = json!([{ "source": 0, "sampler": 0 }]);
        document["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
        document["meshes"][0]["primitives"][0]["material"] = json!(0);
        let used = load_glb(&document, &buffer()).materials[0].base_colour_texture.unwrap();
        let (texels, levels) = minified;
        assert_eq!(
            (used.nearest, used.minified),
            (nearest, Minified { nearest: texels, levels }),
            "{mag:?} {min:?}"
        );
    }
}

#[test]
fn texels_count_by_their_alpha_where_the_material_uses_it() {
    // White leaves a quarter of the image, the rest is black and transparent.
    let image = data_uri(&png(&[[255; 4], [0; 4], [0; 4], [0; 4]]));
    for (mode, expected) in [("OPAQUE", 0.25), ("MASK", 1.0), ("BLEND", 1.0)] {
        let mut document = document();
        document["images"] = json!([{ "uri": image }]);
        document["textures"] = json!([{ "source": 0 }]);
        let pbr = json!({ "baseColorTexture": { "index": 0 }, "metallicFactor": 0 });
        document["materials"] = json!([{ "alphaMode": mode, "pbrMetallicRoughness": pbr }]);
        document["meshes"][0]["primitives"][0]["material"] = json!(0);
        let scene = load_glb(&document, &buffer());
        let mean = scene.materials[0].mean_bsdf(&scene).base.x;
        assert!((mean - expected).abs() < 0.01, "{mode}: {mean}");
    }
}
