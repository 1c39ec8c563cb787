//! Made-up signals and surfaces on a device, and a denoiser over them.

#![allow(dead_code, reason = "each test program uses a part")]

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use exr::prelude::f16;
use glam::{IVec2, Mat4, Vec2, Vec3, Vec4};
use glowworm::denoise::svgf::Svgf;
use glowworm::denoise::{Denoiser, DenoiserInputs, Use};
use glowworm::gpu_scene::structs::FrameUniforms;
use glowworm::settings::SvgfSettings;
use glowworm::vulkan::{ComputePipeline, Device, Frames, Image, ImageDescription, shaders, vk};

/// Odd, so that the last groups of threads are cut.
pub const WIDTH: usize = 67;
pub const HEIGHT: usize = 45;
/// Tangents of half the field of view.
const HALF_VIEW: Vec2 = Vec2::new(0.8, 0.8 * HEIGHT as f32 / WIDTH as f32);

/// The denoiser's inputs of a pixel. Twin of `DenoiserPixel` in shaders/test/fill_denoiser_inputs.comp.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Pixel {
    pub noisy: [f32; 4],
    pub normals: [f32; 4],
    pub reprojected: [f32; 4],
    pub depth: f32,
    pub pad: [u32; 3],
}

fn octahedral_encode(n: Vec3) -> Vec2 {
    let p = Vec2::new(n.x, n.y) / (n.x.abs() + n.y.abs() + n.z.abs());
    let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    if n.z >= 0.0 { p } else { Vec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y)) }
}

fn octahedral_decode(p: Vec2) -> Vec3 {
    let mut n = Vec3::new(p.x, p.y, 1.0 - p.x.abs() - p.y.abs());
    if n.z < 0.0 {
        let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
        (n.x, n.y) = ((1.0 - n.y.abs()) * sign(n.x), (1.0 - n.x.abs()) * sign(n.y));
    }
    n.normalize()
}

impl Pixel {
    /// A surface with one normal and no motion: the history of a pixel is its own.
    pub fn stationary(light: Vec3, normal: Vec3, depth: f32) -> Self {
        let place = octahedral_encode(normal).to_array().map(|part| f16::from_f32(part).to_f32());
        let [x, y] = place;
        Self {
            noisy: light.extend(1.0).to_array().map(|part| f16::from_f32(part).to_f32()),
            normals: [x, y, x, y],
            reprojected: [0.0, 0.0, 15.0, 0.0],
            depth,
            pad: [0; 3],
        }
    }

    pub fn geometric(&self) -> Vec3 {
        octahedral_decode(Vec2::new(self.normals[2], self.normals[3]))
    }

    /// The shading normal, with 10 bits a component.
    pub fn packed_shading(&self) -> Vec3 {
        let packed = |part: f32| ((part * 0.5 + 0.5) * 1023.0 + 0.5).floor() * (2.0 / 1023.0) - 1.0;
        octahedral_decode(Vec2::new(packed(self.normals[0]), packed(self.normals[1])))
    }
}

/// The eye is the origin, the view goes along -z.
pub fn position_at(pixel: IVec2, depth: f32) -> Vec3 {
    let at = (pixel.as_vec2() + 0.5) * 2.0 / Vec2::new(WIDTH as f32, HEIGHT as f32) - 1.0;
    depth * Vec3::new(at.x * HALF_VIEW.x, -at.y * HALF_VIEW.y, -1.0)
}

/// Width of a pixel at a depth.
pub fn footprint(depth: f32) -> f32 {
    depth * HALF_VIEW.y * 2.0 / HEIGHT as f32
}

/// Depth of a plane through `point` in each pixel's middle; none where the ray misses it.
pub fn plane_depth(pixel: IVec2, point: Vec3, normal: Vec3) -> Option<f32> {
    let depth = point.dot(normal) / position_at(pixel, 1.0).dot(normal);
    (depth > 0.0 && depth.is_finite()).then_some(depth)
}

/// A pixel for each place of the picture.
pub fn pixels(of: impl FnMut(IVec2) -> Pixel) -> Vec<Pixel> {
    let places = (0..HEIGHT as i32).flat_map(|y| (0..WIDTH as i32).map(move |x| IVec2::new(x, y)));
    places.map(of).collect()
}

/// A wall that faces the eye, lit by `light`.
pub fn wall(mut light: impl FnMut(usize) -> Vec3) -> Vec<Pixel> {
    let mut count = 0;
    pixels(|_| {
        count += 1;
        Pixel::stationary(light(count - 1), Vec3::Z, 4.0)
    })
}

/// The eye is the origin, now and a frame ago, the view goes along -z, and the clip space's w is the depth.
pub fn uniforms() -> FrameUniforms {
    let depth = Mat4::from_cols(Vec4::ZERO, Vec4::ZERO, Vec4::new(0.0, 0.0, 0.0, -1.0), Vec4::ZERO);
    FrameUniforms {
        view_projection: depth,
        previous_view_projection: depth,
        ray: Vec4::new(0.0, 0.0, -1.0, 0.0),
        ray_x: Vec4::new(HALF_VIEW.x, 0.0, 0.0, 0.0),
        ray_y: Vec4::new(0.0, -HALF_VIEW.y, 0.0, 0.0),
        size: [WIDTH as u32, HEIGHT as u32],
        ..FrameUniforms::default()
    }
}

/// The denoiser with its inputs.
pub struct Bench<Kind = Svgf> {
    device: Arc<Device>,
    pub frames: Frames,
    fill: ComputePipeline,
    noisy: Image,
    pub normal: Image,
    reprojected: Image,
    pub depth: Image,
    surface: Image,
    pub denoiser: Kind,
    extent: [u32; 2],
    /// Whether all surfaces are rough, which are mirrors otherwise.
    pub is_rough: bool,
    pub light_is_wide: bool,
}

/// Texels of an image of four half floats.
pub fn texels(device: &Arc<Device>, image: &Image) -> Vec<Vec4> {
    let bytes = image.read_layer(device, 0, 8).unwrap();
    let halves: Vec<u16> = bytemuck::pod_collect_to_vec(&bytes);
    let texel = |parts: &[u16]| Vec4::from_slice(&[0, 1, 2, 3].map(|i| f16::from_bits(parts[i]).to_f32()));
    halves.chunks_exact(4).map(texel).collect()
}

impl Bench<Svgf> {
    pub fn new(device: &Arc<Device>, settings: &SvgfSettings) -> Self {
        Self::of_size(device, [WIDTH as u32, HEIGHT as u32], settings)
    }

    pub fn of_size(device: &Arc<Device>, extent: [u32; 2], settings: &SvgfSettings) -> Self {
        Self::of(device, extent, Svgf::new(device, Use::Reflections, extent, settings).unwrap())
    }

    pub fn output(&self) -> Vec<Vec4> {
        self.read(Svgf::output)
    }
}

impl<Kind: Denoiser> Bench<Kind> {
    pub fn of(device: &Arc<Device>, extent: [u32; 2], denoiser: Kind) -> Self {
        let image = |name, format| {
            let usage = vk::ImageUsageFlags::STORAGE;
            let description = ImageDescription { name, format, extent, layers: None, levels: 1, usage };
            Image::new(device, &description).unwrap()
        };
        let halves = vk::Format::R16G16B16A16_SFLOAT;
        Self {
            frames: Frames::new(device).unwrap(),
            fill: ComputePipeline::new(device, "fill", shaders::FILL_DENOISER_INPUTS_COMP).unwrap(),
            noisy: image("noisy", halves),
            normal: image("normal", halves),
            reprojected: image("reprojected", halves),
            depth: image("depth", vk::Format::R32_SFLOAT),
            surface: image("surface", vk::Format::R16G16B16A16_UINT),
            denoiser,
            extent,
            is_rough: false,
            light_is_wide: false,
            device: Arc::clone(device),
        }
    }

    /// Denoises one frame.
    pub fn denoise(&mut self, pixels: &[Pixel]) {
        let (mut frame, _) = self.frames.begin().unwrap();
        let uniforms = frame.upload(&[FrameUniforms { size: self.extent, ..uniforms() }]).unwrap();
        let uploaded = frame.upload(pixels).unwrap();
        frame
            .pass("fill", &self.fill)
            .read("frame_uniforms", &uniforms)
            .read("pixels", &uploaded)
            .write("noisy", &self.noisy)
            .write("gbuffer_normal", &self.normal)
            .write("reprojected", &self.reprojected)
            .write("gbuffer_depth", &self.depth)
            .write("surface", &self.surface)
            .dispatch_over(self.extent)
            .unwrap();
        let inputs = DenoiserInputs {
            uniforms: &uniforms,
            noisy: &self.noisy,
            variance: None,
            depth: &self.depth,
            normal: &self.normal,
            surface: &self.surface,
            // The denoiser reads the last channel only: 1 of the signal, 0 of a normal that faces the eye.
            albedo: if self.is_rough { &self.noisy } else { &self.normal },
            reprojected: &self.reprojected,
            camera_moves: false,
            light_is_wide: self.light_is_wide,
        };
        self.denoiser.record(&mut frame, &inputs).unwrap();
        frame.submit().unwrap();
    }

    pub fn read(&self, image: impl Fn(&Kind) -> &Image) -> Vec<Vec4> {
        texels(&self.device, image(&self.denoiser))
    }
}
