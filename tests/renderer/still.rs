//! A still picture converges to the reference, then freezes: the mean of all frames, whatever came before.

use std::sync::Arc;

use glam::{Affine3A, Vec3};
use glowworm::output::Picture;
use glowworm::renderer::{DebugView, Line, Renderer};
use glowworm::scene::{Pose, Scene};
use glowworm::settings::{
    Antialiasing, Denoise, Direct, EffectSettings, Indirect, Reflections, Settings, VplSettings,
};

use super::support::golden::reference;
use super::support::{GpuFixture, luminance, mean, named_scene, plain, scene};
use super::taa::BOXES;

const FRAMES: u32 = 24;

pub(super) fn settings() -> Settings {
    Settings {
        size: [48, 32],
        still_frames: FRAMES,
        vpl: VplSettings { slots: 96, pool: 1024, temporal_sets: 4, budget: 16, ..VplSettings::default() },
        ..Settings::default()
    }
}

/// Draws until the picture is frozen.
pub(super) fn frozen(renderer: &mut Renderer, pose: &Pose) -> Picture {
    for _ in 0..1000 {
        renderer.render(pose).unwrap();
        if renderer.is_frozen() {
            return renderer.read_picture(false).unwrap();
        }
    }
    panic!("the picture does not freeze");
}

/// Moves a light, a box and the camera.
fn moved(rest: &Pose, frame: u32) -> Pose {
    let mut pose = rest.clone();
    pose.lights[0].position.x -= 0.1 * (frame + 1) as f32;
    pose.instances[1] = Affine3A::from_translation(Vec3::X * 0.1 * frame as f32) * pose.instances[1];
    pose.camera.eye.y += 0.05;
    pose
}

fn check(settings: &Settings) {
    let scene =
        scene(&BOXES.replacen("albedo = [0.1, 0.2, 0.6]", "albedo = [0.1, 0.2, 0.6], roughness = 0.2", 1));
    check_stillness(&scene, settings);
}

/// The picture that freezes is the same whatever came before: motion of a light, of instance 1 and of the camera, rests, other settings.
pub(super) fn check_stillness(scene: &Arc<Scene>, settings: &Settings) {
    check_stillness_from(scene, settings, |rest| moved(rest, 4));
}

/// [`check_stillness`] with a renderer that is made for the pose `first` gives of the rest pose.
pub(super) fn check_stillness_from(scene: &Arc<Scene>, settings: &Settings, first: impl Fn(&Pose) -> Pose) {
    let Some(gpu) = GpuFixture::open() else { return };
    let rest = scene.pose(0.0);
    let expected = frozen(&mut gpu.renderer(scene, settings, &rest), &rest);
    assert!(expected.colour.iter().flatten().all(|channel| channel.is_finite() && *channel >= 0.0));
    // After motion, for numbers of frames that no round divides, with exposure on its way.
    for frames in [1, 7] {
        let mut renderer = gpu.renderer(scene, settings, &first(&rest));
        for frame in 0..frames {
            renderer.set_exposure_pace(0.1);
            renderer.render(&moved(&rest, frame)).unwrap();
        }
        renderer.set_exposure_pace(0.1);
        assert!(frozen(&mut renderer, &rest) == expected, "after {frames} frames of motion");
    }
    // After a rest, and another one that was broken off, seen by another camera with other settings.
    let mut renderer = gpu.renderer(scene, settings, &rest);
    frozen(&mut renderer, &rest);
    let other = Settings { seed: settings.seed + 1, bounces: 1, ..settings.clone() };
    renderer.set_settings(&other, &rest).unwrap();
    (0..FRAMES + 5).for_each(|_| renderer.render(&moved(&rest, 2)).unwrap());
    renderer.set_settings(settings, &rest).unwrap();
    assert!(frozen(&mut renderer, &rest) == expected, "after other settings");
}

#[test]
fn what_freezes_depends_on_no_past() {
    check(&settings());
}

#[test]
#[ignore = "long; what_freezes_depends_on_no_past is quicker"]
fn nor_with_one_set_and_a_small_budget() {
    let vpl = VplSettings { temporal_sets: 1, ..settings().vpl };
    check(&Settings { vpl, ..settings() });
}

#[test]
#[ignore = "long; what_freezes_depends_on_no_past is quicker"]
fn nor_with_six_sets_of_the_full_resolution() {
    let vpl = VplSettings { temporal_sets: 6, interleave: 1, ..settings().vpl };
    check(&Settings { vpl, antialiasing: Antialiasing::None, ..settings() });
}

#[test]
#[ignore = "long; what_freezes_depends_on_no_past is quicker"]
fn nor_with_soft_shadows_and_reflections() {
    check(&Settings { direct: Direct::Soft, reflections: Reflections::Rays, ..settings() });
}

#[test]
fn nor_without_indirect_light_and_denoisers() {
    let effects = EffectSettings { denoise: Denoise::NONE, ..settings().effects };
    check(&Settings { indirect: Indirect::NONE, effects, direct: Direct::Soft, ..settings() });
}

#[test]
fn a_frozen_frame_runs_nothing() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(BOXES);
    let pose = scene.pose(0.0);
    let mut renderer = gpu.renderer(&scene, &settings(), &pose);
    let picture = frozen(&mut renderer, &pose);
    for _ in 0..5 {
        renderer.render(&pose).unwrap();
        assert!(renderer.read_picture(false).unwrap() == picture);
    }
    for report in renderer.finish().unwrap() {
        let works = report.frame < u64::from(FRAMES);
        assert_eq!(u64::from(report.still), if works { report.frame + 1 } else { FRAMES.into() });
        assert_eq!(report.figures.passes["still"] > 0.0, works, "frame {}", report.frame);
        assert!(
            works || report.figures.total_ms == 0.0 && report.figures.passes.values().all(|ms| *ms == 0.0)
        );
    }

    // Lines over the picture and another exposure show in the next frame, and leave no trace.
    let shown = |renderer: &mut Renderer| {
        renderer.render(&pose).unwrap();
        assert!(renderer.is_frozen());
        renderer.read_display().unwrap()
    };
    let line = Line {
        from: Vec3::new(-1.0, 0.0, 1.0),
        to: Vec3::new(1.0, 0.5, 1.0),
        colour: [1.0; 4],
        width: 3.0,
        hidden: 1.0,
    };
    renderer.set_view(&DebugView { lines: vec![line], ..DebugView::default() }).unwrap();
    assert!(shown(&mut renderer) != picture.display);
    renderer.set_view(&DebugView::default()).unwrap();
    assert!(shown(&mut renderer) == picture.display);
    renderer.set_settings(&Settings { exposure: Some(2.0), ..settings() }, &pose).unwrap();
    assert!(shown(&mut renderer) != picture.display);
    renderer.set_settings(&settings(), &pose).unwrap();
    assert!(shown(&mut renderer) == picture.display);

    // A view shows frames as they are; then the mean begins anew.
    renderer.set_view(&DebugView { buffer: "normal".into(), ..DebugView::default() }).unwrap();
    renderer.render(&pose).unwrap();
    assert!(!renderer.is_frozen() && renderer.read_display().unwrap() != picture.display);
    renderer.set_view(&DebugView::default()).unwrap();
    assert!(frozen(&mut renderer, &pose) == picture);
}

/// Root of the mean square of the relative errors of luminance, and the ratio of the means.
fn error(ours: &[[f32; 3]], expected: &[[f32; 3]]) -> (f32, f32) {
    let [ours, expected] = [ours, expected].map(|pixels| pixels.iter().map(luminance).collect::<Vec<_>>());
    let all = mean(expected.iter().copied());
    let squares = ours.iter().zip(&expected).map(|(a, b)| ((a - b) / (b + 0.1 * all)).powi(2));
    (mean(squares).sqrt(), mean(ours.iter().copied()) / all)
}

fn check_truth(name: &str, scene: &Arc<Scene>, settings: &Settings) {
    let Some(gpu) = GpuFixture::open() else { return };
    let expected = reference(name, scene, settings.size, settings.bounces, 2048).colour;
    let errors = [16, 64, 256].map(|still_frames| {
        let renderer = gpu.rendered(scene, &Settings { still_frames, ..settings.clone() }, still_frames);
        error(&renderer.read_picture(false).unwrap().colour, &expected)
    });
    eprintln!("{errors:?}");
    assert!(errors[1].0 < 0.7 * errors[0].0 && errors[2].0 < 0.7 * errors[1].0, "{errors:?}");
    assert!((errors[2].1 - 1.0).abs() < 0.01, "{errors:?}");
}

#[test]
#[ignore = "long; few_still_frames_are_nearer_to_the_reference is quicker"]
fn the_mean_of_sets_is_that_of_the_path_tracer() {
    let settings = Settings { size: [48; 2], ..plain() };
    check_truth("cornell-box", &named_scene("cornell-box", None), &settings);
}

#[test]
fn the_mean_of_paths_nears_the_reference_as_frames_are_added() {
    let settings = Settings { size: [32; 2], indirect: Indirect::PATHS, ..plain() };
    check_truth("cornell-box", &named_scene("cornell-box", None), &settings);
}

#[test]
fn few_still_frames_are_nearer_to_the_reference_than_a_denoised_one() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("cornell-box", None);
    let settings = Settings { size: [48; 2], antialiasing: Antialiasing::None, ..Settings::default() };
    let expected = reference("cornell-box", &scene, settings.size, settings.bounces, 1024).colour;
    let [denoised, still] = [0, 1024].map(|still_frames| {
        let renderer = gpu.rendered(&scene, &Settings { still_frames, ..settings.clone() }, 32);
        error(&renderer.read_picture(false).unwrap().colour, &expected)
    });
    eprintln!("denoised {denoised:?}, still {still:?}");
    assert!(still.0 < 0.7 * denoised.0 && (still.1 - 1.0).abs() < 0.02, "{denoised:?}, {still:?}");
}

#[test]
fn a_light_with_few_paths_lights_all_pixels_alike() {
    let Some(gpu) = GpuFixture::open() else { return };
    // A candle far from a strong light gets so few paths that most sets have none.
    let scene = scene(&BOXES.replace(
        "[camera]",
        "[[lights]]\ntype = \"point\"\nposition = [-2.5, -1.5, -2.5]\nintensity = [0.02, 0.02, 0.02]\n[camera]",
    ));
    let vpl = VplSettings { slots: 64, pool: 64, ..VplSettings::default() };
    let settings = Settings { size: [32; 2], still_frames: 1024, vpl, ..plain() };
    let mut only_candle = scene.pose(0.0);
    // As weak as it is, it is all that there is to see.
    if let glowworm::scene::LightKind::Point { intensity } = &mut only_candle.lights[0].kind {
        *intensity = Vec3::splat(12.0);
    }
    only_candle.lights[0].position = Vec3::new(0.0, 500.0, 0.0);
    let mut renderer = gpu.renderer(&scene, &settings, &only_candle);
    (0..settings.still_frames).for_each(|_| renderer.render(&only_candle).unwrap());
    let picture = renderer.read_picture(false).unwrap().colour;
    let of_quarter = |quarter: usize| {
        let pixels =
            (0..16 * 16).map(|at| picture[(2 * (at / 16) + quarter / 2) * 32 + 2 * (at % 16) + quarter % 2]);
        mean(pixels.map(|pixel| luminance(&pixel)))
    };
    let means = [0, 1, 2, 3].map(of_quarter);
    eprintln!("{means:?}");
    let all = means.iter().sum::<f32>() / 4.0;
    assert!(all > 0.0 && means.iter().all(|mean| (mean / all - 1.0).abs() < 0.15), "{means:?}");
}

#[test]
fn nor_on_the_time_at_which_an_animation_pauses() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("playroom", None);
    let vpl = VplSettings { slots: 64, temporal_sets: 4, ..VplSettings::default() };
    let settings = Settings { size: [48, 30], still_frames: 8, vpl, ..Settings::default() };
    let at = |frame: u32| {
        let mut pose = scene.pose(f64::from(frame) / 30.0);
        let step = Vec3::new(0.011, 0.003, -0.001) * frame as f32;
        (pose.camera.eye, pose.camera.target) = (pose.camera.eye + step, pose.camera.target + step);
        pose
    };
    let paused = at(30);
    let expected = frozen(&mut gpu.renderer(&scene, &settings, &paused), &paused);
    // Made for another pose.
    assert!(frozen(&mut gpu.renderer(&scene, &settings, &at(0)), &paused) == expected, "from the start");
    let mut renderer = gpu.renderer(&scene, &settings, &at(0));
    (0..30).for_each(|frame| renderer.render(&at(frame)).unwrap());
    assert!(frozen(&mut renderer, &paused) == expected);
    // The window renders fewer pixels while anything moves.
    renderer.set_settings(&Settings { size: [24, 15], ..settings.clone() }, &paused).unwrap();
    (0..9).for_each(|frame| renderer.render(&at(frame)).unwrap());
    renderer.render(&paused).unwrap();
    renderer.set_settings(&settings, &paused).unwrap();
    assert!(frozen(&mut renderer, &paused) == expected, "after another size");
}
