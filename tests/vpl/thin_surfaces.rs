//! Light paths through thin surfaces: energy, tint, and the path tracer's answer.

use std::f64::consts::PI;
use std::sync::atomic::AtomicBool;

use glam::{DVec3, Vec3};
use glowworm::bvh::Ray;
use glowworm::estimators::vpls::{SlotState, SlotView, VplManager};
use glowworm::reference::{PixelFilter, Reference, ReferenceSettings};
use glowworm::scene::{Camera, Environment, Material, Mesh, Scene, Side, SurfacePoint, WorldSurface};
use glowworm::settings::Settings;

use crate::support::*;

/// A closed room with a light in its middle, which boxes of these materials enclose, one around the other.
fn lamp_in_boxes(boxes: &[Material]) -> Stage {
    let mut scene = grey_scene(0.7);
    place(&mut scene, room(4.0), Vec3::ZERO, false);
    for (index, material) in boxes.iter().enumerate() {
        scene.materials.push(material.clone());
        let size = Vec3::splat(0.5 * (index + 1) as f32);
        place(&mut scene, Mesh::cuboid("box", size, 1 + index as u32), Vec3::ZERO, true);
    }
    scene.lights.push(point(3.0, Vec3::ZERO));
    Stage::new(scene)
}

/// Whether a slot's VPL lies on the walls of the room.
fn on_wall(slot: &SlotView) -> bool {
    slot.state == SlotState::Valid && slot.position.abs().max_element() > 1.9
}

fn flux(manager: &VplManager, filter: impl Fn(&SlotView) -> bool) -> DVec3 {
    manager.slots().filter(filter).map(|slot| slot.flux.as_dvec3()).sum()
}

#[test]
fn a_clear_pane_tints_each_vpl_behind_it() {
    // The red light passes always, so all paths go on.
    let tint = Vec3::new(1.0, 0.5, 0.25);
    let (bare, tinted) = (lamp_in_boxes(&[]), lamp_in_boxes(&[pane(tint), pane(tint)]));
    let settings = without_choice(settings(500, 1));
    let [bare_sets, tinted_sets] = [&bare, &tinted].map(|stage| {
        let manager = VplManager::new(stage.world(), &settings);
        all_sets(&manager, stage, &settings)
    });
    for (bare, tinted) in bare_sets.iter().flatten().zip(tinted_sets.iter().flatten()) {
        assert!(bare.position.distance(tinted.position) < 1e-5);
        assert!((bare.flux * tint * tint).distance(tinted.flux) < 1e-5 * bare.flux.x);
    }
}

#[test]
fn the_flux_behind_a_pane_is_what_it_lets_pass() {
    for tints in [vec![Vec3::new(0.8, 0.5, 0.1)], vec![Vec3::new(0.6, 0.9, 0.3), Vec3::splat(0.7)]] {
        let stage = lamp_in_boxes(&tints.iter().map(|&tint| pane(tint)).collect::<Vec<_>>());
        let tint = tints.iter().product::<Vec3>().as_dvec3();
        for settings in [settings(4096, 1), without_choice(settings(4096, 1))] {
            let manager = VplManager::new(stage.world(), &settings);
            let (found, expected) = (flux(&manager, on_wall), 12.0 * PI * 0.7 * tint);
            assert!((found / expected - 1.0).abs().max_element() < 0.03, "{found} {expected}");
            // The panes reflect nothing.
            assert!(flux(&manager, |slot| !on_wall(slot)) == DVec3::ZERO);
        }
    }
}

#[test]
fn a_veil_stops_its_share_of_the_paths() {
    let stage = lamp_in_boxes(&[veil(0.5, 0.6), veil(0.25, 0.4)]);
    let manager = VplManager::new(stage.world(), &without_choice(settings(4096, 1)));
    let on_box = |slot: &SlotView, size: f32| (slot.position.abs().max_element() - 0.5 * size).abs() < 1e-4;
    for (size, stopped, albedo) in [(0.5, 0.5, 0.6), (1.0, 0.5 * 0.25, 0.4), (4.0, 0.5 * 0.75, 0.7)] {
        let count = manager.slots().filter(|slot| on_box(slot, size)).count();
        let share = count as f64 / 4096.0;
        assert!((share / stopped - 1.0).abs() < 0.1, "{share} instead of {stopped} on {size}");
        let found = flux(&manager, |slot| on_box(slot, size)).x / (12.0 * PI * albedo);
        assert!((found / stopped - 1.0).abs() < 0.1, "{found} instead of {stopped} on {size}");
    }
    // They shine back to where they came from.
    assert!(manager.slots().all(|slot| slot.normal.dot(slot.position) < 0.0));
}

/// A floor in a box of this material, lit from outside.
fn floor_in_box(material: Material, light: impl Fn(&mut Scene)) -> Stage {
    let mut scene = grey_scene(0.5);
    scene.materials.push(material);
    place(&mut scene, square(4.0), Vec3::ZERO, false);
    place(&mut scene, Mesh::cuboid("box", Vec3::splat(5.0), 1), Vec3::ZERO, false);
    light(&mut scene);
    Stage::new(scene)
}

#[test]
fn sun_and_sky_shine_through_a_pane() {
    let sun = |scene: &mut Scene| scene.lights.push(directional(2.0, Vec3::new(0.3, -1.0, 0.2)));
    let sky = |scene: &mut Scene| scene.environment = Some(Environment::constant(Vec3::ONE));
    let lights: [&dyn Fn(&mut Scene); 2] = [&sun, &sky];
    for light in lights {
        let on_floor = |slot: &SlotView| slot.bounce == 1 && slot.normal.y > 0.9 && slot.position.y < 0.1;
        let of = |material| {
            let stage = floor_in_box(material, light);
            flux(&VplManager::new(stage.world(), &without_choice(settings(16_384, 1))), on_floor)
        };
        let bare = of(pane(Vec3::ONE));
        assert!(bare.x > 0.0);
        for (tint, tolerance) in [(Vec3::new(1.0, 0.5, 0.25), 1e-5), (Vec3::new(0.4, 0.5, 0.2), 0.05)] {
            let share = of(pane(tint)) / bare / tint.as_dvec3();
            assert!((share - 1.0).abs().max_element() < tolerance, "{share}");
        }
    }
}

/// A room that a tinted, half-covering pane divides, with a light on one side and the camera on the other.
fn divided_room() -> Stage {
    let mut scene = Scene::new("divided room");
    scene.materials.push(Material::lambertian("grey", Vec3::new(0.8, 0.7, 0.6)));
    let stained = Material { transmission: 0.6, ..veil(0.7, 1.0) };
    scene.materials.push(Material { base_colour: Vec3::new(0.9, 0.6, 0.3), ..stained });
    place(&mut scene, room(4.0), Vec3::ZERO, false);
    let corners = [[-2.0, -2.0], [-2.0, 2.0], [2.0, 2.0], [2.0, -2.0]];
    let corners = corners.map(|[y, z]| Vec3::new(0.2, y, z));
    place(&mut scene, Mesh::polygon("pane", &corners, 1), Vec3::ZERO, false);
    scene.lights.push(point(5.0, Vec3::new(-1.2, 0.7, 0.4)));
    let eye = Vec3::new(1.2, 1.5, 0.3);
    scene.camera = Camera { vertical_fov: 0.4, ..Camera::looking(eye, Vec3::new(1.2, -2.0, -0.1)) };
    Stage::new(scene)
}

const SIDE: u32 = 4;

/// Mean indirect irradiance of what the camera sees, by the path tracer.
fn traced(stage: &Stage, bounces: u32) -> Vec3 {
    let settings = ReferenceSettings {
        size: [SIDE; 2],
        bounces: Some(bounces),
        seed: 3,
        filter: PixelFilter::Center,
        layers: true,
    };
    let reference = Reference::new(&stage.scene, &stage.pose, &settings);
    let mut film = reference.film().unwrap();
    for _ in 0..20_000 {
        assert!(reference.add_sample(&mut film, &AtomicBool::new(false)));
    }
    let picture = film.picture();
    let layer = picture.layers.iter().find(|layer| layer.name == "indirect").unwrap();
    let mean = |channel: usize| layer.channels[channel].1.iter().sum::<f32>() / (SIDE * SIDE) as f32;
    Vec3::new(mean(0), mean(1), mean(2))
}

/// The surface that a pixel of it shows.
fn surface_at(stage: &Stage, pixel: u32) -> WorldSurface {
    let [axis, right, down] = stage.pose.camera.pixel_rays(1.0);
    let at = |index: u32| (index as f32 + 0.5) / SIDE as f32 * 2.0 - 1.0;
    let direction = axis + right * at(pixel % SIDE) + down * at(pixel / SIDE);
    let ray = Ray { origin: stage.pose.camera.eye, direction, t_min: 0.0, t_max: f32::INFINITY };
    let hit = stage.world().visible(&ray).unwrap();
    let point = SurfacePoint { triangle: hit.triangle, barycentrics: hit.barycentrics };
    stage.scene.surface_at(&stage.pose, hit.instance, point, Side::Facing(direction)).surface
}

#[test]
fn the_mean_is_that_of_the_path_tracer() {
    let stage = divided_room();
    for bounces in [1, 3] {
        let expected = traced(&stage, bounces);
        for choice in [true, false] {
            let seeds = 8;
            let mut found = Vec3::ZERO;
            for seed in 0..seeds {
                let settings = Settings { seed, ..settings(2048 * bounces, bounces) };
                let settings = if choice { settings } else { without_choice(settings) };
                let manager = VplManager::new(stage.world(), &settings);
                for pixel in 0..SIDE * SIDE {
                    let seen = manager.inspect(stage.world(), &surface_at(&stage, pixel), 0.0);
                    let visible = seen.iter().filter(|vpl| vpl.visible);
                    found += visible.map(|vpl| vpl.irradiance).sum::<Vec3>() / (seeds * SIDE * SIDE) as f32;
                }
            }
            let ratio = found / expected;
            assert!((ratio - 1.0).abs().max_element() < 0.02, "{bounces} bounces: {found} {expected}");
        }
    }
}
