//! Whole pictures of the real scenes, for plausibility.

use super::support::{GpuFixture, assets, luminance, mean, named_scene, plain};
use glowworm::settings::{Settings, VplSettings};

#[test]
#[ignore = "long; shadows::sponza_is_lit_as_in_the_reference is quicker"]
fn the_real_scenes_render() {
    let Some(gpu) = GpuFixture::open() else { return };
    let Some(assets) = assets() else { return };
    for name in ["sponza", "sibenik", "conference", "classroom", "living-room"] {
        let scene = named_scene(name, Some(&assets));
        let settings = Settings {
            size: [96, 54],
            vpl: VplSettings { slots: 128, temporal_sets: 4, ..VplSettings::default() },
            ..plain()
        };
        let picture = gpu.rendered(&scene, &settings, 5).read_picture(true).unwrap();
        assert!(picture.colour.iter().flatten().all(|value| value.is_finite()), "{name}");
        let brightness = mean(
            picture
                .display
                .iter()
                .map(|pixel| luminance(&[0, 1, 2].map(|channel| f32::from(pixel[channel]) / 255.0))),
        );
        assert!((0.15..0.85).contains(&brightness), "{name} is {brightness} bright");
    }
}
