//! Inputs of every estimator, effect and denoiser for a frame; always complete.

use super::clock::FrameClock;
use super::gbuffer::GBuffer;
use super::reprojection::Reprojection;
use crate::scene::Pose;
use crate::vulkan::{Pass, SharedSet, Upload};

/// The inputs of one frame.
pub struct FrameInputs<'a> {
    /// `FrameUniforms`.
    pub uniforms: &'a Upload,
    /// Set 1: the scene.
    pub scene: &'a SharedSet<'a>,
    /// The visible surfaces.
    pub gbuffer: &'a GBuffer,
    /// The surfaces of this and the last frame, and where each was then; of one texel where nothing follows surfaces.
    pub reprojection: &'a Reprojection,
    /// The frame's number, and its place among the still frames.
    pub clock: FrameClock,
    /// Where everything stands, with the camera where it samples the pixels.
    pub pose: &'a Pose,
}

impl FrameInputs<'_> {
    /// Binds frame uniforms, the scene, and depth and normals of the visible surfaces.
    pub fn bind<'f>(&'f self, pass: Pass<'f>) -> Pass<'f> {
        pass.read("frame_uniforms", self.uniforms)
            .read("gbuffer_depth", &self.gbuffer.depth)
            .read("gbuffer_normal", &self.gbuffer.normal)
            .shared(self.scene)
    }
}
