//! Inputs of the denoiser of indirect light for a frame, and the images that its output is joined with, so that a denoiser can run
//! again without the renderer.

use std::collections::BTreeMap;

use glam::{Affine3A, Mat4, Vec3};

use super::{RenderError, Renderer};
use crate::effects::reflections::Reflections;
use crate::passes::thin_surfaces::ThinSurfacesPass;
use crate::vulkan::Image;

/// One frame. Images have four channels a pixel, in rows from the top left, of which [`DenoiserFrame::CHANNELS`] count.
#[derive(Clone, Debug, PartialEq)]
pub struct DenoiserFrame {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Where the eye is; a pixel at (x, y) in -1..1 sees `eye + depth * (ray + x ray_x + y ray_y)`.
    pub eye: Vec3,
    /// See `eye`.
    pub rays: [Vec3; 3],
    /// World to clip space, without jitter.
    pub view_projection: Mat4,
    /// Object to world of each instance.
    pub instances: Vec<Affine3A>,
    /// Roughness up to which surfaces mirror, as in the frame uniforms.
    pub reflection_limit: f32,
    /// The images by the names that shaders give them.
    pub images: BTreeMap<&'static str, Vec<[f32; 4]>>,
}

impl DenoiserFrame {
    /// Images of every frame, with their channels.
    pub const CHANNELS: [(&'static str, usize); 8] = [
        ("gbuffer_depth", 1),
        ("gbuffer_normal", 4),
        ("gbuffer_albedo", 4),
        ("gbuffer_instance", 1),
        ("gbuffer_motion", 2),
        ("noisy", 4),
        ("direct", 4),
        ("specular_albedo", 4),
    ];
    /// Image of frames with reflection rays: 4 channels.
    pub const REFLECTION: &'static str = "reflection";
    /// Images of scenes with thin surfaces: 4 channels each.
    pub const THIN_SURFACES: [&'static str; 4] =
        ["thin_light", "thin_albedo", "thin_transmittance", "thin_mirrored"];
}

impl Renderer {
    /// Waits for the last frame and reads what its denoiser of indirect light was given, half floats and all as they were; none where no
    /// denoiser follows surfaces at the picture's size, as with an estimator whose frames are means already.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn read_denoiser_frame(&self) -> Result<Option<DenoiserFrame>, RenderError> {
        let signal = self.estimator.signal();
        let size = self.resolved.size;
        let is_noisy = signal.variance.is_none() && signal.noisy.extent() == size;
        let (Some(uniforms), Some(view_projection)) = (self.uniforms, self.unjittered) else {
            return Ok(None);
        };
        if !is_noisy || !self.passes.follows_surfaces {
            return Ok(None);
        }
        let (gbuffer, shading) = (self.passes.gbuffer.output(), &self.passes.direct.shading);
        let mut images = BTreeMap::from([
            ("gbuffer_depth", self.read_words(&gbuffer.depth, |word: [u32; 1]| f32::from_bits(word[0]))?),
            ("gbuffer_instance", self.read_words(&gbuffer.instance, |words: [u32; 2]| words[0] as f32)?),
            ("gbuffer_motion", self.read_halves(&gbuffer.motion, 2)?),
        ]);
        let mut halves = vec![
            ("gbuffer_normal", &gbuffer.normal),
            ("gbuffer_albedo", &gbuffer.albedo),
            ("noisy", signal.noisy),
            ("direct", shading.output()),
            ("specular_albedo", shading.specular_albedo()),
        ];
        halves.extend(
            self.passes
                .reflections
                .as_ref()
                .map(Reflections::output)
                .map(|image| (DenoiserFrame::REFLECTION, image)),
        );
        if let Some(thin) = self.passes.direct.thin_surfaces.as_ref().map(ThinSurfacesPass::output) {
            let thin = [&thin.light, &thin.albedo, &thin.transmittance, &thin.mirrored];
            halves.extend(DenoiserFrame::THIN_SURFACES.into_iter().zip(thin));
        }
        for (name, image) in halves {
            images.insert(name, self.read_halves(image, 4)?);
        }
        Ok(Some(DenoiserFrame {
            size,
            eye: uniforms.eye.truncate(),
            rays: [uniforms.ray, uniforms.ray_x, uniforms.ray_y].map(|ray| ray.truncate()),
            view_projection,
            instances: self.gpu_scene.buffers().transforms().to_vec(),
            reflection_limit: uniforms.reflection_limit,
            images,
        }))
    }

    /// The first channel of an image of `N` words a texel.
    fn read_words<const N: usize>(
        &self,
        image: &Image,
        value: impl Fn([u32; N]) -> f32,
    ) -> Result<Vec<[f32; 4]>, RenderError> {
        let bytes = image.read_layer(&self.device, 0, 4 * N as u64)?;
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(&bytes);
        let texel = |words: &[u32]| [value(std::array::from_fn(|index| words[index])), 0.0, 0.0, 0.0];
        Ok(words.chunks_exact(N).map(texel).collect())
    }
}
