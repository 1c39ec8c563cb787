//! Placement: VPLs lie where the camera profits, and the mean stays that of all light paths.

use glam::Vec3;
use glowworm::estimators::vpls::{SlotState, VplManager};
use glowworm::scene::{Camera, Environment, Mesh, WorldSurface, luminance};
use glowworm::settings::{Settings, VplSettings};

use crate::support::*;

const FAR: f32 = 60.0;

/// A court of 4 m without a roof on a wide ground, under a sun; the camera stands in the court.
fn court() -> Stage {
    let mut scene = grey_scene(0.6);
    place(&mut scene, square(FAR), Vec3::ZERO, false);
    for (at, size) in [
        (Vec3::new(2.1, 1.5, 0.0), Vec3::new(0.2, 3.0, 4.4)),
        (Vec3::new(-2.1, 1.5, 0.0), Vec3::new(0.2, 3.0, 4.4)),
        (Vec3::new(0.0, 1.5, 2.1), Vec3::new(4.4, 3.0, 0.2)),
        (Vec3::new(0.0, 1.5, -2.1), Vec3::new(4.4, 3.0, 0.2)),
    ] {
        place(&mut scene, Mesh::cuboid("wall", size, 0), at, false);
    }
    scene.lights.push(directional(1.0, Vec3::new(0.5, -1.0, 0.3)));
    scene.camera = Camera::looking(Vec3::new(-1.5, 1.5, -1.5), Vec3::new(1.0, 1.0, 1.0));
    Stage::new(scene)
}

/// The scene under a grey sky.
fn court_under_a_sky() -> Stage {
    let mut scene = court().scene;
    scene.lights.clear();
    scene.environment = Some(Environment::constant(Vec3::ONE));
    Stage::new(scene)
}

fn manager(stage: &Stage, candidates: u32, seed: u32) -> VplManager {
    let vpl = VplSettings { candidates, ..settings(4096, 2).vpl };
    VplManager::new(stage.world(), &Settings { seed, vpl, ..settings(4096, 2) })
}

/// A point on the wall in front of the camera, and what lights it.
fn wall() -> WorldSurface {
    let normal = Vec3::NEG_X;
    WorldSurface { position: Vec3::new(2.0, 1.2, 0.4), geometric_normal: normal, normal, ray_offset: 1e-4 }
}

/// Irradiance of the wall, and the number of VPLs that it sees.
fn seen(stage: &Stage, manager: &VplManager) -> (f32, usize) {
    let all = manager.inspect(stage.world(), &wall(), 0.0);
    let visible = all.iter().filter(|one| one.visible);
    (visible.clone().map(|one| luminance(one.irradiance)).sum(), visible.count())
}

#[test]
fn the_camera_sees_more_vpls_and_the_same_light() {
    check_placement(&court());
    check_placement(&court_under_a_sky());
}

fn check_placement(stage: &Stage) {
    const SEEDS: u32 = 12;
    let of = |candidates| {
        let runs: Vec<_> = (0..SEEDS).map(|seed| seen(stage, &manager(stage, candidates, seed))).collect();
        (runs.iter().map(|run| run.0).sum::<f32>(), runs.iter().map(|run| run.1).sum::<usize>())
    };
    let (plain, plain_count) = of(1);
    let (placed, placed_count) = of(32);
    assert!(
        placed_count > 3 * plain_count,
        "{placed_count} VPLs light the wall, without a choice {plain_count}"
    );
    assert!((placed / plain - 1.0).abs() < 0.05, "irradiance {placed}, without a choice {plain}");
}

#[test]
fn vpls_come_along_with_the_camera_and_then_rest() {
    let mut stage = court();
    let mut manager = manager(&stage, 32, 0);
    assert_eq!(stage.frame(&mut manager).shot, 0);
    // It goes out and looks at the court from outside.
    stage.pose.camera = Camera::looking(Vec3::new(20.0, 1.5, 0.0), Vec3::new(2.2, 1.0, 0.0));
    let shot: Vec<u32> = (0..65).map(|_| stage.frame(&mut manager).shot).collect();
    assert!(shot.iter().all(|&shot| shot <= 64));
    assert_eq!(shot[64], 0, "4096 slots, 64 a frame");
    let fresh = VplManager::new(stage.world(), &Settings { seed: 0, ..settings(4096, 2) });
    let vpls =
        |manager: &VplManager| manager.slots().map(|slot| (slot.position, slot.flux)).collect::<Vec<_>>();
    assert_eq!(vpls(&manager), vpls(&fresh), "the past is forgotten");
    assert!(manager.slots().filter(|slot| slot.state == SlotState::Valid && slot.useful).count() > 1000);
}

#[test]
fn a_small_turn_keeps_most_vpls() {
    let mut stage = court();
    let mut manager = manager(&stage, 32, 0);
    let places = |manager: &VplManager| manager.slots().map(|slot| slot.position).collect::<Vec<_>>();
    let before = places(&manager);
    stage.pose.camera.target += Vec3::new(0.05, 0.0, 0.0);
    for _ in 0..65 {
        stage.frame(&mut manager);
    }
    let kept = before.iter().zip(places(&manager)).filter(|(a, b)| **a == *b).count();
    assert!(kept * 4 > before.len() * 3, "{kept} of {} VPLs kept", before.len());
}
