//! Reflections together with the rest of a frame: light of VPLs, thin surfaces, still scenes, changes while it runs, roughness.

use std::sync::Arc;

use glowworm::scene::{LightKind, Scene};
use glowworm::settings::{
    Antialiasing, Denoise, Direct, EffectSettings, Noise, Reflections, Settings, VplSettings,
};

use super::reflections::{FRAMES, SIZE, SKY, settings, stage};
use super::still::{self, check_stillness_from, frozen};
use super::support::golden::reference;
use super::support::{GpuFixture, channel, exact, layer, luminance, mean, scene};

/// A closed room with a mirror on its far wall, seen from a place where the mirror shows the wall behind the camera too.
fn room(roughness: f32) -> Arc<Scene> {
    scene(&format!(
        r#"
[[models]]
name = "room"
primitive = "box"
size = [6, 4, 6]
material = {{ albedo = [0.7, 0.65, 0.6] }}
[[models]]
name = "mirror"
primitive = "box"
size = [1.2, 0.9, 0.1]
material = {{ albedo = [0.95, 0.9, 0.8], roughness = {roughness}, metallic = 1 }}
[[models]]
name = "box"
primitive = "box"
size = [0.9, 1.8, 0.9]
material = {{ albedo = [0.3, 0.4, 0.7] }}
[[instances]]
model = "room"
[[instances]]
model = "mirror"
translation = [0.2, 0, -2.9]
[[instances]]
model = "box"
translation = [-0.9, -1.1, -1.2]
rotation = [0, 30, 0]
[[lights]]
type = "point"
position = [0.6, 1.5, 0.5]
intensity = [12, 12, 12]
[camera]
eye = [0.6, 0.2, 0.2]
target = [0.1, -0.1, -3]
vfov_deg = 40
"#
    ))
}

/// Light at hits holds a bounce more than the path tracer has: VPLs stand for all bounces at the hit, as at surfaces that are seen.
#[test]
#[ignore = "long; a_sheet_before_a_mirror_tints_it_twice is quicker"]
fn a_mirror_shows_the_light_of_vpls() {
    let Some(gpu) = GpuFixture::open() else { return };
    let size = [64, 48];
    for (roughness, bounces) in [(0.0, 1), (0.3, 1), (0.0, 2), (0.3, 2)] {
        let scene = room(roughness);
        let effects =
            EffectSettings { denoise: Denoise::NONE, reflection_roughness: Some(1.0), ..Default::default() };
        let vpl = VplSettings { slots: 1024, pool: 1024, budget: 1024, temporal_sets: 4, ..exact(size).vpl };
        let settings = Settings { bounces, vpl, effects, reflections: Reflections::Rays, ..exact(size) };
        let picture = gpu.rendered(&scene, &settings, 1).read_picture(true).unwrap();
        let is_mirror: Vec<bool> = channel(&picture, "instance").iter().map(|id| *id == 1.0).collect();
        let of = |reflected: Vec<[f32; 3]>| {
            let pixels = reflected.into_iter().zip(&is_mirror);
            mean(pixels.filter(|(_, is_mirror)| **is_mirror).map(|(pixel, _)| luminance(&pixel)))
        };
        let reference = of(layer(
            &reference(&format!("mirror-{roughness}"), &scene, size, bounces + 1, 512),
            "reflected",
        ));
        let ours = of(gpu.mean_of_frames(&scene, &settings, 24, |picture| layer(picture, "reflected")));
        assert!(
            (ours / reference - 1.0).abs() < 0.03,
            "roughness {roughness}, {bounces} bounces: {}",
            ours / reference
        );
    }
}

#[test]
fn a_sheet_before_a_mirror_tints_it_twice() {
    let Some(gpu) = GpuFixture::open() else { return };
    let pane = r#"
[[models]]
name = "pane"
primitive = "quad"
size = [12, 1, 8]
material = { albedo = [0.9, 0.5, 0.2] }
[[materials]]
name = "pane"
transmission = 1
[[instances]]
model = "pane"
translation = [0, 3, -1.2]
rotation = [90, 0, 0]
"#;
    let mirror = "albedo = [0.9, 0.9, 0.9], roughness = 0, metallic = 1";
    let reflected = |name: &str, more: &str| {
        let scene = stage(mirror, more);
        let picture = gpu.rendered(&scene, &settings(Denoise::NONE), FRAMES).read_picture(true).unwrap();
        let reference = reference(name, &scene, SIZE, 1, 256);
        [picture, reference].map(|picture| {
            let pixels = layer(&picture, "reflected");
            [0, 1, 2].map(|i| mean(pixels.iter().map(|pixel| pixel[i])))
        })
    };
    let ([tinted, reference], [clear, _]) = (reflected("mirror-behind-pane", pane), reflected("mirror", ""));
    eprintln!("{tinted:?}, {reference:?} in the path tracer, {clear:?} without the thin surface");
    for i in 0..3 {
        assert!((tinted[i] / reference[i] - 1.0).abs() < 0.02, "{tinted:?}, {reference:?}");
    }
    // The more of a colour the thin surface absorbs, by its square.
    let shares = [0, 1, 2].map(|i| tinted[i] / clear[i]);
    assert!(shares[0] > 0.7 && shares[1] < 0.4 && shares[2] < 0.15, "{shares:?}");
}

/// Before the mirror: a ball that mirrors blurredly, one between mirroring and not, the sky, an area light.
const BALLS: &str = r#"
[[models]]
name = "metal"
primitive = "sphere"
size = [0.4, 0.4, 0.4]
subdivisions = 3
material = { albedo = [0.9, 0.7, 0.3], roughness = 0.3, metallic = 1 }
[[models]]
name = "dull"
primitive = "sphere"
size = [0.4, 0.4, 0.4]
subdivisions = 3
material = { albedo = [0.3, 0.5, 0.3], roughness = 0.62, metallic = 0.5 }
[[instances]]
model = "metal"
translation = [0.1, 0.4, 0.6]
[[instances]]
model = "dull"
translation = [0.6, 1.8, -0.4]
[environment]
colour = [0.2, 0.3, 0.5]
"#;

/// Everything in use.
fn all_in_use() -> Settings {
    let effects = EffectSettings { reflection_depth: 3, ..EffectSettings::default() };
    Settings { effects, direct: Direct::Soft, reflections: Reflections::Auto, ..still::settings() }
}

fn mirrors() -> Arc<Scene> {
    stage("albedo = [0.9, 0.9, 0.9], roughness = 0, metallic = 1", BALLS)
}

#[test]
#[ignore = "long; still::what_freezes_depends_on_no_past is quicker"]
fn frozen_mirrors_depend_on_no_past() {
    let smooth = all_in_use();
    let effects = EffectSettings { denoise: Denoise::NONE, noise: Noise::White, ..smooth.effects };
    let (direct, antialiasing) = (Direct::Hard, Antialiasing::None);
    let rough = Settings { direct, antialiasing, effects, ..smooth.clone() };
    for settings in [smooth, rough] {
        // A renderer made for another pose freezes to other bits in about 20 of 1536 pixels: a known fault.
        check_stillness_from(&mirrors(), &settings, |rest| rest.clone());
    }
}

#[test]
#[ignore = "long; live::changed_settings_end_as_a_fresh_renderer_bit_for_bit is quicker"]
fn changes_while_it_runs_end_as_a_fresh_renderer() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = mirrors();
    let pose = scene.pose(0.0);
    let start = all_in_use();
    let mut renderer = gpu.renderer(&scene, &start, &pose);
    (0..7).for_each(|_| renderer.render(&pose).unwrap());
    type Change = fn(&mut Settings);
    let changes: [(&str, Change); 5] = [
        ("none", |settings| settings.reflections = Reflections::None),
        ("rays", |settings| settings.reflections = Reflections::Rays),
        ("depth and noise", |settings| {
            (settings.effects.reflection_depth, settings.effects.noise) = (1, Noise::White);
        }),
        ("limit and shadows", |settings| {
            (settings.effects.reflection_roughness, settings.direct) = (Some(0.2), Direct::Hard);
        }),
        ("denoiser", |settings| settings.effects.denoise = Denoise::NONE),
    ];
    // One after the other: history of an earlier change must not show either.
    let mut settings = start;
    for (what, change) in changes {
        change(&mut settings);
        renderer.set_settings(&settings, &pose).unwrap();
        let ours = frozen(&mut renderer, &pose);
        assert!(ours == frozen(&mut gpu.renderer(&scene, &settings, &pose), &pose), "{what}");
    }
    // The mirror becomes a dull one, below the limit.
    let mut edited = Scene::clone(&scene);
    edited.materials[0].roughness = 0.15;
    let edited = Arc::new(edited);
    renderer.set_scene(&edited, &pose).unwrap();
    let ours = frozen(&mut renderer, &pose);
    assert!(ours == frozen(&mut gpu.renderer(&edited, &settings, &pose), &pose), "edited");
}

#[test]
#[ignore = "long; reflections::denoised_stills_are_like_the_reference is quicker"]
fn above_the_limit_the_lobe_gets_irradiance_and_both_blend() {
    let Some(gpu) = GpuFixture::open() else { return };
    let (direct, antialiasing) = (Direct::Hard, Antialiasing::None);
    let base = Settings { direct, antialiasing, ..all_in_use() };
    let reflected = |roughness: f32, reflections, limit: f32| {
        let scene = stage(&format!("albedo = [0.9, 0.9, 0.9], roughness = {roughness}, metallic = 1"), SKY);
        let effects =
            EffectSettings { denoise: Denoise::NONE, reflection_roughness: Some(limit), ..base.effects };
        let settings = Settings { reflections, effects, ..base.clone() };
        gpu.mean_of_frames(&scene, &settings, 48, |picture| layer(picture, "reflected"))
    };
    for (roughness, share) in [(0.45, 1.0), (0.55, 0.84375), (0.65, 0.15625), (0.75, 0.0)] {
        let ours = reflected(roughness, Reflections::Rays, 0.6);
        let (rays, irradiance) =
            (reflected(roughness, Reflections::Rays, 1.0), reflected(roughness, Reflections::None, 0.6));
        assert_ne!(rays, irradiance);
        let is_off = |&(at, i): &(usize, usize)| {
            let expected = share * rays[at][i] + (1.0 - share) * irradiance[at][i];
            (ours[at][i] - expected).abs() > 2e-3 * expected.max(0.1)
        };
        let off = (0..ours.len()).flat_map(|at| (0..3).map(move |i| (at, i))).filter(is_off).count();
        // Weights are rounded: now and then another VPL is chosen.
        assert!(off * 1000 <= 3 * ours.len(), "roughness {roughness}: {off} values are no blend");
    }
}

/// A pane, some of which is a metal, on the left before nothing and on the right before a mirror.
fn pane(roughness: f32) -> Arc<Scene> {
    let more = format!(
        r#"
[[models]]
name = "pane"
primitive = "quad"
size = [3, 1, 2.6]
material = {{ albedo = [0.7, 0.3, 0.1], roughness = {roughness}, metallic = 0.6 }}
[[materials]]
name = "pane"
transmission = 0.5
[[instances]]
model = "pane"
translation = [0, 1.3, -1.9]
rotation = [90, 0, 0]
{SKY}"#
    );
    let mut scene = (*stage("albedo = [0.8, 0.8, 0.8], roughness = 0, metallic = 1", &more)).clone();
    scene.instances[0].transform.translation.x += 6.3;
    // VPLs have the light of a sun without extent by way of a perfect mirror; a path tracer cannot find it.
    scene.lights.retain(|light| !matches!(light.kind, LightKind::Directional { .. }));
    Arc::new(scene)
}

#[test]
#[ignore = "long; a_sheet_before_a_mirror_tints_it_twice is quicker"]
fn panes_reflect_what_is_in_front_of_them() {
    let Some(gpu) = GpuFixture::open() else { return };
    for roughness in [0.0, 0.3, 0.6] {
        let scene = pane(roughness);
        let settings = Settings {
            size: SIZE,
            direct: Direct::Hard,
            antialiasing: Antialiasing::None,
            still_frames: 256,
            ..Settings::default()
        };
        let drawn = [0, 1].map(|seed| {
            let settings = Settings { seed, ..settings.clone() };
            gpu.rendered(&scene, &settings, 330).read_picture(true).unwrap().colour
        });
        let reference =
            reference(&format!("room-mirror-{roughness}"), &scene, SIZE, settings.bounces, 512).colour;
        for (what, columns) in [("nothing", 30..48), ("a mirror", 53..62)] {
            let of = |picture: &[[f32; 3]]| {
                let place = |at: &usize| columns.contains(&(at % 96)) && (18..30).contains(&(at / 96));
                mean((0..picture.len()).filter(place).map(|at| luminance(&picture[at])))
            };
            let ratio = mean(drawn.iter().map(|picture| of(picture))) / of(&reference);
            eprintln!("roughness {roughness} before {what}: {} of {}", ratio, of(&reference));
            assert!((ratio - 1.0).abs() < 0.03, "roughness {roughness} before {what}: {ratio}");
        }
    }
}
