//! Thin surfaces that move: which VPLs are invalid or stale, and that none remembers.

use glam::{Quat, Vec3};
use glowworm::estimators::vpls::{SlotState, SlotView, VplManager};
use glowworm::scene::{Material, Mesh};

use crate::history::{assert_forgets, open_room};
use crate::support::*;

/// A closed room with a lamp, and a pane of this material that stands outside.
fn pane_outside(material: Material) -> (Stage, usize) {
    let mut scene = grey_scene(0.7);
    scene.materials.push(material);
    place(&mut scene, room(4.0), Vec3::ZERO, false);
    let mesh = Mesh::cuboid("pane", Vec3::new(2.0, 0.01, 2.0), 1);
    let pane = place(&mut scene, mesh, Vec3::Y * 3.0, true);
    scene.lights.push(point(3.0, Vec3::ZERO));
    (Stage::new(scene), pane)
}

#[test]
fn what_a_dark_pane_covers_is_invalid_and_behind_a_light_one_stale() {
    let settings = without_choice(settings(1024, 1));
    for (tint, invalidates) in [(0.0, true), (0.3, true), (0.9, false)] {
        // Light passes both sides of the pane.
        let (mut stage, moved) = pane_outside(pane(Vec3::splat(tint)));
        let mut manager = VplManager::new(stage.world(), &settings);
        stage.move_instance(moved, Vec3::Y * -4.0);
        stage.invalidate(&mut manager);
        let shade = |slot: &SlotView| slot.position.normalize().dot(Vec3::NEG_Y) > 0.8;
        let counters = manager.counters();
        assert_eq!(counters.invalidated_by.occluded, counters.invalidated);
        if invalidates {
            assert!(counters.invalidated > 80, "{counters:?}");
            assert!(manager.slots().all(|slot| slot.state == SlotState::Invalid || !shade(&slot)));
        } else {
            assert_eq!(counters.invalidated, 0);
            assert!(counters.stale > 80, "{counters:?}");
            assert!(manager.slots().all(|slot| slot.stale || !shade(&slot)));
        }
        assert!(manager.slots().all(|slot| slot.position.y < 0.0 || !slot.stale), "nothing changes above");
    }
}

#[test]
fn a_pane_that_moves_elsewhere_changes_nothing() {
    let (mut stage, moved) = pane_outside(pane(Vec3::new(0.5, 0.7, 0.9)));
    let mut manager = VplManager::new(stage.world(), &without_choice(settings(512, 2)));
    stage.move_instance(moved, Vec3::new(0.1, -0.3, 0.0));
    let counters = stage.frame(&mut manager);
    assert_eq!((counters.invalidated, counters.stale, counters.shot), (0, 0, 0));
}

#[test]
fn a_pane_that_cannot_be_seen_changes_nothing() {
    // It comes between the lamp and a veil, which still stops the same paths.
    let (stage, moved) = pane_outside(veil(0.0, 0.5));
    let mut scene = stage.scene;
    scene.materials.push(veil(0.5, 0.5));
    place(&mut scene, Mesh::cuboid("veil", Vec3::splat(3.9), 2), Vec3::ZERO, false);
    let mut stage = Stage::new(scene);
    let mut manager = VplManager::new(stage.world(), &without_choice(settings(512, 2)));
    for height in [-4.0, -0.5] {
        stage.move_instance(moved, Vec3::Y * height);
        let counters = stage.frame(&mut manager);
        assert_eq!((counters.invalidated, counters.stale, counters.shot), (0, 0, 0));
    }
}

/// An open room with panes of coated glass, a veil and two tinted panes side by side.
fn glazed_room() -> Stage {
    let mut stage = open_room();
    let scene = &mut stage.scene;
    let glass =
        Material { roughness: 0.1, f0: Vec3::splat(0.04), f90: 1.0, ..pane(Vec3::new(0.9, 0.8, 0.7)) };
    let stained = |tint| Material { transmission: 0.8, ..Material::lambertian("stained", tint) };
    let red = stained(Vec3::new(0.9, 0.6, 0.6));
    scene.materials.extend([glass, veil(0.4, 0.6), red, stained(Vec3::splat(0.5))]);
    for (material, (at, dynamic)) in (1..).zip([
        (Vec3::new(0.3, 1.6, 0.2), true),
        (Vec3::new(-0.5, 2.0, 0.8), false),
        (Vec3::new(1.4, 2.0, 0.0), true),
        (Vec3::new(1.6, 2.0, 0.0), true),
    ]) {
        let mut thin_surface = square(1.5);
        thin_surface.triangle_materials.fill(material);
        let turn = Quat::from_rotation_z(if material > 2 { 1.5 } else { 0.2 });
        thin_surface.positions.iter_mut().chain(&mut thin_surface.normals).for_each(|v| *v = turn * *v);
        place(scene, thin_surface, at, dynamic);
    }
    Stage::new(stage.scene)
}

/// The first pane of [`glazed_room`].
const PANE: usize = 4;
/// To a corner below the missing ceiling: the bounds of the scene stay the same.
const AWAY: Vec3 = Vec3::new(1.8, 1.8, -1.8);

#[test]
fn moved_pane_is_forgotten() {
    assert_forgets(glazed_room(), |frame, stage| {
        stage.move_instance(PANE, Vec3::new(0.06, -0.03, 0.04) * frame as f32);
    });
}

#[test]
fn pane_that_comes_and_goes_is_forgotten() {
    for pane in [PANE, PANE + 1] {
        assert_forgets(glazed_room(), |frame, stage| {
            stage.move_instance(pane, if (5..12).contains(&frame) { Vec3::ZERO } else { AWAY });
        });
    }
}

#[test]
fn pane_that_comes_and_stays_is_forgotten() {
    assert_forgets(glazed_room(), |frame, stage| {
        stage.move_instance(PANE, if frame < 19 { AWAY } else { Vec3::ZERO });
    });
}

#[test]
fn panes_that_change_places_are_forgotten() {
    // Light behind both is as bright as before, but passes or stops elsewhere.
    assert_forgets(glazed_room(), |frame, stage| {
        let by = Vec3::X * if frame % 2 == 0 { 0.2 } else { 0.0 };
        stage.move_instance(PANE + 2, by);
        stage.move_instance(PANE + 3, -by);
        if frame == 19 {
            stage.move_instance(PANE + 2, Vec3::X * 0.2);
            stage.move_instance(PANE + 3, Vec3::X * -0.2);
        }
    });
}

#[test]
fn lamp_that_moves_behind_panes_is_forgotten() {
    assert_forgets(glazed_room(), |frame, stage| {
        stage.pose.lights[0].position.x += 0.05;
        stage.move_instance(PANE, Vec3::X * -0.02 * frame as f32);
    });
}

#[test]
fn panes_that_move_at_random_are_forgotten() {
    for seed in 0..4 {
        let mut random = Random(seed);
        assert_forgets(glazed_room(), |_, stage| {
            for pane in PANE..PANE + 4 {
                let rest = stage.scene.instances[pane].transform.translation;
                let place = Vec3::new(random.unit(), random.unit(), random.unit());
                let place = Vec3::new(-2.0, 0.9, -2.0) + place * Vec3::new(4.0, 2.2, 4.0);
                if random.unit() < 0.3 {
                    stage.move_instance(pane, place - Vec3::from(rest));
                }
            }
        });
    }
}
