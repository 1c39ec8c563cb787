//! Flux of VPLs against analytic light transport.

use std::f64::consts::PI;

use glam::Vec3;
use glowworm::estimators::vpls::{SlotState, VplManager};
use glowworm::scene::{Mesh, luminance};

use crate::depth::quick_or_all;
use crate::support::*;

#[test]
fn closed_room_keeps_albedo_to_the_power_of_the_bounce() {
    let mut scene = grey_scene(0.7);
    place(&mut scene, room(4.0), Vec3::ZERO, false);
    scene.lights.push(point(3.0, Vec3::new(0.3, 0.5, -0.8)));
    let stage = Stage::new(scene);
    for vpls in [16, 250, 1000] {
        let manager = VplManager::new(stage.world(), &settings(vpls, 4));
        assert_eq!(manager.counters().escaped, 0);
        assert_eq!(manager.counters().shot, 0);
        for bounce in 1..=4 {
            let expected = 12.0 * PI * 0.7f64.powi(bounce);
            let got = flux_of(&manager, |slot| slot.bounce == bounce as u32);
            assert!((got / expected - 1.0).abs() < 1e-5, "{vpls} {bounce}: {got} {expected}");
        }
    }
}

#[test]
fn sets_add_up_to_the_total() {
    let mut scene = grey_scene(0.6);
    place(&mut scene, room(4.0), Vec3::ZERO, false);
    scene.lights.push(point(3.0, Vec3::ZERO));
    scene.lights.push(spot(8.0, Vec3::Y, Vec3::X));
    let stage = Stage::new(scene);
    let settings = settings(333, 3);
    let manager = VplManager::new(stage.world(), &settings);
    let sets = all_sets(&manager, &stage, &settings);
    let flux = manager.set_flux();
    let sum: f32 = flux.iter().sum();
    let total = total_flux(&manager);
    assert!(total > 0.0 && (sum / total - 1.0).abs() < 1e-5, "{sum} {total}");
    // Sets hold the flux that they report.
    let mut seen = vec![false; 333];
    for (index, (set, said)) in sets.iter().zip(&flux).enumerate() {
        let held: f32 = set.iter().map(|vpl| luminance(vpl.flux)).sum();
        assert!((held - said).abs() < 1e-4 * total);
        for vpl in set {
            assert_eq!(vpl.slot % 4, index as u32, "slot s is in set s mod T");
            assert!(!std::mem::replace(&mut seen[vpl.slot as usize], true));
        }
    }
    assert!(seen.iter().all(|seen| *seen));
}

#[test]
fn integrating_sphere_is_evenly_lit() {
    let (radius, albedo, intensity) = (2.0f32, 0.6f32, 5.0f32);
    let mut scene = grey_scene(albedo);
    let mesh = Mesh::sphere("sphere", radius, 6, 0).turned_inside_out();
    place(&mut scene, mesh, Vec3::new(10.0, 0.0, 0.0), false);
    let center = Vec3::new(10.0, 0.0, 0.0);
    scene.lights.push(point(intensity, center));
    let stage = Stage::new(scene);
    for bounces in [1, 2, 4] {
        let settings = settings(256, bounces);
        let manager = VplManager::new(stage.world(), &settings);
        let series: f32 = (1..=bounces).map(|b| albedo.powi(b as i32)).sum();
        let expected = f64::from(intensity / (radius * radius) * series);
        let sets = all_sets(&manager, &stage, &settings);
        let mut random = Random(7);
        let irradiance: Vec<f64> = (0..400)
            .map(|_| {
                let normal = -random.direction();
                let x = center - normal * radius;
                let vpls = sets.iter().flatten();
                vpls.map(|vpl| {
                    let d = vpl.position - x;
                    let w = d.normalize();
                    let cosines = normal.dot(w).max(0.0) * vpl.normal.dot(-w).max(0.0);
                    f64::from(vpl.flux.x * cosines / d.length_squared()) / PI
                })
                .sum()
            })
            .collect();
        let mean = irradiance.iter().sum::<f64>() / irradiance.len() as f64;
        assert!((mean / expected - 1.0).abs() < 5e-3, "B {bounces}: {mean} {expected}");
        let off = irradiance.iter().filter(|e| (*e / expected - 1.0).abs() > 0.02);
        assert!(off.count() <= 4, "B {bounces}");
    }
}

/// A room with a point, a spot and an area light in it, and the sun on its roof.
fn four_lights() -> Stage {
    let mut scene = grey_scene(0.5);
    place(&mut scene, room(4.0), Vec3::ZERO, false);
    let emitter = place(&mut scene, square(-1.0), Vec3::new(0.0, 1.9, 0.0), false);
    scene.lights.push(point(0.02, Vec3::new(1.0, 0.0, 1.0)));
    scene.lights.push(spot(40.0, Vec3::new(-1.0, 0.0, 0.0), Vec3::new(0.2, -1.0, 0.1)));
    scene.lights.push(directional(2.0, Vec3::new(0.0, -1.0, 0.0)));
    scene.lights.push(area(&scene, emitter, 5.0));
    Stage::new(scene)
}

#[test]
fn each_of_four_lights_gets_its_energy() {
    let stage = four_lights();
    let soft = 2.0 * PI * (1.0 - 0.5 * (0.3f64.cos() + 0.6f64.cos()));
    let flux = [0.02 * 4.0 * PI, 40.0 * soft, 2.0 * 16.0, 5.0 * PI];
    let manager = VplManager::new(stage.world(), &settings(3000, 3));
    for (light, flux) in flux.into_iter().enumerate() {
        let sun = light == 2;
        for bounce in 0..=3 {
            let expected = match bounce {
                0 => {
                    if light == 3 {
                        flux
                    } else {
                        0.0
                    }
                }
                // Light from the outside of the roof never returns.
                2.. if sun => 0.0,
                _ => flux * 0.5f64.powi(bounce as i32),
            };
            let got = flux_of(&manager, |slot| slot.light == Some(light as u32) && slot.bounce == bounce);
            let tolerance = if sun { 0.01 } else { 1e-4 };
            assert!(
                (got - expected).abs() <= tolerance * flux,
                "light {light} bounce {bounce}: {got} {expected}"
            );
        }
    }
}

/// Each count takes 4,000 managers to tell 5 %.
#[test]
fn too_few_slots_for_all_lights_stay_unbiased() {
    let stage = four_lights();
    for &vpls in quick_or_all(&[1, 5][..], &[1, 2, 5, 7]) {
        let (mut mean, seeds) = (0.0, 4000);
        for seed in 0..seeds {
            let settings = glowworm::settings::Settings { seed, ..settings(vpls, 3) };
            let manager = VplManager::new(stage.world(), &settings);
            mean += flux_of(&manager, |slot| slot.bounce == 1) / f64::from(seeds);
        }
        // The area light's path spends its first slot on bounce 0; with one slot nothing is left of it.
        let area = if vpls == 1 { 0.0 } else { 5.0 * PI };
        let soft = 2.0 * PI * (1.0 - 0.5 * (0.3f64.cos() + 0.6f64.cos()));
        let expected = 0.5 * (0.02 * 4.0 * PI + 40.0 * soft + 32.0 + area);
        assert!((mean / expected - 1.0).abs() < 0.05, "{vpls}: {mean} {expected}");
    }
}

#[test]
fn escapes_are_true_zeros_and_invalid_slots_are_made_up_for() {
    // A light over the middle of an open square, as high as half its edge, sees a sixth of all directions
    // fall on it.
    let mut scene = grey_scene(0.8);
    place(&mut scene, square(2.0), Vec3::ZERO, false);
    let plate = place(&mut scene, square(0.6), Vec3::new(0.0, -5.0, 0.0), true);
    scene.lights.push(point(1.0, Vec3::Y));
    let mut stage = Stage::new(scene);
    let settings = glowworm::settings::Settings {
        vpl: glowworm::settings::VplSettings { budget: 1, candidates: 1, ..settings(4096, 1).vpl },
        ..settings(4096, 1)
    };
    let mut manager = VplManager::new(stage.world(), &settings);
    let expected = 4.0 * PI / 6.0 * 0.8;
    let whole = flux_of(&manager, |_| true);
    assert!((whole / expected - 1.0).abs() < 0.02, "{whole} {expected}");
    let escaped = manager.counters().escaped;
    // Hold the plate below the light: VPLs behind it are invalid, and the rest keeps the total flux.
    stage.move_instance(plate, Vec3::new(0.0, 5.5, 0.0));
    stage.invalidate(&mut manager);
    let counters = manager.counters();
    assert_eq!(counters.escaped, escaped);
    assert!(counters.invalidated > 100 && counters.valid > 100);
    let live = f64::from(counters.valid + counters.escaped);
    let each = 4.0 * PI / live * 0.8;
    for slot in manager.slots().filter(|slot| slot.state == SlotState::Valid) {
        assert!((f64::from(slot.flux.x) / each - 1.0).abs() < 1e-5);
    }
}
