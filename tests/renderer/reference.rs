//! The renderer against the path tracer: the light that VPLs carry, and the tone mapping they share.

use std::sync::Arc;

use glowworm::output::{Picture, tone_map};
use glowworm::scene::Scene;
use glowworm::settings::{Settings, ToneMap, VplSettings};

use super::support::golden::reference;
use super::support::{GpuFixture, channel, exact, layer, luminance, mean, named_scene, quantile};

const SIDE: u32 = 48;
const BLOCK: usize = 12;

/// Mean luminance of each block of pixels.
fn blocks(pixels: &[[f32; 3]]) -> Vec<f32> {
    let side = SIDE as usize;
    let starts = (0..side).step_by(BLOCK);
    starts
        .clone()
        .flat_map(|y| starts.clone().map(move |x| (x, y)))
        .map(|(x, y)| {
            let rows = (y..y + BLOCK).flat_map(|row| &pixels[row * side + x..row * side + x + BLOCK]);
            mean(rows.map(luminance))
        })
        .collect()
}

/// Compares the irradiance of so many VPLs with the path tracer: its mean, and blocks of pixels.
pub(super) fn check_against_reference(name: &str, scene: &Arc<Scene>, interleave: u32, vpls: u32) {
    let Some(gpu) = GpuFixture::open() else { return };
    // Several sets with interleaving would have half the resolution, too little for so small a picture.
    let temporal_sets = if interleave == 1 { 8 } else { 1 };
    let settings = Settings {
        vpl: VplSettings { slots: vpls, temporal_sets, interleave, ..exact([SIDE; 2]).vpl },
        ..exact([SIDE; 2])
    };
    let drawn = gpu.rendered(scene, &settings, 8).read_picture(true).unwrap();
    let reference = reference(name, scene, settings.size, settings.bounces, 1024);
    let (drawn, reference) = (layer(&drawn, "indirect"), layer(&reference, "indirect"));
    let ratio = mean(drawn.iter().map(luminance)) / mean(reference.iter().map(luminance));
    assert!((ratio - 1.0).abs() <= 0.02, "the mean is {ratio} of the reference's");
    let errors: Vec<f32> = blocks(&drawn)
        .iter()
        .zip(blocks(&reference))
        .map(|(drawn, reference)| (drawn / reference - 1.0).abs())
        .collect();
    let most = quantile(errors, 0.9);
    assert!(most <= 0.05, "one block in ten is off by more than {most}");
}

#[test]
fn the_cornell_box_is_lit_as_in_the_reference() {
    check_against_reference("cornell-box", &named_scene("cornell-box", None), 1, 8192);
}

#[test]
#[ignore = "long; the_cornell_box_is_lit_as_in_the_reference is quicker"]
fn interleaving_moves_no_light() {
    check_against_reference("cornell-box", &named_scene("cornell-box", None), 2, 8192);
}

#[test]
#[ignore = "long; the_cornell_box_is_lit_as_in_the_reference is quicker"]
fn four_kinds_of_lights_light_as_in_the_reference() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/scene-files/all-kinds.toml");
    check_against_reference("all-kinds", &named_scene(file, None), 1, 8192);
}

#[test]
fn both_see_the_same_surfaces_and_direct_light() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("cornell-box", None);
    let drawn = gpu.rendered(&scene, &exact([SIDE; 2]), 1).read_picture(true).unwrap();
    let reference = reference("cornell-box", &scene, [SIDE; 2], 2, 4);
    for name in ["direct", "albedo", "normal", "position"] {
        let pairs = layer(&drawn, name).into_iter().zip(layer(&reference, name));
        let differences = pairs.flat_map(|(a, b)| [0, 1, 2].map(|i| (a[i] - b[i]).abs())).collect();
        let most = quantile(differences, 0.99);
        assert!(most < 2e-3, "{name}: {most}");
    }
    let same = channel(&drawn, "instance")
        .iter()
        .zip(channel(&reference, "instance"))
        .filter(|(a, b)| **a == *b)
        .count();
    assert!(same >= (SIDE * SIDE) as usize * 99 / 100, "{same}");
}

#[test]
fn the_tone_mapping_on_the_cpu_is_that_of_the_shaders() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("cornell-box", None);
    let curves = [ToneMap::Aces, ToneMap::Agx, ToneMap::None];
    for (exposure, tone_map_of) in curves.into_iter().flat_map(|curve| [(None, curve), (Some(1.5), curve)]) {
        let settings = Settings { exposure, tone_map: tone_map_of, ..exact([SIDE; 2]) };
        let drawn = gpu.rendered(&scene, &settings, 1).read_picture(true).unwrap();
        let mut twin = Picture { display: Vec::new(), ..drawn.clone() };
        let shines = layer(&drawn, "emission").into_iter().map(|emission| emission != [0.0; 3]);
        let weights = channel(&drawn, "instance").into_iter().zip(shines).map(|pixel| match pixel {
            (instance, _) if instance < 0.0 => 0.0,
            (_, shines) => {
                if shines {
                    1.0 / 16.0
                } else {
                    1.0
                }
            }
        });
        tone_map(&mut twin, (&settings).into(), weights);
        for (a, b) in drawn.display.iter().zip(&twin.display) {
            assert!(a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) <= 1), "{a:?} {b:?}");
        }
    }
}
