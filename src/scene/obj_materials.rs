//! Converts tobj's materials and their images to the scene's.
//!
//! In: the materials of an OBJ. Out: a [`Material`] for each, with its texture and alpha mask in the scene; an
//! unreadable image is replaced by a fallback and named in a warning.

use std::collections::{BTreeSet, HashMap};
use std::path::Path;

use glam::Vec3;
use image::DynamicImage;
use rayon::prelude::*;

use super::material::{AlphaMask, Material, Texture};
use super::mtl::find_file;
use super::{Scene, texture};

/// The images of a model's materials, each read once.
struct Images(HashMap<String, Result<DynamicImage, String>>);

impl Images {
    fn read(file: &Path, materials: &[tobj::Material]) -> Self {
        let folder = file.parent().unwrap_or(Path::new(""));
        let names = materials.iter().flat_map(|m| [&m.diffuse_texture, &m.dissolve_texture]).flatten();
        let names: BTreeSet<&String> = names.collect();
        let read = |name: &&String| {
            let path = find_file(folder, name).ok_or_else(|| "is missing".to_owned());
            ((*name).clone(), path.and_then(|path| texture::read_image(&path)))
        };
        Self(names.into_iter().collect::<Vec<_>>().par_iter().map(read).collect())
    }

    fn get(&self, name: &str) -> Result<&DynamicImage, &str> {
        match self.0.get(name) {
            Some(Ok(image)) => Ok(image),
            Some(Err(problem)) => Err(problem),
            None => Err("was not read"),
        }
    }
}

/// Inputs of a mask: colour map, opacity map, bits of `d`.
type MaskKey<'a> = (Option<&'a str>, Option<&'a str>, u32);

/// Adds a [`Material`] for each of `materials` (of the OBJ `file`), in order, with textures and masks.
pub(super) fn add_materials(file: &Path, materials: &[tobj::Material], scene: &mut Scene) {
    let images = Images::read(file, materials);
    let textures = add_textures(file, materials, &images, scene);
    let mut masks: HashMap<MaskKey, Option<usize>> = HashMap::new();
    for material in materials {
        let colour_map = material.diffuse_texture.as_deref();
        let opacity_map = material.dissolve_texture.as_deref();
        let emission = Vec3::from_array(material.emissive.unwrap_or_default());
        // An emissive surface is meant to be visible, so it ignores `d`.
        let dissolve = if emission == Vec3::ZERO { material.dissolve.unwrap_or(1.0) } else { 1.0 };
        let alpha_mask = *masks.entry((colour_map, opacity_map, dissolve.to_bits())).or_insert_with(|| {
            let mask = mask_of(colour_map, opacity_map, dissolve, &images)?;
            scene.alpha_masks.push(mask);
            Some(scene.alpha_masks.len() - 1)
        });
        scene.materials.push(Material {
            name: material.name.clone(),
            albedo: Vec3::from_array(
                material.diffuse.unwrap_or([if colour_map.is_some() { 1.0 } else { 0.5 }; 3]),
            ),
            specular: Vec3::from_array(material.specular.unwrap_or_default()),
            shininess: material.shininess.unwrap_or(1.0),
            emission,
            albedo_texture: colour_map.and_then(|name| textures.get(name).copied()),
            alpha_mask,
        });
    }
}

/// Adds every colour map with its mip chain, or a fallback for an unreadable one. Returns scene indices by name.
fn add_textures(
    file: &Path,
    materials: &[tobj::Material],
    images: &Images,
    scene: &mut Scene,
) -> HashMap<String, usize> {
    let mut names: Vec<&str> = Vec::new();
    for material in materials {
        for (name, fallback) in [
            (&material.diffuse_texture, "using a magenta and black checkerboard"),
            (&material.dissolve_texture, "using no alpha mask"),
        ] {
            let Some(name) = name else { continue };
            if let Err(problem) = images.get(name) {
                let line = format!("{}: texture {name} {problem}; {fallback}", file.display());
                if !scene.warnings.contains(&line) {
                    scene.warnings.push(line);
                }
            }
        }
        names.extend(material.diffuse_texture.as_deref().filter(|name| !names.contains(name)));
    }
    let build = |name: &&str| match images.get(name) {
        Ok(image) => {
            let texels = texture::to_srgb8(image);
            Texture::from_rgba8(name, texels.width(), texels.height(), texels.into_raw())
        }
        Err(_) => Texture::missing(name),
    };
    let first = scene.textures.len();
    scene.textures.par_extend(names.par_iter().map(build));
    names.iter().enumerate().map(|(i, name)| ((*name).to_owned(), first + i)).collect()
}

/// The alpha mask: `map_d` if present, else the alpha of `map_Kd`, times `d`.
fn mask_of(
    colour_map: Option<&str>,
    opacity_map: Option<&str>,
    dissolve: f32,
    images: &Images,
) -> Option<AlphaMask> {
    let from_opacity = opacity_map.and_then(|name| texture::opacity(images.get(name).ok()?, true));
    let from_colour = || colour_map.and_then(|name| texture::opacity(images.get(name).ok()?, false));
    let (width, height, opacity) = from_opacity.or_else(from_colour).unwrap_or((1, 1, vec![255]));
    AlphaMask::from_opacity(width, height, &opacity, dissolve)
}
