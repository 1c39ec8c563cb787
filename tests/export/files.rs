//! The output folder: which files are written, replaced and kept.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use glowworm::export::{ExportError, ExportFolder, export_mitsuba};
use glowworm::formats::load_scene;
use glowworm::scene::Scene;

use crate::support::*;

/// Every file below `folder`, relative to it.
fn files_below(folder: &Path) -> BTreeSet<String> {
    let mut files = BTreeSet::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                files.insert(path.strip_prefix(folder).unwrap().to_str().unwrap().replace('\\', "/"));
            }
        }
    }
    files
}

fn export_into(folder: &Path, scene: &Scene) -> Result<(), ExportError> {
    export_mitsuba(scene, &settings(), &ExportFolder::new(folder)?).map(|_| ())
}

fn cornell_box() -> Scene {
    load_scene("cornell-box", None).unwrap()
}

#[test]
fn all_files_are_named_and_all_names_are_found() {
    let exported = export(&all_kinds());
    let files = files_below(exported.folder.path());
    assert_eq!(files, exported.report.files.iter().cloned().collect());
    let document = roxmltree::Document::parse(&exported.text).unwrap();
    let (mut named, mut ids) = (BTreeSet::new(), BTreeSet::new());
    for node in document.descendants() {
        if node.attribute("name") == Some("filename") {
            named.insert(node.attribute("value").unwrap().to_owned());
        }
        if let Some(id) = node.attribute("id").filter(|_| !node.has_tag_name("ref")) {
            assert!(ids.insert(id), "{id} is there twice");
        }
    }
    for reference in document.descendants().filter(|node| node.has_tag_name("ref")) {
        assert!(ids.contains(reference.attribute("id").unwrap()));
    }
    named.extend(["scene.xml", "glowworm-export.json"].map(str::to_owned));
    assert_eq!(files, named);
}

#[test]
fn any_name_is_safe() {
    let name = "-->\"<&'../../x -- \u{1}\u{ffff}\u{e4}/\\..\n";
    let mut scene = cornell_box();
    scene.name = name.to_owned();
    Arc::make_mut(&mut scene.meshes[0]).name = name.to_owned();
    scene.instances[0].name = name.to_owned();
    for material in &mut scene.materials {
        material.name = name.repeat(50);
    }
    let exported = export(&scene);
    let document = roxmltree::Document::parse(&exported.text).unwrap();
    assert_eq!(elements(document.root_element(), "shape").len(), 4);
    for file in files_below(exported.folder.path()) {
        assert!(
            file.len() < 200 && file.chars().all(|c| c.is_ascii_alphanumeric() || "/-_.".contains(c)),
            "{file}"
        );
    }
}

#[test]
fn a_new_folder_is_made_and_an_earlier_export_replaced() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("new");
    export_into(&folder, &all_kinds()).unwrap();
    assert!(folder.join("textures").is_dir());
    // Foreign files are kept.
    fs::write(folder.join("scene.exr"), "picture").unwrap();
    fs::write(folder.join("textures/mine.png"), "mine").unwrap();
    export_into(&folder, &cornell_box()).unwrap();
    let mut expected: BTreeSet<String> = export(&cornell_box()).report.files.into_iter().collect();
    expected.extend(["scene.exr", "textures/mine.png"].map(str::to_owned));
    assert_eq!(files_below(&folder), expected);
    assert_eq!(fs::read_dir(place.path()).unwrap().count(), 1);
    let again = fs::read(folder.join("scene.xml")).unwrap();
    export_into(&folder, &cornell_box()).unwrap();
    assert_eq!(fs::read(folder.join("scene.xml")).unwrap(), again);
}

#[test]
fn other_peoples_folders_are_left_alone() {
    let place = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(place.path().join(name), text).unwrap();
    write("notes.txt", "mine");
    let refused = |says: &str, folder: &Path| {
        let before = files_below(place.path());
        let message = export_into(folder, &cornell_box()).unwrap_err().to_string();
        assert!(message.contains(says) && !message.contains('\n'), "{message}");
        assert_eq!(files_below(place.path()), before);
    };
    refused("contains files that are not of an earlier export", place.path());
    write("glowworm-export.json", "{}");
    refused("contains files that are not of an earlier export", place.path());
    refused("is not a folder", &place.path().join("notes.txt"));
    refused("create it first", &place.path().join("a/b"));
    assert!(!place.path().join("a").exists());
}

#[test]
fn a_foreign_file_in_the_way_stops_the_export_and_nothing_is_lost() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("export");
    export_into(&folder, &cornell_box()).unwrap();
    let mine = export(&all_kinds()).report.files.into_iter().find(|file| file.contains("wedge")).unwrap();
    fs::write(folder.join(&mine), "mine").unwrap();
    let scene = fs::read(folder.join("scene.xml")).unwrap();
    let before = files_below(&folder);
    let message = export_into(&folder, &all_kinds()).unwrap_err().to_string();
    assert!(message.contains(&mine) && message.contains("move it away"), "{message}");
    assert_eq!(files_below(&folder), before);
    assert_eq!(fs::read(folder.join("scene.xml")).unwrap(), scene);
    assert_eq!(fs::read(folder.join(&mine)).unwrap(), b"mine");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 3);
}

#[test]
fn a_report_cannot_make_us_remove_what_is_not_ours() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("export");
    export_into(&folder, &cornell_box()).unwrap();
    fs::write(place.path().join("precious"), "mine").unwrap();
    fs::write(folder.join("own.ply"), "mine").unwrap();
    let listing =
        r#"{"format": "mitsuba", "files": ["../precious", "own.ply", "meshes/../own.ply", "meshes/.."]}"#;
    fs::write(folder.join("glowworm-export.json"), listing).unwrap();
    // The files that the listing does not name now block the export.
    let message = export_into(&folder, &cornell_box()).unwrap_err().to_string();
    assert!(message.contains("exists and is not of an earlier export"), "{message}");
    fs::remove_dir_all(folder.join("meshes")).unwrap();
    fs::remove_file(folder.join("scene.xml")).unwrap();
    fs::remove_file(folder.join("glowworm-export.json")).unwrap();
    fs::remove_file(folder.join("own.ply")).unwrap();
    export_into(&folder, &cornell_box()).unwrap();
    assert_eq!(fs::read(place.path().join("precious")).unwrap(), b"mine");
}

#[test]
fn a_killed_export_is_no_obstacle() {
    let place = tempfile::tempdir().unwrap();
    fs::create_dir(place.path().join(".glowworm-export.abc")).unwrap();
    export_into(place.path(), &cornell_box()).unwrap();
}
