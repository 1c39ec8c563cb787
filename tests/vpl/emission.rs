//! Distribution of first VPLs against the emission of each kind of light.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::Vec3;
use glowworm::estimators::vpls::{SlotState, VplManager};
use glowworm::scene::{AlphaMask, Environment, EnvironmentMap, Light, Mesh, Scene};

use crate::support::*;

/// Compares the fraction of samples in each bin with the expected one.
fn assert_shares(what: &str, counts: &[u32], expected: &[f32]) {
    let total: u32 = counts.iter().sum();
    for (bin, (count, expected)) in counts.iter().zip(expected).enumerate() {
        let got = *count as f32 / total as f32;
        assert!((got - expected).abs() < 0.004, "{what}, bin {bin}: {got} instead of {expected}");
    }
}

fn sphere_scene(light: impl Fn(&mut Scene) -> Light) -> Stage {
    let mut scene = grey_scene(0.5);
    let mesh = Mesh::sphere("sphere", 10.0, 4, 0).turned_inside_out();
    place(&mut scene, mesh, Vec3::ZERO, false);
    let light = light(&mut scene);
    scene.lights.push(light);
    Stage::new(scene)
}

fn positions(stage: &Stage, vpls: u32, bounces: u32, bounce: u32) -> Vec<Vec3> {
    let manager = VplManager::new(stage.world(), &without_choice(settings(vpls, bounces)));
    let slots = manager.slots();
    slots
        .filter(|slot| slot.bounce == bounce && slot.state == SlotState::Valid)
        .map(|slot| slot.position)
        .collect()
}

#[test]
fn point_light_is_uniform() {
    let stage = sphere_scene(|_| point(1.0, Vec3::ZERO));
    let mut counts = [0u32; 24];
    for p in positions(&stage, 20_000, 1, 1) {
        // Bands of equal height on a sphere have equal area; three of them, eight sectors each.
        let band = ((p.normalize().y * 0.5 + 0.5) * 3.0).clamp(0.0, 2.99) as usize;
        let sector = ((p.z.atan2(p.x) / (2.0 * PI) + 0.5) * 8.0).clamp(0.0, 7.99) as usize;
        counts[band * 8 + sector] += 1;
    }
    assert_shares("point", &counts, &[1.0 / 24.0; 24]);
}

#[test]
fn spot_light_follows_its_falloff() {
    for axis in [Vec3::NEG_Y, Vec3::new(0.48, 0.6, 0.64), Vec3::new(1.0, 2.0, -0.5).normalize()] {
        let stage = sphere_scene(|_| spot(1.0, Vec3::ZERO, axis));
        let all = positions(&stage, 20_000, 1, 1);
        assert_eq!(all.len(), 20_000);
        let (inner, outer) = (0.3f32.cos(), 0.6f32.cos());
        let bins = 16;
        let width = (1.0 - outer) / bins as f32;
        let density = |cos: f32| {
            let t = ((cos - outer) / (inner - outer)).clamp(0.0, 1.0);
            t * t * (3.0 - 2.0 * t)
        };
        // Integrate the emission over each bin of the cosine, by many small steps.
        let mut expected: Vec<f32> = (0..bins)
            .map(|bin| {
                (0..200).map(|i| density(outer + width * (bin as f32 + (i as f32 + 0.5) / 200.0))).sum()
            })
            .collect();
        let total: f32 = expected.iter().sum();
        expected.iter_mut().for_each(|share| *share /= total);
        let mut counts = vec![0u32; bins];
        for p in &all {
            let bin = (p.normalize().dot(axis) - outer) / width;
            assert!(bin > -0.2);
            counts[(bin.max(0.0) as usize).min(bins - 1)] += 1;
        }
        assert_shares("spot", &counts, &expected);
        let mean = all.iter().sum::<Vec3>() / all.len() as f32;
        assert!(mean.normalize().dot(axis) > 0.9999, "as much on one side as on the other");
    }
}

#[test]
fn directional_light_is_uniform_across_its_direction() {
    let mut scene = grey_scene(0.5);
    place(&mut scene, square(2.0), Vec3::ZERO, false);
    scene.lights.push(directional(3.0, Vec3::new(0.5, -1.0, 0.2)));
    let stage = Stage::new(scene);
    let manager = VplManager::new(stage.world(), &settings(40_000, 1));
    let mut counts = [0u32; 16];
    for slot in manager.slots().filter(|slot| slot.state == SlotState::Valid) {
        let cell = ((slot.position + 1.0) * 2.0).clamp(Vec3::ZERO, Vec3::splat(3.99));
        counts[cell.x as usize * 4 + cell.z as usize] += 1;
    }
    assert_shares("directional", &counts, &[1.0 / 16.0; 16]);
    // The irradiance falls on the square at an angle.
    let cos = Vec3::new(0.5, -1.0, 0.2).normalize().y.abs();
    let flux = flux_of(&manager, |_| true) as f32;
    assert!((flux / (3.0 * 4.0 * cos * 0.5) - 1.0).abs() < 0.01, "{flux}");
}

#[test]
fn sun_finds_a_house_on_a_wide_plain() {
    let mut scene = grey_scene(0.5);
    place(&mut scene, square(200.0), Vec3::ZERO, false);
    let dome = Mesh::sphere("dome", 1.0, 4, 0);
    place(&mut scene, dome, Vec3::new(30.0, 0.0, 20.0), false);
    scene.lights.push(directional(3.0, Vec3::NEG_Y));
    let stage = Stage::new(scene);
    let manager = VplManager::new(stage.world(), &without_choice(settings(4096, 1)));
    let is_on_dome = |slot: &glowworm::estimators::vpls::SlotView| {
        slot.state == SlotState::Valid && slot.position.y > 1e-4
    };
    let on_dome = manager.slots().filter(is_on_dome).count();
    assert!(on_dome > 250, "{on_dome}");
    // The weights still give each point its irradiance.
    let flux = flux_of(&manager, is_on_dome) as f32;
    assert!((flux / (3.0 * PI * 0.5) - 1.0).abs() < 0.03, "{flux}");
    let flux = flux_of(&manager, |_| true) as f32;
    assert!((flux / (3.0 * 40_000.0 * 0.5) - 1.0).abs() < 0.03, "{flux}");
}

#[test]
fn area_light_starts_evenly_and_shines_by_the_cosine() {
    // A small light at the centre of a large sphere, so that the start on the light hardly matters.
    let stage = sphere_scene(|scene| {
        let emitter = place(scene, square(0.02), Vec3::ZERO, false);
        area(scene, emitter, 1.0)
    });
    let mut counts = [0u32; 16];
    for p in positions(&stage, 40_000, 1, 0) {
        let cell = ((p / 0.01 + 1.0) * 2.0).clamp(Vec3::ZERO, Vec3::splat(3.99));
        counts[cell.x as usize * 4 + cell.z as usize] += 1;
    }
    assert_shares("area, where", &counts, &[1.0 / 16.0; 16]);
    let mut counts = [0u32; 32];
    for p in positions(&stage, 40_000, 1, 1) {
        let direction = p.normalize();
        assert!(direction.y > -0.01, "the back stays dark");
        // Rings of equal cosine-weighted solid angle have equal steps of sin^2.
        let ring = ((1.0 - direction.y * direction.y) * 4.0).clamp(0.0, 3.99) as usize;
        let sector = ((p.z.atan2(p.x) / (2.0 * PI) + 0.5) * 8.0).clamp(0.0, 7.99) as usize;
        counts[ring * 8 + sector] += 1;
    }
    assert_shares("area, whither", &counts, &[1.0 / 32.0; 32]);
}

#[test]
fn area_light_weighs_its_triangles() {
    let mut scene = grey_scene(0.5);
    let bright = place(&mut scene, square(1.0), Vec3::ZERO, false);
    let mut emitter = area(&scene, bright, 1.0);
    let glowworm::scene::LightKind::Area { triangles, .. } = &mut emitter.kind else {
        panic!("not an area light")
    };
    triangles[0].radiance = Vec3::new(3.0, 0.0, 0.0);
    triangles[1].radiance = Vec3::new(0.0, 0.0, 1.0);
    scene.lights.push(emitter);
    let stage = Stage::new(scene);
    let manager = VplManager::new(stage.world(), &without_choice(settings(4000, 1)));
    let flux: Vec3 = manager.slots().filter(|slot| slot.bounce == 0).map(|slot| slot.flux).sum();
    let expected = Vec3::new(3.0, 0.0, 1.0) * PI * 0.5;
    assert!(flux.distance(expected) < 0.01 * expected.length(), "{flux} {expected}");
}

/// An alpha mask cuts half of the light away: half of its paths carry no flux, the rest carry half of it.
#[test]
fn holes_in_an_area_light_emit_nothing() {
    let mut scene = grey_scene(0.5);
    scene.alpha_masks.push(AlphaMask { nearest: true, ..AlphaMask::new([2, 1], vec![255, 0]) });
    scene.materials[0].alpha_mask = Some(0);
    let mut mesh = square(2.0);
    mesh.uvs = mesh.positions.iter().map(|position| glam::Vec2::new(0.5 * (position.x + 1.0), 0.5)).collect();
    // Up to the edge, where coordinates wrap around.
    mesh.uvs.iter_mut().for_each(|uv| uv.x = uv.x.clamp(0.0, 0.999));
    let emitter = place(&mut scene, mesh, Vec3::ZERO, false);
    let light = area(&scene, emitter, 1.0);
    scene.lights.push(light);
    let stage = Stage::new(scene);
    let manager = VplManager::new(stage.world(), &without_choice(settings(4096, 1)));
    let primaries: Vec<_> = manager.slots().filter(|slot| slot.bounce == 0).collect();
    let valid: Vec<_> = primaries.iter().filter(|slot| slot.state == SlotState::Valid).collect();
    assert!(valid.iter().all(|slot| slot.position.x < 0.01));
    let kept = valid.len() as f32 / primaries.len() as f32;
    assert!((kept - 0.5).abs() < 0.02, "{kept}");
    let flux = flux_of(&manager, |slot| slot.bounce == 0) as f32;
    assert!((flux / (0.5 * PI * 4.0) - 1.0).abs() < 0.02, "{flux}");
}

#[test]
fn vpls_at_infinity_follow_the_radiance() {
    let mut stage = sphere_scene(|_| point(0.0, Vec3::ZERO));
    // Three quarters of the light come from above; the map is turned about the vertical, which changes nothing of that.
    let texels =
        (0..64 * 32).map(|i| Vec3::new(1.0, 2.0, 0.5) * if i < 64 * 16 { 3.0 } else { 1.0 }).collect();
    let map = Some(Arc::new(EnvironmentMap::new(64, 32, texels)));
    stage.scene.environment = Some(Environment { radiance: Vec3::ONE, map, rotation: 0.5 });
    let stage = Stage::new(stage.scene);
    let settings = without_choice(settings(30_000, 2));
    let manager = VplManager::new(stage.world(), &settings);
    let vpls: Vec<_> = (0..settings.vpl.temporal_sets)
        .flat_map(|set| manager.set_vpls(stage.world(), set))
        .filter(|vpl| vpl.at_infinity == 1)
        .collect();
    assert_eq!(vpls.len(), 10_000, "one of three slots of a path");
    let above = vpls.iter().filter(|vpl| vpl.position.y > 0.0).count();
    assert!((above as f32 / vpls.len() as f32 - 0.75).abs() < 0.01, "{above}");
    // Together they have the irradiance of all directions, each across its own.
    let all: Vec3 = vpls.iter().map(|vpl| vpl.flux).sum();
    let expected = Vec3::new(1.0, 2.0, 0.5) * (4.0 * PI * 2.0);
    assert!((all / expected - 1.0).abs().max_element() < 0.01, "{all} {expected}");
}
