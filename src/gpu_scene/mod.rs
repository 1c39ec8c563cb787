//! The scene on the device: the one descriptor set that rays and shading read.
//!
//! In: a scene, its BVH and where everything stands. Out: set 1 of every pass that casts rays or shades what these hit, the same
//! for all methods and always complete (shaders/include/scene_set.glsl); and what raster draws.

pub mod area_lights;
pub mod clusters;
pub mod environment;
pub mod geometry;
pub mod hit_buffers;
mod lights;
pub mod noise;
pub mod scene_buffers;
pub mod structs;
pub mod tracer;
mod tracer_hardware;
mod tracer_software;

use std::sync::Arc;

use crate::bvh::TwoLevelBvh;
use crate::scene::{Pose, Scene};
use crate::vulkan::{Buffer, Device, Frame, Resource, SharedSet, Upload, VulkanError};
use area_lights::{AreaLights, UploadedAreaLights};
use environment::EnvironmentTexture;
use hit_buffers::HitBuffers;
pub use lights::lights_of;
use scene_buffers::{SceneBuffers, dark_behind};
use structs::LightData;
use tracer::{RayTracer, Tracer, TracerVariant};

/// A resource of the scene set under its name in shaders/include/scene_set.glsl.
pub type Named<'a> = (&'static str, Resource<'a>);

/// A scene in device memory.
pub struct GpuScene {
    buffers: SceneBuffers,
    hits: HitBuffers,
    noise: Buffer,
    tracer: Tracer,
    area_lights: AreaLights,
    /// Point, spot and directional lights.
    lights: Vec<LightData>,
}

/// Uploads of a frame: instances and lights as they stand.
pub struct FrameScene {
    instances: Arc<Buffer>,
    lights: Upload,
    area_lights: UploadedAreaLights,
}

impl GpuScene {
    /// Uploads what does not move, and makes the tracer.
    ///
    /// # Errors
    /// Where the device lacks memory, or does not support the tracer.
    pub fn new(
        device: &Arc<Device>,
        scene: &Scene,
        tracer: RayTracer,
        bvh: &TwoLevelBvh,
    ) -> Result<Self, VulkanError> {
        Ok(Self {
            buffers: SceneBuffers::new(device, scene)?,
            hits: HitBuffers::new(device, scene)?,
            noise: noise::table(device)?,
            tracer: Tracer::new(device, tracer, bvh)?,
            area_lights: AreaLights::default(),
            lights: Vec::new(),
        })
    }

    /// The buffers that raster draws.
    pub fn buffers(&self) -> &SceneBuffers {
        &self.buffers
    }

    /// The tracer.
    pub fn tracer(&self) -> &Tracer {
        &self.tracer
    }

    /// Which shaders the scene needs.
    pub fn variant(&self) -> TracerVariant {
        self.tracer.variant()
    }

    /// Replaces the tracer. No frame is in flight.
    pub fn set_tracer(&mut self, tracer: Tracer) {
        self.tracer = tracer;
    }

    /// Makes what differs for a scene that is built like this one: materials, and the environment if its map is another one.
    ///
    /// # Errors
    /// Where the device lacks memory.
    pub fn changes_for(
        &self,
        device: &Arc<Device>,
        scene: &Scene,
        bvh: &TwoLevelBvh,
    ) -> Result<SceneChanges, VulkanError> {
        let (materials, environment) = self.buffers.for_scene(device, scene)?;
        let thin_surfaces = bvh.thin_surfaces_of(scene);
        Ok(SceneChanges {
            materials: (materials, dark_behind(scene)),
            environment,
            thin_surface_materials: self.tracer.thin_surface_materials(device, &thin_surfaces)?,
        })
    }

    /// Goes on with them. No frame is in flight.
    pub fn apply(&mut self, changes: SceneChanges) {
        self.buffers.replace(changes.materials, changes.environment);
        self.tracer.replace_thin_surfaces(changes.thin_surface_materials);
    }

    /// Brings the lights up to date with `pose`. With `soft` shadows they keep their extent.
    pub fn update_lights(&mut self, scene: &Scene, pose: &Pose, soft: bool) {
        self.lights = lights_of(pose, soft);
        self.area_lights.update(scene, pose);
    }

    /// How many point, spot and directional lights there are, and how many area lights.
    pub fn light_counts(&self) -> [u32; 2] {
        [to_u32(self.lights.len()), self.area_lights.count()]
    }

    /// Uploads the lights and where everything stands in `pose`, and brings the BVH on the device up to date.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn upload(
        &mut self,
        frame: &mut Frame<'_>,
        (scene, pose): (&Scene, &Pose),
        bvh: &TwoLevelBvh,
    ) -> Result<FrameScene, VulkanError> {
        self.tracer.update(frame, bvh)?;
        Ok(FrameScene {
            instances: self.buffers.upload_instances(frame, scene, pose, &self.area_lights)?,
            lights: frame.upload(&self.lights)?,
            area_lights: self.area_lights.upload(frame)?,
        })
    }

    /// Writes the scene set of a frame.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn set<'a>(
        &'a self,
        frame: &mut Frame<'_>,
        uploaded: &'a FrameScene,
    ) -> Result<SharedSet<'a>, VulkanError> {
        let mut resources: Vec<Named<'a>> = vec![
            ("instances", (&*uploaded.instances).into()),
            ("lights", (&uploaded.lights).into()),
            ("area_lights", (&uploaded.area_lights.lights).into()),
            ("emitters", (&uploaded.area_lights.emitters).into()),
            ("blue_noise", (&self.noise).into()),
        ];
        resources.extend(self.buffers.resources());
        resources.extend(self.hits.resources());
        resources.extend(self.tracer.resources());
        frame.shared_set(resources)
    }
}

/// Parts that differ for another scene of the same geometry.
pub struct SceneChanges {
    materials: (Buffer, Vec<bool>),
    environment: Option<EnvironmentTexture>,
    thin_surface_materials: Buffer,
}

/// A count as shaders take it.
pub(crate) fn to_u32(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}
