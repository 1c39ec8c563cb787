//! Surfaces that rays hit, besides the buffers of raster passes: for shaders/include/hit.glsl.
//!
//! Rays hit any material, and without descriptor indexing a shader cannot choose among images, so all mip chains lie one after
//! the other in one texel buffer, a word for each texel of 8 bits a channel and two for half floats, which costs 5.3 bytes a
//! texel, or twice that, beside the images of raster, and the shader filters them.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::geometry::corners;
use super::{Named, to_u32};
use crate::scene::{Scene, Texture};
use crate::vulkan::{Buffer, Device, VulkanError};

/// A texture in the texel buffer; `TextureData` in shaders/include/textures.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct TextureData {
    /// First word of the first level.
    pub first: u32,
    /// Size of that, width in the lower 16 bits, height above.
    pub size: u32,
    /// Number of levels.
    pub levels: u32,
    /// 0: sRGB-encoded bytes; 1: linear bytes; 2: half floats, two words a texel.
    pub format: u32,
}

/// Triangles and textures of a scene in device memory.
pub struct HitBuffers {
    corners: Buffer,
    textures: Buffer,
    texels: Buffer,
}

impl HitBuffers {
    /// Uploads them: 12 bytes a triangle, 5.3 a texel.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn new(device: &Arc<Device>, scene: &Scene) -> Result<Self, VulkanError> {
        let Texels { table, texels } = Texels::of(scene, Buffer::most_rgba8_texels(device));
        Ok(Self {
            corners: Buffer::with_data(device, "corners", &corners(scene))?,
            textures: Buffer::with_data(device, "textures", &table)?,
            texels: Buffer::of_rgba8_texels(device, "texture_texels", &texels)?,
        })
    }

    /// Part of the scene set.
    pub fn resources(&self) -> [Named<'_>; 3] {
        [
            ("corners", (&self.corners).into()),
            ("textures", (&self.textures).into()),
            ("texture_texels", (&self.texels).into()),
        ]
    }
}

/// The levels of all textures.
struct Texels {
    table: Vec<TextureData>,
    texels: Vec<u8>,
}

impl Texels {
    /// At most `most` words: where there are more, the largest levels are left out.
    fn of(scene: &Scene, most: u64) -> Self {
        let mut firsts = vec![0; scene.textures.len()];
        let size = |texture: &Texture, first: usize| texture.levels[first].2.len() as u64 / 4;
        let total = |firsts: &[usize]| -> u64 {
            let of = |(texture, &first): (&Arc<Texture>, &usize)| -> u64 {
                (first..texture.levels.len()).map(|level| size(texture, level)).sum()
            };
            scene.textures.iter().zip(firsts).map(of).sum()
        };
        while total(&firsts) > most
            && let Some(largest) = (0..firsts.len())
                .filter(|&index| firsts[index] + 1 < scene.textures[index].levels.len())
                .max_by_key(|&index| size(&scene.textures[index], firsts[index]))
        {
            firsts[largest] += 1;
        }
        let mut store = Self { table: Vec::new(), texels: Vec::new() };
        for (texture, first) in scene.textures.iter().zip(firsts) {
            let levels = &texture.levels[first..];
            store.table.push(TextureData {
                first: to_u32(store.texels.len() / 4),
                size: levels[0].0 | levels[0].1 << 16,
                levels: to_u32(levels.len()),
                format: if texture.half { 2 } else { u32::from(texture.linear) },
            });
            levels.iter().for_each(|(_, _, texels)| store.texels.extend(texels));
        }
        store
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_levels_are_left_out_where_a_device_has_no_room() {
        let mut scene = Scene::new("textures");
        for (name, side) in [("small", 4), ("large", 16)] {
            let texture = Texture::from_rgba8(name, side, side, vec![7; 4 * (side * side) as usize]);
            scene.textures.push(texture.into());
        }
        // 16 + 4 + 1 and 256 + 64 + 16 + 4 + 1.
        let all = Texels::of(&scene, 1 << 20);
        assert_eq!((all.table[1].first, all.texels.len()), (21, 4 * 362));
        let some = Texels::of(&scene, 50);
        assert_eq!(some.texels.len(), 4 * 42);
        assert_eq!((some.table[1].size, some.table[1].levels), (4 | 4 << 16, 3));
        assert_eq!(Texels::of(&scene, 0).table.iter().map(|texture| texture.levels).sum::<u32>(), 2);
    }
}
