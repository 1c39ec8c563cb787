//! The camera of a frame: where it samples the pixels, and what all passes are told.

use glam::{Mat4, Vec2};

use super::Renderer;
use crate::effects::reflections::Reflections;
use crate::estimators::World;
use crate::gpu_scene::structs::FrameUniforms;
use crate::passes::clock::{ClockInputs, FrameClock};
use crate::scene::{Camera, Pose};
use crate::settings::{Antialiasing, Direct};

/// Where positions within the pixel are averaged, textures are sharper than the pixel by so much: a mip bias of -1.15 (Karis 2014 has
/// -1), by which the mean keeps the contrast of floors at any angle.
const JITTERED_FOOTPRINT: f32 = 0.45;

/// Pose and uniforms of a frame.
pub(super) struct FrameSetup {
    /// Where everything stands, with the camera where it samples the pixels.
    pub pose: Pose,
    pub uniforms: FrameUniforms,
    /// World to clip space without jitter, now and one frame ago.
    pub unjittered: [Mat4; 2],
}

impl Renderer {
    /// Decides when still frames begin and end. A view shows the frame as it is.
    pub(super) fn clock_inputs(&self) -> ClockInputs {
        let is_picture = self.view.is_picture();
        ClockInputs {
            cycle_length: self.estimator.cycle_length(),
            equals_restart: self.estimator.equals_restart(),
            still_frames: if is_picture { self.resolved.still_frames } else { 0 },
            is_jittered: is_picture && self.resolved.antialiasing == Antialiasing::Taa,
        }
    }

    /// The camera with this frame's jitter, and the uniforms.
    pub(super) fn set_up(&self, pose: &Pose, clock: &FrameClock) -> FrameSetup {
        let size = self.resolved.size;
        let [light_count, area_light_count] = self.gpu_scene.light_counts();
        let extent = Vec2::from(size.map(|side| side as f32));
        let aspect = extent.x / extent.y;
        let unjittered = view_projection(&pose.camera, aspect);
        let previous = self.unjittered.unwrap_or(unjittered);
        let jitter = clock.jitter();
        let mut pose = pose.clone();
        pose.camera.shift = 2.0 * jitter / extent;
        let [ray, ray_x, ray_y] = pose.camera.pixel_rays(aspect).map(|ray| ray.extend(0.0));
        let uniforms = FrameUniforms {
            view_projection: view_projection(&pose.camera, aspect),
            previous_view_projection: previous,
            eye: pose.camera.eye.extend(self.radius),
            background: self.gpu_scene.buffers().environment.background(&self.scene, &pose),
            ray,
            ray_x,
            ray_y,
            size,
            light_count,
            noise_frame: clock.noise_frame(),
            jitter,
            seed: self.resolved.seed,
            area_light_count,
            direct_lights: match self.resolved.direct {
                Direct::Soft => light_count + area_light_count,
                Direct::Paths => 0,
                Direct::Auto | Direct::Hard => light_count,
            },
            reflection_limit: self.passes.reflections.as_ref().map_or(-1.0, Reflections::limit),
            footprint: if self.resolved.antialiasing == Antialiasing::Taa { JITTERED_FOOTPRINT } else { 1.0 },
            tone_map: self.resolved.tone_map as u32,
        };
        FrameSetup { pose, uniforms, unjittered: [unjittered, previous] }
    }

    /// The world as the last frame showed it, but for `pose`.
    pub fn world<'a>(&'a self, pose: &'a Pose) -> World<'a> {
        World { scene: &self.scene, pose, bvh: &self.bvh }
    }
}

/// World to clip space.
fn view_projection(camera: &Camera, aspect: f32) -> Mat4 {
    camera.projection_matrix(aspect) * camera.view_matrix()
}
