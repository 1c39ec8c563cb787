//! Invalid scene files give an error of one line with file, line and key.

use super::*;

#[test]
fn unknown_scenes_are_named() {
    let error = load_scene("cornel-box", None).unwrap_err().to_string();
    assert!(error.contains("cornel-box") && error.contains("cornell-box") && error.contains("living-room"));
    let folder = Folder::new().with("scene.fbx", "{}");
    let error = folder.load("scene.fbx").unwrap_err().to_string();
    assert!(error.contains("scene.fbx") && error.contains(".toml"), "{error}");
    assert!(folder.load("missing.toml").unwrap_err().to_string().contains("missing.toml"));
    assert!(folder.load("missing.obj").unwrap_err().to_string().contains("missing.obj"));
    assert!(load_scene("", None).is_err() && load_scene(".", None).is_err());
}

const MODEL: &str = "[[models]]\nname = \"m\"\npath = \"m.obj\"\n";

#[test]
fn broken_scene_files_name_line_and_key() {
    for (text, parts) in [
        ("name = 3", &["bad.toml:1", "string"][..]),
        ("name = \"a\"\ncolour = 1", &["bad.toml:2", "colour", "expected"]),
        ("[camera\neye = 1", &["bad.toml:1"]),
        ("[camera]\neye = [0, 0, 1]\ntarget = [0, 0, 0]\nfov = 3", &["bad.toml:4", "fov", "vfov_deg"]),
        ("[camera]\neye = [0, 0, 1]", &["bad.toml:1", "target"]),
        ("[camera]\neye = [0, 0]\ntarget = [0, 0, 0]", &["bad.toml:2"]),
        ("[camera]\neye = [0, 0, 1]\ntarget = [0, 0, 1]", &["bad.toml:1", "camera", "eye and target"]),
        ("[camera]\neye = [0, 0, 1]\ntarget = [0, 5, 1]", &["bad.toml:1", "parallel"]),
        ("[camera]\neye = [0, 0, nan]\ntarget = [0, 5, 1]", &["bad.toml:1", "eye", "finite"]),
        (
            "\n[camera]\neye = [0, 0, 1]\ntarget = [0, 0, 0]\nnear = 5\nfar = 2",
            &["bad.toml:2", "near", "far"],
        ),
        ("[camera]\neye = [0, 0, 1]\ntarget = [0, 0, 0]\nnear = -1", &["bad.toml:1", "near"]),
        ("[camera]\neye = [0, 0, 1]\ntarget = [0, 0, 0]\nvfov_deg = 180", &["bad.toml:1", "vfov_deg"]),
        ("[camera]\neye = [0, 0, 1e19]\ntarget = [0, 5, 1]", &["bad.toml:1", "eye must lie within +-1e9"]),
        ("background = [0, -1, 0]", &["bad.toml:1", "background", "negative"]),
        ("[settings]\nvpls = 3\nvplz = 4", &["bad.toml:3", "vplz"]),
        ("[settings]\nvpls = \"many\"", &["bad.toml:2", "vpls = many: must be a whole number"]),
    ] {
        expect_error("bad.toml", text, parts);
    }
    expect_error("bad.toml", [b'a', 0xff], &["UTF-8"]);
}

#[test]
fn broken_models_name_themselves() {
    for (text, parts) in [
        ("[[instances]]\nmodel = \"x\"", &["bad.toml:1", "\"x\"", "known are none"][..]),
        ("[[models]]\nname = \"m\"", &["bad.toml:1", "exactly one"]),
        ("[[models]]\nname = \"m\"\npath = \"no.obj\"", &["bad.toml:1", "no.obj", "relative"]),
        ("[[models]]\nname = \"m\"\nbuiltin = \"teapot\"", &["bad.toml:1", "teapot", "cornell-box"]),
        ("[[models]]\nname = \"m\"\nprimitive = \"cone\"", &["bad.toml:3", "cone", "sphere"]),
        ("[[models]]\nname = \"m\"\nprimitive = \"box\"\nsize = [1, 0, 1]", &["bad.toml:1", "size"]),
        (
            "[[models]]\nname = \"m\"\nprimitive = \"box\"\nmaterial = { albedo = [2, 0, 0] }",
            &["albedo", "above 1"],
        ),
        (
            "[[models]]\nname = \"m\"\nprimitive = \"sphere\"\nsize = [1e19, 1, 1]",
            &["bad.toml:1", "size must lie within +-1e9"],
        ),
        ("[[models]]\nname = \"m\"\npath = \"m.obj\"\nsize = [1, 1, 1]", &["size", "is not allowed"]),
    ] {
        expect_error("bad.toml", text, parts);
    }
}

#[test]
fn broken_materials_name_themselves() {
    let model =
        "[[models]]\nname = \"m\"\nprimitive = \"quad\"\n[[instances]]\nmodel = \"m\"\n[[materials]]\n";
    for (keys, parts) in [
        ("name = \"chalk\"\nroughness = 0.5", &["s.toml:6", "material \"chalk\"", "no model"][..]),
        ("roughness = 0.5", &["s.toml:6", "name"]),
        ("name = \"m\"\nroughness = 1.5", &["material \"m\"", "roughness", "0 to 1"]),
        ("name = \"m\"\nbase_colour = [0, 2, 0]", &["base_colour", "above 1"]),
        ("name = \"m\"\nemission = [0, -2, 0]", &["emission", "negative"]),
        ("name = \"m\"\nnormal_scale = inf", &["normal_scale", "finite"]),
        ("name = \"m\"\n[[materials]]\nname = \"m\"", &["s.toml:8", "another entry"]),
        ("name = \"m\"\nshine = 1", &["s.toml:8", "shine"]),
    ] {
        expect_error("s.toml", format!("{model}{keys}\n"), parts);
    }
}

#[test]
fn broken_instances_name_themselves() {
    for (rest, parts) in [
        ("scale = 0", &["instance \"m\"", "scale"][..]),
        ("scale = [1, 0, 1]", &["instance \"m\"", "scale"]),
        ("scale = 1e25", &["instance \"m\"", "scale must lie within +-1e9"]),
        ("scale = 1e9\ntranslation = [9e8, 0, 0]", &["instance \"m\"", "+-1e9", "scale it down"]),
        ("translation = [1e12, 0, 0]", &["instance \"m\"", "translation must lie within +-1e9"]),
        ("scale = \"big\"", &["bad.toml:6", "a scale must be"]),
        ("rotation = [1, 2]", &["bad.toml:6", "a rotation must be"]),
        ("rotation = { axis = [0, 0, 0], degrees = 3 }", &["rotation.axis", "zero"]),
        ("translation = [inf, 0, 0]", &["translation", "finite"]),
        ("animation = {}", &["animation", "keyframes or a rotation"]),
        ("animation = { keyframes = [{ time = 1 }, { time = 1 }] }", &["keyframe times", "time 1"]),
        ("animation = { keyframes = [{ time = nan }] }", &["keyframe times"]),
        ("animation = { keyframes = [{ time = -1e300 }] }", &["keyframe times", "1e9"]),
        ("animation = { rotation = { axis = [0, 0, 0], degrees_per_second = 1 } }", &["axis", "zero"]),
        ("animation = { spin = 1 }", &["bad.toml:6", "spin"]),
        ("name = \"a\"\n[[instances]]\nname = \"a\"\nmodel = \"m\"", &["bad.toml:7", "another instance"]),
    ] {
        expect_error(
            "bad.toml",
            format!("{MODEL}\n[[instances]]\nmodel = \"m\"\n{rest}").replace("\n\n", "\n"),
            parts,
        );
    }
    let glow = "[[models]]\nname = \"g\"\nprimitive = \"box\"\nmaterial = { emission = [1, 1, 1] }\n";
    let mirrored = format!("{glow}[[instances]]\nmodel = \"g\"\nscale = [1, -1, 1]");
    expect_error("bad.toml", mirrored, &["bad.toml:5", "mirrored"]);
    expect_error("bad.toml", format!("{MODEL}{MODEL}"), &["bad.toml:4", "another model"]);
}

#[test]
fn broken_lights_name_themselves() {
    let quad = "polygon = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]";
    for (rest, parts) in [
        (
            "type = \"point\"\nposition = [0, 0, 0]\nintensity = [1, -1, 1]",
            &["light \"l\"", "intensity", "negative"][..],
        ),
        ("type = \"point\"\nposition = [0, 0, 0]\nintensity = [1, nan, 1]", &["intensity", "finite"]),
        ("type = \"point\"\nposition = [0, 0, 0]", &["the key intensity is missing"]),
        ("type = \"point\"\nintensity = [1, 1, 1]", &["the key position is missing"]),
        ("type = \"point\"\nposition = [0, 0, 0]\nintensity = 3", &["bad.toml:5"]),
        ("type = \"lamp\"", &["bad.toml:3", "lamp", "directional"]),
        // The error is the unknown type, not the unknown keys.
        (
            "radius = 1\nheight = 2\ntype = \"tube\"",
            &["bad.toml:5", "light \"l\"", "tube", "point", "spot", "area"],
        ),
        ("type = \"sphere\"\nradius = 1", &["bad.toml:3", "unknown type", "sphere", "directional"]),
        ("type = \"point\"\nheight = 1", &["bad.toml:4", "height"]),
        (
            "type = \"point\"\nposition = [0, 0, 0]\nintensity = [1, 1, 1]\nradius = -1",
            &["light \"l\"", "radius", "from 0", "-1"],
        ),
        (
            "type = \"spot\"\nposition = [0, 0, 0]\ndirection = [0, 1, 0]\nouter_deg = 9\nintensity = [1, 1, 1]\nradius = nan",
            &["light \"l\"", "radius", "NaN"],
        ),
        (
            "type = \"point\"\nposition = [0, 0, 0]\nintensity = [1, 1, 1]\nangle_deg = 1",
            &["angle_deg", "is not allowed"],
        ),
        (
            "type = \"directional\"\ndirection = [0, 1, 0]\nirradiance = [1, 1, 1]\nradius = 1",
            &["radius", "is not allowed"],
        ),
        (
            "type = \"directional\"\ndirection = [0, 1, 0]\nirradiance = [1, 1, 1]\nangle_deg = 90.1",
            &["light \"l\"", "angle_deg", "90.1"],
        ),
        ("intensity = [1, 1, 1]", &["bad.toml:1", "type"]),
        (
            "type = \"point\"\nposition = [0, 0, 0]\nintensity = [1, 1, 1]\nouter_deg = 3",
            &["outer_deg", "is not allowed"],
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
        ("type = \"directional\"\nirradiance = [1, 1, 1]", &["the key direction is missing"]),
        ("type = \"directional\"\ndirection = [0, 0, 0]\nirradiance = [1, 1, 1]", &["direction", "zero"]),
        ("type = \"area\"\nradiance = [1, 1, 1]", &["polygon", "instance"]),
        ("type = \"area\"\nradiance = [1, 1, 1]\ninstance = \"x\"", &["unknown instance", "\"x\""]),
        (
            "type = \"area\"\nradiance = [1, 1, 1]\npolygon = [[0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]]",
            &["polygon", "convex"],
        ),
        (
            "type = \"area\"\nradiance = [1, 1, 1]\npolygon = [[0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1, 0]]",
            &["polygon", "convex"],
        ),
    ] {
        expect_error("bad.toml", format!("[[lights]]\nname = \"l\"\n{rest}"), parts);
    }
    expect_error(
        "bad.toml",
        format!("[[lights]]\ntype = \"area\"\n{quad}"),
        &["the key radiance is missing"],
    );
}

#[test]
fn no_bytes_of_a_scene_file_panic() {
    let toml = "[[models]]\nname='m'\npath='m.obj'\n[[instances]]\nmodel='m'\nscale=[1,2,1]\nrotation={axis=[0,1,0],degrees=9}\n\
        animation={keyframes=[{time=0},{time=1}]}\n[camera]\neye=[0,0,9]\ntarget=[0,0,0]\n[[lights]]\ntype='spot'\n\
        position=[0,1,0]\ndirection=[0,1,0]\nouter_deg=20\nintensity=[1,1,1]\n[[lights]]\ntype='area'\nradiance=[1,1,1]\n\
        polygon=[[0,0,0],[1,0,0],[1,1,0],[0,1,0]]\n[settings]\nvpls=2\n";
    fuzz(&Folder::new().with("m.obj", TRIANGLE), "f.toml", toml);
}
