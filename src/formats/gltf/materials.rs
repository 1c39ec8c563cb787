//! Materials with their images.
//!
//! In: the materials of a file. Out: the scene's, in order, with textures and alpha masks.

use std::collections::{HashMap, HashSet};

use ::gltf::Semantic;
use ::gltf::json::Value;
use ::gltf::material::AlphaMode;
use ::gltf::material::NormalTexture;
use ::gltf::texture::{Info, MagFilter, MinFilter, Sampler, WrappingMode};
use glam::{Mat2, Vec2, Vec3};
use image::DynamicImage;
use rayon::prelude::*;

use super::source::Source;
use crate::activity;
use crate::formats::error::SceneError;
use crate::formats::images::{self, Content};
use crate::scene::{Alpha, AlphaMask, GLTF_F0, Material};
use crate::scene::{Minified, MipLevels, Scene, TextureUse, Wrap};

/// The materials of a file in the scene.
pub(super) struct Materials {
    /// Scene index of the first; the one of primitives without a material comes last.
    first: usize,
    count: usize,
}

impl Materials {
    /// Scene index of a primitive's material.
    pub fn of(&self, material: &::gltf::Material<'_>) -> usize {
        self.first + material.index().unwrap_or(self.count)
    }

    /// Adds all materials of the file.
    pub fn add(source: &mut Source, scene: &mut Scene) -> Result<Self, SceneError> {
        let (mut images, problems) = Images::read(source);
        scene.warnings.extend(problems);
        for (index, image) in images.decoded.iter().enumerate() {
            let sizes = image.as_ref().and_then(images::shrinking);
            source.not_shown.extend(sizes.map(|sizes| format!("image {index} in full ({sizes})")));
        }
        let first = scene.materials.len();
        let document = source.document.clone();
        for material in document.materials() {
            note_what_is_not_shown(&material, source);
            let made = material_of(&material, source, &mut images, scene)?;
            scene.materials.push(made);
        }
        let plain = Material { metallic: 1.0, ..Material::lambertian("glTF", Vec3::ONE) };
        scene.materials.push(Material { f0: GLTF_F0, f90: 1.0, ..plain });
        Ok(Self { first, count: document.materials().len() })
    }
}

/// The images of a file, decoded where a material uses them.
struct Images {
    decoded: Vec<Option<DynamicImage>>,
    /// Scene indices of textures, by image and what is read of it.
    places: HashMap<(usize, Content), usize>,
    /// Of images that masks are made of.
    opacities: HashMap<usize, AlphaMask>,
    /// Materials that cut or blend by the alpha of some of their vertices.
    vertex_alpha: HashSet<usize>,
}

impl Images {
    /// Reads the images of materials; of those that cannot be read a checkerboard is the base colour, and others have no effect,
    /// with a warning.
    fn read(source: &Source) -> (Self, Vec<String>) {
        let count = source.document.images().len();
        let (mut used, mut is_base) = (vec![false; count], vec![false; count]);
        for material in source.document.materials() {
            let data = material.pbr_metallic_roughness().metallic_roughness_texture();
            let colour = material.pbr_metallic_roughness().base_color_texture();
            let normal = material.normal_texture().map(|map| map.texture());
            colour.iter().for_each(|info| is_base[info.texture().source().index()] = true);
            let others = [data, colour, material.emissive_texture()].into_iter().flatten();
            for texture in others.map(|info| info.texture()).chain(normal) {
                used[texture.source().index()] = true;
            }
        }
        let read = |index: &usize| match used[*index].then(|| read_image(source, *index)) {
            None => (None, None),
            Some(Ok(image)) => (Some(image), None),
            Some(Err(problem)) => {
                let (image, fallback) = match is_base[*index] {
                    true => (Some(images::checkerboard()), "using a magenta and black checkerboard"),
                    false => (None, "leaving it out"),
                };
                (image, Some(format!("{}: image {index} {problem}; {fallback}", source.file.display())))
            }
        };
        let indices: Vec<usize> = (0..count).collect();
        let (decoded, problems): (Vec<_>, Vec<_>) = indices.par_iter().map(read).unzip();
        let (places, opacities) = (HashMap::new(), HashMap::new());
        let images = Self { decoded, places, opacities, vertex_alpha: vertex_alpha(source) };
        (images, problems.into_iter().flatten().collect())
    }

    /// The mask of a texture's alpha; materials share its texels.
    fn opacity(&mut self, texture: &::gltf::Texture<'_>) -> AlphaMask {
        let index = texture.source().index();
        let read = || self.decoded[index].as_ref().and_then(|image| images::opacity(image, false));
        self.opacities.entry(index).or_insert_with(|| read().unwrap_or_else(AlphaMask::whole)).clone()
    }

    /// Adds a texture to the scene, where it is not there yet; returns its index.
    fn add(&mut self, texture: &::gltf::Texture<'_>, content: Content, scene: &mut Scene) -> Option<usize> {
        let index = texture.source().index();
        let image = self.decoded[index].as_ref()?;
        Some(*self.places.entry((index, content)).or_insert_with(|| {
            let name = texture.source().name().map_or_else(|| format!("image {index}"), str::to_owned);
            scene.textures.push(images::texture(&name, image, content, None).into());
            scene.textures.len() - 1
        }))
    }
}

/// Decodes an image; the error completes a sentence about it.
fn read_image(source: &Source, index: usize) -> Result<DynamicImage, String> {
    activity::begin(format!("{}: decoding image {index}", source.file.display()));
    // The crate's own accessor panics where the type is missing.
    let json = &source.document.as_json().images[index];
    let view = json.buffer_view.and_then(|view| source.document.views().nth(view.value()));
    match (view, &json.uri) {
        (Some(view), _) => images::decode_image(source.view(&view)?, None),
        (None, Some(uri)) => images::decode_image(&source.resolve(uri)?, None),
        (None, None) => Err("has neither uri nor bufferView".to_owned()),
    }
}

/// The materials that use alpha and have vertices whose own is below 1.
fn vertex_alpha(source: &Source) -> HashSet<usize> {
    let primitives = source.document.meshes().flat_map(|mesh| mesh.primitives().collect::<Vec<_>>());
    let found = primitives.filter_map(|primitive| {
        let material = primitive.material();
        let colours =
            primitive.get(&Semantic::Colors(0)).filter(|_| material.alpha_mode() != AlphaMode::Opaque)?;
        // What cannot be read is an error of the mesh.
        let alphas = source.vectors::<4>(&colours, "colours").ok()?;
        alphas.iter().any(|colour| colour[3] < 1.0).then(|| material.index())?
    });
    found.collect()
}

/// A place in a file that names a texture.
struct Slot<'a> {
    texture: ::gltf::Texture<'a>,
    set: u32,
    transform: Option<Transform>,
}

/// KHR_texture_transform.
#[derive(Clone, Copy)]
struct Transform {
    offset: [f32; 2],
    rotation: f32,
    scale: [f32; 2],
    set: Option<u32>,
}

impl<'a> From<Info<'a>> for Slot<'a> {
    fn from(info: Info<'a>) -> Self {
        let transform = info.texture_transform().map(|transform| Transform {
            offset: transform.offset(),
            rotation: transform.rotation(),
            scale: transform.scale(),
            set: transform.tex_coord(),
        });
        Self { texture: info.texture(), set: info.tex_coord(), transform }
    }
}

impl<'a> From<NormalTexture<'a>> for Slot<'a> {
    fn from(map: NormalTexture<'a>) -> Self {
        // The crate reads this extension of the other textures alone.
        let transform = map.extension_value("KHR_texture_transform").map(|value| {
            let number = |value: Option<&Value>, or: f64| value.and_then(Value::as_f64).unwrap_or(or) as f32;
            let pair =
                |key: &str, or: f64| [0, 1].map(|axis| number(value.get(key).and_then(|v| v.get(axis)), or));
            Transform {
                offset: pair("offset", 0.0),
                rotation: number(value.get("rotation"), 0.0),
                scale: pair("scale", 1.0),
                set: value.get("texCoord").and_then(Value::as_u64).and_then(|set| u32::try_from(set).ok()),
            }
        });
        Self { texture: map.texture(), set: map.tex_coord(), transform }
    }
}

/// How a material uses a texture; none if it has none, or one that is not shown.
fn texture_use<'a>(
    slot: Option<impl Into<Slot<'a>>>,
    content: Content,
    source: &mut Source,
    images: &mut Images,
    scene: &mut Scene,
) -> Result<Option<TextureUse>, SceneError> {
    let Some(Slot { texture, set, transform }) = slot.map(Into::into) else { return Ok(None) };
    let set = transform.and_then(|transform| transform.set).unwrap_or(set);
    if set > 1 {
        source.not_shown.insert("texture coordinates but the first two".to_owned());
    }
    let Some(index) = images.add(&texture, content, scene) else { return Ok(None) };
    let wrap = [texture.sampler().wrap_s(), texture.sampler().wrap_t()].map(|mode| match mode {
        WrappingMode::ClampToEdge => Wrap::Clamp,
        WrappingMode::MirroredRepeat => Wrap::Mirror,
        WrappingMode::Repeat => Wrap::Repeat,
    });
    let nearest = is_nearest(&texture.sampler());
    let minified = minified(&texture.sampler(), nearest);
    let mut texture = TextureUse { set: set.min(1) as usize, wrap, nearest, minified, ..index.into() };
    if let Some(Transform { offset, rotation, scale, .. }) = transform {
        let (sin, cos) = rotation.sin_cos();
        let rotation = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
        texture.matrix = rotation * Mat2::from_diagonal(Vec2::from_array(scale));
        texture.offset = Vec2::from_array(offset);
        if !(texture.matrix.is_finite() && texture.offset.is_finite()) {
            return Err(source.error("a texture transform is not finite; export the file again"));
        }
    }
    Ok(Some(texture))
}

/// Whether a magnified image shows its texels as they are. Where a sampler does not say, minification does.
fn is_nearest(sampler: &Sampler<'_>) -> bool {
    let minified = || sampler.min_filter() == Some(MinFilter::Nearest);
    sampler.mag_filter().map_or_else(minified, |filter| filter == MagFilter::Nearest)
}

/// What a minified image shows. Where a sampler does not say, its levels are interpolated, of such texels as magnification shows.
fn minified(sampler: &Sampler<'_>, nearest: bool) -> Minified {
    let (nearest, levels) = match sampler.min_filter() {
        None => (nearest, MipLevels::Interpolated),
        Some(MinFilter::Nearest) => (true, MipLevels::First),
        Some(MinFilter::Linear) => (false, MipLevels::First),
        Some(MinFilter::NearestMipmapNearest) => (true, MipLevels::Nearest),
        Some(MinFilter::LinearMipmapNearest) => (false, MipLevels::Nearest),
        Some(MinFilter::NearestMipmapLinear) => (true, MipLevels::Interpolated),
        Some(MinFilter::LinearMipmapLinear) => (false, MipLevels::Interpolated),
    };
    Minified { nearest, levels }
}

fn material_of(
    material: &::gltf::Material<'_>,
    source: &mut Source,
    images: &mut Images,
    scene: &mut Scene,
) -> Result<Material, SceneError> {
    let pbr = material.pbr_metallic_roughness();
    let [r, g, b, opacity] = pbr.base_color_factor();
    let base = Vec3::new(r, g, b).clamp(Vec3::ZERO, Vec3::ONE);
    let name =
        material.name().map_or_else(|| format!("material {}", material.index().unwrap_or(0)), str::to_owned);
    let colour =
        if material.alpha_mode() == AlphaMode::Opaque { Content::OpaqueColour } else { Content::Colour };
    let base_texture = texture_use(pbr.base_color_texture(), colour, source, images, scene)?;
    let transmission = material.transmission().map_or(0.0, |t| t.transmission_factor().clamp(0.0, 1.0));
    let (alpha, alpha_mask) = alpha_of(material, images, scene, base_texture);
    let (opacity, double_sided) = (opacity.clamp(0.0, 1.0), material.double_sided());
    let sides = Material { double_sided, emits_on_both_sides: double_sided, ..Material::grey(&name) };
    if material.unlit() {
        let (base_colour, f0) = (Vec3::ZERO, Vec3::ZERO);
        let shape = Material { alpha, alpha_mask, opacity, base_colour_texture: base_texture, ..sides };
        let emitting = Material { emission: base, emission_texture: base_texture, unlit: true, ..shape };
        return Ok(Material { base_colour, f0, ..emitting });
    }
    let strength = material.emissive_strength().unwrap_or(1.0).max(0.0);
    let (f0, f90) = dielectric_of(material);
    let data_texture = texture_use(pbr.metallic_roughness_texture(), Content::Data, source, images, scene)?;
    let emission_texture =
        texture_use(material.emissive_texture(), Content::OpaqueColour, source, images, scene)?;
    let normal_scale = material.normal_texture().map_or(1.0, |map| map.scale());
    let normal_texture = texture_use(material.normal_texture(), Content::Data, source, images, scene)?;
    if !normal_scale.is_finite() {
        return Err(source.error(format!(
            "material \"{name}\": the scale of its normal map is not finite; export the file again"
        )));
    }
    Ok(Material {
        name,
        base_colour: base,
        base_colour_texture: base_texture,
        metallic: pbr.metallic_factor().clamp(0.0, 1.0),
        roughness: pbr.roughness_factor().clamp(0.0, 1.0),
        metallic_roughness_texture: data_texture,
        f0,
        f90,
        emission: Vec3::from_array(material.emissive_factor()).max(Vec3::ZERO) * strength,
        emission_texture,
        normal_texture,
        normal_scale,
        alpha,
        opacity,
        transmission,
        alpha_mask,
        ..sides
    })
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

/// How alpha is used, and the mask of what is cut out, which is read as the base colour is.
fn alpha_of(
    material: &::gltf::Material<'_>,
    images: &mut Images,
    scene: &mut Scene,
    base: Option<TextureUse>,
) -> (Alpha, Option<usize>) {
    if material.alpha_mode() == AlphaMode::Opaque {
        return (Alpha::Opaque, None);
    }
    let pbr = material.pbr_metallic_roughness();
    let factor = pbr.base_color_factor()[3].clamp(0.0, 1.0);
    let map = pbr.base_color_texture();
    let mask = map.map_or_else(AlphaMask::whole, |info| images.opacity(&info.texture()));
    let by_vertices = material.index().is_some_and(|index| images.vertex_alpha.contains(&index));
    let (wrap, nearest) = base.map_or((Wrap::REPEAT, false), |texture| (texture.wrap, texture.nearest));
    let mask = AlphaMask { wrap, nearest, ..mask };
    let mut add = |mask: AlphaMask| {
        (by_vertices || mask.cuts()).then(|| {
            scene.alpha_masks.push(mask);
            scene.alpha_masks.len() - 1
        })
    };
    match material.alpha_mode() {
        AlphaMode::Mask => {
            let cutoff = material.alpha_cutoff().unwrap_or(0.5);
            (Alpha::Mask(cutoff), add(mask.cut_at(cutoff, factor)).filter(|_| cutoff > 0.0))
        }
        AlphaMode::Blend if factor < 1.0 || by_vertices || mask.clone().cut_at(1.0, 1.0).cuts() => {
            (Alpha::Blend, None)
        }
        _ => (Alpha::Opaque, None),
    }
}

fn note_what_is_not_shown(material: &::gltf::Material<'_>, source: &mut Source) {
    for (is_there, what) in [
        (material.occlusion_texture().is_some(), "occlusion maps (light is traced)"),
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
