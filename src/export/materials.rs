//! Materials as Mitsuba's BSDFs, with their textures.
//!
//! In: a material. Out: its `<bsdf>`, and the image files that it references.
//!
//! A surface is `twosided` `diffuse`, within a `mask` if it has an alpha mask. The base colour is multiplied into the
//! texels, at 16 bits a channel, since Mitsuba has no product of a colour and a texture. A GGX lobe is a
//! `roughconductor` of the same roughness, blended with the diffuse part so that both keep their mean reflectance.
//! Roughness and metallic are those of the mean of their textures.

use std::io::{self, Write};

use glam::Vec3;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError};

use super::xml::Element;
use super::{Content, Export, Specular, named};
use crate::bsdf::Bsdf;
use crate::scene::{AlphaMask, Material, Texture, srgb_to_linear};

/// A GGX lobe as a rough conductor.
struct Highlight {
    /// Reflectance: its mean albedo over that's largest channel.
    colour: Vec3,
    /// Blend weight: the largest channel of its mean albedo.
    weight: f32,
    /// GGX's alpha.
    alpha: f32,
}

impl Highlight {
    /// The lobe of a surface, if it has one.
    fn of(bsdf: &Bsdf) -> Option<Self> {
        let albedo = bsdf.mean_reflected_albedo();
        let weight = albedo.max_element();
        let alpha = bsdf.roughness * bsdf.roughness;
        (weight > 0.0).then(|| Self { colour: albedo / weight, weight, alpha })
    }
}

impl Export<'_> {
    /// Name of a material's BSDF.
    pub(super) fn bsdf_id(&self, material: u32) -> String {
        named("material", material as usize, &self.scene.materials[material as usize].name)
    }

    /// The BSDF of a material.
    pub(super) fn bsdf(&mut self, index: u32) -> Element {
        let material = &self.scene.materials[index as usize];
        let id = self.bsdf_id(index);
        let surface = Element::plugin("bsdf", "twosided").child(self.reflection(material));
        let Some(mask) = material.alpha_mask else { return surface.attribute("id", id) };
        let file = format!("textures/{}.png", named("mask", mask, ""));
        self.add_file(&file, Content::Mask(mask));
        let opacity = bitmap("opacity", &file, "nearest").boolean("raw", true);
        Element::plugin("bsdf", "mask").attribute("id", id).child(opacity).child(surface)
    }

    fn reflection(&mut self, material: &Material) -> Element {
        let bsdf = material.mean_bsdf(self.scene);
        let highlight = Highlight::of(&bsdf).filter(|_| self.settings.specular == Specular::Convert);
        let share = bsdf.mean_diffuse_share();
        let Some(Highlight { colour, weight, alpha }) = highlight else {
            return self.diffuse(material, share);
        };
        let conductor = |reflectance| {
            Element::plugin("bsdf", "roughconductor")
                .string("material", "none")
                .string("distribution", "ggx")
                .float("alpha", alpha.max(1e-3))
                .rgb("specular_reflectance", reflectance)
        };
        if share == 0.0 || bsdf.base == Vec3::ZERO {
            return conductor(colour * weight);
        }
        Element::plugin("bsdf", "blendbsdf")
            .float("weight", weight)
            .child(self.diffuse(material, share / (1.0 - weight)))
            .child(conductor(colour))
    }

    /// Lambertian reflection of a material's base colour times `share`.
    fn diffuse(&mut self, material: &Material, share: f32) -> Element {
        let surface = Element::plugin("bsdf", "diffuse");
        let tint = material.base_colour * share;
        let Some(texture) = material.base_colour_texture.map(|texture| texture.texture) else {
            return surface.rgb("reflectance", tint.min(Vec3::ONE));
        };
        // Materials may share an image with different tints.
        let known = self.tints.iter().position(|known| *known == (texture, tint));
        let place = known.unwrap_or_else(|| {
            self.tints.push((texture, tint));
            self.tints.len() - 1
        });
        let file = format!("textures/{}.png", named("texture", place, &self.scene.textures[texture].name));
        self.add_file(&file, Content::Texture { texture, tint });
        surface.child(bitmap("reflectance", &file, "bilinear"))
    }
}

/// A repeating image with 32-bit float texels.
fn bitmap(name: &str, file: &str, filter: &str) -> Element {
    Element::plugin("texture", "bitmap")
        .attribute("name", name)
        .string("filename", file)
        .string("filter_type", filter)
        .string("wrap_mode", "repeat")
        .string("format", "variant")
        .boolean("accel", false)
}

/// Writes a texture times `tint` as sRGB: 8 bits a channel, or 16 unless the tint is 1.
pub(super) fn write_texture(texture: &Texture, tint: Vec3, output: &mut dyn Write) -> io::Result<()> {
    let (width, height, texels) = &texture.levels[0];
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

/// Writes a mask: white where the surface is opaque, else black.
pub(super) fn write_mask(mask: &AlphaMask, output: &mut dyn Write) -> io::Result<()> {
    let is_there = |bit: u32| mask.bits[(bit / 32) as usize] >> (bit % 32) & 1 == 1;
    let bytes: Vec<u8> =
        (0..mask.width * mask.height).map(|bit| if is_there(bit) { 255 } else { 0 }).collect();
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
