//! The committed SPIR-V was compiled from the shaders as they are. `.ci/run` compiles them anew and compares the bytes.

#![allow(clippy::unwrap_used)]

#[path = "../shaders/sources.rs"]
mod sources;

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

const ADVICE: &str = "run scripts/compile-shaders and commit shaders/spirv";

#[test]
fn the_committed_spirv_is_of_these_sources() {
    let now = sources::manifest(Path::new("shaders")).unwrap();
    let compiled = fs::read_to_string(Path::new("shaders/spirv").join(sources::MANIFEST)).unwrap();
    let changed: Vec<_> = now.lines().filter(|line| !compiled.contains(line)).collect();
    assert!(changed.is_empty() && now == compiled, "{ADVICE}: {changed:#?}");
}

#[test]
fn each_shader_has_its_spirv_and_nothing_is_left_over() {
    let shaders = sources::shaders(Path::new("shaders")).unwrap();
    assert!(shaders.len() > 30 && shaders.iter().any(|shader| shader.traces_rays));
    let expected: BTreeSet<_> = shaders.iter().flat_map(sources::Shader::spirv_files).collect();
    let entries = fs::read_dir("shaders/spirv").unwrap().map(|entry| entry.unwrap());
    let found: BTreeSet<_> = entries.map(|entry| entry.file_name().into_string().unwrap()).collect();
    let with_manifest: BTreeSet<_> = expected.iter().cloned().chain([sources::MANIFEST.to_owned()]).collect();
    assert_eq!(found, with_manifest, "{ADVICE}");
    for file in expected {
        let bytes = fs::read(Path::new("shaders/spirv").join(&file)).unwrap();
        assert!(
            bytes.len().is_multiple_of(4) && bytes.starts_with(&0x0723_0203u32.to_le_bytes()),
            "{file}: {ADVICE}"
        );
    }
}
