//! Invalid models give an error of one line with file and line, or a warning and a fallback.

use super::*;

#[test]
fn broken_objs_name_the_line() {
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (rest, parts) in [
        ("f 1 2 9", &["bad.obj:4", "vertex 9", "has 3"][..]),
        ("f 1 2 0", &["bad.obj:4", "vertex 0"]),
        ("f -4 -2 -1", &["bad.obj:4", "vertex -4"]),
        ("vt 0 0\nf 1/1 2/2 3/1", &["bad.obj:5", "texture coordinate 2", "has 1"]),
        ("vn 0 0 1\nf 1//1 2//1 3//7", &["bad.obj:5", "normal 7", "has 1"]),
        ("f 1 2 x", &["bad.obj:4", "\"x\""]),
        ("f 1/1/1/1 2 3", &["bad.obj:4", "1/1/1/1"]),
        ("f 1 2 99999999999999999999", &["bad.obj:4", "99999999999999999999"]),
        ("v nan 0 0\nf 1 2 4", &["bad.obj:4", "not a finite number"]),
        ("v 0 inf 0\nf 1 2 4", &["bad.obj:4", "not a finite number"]),
        ("v 0 0 1e30\nf 1 2 4", &["bad.obj:4", "scale the model down"]),
        ("v 0 1\nf 1 2 4", &["bad.obj:4", "3 numbers"]),
        ("vt nan 0\nf 1/1 2/1 3/1", &["bad.obj:4", "texture coordinate"]),
        ("f 1 1 1", &["zero area"]),
        ("v 1e-20 0 0\nv 0 1e-20 0\nf 1 4 5", &["bad.obj", "hardly any extent"]),
        ("l 1 2", &["no triangles"]),
        ("", &["no triangles"]),
    ] {
        expect_error("bad.obj", format!("{vertices}{rest}\n"), parts);
    }
    expect_error("bad.obj", "", &["no triangles"]);
    expect_error("bad.obj", "hello\nworld\n", &["no triangles"]);
    expect_error("bad.obj", [0x89, b'P', b'N', b'G', 0, 1, 2, 3, 0xff, 0xfe], &["binary file"]);
    expect_error("bad.obj", [0xff; 100], &["no triangles"]);
}

/// What no face uses, or many exporters write.
#[test]
fn harmless_mistakes_are_passed_over() {
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for rest in [
        "v nan 0\nvt\nvn 1\nf 1 2 3",
        "f 1//1 2//2 3//3",
        "f 1/7 2/8 3/9",
        "vn 0 0 1\nvn -nan(ind) 0 0\nf 1//1 2//2 3//1",
        "v 0 0 1 2 3\nf 1 2 3 # a comment",
        "vt 0.5\nf 1/1/ 2/1 3",
    ] {
        let scene = load_files(&[("m.obj", &format!("{vertices}{rest}\n"))]);
        check_consistency(&scene);
        let normals = &scene.meshes[0].normals;
        assert!(normals.len() == 3 && normals.iter().all(|normal| normal.distance(Vec3::Z) < 1e-6), "{rest}");
    }
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
    assert_eq!(material.base_colour, glam::Vec3::splat(0.5));
    let folder = Folder::new().with("m.obj", TRIANGLE).with("m.mtl", [0u8, 255, 10, 13, 7]);
    assert!(folder.load("m.obj").unwrap().warnings[0].contains("material a"));
}

#[test]
fn missing_and_truncated_textures_become_checkerboards() {
    let image =
        image::RgbImage::from_fn(64, 64, |x, y| image::Rgb([(x * 4) as u8, (y * 4) as u8, (x * y) as u8]));
    for extension in ["png", "jpg", "bmp", "tga"] {
        let name = format!("t.{extension}");
        let mtl = format!("newmtl a\nKd 1 1 1\nmap_Kd {name}\n");
        let folder = Folder::new().with("m.obj", TRIANGLE).with("m.mtl", &mtl);
        let file = folder.path().join(&name);
        let check = |state: &str, fallback: bool| {
            let scene = folder.load("m.obj").unwrap();
            let warned = scene.warnings.iter().any(|w| w.contains(&name) && w.contains("checkerboard"));
            assert_eq!(warned, fallback, "{state} {name}: {:?}", scene.warnings);
            let magenta = scene.textures[0].levels[0].2[..4] == [255, 0, 255, 255];
            assert_eq!(magenta, fallback, "{state} {name}");
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

#[test]
fn no_bytes_of_an_obj_panic() {
    let obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0 2\nvt .5 1\nvn 0 0 1\nusemtl a\nf 1/1/1 2/1/1 -1//1\nf 1 2 3 \\\n3\no x\n";
    let folder = Folder::new().with("m.mtl", "newmtl a\nKd 1 1 1\nKe 1 1 1\n");
    fuzz(&folder, "f.obj", obj);
}
