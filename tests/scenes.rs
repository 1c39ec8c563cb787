//! Scenes from their public side: loading, errors, radiometry.

use std::path::PathBuf;

use glowworm::scene::{BUILTIN_SCENES, load_scene};

#[test]
fn all_builtin_scenes_load() {
    let Some(assets) = std::env::var_os("GLOWWORM_ASSETS").map(PathBuf::from) else { return };
    for name in BUILTIN_SCENES {
        let t = std::time::Instant::now();
        match load_scene(name, Some(&assets)) {
            Ok(s) => println!(
                "{name}: {} triangles, {} lights, {:?} {:?}",
                s.triangle_count(),
                s.lights.len(),
                s.warnings,
                t.elapsed()
            ),
            Err(e) => panic!("{e}"),
        }
    }
}
