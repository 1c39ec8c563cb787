//! The structs that shaders and Rust share (std140 and std430), besides those of `bvh` and the methods. A test
//! compares every member's offset with the compiled shaders.

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec2, Vec3, Vec4};

use crate::bvh::Ray;
use crate::bvh::gpu::sampler_bits;
use crate::scene::{Minified, MipLevels, TextureUse};

/// A [`Ray`] as shaders have it; `GpuRay` in shaders/include/ray.glsl. 32 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct GpuRay {
    /// World-space start.
    pub origin: Vec3,
    /// Open lower bound of t.
    pub t_min: f32,
    /// World-space direction.
    pub direction: Vec3,
    /// Open upper bound of t.
    pub t_max: f32,
}

impl From<&Ray> for GpuRay {
    fn from(&Ray { origin, direction, t_min, t_max }: &Ray) -> Self {
        Self { origin, t_min, direction, t_max }
    }
}

/// Uniforms of a frame, for every pass; `FrameUniforms` in shaders/include/frame.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct FrameUniforms {
    /// World to clip, reversed depth.
    pub view_projection: Mat4,
    /// World to clip one frame ago, without jitter.
    pub previous_view_projection: Mat4,
    /// xyz: world position; w: radius of the scene's bounding sphere.
    pub eye: Vec4,
    /// rgb: radiance where no surface is, to be multiplied with that of the environment's map; w: its rotation, radians.
    pub background: Vec4,
    /// xyz: view direction. A pixel at (x, y) in -1..1 sees `eye + depth * (ray + x ray_x + y ray_y)`.
    pub ray: Vec4,
    /// xyz: right times the tangent of half the horizontal field of view.
    pub ray_x: Vec4,
    /// xyz: down times the tangent of half the vertical field of view.
    pub ray_y: Vec4,
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// Point, spot and directional lights.
    pub light_count: u32,
    /// Number of the frame in the sequence of random numbers.
    pub noise_frame: u32,
    /// Offset from the middle of a pixel to where it is sampled, pixels.
    pub jitter: Vec2,
    /// Seed of random numbers.
    pub seed: u32,
    /// Lights, from the first one on, whose direct light is `direct`; estimators sample the others.
    pub direct_lights: u32,
    /// Roughness around which rays cease to trace what surfaces mirror; 2: always, -1: never.
    pub reflection_limit: f32,
    /// Share of a pixel's width over which textures are averaged.
    pub footprint: f32,
    /// The tone curve: see [`ToneMap`](crate::settings::ToneMap).
    pub tone_map: u32,
    /// Area lights of the scene, which follow the others in the order of lights.
    pub area_light_count: u32,
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
    /// rgb: factor on its materials' emission.
    pub emission: Vec4,
    /// 1: its transform swaps left and right, so triangles wind the other way.
    pub flips_winding: u32,
    /// The first triangle of its mesh among those of all meshes.
    pub first_triangle: u32,
    /// Index of the area light that it is, plus one; 0: none.
    pub area_light: u32,
    /// 1: it may move.
    pub is_dynamic: u32,
}

/// A surface; `MaterialData` in shaders/include/scene.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct MaterialData {
    /// rgb: base colour, to be multiplied with its texture; w: metallic.
    pub base: Vec4,
    /// rgb: F0 of a dielectric; w: F90.
    pub reflectance: Vec4,
    /// rgb: radiance of the sides that emit, W/m^2/sr, to be multiplied with its texture; w: roughness.
    pub emission: Vec4,
    /// rgb: the same, mean over its texture.
    pub mean_emission: Vec4,
    /// rgb: share of the light that it reflects, mean over textures and directions.
    pub mean_albedo: Vec4,
    /// Index of the alpha mask plus one, 0: none.
    pub mask: u32,
    /// Factor on the slopes of its normal map.
    pub normal_scale: f32,
    /// [`COLOURED`], [`SINGLE_SIDED`], [`EMITS_ON_BOTH_SIDES`], [`UNLIT`].
    pub flags: u32,
    /// Unused.
    pub pad1: u32,
    /// Texture of the base colour.
    pub base_texture: TextureUseData,
    /// Texture of roughness (green) and metallic (blue).
    pub metallic_roughness_texture: TextureUseData,
    /// Texture of the emission.
    pub emission_texture: TextureUseData,
    /// Texture of the normal.
    pub normal_texture: TextureUseData,
}

/// In [`MaterialData::flags`]: some of its vertices have colours.
pub const COLOURED: u32 = 1;
/// In [`MaterialData::flags`]: its back does not show to the eye.
pub const SINGLE_SIDED: u32 = 2;
/// In [`MaterialData::flags`]: its back emits as its front does.
pub const EMITS_ON_BOTH_SIDES: u32 = 4;
/// In [`MaterialData::flags`]: its emission is multiplied with the vertices' colours.
pub const UNLIT: u32 = 8;

/// How a material uses a texture; `TextureUse` in shaders/include/scene.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TextureUseData {
    /// Two columns.
    pub matrix: Vec4,
    /// Added then.
    pub offset: Vec2,
    /// Index of the texture plus one; 0: none.
    pub image: u32,
    /// Wrap modes and filter, and 16 for the second set of coordinates.
    pub modes: u32,
}

impl Default for TextureUseData {
    fn default() -> Self {
        Self { matrix: Vec4::new(1.0, 0.0, 0.0, 1.0), offset: Vec2::ZERO, image: 0, modes: 0 }
    }
}

impl From<TextureUse> for TextureUseData {
    fn from(texture: TextureUse) -> Self {
        Self {
            matrix: Vec4::from_array(texture.matrix.to_cols_array()),
            offset: texture.offset,
            image: super::to_u32(texture.texture) + 1,
            modes: sampler_bits(texture.wrap, texture.nearest)
                | (texture.set as u32) << 4
                | minified_bits(texture.minified),
        }
    }
}

/// How an image is read where it is minified; twin: shaders/include/wrap.glsl.
fn minified_bits(minified: Minified) -> u32 {
    let levels = match minified.levels {
        MipLevels::Interpolated => 0,
        MipLevels::Nearest => 256,
        MipLevels::First => 512,
    };
    u32::from(minified.nearest) << 7 | levels
}

/// A point, spot or directional light; `LightData` in shaders/include/lights.glsl.
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
    /// Radius of the sphere that shines (point, spot), world units; 0 for a point.
    pub radius: f32,
    /// Half angle of the disc that shines (directional), radians; 0 for parallel light.
    pub half_angle: f32,
    /// Unused.
    pub pad2: u32,
}

/// A line over the picture; `OverlayLine` in shaders/include/overlay.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct OverlayLine {
    /// xyz: world position of one end; w: width in pixels.
    pub from_width: Vec4,
    /// xyz: of the other end; w: factor on the opacity of hidden parts.
    pub to_hidden: Vec4,
    /// Display values, opacity.
    pub colour: Vec4,
}

#[cfg(test)]
pub(crate) mod tests {

    use super::super::geometry::Vertex;
    use super::super::hit_buffers::TextureData;
    use super::TextureUseData as TextureUse;
    use super::*;
    use crate::bvh::thin_surfaces::{GpuThinSurface, GpuThinTriangle};
    use crate::vulkan::{Reflection, shaders};

    /// Whether a struct of a shader has these members at these offsets.
    pub(crate) fn check(spirv: &[u8], name: &str, offsets: &[(&str, usize)], size: usize) {
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

    /// Compares a struct with the one of the same name in a shader.
    macro_rules! same_layout {
        ($spirv:expr, $kind:ident, $($member:ident),+) => {
            $crate::gpu_scene::structs::tests::check(
                $spirv,
                stringify!($kind),
                &[$((stringify!($member), std::mem::offset_of!($kind, $member))),+],
                size_of::<$kind>(),
            );
        };
    }
    pub(crate) use same_layout;

    #[test]
    fn the_uniforms_have_the_layout_of_the_shaders() {
        same_layout!(
            shaders::RADIANCE_COMP,
            FrameUniforms,
            view_projection,
            previous_view_projection,
            eye,
            background,
            ray,
            ray_x,
            ray_y,
            size,
            light_count,
            noise_frame,
            jitter,
            seed,
            direct_lights,
            reflection_limit,
            footprint,
            tone_map,
            area_light_count
        );
    }

    #[test]
    fn structs_of_the_scene_have_the_layout_of_the_shaders() {
        same_layout!(
            shaders::GBUFFER_FRAG,
            InstanceData,
            object_to_world,
            world_to_object,
            previous_object_to_world,
            emission,
            flips_winding,
            first_triangle,
            area_light,
            is_dynamic
        );
        same_layout!(
            shaders::GBUFFER_FRAG,
            MaterialData,
            base,
            reflectance,
            emission,
            mean_emission,
            mean_albedo,
            mask,
            normal_scale,
            flags,
            pad1,
            base_texture,
            metallic_roughness_texture,
            emission_texture,
            normal_texture
        );
        same_layout!(shaders::GBUFFER_FRAG, TextureUse, matrix, offset, image, modes);
        same_layout!(shaders::HIT_SURFACES_COMP.software, TextureData, first, size, levels, format);
        same_layout!(shaders::HIT_SURFACES_COMP.software, Vertex, position, normal, uv, tangent, pad);
        same_layout!(
            shaders::DIRECT_SHADING_COMP,
            LightData,
            position,
            direction,
            power,
            kind,
            radius,
            half_angle,
            pad2
        );
        same_layout!(shaders::OVERLAY_VERT, OverlayLine, from_width, to_hidden, colour);
        same_layout!(shaders::CAST_RAYS_COMP.software, GpuThinTriangle, uvs, colours);
        same_layout!(
            shaders::CAST_RAYS_COMP.software,
            GpuThinSurface,
            passed,
            base,
            reflectance,
            roughness,
            first,
            size,
            modes
        );
        same_layout!(shaders::CAST_RAYS_COMP.software, GpuRay, origin, t_min, direction, t_max);
    }
}
