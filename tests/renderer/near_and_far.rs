//! Lamps near what they light, and scenes in which something is far larger than what is seen.

use std::fmt::Write;

use glowworm::output::Picture;
use glowworm::settings::{
    Antialiasing, Denoise, Direct, EffectSettings, Indirect, Reflections, Settings, VplSettings,
};

use super::support::golden::reference;
use super::support::{GpuFixture, exact, layer, luminance, mean, plain, scene};

const SIDE: u32 = 32;

fn box_on_a_floor(width: f32, rotation: &str, more: &str) -> String {
    format!(
        r#"
        [[models]]
        name = "floor"
        primitive = "quad"
        size = [{width}, 1, {width}]
        material = {{ albedo = [0.5, 0.5, 0.5] }}
        [[models]]
        name = "box"
        primitive = "box"
        size = [1, 1, 1]
        material = {{ albedo = [0.7, 0.3, 0.3] }}
        {more}
        [[instances]]
        model = "floor"
        {rotation}
        [[instances]]
        model = "box"
        translation = [0, 0.5, 0]
        [[lights]]
        type = "point"
        position = [1.5, 2, 1]
        intensity = [10, 10, 10]
        [camera]
        eye = [0, 1.5, 4]
        target = [0, 0.2, 0]
        vfov_deg = 40
        "#
    )
}

fn mean_of(picture: &Picture) -> f32 {
    mean(picture.colour.iter().map(luminance))
}

fn by_paths() -> Settings {
    Settings {
        indirect: Indirect::PATHS,
        effects: EffectSettings { denoise: Denoise::NONE, ..EffectSettings::default() },
        size: [SIDE; 2],
        ..plain()
    }
}

#[test]
fn what_is_far_and_black_changes_nothing() {
    let Some(gpu) = GpuFixture::open() else { return };
    for settings in [exact([SIDE; 2]), by_paths()] {
        let drawn = |more: &str| {
            let scene = scene(&box_on_a_floor(8.0, "", more));
            gpu.rendered(&scene, &settings, 2).read_picture(false).unwrap()
        };
        let alone = drawn("");
        for (primitive, size, place) in [
            ("sphere", [1e5; 3], [0.0; 3]),
            ("sphere", [1e6; 3], [0.0; 3]),
            ("quad", [1.0; 3], [1e6, 0.0, 0.0]),
        ] {
            let mut more =
                format!("[[models]]\nname = \"far\"\nprimitive = \"{primitive}\"\nsize = {size:?}\n");
            write!(
                more,
                "material = {{ albedo = [0, 0, 0] }}\n[[instances]]\nmodel = \"far\"\ntranslation = {place:?}"
            )
            .unwrap();
            let beside = drawn(&more);
            let off = (mean_of(&beside) / mean_of(&alone) - 1.0).abs();
            assert!(off < 0.01, "{primitive} of {size:?} at {place:?}: {off}");
        }
    }
}

#[test]
fn a_ground_without_end_has_no_acne() {
    let Some(gpu) = GpuFixture::open() else { return };
    for (name, rotation) in
        [("level_ground", ""), ("tilted_ground", "rotation = { axis = [1, 0, 0.3], degrees = 10 }")]
    {
        let scene = scene(&box_on_a_floor(1e5, rotation, ""));
        let expected = mean_of(&reference(name, &scene, [SIDE; 2], 2, 256));
        let vpl = VplSettings { slots: 128, pool: 512, ..VplSettings::default() };
        for settings in [Settings { vpl, size: [SIDE; 2], ..plain() }, by_paths()] {
            let settings =
                Settings { antialiasing: Antialiasing::Taa, still_frames: 64, bounces: 2, ..settings };
            let found = mean_of(&gpu.rendered(&scene, &settings, 80).read_picture(false).unwrap());
            // The rounding of corners 50 km away lifts rays some centimetres.
            assert!((found / expected - 1.0).abs() < 0.03, "{name}: {found} for {expected}");
        }
    }
}

// Takes 3 s: lamps near the floor light a few pixels by rare samples.
#[test]
fn a_lamp_near_the_floor_lights_it_in_full() {
    const LAMP: &str = r#"
        [[models]]
        name = "floor"
        primitive = "quad"
        size = [10, 1, 10]
        material = { albedo = [0.5, 0.5, 0.5] }
        [[models]]
        name = "lamp"
        primitive = "sphere"
        size = [0.5, 1, 1]
        subdivisions = 2
        material = { albedo = [0, 0, 0], emission = [15, 15, 15] }
        [[instances]]
        model = "floor"
        [[instances]]
        model = "lamp"
        translation = [1.2, 0.7, 0]
        [camera]
        eye = [0, 3, 5]
        target = [0, 0, 0]
        vfov_deg = 45
    "#;
    let Some(gpu) = GpuFixture::open() else { return };
    let (scene, size) = (scene(LAMP), [48; 2]);
    let settings = Settings { size, still_frames: 96, bounces: 1, ..Settings::default() };
    let expected = reference("lamp_near_a_floor", &scene, size, 1, 1024);
    let found = gpu.rendered(&scene, &settings, 144).read_picture(false).unwrap();
    // The brightest part of the floor, without the lamp and its edges.
    let is_lamp = |pixel: usize| luminance(&expected.colour[pixel]) > 5.0;
    let width = size[0] as usize;
    let is_edge = |pixel: usize| {
        (0..9).any(|place| {
            is_lamp((pixel + place / 3 * width + place % 3).saturating_sub(width + 1).min(width * width - 1))
        })
    };
    let near: Vec<[f32; 2]> = (0..width * width)
        .filter(|&pixel| luminance(&expected.colour[pixel]) > 0.6 && !is_edge(pixel))
        .map(|pixel| [&expected, &found].map(|picture| luminance(&picture.colour[pixel])))
        .collect();
    assert!(near.len() > 40, "{} pixels", near.len());
    let [theirs, ours] = [0, 1].map(|place| mean(near.iter().map(|pair| pair[place])));
    assert!((ours / theirs - 1.0).abs() < 0.03, "{ours} for {theirs}");
}

#[test]
fn the_rim_of_a_rough_metal_ball_reflects_no_more_than_there_is() {
    let Some(gpu) = GpuFixture::open() else { return };
    for roughness in [0.2, 0.5] {
        // Few triangles: at the rim vertex normals face away from the eye.
        let furnace = scene(&format!(
            r#"
            [[models]]
            name = "ball"
            primitive = "sphere"
            size = [1, 1, 1]
            subdivisions = 1
            material = {{ albedo = [1, 1, 1], metallic = 1, roughness = {roughness} }}
            [[instances]]
            model = "ball"
            [environment]
            colour = [1, 1, 1]
            [camera]
            eye = [0, 0.3, 3]
            target = [0, 0, 0]
            vfov_deg = 25
            "#
        ));
        let settings = Settings {
            size: [SIDE; 2],
            direct: Direct::Auto,
            reflections: Reflections::Rays,
            indirect: Indirect::PATHS,
            antialiasing: Antialiasing::Taa,
            still_frames: 64,
            ..plain()
        };
        let found = gpu.rendered(&furnace, &settings, 80).read_picture(true).unwrap();
        assert!(layer(&found, "reflected").iter().any(|pixel| pixel[0] > 0.5));
        let brightest = found.colour.iter().map(luminance).fold(0.0, f32::max);
        assert!(brightest < 1.1, "{brightest} at roughness {roughness}");
        assert!((mean_of(&found) - 1.0).abs() < 0.01, "{}", mean_of(&found));
    }
}
