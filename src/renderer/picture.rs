//! Reads the device's images back into a [`Picture`].

use std::f32::consts::PI;

use glam::{Vec2, Vec3, Vec4};

use super::shared::effect_image;
use super::{RenderError, Renderer};
use crate::effects::reflections::reflection_weight;
use crate::gpu_scene::structs::FrameUniforms;
use crate::output::{Layer, Picture};
use crate::passes::effect_view::Visualization;
use crate::passes::thin_surfaces::ThinSurfacesPass;
use crate::vulkan::Image;

/// Twin of MATERIAL in shaders/include/gbuffer.glsl.
const MATERIAL: u32 = 0x7fff_ffff;

/// Parts of the radiance of each pixel.
struct Light {
    /// Radiance over `specular_albedo`; a: share of it, where the rest is by irradiance.
    mirrored: Vec<[f32; 4]>,
    direct: Vec<[f32; 4]>,
    irradiance: Vec<[f32; 4]>,
    albedo: Vec<[f32; 4]>,
    specular_albedo: Vec<[f32; 4]>,
    /// Factor on radiance that a thin surface before the pixel mirrors.
    thin_mirrored: Vec<[f32; 4]>,
}

/// Light that thin surfaces add to each pixel, and their transmittance.
struct ThinSurfaceLight {
    light: Vec<[f32; 4]>,
    albedo: Vec<[f32; 4]>,
    transmittance: Vec<[f32; 4]>,
    mirrored: Vec<[f32; 4]>,
}

impl Light {
    /// As it is seen through thin surfaces. Roughness, the alpha of the albedo, stays that of the surface.
    fn behind(self, thin_surfaces: ThinSurfaceLight) -> Self {
        let passed = |light: Vec<[f32; 4]>, added: Option<&Vec<[f32; 4]>>| {
            let pass = |(pixel, mut light): (usize, [f32; 4])| {
                for channel in 0..3 {
                    let added = added.map_or(0.0, |added| added[pixel][channel]);
                    light[channel] = light[channel] * thin_surfaces.transmittance[pixel][channel] + added;
                }
                light
            };
            light.into_iter().enumerate().map(pass).collect()
        };
        Self {
            direct: passed(self.direct, Some(&thin_surfaces.light)),
            albedo: passed(self.albedo, Some(&thin_surfaces.albedo)),
            specular_albedo: passed(self.specular_albedo, None),
            mirrored: self.mirrored,
            irradiance: self.irradiance,
            thin_mirrored: thin_surfaces.mirrored,
        }
    }

    /// Radiance that the GGX lobe of each pixel reflects to the eye, without that of punctual lights. Twin: `radiance_at` in shaders/include/radiance.glsl.
    fn reflected(&self) -> Vec<[f32; 4]> {
        let of = |pixel: usize| {
            let (albedo, thin) = (self.specular_albedo[pixel], self.thin_mirrored[pixel]);
            let (e, mirrored) = (self.irradiance[pixel], self.mirrored[pixel]);
            let share = mirrored[3];
            std::array::from_fn(|i| {
                albedo[i] * (1.0 - share) * e[i] / PI + (albedo[i] * share + thin[i]) * mirrored[i]
            })
        };
        (0..self.mirrored.len()).map(of).collect()
    }
}

impl Renderer {
    /// Waits for the last frame and reads its picture; with `layers`, the G-buffer and both kinds of light too.
    pub fn read_picture(&self, layers: bool) -> Result<Picture, RenderError> {
        let [width, height] = self.resolved.size.map(|side| side as usize);
        let colour = match &self.passes.taa {
            Some(taa) if self.still == 0 => self.read_halves(taa.output(), 4)?,
            _ => self.read_halves(self.passes.combine.radiance(), 4)?,
        };
        let mut picture = Picture {
            width,
            height,
            colour: colour.into_iter().map(|[r, g, b, _]| [r, g, b]).collect(),
            display: self.read_display()?,
            ..Picture::default()
        };
        if layers {
            picture.layers = self.read_layers(&self.read_light()?)?;
        }
        Ok(picture)
    }

    /// Waits for the last frame and reads its picture as it would be without a denoiser of indirect light, before edges are smoothed,
    /// with the layers of [`Self::read_picture`] and `roughness`.
    pub fn read_noisy_picture(&self) -> Result<Picture, RenderError> {
        let [width, height] = self.resolved.size.map(|side| side as usize);
        let light = self.read_light()?;
        let light = Light { irradiance: self.read_halves(self.estimator.signal().noisy, 4)?, ..light };
        let reflected = light.reflected();
        let radiance = |pixel: usize| {
            let (direct, albedo) = (light.direct[pixel], light.albedo[pixel]);
            let (irradiance, reflected) = (light.irradiance[pixel], reflected[pixel]);
            [0, 1, 2].map(|i| direct[i] + albedo[i] / PI * irradiance[i] + reflected[i])
        };
        let mut layers = self.read_layers(&light)?;
        let roughness = light.albedo.iter().map(|albedo| albedo[3]).collect();
        layers.push(Layer::single("roughness", "Y", roughness));
        let colour = (0..width * height).map(radiance).collect();
        Ok(Picture { width, height, colour, layers, ..Picture::default() })
    }

    /// Waits for the last frame and reads what it shows: sRGB, in rows from the top left.
    pub fn read_display(&self) -> Result<Vec<[u8; 4]>, RenderError> {
        let display = self.passes.combine.display().read_layer(&self.device, 0, 4)?;
        Ok(bytemuck::cast_slice(&display).to_vec())
    }

    fn read_light(&self) -> Result<Light, RenderError> {
        let albedo = self.read_halves(&self.passes.gbuffer.output().albedo, 4)?;
        let light = Light {
            mirrored: self.read_mirrored(&albedo)?,
            thin_mirrored: vec![[0.0; 4]; albedo.len()],
            direct: self.read_halves(self.passes.direct.shading.output(), 4)?,
            irradiance: self.read_halves(self.irradiance(), 4)?,
            albedo,
            specular_albedo: self.read_halves(self.passes.direct.shading.specular_albedo(), 4)?,
        };
        let Some(thin_surfaces) = self.passes.direct.thin_surfaces.as_ref().map(ThinSurfacesPass::output)
        else {
            return Ok(light);
        };
        Ok(light.behind(ThinSurfaceLight {
            light: self.read_halves(&thin_surfaces.light, 4)?,
            albedo: self.read_halves(&thin_surfaces.albedo, 4)?,
            transmittance: self.read_halves(&thin_surfaces.transmittance, 4)?,
            mirrored: self.read_halves(&thin_surfaces.mirrored, 4)?,
        }))
    }

    /// [`Light::mirrored`] of surfaces of this albedo and roughness.
    fn read_mirrored(&self, albedo: &[[f32; 4]]) -> Result<Vec<[f32; 4]>, RenderError> {
        let Some(reflections) = &self.passes.reflections else { return Ok(vec![[0.0; 4]; albedo.len()]) };
        let radiance = self.read_halves(reflections.output(), 4)?;
        let share = |roughness| reflection_weight(roughness, reflections.limit());
        let of = |([r, g, b, _], albedo): ([f32; 4], &[f32; 4])| [r, g, b, share(albedo[3])];
        Ok(radiance.into_iter().zip(albedo).map(of).collect())
    }

    fn read_layers(&self, light: &Light) -> Result<Vec<Layer>, RenderError> {
        let gbuffer = self.passes.gbuffer.output();
        let depth: Vec<f32> = bytemuck::pod_collect_to_vec(&gbuffer.depth.read_layer(&self.device, 0, 4)?);
        let normal = self.read_halves(&gbuffer.normal, 4)?;
        let ids = gbuffer.instance.read_layer(&self.device, 0, 8)?;
        let ids: Vec<[u32; 2]> = bytemuck::cast_slice(&ids).to_vec();
        let seen = |index: usize| ids[index][0] > 0;
        let normals: Vec<[f32; 4]> = (0..normal.len())
            .map(|index| {
                let [x, y, ..] = normal[index];
                let n = if seen(index) { octahedral_decode(x, y) } else { glam::Vec3::ZERO };
                n.extend(0.0).to_array()
            })
            .collect();
        let packed = gbuffer.surface.read_layer(&self.device, 0, 8)?;
        let packed: Vec<[u32; 2]> = bytemuck::cast_slice(&packed).to_vec();
        let base: Vec<[f32; 4]> = packed.iter().map(|&[base, _]| unpack_base(base).to_array()).collect();
        let emission: Vec<[f32; 4]> = packed.iter().map(|&[_, emission]| unpack_emission(emission)).collect();
        let reflectance: Vec<[f32; 4]> = (0..ids.len())
            .map(|index| self.reflectance(ids[index], base[index], light.albedo[index][3]))
            .collect();
        let pixels = || (0..).flat_map(|y| (0..self.resolved.size[0]).map(move |x| [x, y]));
        let position: Vec<[f32; 4]> =
            pixels().zip(&depth).map(|(pixel, depth)| self.position(pixel, *depth)).collect();
        // From pixels to a fraction of the picture.
        let size = Vec2::from(self.resolved.size.map(|side| side as f32));
        let motion = self.read_halves(&gbuffer.motion, 2)?;
        let motion: Vec<[f32; 2]> = pixels()
            .zip(&motion)
            .zip(&depth)
            .map(|((pixel, &[x, y, ..]), &depth)| {
                let moved = if depth > 0.0 { Vec2::new(x, y) / size } else { self.background_motion(pixel) };
                moved.to_array()
            })
            .collect();
        let instances = ids.iter().map(|id| id[0] as f32 - 1.0).collect();
        let mut layers = vec![
            Layer::of_channels("direct", &["R", "G", "B"], &light.direct),
            Layer::of_channels("indirect", &["R", "G", "B"], &light.irradiance),
            Layer::of_channels("reflected", &["R", "G", "B"], &light.reflected()),
            Layer::of_channels("albedo", &["R", "G", "B"], &light.albedo),
            Layer::of_channels("normal", &["X", "Y", "Z"], &normals),
            Layer::of_channels("position", &["X", "Y", "Z"], &position),
            Layer::single("depth", "Z", depth),
            Layer::of_channels("base_colour", &["R", "G", "B", "metallic"], &base),
            Layer::of_channels("emission", &["R", "G", "B"], &emission),
            Layer::of_channels("reflectance", &["R", "G", "B", "roughness"], &reflectance),
            Layer::single("instance", "id", instances),
            Layer::of_channels("motion", &["X", "Y"], &motion),
        ];
        for effect in ["shadow", "reflection"] {
            layers.extend(self.effect_layers(effect)?);
        }
        Ok(layers)
    }

    /// Layers of an effect, if it is in use: the signal, and for the denoiser its standard deviation and its history.
    fn effect_layers(&self, effect: &str) -> Result<Vec<Layer>, RenderError> {
        let (direct, reflections) = (&self.passes.direct, self.passes.reflections.as_ref());
        let mut layers = Vec::new();
        for stage in ["", "-raw", "-temporal", "-variance", "-history"] {
            let view = format!("{effect}{stage}");
            let Some((image, kind)) = effect_image(direct, reflections, &view) else { continue };
            let texels = self.read_halves(image, 4)?;
            let name = view.replace('-', "_");
            layers.push(match kind {
                Visualization::Share | Visualization::Light | Visualization::Irradiance => {
                    Layer::of_channels(&name, &["R", "G", "B"], &texels)
                }
                Visualization::Deviation => {
                    Layer::single(&name, "variance", texels.iter().map(|texel| texel[3] * texel[3]).collect())
                }
                Visualization::History => {
                    Layer::single(&name, "frames", texels.iter().map(|texel| texel[2]).collect())
                }
            });
        }
        Ok(layers)
    }

    /// Reflectance at normal incidence and roughness of a pixel, from the G-buffer's instance channel, its base colour with
    /// metallic, and its roughness.
    fn reflectance(&self, [instance, material]: [u32; 2], base: [f32; 4], roughness: f32) -> [f32; 4] {
        let material = self.scene.materials.get((material & MATERIAL) as usize).filter(|_| instance > 0);
        let [r, g, b, metallic] = base;
        material.map_or([0.0; 4], |material| {
            material.f0.lerp(Vec3::new(r, g, b), metallic).extend(roughness).to_array()
        })
    }

    /// Where a pixel sees a surface at a view depth, in the world; 0 where it sees none. Twin: `position_at` in
    /// shaders/include/frame.glsl.
    fn position(&self, pixel: [u32; 2], depth: f32) -> [f32; 4] {
        let Some(uniforms) = self.uniforms.filter(|_| depth > 0.0) else { return [0.0; 4] };
        let (ray, _) = self.pixel_ray(&uniforms, pixel);
        (uniforms.eye + depth * ray + self.anchor.extend(0.0)).to_array()
    }

    /// The ray through a pixel, and the place of that in the picture, 0 to 1.
    fn pixel_ray(&self, uniforms: &FrameUniforms, pixel: [u32; 2]) -> (Vec4, Vec2) {
        let [pixel, size] = [pixel, self.resolved.size].map(|of| Vec2::from(of.map(|side| side as f32)));
        let place = (pixel + 0.5) / size;
        let at = 2.0 * place - 1.0;
        (uniforms.ray + at.x * uniforms.ray_x + at.y * uniforms.ray_y, place + uniforms.jitter / size)
    }

    /// How far what lies behind all surfaces has moved since the last frame, as a fraction of the picture. Twin: `motion_at` in
    /// shaders/passes/taa.comp.
    fn background_motion(&self, pixel: [u32; 2]) -> Vec2 {
        let turned = |uniforms: &FrameUniforms| Some(uniforms.previous_view_projection) != self.unjittered;
        let Some(uniforms) = self.uniforms.filter(turned) else { return Vec2::ZERO };
        let (ray, place) = self.pixel_ray(&uniforms, pixel);
        let then = uniforms.previous_view_projection * ray;
        if then.w > 0.0 { place - (then.truncate().truncate() / then.w * 0.5 + 0.5) } else { Vec2::ONE }
    }

    pub(super) fn read_halves(&self, image: &Image, channels: usize) -> Result<Vec<[f32; 4]>, RenderError> {
        let bytes = image.read_layer(&self.device, 0, channels as u64 * 2)?;
        let halves: Vec<u16> = bytemuck::pod_collect_to_vec(&bytes);
        let widen = |texel: &[u16]| {
            let mut wide = [0.0; 4];
            for (target, source) in wide.iter_mut().zip(texel) {
                *target = exr::prelude::f16::from_bits(*source).to_f32();
            }
            wide
        };
        Ok(halves.chunks_exact(channels).map(widen).collect())
    }
}

/// Twin of `octahedral_decode` in shaders/include/gbuffer.glsl.
fn octahedral_decode(x: f32, y: f32) -> glam::Vec3 {
    let z = 1.0 - x.abs() - y.abs();
    let sign = |v: f32| if v >= 0.0 { 1.0 } else { -1.0 };
    let (x, y) = if z < 0.0 { ((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y)) } else { (x, y) };
    glam::Vec3::new(x, y, z).normalize()
}

/// Twin of `unpack_base` in shaders/include/gbuffer.glsl.
fn unpack_base(packed: u32) -> Vec4 {
    let [r, g, b, metallic] = packed.to_le_bytes().map(|byte| f32::from(byte) / 255.0);
    Vec4::new(r * r, g * g, b * b, metallic)
}

/// Twin of `unpack_emission` in shaders/include/gbuffer.glsl.
fn unpack_emission(packed: u32) -> [f32; 4] {
    let scale = ((packed >> 27) as f32 - 24.0).exp2();
    let [r, g, b] = [0, 9, 18].map(|shift| (packed >> shift & 511) as f32 * scale);
    [r, g, b, 0.0]
}
