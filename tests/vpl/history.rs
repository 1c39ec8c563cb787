//! After any change ends, no history of it remains after ceil(slots / budget) frames.

use glam::{Affine3A, Quat, Vec3};
use glowworm::estimators::vpls::{SlotState, VplManager};
use glowworm::scene::{LightKind, Mesh};
use glowworm::settings::{Settings, VplSettings};

use crate::support::*;

const BOX: usize = 1;
const EMITTER: usize = 2;
const PILLAR: usize = 3;

/// A room without its ceiling: a moving box and light, a pillar, and lights of all four kinds.
pub fn open_room() -> Stage {
    let mut scene = grey_scene(0.7);
    let mut walls = square(6.0);
    for turn in 0..3 {
        let turn = Quat::from_rotation_y(turn as f32 * std::f32::consts::FRAC_PI_2);
        let corners = [[-3.0, 0.0], [3.0, 0.0], [3.0, 4.0], [-3.0, 4.0]];
        let corners = corners.map(|[x, y]| turn * Vec3::new(x, y, -3.0));
        walls.push_polygon(&corners, 0);
    }
    place(&mut scene, walls, Vec3::ZERO, false);
    place(&mut scene, Mesh::cuboid("box", Vec3::ONE, 0), Vec3::new(1.0, 0.6, 0.0), true);
    place(&mut scene, square(-0.8), Vec3::new(-1.0, 3.0, 0.5), true);
    let pillar = Mesh::cuboid("pillar", Vec3::new(0.4, 3.0, 0.4), 0);
    place(&mut scene, pillar, Vec3::new(-1.2, 1.6, -1.0), false);
    scene.lights.push(point(3.0, Vec3::new(0.3, 2.5, 0.2)));
    scene.lights.push(spot(30.0, Vec3::new(2.0, 3.0, 1.0), Vec3::new(-0.5, -1.0, -0.3)));
    scene.lights.push(directional(1.0, Vec3::new(0.3, -1.0, -0.4)));
    scene.lights.push(area(&scene, EMITTER, 4.0));
    Stage::new(scene)
}

/// Plays `change` for 20 frames, waits for the guaranteed number of frames, and compares with a fresh start.
pub fn assert_forgets(mut stage: Stage, mut change: impl FnMut(u32, &mut Stage)) {
    let mut touched = 0;
    for (vpls, bounces, budget, candidates) in
        [(300, 2, 32, 32), (301, 4, 7, 32), (64, 16, 1, 32), (400, 3, 25, 1)]
    {
        let settings = Settings {
            vpl: VplSettings { budget, candidates, ..settings(vpls, bounces).vpl },
            ..settings(vpls, bounces)
        };
        let rest = stage.pose.clone();
        let mut manager = VplManager::new(stage.world(), &settings);
        for frame in 0..20 {
            change(frame, &mut stage);
            let counters = stage.frame(&mut manager);
            assert!(counters.shot <= budget);
            assert_descendants_follow(&manager);
            touched += counters.shot + counters.invalidated;
        }
        for _ in 0..vpls.div_ceil(budget) {
            assert!(stage.frame(&mut manager).shot <= budget);
        }
        let fresh_stage = stage.fresh();
        let fresh = VplManager::new(fresh_stage.world(), &settings);
        for (slot, expected) in manager.slots().zip(fresh.slots()) {
            assert_eq!(slot.state, expected.state, "{slot:?} {expected:?}");
            assert!(!slot.stale && slot.state != SlotState::Invalid, "{slot:?}");
            if slot.state == SlotState::Valid {
                assert_eq!(slot, expected);
            }
        }
        assert_eq!(all_sets(&manager, &stage, &settings), all_sets(&fresh, &fresh_stage, &settings));
        // From now on the world is stationary.
        for _ in 0..3 {
            let counters = stage.frame(&mut manager);
            assert_eq!((counters.shot, counters.invalidated), (0, 0));
        }
        stage.pose = rest;
        stage = stage.fresh();
    }
    assert!(touched > 0, "the change must be felt");
}

#[test]
fn moved_lights() {
    for light in [0, 1] {
        assert_forgets(open_room(), |frame, stage| {
            stage.pose.lights[light].position.x += 0.05;
            stage.pose.lights[light].position.z -= 0.02 * frame as f32 / 20.0;
        });
    }
}

#[test]
fn turned_sun() {
    assert_forgets(open_room(), |_, stage| {
        let direction = &mut stage.pose.lights[2].direction;
        *direction = (Quat::from_rotation_z(0.02) * *direction).normalize();
    });
}

#[test]
fn moved_object() {
    assert_forgets(open_room(), |frame, stage| {
        let turn = Affine3A::from_rotation_y(0.1 * frame as f32);
        let rest = stage.scene.instances[BOX].transform;
        stage.pose.instances[BOX] = Affine3A::from_translation(Vec3::X * -0.08 * frame as f32) * rest * turn;
    });
}

#[test]
fn moved_light() {
    assert_forgets(open_room(), |frame, stage| {
        stage.move_instance(EMITTER, Vec3::new(0.05, 0.0, -0.05) * frame as f32);
    });
}

#[test]
fn object_that_comes_and_goes() {
    assert_forgets(open_room(), |frame, stage| {
        let height = if (5..15).contains(&frame) { 1.2 } else { 0.0 };
        stage.move_instance(BOX, Vec3::new(-0.7, height, 0.2) * f32::from(height > 0.0));
    });
}

#[test]
fn object_that_stays_in_the_light() {
    assert_forgets(open_room(), |frame, stage| {
        stage.move_instance(BOX, Vec3::new(-0.7, 0.06 * frame as f32, 0.2));
    });
}

#[test]
fn object_that_leaves_the_bounds() {
    assert_forgets(open_room(), |frame, stage| {
        stage.move_instance(BOX, Vec3::Y * frame as f32);
    });
}

#[test]
fn spot_that_turns_away_and_back() {
    assert_forgets(open_room(), |frame, stage| {
        let rest = stage.scene.lights[1].direction;
        let turn = Quat::from_rotation_x(std::f32::consts::PI * f32::from(frame.min(19 - frame) as u8) / 9.0);
        stage.pose.lights[1].direction = turn * rest;
    });
}

#[test]
fn moved_pillar_that_was_thought_static() {
    assert_forgets(open_room(), |frame, stage| {
        stage.move_instance(PILLAR, Vec3::new(0.1, 0.0, 0.03) * frame as f32);
    });
}

#[test]
fn changed_intensity() {
    assert_forgets(open_room(), |frame, stage| {
        stage.pose.lights[0].kind =
            LightKind::Point { intensity: Vec3::new(3.0, 2.0, 1.0) * (1.0 + frame as f32) };
    });
}

#[test]
fn lights_that_come_and_go() {
    assert_forgets(open_room(), |frame, stage| {
        let mut lights = stage.scene.lights.clone();
        if (3..12).contains(&frame) {
            lights.remove(1);
        }
        if frame > 7 {
            lights.push(point(9.0, Vec3::new(2.0, 1.0, -2.0)));
        }
        stage.pose.lights = lights;
    });
}

#[test]
fn everything_at_once() {
    assert_forgets(open_room(), |frame, stage| {
        let t = frame as f32 / 20.0;
        stage.move_instance(BOX, Vec3::new(-2.0 * t, 0.5 * t, t));
        stage.move_instance(EMITTER, Vec3::new(2.0 * t, -t, 0.0));
        stage.pose.lights[0].position = Vec3::new(0.3 - t, 2.5, 0.2 + t);
        stage.pose.lights[1].direction = Vec3::new(-0.5 + t, -1.0, -0.3).normalize();
        stage.pose.lights[2].direction = Vec3::new(0.3, -1.0, -0.4 + t).normalize();
    });
}
