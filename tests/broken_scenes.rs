//! What is wrong with a scene ends in one line that names the place, or in a warning and a stand-in;
//! never in a panic, whatever the bytes.

use std::path::Path;

use glowworm::scene::{Scene, SceneError, load_scene};

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn with(self, name: &str, content: impl AsRef<[u8]>) -> Self {
        std::fs::write(self.0.path().join(name), content).unwrap();
        self
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn load(&self, name: &str) -> Result<Scene, SceneError> {
        load_scene(self.path().join(name).to_str().unwrap(), Some(self.path()))
    }
}

/// Loads `name` from a folder that holds `content`; the error must be one line with all of `parts`.
fn expect_error(name: &str, content: impl AsRef<[u8]>, parts: &[&str]) {
    let folder = Folder::new().with(name, content).with("m.obj", TRIANGLE);
    let error = folder
        .load(name)
        .map(|_| ())
        .expect_err(&format!("an error about {parts:?}"))
        .to_string();
    assert!(!error.contains('\n') && error.contains(name), "{error}");
    for part in parts {
        assert!(error.contains(part), "\"{error}\" should say \"{part}\"");
    }
}

const TRIANGLE: &str =
    "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n";

#[test]
fn unknown_scenes_are_named() {
    let error = load_scene("cornel-box", None).unwrap_err().to_string();
    assert!(
        error.contains("cornel-box")
            && error.contains("cornell-box")
            && error.contains("living-room")
    );
    let folder = Folder::new().with("scene.gltf", "{}");
    let error = folder.load("scene.gltf").unwrap_err().to_string();
    assert!(
        error.contains("scene.gltf") && error.contains(".toml"),
        "{error}"
    );
    assert!(
        folder
            .load("missing.toml")
            .unwrap_err()
            .to_string()
            .contains("missing.toml")
    );
    assert!(
        folder
            .load("missing.obj")
            .unwrap_err()
            .to_string()
            .contains("missing.obj")
    );
    assert!(load_scene("", None).is_err() && load_scene(".", None).is_err());
}

#[test]
fn broken_objs_name_the_line() {
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (rest, parts) in [
        ("f 1 2 9", &["bad.obj:4", "vertex 9", "has 3"][..]),
        ("f 1 2 0", &["bad.obj:4", "vertex 0"]),
        ("f -4 -2 -1", &["bad.obj:4", "vertex -4"]),
        (
            "vt 0 0\nf 1/1 2/2 3/1",
            &["bad.obj:5", "texture coordinate 2", "has 1"],
        ),
        (
            "vn 0 0 1\nf 1//1 2//1 3//7",
            &["bad.obj:5", "normal 7", "has 1"],
        ),
        ("f 1 2 x", &["bad.obj:4", "\"x\""]),
        ("f 1/1/1/1 2 3", &["bad.obj:4", "1/1/1/1"]),
        (
            "f 1 2 99999999999999999999",
            &["bad.obj:4", "99999999999999999999"],
        ),
        ("v nan 0 0\nf 1 2 4", &["bad.obj:4", "not a finite number"]),
        ("v 0 inf 0\nf 1 2 4", &["bad.obj:4", "not a finite number"]),
        (
            "v 0 0 1e30\nf 1 2 4",
            &["bad.obj:4", "scale the model down"],
        ),
        ("v 0 1\nf 1 2 4", &["bad.obj:4", "3 numbers"]),
        (
            "vt nan 0\nf 1/1 2/1 3/1",
            &["bad.obj:4", "texture coordinate"],
        ),
        ("f 1 1 1", &["zero area"]),
        ("l 1 2", &["no triangles"]),
        ("", &["no triangles"]),
    ] {
        expect_error("bad.obj", format!("{vertices}{rest}\n"), parts);
    }
    expect_error("bad.obj", "", &["no triangles"]);
    expect_error("bad.obj", "hello\nworld\n", &["no triangles"]);
    expect_error(
        "bad.obj",
        [0x89, b'P', b'N', b'G', 0, 1, 2, 3, 0xff, 0xfe],
        &["binary file"],
    );
    expect_error("bad.obj", [0xff; 100], &["no triangles"]);
}

#[test]
fn missing_libraries_and_materials_become_grey() {
    let scene = Folder::new().with("m.obj", TRIANGLE).load("m.obj").unwrap();
    assert!(
        scene.warnings[0].contains("m.obj") && scene.warnings[0].contains("m.mtl"),
        "{:?}",
        scene.warnings
    );
    let material = &scene.materials[scene.meshes[0].triangle_materials[0] as usize];
    assert_eq!(material.albedo, glam::Vec3::splat(0.5));
    let folder = Folder::new()
        .with("m.obj", TRIANGLE)
        .with("m.mtl", [0u8, 255, 10, 13, 7]);
    assert!(folder.load("m.obj").unwrap().warnings[0].contains("material a"));
}

#[test]
fn missing_and_truncated_textures_become_checkerboards() {
    let image = image::RgbImage::from_fn(64, 64, |x, y| {
        image::Rgb([(x * 4) as u8, (y * 4) as u8, (x * y) as u8])
    });
    for extension in ["png", "jpg", "bmp", "tga"] {
        let name = format!("t.{extension}");
        let mtl = format!("newmtl a\nKd 1 1 1\nmap_Kd {name}\n");
        let folder = Folder::new().with("m.obj", TRIANGLE).with("m.mtl", &mtl);
        let file = folder.path().join(&name);
        let check = |state: &str, stand_in: bool| {
            let scene = folder.load("m.obj").unwrap();
            let warned = scene
                .warnings
                .iter()
                .any(|w| w.contains(&name) && w.contains("checkerboard"));
            assert_eq!(warned, stand_in, "{state} {name}: {:?}", scene.warnings);
            let magenta = scene.textures[0].levels[0].2[..4] == [255, 0, 255, 255];
            assert_eq!(magenta, stand_in, "{state} {name}");
        };
        check("missing", true);
        image.save(&file).unwrap();
        check("whole", false);
        let bytes = std::fs::read(&file).unwrap();
        for share in [1, 3, 5, 9] {
            std::fs::write(&file, &bytes[..bytes.len() * share / 10]).unwrap();
            check("truncated", true);
        }
        std::fs::write(&file, "").unwrap();
        check("empty", true);
    }
}

const MODEL: &str = "[[models]]\nname = \"m\"\npath = \"m.obj\"\n";

#[test]
fn broken_scene_files_name_line_and_key() {
    for (text, parts) in [
        ("name = 3", &["bad.toml:1", "string"][..]),
        (
            "name = \"a\"\ncolour = 1",
            &["bad.toml:2", "colour", "expected"],
        ),
        ("[camera\neye = 1", &["bad.toml:1"]),
        (
            "[camera]\neye = [0, 0, 1]\ntarget = [0, 0, 0]\nfov = 3",
            &["bad.toml:4", "fov", "vfov_deg"],
        ),
        ("[camera]\neye = [0, 0, 1]", &["bad.toml:1", "target"]),
        (
            "[camera]\neye = [0, 0]\ntarget = [0, 0, 0]",
            &["bad.toml:2"],
        ),
        (
            "[camera]\neye = [0, 0, 1]\ntarget = [0, 0, 1]",
            &["bad.toml:1", "camera", "eye and target"],
        ),
        (
            "[camera]\neye = [0, 0, 1]\ntarget = [0, 5, 1]",
            &["bad.toml:1", "parallel"],
        ),
        (
            "[camera]\neye = [0, 0, nan]\ntarget = [0, 5, 1]",
            &["bad.toml:1", "eye", "finite"],
        ),
        (
            "\n[camera]\neye = [0, 0, 1]\ntarget = [0, 0, 0]\nnear = 5\nfar = 2",
            &["bad.toml:2", "near", "far"],
        ),
        (
            "[camera]\neye = [0, 0, 1]\ntarget = [0, 0, 0]\nnear = -1",
            &["bad.toml:1", "near"],
        ),
        (
            "[camera]\neye = [0, 0, 1]\ntarget = [0, 0, 0]\nvfov_deg = 180",
            &["bad.toml:1", "vfov_deg"],
        ),
        (
            "background = [0, -1, 0]",
            &["bad.toml:1", "background", "negative"],
        ),
        ("[settings]\nvpls = 3\nvplz = 4", &["bad.toml:3", "vplz"]),
        ("[settings]\nvpls = \"many\"", &["bad.toml:2", "u32"]),
        (
            "[[instances]]\nmodel = \"x\"",
            &["bad.toml:1", "\"x\"", "there are: none"],
        ),
        ("[[models]]\nname = \"m\"", &["bad.toml:1", "exactly one"]),
        (
            "[[models]]\nname = \"m\"\npath = \"no.obj\"",
            &["bad.toml:1", "no.obj", "relative"],
        ),
        (
            "[[models]]\nname = \"m\"\nbuiltin = \"teapot\"",
            &["bad.toml:1", "teapot", "cornell-box"],
        ),
        (
            "[[models]]\nname = \"m\"\nprimitive = \"cone\"",
            &["bad.toml:3", "cone", "sphere"],
        ),
        (
            "[[models]]\nname = \"m\"\nprimitive = \"box\"\nsize = [1, 0, 1]",
            &["bad.toml:1", "size"],
        ),
        (
            "[[models]]\nname = \"m\"\nprimitive = \"box\"\nmaterial = { albedo = [2, 0, 0] }",
            &["albedo", "above 1"],
        ),
        (
            "[[models]]\nname = \"m\"\npath = \"m.obj\"\nsize = [1, 1, 1]",
            &["size", "does not belong"],
        ),
    ] {
        expect_error("bad.toml", text, parts);
    }
    expect_error("bad.toml", [b'a', 0xff], &["UTF-8"]);
}

#[test]
fn broken_instances_name_themselves() {
    for (rest, parts) in [
        ("scale = 0", &["instance \"m\"", "scale"][..]),
        ("scale = [1, 0, 1]", &["instance \"m\"", "scale"]),
        ("scale = \"big\"", &["bad.toml:6", "a scale must be"]),
        ("rotation = [1, 2]", &["bad.toml:6", "a rotation must be"]),
        (
            "rotation = { axis = [0, 0, 0], degrees = 3 }",
            &["rotation.axis", "zero"],
        ),
        ("translation = [inf, 0, 0]", &["translation", "finite"]),
        ("animation = {}", &["animation", "keyframes or a rotation"]),
        (
            "animation = { keyframes = [{ time = 1 }, { time = 1 }] }",
            &["keyframe times", "time 1"],
        ),
        (
            "animation = { keyframes = [{ time = nan }] }",
            &["keyframe times"],
        ),
        (
            "animation = { rotation = { axis = [0, 0, 0], degrees_per_second = 1 } }",
            &["axis", "zero"],
        ),
        ("animation = { spin = 1 }", &["bad.toml:6", "spin"]),
        (
            "name = \"a\"\n[[instances]]\nname = \"a\"\nmodel = \"m\"",
            &["bad.toml:7", "another instance"],
        ),
    ] {
        expect_error(
            "bad.toml",
            format!("{MODEL}\n[[instances]]\nmodel = \"m\"\n{rest}").replace("\n\n", "\n"),
            parts,
        );
    }
    expect_error(
        "bad.toml",
        format!("{MODEL}{MODEL}"),
        &["bad.toml:4", "another model"],
    );
}

#[test]
fn broken_lights_name_themselves() {
    let quad = "polygon = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]";
    for (rest, parts) in [
        (
            "type = \"point\"\nposition = [0, 0, 0]\nintensity = [1, -1, 1]",
            &["light \"l\"", "intensity", "negative"][..],
        ),
        (
            "type = \"point\"\nposition = [0, 0, 0]\nintensity = [1, nan, 1]",
            &["intensity", "finite"],
        ),
        (
            "type = \"point\"\nposition = [0, 0, 0]",
            &["needs the key intensity"],
        ),
        (
            "type = \"point\"\nintensity = [1, 1, 1]",
            &["needs the key position"],
        ),
        (
            "type = \"point\"\nposition = [0, 0, 0]\nintensity = 3",
            &["bad.toml:5"],
        ),
        ("type = \"lamp\"", &["bad.toml:3", "lamp", "directional"]),
        ("intensity = [1, 1, 1]", &["bad.toml:1", "type"]),
        (
            "type = \"point\"\nposition = [0, 0, 0]\nintensity = [1, 1, 1]\nouter_deg = 3",
            &["outer_deg", "does not belong"],
        ),
        (
            "type = \"spot\"\nposition = [0, 0, 0]\ndirection = [0, 0, 0]\nouter_deg = 9\nintensity = [1, 1, 1]",
            &["direction", "zero"],
        ),
        (
            "type = \"spot\"\nposition = [0, 0, 0]\ndirection = [0, 1, 0]\nouter_deg = 9\ninner_deg = 9\nintensity = [1, 1, 1]",
            &["inner_deg < outer_deg"],
        ),
        (
            "type = \"spot\"\nposition = [0, 0, 0]\ndirection = [0, 1, 0]\nouter_deg = 180\nintensity = [1, 1, 1]",
            &["outer_deg"],
        ),
        (
            "type = \"directional\"\nirradiance = [1, 1, 1]",
            &["needs the key direction"],
        ),
        (
            "type = \"directional\"\ndirection = [0, 0, 0]\nirradiance = [1, 1, 1]",
            &["direction", "zero"],
        ),
        (
            "type = \"area\"\nradiance = [1, 1, 1]",
            &["polygon", "instance"],
        ),
        (
            "type = \"area\"\nradiance = [1, 1, 1]\ninstance = \"x\"",
            &["no instance", "\"x\""],
        ),
        (
            "type = \"area\"\nradiance = [1, 1, 1]\npolygon = [[0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]]",
            &["polygon", "convex"],
        ),
        (
            "type = \"area\"\nradiance = [1, 1, 1]\npolygon = [[0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1, 0]]",
            &["polygon", "convex"],
        ),
    ] {
        expect_error(
            "bad.toml",
            format!("[[lights]]\nname = \"l\"\n{rest}"),
            parts,
        );
    }
    expect_error(
        "bad.toml",
        format!("[[lights]]\ntype = \"area\"\n{quad}"),
        &["needs the key radiance"],
    );
}

#[test]
fn no_bytes_of_an_obj_panic() {
    let obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0 2\nvt .5 1\nvn 0 0 1\nusemtl a\nf 1/1/1 2/1/1 -1//1\nf 1 2 3 \\\n3\no x\n";
    let folder = Folder::new().with("m.mtl", "newmtl a\nKd 1 1 1\nKe 1 1 1\n");
    fuzz(&folder, "f.obj", obj);
}

#[test]
fn no_bytes_of_a_scene_file_panic() {
    let toml = "[[models]]\nname='m'\npath='m.obj'\n[[instances]]\nmodel='m'\nscale=[1,2,1]\nrotation={axis=[0,1,0],degrees=9}\n\
        animation={keyframes=[{time=0},{time=1}]}\n[camera]\neye=[0,0,9]\ntarget=[0,0,0]\n[[lights]]\ntype='spot'\n\
        position=[0,1,0]\ndirection=[0,1,0]\nouter_deg=20\nintensity=[1,1,1]\n[[lights]]\ntype='area'\nradiance=[1,1,1]\n\
        polygon=[[0,0,0],[1,0,0],[1,1,0],[0,1,0]]\n[settings]\nvpls=2\n";
    fuzz(&Folder::new().with("m.obj", TRIANGLE), "f.toml", toml);
}

/// Cuts the file off at every byte and changes every byte; a panic fails the test.
fn fuzz(folder: &Folder, name: &str, text: &str) {
    let file = folder.path().join(name);
    let mut loaded = 0;
    let mut attempt = |bytes: &[u8]| {
        std::fs::write(&file, bytes).unwrap();
        match folder.load(name) {
            Ok(scene) => {
                loaded += 1;
                let pose = scene.pose(0.25);
                scene.bounds(&pose);
            }
            Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
        }
    };
    attempt(text.as_bytes());
    for i in 0..text.len() {
        attempt(&text.as_bytes()[..i]);
        for byte in [
            0, b'\n', b' ', b'-', b'9', b'/', b'"', b'\\', b'#', b'e', 0xff,
        ] {
            let mut changed = text.as_bytes().to_vec();
            changed[i] = byte;
            attempt(&changed);
        }
    }
    assert!(loaded > 0);
}
