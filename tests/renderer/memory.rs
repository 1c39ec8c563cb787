//! Device memory is what docs/PERFORMANCE.md says.

use glowworm::settings::{Antialiasing, Indirect, Settings, VplSettings};

use super::support::depth::quick_or_all;
use super::support::{GpuFixture, named_scene, plain};

/// Bytes that grow with the picture and the VPLs, as in docs/PERFORMANCE.md, "Memory".
fn computed(settings: &Settings) -> u64 {
    let pixels = settings.size.iter().map(|side| u64::from(*side)).product::<u64>();
    let of_step =
        |step: u32| settings.size.iter().map(|side| u64::from(side.div_ceil(step))).product::<u64>();
    let VplSettings { interleave, temporal_sets, .. } = settings.vpl;
    let set_step = if temporal_sets > 1 && interleave > 1 { 2 } else { 1 };
    let sets = u64::from(temporal_sets);
    let vpls = u64::from(settings.vpl.pool_size().div_ceil(temporal_sets));
    // A tile is 16 x 16 texels, a block 8 x 8, and blocks begin anywhere; each has a number for each of 64 clusters.
    let [across, down] = settings.size.map(|side| u64::from(side.div_ceil(16 * set_step)));
    let tiles = 256 * (across * down + (2 * across + 1) * (2 * down + 1));
    pixels * (if settings.antialiasing == Antialiasing::Taa { 140 } else { 84 })
        + of_step(2) * 24
        + of_step(set_step) * (24 + 8 * sets)
        + tiles
        + sets * (64 * vpls + 64 * 48)
}

/// Device memory for thin surfaces with so many lights, bytes.
fn of_thin_surfaces(settings: &Settings, lights: u64) -> u64 {
    let pixels = settings.size.iter().map(|side| u64::from(*side)).product::<u64>();
    pixels * (32 + 4 * lights - 4 * lights.div_ceil(32))
}

#[test]
fn thin_surfaces_take_what_they_say() {
    let Some(gpu) = GpuFixture::open_alone() else { return };
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("pane.obj", "mtllib pane.mtl\nusemtl pane\nv -1 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let light = "[[lights]]\ntype = \"point\"\nposition = [0, 2, 1]\nintensity = [1, 1, 1]\n";
    let model = "[[models]]\nname = \"pane\"\npath = \"pane.obj\"\n[[instances]]\nmodel = \"pane\"\n";
    write("scene.toml", &(model.to_owned() + &light.repeat(5)));
    let settings = |size| Settings { size, indirect: Indirect::NONE, ..plain() };
    let grown = |material: &str| {
        write("pane.mtl", &format!("newmtl pane\nKd 0.5 0.5 0.5\n{material}\n"));
        let scene = named_scene(folder.path().join("scene.toml").to_str().unwrap(), None);
        let [small, large] = [[8, 8], [640, 360]].map(|size| {
            let renderer = gpu.rendered(&scene, &settings(size), 1);
            gpu.device.restart_memory_peak();
            let bytes = gpu.device.memory_peak();
            drop(renderer);
            bytes
        });
        large - small
    };
    let [veil, opaque] = ["d 0.5", "d 1"].map(grown);
    let expected = of_thin_surfaces(&settings([640, 360]), 5) - of_thin_surfaces(&settings([8, 8]), 5);
    let (added, expected) = ((veil - opaque) as f64, expected as f64);
    assert!((added / expected - 1.0).abs() < 0.01, "{added} of {expected} bytes");
}

#[test]
fn memory_grows_as_computed() {
    let Some(gpu) = GpuFixture::open_alone() else { return };
    let scene = named_scene("cornell-box", None);
    let used = |settings: &Settings| {
        let renderer = gpu.rendered(&scene, settings, 1);
        gpu.device.restart_memory_peak();
        let bytes = gpu.device.memory_peak();
        drop(renderer);
        bytes
    };
    let of = |size, vpls, temporal_sets, interleave| {
        // The larger ones with antialiasing and still frames.
        let is_large = size == [320, 200];
        let antialiasing = if is_large { Antialiasing::Taa } else { Antialiasing::None };
        let settings = Settings {
            size,
            antialiasing,
            still_frames: if is_large { 64 } else { 0 },
            vpl: VplSettings { slots: vpls, temporal_sets, interleave, ..VplSettings::default() },
            ..plain()
        };
        (used(&settings), computed(&settings))
    };
    let (rest, least) = of([8, 8], 64, 1, 4);
    for (size, vpls, sets, interleave) in [
        ([320, 200], 512, 1, 4),
        ([320, 200], 512, 16, 4),
        ([128, 64], 4096, 1, 1),
        ([640, 360], 512, 32, 4),
        ([320, 200], 512, 4, 6),
        ([320, 200], 512, 4, 8),
        ([128, 64], 65_536, 64, 4),
    ]
    .into_iter()
    .step_by(quick_or_all(3, 1))
    {
        let (used, computed) = of(size, vpls, sets, interleave);
        let (grown, expected) = ((used - rest) as f64, (computed - least) as f64);
        // Besides what grows with the picture there are the VPLs in flight, 64 bytes each.
        let slack = f64::from(vpls.div_ceil(sets)) * 64.0 * 4.0 + 0.01 * expected;
        assert!(
            (grown - expected).abs() <= slack,
            "{size:?}, S = {vpls}, T = {sets}: {grown} of {expected} bytes"
        );
    }
}
