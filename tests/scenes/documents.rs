//! Opening a scene for editing, saving and loading it gives the same scene.

use std::sync::Arc;

use glowworm::formats::{
    AnimationEntry, EnvironmentEntry, KeyframeEntry, LightEntry, MaterialEdit, SceneDocument, scene_of_text,
};

use super::*;

#[test]
fn a_document_makes_the_scene_that_it_was_opened_from() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/scene-files/");
    let files = ["all-kinds.toml", "wedge.obj"].map(|file| format!("{folder}{file}"));
    for name in ["playroom", "cornell-box", &files[0], &files[1]] {
        let loaded = load_scene(name, None).unwrap();
        let (document, opened, _) = SceneDocument::open(name, None).unwrap();
        let again = scene_of_text(&document.text(), None).unwrap();
        for time in [0.0, 0.37, 12.5] {
            assert_eq!(opened.pose(time), loaded.pose(time), "{name}");
            assert_eq!(again.pose(time), loaded.pose(time), "{name}");
        }
        assert_eq!(again.settings, loaded.settings, "{name}");
        assert_eq!(again.triangle_count(), loaded.triangle_count(), "{name}");
    }
}

#[test]
fn a_camera_and_an_edit_are_saved_to_the_bit() {
    let (mut document, scene, _) = SceneDocument::open("playroom", None).unwrap();
    let mut camera = scene.camera;
    camera.eye += Vec3::new(0.1, 1.0 / 3.0, -0.7);
    camera.vertical_fov = 0.987_654_3;
    document.set_camera(&camera);
    let moved = document.instance_mut(3).unwrap();
    moved.translation = Some([1.0 / 3.0, -0.1, 0.7]);
    let placement = document.placement(document.instances().nth(3).unwrap()).unwrap();
    let again = scene_of_text(&document.text(), None).unwrap();
    assert_eq!(again.camera.eye, camera.eye);
    assert!((again.camera.vertical_fov - camera.vertical_fov).abs() <= f32::EPSILON);
    assert_eq!(again.instances[3].transform, placement.transform);
}

/// A folder of a model and a map, which may be deleted.
fn model_and_map() -> (Folder, [PathBuf; 2]) {
    let folder = Folder::new();
    for name in ["wedge.obj", "wedge.mtl"] {
        let original = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/scene-files/");
        std::fs::copy(format!("{original}{name}"), folder.path().join(name)).unwrap();
    }
    let files = ["wedge.obj", "sky.exr"].map(|name| folder.path().join(name));
    image::Rgb32FImage::from_pixel(4, 2, image::Rgb([0.5, 0.25, 1.0])).save(&files[1]).unwrap();
    (folder, files)
}

/// Every key of an edit, for a material.
fn edit(scene: &Scene) -> MaterialEdit {
    MaterialEdit {
        name: scene.materials[0].name.clone(),
        base_colour: Some([0.1, 0.2, 1.0 / 3.0]),
        metallic: Some(0.3),
        roughness: Some(0.7),
        emission: Some([2.0, 1.0, 0.5]),
        opacity: Some(0.9),
        transmission: Some(0.0),
        normal_scale: Some(-0.5),
    }
}

#[test]
fn edited_materials_and_environment_are_saved_and_loaded_again() {
    let (folder, [model, map]) = model_and_map();
    let (mut document, file, _) = SceneDocument::open(model.to_str().unwrap(), None).unwrap();
    let edit = edit(&file);
    document.set_material(edit.clone()).unwrap();
    let strength = Some(2.0);
    let rotation_deg = Some(30.0);
    let sky = EnvironmentEntry { map: Some(map), strength, rotation_deg, ..EnvironmentEntry::default() };
    document.set_environment(Some(sky)).unwrap();
    let saved = folder.path().join("saved.toml");
    std::fs::write(&saved, document.text()).unwrap();

    let (again, scene, _) = SceneDocument::open(saved.to_str().unwrap(), None).unwrap();
    assert_eq!(again.material_edit(&edit.name), Some(&edit));
    let mut edited = file.materials[0].clone();
    edit.apply(&mut edited);
    assert_ne!(edited, file.materials[0]);
    assert_eq!(scene.materials[0], edited);
    // An edit has no keys but those that differ.
    assert_eq!(
        MaterialEdit::between(&file.materials[0], &edited),
        MaterialEdit { transmission: None, ..edit.clone() }
    );
    let environment = scene.environment.as_ref().unwrap();
    assert_eq!((environment.radiance, environment.rotation), (Vec3::splat(2.0), 30f32.to_radians()));
    assert!(environment.map.is_some());
    // The material that now emits is a light, as in a scene that was made so.
    assert_eq!(scene.lights.len(), file.lights.len() + 1);
    // Taken back, nothing of it is left.
    let mut reset = again;
    reset.set_material(MaterialEdit { name: edit.name.clone(), ..MaterialEdit::default() }).unwrap();
    assert!(!reset.text().contains("[[materials]]"));
}

#[test]
fn an_edited_scene_is_built_without_reading_files_again() {
    let (_folder, [model, map]) = model_and_map();
    let (mut document, opened, mut read) = SceneDocument::open(model.to_str().unwrap(), None).unwrap();
    std::fs::remove_file(model).unwrap();
    document.set_material(edit(&opened)).unwrap();
    let edited = document.build(None, &mut read).unwrap();
    assert!(Arc::ptr_eq(&edited.meshes[0], &opened.meshes[0]));
    assert_eq!(edited.materials[0].metallic, 0.3);
    assert!(edited.same_geometry_and_bindings(&opened));
    assert_eq!(read.materials(), opened.materials);

    // A map is read once, and kept while its numbers change.
    let at = |strength| EnvironmentEntry {
        map: Some(map.clone()),
        strength: Some(strength),
        ..EnvironmentEntry::default()
    };
    document.set_environment(Some(at(1.0))).unwrap();
    let first = document.build(None, &mut read).unwrap().environment.unwrap();
    std::fs::remove_file(&map).unwrap();
    document.set_environment(Some(at(3.0))).unwrap();
    let second = document.build(None, &mut read).unwrap().environment.unwrap();
    assert!(Arc::ptr_eq(&first.map.unwrap(), &second.map.unwrap()));
    assert_eq!(second.radiance, Vec3::splat(3.0));
}

#[test]
fn a_thin_surface_that_is_none_any_more_is_built_otherwise() {
    let scene = |transmission: f32| {
        let mut scene = load_scene("cornell-box", None).unwrap();
        scene.materials[0].transmission = transmission;
        scene
    };
    assert!(scene(0.4).same_geometry_and_bindings(&scene(0.5)));
    assert!(!scene(0.0).same_geometry_and_bindings(&scene(0.5)));
}

/// A scene file with comments, an odd order and odd formatting.
const COMMENTED: &str = r#"# My first scene.
[[lights]]
type = "point"      # hangs above the ball
name = "bulb"
intensity = [ 20, 20.0,
              20 ]
position = [0, 3, 0]

[camera] # before the models, since it matters most
target = [0, 0, 0]
eye = [0.5, 1, 4]

# A ball. Its file lies beside this one.
[[models]]
name = "wedge"
path = "wedge.obj"

[settings]
bounces = 3   # enough
[settings.vpls]
vpls = 64     # few

[[lights]]
# The sun.
direction = [0, -1, 0.25]
irradiance = [1, 1, 0.9]
type = "directional"

[[instances]]
model = "wedge"
rotation = { axis = [0, 1, 0], degrees = 30 }
# The end.
"#;

#[test]
fn comments_and_order_survive_an_edit() {
    let (folder, _) = model_and_map();
    let file = folder.path().join("mine.toml");
    std::fs::write(&file, COMMENTED).unwrap();
    let open = |file: &Path| SceneDocument::open(file.to_str().unwrap(), None).unwrap().0;
    let mut document = open(&file);
    assert_eq!(document.text_to_save(&file), COMMENTED);

    // One light: a value that is there, and one that is not.
    document.light_mut(0).unwrap().intensity = Some([20.0, 10.0, 0.1]);
    document.light_mut(1).unwrap().angle_deg = Some(0.3);
    let given = "intensity = [ 20, 20.0,\n              20 ]";
    let expected = COMMENTED
        .replace(given, "intensity = [20.0, 10.0, 0.1]")
        .replace("type = \"directional\"\n", "type = \"directional\"\nangle_deg = 0.3\n");
    assert_eq!(document.text_to_save(&file), expected);
    assert_eq!(scene_of_text(&document.text(), None).unwrap().lights.len(), 2);

    // An entry is added and one removed, with its comments; the others keep theirs, and settings their tables.
    document.add_light(LightEntry {
        position: Some([1.0; 3]),
        intensity: Some([1.0; 3]),
        ..LightEntry::default()
    });
    document.remove_light(0);
    let settings = "bounces = 3\nvpls = 32\nseed = 7\n".parse().unwrap();
    document.set_settings(settings);
    let saved = document.text_to_save(&file);
    for kept in ["# The sun.", "bounces = 3   # enough", "vpls = 32     # few", "# The end."] {
        assert!(saved.contains(kept), "{kept} is lost:\n{saved}");
    }
    let sun = saved.find("# The sun.").unwrap();
    assert!(saved[sun..].contains("angle_deg = 0.3"), "{saved}");
    assert!(!saved.contains("bulb") && saved.contains("path = \"wedge.obj\""), "{saved}");
    std::fs::write(&file, &saved).unwrap();
    let again = open(&file);
    assert!(again.lights().eq(document.lights()) && again.instances().eq(document.instances()), "{saved}");
    let scene = folder.load("mine.toml").unwrap();
    assert_eq!(scene.settings.len(), 3, "{:?}", scene.settings);

    // In another folder its paths must be absolute.
    let elsewhere = tempfile::tempdir().unwrap();
    let moved = elsewhere.path().join("mine.toml");
    std::fs::write(&moved, document.text_to_save(&moved)).unwrap();
    assert!(load_scene(moved.to_str().unwrap(), None).is_ok());
}

/// Keys of a light with comments, between brackets.
const KEYED: &str = r#"[[lights]]
type = "point"
position = [0, 3, 0]
intensity = [20, 20, 20]
[lights.animation]
keyframes = [
    { time = 0 },                           # at rest
    { time = 2, translation = [1, 0, 0] },  # to the right
    { time = 4 },
]
repeat = true  # for ever
[[models]]
name = "wedge"
path = "wedge.obj"
[[instances]]
model = "wedge"  # stands still
"#;

#[test]
fn keyframes_are_edited_line_by_line() {
    let (folder, _) = model_and_map();
    let file = folder.path().join("mine.toml");
    std::fs::write(&file, KEYED).unwrap();
    let open = || SceneDocument::open(file.to_str().unwrap(), None).unwrap().0;
    let key = |time: f64, x: f32| {
        let translation = (x != 0.0).then_some([x, 0.0, 0.0]);
        KeyframeEntry { time, translation, rotation: None }
    };
    let saved = |edit: &dyn Fn(&mut Vec<KeyframeEntry>)| {
        let mut document = open();
        edit(&mut document.light_mut(0).unwrap().animation.as_mut().unwrap().keyframes);
        document.text_to_save(&file)
    };
    assert_eq!(saved(&|_| {}), KEYED);
    // One moved in time, one added between, one at the end, one deleted.
    assert_eq!(saved(&|keys| keys[1].time = 2.5), KEYED.replace("time = 2,", "time = 2.5,"));
    let between = "# at rest\n    { time = 1.0, translation = [0.5, 0.0, 0.0] },\n";
    assert_eq!(saved(&|keys| keys.insert(1, key(1.0, 0.5))), KEYED.replace("# at rest\n", between));
    let last = "    { time = 4 },\n    { time = 6.0 },\n";
    assert_eq!(saved(&|keys| keys.push(key(6.0, 0.0))), KEYED.replace("    { time = 4 },\n", last));
    let line = "    { time = 2, translation = [1, 0, 0] },  # to the right\n";
    assert_eq!(saved(&|keys| keys.retain(|key| key.time != 2.0)), KEYED.replace(line, ""));

    // An object without keyframes gets some.
    let mut document = open();
    let keyframes = vec![key(0.0, 0.0), key(1.0, 2.0)];
    let animation = AnimationEntry { keyframes, ..AnimationEntry::default() };
    document.instance_mut(0).unwrap().animation = Some(animation);
    let added = "\n[instances.animation]\nkeyframes = [\n    { time = 0.0 },\n    { time = 1.0, translation = [2.0, 0.0, 0.0] },\n]\n";
    assert_eq!(document.text_to_save(&file), KEYED.to_owned() + added);
}
