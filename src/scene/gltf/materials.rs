//! Materials with their images.
//!
//! In: the materials of a file. Out: the scene's, in order, with textures and alpha masks; and where the texture
//! coordinates of each come from. One set of coordinates serves all textures of a material: its first texture's.

use std::collections::HashMap;

use ::gltf::material::AlphaMode;
use ::gltf::texture::{Info, WrappingMode};
use glam::{Mat2, Vec2, Vec3};
use image::DynamicImage;
use rayon::prelude::*;

use super::source::Source;
use crate::scene::error::SceneError;
use crate::scene::material::{Alpha, AlphaMask, GLTF_F0, Material, Texture};
use crate::scene::{Scene, texture};

/// The texture coordinates of a material: a set, and `offset + matrix * uv` (KHR_texture_transform).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coordinates {
    pub set: u32,
    pub matrix: Mat2,
    pub offset: Vec2,
}

impl Default for Coordinates {
    fn default() -> Self {
        Self { set: 0, matrix: Mat2::IDENTITY, offset: Vec2::ZERO }
    }
}

/// The materials of a file in the scene.
pub(super) struct Materials {
    /// Scene index of the first; the one of primitives without a material comes last.
    first: usize,
    coordinates: Vec<Coordinates>,
}

impl Materials {
    /// Scene index and coordinates of a primitive's material.
    pub fn of(&self, material: &::gltf::Material<'_>) -> (u32, Coordinates) {
        let index = material.index().unwrap_or(self.coordinates.len() - 1);
        ((self.first + index) as u32, self.coordinates[index])
    }

    /// Adds all materials of the file.
    pub fn add(source: &mut Source, scene: &mut Scene) -> Result<Self, SceneError> {
        let images = Images::read(source)?;
        for (index, image) in images.0.iter().enumerate() {
            let sizes = image.as_ref().and_then(texture::shrinking);
            source.not_shown.extend(sizes.map(|sizes| format!("image {index} in full ({sizes})")));
        }
        let first = scene.materials.len();
        let mut places = HashMap::new();
        let mut coordinates = Vec::new();
        let document = source.document.clone();
        for material in document.materials() {
            coordinates.push(coordinates_of(&material, source)?);
            note_what_is_not_shown(&material, source);
            let made = material_of(&material, &images, scene, &mut places);
            scene.materials.push(made);
        }
        coordinates.push(Coordinates::default());
        let plain = Material { metallic: 1.0, ..Material::lambertian("glTF", Vec3::ONE) };
        scene.materials.push(Material { f0: GLTF_F0, f90: 1.0, ..plain });
        Ok(Self { first, coordinates })
    }
}

/// The images of a file, decoded where a material uses them.
struct Images(Vec<Option<DynamicImage>>);

impl Images {
    fn read(source: &Source) -> Result<Self, SceneError> {
        let mut used = vec![false; source.document.images().len()];
        for material in source.document.materials() {
            let data = material.pbr_metallic_roughness().metallic_roughness_texture();
            let colour = material.pbr_metallic_roughness().base_color_texture();
            for info in [data, colour, material.emissive_texture()].into_iter().flatten() {
                used[info.texture().source().index()] = true;
            }
        }
        let images: Vec<_> = source.document.images().zip(used).collect();
        let read = |(image, used): &(::gltf::Image<'_>, bool)| -> Result<Option<DynamicImage>, SceneError> {
            if !*used {
                return Ok(None);
            }
            let what = format!("image {}", image.index());
            let embedded;
            let external;
            let bytes: &[u8] = match image.source() {
                ::gltf::image::Source::View { view, .. } => {
                    embedded = source.view(&view)?;
                    embedded
                }
                ::gltf::image::Source::Uri { uri, .. } => {
                    external = source.resolve(uri, &what)?;
                    &external
                }
            };
            let decoded = texture::decode_image(bytes, None);
            decoded
                .map(Some)
                .map_err(|problem| source.error(format!("{what} {problem}; export the file again")))
        };
        images.par_iter().map(read).collect::<Result<_, _>>().map(Self)
    }

    fn of(&self, info: &Info<'_>) -> Option<(usize, &DynamicImage)> {
        let index = info.texture().source().index();
        Some((index, self.0[index].as_ref()?))
    }
}

/// Scene indices of textures, by image and whether they are linear.
type Places = HashMap<(usize, bool), usize>;

fn add_texture(
    info: Option<Info<'_>>,
    linear: bool,
    images: &Images,
    scene: &mut Scene,
    places: &mut Places,
) -> Option<usize> {
    let info = info?;
    let (index, image) = images.of(&info)?;
    Some(*places.entry((index, linear)).or_insert_with(|| {
        let name = info.texture().source().name().map_or_else(|| format!("image {index}"), str::to_owned);
        let texels = texture::to_srgb8(image);
        let (width, height) = texels.dimensions();
        scene.textures.push(match linear {
            true => Texture::linear_from_rgba8(&name, width, height, texels.into_raw()),
            false => Texture::from_rgba8(&name, width, height, texels.into_raw()),
        });
        scene.textures.len() - 1
    }))
}

fn material_of(
    material: &::gltf::Material<'_>,
    images: &Images,
    scene: &mut Scene,
    places: &mut Places,
) -> Material {
    let pbr = material.pbr_metallic_roughness();
    let [r, g, b, opacity] = pbr.base_color_factor();
    let base = Vec3::new(r, g, b).clamp(Vec3::ZERO, Vec3::ONE);
    let name =
        material.name().map_or_else(|| format!("material {}", material.index().unwrap_or(0)), str::to_owned);
    let base_texture = add_texture(pbr.base_color_texture(), false, images, scene, places);
    let transmission = material.transmission().map_or(0.0, |t| t.transmission_factor().clamp(0.0, 1.0));
    let (alpha, alpha_mask) = alpha_of(material, images, scene, transmission * base.max_element());
    if material.unlit() {
        let unlit = Material {
            emission: base,
            emission_texture: base_texture,
            ..Material::lambertian(&name, Vec3::ZERO)
        };
        return Material { alpha, alpha_mask, ..unlit };
    }
    let strength = material.emissive_strength().unwrap_or(1.0).max(0.0);
    let (f0, f90) = dielectric_of(material);
    Material {
        name,
        base_colour: base,
        base_colour_texture: base_texture,
        metallic: pbr.metallic_factor().clamp(0.0, 1.0),
        roughness: pbr.roughness_factor().clamp(0.0, 1.0),
        metallic_roughness_texture: add_texture(
            pbr.metallic_roughness_texture(),
            true,
            images,
            scene,
            places,
        ),
        f0,
        f90,
        emission: Vec3::from_array(material.emissive_factor()).max(Vec3::ZERO) * strength,
        emission_texture: add_texture(material.emissive_texture(), false, images, scene, places),
        alpha,
        opacity: opacity.clamp(0.0, 1.0),
        transmission,
        double_sided: material.double_sided(),
        alpha_mask,
    }
}

/// Reflectances of the dielectric part (KHR_materials_ior, KHR_materials_specular).
fn dielectric_of(material: &::gltf::Material<'_>) -> (Vec3, f32) {
    let by_index = material.ior().map(|ior| Vec3::splat(((ior - 1.0) / (ior + 1.0)).powi(2)));
    let f0 = by_index.unwrap_or(GLTF_F0);
    let Some(specular) = material.specular() else { return (f0, 1.0) };
    let factor = specular.specular_factor().clamp(0.0, 1.0);
    let colour = Vec3::from_array(specular.specular_color_factor()).max(Vec3::ZERO);
    ((f0 * colour).min(Vec3::ONE) * factor, factor)
}

/// How alpha is used, and the mask of what is cut out; `passes`: the share that passes what is there.
fn alpha_of(
    material: &::gltf::Material<'_>,
    images: &Images,
    scene: &mut Scene,
    passes: f32,
) -> (Alpha, Option<usize>) {
    let pbr = material.pbr_metallic_roughness();
    let factor = pbr.base_color_factor()[3].clamp(0.0, 1.0);
    let map = pbr.base_color_texture();
    let opacity = map.as_ref().and_then(|info| texture::opacity(images.of(info)?.1, false));
    let (width, height, opacity) = opacity.unwrap_or((1, 1, vec![255]));
    let mut add = |factor: f32| {
        let mask = AlphaMask::from_opacity(width, height, &opacity, factor)?;
        scene.alpha_masks.push(mask);
        Some(scene.alpha_masks.len() - 1)
    };
    match material.alpha_mode() {
        AlphaMode::Mask => {
            let cutoff = material.alpha_cutoff().unwrap_or(0.5).max(1e-6);
            // The mask's own threshold is a half.
            (Alpha::Mask(cutoff), add(factor * 0.5 / cutoff))
        }
        AlphaMode::Blend if factor < 1.0 || opacity.iter().any(|&alpha| alpha < 255) => {
            (Alpha::Blend, add(if passes >= 0.5 { 0.0 } else { factor }))
        }
        _ if passes >= 0.5 => (Alpha::Opaque, add(0.0)),
        _ => (Alpha::Opaque, None),
    }
}

/// The coordinates of a material's textures: those of the first; others that differ are not shown.
fn coordinates_of(material: &::gltf::Material<'_>, source: &mut Source) -> Result<Coordinates, SceneError> {
    let pbr = material.pbr_metallic_roughness();
    let infos = [pbr.base_color_texture(), pbr.metallic_roughness_texture(), material.emissive_texture()];
    let mut all = Vec::new();
    for info in infos.into_iter().flatten() {
        let sampler = info.texture().sampler();
        if [sampler.wrap_s(), sampler.wrap_t()].iter().any(|mode| *mode != WrappingMode::Repeat) {
            source.not_shown.insert("wrap modes of textures (they repeat)".to_owned());
        }
        let transform = info.texture_transform();
        let set = transform.as_ref().and_then(|transform| transform.tex_coord()).unwrap_or(info.tex_coord());
        let mut coordinates = Coordinates { set, ..Coordinates::default() };
        if let Some(transform) = transform {
            let (sin, cos) = transform.rotation().sin_cos();
            let rotation = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
            coordinates.matrix = rotation * Mat2::from_diagonal(Vec2::from_array(transform.scale()));
            coordinates.offset = Vec2::from_array(transform.offset());
            if !(coordinates.matrix.is_finite() && coordinates.offset.is_finite()) {
                return Err(source.error("a texture transform is not finite; export the file again"));
            }
        }
        all.push(coordinates);
    }
    let first = all.first().copied().unwrap_or_default();
    if all.iter().any(|other| *other != first) {
        source
            .not_shown
            .insert("textures of one material with different coordinates (the first's are used)".to_owned());
    }
    Ok(first)
}

fn note_what_is_not_shown(material: &::gltf::Material<'_>, source: &mut Source) {
    for (is_there, what) in [
        (material.normal_texture().is_some(), "normal maps"),
        (material.transmission().is_some_and(|t| t.transmission_texture().is_some()), "maps of transmission"),
        (
            material
                .specular()
                .is_some_and(|s| s.specular_texture().is_some() || s.specular_color_texture().is_some()),
            "maps of the reflectance",
        ),
    ] {
        if is_there {
            source.not_shown.insert(what.to_owned());
        }
    }
}
