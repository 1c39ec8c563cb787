//! Files that are something else than their name says, names in any script, and text that would steer a terminal.

use serde_json::json;

use super::gltf_files::{buffer, data_uri, document, glb, png};
use super::program::{Run, assert_fails, stderr};
use super::*;

const POINTER: &str = "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 12345\n";
const PAGE: &str = "<!DOCTYPE html>\n<html><body>Not found</body></html>\n";

#[test]
fn files_that_are_something_else_are_called_what_they_are() {
    for (name, content, says) in [
        ("a.obj", POINTER.as_bytes(), "Git LFS pointer"),
        ("a.gltf", POINTER.as_bytes(), "Git LFS pointer"),
        ("a.glb", PAGE.as_bytes(), "HTML"),
        ("a.obj", PAGE.as_bytes(), "HTML"),
        ("a.toml", PAGE.as_bytes(), "HTML"),
        ("a.obj", b"PK\x03\x04abc", "ZIP"),
        ("a.glb", b"\x1f\x8b\x08abc", "gzip"),
        ("a.gltf", b"", "empty"),
        ("a.glb", &[0; 64], "zeros"),
        ("a.glb", b"glTF\x01\0\0\0\x20\0\0\0", "glTF 1.0"),
        ("a.gltf", br#"{"asset": {"version": "1.0"}, "meshes": {"m": {}}}"#, "glTF 1.0"),
        ("a.gltf", br#"{"meshes": {"m": {}}, "techniques": {}}"#, "glTF 1.0"),
        ("a.gltf", br#"{"asset": {"version": "1.0"}, "scene": "main"}"#, "glTF 1.0"),
        ("a.gltf", br#"{"name": "package"}"#, "without an asset"),
        ("a.gltf", b"{\"asset\": ", "JSON (EOF"),
    ] {
        expect_error(name, content, &[says]);
    }
    for (content, says) in [
        (POINTER.as_bytes(), "Git LFS pointer"),
        (PAGE.as_bytes(), "HTML"),
        (b"", "empty"),
        (b"GIF89a", "Gif"),
    ] {
        // As an image of an OBJ, of a glTF, a buffer, and a map of the environment.
        let folder = Folder::new()
            .with("m.obj", TRIANGLE)
            .with("m.mtl", "newmtl a\nmap_Kd t.png\n")
            .with("t.png", content)
            .with("t.hdr", content)
            .with("s.toml", "[environment]\nmap = \"t.hdr\"\n[[models]]\nname = \"m\"\npath = \"m.obj\"\n[[instances]]\nmodel = \"m\"\n");
        let warnings = folder.load("m.obj").unwrap().warnings;
        assert!(warnings.iter().any(|warning| warning.contains(says)), "{warnings:?}");
        let mut with_image = document();
        with_image["images"] = json!([{ "uri": "t.png" }]);
        with_image["textures"] = json!([{ "source": 0 }]);
        with_image["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
        let folder = folder.with("a.glb", glb(&with_image, &buffer()));
        let warnings = folder.load("a.glb").unwrap().warnings;
        let told = |warning: &String| warning.contains("image 0") && warning.contains(says);
        assert!(warnings.iter().any(told), "{warnings:?}");
        let error = folder.load("s.toml").unwrap_err().to_string();
        assert!(error.contains("t.hdr") && (error.contains(says) || says == "Gif"), "{error}");
        let mut with_buffer = document();
        with_buffer["buffers"][0]["uri"] = json!("t.png");
        let error = folder.with("a.gltf", with_buffer.to_string()).load("a.gltf").unwrap_err().to_string();
        assert!(error.contains("buffer 0") && (error.contains(says) || says == "Gif"), "{error}");
    }
}

#[test]
fn models_of_another_kind_are_refused_by_name() {
    for name in ["m.fbx", "m.stl", "m"] {
        let text = format!("[[models]]\nname = \"m\"\npath = \"{name}\"\n");
        let error =
            Folder::new().with(name, TRIANGLE).with("s.toml", text).load("s.toml").unwrap_err().to_string();
        assert!(error.contains("s.toml:1") && error.contains(name) && error.contains("convert"), "{error}");
    }
}

/// Palettes without the colours that texels name, images without a type or content: a warning, never a panic.
#[test]
fn malformed_images_are_warnings() {
    // A palette of one colour, of which texels name the second: a stored block of one row of one byte.
    let chunk =
        |name: &[u8; 4], data: &[u8]| [&(data.len() as u32).to_be_bytes()[..], name, data, &[0; 4]].concat();
    let row = [0x78, 1, 1, 2, 0, 0xfd, 0xff, 0, 0x10, 0, 0, 0, 0];
    let mut palette = b"\x89PNG\r\n\x1a\n".to_vec();
    for (name, data) in [
        (b"IHDR", &[0, 0, 0, 1, 0, 0, 0, 1, 4, 3, 0, 0, 0][..]),
        (b"PLTE", &[1, 2, 3]),
        (b"IDAT", &row),
        (b"IEND", &[]),
    ] {
        palette.extend(chunk(name, data));
    }
    for image in [palette, vec![7; 40], png(&[[255; 4]])[..30].to_vec()] {
        let folder = Folder::new()
            .with("m.obj", TRIANGLE)
            .with("m.mtl", "newmtl a\nmap_Kd t.png\n")
            .with("t.png", &image);
        let warnings = folder.load("m.obj").unwrap().warnings;
        assert!(
            warnings.iter().any(|warning| warning.contains("t.png") && warning.contains("checkerboard")),
            "{warnings:?}"
        );
        for source in [json!({ "bufferView": 0 }), json!({ "uri": data_uri(&image) })] {
            let mut with_image = document();
            with_image["images"] = json!([source]);
            with_image["textures"] = json!([{ "source": 0 }]);
            with_image["materials"] =
                json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
            let warnings = super::gltf_files::load_glb(&with_image, &buffer()).warnings;
            assert!(warnings.iter().any(|warning| warning.contains("image 0")), "{warnings:?}");
        }
    }
}

#[test]
fn data_uris_are_read_as_writers_have_them() {
    let image = png(&[[255, 0, 0, 255]]);
    let uri = data_uri(&image);
    let encoded = uri.split_once(',').unwrap().1;
    let percent: String = image.iter().map(|byte| format!("%{byte:02x}")).collect();
    for uri in [
        uri.clone(),
        uri.trim_end_matches('=').to_owned(),
        format!("data:application/octet-stream;base64,{encoded}"),
        format!("data:;base64,{encoded}"),
        format!("DATA:image/png;charset=utf-8;BASE64,{}", encoded.replace('+', "-").replace('/', "_")),
        format!("data:image/png;base64,{}", encoded.replace('=', "%3D")),
        format!("data:image/png;base64,{}\n{}", &encoded[..8], &encoded[8..]),
        format!("data:image/png,{percent}"),
    ] {
        let mut with_image = document();
        with_image["images"] = json!([{ "uri": uri }]);
        with_image["textures"] = json!([{ "source": 0 }]);
        with_image["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
        let scene = Folder::new().with("a.glb", glb(&with_image, &buffer())).load("a.glb").unwrap();
        assert_eq!(scene.textures[0].sample(glam::Vec2::splat(0.5)), Vec3::X, "{uri}");
    }
}

#[test]
fn files_are_found_whatever_their_name() {
    for (file, uri) in [
        ("a b.png", "a%20b.png"),
        ("a b.png", "a b.png"),
        ("\u{fc}.png", "%C3%BC.png"),
        ("\u{fc}.png", "u\u{308}.png"),
        ("u\u{308}.png", "\u{fc}.png"),
        ("日本 \u{2764}'#.png", "日本 \u{2764}'#.png"),
        ("100%.png", "100%.png"),
        ("a%20b.png", "a%20b.png"),
        ("A.PNG", "a.png"),
        ("a.png", "./a.png?v=1"),
        ("a.png", ".\\a.png"),
    ] {
        let mut with_image = document();
        with_image["images"] = json!([{ "uri": uri }]);
        with_image["textures"] = json!([{ "source": 0 }]);
        with_image["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
        let folder =
            Folder::new().with(file, png(&[[255, 0, 0, 255]])).with("a.glb", glb(&with_image, &buffer()));
        let scene = folder.load("a.glb");
        assert!(scene.is_ok(), "{uri}: {}", scene.unwrap_err());
    }
}

#[test]
fn names_in_any_script_are_kept_in_an_exr_and_resumed() {
    for name in ["日本", "\u{fc}", "a\u{1f600}b"] {
        let run = Run::new();
        std::fs::write(run.path(&format!("{name}.obj")), TRIANGLE).unwrap();
        for spp in ["1", "2"] {
            let scene = format!("{name}.obj");
            let output = run.glowworm(&[
                "reference",
                &scene,
                "--size",
                "4x4",
                "--spp",
                spp,
                "--layers",
                "--resume",
                "--out",
                "a.exr",
            ]);
            assert!(output.status.success(), "{}", stderr(&output));
            // The second goes on with the sample of the first.
            let said = String::from_utf8(output.stdout).unwrap();
            assert!(said.contains(&format!("{spp} samples per pixel")), "{said}");
        }
    }
}

#[test]
fn nothing_in_a_file_steers_the_terminal() {
    let evil = "a\\u001b[31m\\u0007\\u009bb";
    let run = Run::new();
    let model = format!("[[models]]\nname = \"{evil}\"\npath = \"{evil}.obj\"\n");
    std::fs::write(run.path("s.toml"), model).unwrap();
    let output = run.glowworm(&["reference", "s.toml", "--size", "4x4", "--out", "a.png"]);
    assert_fails(&output, 1, &["\\u{1b}[31m\\u{7}\\u{9b}b"]);
    assert!(!stderr(&output).trim_end().contains(|c: char| c.is_control()), "{:?}", stderr(&output));
    // In warnings, and on standard output.
    std::fs::write(run.path("m.obj"), TRIANGLE.replace("usemtl a", "usemtl a\u{1b}]0;title\u{7}")).unwrap();
    let output =
        run.glowworm(&["reference", "m.obj", "--size", "4x4", "--spp", "1", "--out", "b\u{1b}[2J.png"]);
    let said = stderr(&output) + &String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("a\\u{1b}]0;title\\u{7}") && said.contains("b\\u{1b}[2J.png"), "{said}");
    assert!(!said.contains(|c: char| c.is_control() && c != '\n'), "{said:?}");
}

#[cfg(unix)]
#[test]
fn pictures_are_written_through_links() {
    let run = Run::new();
    std::fs::write(run.path("m.obj"), TRIANGLE).unwrap();
    std::fs::create_dir(run.path("there")).unwrap();
    for (link, target) in [("a.png", "there/a.png"), ("b.exr", "there/b.exr")] {
        std::os::unix::fs::symlink(target, run.path(link)).unwrap();
        for _ in 0..2 {
            let output = run.glowworm(&["reference", "m.obj", "--size", "4x4", "--spp", "1", "--out", link]);
            assert!(output.status.success(), "{}", stderr(&output));
            assert!(std::fs::symlink_metadata(run.path(link)).unwrap().is_symlink());
            assert!(std::fs::symlink_metadata(run.path(target)).unwrap().is_file());
        }
    }
    assert_eq!(std::fs::read_dir(run.path("there")).unwrap().count(), 2);
}

#[test]
fn many_of_anything_load_in_seconds() {
    let begun = std::time::Instant::now();
    let corner = |i: usize| {
        let (radius, angle) =
            (if i.is_multiple_of(2) { 1.0 } else { 0.6 }, i as f64 * std::f64::consts::TAU / 20_000.0);
        format!("v {} {} 0\n", radius * angle.cos(), radius * angle.sin())
    };
    let star: String = (0..20_000).map(corner).collect();
    let face = (1..=20_000).map(|i| i.to_string()).collect::<Vec<_>>().join(" ");
    let alike = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{}", "f 1 2 3\n".repeat(140_000));
    for (name, text, area) in
        [("star", format!("{star}f {face}\n"), 0.6 * std::f32::consts::PI), ("alike", alike, 4.0)]
    {
        let folder = Folder::new().with(&format!("{name}.obj"), text).with(
            "s.toml",
            format!("[[models]]\nname = \"m\"\npath = \"{name}.obj\"\n[[instances]]\nmodel = \"m\"\n[camera]\neye = [0, 0, 3]\ntarget = [0, 0, 0]\n"),
        );
        let scene = folder.load("s.toml").unwrap();
        let mesh = &scene.meshes[0];
        let sum: f32 = (0..mesh.triangles.len() as u32).map(|triangle| mesh.triangle_area(triangle)).sum();
        assert!((sum / area - 1.0).abs() < 1e-3, "{name}: {sum}");
        let bvh = glowworm::bvh::TwoLevelBvh::build(&scene, &scene.pose(0.0).instances);
        assert!(bvh.bounds().1.x >= 0.99);
    }
    // A second or two; quadratic time would be minutes.
    assert!(begun.elapsed().as_secs() < 20, "{:?}", begun.elapsed());
}
