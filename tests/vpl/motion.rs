//! Smooth motion, and independence of scale.

use glam::{Affine3A, Quat, Vec3};
use glowworm::estimators::vpls::{SlotState, SlotView, VplManager};
use glowworm::scene::{Camera, Light, LightKind, Mesh};
use glowworm::settings::{Settings, VplSettings};

use crate::support::*;

/// Moves a light by small steps, shoots everything again each time, and returns the distance that each slot's VPL of
/// `bounce` moved in each step.
fn steps(mut stage: Stage, bounces: u32, bounce: u32, change: impl Fn(u32, &mut Light)) -> Vec<f32> {
    let settings =
        Settings { vpl: VplSettings { budget: 512, ..settings(512, bounces).vpl }, ..settings(512, bounces) };
    let mut manager = VplManager::new(stage.world(), &settings);
    let mut distances = Vec::new();
    for step in 0..50 {
        let before: Vec<SlotView> = manager.slots().collect();
        change(step, &mut stage.pose.lights[0]);
        stage.frame(&mut manager);
        for (old, new) in before.iter().zip(manager.slots()) {
            let both = [old.state, new.state] == [SlotState::Valid; 2];
            if both && new.bounce == bounce {
                distances.push(old.position.distance(new.position));
            }
        }
    }
    distances.sort_by(f32::total_cmp);
    distances
}

fn inside_sphere(light: Light) -> Stage {
    let mut scene = grey_scene(0.5);
    let mesh = Mesh::sphere("sphere", 2.0, 5, 0).turned_inside_out();
    place(&mut scene, mesh, Vec3::ZERO, false);
    scene.lights.push(light);
    Stage::new(scene)
}

#[test]
fn first_vpls_follow_a_moving_light() {
    let distances = steps(inside_sphere(point(1.0, Vec3::ZERO)), 1, 1, |_, light| {
        light.position.x += 0.01;
    });
    assert_eq!(distances.len(), 512 * 50);
    // At most 1.0 off the centre of a sphere of radius 2, no VPL moves more than a few times faster than the light.
    assert!(distances[distances.len() - 1] < 0.04, "{:?}", distances.last());
}

#[test]
fn first_vpls_follow_a_turning_spot() {
    let turn = |_, light: &mut Light| {
        let turned = Quat::from_rotation_y(0.005) * Quat::from_rotation_x(0.004) * light.direction;
        light.direction = turned.normalize();
    };
    let distances = steps(inside_sphere(spot(1.0, Vec3::ZERO, Vec3::NEG_Y)), 1, 1, turn);
    assert!(distances[distances.len() - 1] < 0.05, "{:?}", distances.last());
}

#[test]
fn second_vpls_follow_too() {
    let distances = steps(inside_sphere(point(1.0, Vec3::ZERO)), 2, 2, |_, light| {
        light.position.y += 0.005;
    });
    let nearly_all = distances[distances.len() * 97 / 100];
    assert!(nearly_all < 0.1, "{nearly_all}");
    assert!(distances[distances.len() / 2] < 0.02);
}

#[test]
fn vpls_on_a_plane_follow() {
    let mut scene = grey_scene(0.5);
    place(&mut scene, square(100.0), Vec3::ZERO, false);
    scene.lights.push(spot(1.0, Vec3::new(0.0, 3.0, 0.0), Vec3::NEG_Y));
    let distances = steps(Stage::new(scene), 1, 1, |_, light| {
        light.position += Vec3::new(0.02, 0.0, 0.01);
    });
    let step = Vec3::new(0.02, 0.0, 0.01).length();
    assert!(distances.iter().all(|distance| (distance - step).abs() < 1e-3));
}

#[test]
fn vpls_ride_on_their_object() {
    let mut scene = grey_scene(0.5);
    let floor = place(&mut scene, square(2.0), Vec3::ZERO, true);
    scene.lights.push(directional(1.0, Vec3::NEG_Y));
    let mut stage = Stage::new(scene);
    let settings = Settings { vpl: VplSettings { budget: 1, ..settings(200, 1).vpl }, ..settings(200, 1) };
    let manager = VplManager::new(stage.world(), &settings);
    let before = all_sets(&manager, &stage, &settings);
    stage.move_instance(floor, Vec3::new(0.0, 0.25, 0.0));
    let after = all_sets(&manager, &stage, &settings);
    for (old, new) in before.iter().zip(&after) {
        assert_eq!(old.len(), new.len());
        for (old, new) in old.iter().zip(new.iter()) {
            assert!(new.position.distance(old.position + Vec3::Y * 0.25) < 1e-5);
        }
    }
}

/// A furnished room with all kinds of lights, `scale` times as large, its irradiances the same.
fn scaled(scale: f32) -> Stage {
    let mut scene = grey_scene(0.6);
    let at = |x, y, z| Vec3::new(x, y, z) * scale;
    place(&mut scene, square(6.0 * scale), Vec3::ZERO, false);
    place(&mut scene, Mesh::cuboid("wall", at(6.0, 3.0, 0.1), 0), at(0.0, 1.5, -3.0), false);
    place(&mut scene, Mesh::sphere("ball", 0.5 * scale, 3, 0), at(1.0, 0.6, 0.0), true);
    let emitter = place(&mut scene, square(-0.8 * scale), at(-1.0, 3.0, 0.5), true);
    let power = scale * scale;
    scene.lights.push(point(3.0 * power, at(0.3, 2.5, 0.2)));
    scene.lights.push(spot(30.0 * power, at(2.0, 3.0, 1.0), Vec3::new(-0.5, -1.0, -0.3)));
    scene.lights.push(directional(1.0, Vec3::new(0.3, -1.0, -0.4)));
    scene.lights.push(area(&scene, emitter, 4.0));
    scene.camera = Camera::looking(at(2.5, 2.0, 4.0), at(0.0, 0.5, 0.0));
    Stage::new(scene)
}

fn play(mut stage: Stage, scale: f32, settings: &Settings) -> Vec<SlotView> {
    let mut manager = VplManager::new(stage.world(), settings);
    for frame in 1..=10 {
        stage.move_instance(2, Vec3::new(-0.1, 0.02, 0.05) * frame as f32 * scale);
        stage.pose.lights[0].position.z += 0.03 * scale;
        stage.frame(&mut manager);
    }
    manager.slots().collect()
}

#[test]
fn scale_changes_nothing() {
    let [chosen, thrown] = [settings(512, 3), without_choice(settings(512, 3))];
    for (scale, settings) in [
        (1.0 / 128.0, &chosen),
        (128.0, &chosen),
        (1.0 / 128.0, &thrown),
        (0.01, &thrown),
        (0.3, &thrown),
        (100.0, &thrown),
    ] {
        let reference = play(scaled(1.0), 1.0, settings);
        let slots = play(scaled(scale), scale, settings);
        let mut differ = 0;
        for (slot, expected) in slots.iter().zip(&reference) {
            assert_eq!(slot.light, expected.light);
            let same = slot.state == expected.state
                && (slot.state != SlotState::Valid
                    || ((slot.position / scale).distance(expected.position) < 1e-2
                        && (slot.flux / (scale * scale) - expected.flux).abs().max_element()
                            < 1e-3 * expected.flux.max_element()));
            differ += u32::from(!same);
        }
        // Powers of two round alike; otherwise a ray that grazes an edge may hit or miss.
        let exact = scale.log2().fract() == 0.0;
        assert!(differ <= if exact { 0 } else { 5 }, "{scale}: {differ} of 512 slots differ");
    }
}

#[test]
fn mirrored_and_stretched_instances_are_lit_on_the_side_that_is_hit() {
    let mut scene = grey_scene(0.5);
    let ball = Mesh::sphere("ball", 1.0, 4, 0).turned_inside_out();
    let instance = place(&mut scene, ball, Vec3::ZERO, false);
    scene.instances[instance].transform = Affine3A::from_scale(Vec3::new(-1.0, 2.0, 0.5));
    scene.lights.push(point(1.0, Vec3::ZERO));
    let shell = place(&mut scene, square(0.2), Vec3::ZERO, false);
    scene.instances[shell].transform = Affine3A::from_scale(Vec3::new(1.0, -1.0, 1.0))
        * Affine3A::from_translation(Vec3::new(0.0, -0.2, 0.0));
    scene.lights.push(Light {
        kind: match area(&scene, shell, 1.0).kind {
            LightKind::Area { instance, triangles } => LightKind::Area { instance, triangles },
            other => other,
        },
        ..point(1.0, Vec3::ZERO)
    });
    let stage = Stage::new(scene);
    let manager = VplManager::new(stage.world(), &settings(400, 2));
    assert!(manager.counters().escaped < 8, "{:?}", manager.counters());
    for slot in manager.slots().filter(|slot| slot.state == SlotState::Valid) {
        if slot.bounce == 0 {
            assert_eq!(slot.normal, Vec3::NEG_Y, "the mirrored light shines down");
        } else if slot.position.y.abs() > 0.3 {
            let outward = slot.position / Vec3::new(1.0, 4.0, 0.25);
            assert!(slot.normal.dot(-outward.normalize()) > 0.99, "{slot:?}");
        }
    }
}
