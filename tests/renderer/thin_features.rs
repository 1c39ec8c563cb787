//! Features as thin as pixels get their share of the indirect light.

use glowworm::settings::{Settings, VplSettings};

use super::rooms::thin_features;
use super::support::{GpuFixture, indirect, luminance, plain};

const SIZE: [u32; 2] = [320, 180];

/// The share of pixels that have less than a quarter of their light at the default settings. What their light is, every pixel
/// gathers from all VPLs of `reference`.
fn dark_share(reference: Settings) -> Option<f32> {
    let gpu = GpuFixture::open()?;
    let scene = thin_features();
    let settings = Settings { size: SIZE, ..plain() };
    let ours = indirect(&gpu.rendered(&scene, &settings, settings.vpl.temporal_sets));
    let reference = Settings { size: SIZE, vpl: VplSettings { interleave: 1, ..reference.vpl }, ..reference };
    let reference = indirect(&gpu.rendered(&scene, &reference, reference.vpl.temporal_sets));
    let pairs: Vec<(f32, f32)> = ours
        .iter()
        .zip(&reference)
        .map(|(ours, reference)| (luminance(ours), luminance(reference)))
        .collect();
    let lit = pairs.iter().filter(|(_, reference)| *reference > 0.0).count();
    assert!(lit > 50_000, "only {lit} pixels are lit");
    let dark = pairs.iter().filter(|(ours, reference)| *ours < 0.25 * reference).count();
    let share = dark as f32 / lit as f32;
    eprintln!("{share:.5} of the pixels have less than a quarter of their light");
    Some(share)
}

#[test]
fn thin_features_do_not_go_black() {
    let vpl = VplSettings { slots: 2048, temporal_sets: 2, ..VplSettings::default() };
    let many = Settings { seed: 77, vpl, ..plain() };
    let Some(share) = dark_share(many) else { return };
    assert!(share < 0.003, "{share} of the pixels have less than a quarter of their light");
}

#[test]
fn interleaving_leaves_no_pixel_in_the_dark() {
    // The same VPLs, so that all differences are those of drawing a few.
    let vpl = VplSettings { temporal_sets: 1, ..VplSettings::default() };
    let same = Settings { vpl, ..plain() };
    let Some(share) = dark_share(same) else { return };
    assert!(share < 0.003, "{share} of the pixels have less than a quarter of what their VPLs send");
}
