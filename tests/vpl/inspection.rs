//! The manager's debug data: ages, reasons, paths; lights that are added and removed.

use glam::Vec3;
use glowworm::estimators::vpls::{
    Invalidation, InvalidationReason, SlotState, SlotView, VplCounters, VplManager,
};
use glowworm::scene::{Light, LightKind, Mesh};
use glowworm::settings::{Settings, VplSettings};

use crate::support::*;

/// A room with a spot that points down and a small plate high above the floor, outside of its cone.
fn room_with_plate() -> Stage {
    let mut scene = grey_scene(0.6);
    place(&mut scene, room(4.0), Vec3::ZERO, false);
    place(&mut scene, Mesh::cuboid("plate", Vec3::new(0.6, 0.05, 0.6), 0), Vec3::new(1.7, 1.0, 0.0), true);
    scene.lights.push(spot(5.0, Vec3::new(0.0, 1.8, 0.0), Vec3::NEG_Y));
    Stage::new(scene)
}

/// Plays one frame and returns its counters and the slots; checks that counts by reason add up.
fn frame(stage: &mut Stage, manager: &mut VplManager) -> (VplCounters, Vec<SlotView>) {
    let counters = stage.frame(manager);
    let by_reason: u32 = InvalidationReason::ALL.iter().map(|&reason| counters.invalidated_by[reason]).sum();
    assert_eq!(by_reason, counters.invalidated, "every invalidation has one reason");
    (counters, manager.slots().collect())
}

fn last_invalidation(manager: &VplManager, slot: &SlotView) -> Option<Invalidation> {
    manager.history(slot.slot).and_then(|history| history.invalidation)
}

/// The slots that became invalid in the manager's last frame for this reason.
fn became_invalid(manager: &VplManager, reason: InvalidationReason) -> Vec<SlotView> {
    let now = |slot: &SlotView| {
        last_invalidation(manager, slot)
            .is_some_and(|last| last.frame == manager.frame() && last.reason == reason)
    };
    manager.slots().filter(now).collect()
}

#[test]
fn a_spot_that_turns_away_is_the_reason() {
    let mut stage = room_with_plate();
    let mut manager = VplManager::new(stage.world(), &settings(256, 2));
    let before: Vec<SlotView> = manager.slots().collect();
    stage.pose.lights[0].direction = Vec3::X;
    let (counters, _) = frame(&mut stage, &mut manager);
    let lost = became_invalid(&manager, InvalidationReason::LightTurnedAway);
    assert_eq!(lost.len(), 128, "all first bounces");
    assert_eq!(counters.invalidated_by[InvalidationReason::LightTurnedAway], 128);
    assert_eq!(counters.invalidated_by[InvalidationReason::ParentInvalid], 128);
    for slot in lost {
        let last = last_invalidation(&manager, &slot).unwrap();
        assert_eq!(last.position, before[slot.slot as usize].position);
        assert_eq!(last.origin, Vec3::new(0.0, 1.8, 0.0));
    }
}

#[test]
fn what_comes_between_is_the_reason() {
    let mut stage = room_with_plate();
    let settings = Settings { vpl: VplSettings { budget: 8, ..settings(256, 2).vpl }, ..settings(256, 2) };
    let mut manager = VplManager::new(stage.world(), &settings);
    stage.move_instance(1, Vec3::new(-1.7, 0.0, 0.0));
    let (counters, _) = frame(&mut stage, &mut manager);
    assert!(counters.invalidated_by[InvalidationReason::Occluded] > 20, "{counters:?}");
    for slot in became_invalid(&manager, InvalidationReason::Occluded).iter().filter(|slot| slot.bounce == 1)
    {
        // Its path crosses the plate, which lies at height 1.
        let last = last_invalidation(&manager, slot).unwrap();
        let part = (last.origin.y - 1.0) / (last.origin.y - last.position.y);
        let crossing = last.origin.lerp(last.position, part);
        assert!(crossing.x.abs() < 0.35 && crossing.z.abs() < 0.35, "{crossing}");
    }
}

#[test]
fn ages_count_frames_since_the_shot() {
    let mut stage = room_with_plate();
    let settings = Settings { vpl: VplSettings { budget: 32, ..settings(256, 2).vpl }, ..settings(256, 2) };
    let mut manager = VplManager::new(stage.world(), &settings);
    let of_age = |manager: &VplManager, age| {
        manager.slots().filter(|slot| manager.history(slot.slot).unwrap().age == age).count()
    };
    for age in 1..=3 {
        frame(&mut stage, &mut manager);
        assert_eq!(of_age(&manager, age), 256);
    }
    stage.pose.lights[0].position.x += 0.1;
    let (counters, slots) = frame(&mut stage, &mut manager);
    assert_eq!(counters.shot, 32);
    assert_eq!(of_age(&manager, 0), 32);
    assert_eq!(of_age(&manager, 4) + counters.invalidated as usize, 224);
    assert_eq!(counters.stale as usize, slots.iter().filter(|slot| slot.stale).count());
    assert!(counters.stale >= 224 - counters.invalidated);
}

#[test]
fn paths_lead_from_the_light_to_the_slot() {
    let stage = room_with_plate();
    let manager = VplManager::new(stage.world(), &settings(300, 4));
    let slots: Vec<SlotView> = manager.slots().collect();
    for slot in slots.iter().filter(|slot| slot.state == SlotState::Valid) {
        let path = manager.path_to(slot.slot);
        assert_eq!(path.len() as u32, slot.bounce);
        assert_eq!(path.last(), Some(&slot.slot));
        assert_eq!(slots[path[0] as usize].origin, stage.pose.lights[0].position);
        for pair in path.windows(2) {
            assert_eq!(slots[pair[1] as usize].parent, Some(pair[0]));
            assert_eq!(slots[pair[1] as usize].origin, slots[pair[0] as usize].position);
        }
    }
}

fn two_lights() -> Stage {
    let mut scene = grey_scene(0.6);
    place(&mut scene, room(4.0), Vec3::ZERO, false);
    scene.lights.push(Light { name: "first".into(), ..point(1.0, Vec3::new(-1.0, 0.5, 0.0)) });
    scene.lights.push(Light { name: "second".into(), ..point(1.0, Vec3::new(1.0, 0.5, 0.3)) });
    Stage::new(scene)
}

#[test]
fn the_other_lights_keep_their_vpls_when_one_goes() {
    let mut stage = two_lights();
    let mut manager = VplManager::new(
        stage.world(),
        &Settings { vpl: VplSettings { budget: 16, ..settings(256, 2).vpl }, ..settings(256, 2) },
    );
    let positions = |manager: &VplManager, light| -> Vec<Vec3> {
        let of_light = manager.slots().filter(|slot| slot.light == Some(light) && slot.flux != Vec3::ZERO);
        of_light.map(|slot| slot.position).collect()
    };
    let before = positions(&manager, 1);
    stage.pose.lights.remove(0);
    let counters = stage.frame(&mut manager);
    let after = positions(&manager, 0);
    let kept = before.iter().filter(|position| after.contains(position)).count();
    assert!(kept + 16 >= before.len(), "{kept} of {} are left, {counters:?}", before.len());
    assert_eq!(counters.invalidated_by[InvalidationReason::NoSlot], 128, "those of the light that went");
}

#[test]
fn lights_that_come_go_and_change_kind_are_forgotten() {
    let changes: [fn(&mut Vec<Light>); 5] = [
        |lights| drop(lights.remove(0)),
        |lights| lights.push(spot(4.0, Vec3::new(0.0, 1.5, 0.0), Vec3::NEG_Y)),
        |lights| lights.insert(0, point(2.0, Vec3::new(0.3, 1.5, 0.0))),
        |lights| lights[1].kind = LightKind::Directional { irradiance: Vec3::ONE },
        Vec::clear,
    ];
    for (index, change) in changes.into_iter().enumerate() {
        let mut stage = two_lights();
        let settings =
            Settings { vpl: VplSettings { budget: 50, ..settings(300, 3).vpl }, ..settings(300, 3) };
        let mut manager = VplManager::new(stage.world(), &settings);
        stage.frame(&mut manager);
        change(&mut stage.pose.lights);
        for _ in 0..300u32.div_ceil(50) {
            stage.frame(&mut manager);
        }
        assert_eq!(manager.counters().stale, 0);
        let fresh = VplManager::new(stage.world(), &settings);
        let sets = |manager: &VplManager| all_sets(manager, &stage, &settings);
        assert_eq!(sets(&manager), sets(&fresh), "change {index}");
    }
}
