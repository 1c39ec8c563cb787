//! Materials as Mitsuba's BSDFs, with their textures.
//!
//! In: a material. Out: its `<bsdf>`, and the image files that it references.
//!
//! A Lambertian surface is `twosided` `diffuse`. Others are `glowworm`, the BSDF of glowworm_bsdf.py; for those who render
//! without that file there is Mitsuba's `principled`, which comes near. Alpha masks, and the coverage of a thin surface,
//! are a `mask` around either. The base colour is multiplied into the texels, at 16 bits a channel, since Mitsuba has no
//! product of a colour and a texture; metallic and roughness likewise.

use std::io::{self, Cursor, Write};

use exr::prelude::{Encoding, Image, SpecificChannels, Vec2, WritableImage};
use glam::Vec3;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError};

use super::exporter::{Content, Export, Reader, named};
use super::remarks;
use super::xml::Element;
use crate::scene::{
    Alpha, AlphaMask, EnvironmentMap, Material, Texture, TextureUse, Wrap, luminance, srgb_to_linear,
};

/// Largest reflectance at normal incidence of a plain material: its index of refraction must be finite.
const MAX_PLAIN_F0: f32 = 0.9;

impl Export<'_> {
    /// Name of a material's BSDF.
    pub(super) fn bsdf_id(&self, material: u32) -> String {
        named("material", material as usize, &self.scene.materials[material as usize].name)
    }

    /// Whether Mitsuba has no material that is the same.
    pub(super) fn is_special(&self, index: u32) -> bool {
        let material = &self.scene.materials[index as usize];
        material.mean_bsdf(self.scene).reflects()
            || passed_share(material) > 0.0
            || material.normal_texture.is_some()
            || self.coloured.contains(&index)
    }

    /// The BSDF of a material.
    pub(super) fn bsdf(&mut self, index: u32, reader: Reader) -> Element {
        let material = &self.scene.materials[index as usize];
        let surface = match reader {
            _ if !self.is_special(index) => {
                let diffuse = Element::plugin("bsdf", "diffuse");
                two_sided(self.coloured(diffuse, "reflectance", material))
            }
            Reader::Plain => self.principled(material),
            Reader::Exact => self.glowworm(index),
        };
        self.cut(surface, material).attribute("id", self.bsdf_id(index))
    }

    /// Adds the mask or coverage of a material to its surface.
    fn cut(&mut self, surface: Element, material: &Material) -> Element {
        if !material.double_sided {
            self.remarks.insert(remarks::BACKS);
        }
        let masked = |opacity: Element| Element::plugin("bsdf", "mask").child(opacity);
        if material.alpha == Alpha::Blend {
            return masked(self.coverage(material)).child(surface);
        }
        match material.alpha_mask {
            Some(mask) if !material.is_thin_surface() => {
                let file = format!("textures/{}.png", named("mask", mask, ""));
                self.add_file(&file, Content::Mask(mask));
                if !self.scene.alpha_masks[mask].nearest {
                    self.remarks.insert(remarks::CUT_TEXELS);
                }
                let wrap = self.wrap_mode(self.scene.alpha_masks[mask].wrap);
                masked(bitmap("opacity", &file, "nearest", wrap).boolean("raw", true)).child(surface)
            }
            _ => surface,
        }
    }

    /// The coverage of a thin surface.
    fn coverage(&mut self, material: &Material) -> Element {
        let has_alpha = |image: &TextureUse| {
            let texture = &self.scene.textures[image.texture];
            let (width, height, _) = texture.levels[0];
            (0..width * height).any(|place| texture.texel(0, place).w < 1.0)
        };
        match material.base_colour_texture.filter(has_alpha) {
            Some(texture) => self.channel("opacity", texture, 3, material.opacity),
            None => float("opacity", material.opacity),
        }
    }

    /// The BSDF of glowworm_bsdf.py.
    fn glowworm(&mut self, index: u32) -> Element {
        let material = &self.scene.materials[index as usize];
        let surface = self.coloured(Element::plugin("bsdf", "glowworm"), "base_color", material);
        let surface = self
            .metallic_roughness(surface, material)
            .rgb("f0", material.f0)
            .float("f90", material.f90)
            .float("transmission", passed_share(material));
        let surface = match self.coloured.contains(&index) {
            true => surface.child(attribute("vertex_color")),
            false => surface,
        };
        let Some(map) = material.normal_texture else { return surface };
        surface
            .child(self.normal_map("normal_map", map))
            .float("normal_scale", material.normal_scale)
            .child(attribute("vertex_tangent"))
            .child(attribute("vertex_side"))
    }

    fn normal_map(&mut self, name: &str, map: TextureUse) -> Element {
        let content = Content::Texture { texture: map.texture, tint: Vec3::ONE };
        self.read(name, content, map, ["", "png"]).boolean("raw", true)
    }

    /// The nearest material of Mitsuba's own.
    fn principled(&mut self, material: &Material) -> Element {
        let surface = self.coloured(Element::plugin("bsdf", "principled"), "base_color", material);
        let root = luminance(material.f0).min(MAX_PLAIN_F0).sqrt();
        let surface = self.metallic_roughness(surface, material).float("eta", (1.0 + root) / (1.0 - root));
        let surface = match material.normal_texture {
            Some(map) => {
                let map = self.normal_map("normalmap", map);
                Element::plugin("bsdf", "normalmap").child(map).child(surface)
            }
            None => surface,
        };
        let passes = passed_share(material) * luminance(material.mean_base(self.scene));
        if passes > 0.0 {
            return Element::plugin("bsdf", "mask").float("opacity", 1.0 - passes).child(two_sided(surface));
        }
        two_sided(surface)
    }

    fn metallic_roughness(&mut self, surface: Element, material: &Material) -> Element {
        let values = [("metallic", 2, material.metallic), ("roughness", 1, material.roughness)];
        values.into_iter().fold(surface, |surface, (name, channel, factor)| {
            surface.child(match material.metallic_roughness_texture {
                Some(texture) if factor > 0.0 => self.channel(name, texture, channel, factor),
                _ => float(name, factor),
            })
        })
    }

    /// A number from a channel of a texture times `factor`.
    fn channel(&mut self, name: &str, image: TextureUse, channel: usize, factor: f32) -> Element {
        let content = Content::Channel { texture: image.texture, channel, factor };
        self.read(name, content, image, [&format!("{name}-"), "png"]).boolean("raw", true)
    }

    /// The surface with the parameter `name`: the base colour.
    fn coloured(&mut self, surface: Element, name: &str, material: &Material) -> Element {
        let tint = material.base_colour;
        let Some(image) = material.base_colour_texture else {
            return surface.rgb(name, tint.min(Vec3::ONE));
        };
        let content = Content::Texture { texture: image.texture, tint };
        surface.child(self.read(name, content, image, ["", "png"]))
    }

    /// The radiance of an emissive material; Mitsuba does not multiply it with the coverage.
    pub(super) fn radiance(&mut self, emitter: Element, material: &Material) -> Element {
        let coverage = if material.alpha == Alpha::Blend { material.opacity } else { 1.0 };
        let factor = material.emission * coverage;
        let Some(image) = material.emission_texture else {
            return emitter.rgb("radiance", factor);
        };
        let content = Content::Emission { texture: image.texture, factor };
        emitter.child(self.read("radiance", content, image, ["emission-", "exr"]).boolean("raw", true))
    }

    /// The parameter `name`: what a texture is read for, from a file with this start and end of its name. Materials may
    /// share a texture with different factors.
    fn read(&mut self, name: &str, content: Content, image: TextureUse, [start, end]: [&str; 2]) -> Element {
        let known = self.images.iter().position(|known| *known == content);
        let place = known.unwrap_or_else(|| {
            self.images.push(content);
            self.images.len() - 1
        });
        let texture = named("texture", place, &self.scene.textures[image.texture].name);
        let file = format!("textures/{start}{texture}.{end}");
        self.add_file(&file, content);
        let filter = if image.nearest { "nearest" } else { "bilinear" };
        bitmap(name, &file, filter, self.wrap_mode(image.wrap))
    }

    /// Mitsuba's name of a wrap mode; it has one for both axes.
    fn wrap_mode(&mut self, [u, v]: [Wrap; 2]) -> &'static str {
        if u != v {
            self.remarks.insert(remarks::WRAP_MODES);
        }
        match u {
            Wrap::Repeat => "repeat",
            Wrap::Mirror => "mirror",
            Wrap::Clamp => "clamp",
        }
    }
}

/// Share of the base colour that passes as through a thin surface. Metals let nothing pass.
fn passed_share(material: &Material) -> f32 {
    material.transmission * (1.0 - material.metallic)
}

fn two_sided(surface: Element) -> Element {
    Element::plugin("bsdf", "twosided").child(surface)
}

fn float(name: &str, value: f32) -> Element {
    Element::new("float").attribute("name", name).attribute("value", format!("{value:?}"))
}

/// A vertex attribute beside positions, normals and texture coordinates.
fn attribute(name: &str) -> Element {
    Element::plugin("texture", "mesh_attribute").attribute("name", name).string("name", name)
}

/// An image with 32-bit float texels.
fn bitmap(name: &str, file: &str, filter: &str, wrap: &str) -> Element {
    Element::plugin("texture", "bitmap")
        .attribute("name", name)
        .string("filename", file)
        .string("filter_type", filter)
        .string("wrap_mode", wrap)
        .string("format", "variant")
        .boolean("accel", false)
}

/// Writes a texture times `tint` as sRGB: 8 bits a channel, or 16 unless the tint is 1.
pub(super) fn write_texture(texture: &Texture, tint: Vec3, output: &mut dyn Write) -> io::Result<()> {
    let (width, height, texels) = &texture.levels[0];
    if texture.half {
        let colours = (0..width * height).map(|place| texture.texel(0, place).truncate() * tint);
        let words = colours.flat_map(|colour| colour.to_array().map(|value| encode_srgb16(f64::from(value))));
        let bytes: Vec<u8> = words.flat_map(u16::to_ne_bytes).collect();
        return write_png(output, &bytes, [*width, *height], ExtendedColorType::Rgb16);
    }
    let colours = texels.chunks_exact(4);
    if tint == Vec3::ONE {
        let bytes: Vec<u8> = colours.flat_map(|texel| [texel[0], texel[1], texel[2]]).collect();
        return write_png(output, &bytes, [*width, *height], ExtendedColorType::Rgb8);
    }
    let table: [[u16; 256]; 3] = tint.to_array().map(|factor| {
        std::array::from_fn(|texel| encode_srgb16(f64::from(factor) * f64::from(srgb_to_linear(texel as u8))))
    });
    let words = colours.flat_map(|texel| [0, 1, 2].map(|channel| table[channel][texel[channel] as usize]));
    let bytes: Vec<u8> = words.flat_map(u16::to_ne_bytes).collect();
    write_png(output, &bytes, [*width, *height], ExtendedColorType::Rgb16)
}

/// Writes a channel of a texture times `factor`, 16 bits.
pub(super) fn write_channel(
    texture: &Texture,
    channel: usize,
    factor: f32,
    output: &mut dyn Write,
) -> io::Result<()> {
    let (width, height, _) = texture.levels[0];
    let value = |place: u32| (texture.texel(0, place)[channel] * factor * 65_535.0).round() as u16;
    let bytes: Vec<u8> = (0..width * height).flat_map(|place| value(place).to_ne_bytes()).collect();
    write_png(output, &bytes, [width, height], ExtendedColorType::L16)
}

/// Writes a texture times `factor` as EXR, linear.
pub(super) fn write_emission(texture: &Texture, factor: Vec3, output: &mut dyn Write) -> io::Result<()> {
    let (width, height, _) = texture.levels[0];
    write_exr(output, [width as usize, height as usize], |x, y| {
        factor * texture.texel(0, y as u32 * width + x as u32).truncate()
    })
}

/// Writes a map times `factor` as EXR. Mitsuba interpolates between rows from pole to pole, glowworm between the middles
/// of rows; so there is a row for each middle and each edge, where it is the mean of its neighbours.
pub(super) fn write_environment(
    map: &EnvironmentMap,
    factor: Vec3,
    output: &mut dyn Write,
) -> io::Result<()> {
    let (width, height, texels) = map.texels();
    write_exr(output, [width, 2 * height + 1], |x, y| {
        let (above, below) = (y.saturating_sub(1) / 2, (y / 2).min(height - 1));
        factor * 0.5 * (texels[above * width + x] + texels[below * width + x])
    })
}

fn write_exr(
    output: &mut dyn Write,
    [width, height]: [usize; 2],
    colour: impl Fn(usize, usize) -> Vec3 + Sync,
) -> io::Result<()> {
    let pixel = |at: Vec2<usize>| {
        let Vec3 { x, y, z } = colour(at.x(), at.y());
        (x, y, z)
    };
    let mut image = Image::from_channels((width, height), SpecificChannels::rgb(pixel));
    image.layer_data.encoding = Encoding::FAST_LOSSLESS;
    let mut bytes = Vec::new();
    image.write().to_buffered(Cursor::new(&mut bytes)).map_err(io::Error::other)?;
    output.write_all(&bytes)
}

/// Writes a mask: white where the surface is opaque, else black.
pub(super) fn write_mask(mask: &AlphaMask, output: &mut dyn Write) -> io::Result<()> {
    let size = glam::Vec2::new(mask.width as f32, mask.height as f32);
    let centre = |place: u32| glam::Vec2::new((place % mask.width) as f32, (place / mask.width) as f32) + 0.5;
    let is_there = |place: u32| mask.opaque_at(centre(place) / size, 1.0);
    let bytes: Vec<u8> =
        (0..mask.width * mask.height).map(|place| if is_there(place) { 255 } else { 0 }).collect();
    write_png(output, &bytes, [mask.width, mask.height], ExtendedColorType::L8)
}

fn write_png(
    output: &mut dyn Write,
    bytes: &[u8],
    size: [u32; 2],
    kind: ExtendedColorType,
) -> io::Result<()> {
    PngEncoder::new(output).write_image(bytes, size[0], size[1], kind).map_err(|error| match error {
        ImageError::IoError(error) => error,
        other => io::Error::other(other),
    })
}

/// Encodes a linear channel as 16-bit sRGB (IEC 61966-2-1).
fn encode_srgb16(linear: f64) -> u16 {
    let l = linear.clamp(0.0, 1.0);
    let s = if l <= 0.003_130_8 { l * 12.92 } else { 1.055 * l.powf(1.0 / 2.4) - 0.055 };
    (s * 65_535.0).round() as u16
}
