//! Thin surfaces as `shaders/include/tracer.glsl` reads them, for both tracers.
//!
//! In: a scene. Out: the transmittance of its thin surfaces: a record for each material, and the texels of their base colours.

use std::collections::HashMap;

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec4};

use super::pack::{halves, non_empty, sampler_bits};
use crate::scene::{Alpha, Material, Mesh, Scene, Wrap};

/// In [`GpuTriangle::masked`](super::gpu::GpuTriangle::masked): the triangle is one of a thin surface, and the rest is the index of its
/// [`GpuThinTriangle`].
pub const THIN_SURFACE: u32 = 1 << 31;

/// In [`GpuThinSurface::modes`]: the texture's colour is linear.
const LINEAR: u32 = 16;
/// In [`GpuThinSurface::modes`]: alpha is the share of the surface that is there; otherwise all is.
const BLENDS: u32 = 32;
/// In [`GpuThinSurface::modes`]: the texture's texels are half floats, two words each.
const HALF: u32 = 128;

/// The corners of a thin surface's triangle. 48 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct GpuThinTriangle {
    /// Coordinates on the texture of the base colour.
    pub uvs: [Vec2; 3],
    /// Linear colour and alpha, half floats.
    pub colours: [[u32; 2]; 3],
}

/// The material of a thin surface. 64 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct GpuThinSurface {
    /// rgb: transmittance where its coat reflects nothing, to be multiplied with texture and vertices; w: opacity.
    pub passed: Vec4,
    /// rgb: base colour of its coat, mean over textures; w: metallic, likewise.
    pub base: Vec4,
    /// rgb: F0; w: F90.
    pub reflectance: Vec4,
    /// Perceptual, mean over textures.
    pub roughness: f32,
    /// First word of its texture in [`GpuThinSurfaces::texels`].
    pub first: u32,
    /// Size of that, width in the lower 16 bits, height above; 0: there is none.
    pub size: u32,
    /// How the texture is read, whether its colour is linear, whether the thin surface blends.
    pub modes: u32,
}

/// The thin surfaces of a scene; no array is empty.
#[derive(Clone, Debug)]
pub struct GpuThinSurfaces {
    /// Corners of their triangles.
    pub triangles: Vec<GpuThinTriangle>,
    /// One for each material, of which only those of thin surfaces mean anything.
    pub thin_surfaces: Vec<GpuThinSurface>,
    /// RGBA of 8 bits or half floats, level 0 of the textures of their base colours.
    pub texels: Vec<u32>,
}

impl GpuThinSurfaces {
    /// The thin surfaces of `scene`, whose triangles are `triangles`: nothing if there are none.
    pub(super) fn new(scene: &Scene, triangles: &[GpuThinTriangle]) -> Self {
        let mut texels = Vec::new();
        let mut firsts = HashMap::new();
        let materials = if triangles.is_empty() { &[][..] } else { &scene.materials };
        let thin_surfaces = materials.iter().map(|material| {
            let texture = material.base_colour_texture.filter(|_| material.is_thin_surface());
            let thin_surface = thin_surface(scene, material);
            let Some(texture) = texture else { return thin_surface };
            let image = &scene.textures[texture.texture];
            let (width, height, level) = &image.levels[0];
            let first = *firsts.entry(texture.texture).or_insert_with(|| {
                let first = texels.len() as u32;
                texels.extend(
                    level
                        .chunks_exact(4)
                        .map(|texel| u32::from_le_bytes([texel[0], texel[1], texel[2], texel[3]])),
                );
                first
            });
            let depth = if image.half { HALF | LINEAR } else { 0 };
            let colour = if image.linear { LINEAR } else { 0 };
            let modes = thin_surface.modes | sampler_bits(texture.wrap, texture.nearest) | depth | colour;
            GpuThinSurface { first, size: width | height << 16, modes, ..thin_surface }
        });
        let thin_surfaces = non_empty(thin_surfaces.collect());
        Self { triangles: non_empty(triangles.to_vec()), thin_surfaces, texels: non_empty(texels) }
    }
}

/// A thin surface without texture.
fn thin_surface(scene: &Scene, material: &Material) -> GpuThinSurface {
    let coat = material.mean_bsdf(scene);
    let blends = material.alpha == Alpha::Blend;
    GpuThinSurface {
        passed: material.passed().extend(material.opacity),
        base: coat.base.extend(coat.metallic),
        reflectance: coat.f0.extend(coat.f90),
        roughness: coat.roughness,
        modes: sampler_bits(Wrap::REPEAT, false) | if blends { BLENDS } else { 0 },
        ..GpuThinSurface::default()
    }
}

/// The corners of triangle `id` of a mesh, of a thin surface's material.
pub(super) fn thin_triangle(mesh: &Mesh, id: u32, material: &Material) -> GpuThinTriangle {
    let colour = |vertex: u32| halves(mesh.colours.get(vertex as usize).copied().unwrap_or(Vec4::ONE));
    GpuThinTriangle {
        uvs: mesh.mask_coordinates(id, material),
        colours: mesh.triangles[id as usize].map(colour),
    }
}
