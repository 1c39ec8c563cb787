//! An OBJ and its MTL as they are shown.

use glam::{Vec2, Vec3};

use super::*;

/// Two squares that meet at a right angle along the edge from vertex 2 to 3.
const ROOF: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 0 -1\nv 1 1 -1\n";

/// The normals of the vertices at a place, each once.
fn normals_at(scene: &Scene, place: Vec3) -> Vec<Vec3> {
    let mesh = &scene.meshes[0];
    let mut normals: Vec<Vec3> = Vec::new();
    for triangle in &mesh.triangles {
        for vertex in
            triangle.map(|vertex| vertex as usize).into_iter().filter(|&v| mesh.positions[v] == place)
        {
            let normal = mesh.normals[vertex];
            if normals.iter().all(|known| known.distance(normal) > 1e-4) {
                normals.push(normal);
            }
        }
    }
    normals.sort_by(|a, b| a.z.total_cmp(&b.z));
    normals
}

#[test]
fn smoothing_groups_say_where_edges_are_smooth() {
    let (front, side) = (Vec3::Z, Vec3::X);
    let both = (front + side).normalize();
    for (faces, expected) in [
        ("s 1\nf 1 2 3 4\nf 2 5 6 3", &[both][..]),
        ("s 7\nf 1 2 3 4\ns 1\nf 2 5 6 3", &[side, front]),
        ("s off\nf 1 2 3 4\nf 2 5 6 3", &[side, front]),
        ("s 0\nf 1 2 3 4\ns 1\nf 2 5 6 3", &[side, front]),
        // Without a word a crease angle decides.
        ("f 1 2 3 4\nf 2 5 6 3", &[side, front]),
        // Normals of the file come first.
        ("vn 0 1 0\ns 1\nf 1//1 2//1 3//1 4//1\nf 2//1 5//1 6//1 3//1", &[Vec3::Y]),
    ] {
        let scene = load_files(&[("roof.obj", &format!("{ROOF}{faces}\n"))]);
        check_consistency(&scene);
        let normals = normals_at(&scene, Vec3::X);
        assert_eq!(normals.len(), expected.len(), "{faces}: {normals:?}");
        for (normal, expected) in normals.iter().zip(expected) {
            assert!(normal.distance(*expected) < 1e-4, "{faces}: {normals:?}");
        }
    }
    // A flat edge within the crease angle.
    let ramp = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 -.3\nv 2 1 -.3\n";
    for (said, count) in [("", 1), ("s off\n", 2), ("s 3\n", 1)] {
        let scene = load_files(&[("ramp.obj", &format!("{ramp}{said}f 1 2 3 4\nf 2 5 6 3\n"))]);
        assert_eq!(normals_at(&scene, Vec3::X).len(), count, "{said}");
    }
}

#[test]
fn vertices_have_colours() {
    let square = |colours: [&str; 4]| {
        let [a, b, c, d] = colours;
        format!("v 0 0 0 {a}\nv 1 0 0 {b}\nv 1 1 0 {c}\nv 0 1 0 {d}\nf 1 2 3 4\n")
    };
    for (colours, expected) in [
        (["1 0 0"; 4], Vec3::X),
        // sRGB: half of the light.
        (["0.7354 0.7354 0"; 4], Vec3::new(0.5, 0.5, 0.0)),
        (["1 0 0 1"; 4].map(|_| "1 1 0 0"), Vec3::X),
        (["-3 2 nan"; 4], Vec3::ONE),
        (["", "", "", ""], Vec3::splat(0.5)),
    ] {
        let scene = load_files(&[("square.obj", &square(colours))]);
        check_consistency(&scene);
        let point = glowworm::scene::SurfacePoint { triangle: 0, barycentrics: Vec2::splat(0.3) };
        let surface = scene.meshes[0].interpolate(point);
        let material = &scene.materials[scene.meshes[0].triangle_materials[0] as usize];
        let albedo = material.bsdf_at(&scene, surface.attributes).mean_albedo();
        assert!(albedo.distance(expected) < 5e-3, "{colours:?}: {albedo}");
    }
    // Where only some have one, the others are white.
    let scene = load_files(&[("square.obj", &square(["", "0 0 0", "", ""]))]);
    assert!(scene.meshes[0].colours.iter().filter(|colour| colour.x == 1.0).count() == 3);
}

#[test]
fn options_lay_maps_on_the_surface() {
    let folder = Folder::new().with("m.obj", TRIANGLE);
    // From left to right 0, 85, 170 and 255 of blue; the lower row has red.
    let texel = |x: u32, y: u32| image::Rgb([if y == 1 { 255 } else { 0 }, 0, (85 * x) as u8]);
    image::RgbImage::from_fn(4, 2, texel).save(folder.path().join("t t.png")).unwrap();
    let folder = [
        ("t t.png", Vec2::new(0.125, 0.25), [1.0, 0.0]),
        ("-s 2 1 1 t t.png # a comment", Vec2::new(0.4375, 0.25), [1.0, 1.0]),
        ("-o 0.5 0.5 t t.png", Vec2::new(0.375, 0.25), [0.0, 1.0]),
        ("-s 2 -o 0.25 t t.png", Vec2::new(0.3125, 0.75), [0.0, 1.0]),
        ("-clamp on t t.png", Vec2::new(1.9, 0.25), [1.0, 1.0]),
        ("-clamp off t t.png", Vec2::new(1.125, 0.25), [1.0, 0.0]),
        ("-mm 0 1 -blendu on -cc off -texres 4 -bm 1 -t 0 0 0 t t.png", Vec2::new(0.125, 0.75), [0.0, 0.0]),
    ]
    .into_iter()
    .fold(folder, |folder, (map, at, [red, blue])| {
        let folder = folder.with("m.mtl", format!("newmtl a\nmap_Kd {map}\n"));
        let scene = folder.load("m.obj").unwrap();
        let material = scene.materials.iter().find(|material| material.name == "a").unwrap();
        // Texture coordinates of an OBJ count from the bottom.
        let albedo = material.bsdf_at(&scene, Vec2::new(at.x, 1.0 - at.y)).mean_albedo();
        assert!(albedo.distance(Vec3::new(red, 0.0, blue)) < 0.02, "{map}: {albedo}");
        let told = scene.warnings.iter().any(|warning| warning.contains("-mm (range of a map)"));
        assert_eq!(told, map.contains("-mm"), "{:?}", scene.warnings);
        folder
    });
    let bad = folder.with("m.mtl", "newmtl a\nmap_Kd -o inf t t.png\n").load("m.obj").unwrap();
    assert!(bad.warnings.iter().any(|warning| warning.contains("m.mtl:2")), "{:?}", bad.warnings);
}

/// The text in an encoding, with its byte-order mark.
fn marked(text: &str, encoding: &str) -> Vec<u8> {
    let units = || "\u{feff}".encode_utf16().chain(text.encode_utf16());
    match encoding {
        "utf-8" => format!("\u{feff}{text}").into_bytes(),
        "utf-16le" => units().flat_map(u16::to_le_bytes).collect(),
        "utf-16be" => units().flat_map(u16::to_be_bytes).collect(),
        _ => text.chars().map(|c| u8::try_from(c).unwrap()).collect(),
    }
}

#[test]
fn text_is_read_in_any_encoding() {
    let obj = TRIANGLE.replace("usemtl a", "usemtl r\u{e9}d").replace("m.mtl", "m\u{e9}.mtl");
    for encoding in ["utf-8", "utf-16le", "utf-16be", "latin-1"] {
        // The first line counts, too.
        let folder = Folder::new()
            .with("m.obj", marked(&obj, encoding))
            .with("m\u{e9}.mtl", marked("newmtl r\u{e9}d\nKd 1 0 0\n", encoding));
        let scene = folder.load("m.obj").unwrap();
        let material = &scene.materials[scene.meshes[0].triangle_materials[0] as usize];
        assert_eq!((material.base_colour, &*material.name), (Vec3::X, "r\u{e9}d"), "{encoding}");
        if encoding == "latin-1" {
            continue;
        }
        let toml = "name = \"\u{e9}\"\n[[models]]\nname = \"m\"\npath = \"m.obj\"\n[[instances]]\nmodel = \"m\"\n\
                    [camera]\neye = [0, 0, 3]\ntarget = [0, 0, 0]\n";
        assert_eq!(folder.with("s.toml", marked(toml, encoding)).load("s.toml").unwrap().name, "\u{e9}");
    }
}

#[test]
fn names_have_blanks_and_comments() {
    let triangle = |library: &str, material: &str| {
        format!("mtllib {library}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl {material}\nf 1 2 3\n")
    };
    let materials = "newmtl red paint\nKd 1 0 0\nnewmtl No #25\nKd 0 1 0\nnewmtl last # one\nKd 0 0 1\n";
    for (library, material, expected) in [
        ("my lib.mtl", "red paint", Vec3::X),
        ("my lib.mtl # a comment", "red paint # another", Vec3::X),
        ("my lib.mtl", "No #25", Vec3::Y),
        ("plain.mtl other.mtl # two", "last", Vec3::Z),
        ("my\\ lib.mtl", "last", Vec3::Z),
        ("gone.mtl my\\ lib.mtl", "last", Vec3::Z),
        ("PLAIN.mtl", "last  # of all", Vec3::Z),
    ] {
        let folder = Folder::new().with("m.obj", triangle(library, material));
        let folder = folder.with("my lib.mtl", materials).with("plain.mtl", materials);
        let scene = folder.load("m.obj").unwrap();
        let shown = &scene.materials[scene.meshes[0].triangle_materials[0] as usize];
        assert_eq!(shown.base_colour, expected, "{library}, {material}: {:?}", scene.warnings);
    }
}

#[test]
fn what_is_no_face_is_named_once() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2\nl 2 3\np 1\ncurv 0 1 1 2\ncurv2 1 2\n";
    let scene = load_files(&[("lines.obj", obj)]);
    let told: Vec<_> = scene.warnings.iter().filter(|warning| warning.contains("not shown")).collect();
    assert_eq!(told.len(), 1);
    assert!(["lines.obj", "lines", "points", "curves"].iter().all(|word| told[0].contains(word)), "{told:?}");
}

#[test]
fn colours_count_by_the_map_of_opacity() {
    let image = |texels: &[[u8; 4]]| super::gltf_files::png(texels);
    let leaf = image(&[[0, 255, 0, 255], [0, 0, 0, 255], [0, 0, 0, 255], [0, 0, 0, 255]]);
    let folder = Folder::new()
        .with("colour.png", leaf)
        .with("opacity.png", image(&[[255; 4], [0, 0, 0, 255]]))
        .with("m.mtl", "newmtl leaf\nKd 1 1 1\nmap_Kd colour.png\nmap_d opacity.png\n")
        .with(
            "m.obj",
            "mtllib m.mtl\nusemtl leaf\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n",
        );
    let scene = folder.load("m.obj").unwrap();
    // The left half is there: green and black.
    let mean = scene.materials[0].mean_bsdf(&scene).base;
    assert!(mean.distance(Vec3::new(0.0, 0.5, 0.0)) < 0.01, "{mean}");
}
