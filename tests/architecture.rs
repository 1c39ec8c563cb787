//! The map of files in ARCHITECTURE.md names what there is, and nothing else.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Endings of source files.
const SOURCE: [&str; 6] = ["rs", "glsl", "comp", "vert", "frag", "css"];

/// What the map names: files, and folders whose files speak for themselves.
fn named() -> BTreeSet<PathBuf> {
    let text = include_str!("../ARCHITECTURE.md");
    let start = text.find("```text\nglowworm, test").expect("the map of files begins with the two commands");
    let map = text[start..].split("```").nth(1).unwrap();
    map.lines().skip(1).flat_map(named_by).collect()
}

/// What a line names: a path first, and beside it other files of its folder, or `.frag` for another ending.
fn named_by(line: &str) -> BTreeSet<PathBuf> {
    let mut words = line.split([' ', ',', ':', ';', '(', ')']).filter(|word| !word.is_empty());
    let Some(first) = words.next().map(Path::new) else { return BTreeSet::new() };
    let beside = words.filter(|word| word.contains('.')).map(|word| match word.strip_prefix('.') {
        Some(ending) => first.with_extension(ending),
        None => first.with_file_name(word),
    });
    beside.filter(|path| path.exists()).chain([first.to_path_buf()]).collect()
}

/// All files below a folder.
fn below(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { below(&path) } else { vec![path] }).collect()
}

#[test]
fn the_map_names_every_source_file() {
    let named = named();
    let is_named = |file: &Path| file.ancestors().any(|path| named.contains(path));
    let missing: Vec<PathBuf> = ["src", "shaders", "benches"]
        .into_iter()
        .flat_map(|folder| below(Path::new(folder)))
        .filter(|file| file.extension().is_some_and(|ending| SOURCE.iter().any(|source| ending == *source)))
        .filter(|file| !is_named(file))
        .collect();
    assert!(missing.is_empty(), "the map of files in ARCHITECTURE.md lacks {missing:?}");
}

#[test]
fn the_map_names_nothing_else() {
    let gone: Vec<PathBuf> =
        named().into_iter().filter(|path| !path.to_string_lossy().contains('<') && !path.exists()).collect();
    assert!(gone.is_empty(), "the map of files in ARCHITECTURE.md names {gone:?}, which are not there");
}
