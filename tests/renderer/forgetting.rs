//! After any change has ended, the picture is what a fresh start would have shown.

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec3};
use glowworm::scene::{Pose, Scene};
use glowworm::settings::{Settings, VplSettings};

use super::support::{GpuFixture, indirect, luminance, mean, plain, relative_differences, scene};

const ROOM: &str = r#"
[[models]]
name = "room"
primitive = "box"
size = [4, 3, 4]
material = { albedo = [0.7, 0.6, 0.5] }
[[models]]
name = "block"
primitive = "box"
size = [0.8, 0.8, 0.8]
material = { albedo = [0.2, 0.4, 0.8] }
[[instances]]
model = "room"
[[instances]]
name = "block"
model = "block"
translation = [0.5, -1.0, -0.5]
dynamic = true
[[lights]]
type = "point"
position = [-0.5, 0.8, 0.3]
intensity = [5, 5, 5]
[[lights]]
type = "spot"
position = [1.0, 1.2, 1.0]
direction = [-0.3, -1, -0.3]
intensity = [9, 8, 7]
inner_deg = 15
outer_deg = 25
[camera]
eye = [0, 0, 1.9]
target = [0, -0.2, 0]
vfov_deg = 75
"#;

/// Moves by `change` (0 to 1 and on) for 20 frames, waits as long as the renderer may take to forget, and
/// compares with a fresh start.
fn check(change: impl Fn(&mut Pose, f32)) {
    check_in(&scene(ROOM), change);
}

/// [`check`] in another scene.
pub(super) fn check_in(scene: &Arc<Scene>, change: impl Fn(&mut Pose, f32)) {
    let Some(gpu) = GpuFixture::open() else { return };
    let settings = Settings {
        size: [80, 60],
        vpl: VplSettings {
            slots: 200,
            temporal_sets: 8,
            budget: 32,
            // Every VPL is gathered: nothing is random.
            interleave: 1,
            pool: 200,
            clamp: 0.0,
            // History of earlier cycles is tested below.
            longest_history: 0,
            ..VplSettings::default()
        },
        ..plain()
    };
    let pose_at = |time: f32| {
        let mut pose = scene.pose(0.0);
        change(&mut pose, time);
        pose
    };
    let mut renderer = gpu.renderer(scene, &settings, &pose_at(0.0));
    for frame in 0..20 {
        renderer.render(&pose_at(frame as f32 / 19.0)).unwrap();
    }
    let end = pose_at(1.0);
    for _ in 0..settings.vpl.slots.div_ceil(settings.vpl.budget) + settings.vpl.temporal_sets {
        renderer.render(&end).unwrap();
    }
    let mut fresh = gpu.renderer(scene, &settings, &end);
    for _ in 0..settings.vpl.temporal_sets {
        fresh.render(&end).unwrap();
    }
    let (average, worst) = relative_differences(&indirect(&renderer), &indirect(&fresh));
    assert!(average < 1e-4 && worst < 2e-3, "differs by {average} in the mean, {worst} at most");
    for report in renderer.finish().unwrap() {
        assert!(report.figures.counters.get("vpls.shot") <= 32, "frame {} broke the budget", report.frame);
    }
}

#[test]
fn a_moved_light_is_forgotten() {
    check(|pose, time| pose.lights[0].position += Vec3::new(1.2, -0.6, -0.8) * time);
}

#[test]
fn a_moved_object_is_forgotten() {
    check(|pose, time| {
        let turn = Affine3A::from_rotation_translation(
            Quat::from_rotation_y(time),
            Vec3::new(-1.5, 0.7, 0.9) * time,
        );
        pose.instances[1] = turn * pose.instances[1];
    });
}

#[test]
fn a_spot_that_turns_away_and_back_is_forgotten() {
    check(|pose, time| {
        let angle = 1.5 * (time * std::f32::consts::PI).sin();
        pose.lights[1].direction = Quat::from_rotation_x(angle) * pose.lights[1].direction;
    });
}

#[test]
fn a_changed_intensity_is_forgotten() {
    check(|pose, time| {
        if let glowworm::scene::LightKind::Point { intensity } = &mut pose.lights[0].kind {
            *intensity *= 1.0 + 2.0 * time;
        }
    });
}

#[test]
fn a_light_that_goes_is_forgotten() {
    check(|pose, time| {
        if time > 0.5 {
            pose.lights.remove(0);
        }
    });
}

#[test]
fn a_light_that_comes_counts_in_full() {
    check(|pose, time| {
        if time > 0.5 {
            let mut copy = pose.lights[1].clone();
            copy.name = "copy".to_owned();
            copy.position.x -= 1.5;
            pose.lights.push(copy);
        }
    });
}

#[test]
fn a_light_of_another_kind_is_another_light() {
    check(|pose, time| {
        if time > 0.5 {
            let irradiance = Vec3::splat(3.0);
            pose.lights[1].kind = glowworm::scene::LightKind::Directional { irradiance };
        }
    });
}

#[test]
fn a_static_object_moved_by_hand_is_forgotten() {
    check(|pose, time| {
        pose.instances[0] = Affine3A::from_translation(Vec3::new(0.1, 0.0, 0.0) * time) * pose.instances[0];
    });
}

/// A light that jumps drags no tail of 16 frames: default settings, over 8 x 8 blocks against a fresh start.
#[test]
fn a_light_that_jumps_is_shown_at_once() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene: Arc<Scene> = scene(ROOM);
    let settings = Settings { size: [96, 72], ..plain() };
    let rest = scene.pose(0.0);
    let mut after = rest.clone();
    after.lights[0].position = Vec3::new(1.2, -0.6, -1.2);
    after.lights[1].direction = Vec3::new(-1.0, -0.2, -0.6).normalize();
    let fresh = {
        // In the second cycle, whose random numbers the other one has, too.
        let mut renderer = gpu.renderer(&scene, &settings, &after);
        for _ in 0..2 * settings.vpl.temporal_sets {
            renderer.render(&after).unwrap();
        }
        blocks(&indirect(&renderer))
    };
    let mut renderer = gpu.renderer(&scene, &settings, &rest);
    for _ in 0..settings.vpl.temporal_sets {
        renderer.render(&rest).unwrap();
    }
    let stale = difference(&blocks(&indirect(&renderer)), &fresh);
    let mut after_frames = Vec::new();
    for _ in 0..settings.vpl.temporal_sets {
        renderer.render(&after).unwrap();
        after_frames.push(difference(&blocks(&indirect(&renderer)), &fresh));
    }
    eprintln!("{stale} before, then {after_frames:?}");
    assert!(stale > 0.2, "{stale}");
    // Without weights, three quarters of the stale light would be left after 4 frames, half after 8. The rest is noise: half of
    // the slots are not yet shot after 4.
    assert!(after_frames[3] <= 0.4 * stale, "{after_frames:?}");
    assert!(after_frames[7] <= 0.15 * stale, "{after_frames:?}");
    assert!(after_frames[15] <= 0.025, "{after_frames:?}");
}

/// History of earlier cycles lags by no more than a cycle, wherever an object has moved or a light has gone.
#[test]
fn a_jump_is_shown_after_one_round_of_turns() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene: Arc<Scene> = scene(ROOM);
    // Every VPL is gathered: nothing is random.
    let (slots, temporal_sets) = (200, 8);
    let vpl = VplSettings {
        slots,
        temporal_sets,
        budget: slots,
        interleave: 1,
        pool: slots,
        clamp: 0.0,
        ..Default::default()
    };
    assert!(vpl.longest_history > 0);
    let settings = Settings { size: [96, 64], vpl, ..plain() };
    let rest = scene.pose(0.0);
    let [mut moved, mut dark] = [rest.clone(), rest.clone()];
    moved.instances[1] = Affine3A::from_translation(Vec3::new(-1.2, 0.9, 0.8)) * moved.instances[1];
    dark.lights.remove(1);
    for after in [moved, dark] {
        let mut renderer = gpu.renderer(&scene, &settings, &rest);
        for _ in 0..6 * temporal_sets {
            renderer.render(&rest).unwrap();
        }
        for _ in 0..temporal_sets + 2 {
            renderer.render(&after).unwrap();
        }
        let mut fresh = gpu.renderer(&scene, &settings, &after);
        for _ in 0..temporal_sets {
            fresh.render(&after).unwrap();
        }
        let [ours, expected] = [&renderer, &fresh].map(|renderer| blocks(&indirect(renderer)));
        let worst = ours.iter().zip(&expected).map(|(ours, expected)| (ours / expected - 1.0).abs());
        let worst = worst.fold(0.0, f32::max);
        assert!(worst < 0.05, "a block of 8 x 8 pixels is off by {worst}");
    }
}

/// Mean luminance of blocks of 8 x 8 pixels of a picture 96 pixels wide.
fn blocks(picture: &[[f32; 3]]) -> Vec<f32> {
    let mut sums = vec![0.0; picture.len() / 64];
    for (index, pixel) in picture.iter().enumerate() {
        sums[index / 96 / 8 * 12 + index % 96 / 8] += luminance(pixel) / 64.0;
    }
    sums
}

/// Mean relative difference.
fn difference(ours: &[f32], expected: &[f32]) -> f32 {
    mean(ours.iter().zip(expected).map(|(ours, expected)| (ours / expected - 1.0).abs()))
}
