//! Budget, order and fairness of replacement; immediate invalidation.

use glam::Vec3;
use glowworm::estimators::vpls::{SlotState, VplManager};
use glowworm::scene::Mesh;
use glowworm::settings::{Settings, VplSettings};

use crate::support::*;

fn sphere_with(light: glowworm::scene::Light) -> Stage {
    let mut scene = grey_scene(0.5);
    let mesh = Mesh::sphere("sphere", 2.0, 4, 0).turned_inside_out();
    place(&mut scene, mesh, Vec3::ZERO, false);
    scene.lights.push(light);
    Stage::new(scene)
}

#[test]
fn static_scene_never_shoots() {
    let mut scene = grey_scene(0.5);
    place(&mut scene, square(4.0), Vec3::ZERO, false);
    place(&mut scene, Mesh::cuboid("box", Vec3::ONE, 0), Vec3::new(0.0, 0.5, 0.0), true);
    scene.lights.push(point(1.0, Vec3::new(0.7, 1.5, 0.2)));
    let mut stage = Stage::new(scene);
    let settings = settings(512, 3);
    let mut manager = VplManager::new(stage.world(), &settings);
    let first = all_sets(&manager, &stage, &settings);
    for _ in 0..10 {
        let counters = stage.frame(&mut manager);
        assert_eq!((counters.shot, counters.invalidated), (0, 0));
        assert_eq!(all_sets(&manager, &stage, &settings), first);
    }
}

#[test]
fn in_still_frames_all_paths_go_on_and_then_return() {
    for (sets, budget) in [(4, 64), (1, 10), (6, 10)] {
        let mut stage = sphere_with(point(1.0, Vec3::new(0.3, 0.2, 0.1)));
        let vpl = VplSettings { budget, temporal_sets: sets, ..settings(96, 3).vpl };
        let settings = Settings { vpl, ..settings(96, 3) };
        let places = |manager: &VplManager| manager.slots().map(|slot| slot.position).collect::<Vec<_>>();
        let [mut manager, mut other] = [(); 2].map(|()| VplManager::new(stage.world(), &settings));
        let first = places(&manager);
        // 32 paths of 3 slots.
        let round = sets.max(32_u32.div_ceil(budget / 3));
        // One of them stood elsewhere before.
        stage.pose.lights[0].position.x += 0.1;
        stage.frame(&mut other);
        stage.pose.lights[0].position.x -= 0.1;
        while !other.is_fresh() {
            stage.frame(&mut other);
        }
        for still in 0..2 * round {
            let shot = [&mut manager, &mut other].map(|manager| {
                manager.invalidate(stage.world());
                manager.reshoot(stage.world(), still)
            });
            assert!(shot[0] == shot[1] && shot[0] <= budget);
            assert_eq!(places(&manager), places(&other), "still frame {still}");
            if still + 1 == round {
                let now = places(&manager);
                assert!(first.iter().zip(&now).all(|(first, now)| first != now), "a slot is as it was");
            }
        }
        assert!(!manager.is_fresh());
        for _ in 0..96_u32.div_ceil(budget) {
            assert!(!manager.is_fresh() && stage.frame(&mut manager).shot <= budget);
        }
        assert!(manager.is_fresh() && places(&manager) == first);
    }
}

#[test]
fn nothing_starves_while_the_light_keeps_moving() {
    for (vpls, bounces, budget) in [(96, 16, 1), (96, 16, 5), (100, 3, 7)] {
        let mut stage = sphere_with(point(1.0, Vec3::ZERO));
        let settings = Settings {
            vpl: VplSettings { budget, ..settings(vpls, bounces).vpl },
            ..settings(vpls, bounces)
        };
        let mut manager = VplManager::new(stage.world(), &settings);
        let mut last_change = vec![0; vpls as usize];
        let mut positions: Vec<Vec3> = manager.slots().map(|slot| slot.position).collect();
        // Slots that are shot again hit elsewhere, since their parent moved.
        let round = vpls.div_ceil(budget) + bounces;
        for frame in 1..=4 * round {
            let angle = frame as f32 * 0.05;
            stage.pose.lights[0].position = Vec3::new(angle.cos(), 0.3, angle.sin()) * 0.5;
            assert_eq!(stage.frame(&mut manager).shot, budget, "all of the budget is of use");
            for slot in manager.slots() {
                let (at, last) = (slot.slot as usize, slot.position);
                if positions[at] != last || slot.state == SlotState::Escaped {
                    last_change[at] = frame;
                }
                positions[at] = last;
                assert!(frame - last_change[at] <= round, "slot {at} starves");
            }
        }
    }
}

#[test]
fn no_shot_is_lost_once_the_world_stands_still() {
    for moving_frames in 1..20 {
        let mut stage = sphere_with(point(1.0, Vec3::ZERO));
        let settings =
            Settings { vpl: VplSettings { budget: 3, ..settings(80, 16).vpl }, ..settings(80, 16) };
        let mut manager = VplManager::new(stage.world(), &settings);
        for _ in 0..moving_frames {
            stage.pose.lights[0].position.x += 0.02;
            stage.frame(&mut manager);
        }
        let stale = |manager: &VplManager| manager.slots().filter(|slot| slot.stale).count();
        while stale(&manager) > 0 {
            let before = stale(&manager);
            let shot = stage.frame(&mut manager).shot as usize;
            assert!(shot > 0 && stale(&manager) + shot <= before);
        }
    }
}

#[test]
fn invalid_slots_come_first() {
    // A second light moves all the time; a plate drops into the first one's light.
    let mut scene = grey_scene(0.5);
    place(&mut scene, room(4.0), Vec3::ZERO, false);
    let plate = place(&mut scene, square(1.0), Vec3::new(0.0, -1.99, 0.0), true);
    scene.lights.push(point(1.0, Vec3::new(0.0, 0.5, 0.0)));
    let mut stage = Stage::new(scene);
    let settings = Settings { vpl: VplSettings { budget: 16, ..settings(512, 2).vpl }, ..settings(512, 2) };
    let mut manager = VplManager::new(stage.world(), &settings);
    stage.pose.lights[0].position.x = 0.01;
    stage.move_instance(plate, Vec3::new(0.0, 1.5, 0.0));
    let lost = stage.invalidate(&mut manager);
    assert!(lost > 16, "{lost}");
    let before: Vec<_> = manager.slots().collect();
    manager.replace(stage.world());
    // Only paths that held an invalid slot were touched.
    for (old, new) in before.iter().zip(manager.slots()) {
        let hurt = before.iter().any(|slot| slot.path == old.path && slot.state == SlotState::Invalid);
        assert!(hurt || (old.position, old.stale) == (new.position, new.stale));
    }
    while manager.counters().valid + manager.counters().escaped < 256 {
        let invalid = manager.slots().filter(|slot| slot.state == SlotState::Invalid).count();
        stage.frame(&mut manager);
        let left = manager.slots().filter(|slot| slot.state == SlotState::Invalid).count();
        assert!(left < invalid);
    }
}

#[test]
fn descendants_go_in_the_same_frame() {
    let mut scene = grey_scene(0.5);
    place(&mut scene, room(4.0), Vec3::ZERO, false);
    let lid = place(&mut scene, Mesh::cuboid("lid", Vec3::splat(0.2), 0), Vec3::splat(1.5), true);
    scene.lights.push(point(1.0, Vec3::ZERO));
    let mut stage = Stage::new(scene);
    let mut manager = VplManager::new(stage.world(), &settings(512, 4));
    // Shut the light up in the lid.
    stage.move_instance(lid, Vec3::splat(-1.5));
    assert_eq!(stage.invalidate(&mut manager), 512);
    assert_eq!(manager.counters().valid, 0);
    assert_eq!(total_flux(&manager), 0.0);
}

#[test]
fn plate_slides_out_from_under_its_vpls() {
    let mut scene = grey_scene(0.5);
    place(&mut scene, square(8.0), Vec3::ZERO, false);
    let plate = place(&mut scene, square(2.0), Vec3::new(0.0, 0.5, 0.0), true);
    scene.lights.push(spot(1.0, Vec3::new(0.0, 2.0, 0.0), Vec3::NEG_Y));
    let mut stage = Stage::new(scene);
    let settings = Settings { vpl: VplSettings { budget: 3, ..settings(128, 1).vpl }, ..settings(128, 1) };
    let mut manager = VplManager::new(stage.world(), &settings);
    assert!(manager.slots().all(|slot| (slot.position.y - 0.5).abs() < 1e-5));
    for frame in 1..80 {
        let slid = frame as f32 * 0.05;
        stage.move_instance(plate, Vec3::new(slid, 0.0, 0.0));
        stage.frame(&mut manager);
        for set in all_sets(&manager, &stage, &settings) {
            for vpl in set {
                // A ray offset above the surface.
                let p = vpl.position;
                let on_floor = p.y.abs() < 2e-4;
                let on_plate = (p.y - 0.5).abs() < 2e-4 && (p.x - slid).abs() < 1.0 + 2e-4;
                assert!(on_floor || on_plate, "{p} hangs in the air");
                // It is still lit.
                let to_vpl = (p - Vec3::new(0.0, 2.0, 0.0)).normalize();
                assert!(to_vpl.dot(Vec3::NEG_Y) > 0.6f32.cos() - 2e-4, "{p} in the dark");
            }
        }
    }
    assert!(manager.slots().all(|slot| slot.position.y.abs() < 1e-5), "all on the floor");
}

#[test]
fn spot_turned_away_loses_its_vpls_at_once() {
    let mut stage = sphere_with(spot(1.0, Vec3::ZERO, Vec3::NEG_Y));
    let mut manager = VplManager::new(stage.world(), &settings(200, 2));
    stage.pose.lights[0].direction = Vec3::Y;
    assert_eq!(stage.invalidate(&mut manager), 200);
    stage.pose.lights[0].direction = Vec3::NEG_Y;
    for _ in 0..4 {
        stage.frame(&mut manager);
    }
    assert_eq!(manager.counters().valid, 200);
}

#[test]
fn same_slot_same_spot() {
    // A plate passes through the light of a stationary light; afterwards all slots are as before.
    let mut scene = grey_scene(0.5);
    place(&mut scene, room(4.0), Vec3::ZERO, false);
    let plate = place(&mut scene, square(1.0), Vec3::new(0.0, -1.9, 0.0), true);
    scene.lights.push(point(1.0, Vec3::new(0.1, 0.5, 0.0)));
    let mut stage = Stage::new(scene);
    let settings = settings(256, 3);
    let mut manager = VplManager::new(stage.world(), &settings);
    let before: Vec<_> = manager.slots().collect();
    stage.move_instance(plate, Vec3::new(0.0, 2.0, 0.0));
    for _ in 0..4 {
        stage.frame(&mut manager);
    }
    assert_ne!(before, manager.slots().collect::<Vec<_>>());
    stage.move_instance(plate, Vec3::ZERO);
    for _ in 0..4 {
        stage.frame(&mut manager);
    }
    assert_eq!(before, manager.slots().collect::<Vec<_>>());
}

#[test]
fn change_of_power_alone_shoots_nothing() {
    let mut stage = sphere_with(point(1.0, Vec3::ZERO));
    let mut manager = VplManager::new(stage.world(), &settings(64, 2));
    let before = total_flux(&manager);
    stage.pose.lights[0] = point(2.5, Vec3::ZERO);
    let counters = stage.frame(&mut manager);
    assert_eq!((counters.shot, counters.invalidated), (0, 0));
    assert!((total_flux(&manager) / before - 2.5).abs() < 1e-5);
}
