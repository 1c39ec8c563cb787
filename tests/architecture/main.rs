//! The map in ARCHITECTURE.md names every folder, every file says what it is for and is short, and imports run downwards.

#![allow(clippy::unwrap_used)]

mod rooms;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use rooms::ROOMS;

/// Endings of source files, and how a comment begins at their top.
const SOURCE: [(&str, &str); 5] =
    [("rs", "//!"), ("glsl", "//"), ("comp", "//"), ("vert", "//"), ("frag", "//")];

/// Every path that the map names: at the beginning of each line, with commas between.
fn named() -> BTreeSet<PathBuf> {
    let text = include_str!("../../ARCHITECTURE.md");
    let start = text.find("```text\nglowworm, test").expect("the map begins with the two commands");
    let map = text[start..].split("```").nth(1).unwrap();
    let paths =
        |line: &'static str| line.split("  ").next().unwrap_or_default().split(", ").map(PathBuf::from);
    map.lines().skip(1).filter(|line| !line.is_empty()).flat_map(paths).collect()
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
    let folders: BTreeSet<PathBuf> = ["src", "shaders", "tests", "scenes", "scripts", "docs"]
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
    for file in ["src", "shaders", "tests"].iter().flat_map(|folder| below(Path::new(folder)).1) {
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

/// Who may know the VPLs besides themselves: the table of methods, and the faces that show them.
const KNOW_VPLS: [&str; 7] = [
    "src/estimators/mod.rs",
    "src/bench/micro/rays.rs",
    "src/cli/render.rs",
    "src/demo/inspector.rs",
    "src/demo/panel/vpls.rs",
    "src/demo/tour.rs",
    "src/demo/view.rs",
];
/// The room that only those of [`KNOW_VPLS`] know.
const VPLS: &str = "estimators/vpls";

/// The room with the longest name that holds a path of modules.
fn room_of(path: &str) -> Option<&'static str> {
    let holds =
        |room: &str| path == room || path.strip_prefix(room).is_some_and(|rest| rest.starts_with('/'));
    ROOMS.iter().map(|(room, _)| *room).filter(|room| holds(room)).max_by_key(|room| room.len())
}

/// The path of a file's module, such as `estimators/vpls` for its `mod.rs`.
fn module_of(file: &Path) -> String {
    let path = file.strip_prefix("src").unwrap().with_extension("");
    let path = if path.ends_with("mod") { path.parent().unwrap().to_owned() } else { path };
    path.to_str().unwrap().to_owned()
}

/// The paths of modules that a file names from the root of the crate, by `crate::` or by enough of `super::`.
fn paths_in(text: &str, module: &str) -> BTreeSet<String> {
    let mut paths = BTreeSet::new();
    let code: String =
        text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n");
    let tests = code.find("mod tests {").unwrap_or(code.len());
    let mut rest = code.as_str();
    while let Some(at) = ["crate::", "super::"].iter().filter_map(|root| rest.find(root)).min() {
        let mut path = &rest[at..];
        let module =
            if code.len() - path.len() < tests { module.to_owned() } else { format!("{module}/tests") };
        let depth = module.split('/').count();
        rest = &path["crate::".len()..];
        let mut from: Vec<&str> = Vec::new();
        if path.starts_with("super::") {
            let mut up = 0;
            while let Some(above) = path.strip_prefix("super::") {
                (path, up) = (above, up + 1);
            }
            rest = path;
            from = module.split('/').take(depth - up).collect();
        } else {
            path = rest;
        }
        for named in names(path) {
            let whole: Vec<&str> = from.iter().copied().chain(named.iter().map(String::as_str)).collect();
            paths.insert(whole.join("/"));
        }
    }
    paths
}

/// The paths that stand after `crate::`: one, or those of a list in braces, whose lists in turn count as their beginning.
fn names(text: &str) -> Vec<Vec<String>> {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    if let Some(list) = text.strip_prefix('{') {
        let (mut depth, mut items) = (0, vec![String::new()]);
        for c in list.chars() {
            match c {
                '}' if depth == 0 => break,
                ',' if depth == 0 => items.push(String::new()),
                _ => {
                    depth += i32::from(c == '{') - i32::from(c == '}');
                    items.last_mut().unwrap().push(c);
                }
            }
        }
        return items.iter().flat_map(|item| names(item.trim())).collect();
    }
    let mut path = Vec::new();
    let mut rest = text;
    loop {
        let end = rest.find(|c| !is_name(c)).unwrap_or(rest.len());
        if end > 0 {
            path.push(rest[..end].to_owned());
        }
        match rest[end..].strip_prefix("::") {
            Some(more) if more.starts_with('{') => {
                let of = |name: Vec<String>| path.iter().cloned().chain(name).collect();
                return names(more).into_iter().map(of).collect();
            }
            Some(more) => rest = more,
            None => return if path.is_empty() { Vec::new() } else { vec![path] },
        }
    }
}

#[test]
fn names_are_read_from_lists_in_lists() {
    let text =
        "use crate::{a::b, c::{self, d}};\nuse super::super::e;\n// crate::f\nlet x = crate::g::h();\n";
    let found: Vec<String> = paths_in(text, "demo/panel/view").into_iter().collect();
    assert_eq!(found, ["a/b", "c/d", "c/self", "demo/e", "g/h"]);
}

#[test]
fn rooms_use_only_what_stands_below_them() {
    for (at, (room, allowed)) in ROOMS.iter().enumerate() {
        for used in *allowed {
            let below = ROOMS[..at].iter().any(|(below, _)| below == used);
            assert!(below, "{room} may use {used}, which does not stand below it");
        }
    }
    let mut wrong = Vec::new();
    for file in rust_files("src") {
        let module = module_of(&file);
        let room = room_of(&module).unwrap_or_else(|| panic!("{} belongs to no room", file.display()));
        let allowed = ROOMS.iter().find(|(known, _)| *known == room).unwrap().1;
        for path in paths_in(&fs::read_to_string(&file).unwrap(), &module) {
            let Some(used) = room_of(&path) else { continue };
            // A room in a room is known to the outer one, which says what it is; who else knows VPLs is a test of its own.
            let is_own = used == room || used.starts_with(&format!("{room}/"));
            let is_vpls = used.starts_with(VPLS) && !room.starts_with("estimators");
            if !is_own && !is_vpls && !allowed.contains(&used) {
                wrong.push(format!("{} uses {path}: {room} may not use {used}", file.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The files of a room that each file imports from, by `crate::` or `super::`.
fn imports_within_rooms() -> BTreeMap<String, BTreeSet<String>> {
    let files: BTreeMap<String, PathBuf> =
        rust_files("src").into_iter().map(|file| (module_of(&file), file)).collect();
    let file_of = |path: &str| {
        let ends = path.match_indices('/').map(|(at, _)| at).chain([path.len()]);
        ends.map(|end| &path[..end]).rfind(|module| files.contains_key(*module)).map(str::to_owned)
    };
    let imports = |(module, file): (&String, &PathBuf)| {
        let paths = paths_in(&fs::read_to_string(file).unwrap(), module);
        let used = paths.iter().filter_map(|path| file_of(path));
        let used = used.filter(|used| used != module && room_of(used) == room_of(module));
        (module.clone(), used.collect())
    };
    files.iter().map(imports).collect()
}

#[test]
fn no_files_of_a_room_import_each_other_in_a_circle() {
    // Take files away that import none of those left: they are on no circle.
    let mut left = imports_within_rooms();
    loop {
        let free = |used: &BTreeSet<String>| !used.iter().any(|file| left.contains_key(file));
        let done: Vec<String> =
            left.iter().filter(|(_, used)| free(used)).map(|(file, _)| file.clone()).collect();
        if done.is_empty() {
            break;
        }
        done.iter().for_each(|file| drop(left.remove(file)));
    }
    // A circle is left, with the files above it.
    let waits: Vec<String> = left
        .iter()
        .map(|(file, used)| {
            let used: Vec<&str> =
                used.iter().filter(|used| left.contains_key(*used)).map(String::as_str).collect();
            format!("{file} imports {}", used.join(", "))
        })
        .collect();
    assert!(waits.is_empty(), "on a circle of imports, or above one:\n{}", waits.join("\n"));
}

#[test]
fn vpls_are_known_to_few() {
    let knows = |file: &PathBuf| {
        let module = module_of(file);
        let paths = paths_in(&fs::read_to_string(file).unwrap(), &module);
        !module.starts_with(VPLS) && paths.iter().any(|path| path.starts_with(VPLS))
    };
    let found: BTreeSet<PathBuf> = rust_files("src").into_iter().filter(knows).collect();
    // The table declares them as its module.
    let allowed: BTreeSet<PathBuf> = KNOW_VPLS.iter().map(PathBuf::from).collect();
    let wrong: Vec<_> = found.difference(&allowed).collect();
    assert!(wrong.is_empty(), "{wrong:?} must not know of VPLs");
    for folder in
        ["src/passes", "src/renderer", "src/denoise", "src/effects", "shaders/passes", "shaders/denoise"]
    {
        for file in below(Path::new(folder)).1 {
            // The table of noise is no text.
            let Ok(text) = fs::read_to_string(&file) else { continue };
            assert!(!text.to_lowercase().contains("vpl"), "{} must not speak of VPLs", file.display());
        }
    }
}

#[test]
fn the_renderer_is_implemented_where_it_stands() {
    for file in rust_files("src").iter().filter(|file| room_of(&module_of(file)) != Some("renderer")) {
        let text = fs::read_to_string(file).unwrap();
        assert!(!text.contains("impl Renderer {"), "{} adds to the renderer", file.display());
    }
}

/// Most lines of a file of source text.
const MOST_LINES: usize = 400;

#[test]
fn files_are_short() {
    let files = ["src", "shaders"].iter().flat_map(|folder| below(Path::new(folder)).1);
    let lines = |file: &PathBuf| fs::read_to_string(file).map_or(0, |text| text.lines().count());
    let is_source =
        |file: &PathBuf| SOURCE.iter().any(|(ending, _)| file.extension().is_some_and(|of| of == *ending));
    let long: Vec<_> = files.filter(|file| is_source(file) && lines(file) > MOST_LINES).collect();
    assert!(long.is_empty(), "longer than {MOST_LINES} lines: {long:?}");
}

fn rust_files(folder: &str) -> Vec<PathBuf> {
    let files = below(Path::new(folder)).1.into_iter();
    files.filter(|file| file.extension().is_some_and(|ending| ending == "rs")).collect()
}

#[test]
fn pages_name_files_that_exist() {
    let docs = fs::read_dir("docs").unwrap().map(|entry| entry.unwrap().path());
    let pages =
        ["README.md", "ARCHITECTURE.md", "scenes/README.md"].map(PathBuf::from).into_iter().chain(docs);
    let mut missing = Vec::new();
    for page in pages.filter(|path| path.extension().is_some_and(|extension| extension == "md")) {
        let text = fs::read_to_string(&page).unwrap();
        let is_part = |c: char| c.is_ascii_alphanumeric() || "_./-".contains(c);
        for path in text.split(|c| !is_part(c)).map(|path| path.trim_end_matches(['.', '/'])) {
            let is_ours =
                ["src/", "shaders/", "tests/", "scripts/"].iter().any(|room| path.starts_with(room));
            if is_ours && !Path::new(path).exists() {
                missing.push(format!("{}: {path}", page.display()));
            }
        }
    }
    assert!(missing.is_empty(), "{missing:#?}");
}
