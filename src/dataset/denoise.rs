//! A denoiser over the frames of a data set, on a device.
//!
//! In: frames, in order. Out: the pictures that the renderer would show without antialiasing. It runs the renderer's own passes:
//! reprojection, the denoiser of indirect light, `radiance` and the tone map.

use std::collections::BTreeMap;
use std::sync::Arc;

use bytemuck::cast_slice;
use exr::prelude::f16;
use glam::{Affine3A, Mat4, Vec3};

use crate::bvh::TwoLevelBvh;
use crate::denoise::{
    self, Denoiser, DenoiserDescription, DenoiserInputs, DenoiserSettings, SignalNoise, Use,
};
use crate::gpu_scene::GpuScene;
use crate::gpu_scene::structs::FrameUniforms;
use crate::gpu_scene::tracer::RayTracer;
use crate::output::Picture;
use crate::passes::combine::{CombineInputs, CombinePass};
use crate::passes::reprojection::{ReprojectionInputs, ReprojectionPass};
use crate::passes::thin_surfaces::ThinSurfaceImages;
use crate::renderer::DenoiserFrame;
use crate::scene::{Instance, Material, Mesh, Pose, Scene};
use crate::settings::Settings;
use crate::vulkan::{Device, Frames, Image, ImageDescription, VulkanError, vk};

/// A frame that was denoised.
#[derive(Clone, Debug)]
pub struct DenoisedFrame {
    /// Radiance, and what is shown of it.
    pub picture: Picture,
    /// Milliseconds of each pass on the device, in order; a name may occur several times.
    pub passes: Vec<(&'static str, f64)>,
}

/// The denoiser with its history.
pub struct DatasetDenoiser {
    settings: Settings,
    images: BTreeMap<&'static str, Image>,
    thin_surfaces: Option<ThinSurfaceImages>,
    reprojection: ReprojectionPass,
    denoiser: Box<dyn Denoiser>,
    combine: CombinePass,
    /// Instances that stand where those of the frames do, of a mesh that is not seen.
    scene: Scene,
    bvh: TwoLevelBvh,
    gpu_scene: GpuScene,
    /// World to clip space in the last frame.
    last: Option<Mat4>,
    // After what frames in flight use; see `drop`.
    frames: Frames,
    device: Arc<Device>,
}

impl DatasetDenoiser {
    /// Makes the denoiser that `settings`, which were checked, name, for frames with the images, the size and as many instances as
    /// `first` has.
    ///
    /// # Errors
    /// Where the device does not support them.
    pub fn new(
        device: &Arc<Device>,
        settings: &Settings,
        first: &DenoiserFrame,
    ) -> Result<Self, VulkanError> {
        let (scene, extent) = (stand_ins(first.instances.len()), first.size);
        let bvh = TwoLevelBvh::build(&scene, &vec![Affine3A::IDENTITY; scene.instances.len()]);
        let description = DenoiserDescription {
            usage: Use::Indirect,
            noise: SignalNoise::Unknown,
            extent,
            settings: DenoiserSettings::of(settings, Use::Indirect),
        };
        let mut images = BTreeMap::new();
        for name in first.images.keys().copied().filter(|name| !DenoiserFrame::THIN_SURFACES.contains(name)) {
            images.insert(name, image(device, name, extent)?);
        }
        let is_thin = DenoiserFrame::THIN_SURFACES.iter().all(|name| first.images.contains_key(name));
        let thin_surfaces = || {
            let [light, albedo, transmittance, mirrored] =
                DenoiserFrame::THIN_SURFACES.map(|name| image(device, name, extent));
            Ok(ThinSurfaceImages {
                light: light?,
                albedo: albedo?,
                transmittance: transmittance?,
                mirrored: mirrored?,
            })
        };
        Ok(Self {
            settings: settings.clone(),
            images,
            thin_surfaces: is_thin.then(thin_surfaces).transpose()?,
            reprojection: ReprojectionPass::new(device, extent, settings.effects.reprojection_tests())?,
            denoiser: denoise::make(device, &description)?,
            combine: CombinePass::new(device, is_thin, extent)?,
            gpu_scene: GpuScene::new(device, &scene, RayTracer::Software, &bvh)?,
            scene,
            bvh,
            last: None,
            frames: Frames::new(device)?,
            device: Arc::clone(device),
        })
    }

    /// The reason why a frame cannot follow the first one, if there is one.
    pub fn misfit(&self, given: &DenoiserFrame) -> Option<String> {
        let (instances, needed) = (given.instances.len().max(1), self.scene.instances.len());
        let thin: &[_] = if self.thin_surfaces.is_some() { &DenoiserFrame::THIN_SURFACES } else { &[] };
        let lacking = self.images.keys().chain(thin).find(|name| !given.images.contains_key(*name));
        match lacking {
            Some(name) => Some(format!("has no layer {name}, but frame 0 has")),
            None if instances != needed => {
                Some(format!("has {instances} instances, but frame 0 has {needed}"))
            }
            None => None,
        }
    }

    /// Denoises the next frame and waits for it.
    ///
    /// # Errors
    /// Where the device fails.
    ///
    /// # Panics
    /// If the frame is a [`Self::misfit`].
    pub fn denoise(&mut self, given: &DenoiserFrame) -> Result<DenoisedFrame, VulkanError> {
        self.upload(given)?;
        let uniforms = self.uniforms(given);
        let camera_moves = self.last.is_some_and(|last| last != given.view_projection);
        self.last = Some(given.view_projection);
        let pose = Pose {
            camera: self.scene.camera,
            lights: Vec::new(),
            instances: if given.instances.is_empty() {
                vec![Affine3A::IDENTITY]
            } else {
                given.instances.clone()
            },
            environment: None,
        };
        let images = &self.images;
        let (mut frame, _) = self.frames.begin()?;
        let uploaded = &self.gpu_scene.upload(&mut frame, (&self.scene, &pose), &self.bvh)?;
        let scene = &self.gpu_scene.set(&mut frame, uploaded)?;
        let uniforms = &frame.upload(&[uniforms])?;

        // Find the surfaces in the last frame.
        let [depth, normal, albedo] =
            ["gbuffer_depth", "gbuffer_normal", "gbuffer_albedo"].map(|name| &images[name]);
        let (instance, motion) = (&images["gbuffer_instance"], &images["gbuffer_motion"]);
        let surfaces = ReprojectionInputs { uniforms, scene, depth, normal, instance, motion };
        self.reprojection.record(&mut frame, &surfaces)?;

        // Denoise, and join all light.
        let (noisy, followed) = (&images["noisy"], self.reprojection.output());
        let inputs = DenoiserInputs {
            uniforms,
            noisy,
            variance: None,
            depth,
            normal,
            surface: followed.surface(),
            albedo,
            reprojected: &followed.reprojected,
            camera_moves,
            light_is_wide: false,
        };
        self.denoiser.record(&mut frame, &inputs)?;
        let joined = CombineInputs {
            frame: uniforms,
            direct: &images["direct"],
            irradiance: self.denoiser.output(noisy),
            albedo,
            specular_albedo: &images["specular_albedo"],
            thin_surfaces: self.thin_surfaces.as_ref(),
            reflection: images.get(DenoiserFrame::REFLECTION),
        };
        self.combine.record(&mut frame, &joined)?;
        self.combine.tone_map(&mut frame, uniforms, self.combine.radiance(), self.settings.exposure)?;
        frame.submit()?;
        let times = self.frames.finish()?.pop().unwrap_or_default();
        Ok(DenoisedFrame { picture: self.read(given.size)?, passes: times.passes })
    }

    fn upload(&self, given: &DenoiserFrame) -> Result<(), VulkanError> {
        let thin = self.thin_surfaces.iter().flat_map(|thin| {
            let images = [&thin.light, &thin.albedo, &thin.transmittance, &thin.mirrored];
            DenoiserFrame::THIN_SURFACES.into_iter().zip(images)
        });
        for (name, image) in self.images.iter().map(|(name, image)| (*name, image)).chain(thin) {
            let (texels, texel_bytes) = texels_of(name, &given.images[name]);
            image.write(&self.device, &texels, texel_bytes)?;
        }
        Ok(())
    }

    fn uniforms(&self, given: &DenoiserFrame) -> FrameUniforms {
        let [ray, ray_x, ray_y] = given.rays.map(|ray| ray.extend(0.0));
        FrameUniforms {
            view_projection: given.view_projection,
            previous_view_projection: self.last.unwrap_or(given.view_projection),
            eye: given.eye.extend(0.0),
            ray,
            ray_x,
            ray_y,
            size: given.size,
            reflection_limit: given.reflection_limit,
            footprint: 1.0,
            tone_map: self.settings.tone_map as u32,
            ..FrameUniforms::default()
        }
    }

    fn read(&self, size: [u32; 2]) -> Result<Picture, VulkanError> {
        let [width, height] = size.map(|side| side as usize);
        let bytes = self.combine.radiance().read_layer(&self.device, 0, 8)?;
        let halves: Vec<u16> = bytemuck::pod_collect_to_vec(&bytes);
        let colour = |texel: &[u16]| [0, 1, 2].map(|index| f16::from_bits(texel[index]).to_f32());
        let display = self.combine.display().read_layer(&self.device, 0, 4)?;
        Ok(Picture {
            width,
            height,
            colour: halves.chunks_exact(4).map(colour).collect(),
            display: bytemuck::pod_collect_to_vec(&display),
            ..Picture::default()
        })
    }
}

impl Drop for DatasetDenoiser {
    fn drop(&mut self) {
        // A frame in flight may still use the images of the passes.
        let _ = self.device.wait_idle();
    }
}

/// A scene of `count` instances, or of one, since no buffer is empty.
fn stand_ins(count: usize) -> Scene {
    let mut scene = Scene::new("data set");
    scene.materials.push(Material::grey("none"));
    scene.meshes.push(Arc::new(Mesh::polygon("none", &[Vec3::ZERO, Vec3::X, Vec3::Y], 0)));
    let instance = Instance {
        name: "none".to_owned(),
        mesh: 0,
        transform: Affine3A::IDENTITY,
        animation: None,
        dynamic: false,
        visible: true,
    };
    scene.instances = vec![instance; count.max(1)];
    scene
}

/// Twin: the formats of `GBuffer` and of the passes' images.
fn format_of(name: &str) -> vk::Format {
    match name {
        "gbuffer_depth" => vk::Format::R32_SFLOAT,
        "gbuffer_instance" => vk::Format::R32G32_UINT,
        "gbuffer_motion" => vk::Format::R16G16_SFLOAT,
        _ => vk::Format::R16G16B16A16_SFLOAT,
    }
}

fn image(device: &Arc<Device>, name: &str, extent: [u32; 2]) -> Result<Image, VulkanError> {
    let format = format_of(name);
    let is_storage = !matches!(format, vk::Format::R32G32_UINT | vk::Format::R16G16_SFLOAT);
    let usage = if is_storage { vk::ImageUsageFlags::STORAGE } else { vk::ImageUsageFlags::empty() };
    Image::new(device, &ImageDescription { name, format, extent, layers: None, levels: 1, usage })
}

/// Pixels in the format of their image, and its bytes a texel.
fn texels_of(name: &str, pixels: &[[f32; 4]]) -> (Vec<u8>, u64) {
    match format_of(name) {
        vk::Format::R32_SFLOAT => {
            (cast_slice(&pixels.iter().map(|pixel| pixel[0]).collect::<Vec<_>>()).to_vec(), 4)
        }
        vk::Format::R32G32_UINT => {
            (cast_slice(&pixels.iter().map(|pixel| [pixel[0] as u32, 0]).collect::<Vec<_>>()).to_vec(), 8)
        }
        vk::Format::R16G16_SFLOAT => (cast_slice(&halves::<2>(pixels)).to_vec(), 4),
        _ => (cast_slice(&halves::<4>(pixels)).to_vec(), 8),
    }
}

/// Rounded to nearest, as the shaders do, and no further than the largest half; infinity and NaN stay so.
fn halves<const N: usize>(pixels: &[[f32; 4]]) -> Vec<[u16; N]> {
    let bound = f16::MAX.to_f32();
    let half = |value: f32| f16::from_f32(if value.is_finite() { value.clamp(-bound, bound) } else { value });
    pixels.iter().map(|pixel| std::array::from_fn(|index| half(pixel[index]).to_bits())).collect()
}
