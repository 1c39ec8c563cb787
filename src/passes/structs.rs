//! The structs that shaders and Rust share (std140 and std430), besides those of `bvh`, `vpl` and `cast_rays`. A test
//! compares every member's offset with the compiled shaders.

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec4};

/// What every pass of a frame may want to know; `FrameUniforms` in shaders/include/frame.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct FrameUniforms {
    /// World to clip, reversed depth.
    pub view_projection: Mat4,
    /// The same, one frame ago.
    pub previous_view_projection: Mat4,
    /// xyz: world position; w: radius of the scene's bounding sphere.
    pub eye: Vec4,
    /// rgb: radiance where no surface is; w: clamp c of the geometry term in 1/m^2, 0: none.
    pub background: Vec4,
    /// xyz: view direction. A pixel at (x, y) in -1..1 sees `eye + depth * (ray + x ray_x + y ray_y)`.
    pub ray: Vec4,
    /// xyz: right times the tangent of half the horizontal field of view.
    pub ray_x: Vec4,
    /// xyz: down times the tangent of half the vertical field of view.
    pub ray_y: Vec4,
    /// Of the picture, texels.
    pub size: [u32; 2],
    /// n.
    pub interleave: u32,
    /// Lights with shadow maps.
    pub light_count: u32,
    /// Fraction of view depth.
    pub position_cutoff: f32,
    /// Set buffers hold irradiance times this.
    pub irradiance_scale: f32,
    /// Packed depths are view depths times this, so that half floats can hold them.
    pub depth_scale: f32,
    /// One over the luminous irradiance below which a VPL gets only some of its rays.
    pub roulette: f32,
}

/// A placed mesh; `InstanceData` in shaders/include/scene.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct InstanceData {
    /// Rows of the 3x4 matrix.
    pub object_to_world: [Vec4; 3],
    /// Rows of the 3x4 matrix.
    pub world_to_object: [Vec4; 3],
    /// Rows of the 3x4 matrix, one frame ago.
    pub previous_object_to_world: [Vec4; 3],
    /// rgb: what its materials' emission is multiplied by.
    pub emission: Vec4,
    /// 1: it may move.
    pub dynamic: u32,
    /// 1: its transform swaps left and right.
    pub mirrored: u32,
    /// Unused.
    pub pad0: u32,
    /// Unused.
    pub pad1: u32,
}

/// A surface; `MaterialData` in shaders/include/scene.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct MaterialData {
    /// rgb: Kd.
    pub albedo: Vec4,
    /// rgb: Ks; w: Ns.
    pub specular: Vec4,
    /// rgb: Ke of the front side, W/m^2/sr.
    pub emission: Vec4,
    /// Index of the alpha mask plus one, 0: none.
    pub mask: u32,
    /// Unused.
    pub pad0: u32,
    /// Unused.
    pub pad1: u32,
    /// Unused.
    pub pad2: u32,
}

/// A light with shadow maps; `LightData` in shaders/include/lights.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LightData {
    /// xyz: world position; w: cosine of the spot's inner angle.
    pub position: Vec4,
    /// xyz: direction in which light travels; w: cosine of the spot's outer angle.
    pub direction: Vec4,
    /// rgb: intensity in W/sr, or irradiance in W/m^2.
    pub power: Vec4,
    /// 0 point, 1 spot, 2 directional.
    pub kind: u32,
    /// Index of its first shadow tile.
    pub first_tile: u32,
    /// 6: cube faces; otherwise cascades, nearest first.
    pub tile_count: u32,
    /// Unused.
    pub pad0: u32,
}

/// Where a shadow tile is not as in the frame before; `ChangedPart` in shaders/changed_tiles.comp.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ChangedPart {
    /// First texel, counted from the tile's.
    pub first: [u32; 2],
    /// Behind the last texel.
    pub end: [u32; 2],
    /// What is nearer to the light than this, in the tile's depth, is lit as it was.
    pub nearest: f32,
    /// What is farther away is lit as it was but for where cells have changed: see `ChangedCells`.
    pub farthest: f32,
    /// The first row of the cells that tell.
    pub first_row: u32,
    /// Unused.
    pub pad0: u32,
}

/// A part of the shadow atlas; `ShadowTile` in shaders/include/lights.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ShadowTile {
    /// World to the tile's clip space, reversed depth.
    pub view_projection: Mat4,
    /// xy: first texel in the atlas; z: texels across.
    pub rectangle: Vec4,
    /// x: world size of a texel (orthographic), or per unit of depth (perspective); y: 1 if perspective; z: texels around the
    /// middle that can be lit, 0: all.
    pub texel: Vec4,
}

/// A line over the picture; `OverlayLine` in shaders/include/overlay.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct OverlayLine {
    /// xyz: world position of one end; w: width in pixels.
    pub from_width: Vec4,
    /// xyz: of the other end; w: what the opacity of hidden parts is multiplied by.
    pub to_hidden: Vec4,
    /// Display values, opacity.
    pub colour: Vec4,
}

#[cfg(test)]
mod tests {
    use std::mem::{offset_of, size_of};

    use super::super::cast_rays::GpuRay;
    use super::*;
    use crate::vpl::GpuVpl;
    use crate::vulkan::{Reflection, shaders};

    fn check(spirv: &[u8], name: &str, offsets: &[(&str, usize)], size: usize) {
        let reflection = Reflection::new(name, spirv).unwrap();
        let members = reflection.structs.get(name).unwrap_or_else(|| panic!("no struct {name}"));
        let ours: Vec<_> = offsets
            .iter()
            .map(|(name, offset)| ((*name).to_owned(), u32::try_from(*offset).unwrap()))
            .collect();
        assert_eq!(*members, ours, "{name}");
        if let Some(stride) = reflection.strides.get(name) {
            assert_eq!(*stride as usize, size, "stride of {name}");
        }
    }

    macro_rules! same_layout {
        ($spirv:expr, $kind:ident, $($member:ident),+) => {
            check($spirv, stringify!($kind), &[$((stringify!($member), offset_of!($kind, $member))),+], size_of::<$kind>());
        };
    }

    #[test]
    fn structs_have_the_layout_of_the_shaders() {
        same_layout!(
            shaders::COMBINE_COMP,
            FrameUniforms,
            view_projection,
            previous_view_projection,
            eye,
            background,
            ray,
            ray_x,
            ray_y,
            size,
            interleave,
            light_count,
            position_cutoff,
            irradiance_scale,
            depth_scale,
            roulette
        );
        same_layout!(
            shaders::GBUFFER_FRAG,
            InstanceData,
            object_to_world,
            world_to_object,
            previous_object_to_world,
            emission,
            dynamic,
            mirrored,
            pad0,
            pad1
        );
        same_layout!(shaders::GBUFFER_FRAG, MaterialData, albedo, specular, emission, mask, pad0, pad1, pad2);
        same_layout!(
            shaders::DIRECT_SHADING_COMP,
            LightData,
            position,
            direction,
            power,
            kind,
            first_tile,
            tile_count,
            pad0
        );
        same_layout!(shaders::DIRECT_SHADING_COMP, ShadowTile, view_projection, rectangle, texel);
        same_layout!(shaders::OVERLAY_VERT, OverlayLine, from_width, to_hidden, colour);
        same_layout!(shaders::VPL_LIGHT_COMP.software, GpuVpl, position, slot, normal, bounce, flux, _pad);
        same_layout!(shaders::CAST_RAYS_COMP.software, GpuRay, origin, t_min, direction, t_max);
    }
}
