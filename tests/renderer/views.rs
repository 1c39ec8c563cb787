//! Each view shows its buffer: compared with the layers of the same frame, or with the CPU's rays.

use std::sync::Arc;

use glam::{Affine3A, Vec2, Vec3};
use glowworm::estimators;
use glowworm::estimators::vpls::{SHARE_COLOURS, STALENESS, SlotState, VplDebugView};
use glowworm::output::{Picture, Tones, tone_map};
use glowworm::passes::effect_view::VIEWS;
use glowworm::renderer::{DebugView, Renderer};
use glowworm::scene::{Camera, Pose, Scene};
use glowworm::settings::{
    CellSettings, Direct, Indirect, PathFilter, PathSettings, Reflections, Settings, ToneMap, VplSettings,
};

use super::support::{GpuFixture, channel, inspect, layer, mean, plain, scene, set_counts, vpls};

pub const STUDIO: &str = r#"
[[models]]
name = "room"
primitive = "box"
size = [4, 3, 4]
material = { albedo = [0.7, 0.6, 0.5] }
[[models]]
name = "block"
primitive = "box"
size = [0.8, 0.8, 0.8]
material = { albedo = [0.2, 0.4, 0.8], roughness = 0.35 }
[[instances]]
model = "room"
[[instances]]
name = "block"
model = "block"
translation = [0.5, -0.9, 0.2]
dynamic = true
[[instances]]
name = "second block"
model = "block"
translation = [-1.2, -1.1, -0.8]
[[lights]]
type = "point"
position = [-0.5, 1.0, 0.3]
intensity = [5, 5, 5]
[camera]
eye = [0, 0, 1.9]
target = [0, -0.3, 0]
vfov_deg = 70
"#;

/// The studio with blocks that are metallic in part, and glow.
fn glowing() -> String {
    STUDIO.replace("roughness = 0.35", "roughness = 0.35, metallic = 0.5, emission = [0.2, 0.1, 0.05]")
}

const SIDE: u32 = 64;

pub fn settings(temporal_sets: u32, interleave: u32) -> Settings {
    let size = [SIDE, SIDE];
    Settings {
        size,
        exposure: Some(0.0),
        vpl: VplSettings { temporal_sets, interleave, slots: 128, pool: 128, ..VplSettings::default() },
        ..plain()
    }
}

pub fn view(buffer: &'static str) -> DebugView {
    DebugView { buffer: buffer.into(), ..DebugView::default() }
}

fn of_set(buffer: &'static str, set: u32) -> DebugView {
    view(buffer).with_options(&VplDebugView { set, ..VplDebugView::default() })
}

fn single(buffer: &'static str, single_vpl: Option<u32>) -> DebugView {
    view(buffer).with_options(&VplDebugView { single_vpl, ..VplDebugView::default() })
}

/// Stands still for all sets; then the camera and the block move a little, and the picture is what the view
/// makes of that frame.
fn picture(
    gpu: &GpuFixture,
    scene: &Arc<Scene>,
    settings: &Settings,
    view: &DebugView,
) -> (Renderer, Picture) {
    let rest = scene.pose(0.0);
    let mut renderer = gpu.renderer(scene, settings, &rest);
    for _ in 0..settings.vpl.temporal_sets {
        renderer.render(&rest).unwrap();
    }
    renderer.set_view(view).unwrap();
    renderer.render(&moved(&rest)).unwrap();
    let picture = renderer.read_picture(true).unwrap();
    (renderer, picture)
}

fn moved(rest: &Pose) -> Pose {
    let mut pose = rest.clone();
    let shift = Vec3::new(0.05, 0.02, 0.0);
    pose.camera = Camera { eye: rest.camera.eye + shift, target: rest.camera.target + shift, ..rest.camera };
    pose.instances[1] = Affine3A::from_translation(Vec3::new(-0.05, 0.0, 0.05)) * pose.instances[1];
    pose
}

/// Asserts that all but `outliers` of the pixels are as expected to within `tolerance` of 255.
#[track_caller]
fn assert_shows(what: &str, picture: &Picture, expected: &[Vec3], tolerance: f32, outliers: f32) {
    let worst = |(shown, expected): (&[u8; 4], &Vec3)| {
        let shown = Vec3::new(f32::from(shown[0]), f32::from(shown[1]), f32::from(shown[2]));
        (shown - expected.clamp(Vec3::ZERO, Vec3::ONE) * 255.0).abs().max_element()
    };
    let wrong = picture.display.iter().zip(expected).map(worst).filter(|worst| *worst > tolerance).count();
    let share = wrong as f32 / expected.len() as f32;
    assert!(share <= outliers, "{what}: {share} of the pixels differ");
    // A view of nothing would be easy to get right.
    assert!(expected.iter().any(|pixel| *pixel != Vec3::ZERO), "{what}: everything is black");
}

fn encode(x: Vec3) -> Vec3 {
    let curve = |x: f32| if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    Vec3::new(curve(x.x), curve(x.y), curve(x.z))
}

/// Radiance as it is shown without exposure.
fn toned(picture: &Picture, radiance: Vec<Vec3>) -> Vec<Vec3> {
    let mut picture = Picture {
        colour: radiance.iter().map(Vec3::to_array).collect(),
        layers: Vec::new(),
        ..picture.clone()
    };
    let tones = Tones { exposure: Some(0.0), curve: ToneMap::Aces };
    tone_map(&mut picture, tones, std::iter::repeat(1.0));
    let value = |pixel: &[u8; 4]| Vec3::new(f32::from(pixel[0]), f32::from(pixel[1]), f32::from(pixel[2]));
    picture.display.iter().map(|pixel| value(pixel) / 255.0).collect()
}

fn vectors(picture: &Picture, name: &str) -> Vec<Vec3> {
    layer(picture, name).into_iter().map(Vec3::from).collect()
}

fn number_colour(number: f32) -> Vec3 {
    let hue = (number * 0.618_034).fract();
    let value = |shift: f32| 0.55 + 0.45 * (std::f32::consts::TAU * (hue + shift / 3.0)).cos();
    Vec3::new(value(0.0), value(1.0), value(2.0))
}

/// The image that a view should show, from the layers of its picture; none where these do not tell.
fn expected(view: &str, picture: &Picture) -> Option<Vec<Vec3>> {
    let map = |name: &str, to: &dyn Fn(Vec3) -> Vec3| vectors(picture, name).into_iter().map(to).collect();
    let times = |a: Vec<Vec3>, b: Vec<Vec3>| a.into_iter().zip(b).map(|(a, b)| a * b).collect::<Vec<_>>();
    let per_pi = |e: Vec3| e / std::f32::consts::PI;
    let of_layer = |name: &str, index: usize| {
        let layer = picture.layers.iter().find(|layer| layer.name == name).unwrap();
        layer.channels[index].1.clone()
    };
    Some(match view {
        "combined" => toned(picture, picture.colour.iter().copied().map(Vec3::from).collect()),
        "direct" => toned(picture, vectors(picture, "direct")),
        "irradiance" => toned(picture, map("indirect", &per_pi)),
        "indirect" => toned(picture, times(vectors(picture, "albedo"), map("indirect", &per_pi))),
        "position" => map("position", &|p| (p + Vec3::new(2.0, 1.5, 2.0)) / Vec3::new(4.0, 3.0, 4.0)),
        "normal" => map("normal", &|n| n * 0.5 + 0.5),
        "albedo" => map("albedo", &encode),
        "reflectance" => map("reflectance", &encode),
        "base-colour" => map("base_colour", &encode),
        "metallic" => of_layer("base_colour", 3).into_iter().map(Vec3::splat).collect(),
        "emission" => toned(picture, vectors(picture, "emission")),
        "roughness" => of_layer("reflectance", 3).into_iter().map(Vec3::splat).collect(),
        "instance" => channel(picture, "instance").into_iter().map(number_colour).collect(),
        "motion" => of_layer("motion", 0)
            .into_iter()
            .zip(of_layer("motion", 1))
            .map(|(x, y)| {
                let share = Vec2::new(x, y) * SIDE as f32 / 16.0;
                (share.signum() * share.abs().map(f32::sqrt) * 0.5 + 0.5).extend(0.5)
            })
            .collect(),
        "depth" => {
            // The eye is within the room: nearest is the near plane, farthest a corner.
            let camera = moved(&super::support::scene(STUDIO).pose(0.0)).camera;
            let half = Vec3::new(2.0, 1.5, 2.0).dot(camera.forward().abs());
            let farthest = half - camera.eye.dot(camera.forward());
            let share = |depth: f32| (farthest - depth) / (farthest - camera.near);
            channel(picture, "depth").into_iter().map(|depth| Vec3::splat(share(depth))).collect()
        }
        _ => return None,
    })
}

#[test]
fn views_of_layers_show_them() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(&glowing());
    let mut checked = 0;
    for buffer in estimators::views().map(|view| view.name) {
        let (_, picture) = picture(&gpu, &scene, &settings(2, 2), &view(buffer));
        let Some(expected) = expected(buffer, &picture) else { continue };
        assert_shows(buffer, &picture, &expected, 1.5, 0.0);
        checked += 1;
    }
    assert_eq!(checked, 15);
}

/// The settings with the method that has this view.
fn with_method_of(buffer: &str, settings: Settings) -> Settings {
    let mut methods = estimators::methods().iter();
    let method = methods.find(|method| method.views.iter().any(|view| view.name == buffer));
    Settings { indirect: method.map_or(settings.indirect, |method| method.indirect), ..settings }
}

#[test]
fn every_view_shows_something_of_its_own() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(&glowing());
    let mut seen: Vec<(&str, Vec<[u8; 4]>)> = Vec::new();
    for buffer in estimators::views().map(|view| view.name) {
        // Two methods may show the same view.
        if seen.iter().any(|(known, _)| *known == buffer) {
            continue;
        }
        let view = of_set(buffer, 1);
        // Views of effects, which come last, show effects in use.
        let is_effect = VIEWS.iter().any(|view| view.name == buffer);
        let settings = if is_effect {
            Settings { direct: Direct::Soft, reflections: Reflections::Rays, ..settings(4, 2) }
        } else {
            // A map of few cells, so that some are found by probing.
            let cells = CellSettings { capacity: 1024, life: 2, ..CellSettings::default() };
            let paths = PathSettings { filter: PathFilter::Nhpsf, ..PathSettings::default() };
            let settings = with_method_of(buffer, settings(4, 2));
            if settings.indirect == Indirect::PATHS {
                Settings { paths, cells, ..settings }
            } else {
                settings
            }
        };
        let (renderer, picture) = picture(&gpu, &scene, &settings, &view);
        assert_eq!(renderer.view(), &view);
        if buffer != "vpl-visibility" {
            let same = seen.iter().find(|(_, display)| *display == picture.display);
            assert!(same.is_none(), "{buffer:?} looks like {:?}", same.map(|(buffer, _)| buffer));
        }
        seen.push((buffer, picture.display));
    }
}

#[test]
fn one_set_without_interleaving_is_the_irradiance_in_all_its_views() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(STUDIO);
    let rest = scene.pose(0.0);
    let mut renderer = gpu.renderer(&scene, &settings(1, 1), &rest);
    for buffer in ["unfiltered", "filtered", "set-buffer", "set-reprojected"] {
        renderer.set_view(&view(buffer)).unwrap();
        renderer.render(&rest).unwrap();
        let picture = renderer.read_picture(true).unwrap();
        let expected = expected("irradiance", &picture).unwrap();
        assert_shows(buffer, &picture, &expected, 1.5, 0.0);
    }
}

#[test]
fn rejected_pixels_are_those_that_are_not_counted() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(STUDIO);
    const SETS: u32 = 4;
    let mut counted = vec![0; (SIDE * SIDE) as usize];
    let mut by_renderer = Vec::new();
    for set in 0..SETS {
        let view = of_set("set-reprojected", set);
        let (renderer, picture) = picture(&gpu, &scene, &settings(SETS, 1), &view);
        by_renderer = set_counts(&gpu, &renderer);
        for (count, pixel) in counted.iter_mut().zip(&picture.display) {
            *count += u32::from(pixel[..3] != [255, 0, 255]);
        }
    }
    assert_eq!(counted, by_renderer);
    let rejected = counted.iter().filter(|count| **count < SETS).count();
    assert!(rejected > 20, "only {rejected} pixels lack a set");

    // The view of the counts has one colour for each.
    let (_, picture) = picture(&gpu, &scene, &settings(SETS, 1), &view("set-count"));
    let colour_of = |count: u32| {
        let of_count = |(pixel, of): (&[u8; 4], &u32)| (*of == count).then_some(*pixel);
        let mut colours: Vec<_> = picture.display.iter().zip(&counted).filter_map(of_count).collect();
        colours.dedup();
        assert!(colours.len() <= 1, "{count} sets: {colours:?}");
        colours.first().copied()
    };
    assert!(colour_of(SETS).is_some() && colour_of(SETS) != colour_of(1));
}

#[test]
fn staleness_counts_the_frames_since_the_turns_of_the_sets() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(STUDIO);
    let rest = scene.pose(0.0);
    // Ages of the sets after so many frames, and of the turns that they are the mean of.
    for (sets, longest_history, frames, age) in
        [(1, 0, 3, 0.0), (4, 0, 2, 0.5), (4, 0, 9, 1.5), (4, 8, 8, 1.5 + 2.0), (4, 8, 12, 1.5 + 4.0)]
    {
        let mut settings = settings(sets, 1);
        settings.vpl.longest_history = longest_history;
        let mut renderer = gpu.renderer(&scene, &settings, &rest);
        renderer.set_view(&view(STALENESS)).unwrap();
        for _ in 0..frames {
            renderer.render(&rest).unwrap();
        }
        let thirds = (3.0 * age / sets as f32).min(2.999);
        let [low, high] = [0, 1].map(|next| Vec3::from(SHARE_COLOURS[thirds as usize + next]));
        let expected = low.lerp(high, thirds.fract()) * 255.0;
        let picture = renderer.read_picture(false).unwrap();
        let differs = |pixel: &&[u8; 4]| {
            let [r, g, b, _] = pixel.map(f32::from);
            (Vec3::new(r, g, b) - expected).abs().max_element() > 1.5
        };
        let wrong = picture.display.iter().find(differs);
        assert_eq!(wrong, None, "{sets} sets, history {longest_history}, frame {frames}: not {expected}");
    }
}

#[test]
fn a_single_vpl_lights_what_it_sees() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(STUDIO);
    let pose = scene.pose(0.0);
    let mut renderer = gpu.rendered(&scene, &settings(4, 2), 4);
    let valid = vpls(&renderer).slots().filter(|slot| slot.state == SlotState::Valid);
    let slots: Vec<u32> = valid.map(|slot| slot.slot).step_by(37).collect();
    assert!(slots.len() >= 3);
    for slot in slots {
        let single_vpl = Some(slot);
        let weight = vpls(&renderer).counters().valid as f32;
        let mut found = (Vec::new(), Vec::new());
        for y in 0..SIDE {
            for x in 0..SIDE {
                let picked = renderer.pick(&pose, Vec2::new(x as f32, y as f32) + 0.5).unwrap();
                let of_slot = inspect(&renderer, &pose, &picked.surface);
                let light = of_slot.into_iter().find(|light| light.slot == slot && light.visible);
                found.0.push(light.map_or(Vec3::ZERO, |light| light.irradiance * weight));
                found.1.push(Vec3::splat(if light.is_some() { 1.0 } else { 0.0 }));
            }
        }
        renderer.set_view(&single("irradiance", single_vpl)).unwrap();
        renderer.render(&pose).unwrap();
        let picture = renderer.read_picture(true).unwrap();
        let radiance = found.0.iter().map(|e| *e / std::f32::consts::PI).collect();
        assert_shows("its irradiance", &picture, &toned(&picture, radiance), 2.5, 0.01);

        // Visibility alone asks nobody which way surfaces face: it may be white where no light falls.
        renderer.set_view(&single("vpl-visibility", single_vpl)).unwrap();
        renderer.render(&pose).unwrap();
        let picture = renderer.read_picture(true).unwrap();
        let black = picture.display.iter().zip(&found.1).filter(|(pixel, lit)| pixel[0] == 0 && lit.x > 0.0);
        assert!(black.count() <= 40, "lit, but not seen");
    }
}

#[test]
fn what_the_inspector_lists_adds_up_to_the_picture() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(STUDIO);
    let pose = scene.pose(0.0);
    for clamp in [0.0, 400.0] {
        let renderer = gpu.rendered(
            &scene,
            &Settings { vpl: VplSettings { clamp, ..settings(1, 1).vpl }, ..settings(1, 1) },
            1,
        );
        let indirect = vectors(&renderer.read_picture(true).unwrap(), "indirect");
        let mut differences = Vec::new();
        for (index, expected) in indirect.iter().enumerate().step_by(7) {
            let (x, y) = (index as u32 % SIDE, index as u32 / SIDE);
            let picked = renderer.pick(&pose, Vec2::new(x as f32, y as f32) + 0.5).unwrap();
            let listed = inspect(&renderer, &pose, &picked.surface);
            let sum: Vec3 = listed.iter().filter(|vpl| vpl.visible).map(|vpl| vpl.irradiance).sum();
            // Short rays add what the bound takes away.
            let difference = if clamp > 0.0 { sum - *expected } else { (sum - *expected).abs() };
            differences.push(difference.max_element() / expected.max_element());
        }
        assert!(differences.len() > 500);
        let off = differences.iter().filter(|difference| **difference > 2e-3).count();
        assert!(off * 50 <= differences.len(), "{off} of {} points differ", differences.len());
        assert!(mean(differences) < 2e-3);
    }
}

#[test]
fn the_default_view_changes_no_bit() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(STUDIO);
    let pose = scene.pose(0.0);
    let plain = gpu.rendered(&scene, &settings(4, 2), 6).read_picture(true).unwrap();
    let mut renderer = gpu.renderer(&scene, &settings(4, 2), &pose);
    for frame in 0..6 {
        let buffer = if frame == 2 { "normal" } else { "combined" };
        renderer.set_view(&view(buffer)).unwrap();
        renderer.render(&pose).unwrap();
    }
    assert!(renderer.read_picture(true).unwrap() == plain);
}
