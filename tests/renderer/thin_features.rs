//! Features as thin as pixels get their share of the indirect light.

use glam::Quat;
use glowworm::settings::{Indirect, Settings, VplSettings};

use super::rooms::thin_features;
use super::support::depth::quick_or_all;
use super::support::{GpuFixture, indirect, luminance, plain, scene};

/// Every pixel gathers from all VPLs, so that the time grows by pixels and VPLs.
fn size() -> [u32; 2] {
    quick_or_all([192, 108], [320, 180])
}

/// The share of pixels that have less than a quarter of their light at the default settings. Their light is what every pixel
/// gathers from all VPLs of `reference`.
fn dark_share(reference: Settings) -> Option<f32> {
    let gpu = GpuFixture::open()?;
    let (scene, size) = (thin_features(), size());
    let settings = Settings { size, ..plain() };
    let ours = indirect(&gpu.rendered(&scene, &settings, settings.vpl.temporal_sets));
    let reference = Settings { size, vpl: VplSettings { interleave: 1, ..reference.vpl }, ..reference };
    let reference = indirect(&gpu.rendered(&scene, &reference, reference.vpl.temporal_sets));
    let pairs: Vec<(f32, f32)> = ours
        .iter()
        .zip(&reference)
        .map(|(ours, reference)| (luminance(ours), luminance(reference)))
        .collect();
    let lit = pairs.iter().filter(|(_, reference)| *reference > 0.0).count();
    assert!(lit * 8 > pairs.len() * 7, "only {lit} of {} pixels are lit", pairs.len());
    let dark = pairs.iter().filter(|(ours, reference)| *ours < 0.25 * reference).count();
    let share = dark as f32 / lit as f32;
    eprintln!("{share:.5} of the pixels have less than a quarter of their light");
    Some(share)
}

#[test]
#[ignore = "long; interleaving_leaves_no_pixel_in_the_dark is quicker"]
fn thin_features_do_not_go_black() {
    let vpl = VplSettings { slots: 2048, temporal_sets: 2, ..VplSettings::default() };
    let many = Settings { seed: 77, vpl, ..plain() };
    let Some(share) = dark_share(many) else { return };
    assert!(share < 0.003, "{share} of the pixels have less than a quarter of their light");
}

#[test]
fn interleaving_leaves_no_pixel_in_the_dark() {
    // All pictures have the same VPLs, so that they differ only by sampling a few.
    let vpl = VplSettings { temporal_sets: 1, ..VplSettings::default() };
    let same = Settings { vpl, ..plain() };
    let Some(share) = dark_share(same) else { return };
    assert!(share < 0.003, "{share} of the pixels have less than a quarter of what their VPLs send");
}

/// A back is dark, and never seen of a closed mesh.
#[test]
fn closed_emitters_show_no_dark_backs() {
    let Some(gpu) = GpuFixture::open() else { return };
    let ball = |subdivisions: u32, place: [f32; 3]| {
        format!(
            "[[models]]\nname = \"ball {subdivisions}\"\nprimitive = \"sphere\"\nsize = [1, 1, 1]\nsubdivisions = {subdivisions}\n\
             material = {{ albedo = [0, 0, 0], emission = [2, 2, 2] }}\n[[instances]]\nmodel = \"ball {subdivisions}\"\n\
             translation = {place:?}\n"
        )
    };
    let scene = scene(&format!(
        "background = [0.5, 0.5, 0.5]\n{}{}{}[camera]\neye = [0, 0.5, 5]\ntarget = [0, 0, 0]\nvfov_deg = 40\n",
        ball(6, [0.0; 3]),
        ball(2, [1.5, 0.3, 0.0]),
        ball(5, [-3.0, 0.3, -3.0])
    ));
    let mut pose = scene.pose(0.0);
    let settings = Settings { size: [160, 128], indirect: Indirect::NONE, ..plain() };
    let mut renderer = gpu.renderer(&scene, &settings, &pose);
    let mut dark = 0;
    for _ in 0..48 {
        pose.camera.eye = Quat::from_rotation_y(0.02) * pose.camera.eye;
        renderer.render(&pose).unwrap();
        let picture = renderer.read_picture(false).unwrap();
        dark += picture.colour.iter().filter(|pixel| luminance(pixel) < 0.4).count();
    }
    assert_eq!(dark, 0, "pixels of backs");
}
