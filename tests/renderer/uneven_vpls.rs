//! Rooms in which a few VPLs are far brighter than all others: the light of the many dim ones must not be lost.

use std::sync::Arc;

use glowworm::scene::Scene;
use glowworm::settings::{Settings, VplSettings};

use super::rooms::{niche, uplighter};
use super::support::golden::reference;
use super::support::{GpuFixture, indirect, layer, luminance, mean, plain};

const SIZE: [u32; 2] = [80, 60];
/// Seeds over which pictures are averaged.
const SEEDS: u32 = 16;

/// The mean over all pixels and seeds is that of the path tracer.
fn check(name: &str, scene: &Arc<Scene>) {
    let Some(gpu) = GpuFixture::open() else { return };
    let mut drawn = vec![0.0; (SIZE[0] * SIZE[1]) as usize];
    for seed in 0..SEEDS {
        let vpl = VplSettings { slots: 4096, clamp: 0.0, ..VplSettings::default() };
        let settings = Settings { size: SIZE, seed, vpl, ..plain() };
        let picture = indirect(&gpu.rendered(scene, &settings, vpl.temporal_sets));
        drawn.iter_mut().zip(&picture).for_each(|(sum, pixel)| *sum += luminance(pixel) / SEEDS as f32);
    }
    let reference = layer(&reference(name, scene, SIZE, 2, 256), "indirect");
    let reference: Vec<f32> = reference.iter().map(luminance).collect();
    let ratio = mean(drawn) / mean(reference);
    assert!((ratio - 1.0).abs() <= 0.03, "the mean is {ratio} of the reference's");
}

#[test]
#[ignore = "long; a_room_with_a_bright_niche is quicker"]
fn a_room_with_an_uplighter() {
    check("uplighter", &uplighter());
}

#[test]
fn a_room_with_a_bright_niche() {
    check("niche", &niche());
}
