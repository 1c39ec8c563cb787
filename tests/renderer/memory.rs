//! Device memory is what ARCHITECTURE.md says.

use glam::{Affine3A, Vec3};
use glowworm::settings::Settings;

use super::support::{Lab, named_scene};

/// Bytes that grow with the picture and the VPLs, as in ARCHITECTURE.md, "Numbers worth knowing".
fn computed(settings: &Settings) -> u64 {
    let pixels = settings.size.iter().map(|side| u64::from(*side)).product::<u64>();
    let discontinuities = match settings.interleave {
        8 => 12,
        6 | 7 => 8,
        _ => 4,
    };
    let set_buffers = (pixels + u64::from(settings.size[0])) * 8 * (u64::from(settings.temporal_sets) + 1);
    let tiles = u64::from(settings.size[0].div_ceil(8)) * u64::from(settings.size[1].div_ceil(8));
    let classes = u64::from(settings.interleave * settings.interleave);
    let vpls = u64::from(settings.vpls.div_ceil(settings.temporal_sets));
    let vpl_sets = u64::from(settings.temporal_sets) * 16 * (classes + 3 * vpls);
    pixels * (84 + discontinuities) + set_buffers + tiles * 12 + vpl_sets
}

#[test]
fn memory_grows_as_computed() {
    let Some(lab) = Lab::open() else { return };
    let scene = named_scene("cornell-box", None);
    let used = |settings: &Settings| {
        let renderer = lab.rendered(&scene, settings, 1);
        lab.device.restart_memory_peak();
        let bytes = lab.device.memory_peak();
        drop(renderer);
        bytes
    };
    let of = |size, vpls, temporal_sets, interleave| {
        let settings = Settings { size, vpls, temporal_sets, interleave, ..Settings::default() };
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
    ] {
        let (used, computed) = of(size, vpls, sets, interleave);
        let (grown, expected) = ((used - rest) as f64, (computed - least) as f64);
        // Besides what grows with the picture there are the VPLs on their way, 48 bytes each.
        let slack = f64::from(vpls.div_ceil(sets)) * 48.0 * 4.0 + 0.01 * expected;
        assert!(
            (grown - expected).abs() <= slack,
            "{size:?}, S = {vpls}, T = {sets}: {grown} of {expected} bytes"
        );
    }
}

#[test]
fn what_stands_still_is_kept_only_while_something_moves() {
    let Some(lab) = Lab::open() else { return };
    let scene = named_scene("cornell-box", None);
    let rest = scene.pose(0.0);
    let settings = Settings { size: [320, 200], ..Settings::default() };
    let mut renderer = lab.renderer(&scene, &settings, &rest);
    let used = |lab: &Lab| {
        lab.device.restart_memory_peak();
        lab.device.memory_peak()
    };
    // Both frames that may be on their way have their upload memory then.
    for _ in 0..2 {
        renderer.render(&rest).unwrap();
    }
    let before = used(&lab);
    let mut moved = rest.clone();
    moved.instances[0] = Affine3A::from_translation(Vec3::X * 0.01) * moved.instances[0];
    renderer.render(&moved).unwrap();
    let grown = used(&lab) - before;
    let expected = 320 * 200 * 32;
    assert!(grown.abs_diff(expected) < expected / 100, "{grown} of {expected} bytes");
}
