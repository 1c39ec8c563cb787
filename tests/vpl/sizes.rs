//! All sizes and mixes of lights that the settings allow.

use glam::Vec3;
use glowworm::estimators::vpls::{SlotState, VplManager};
use glowworm::settings::{Settings, VplSettings};

use crate::depth::quick_or_all;
use crate::support::*;

/// A room lit by the kinds of light that the bits of `mix` name.
fn lit_room(mix: u32) -> Stage {
    let mut scene = grey_scene(0.5);
    place(&mut scene, room(4.0), Vec3::ZERO, false);
    let emitter = place(&mut scene, square(-1.0), Vec3::new(0.0, 1.5, 0.0), true);
    let all = [
        point(1.0, Vec3::ZERO),
        spot(40.0, Vec3::Y, Vec3::NEG_Y),
        directional(0.5, Vec3::NEG_Y),
        area(&scene, emitter, 5.0),
    ];
    for (bit, light) in all.into_iter().enumerate() {
        if mix >> bit & 1 == 1 {
            scene.lights.push(light);
        }
    }
    Stage::new(scene)
}

#[test]
fn every_small_number_of_slots() {
    for (index, mix) in (0..).zip([1, 8, 9, 6, 15]) {
        let mut stage = lit_room(mix);
        // A third of the numbers for each mix, another third for the next.
        let step = quick_or_all(3, 1);
        for vpls in (1 + index % step..=70).step_by(step as usize) {
            for bounces in [1, 2, 3, 16] {
                let settings = Settings {
                    vpl: VplSettings {
                        temporal_sets: 64.min(vpls),
                        interleave: 1 + vpls % 8,
                        budget: 1 + vpls % 5,
                        ..settings(vpls, bounces).vpl
                    },
                    ..settings(vpls, bounces)
                };
                stage.pose.lights[0].position = Vec3::ZERO;
                let mut manager = VplManager::new(stage.world(), &settings);
                let all_used = |manager: &VplManager| {
                    let mut slots = manager.slots();
                    slots.all(|slot| slot.state != SlotState::Invalid && slot.light.is_some())
                };
                assert!(all_used(&manager), "{mix} {vpls} {bounces}");
                assert_eq!(manager.counters().slots, vpls);
                stage.pose.lights[0].position.x += 0.01;
                let frames = vpls.div_ceil(settings.vpl.budget);
                for _ in 0..frames {
                    assert!(stage.frame(&mut manager).shot <= settings.vpl.budget);
                }
                assert!(all_used(&manager), "{mix} {vpls} {bounces}");
                assert_eq!(stage.frame(&mut manager).shot, 0);
                let sets = all_sets(&manager, &stage, &settings);
                let valid: usize = sets.iter().map(Vec::len).sum();
                assert!(valid as u32 <= manager.counters().valid);
            }
        }
    }
}

#[test]
fn most_slots() {
    let mut stage = lit_room(15);
    for bounces in [1, 16] {
        let settings = Settings {
            vpl: VplSettings {
                temporal_sets: 64,
                interleave: 8,
                budget: 4096,
                ..settings(65_536, bounces).vpl
            },
            ..settings(65_536, bounces)
        };
        let mut manager = VplManager::new(stage.world(), &settings);
        let counters = manager.counters();
        assert_eq!(counters.valid + counters.escaped, 65_536);
        stage.pose.lights[0].position.x += 0.01;
        for _ in 0..16 {
            assert!(stage.frame(&mut manager).shot <= 4096);
        }
        assert_eq!(stage.frame(&mut manager).shot, 0);
    }
}

#[test]
fn without_light_there_is_nothing() {
    let mut dark = lit_room(15);
    for light in &mut dark.pose.lights {
        match &mut light.kind {
            glowworm::scene::LightKind::Point { intensity }
            | glowworm::scene::LightKind::Spot { intensity, .. } => *intensity = Vec3::ZERO,
            glowworm::scene::LightKind::Directional { irradiance } => *irradiance = Vec3::ZERO,
            glowworm::scene::LightKind::Area { triangles, .. } => {
                triangles.iter_mut().for_each(|triangle| triangle.radiance = Vec3::ZERO);
            }
        }
    }
    for mut stage in [lit_room(0), dark] {
        let settings = settings(64, 2);
        let mut manager = VplManager::new(stage.world(), &settings);
        for _ in 0..3 {
            let counters = stage.frame(&mut manager);
            assert_eq!((counters.valid, counters.escaped, counters.shot), (0, 0, 0));
            assert_eq!(total_flux(&manager), 0.0);
            let sets = all_sets(&manager, &stage, &settings);
            assert!(sets.iter().all(Vec::is_empty));
        }
        // The lights are switched on again.
        stage.pose.lights = vec![point(1.0, Vec3::ZERO)];
        for _ in 0..2 {
            stage.frame(&mut manager);
        }
        assert_eq!(manager.counters().valid, 64);
    }
}

#[test]
fn light_without_power_gets_no_path() {
    let mut scene = grey_scene(0.5);
    place(&mut scene, room(4.0), Vec3::ZERO, false);
    scene.lights.push(point(0.0, Vec3::ZERO));
    scene.lights.push(point(1.0, Vec3::Y));
    let stage = Stage::new(scene);
    let manager = VplManager::new(stage.world(), &settings(64, 2));
    assert!(manager.slots().all(|slot| slot.light == Some(1)));
}

#[test]
fn empty_scene_lets_everything_escape() {
    let mut scene = grey_scene(0.5);
    scene.lights.push(point(1.0, Vec3::ZERO));
    scene.lights.push(directional(1.0, Vec3::NEG_Y));
    let mut stage = Stage::new(scene);
    let mut manager = VplManager::new(stage.world(), &without_choice(settings(64, 2)));
    stage.pose.lights[0].position.x = 1.0;
    let counters = stage.frame(&mut manager);
    assert_eq!((counters.escaped, counters.valid, counters.shot), (64, 0, 0));
}
