//! Small scenes, and their animation by hand.

use glam::{Affine3A, Vec3};
use glowworm::bvh::TwoLevelBvh;
use glowworm::estimators::World;
use glowworm::estimators::vpls::{GpuVpl, SlotState, SlotView, VplCounters, VplManager};
use glowworm::scene::{
    Alpha, AreaTriangle, Instance, Light, LightKind, Material, Mesh, Pose, Scene, SpotFalloff, luminance,
};
use glowworm::settings::{Settings, VplSettings};

/// A scene with its current pose.
pub struct Stage {
    pub scene: Scene,
    pub pose: Pose,
    bvh: TwoLevelBvh,
}

impl Stage {
    pub fn new(scene: Scene) -> Self {
        let pose = scene.pose(0.0);
        let bvh = TwoLevelBvh::build(&scene, &pose.instances);
        Self { scene, pose, bvh }
    }

    pub fn world(&self) -> World<'_> {
        World { scene: &self.scene, pose: &self.pose, bvh: &self.bvh }
    }

    /// This scene and pose, without history.
    pub fn fresh(&self) -> Self {
        Self {
            scene: self.scene.clone(),
            pose: self.pose.clone(),
            bvh: TwoLevelBvh::build(&self.scene, &self.pose.instances),
        }
    }

    /// One frame: BVH, invalidation, replacement.
    pub fn frame(&mut self, manager: &mut VplManager) -> VplCounters {
        self.bvh.update(&self.pose.instances);
        let invalidated = manager.invalidate(self.world());
        let shot = manager.replace(self.world());
        let counters = manager.counters();
        assert_eq!((counters.invalidated, counters.shot), (invalidated, shot));
        counters
    }

    pub fn invalidate(&mut self, manager: &mut VplManager) -> u32 {
        self.bvh.update(&self.pose.instances);
        manager.invalidate(self.world())
    }

    pub fn move_instance(&mut self, instance: usize, by: Vec3) {
        let rest = self.scene.instances[instance].transform;
        self.pose.instances[instance] = Affine3A::from_translation(by) * rest;
    }
}

pub fn settings(vpls: u32, bounces: u32) -> Settings {
    Settings {
        bounces,
        vpl: VplSettings {
            slots: vpls,
            pool: vpls,
            temporal_sets: 4.min(vpls),
            interleave: 2,
            ..VplSettings::default()
        },
        ..Settings::default()
    }
}

/// The settings with one candidate a slot, so that VPLs lie where the lights shoot them.
pub fn without_choice(settings: Settings) -> Settings {
    Settings { vpl: VplSettings { candidates: 1, ..settings.vpl }, ..settings }
}

/// A scene with material 0 of grey `albedo`.
pub fn grey_scene(albedo: f32) -> Scene {
    let mut scene = Scene::new("test");
    scene.materials.push(Material::lambertian("grey", Vec3::splat(albedo)));
    scene
}

/// A pane without reflection that lets `tint` pass.
pub fn pane(tint: Vec3) -> Material {
    Material { transmission: 1.0, ..Material::lambertian("pane", tint) }
}

/// A grey veil of which so much is there.
pub fn veil(opacity: f32, albedo: f32) -> Material {
    let grey = Material::lambertian("veil", Vec3::splat(albedo));
    Material { alpha: Alpha::Blend, opacity, ..grey }
}

/// Adds a mesh with an instance of it; returns the instance.
pub fn place(scene: &mut Scene, mesh: Mesh, at: Vec3, dynamic: bool) -> usize {
    let mut instance = Instance::fixed(&mesh.name, scene.meshes.len(), Affine3A::from_translation(at));
    instance.dynamic = dynamic;
    scene.meshes.push(mesh.into());
    scene.instances.push(instance);
    scene.instances.len() - 1
}

/// A horizontal square of edge `size` about the origin, facing up (or down for a negative size).
pub fn square(size: f32) -> Mesh {
    let (h, d) = (0.5 * size.abs(), 0.5 * size);
    let corners =
        [Vec3::new(-d, 0.0, h), Vec3::new(d, 0.0, h), Vec3::new(d, 0.0, -h), Vec3::new(-d, 0.0, -h)];
    Mesh::polygon("square", &corners, 0)
}

/// A closed room of edge `size` about the origin, seen from inside.
pub fn room(size: f32) -> Mesh {
    Mesh::cuboid("room", Vec3::splat(size), 0).turned_inside_out()
}

pub fn light(kind: LightKind, position: Vec3, direction: Vec3) -> Light {
    Light {
        name: "light".into(),
        kind,
        position,
        direction: direction.normalize_or(Vec3::NEG_Y),
        radius: 0.0,
        half_angle: 0.0,
        animation: None,
    }
}

pub fn point(intensity: f32, position: Vec3) -> Light {
    let intensity = Vec3::splat(intensity);
    light(LightKind::Point { intensity }, position, Vec3::NEG_Y)
}

pub fn spot(intensity: f32, position: Vec3, direction: Vec3) -> Light {
    let kind = LightKind::Spot {
        intensity: Vec3::splat(intensity),
        inner_angle: 0.3,
        outer_angle: 0.6,
        falloff: SpotFalloff::Smooth,
    };
    light(kind, position, direction)
}

pub fn directional(irradiance: f32, direction: Vec3) -> Light {
    let irradiance = Vec3::splat(irradiance);
    light(LightKind::Directional { irradiance }, Vec3::ZERO, direction)
}

/// Makes all triangles of `instance` emit `radiance`.
pub fn area(scene: &Scene, instance: usize, radiance: f32) -> Light {
    let triangles = scene.meshes[scene.instances[instance].mesh].triangles.len();
    let triangles = (0..triangles as u32)
        .map(|triangle| AreaTriangle {
            triangle,
            front: true,
            corners: AreaTriangle::WHOLE,
            radiance: Vec3::splat(radiance),
        })
        .collect();
    let kind = LightKind::Area { instance, triangles };
    light(kind, Vec3::ZERO, Vec3::NEG_Y)
}

/// The VPLs of all sets.
pub fn all_sets(manager: &VplManager, stage: &Stage, settings: &Settings) -> Vec<Vec<GpuVpl>> {
    (0..settings.vpl.temporal_sets).map(|set| manager.set_vpls(stage.world(), set)).collect()
}

/// Total red flux of the slots that pass `filter`.
pub fn flux_of(manager: &VplManager, filter: impl Fn(&SlotView) -> bool) -> f64 {
    manager.slots().filter(filter).map(|slot| f64::from(slot.flux.x)).sum()
}

/// Total luminous flux of all VPLs.
pub fn total_flux(manager: &VplManager) -> f32 {
    manager.slots().map(|slot| f64::from(luminance(slot.flux))).sum::<f64>() as f32
}

/// Asserts that no slot outlives its parent.
pub fn assert_descendants_follow(manager: &VplManager) {
    let states: Vec<_> = manager.slots().map(|slot| slot.state).collect();
    for slot in manager.slots() {
        let Some(parent) = slot.parent else { continue };
        let parent = states[parent as usize];
        if parent == SlotState::Invalid {
            assert_eq!(slot.state, SlotState::Invalid, "slot {}", slot.slot);
        }
    }
}

/// A small generator for test inputs (SplitMix64).
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    }

    pub fn direction(&mut self) -> Vec3 {
        loop {
            let v = Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0;
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }
}
