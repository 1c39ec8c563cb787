//! The map in ARCHITECTURE.md names every folder, every file says what it is for, and imports run downwards.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Endings of source files, and how a comment begins at their top.
const SOURCE: [(&str, &str); 5] =
    [("rs", "//!"), ("glsl", "//"), ("comp", "//"), ("vert", "//"), ("frag", "//")];

/// Every path that the map names: the first word of each line.
fn named() -> BTreeSet<PathBuf> {
    let text = include_str!("../ARCHITECTURE.md");
    let start = text.find("```text\nglowworm, test").expect("the map begins with the two commands");
    let map = text[start..].split("```").nth(1).unwrap();
    let first = |line: &str| Some(PathBuf::from(line.split([' ', ',']).next()?));
    map.lines().skip(1).filter(|line| !line.is_empty() && !line.starts_with(' ')).filter_map(first).collect()
}

/// All folders below a folder, itself included, and all files.
fn below(folder: &Path) -> (BTreeSet<PathBuf>, Vec<PathBuf>) {
    let (mut folders, mut files) = (BTreeSet::from([folder.to_owned()]), Vec::new());
    for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            let (more_folders, more_files) = below(&path);
            folders.extend(more_folders);
            files.extend(more_files);
        } else {
            files.push(path);
        }
    }
    (folders, files)
}

#[test]
fn the_map_names_every_folder_and_nothing_else() {
    let named = named();
    let folders: BTreeSet<PathBuf> = ["src", "shaders", "tests", "benches", "scenes", "scripts", "docs"]
        .into_iter()
        .flat_map(|folder| below(Path::new(folder)).0)
        .filter(|folder| !folder.ends_with("__pycache__"))
        .collect();
    let missing: Vec<_> = folders.difference(&named).collect();
    assert!(missing.is_empty(), "the map in ARCHITECTURE.md lacks {missing:?}");
    let gone: Vec<_> = named.iter().filter(|path| !path.exists()).collect();
    assert!(gone.is_empty(), "the map in ARCHITECTURE.md names {gone:?}, which are not there");
}

#[test]
fn every_source_file_says_what_it_is_for() {
    for file in ["src", "shaders", "tests", "benches"].iter().flat_map(|folder| below(Path::new(folder)).1) {
        let ending = file.extension().and_then(|ending| ending.to_str()).unwrap_or("");
        let Some((_, comment)) = SOURCE.iter().find(|(source, _)| *source == ending) else { continue };
        let text = fs::read_to_string(&file).unwrap();
        let first =
            text.lines().find(|line| !line.starts_with("#version") && !line.starts_with("#extension"));
        assert!(
            first.is_some_and(|line| line.starts_with(comment)),
            "{} begins without a word",
            file.display()
        );
    }
}

/// What each part may not know: files below the folder do not contain the word.
const FORBIDDEN: [(&str, &[&str]); 10] = [
    ("src/scene", &["crate::bvh", "crate::builtin", "crate::formats", "crate::vulkan", "crate::renderer"]),
    ("src/builtin", &["crate::bvh", "crate::formats", "crate::vulkan", "crate::renderer"]),
    ("src/bvh", &["crate::builtin", "crate::formats", "crate::vulkan", "crate::renderer"]),
    ("src/formats", &["crate::vulkan", "crate::passes", "crate::estimators", "crate::renderer"]),
    ("src/reference", &["crate::vulkan", "crate::passes", "crate::estimators", "crate::renderer"]),
    ("src/metrics", &["crate::vulkan", "crate::passes", "crate::estimators", "crate::renderer"]),
    ("src/estimators/vpls/manager", &["crate::vulkan", "crate::passes", "crate::renderer"]),
    ("src/passes", &["crate::estimators", "crate::renderer", "vpl"]),
    ("shaders/passes", &["vpl"]),
    ("src/renderer", &["vpl"]),
];

#[test]
fn imports_run_downwards() {
    for (folder, words) in FORBIDDEN {
        for file in below(Path::new(folder)).1 {
            let text = fs::read_to_string(&file).unwrap();
            for word in words {
                assert!(!text.contains(word), "{} must not know of `{word}`", file.display());
            }
        }
    }
    let frame = fs::read_to_string("src/renderer.rs").unwrap();
    assert!(!frame.contains("vpl"), "src/renderer.rs must not know of VPLs");
}
