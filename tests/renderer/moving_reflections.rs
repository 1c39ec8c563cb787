//! Reflections in motion: what moves, or goes, leaves no trail in mirrors, and they stay sharp.

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec3};
use glowworm::renderer::Renderer;
use glowworm::scene::{Pose, Scene};
use glowworm::settings::{Denoise, Settings};

use super::reflections::{FRAMES, colour, settings, ssim, stage};
use super::support::depth::all;
use super::support::{GpuFixture, layer, luminance, mean};

/// A box that crosses before a mirror, and the camera past it.
#[test]
fn in_motion_the_picture_is_like_the_reference() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = stage("albedo = [0.9, 0.9, 0.9], roughness = 0, metallic = 1", "");
    type Move = fn(&mut Pose, f32);
    let moves: [(&str, Move); 2] = [
        ("the camera", |pose, way| {
            pose.camera.eye.x += way;
            pose.camera.target.x += way;
        }),
        ("a box", |pose, way| {
            pose.instances[2] = Affine3A::from_translation(Vec3::X * way) * pose.instances[2]
        }),
    ];
    let settings = settings(Denoise::SVGF);
    for (what, moved) in moves {
        let at = |frame: u32| {
            let mut pose = scene.pose(0.0);
            moved(&mut pose, 0.03 * frame as f32);
            pose
        };
        let mut renderer = gpu.renderer(&scene, &settings, &at(0));
        let mut least: f64 = 1.0;
        for frame in 0..24 {
            renderer.render(&at(frame)).unwrap();
            // Each mean takes as long as 256 frames.
            if frame == 23 || all() && frame % 8 == 7 {
                let converged = mean_of_still_frames(&gpu, &scene, &settings, &at(frame), 4 * FRAMES);
                let ssim = ssim(&colour(&renderer), &colour(&converged));
                eprintln!("{what} moves, frame {frame}: SSIM {ssim}");
                least = least.min(ssim);
            }
        }
        assert!(least >= 0.95, "{what}: {least}");
    }
}

/// Stripes of shadow in a mirror: history is interpolated anew in every frame of motion, which blurs them, though no filter does.
#[test]
fn a_mirror_stays_sharp_while_the_camera_turns() {
    let Some(gpu) = GpuFixture::open() else { return };
    let mut bars = "[[models]]\nname = \"bar\"\nprimitive = \"box\"\nsize = [0.3, 0.1, 12]\n".to_owned();
    for x in 0..20 {
        bars += &format!("[[instances]]\nmodel = \"bar\"\ntranslation = [{}, 6, 3]\n", 0.6 * x as f32 - 6.0);
    }
    let scene = stage("albedo = [0.9, 0.9, 0.9], roughness = 0, metallic = 1", &bars);
    let at = |frame: u32| {
        let mut pose = scene.pose(0.0);
        let turn = Quat::from_rotation_y(0.5_f32.to_radians() * frame as f32);
        pose.camera.target = pose.camera.eye + turn * (pose.camera.target - pose.camera.eye);
        pose
    };
    let settings = settings(Denoise::SVGF);
    let mut renderer = gpu.renderer(&scene, &settings, &at(0));
    (0..24).for_each(|frame| renderer.render(&at(frame)).unwrap());
    // Mean square of the differences between neighbours.
    let contrast = |renderer: &Renderer| {
        let pixels = layer(&renderer.read_picture(true).unwrap(), "reflected");
        mean(pixels.windows(2).map(|pair| (luminance(&pair[1]) - luminance(&pair[0])).powi(2)))
    };
    let share = contrast(&renderer) / contrast(&still(&gpu, &scene, &settings, &at(23)));
    eprintln!("contrast: {share} of the still mirror's");
    assert!((0.62..1.1).contains(&share), "{share}");
}

/// What comes to rest in a pose.
fn still(gpu: &GpuFixture, scene: &Arc<Scene>, settings: &Settings, pose: &Pose) -> Renderer {
    mean_of_still_frames(gpu, scene, settings, pose, FRAMES)
}

fn mean_of_still_frames(
    gpu: &GpuFixture,
    scene: &Arc<Scene>,
    settings: &Settings,
    pose: &Pose,
    frames: u32,
) -> Renderer {
    let settings = Settings { still_frames: frames, ..settings.clone() };
    let mut renderer = gpu.renderer(scene, &settings, pose);
    (0..frames).for_each(|_| renderer.render(pose).unwrap());
    renderer
}

#[test]
#[ignore = "long; a_light_that_goes_leaves_the_mirror is quicker"]
fn a_box_that_moves_leaves_no_trail_in_the_mirror() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = stage("albedo = [0.9, 0.9, 0.9], roughness = 0, metallic = 1", "");
    let at = |frame: u32| {
        let mut pose = scene.pose(0.0);
        pose.instances[2] = Affine3A::from_translation(Vec3::X * 0.12 * frame as f32) * pose.instances[2];
        pose
    };
    let settings = settings(Denoise::SVGF);
    let mut renderer = gpu.renderer(&scene, &settings, &at(0));
    (0..=10).for_each(|frame| renderer.render(&at(frame)).unwrap());
    let reflected = |renderer: &Renderer| layer(&renderer.read_picture(true).unwrap(), "reflected");
    let ours = reflected(&renderer);
    let references: Vec<_> =
        (0..=10).step_by(2).map(|frame| reflected(&still(&gpu, &scene, &settings, &at(frame)))).collect();
    let reference = &references[5];
    let differs = |a: &[f32; 3], b: &[f32; 3]| (luminance(a) / luminance(b).max(1e-3) - 1.0).abs();
    // Where the mirror showed the box, but does no more, nor did two frames ago.
    let uncovered: Vec<usize> = (0..reference.len())
        .filter(|&at| luminance(&reference[at]) > 0.05 && differs(&references[4][at], &reference[at]) < 0.02)
        .filter(|&at| (0..4).any(|frame| differs(&references[frame][at], &reference[at]) > 0.3))
        .collect();
    assert!(uncovered.len() > 60, "{}", uncovered.len());
    let off = |at: &usize| luminance(&ours[*at]) / luminance(&reference[*at]) - 1.0;
    let (bias, error) = (mean(uncovered.iter().map(off)), mean(uncovered.iter().map(|at| off(at).abs())));
    eprintln!("{} pixels uncovered: off by {bias} in the mean, {error} each", uncovered.len());
    assert!(bias.abs() < 0.03 && error < 0.1, "{bias}, {error}");
}

#[test]
fn a_light_that_goes_leaves_the_mirror() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = stage("albedo = [0.9, 0.9, 0.9], roughness = 0.3, metallic = 1", "");
    let rest = scene.pose(0.0);
    let mut dark = rest.clone();
    dark.lights.remove(0);
    let of = |renderer: &Renderer| mean(colour(renderer).iter().map(luminance));
    let mut fresh = gpu.renderer(&scene, &settings(Denoise::SVGF), &dark);
    (0..FRAMES / 2).for_each(|_| fresh.render(&dark).unwrap());
    // One frame alone is a noisy measure.
    let after = mean((0..FRAMES / 2).map(|_| {
        fresh.render(&dark).unwrap();
        of(&fresh)
    }));
    let shares_left = |seed| {
        let mut renderer = gpu.rendered(&scene, &Settings { seed, ..settings(Denoise::SVGF) }, 24);
        let before = of(&renderer);
        [4, 16].map(|frames| {
            (0..frames).for_each(|_| renderer.render(&dark).unwrap());
            (of(&renderer) - after) / (before - after)
        })
    };
    let shares: Vec<[f32; 2]> = (1..=4).map(shares_left).collect();
    eprintln!("left after 4 and after 16 frames more: {shares:?}");
    for (at, most) in [(0, 0.05), (1, 0.01)] {
        let share = mean(shares.iter().map(|shares| shares[at]));
        assert!(share.abs() <= most, "{share} is left");
    }
}
