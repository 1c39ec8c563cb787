//! Broken files through the program: one line that names the file, exit code 1, and nothing written.

use serde_json::{Value, json};

use super::gltf_files::{buffer, document, glb};
use super::program::{Run, assert_fails, stderr};
use super::*;

const SMALL: [&str; 6] = ["--size", "8x8", "--spp", "1", "--out", "a.png"];

/// A scene file under the map `sky`, with the model `m.obj`.
fn under(sky: &str) -> String {
    format!(
        "[environment]\nmap = \"{sky}\"\n[[models]]\nname = \"m\"\npath = \"m.obj\"\n[[instances]]\nmodel = \"m\"\n\
         [camera]\neye = [0.2, 0.2, 3]\ntarget = [0.2, 0.2, 0]\n"
    )
}

fn exr<const N: usize>(names: [&str; N], texel: f32) -> Vec<u8> {
    let channels =
        names.map(|name| exr::prelude::AnyChannel::new(name, exr::prelude::FlatSamples::F32(vec![texel; 8])));
    let channels = exr::prelude::AnyChannels::sort(channels.into_iter().collect());
    let mut bytes = std::io::Cursor::new(Vec::new());
    let image = exr::prelude::Image::from_channels((4, 2), channels);
    exr::prelude::WritableImage::write(&image).to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

/// A changed GLB of a triangle.
fn changed(change: impl Fn(&mut Value, &mut Vec<u8>)) -> Vec<u8> {
    let (mut document, mut bytes) = (document(), buffer());
    change(&mut document, &mut bytes);
    glb(&document, &bytes)
}

#[test]
fn broken_files_end_the_program_with_one_line() {
    let whole = glb(&document(), &buffer());
    let nan = f32::NAN.to_le_bytes();
    let huge_hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n\x01\x02\x03\x80";
    for (name, content, says) in [
        ("bad.glb", whole[..whole.len() / 2].to_vec(), &["whole GLB"][..]),
        ("bad.glb", changed(|d, _| d["bufferViews"][0]["byteLength"] = json!(1000)), &["buffer view 0"]),
        ("bad.glb", changed(|d, _| d["accessors"][0]["type"] = json!("VEC2")), &["accessor 0", "POSITION"]),
        ("bad.glb", changed(|_, b| b[60] = 9), &["vertex 9"]),
        ("bad.glb", changed(|d, _| d["nodes"][0]["children"] = json!([0])), &["node 0", "below itself"]),
        ("bad.glb", changed(|d, _| d["buffers"][0]["uri"] = json!("gone.bin")), &["buffer 0", "gone.bin"]),
        (
            "bad.glb",
            changed(|d, _| d["buffers"][0]["uri"] = json!("../m.bin")),
            &["buffer 0", "out of the folder"],
        ),
        (
            "bad.glb",
            changed(|d, _| d["buffers"] = json!([{ "byteLength": 66 }, { "byteLength": 9 }])),
            &["buffer 1"],
        ),
        (
            "bad.glb",
            changed(|d, _| {
                d["extensionsRequired"] = json!(["EXT_unheard_of"]);
                d["meshes"][0]["primitives"][0]["extensions"] = json!({ "EXT_unheard_of": {} });
            }),
            &["EXT_unheard_of"],
        ),
        ("bad.glb", changed(|d, _| d["nodes"][0]["translation"] = json!([1e39, 0, 0])), &["bad.glb"]),
        ("bad.glb", changed(|_, b| b[..4].copy_from_slice(&nan)), &["accessor 0", "not finite"]),
        ("sky.exr", exr(["Z"], 1.0), &["s.toml:1", "sky.exr", "could not be decoded"]),
        ("sky.exr", exr(["B", "G", "R"], 1.0)[..200].to_vec(), &["sky.exr", "could not be decoded"]),
        ("sky.hdr", huge_hdr.to_vec(), &["sky.hdr", "row 0"]),
        ("sky.hdr", b"#?RADIANCE\n\n-Y 9 +X 99999999\n".to_vec(), &["sky.hdr", "99999999"]),
    ] {
        let run = Run::new();
        let folder = run.folder.path();
        std::fs::write(folder.join(name), &content).unwrap();
        let scene = if name == "bad.glb" { name } else { "s.toml" };
        if scene == "s.toml" {
            std::fs::write(folder.join(scene), under(name)).unwrap();
            std::fs::write(folder.join("m.obj"), TRIANGLE).unwrap();
        }
        let before = run.files();
        let output = run.glowworm(&[&["reference", scene], &SMALL[..]].concat());
        assert_fails(&output, 1, says);
        assert!(stderr(&output).contains(scene), "{}", stderr(&output));
        assert_eq!(run.files(), before, "{says:?}");
    }
}

/// An `.hdr` of one colour, run-length encoded by texels: 1, 1, 1, n repeats the texel before n times, then 256 n times.
fn plain_hdr(width: usize, height: usize) -> Vec<u8> {
    let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    let rest = width - 1;
    for _ in 0..height {
        bytes.extend([64, 128, 32, 129]);
        bytes.extend([1, 1, 1, (rest % 256) as u8, 1, 1, 1, (rest / 256) as u8]);
    }
    bytes
}

#[test]
fn maps_that_are_odd_or_huge_are_used_all_the_same() {
    for (name, content, says) in [
        ("sky.exr", exr(["B", "G", "R"], f32::NAN), "8 texels are not finite or negative; they are black"),
        ("sky.hdr", plain_hdr(32_768, 16_384), "is 32768 x 16384; it was shrunk to 8192 x 4096 texels"),
    ] {
        let run = Run::new();
        let folder = run.folder.path();
        std::fs::write(folder.join(name), &content).unwrap();
        std::fs::write(folder.join("s.toml"), under(name)).unwrap();
        std::fs::write(folder.join("m.obj"), TRIANGLE).unwrap();
        let output = run.glowworm(&[&["reference", "s.toml"], &SMALL[..], &["--out", "a.exr"]].concat());
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(0), "{message}");
        assert!(message.contains("glowworm: warning: ") && message.contains(name), "{message}");
        assert!(message.contains(says), "{message}");
        if name == "sky.hdr" {
            // The corner shows the map.
            let picture = image::open(folder.join("a.exr")).unwrap().to_rgb32f();
            let corner = Vec3::from_array(picture.get_pixel(0, 0).0);
            assert!(corner.distance(Vec3::new(0.5, 1.0, 0.25)) < 1e-3, "{corner}");
        }
    }
}

#[test]
fn pictures_of_many_formats_are_textures() {
    let texels = image::RgbImage::from_pixel(4, 4, image::Rgb([200, 100, 50]));
    for format in ["png", "webp", "tiff", "bmp", "tga"] {
        let folder =
            Folder::new().with("m.obj", TRIANGLE).with("m.mtl", format!("newmtl a\nmap_Kd t.{format}\n"));
        texels.save(folder.path().join(format!("t.{format}"))).unwrap();
        let scene = folder.load("m.obj").unwrap();
        let texture = &scene.textures[0];
        assert_eq!(texture.levels[0].2[..4], [200, 100, 50, 255], "{format}: {:?}", scene.warnings);
    }
    // DDS: one block of DXT1, all of the colour 31, 0, 0 of 5, 6 and 5 bits.
    let mut dds = vec![0u8; 128];
    dds[..4].copy_from_slice(b"DDS ");
    for (at, word) in [(4, 124u32), (8, 0x1007), (12, 4), (16, 4), (76, 32), (80, 4), (108, 0x1000)] {
        dds[at..at + 4].copy_from_slice(&word.to_le_bytes());
    }
    dds[84..88].copy_from_slice(b"DXT1");
    dds.extend([0x00, 0xf8, 0x00, 0xf8, 0, 0, 0, 0]);
    let folder =
        Folder::new().with("m.obj", TRIANGLE).with("m.mtl", "newmtl a\nmap_Kd t.dds\n").with("t.dds", dds);
    let scene = folder.load("m.obj").unwrap();
    assert_eq!(scene.textures[0].levels[0].2[..4], [255, 0, 0, 255], "{:?}", scene.warnings);
}

#[test]
fn textures_beyond_what_devices_hold_are_shrunk_and_named() {
    let folder = Folder::new().with("m.obj", TRIANGLE).with("m.mtl", "newmtl a\nmap_Kd t.png\n");
    image::RgbImage::from_pixel(20_000, 2, image::Rgb([9, 9, 9])).save(folder.path().join("t.png")).unwrap();
    let scene = folder.load("m.obj").unwrap();
    let (width, height, _) = scene.textures[0].levels[0];
    assert_eq!((width, height), (10_000, 1));
    let named = |warning: &String| warning.contains("t.png is 20000 x 2 texels, shrunk to 10000 x 1");
    assert!(scene.warnings.iter().any(named), "{:?}", scene.warnings);
}

/// A disk that is full from the first byte on stands for any.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_and_a_closed_pipe_end_the_program_quietly() {
    let page = |output: std::process::Stdio| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_glowworm"));
        let run =
            command.args(["info", "--options"]).stdout(output).stderr(std::process::Stdio::piped()).spawn();
        let output = run.unwrap().wait_with_output().unwrap();
        (output.status.code(), stderr(&output))
    };
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let (code, message) = page(full.into());
    assert_eq!((code, message.lines().count()), (Some(1), 1), "{message}");
    assert!(message.starts_with("glowworm: error: standard output: "), "{message}");
    // Whoever has read enough is no failure.
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    assert_eq!(page(writer.into()), (Some(0), String::new()));
}
