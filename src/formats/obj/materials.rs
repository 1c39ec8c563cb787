//! The materials of an OBJ and their images.
//!
//! In: the materials of its libraries. Out: a [`Material`] for each, with its textures and alpha mask in the scene; an
//! unreadable image is replaced by a fallback and named in a warning.

use std::collections::{BTreeSet, HashMap};
use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use image::DynamicImage;
use rayon::prelude::*;

use super::map::Map;
use super::mtl::{MtlMaterial, find_file};
use super::normal_map;
use super::surface::surface;
use crate::formats::images::{self, Content};
use crate::scene::{Alpha, AlphaMask, Material, Scene, Texture, Wrap};

/// The images of a model's materials, each read once.
struct Images(HashMap<String, Result<DynamicImage, String>>);

impl Images {
    fn read(file: &Path, materials: &[MtlMaterial]) -> Self {
        let folder = file.parent().unwrap_or(Path::new(""));
        let names: BTreeSet<&str> =
            materials.iter().flat_map(|material| Maps::of(material).names()).collect();
        let read = |name: &&str| {
            let path = find_file(folder, name).ok_or_else(|| "is missing".to_owned());
            ((*name).to_owned(), path.and_then(|path| images::read_image(&path)))
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

/// The maps of a material.
#[derive(Clone, Copy)]
struct Maps<'a> {
    colour: Option<&'a Map>,
    opacity: Option<&'a Map>,
    emission: Option<&'a Map>,
    roughness: Option<&'a Map>,
    metallic: Option<&'a Map>,
    relief: Option<(&'a Map, Relief<'a>)>,
}

/// A map of the normal.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Relief<'a> {
    Normals(&'a str),
    /// A file of heights, and the bits of their multiplier.
    Heights(&'a str, u32),
}

impl<'a> Relief<'a> {
    fn of(material: &'a MtlMaterial) -> Option<(&'a Map, Self)> {
        let heights = |map: &'a Map| (map, Self::Heights(&map.file, map.multiplier.to_bits()));
        let normals = material.norm.as_ref().map(|map| (map, Self::Normals(&map.file)));
        normals.or_else(|| material.bump.as_ref().map(heights))
    }

    fn name(self) -> &'a str {
        match self {
            Self::Normals(name) | Self::Heights(name, _) => name,
        }
    }
}

impl<'a> Maps<'a> {
    fn of(material: &'a MtlMaterial) -> Self {
        Self {
            colour: material.map_kd.as_ref(),
            opacity: material.map_d.as_ref(),
            emission: material.map_ke.as_ref().filter(|_| material.ke.unwrap_or_default() != Vec3::ZERO),
            roughness: material.map_pr.as_ref(),
            metallic: material.map_pm.as_ref(),
            relief: Relief::of(material),
        }
    }

    fn names(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        let relief = self.relief.map(|(map, _)| map);
        [self.colour, self.opacity, self.emission, self.roughness, self.metallic, relief]
            .into_iter()
            .flatten()
            .map(|map| &*map.file)
    }
}

/// The file of a map.
fn name_of(map: Option<&Map>) -> Option<&str> {
    map.map(|map| &*map.file)
}

/// Inputs of a mask: colour map, opacity map, bits of the opacity, whether it ends at its border.
type MaskKey<'a> = (Option<&'a str>, Option<&'a str>, u32, bool);

/// What a texture is made of.
#[derive(Clone, PartialEq, Eq, Hash)]
enum Source<'a> {
    /// Files of colours, and of the opacity by which they count; without one their own alpha.
    Colour(&'a str, Option<&'a str>),
    /// Files of roughness and metallic.
    Data([Option<&'a str>; 2]),
    Relief(Relief<'a>),
}

/// Adds a [`Material`] for each of `materials` (of the OBJ `file`), in order, with textures and masks.
pub(super) fn add_materials(file: &Path, materials: &[MtlMaterial], scene: &mut Scene) {
    let images = Images::read(file, materials);
    warn_of_missing(file, materials, &images, scene);
    let textures = add_textures(materials, &images, scene);
    let mut masks: HashMap<MaskKey<'_>, Option<usize>> = HashMap::new();
    for material in materials {
        let maps = Maps::of(material);
        let surface = surface(material);
        // Masks are read where the colour is.
        let laid = maps.colour.or(maps.opacity);
        let clamp = laid.is_some_and(|map| map.clamp);
        let key = (name_of(maps.colour), name_of(maps.opacity), surface.opacity.to_bits(), clamp);
        let alpha_mask = *masks.entry(key).or_insert_with(|| {
            let mask = mask_of(maps, surface.opacity, &images)?;
            let wrap = if clamp { [Wrap::Clamp; 2] } else { Wrap::REPEAT };
            scene.alpha_masks.push(AlphaMask { wrap, ..mask });
            Some(scene.alpha_masks.len() - 1)
        });
        // Maps of opacity cut out; only `d` makes thin surfaces.
        let cut_out = alpha_mask.is_some() && (maps.opacity.is_some() || !surface.is_thin_surface());
        let texture = |map: Option<&Map>, source: Option<Source<'_>>| Some(map?.of(*textures.get(&source?)?));
        let colour = |map: Option<&Map>| texture(map, colour_of(map, maps));
        let (relief, data) = (maps.relief.unzip(), maps.roughness.or(maps.metallic));
        scene.materials.push(Material {
            base_colour_texture: colour(maps.colour),
            emission_texture: colour(maps.emission),
            metallic_roughness_texture: texture(data, data_of(maps)),
            normal_texture: texture(relief.0, relief.1.map(Source::Relief)),
            alpha: if cut_out { Alpha::Mask(0.5) } else { surface.alpha },
            alpha_mask: alpha_mask.filter(|_| cut_out),
            ..surface
        });
    }
}

fn colour_of<'a>(map: Option<&'a Map>, maps: Maps<'a>) -> Option<Source<'a>> {
    Some(Source::Colour(name_of(map)?, name_of(maps.opacity)))
}

fn data_of(maps: Maps<'_>) -> Option<Source<'_>> {
    let files = [maps.roughness, maps.metallic].map(name_of);
    (files != [None; 2]).then_some(Source::Data(files))
}

fn warn_of_missing(file: &Path, materials: &[MtlMaterial], images: &Images, scene: &mut Scene) {
    for maps in materials.iter().map(Maps::of) {
        for (name, fallback) in [
            (maps.colour, "using a magenta and black checkerboard"),
            (maps.opacity, "using no alpha mask"),
            (maps.emission, "using its colour alone"),
            (maps.roughness, "using its number alone"),
            (maps.metallic, "using its number alone"),
            (maps.relief.map(|(map, _)| map), "using no normal map"),
        ] {
            let Some(name) = name_of(name) else { continue };
            let line = match images.get(name) {
                Err(problem) => format!("{}: texture {name} {problem}; {fallback}", file.display()),
                Ok(image) => match images::shrinking(image) {
                    Some(sizes) => format!("{}: texture {name} is {sizes}", file.display()),
                    None => continue,
                },
            };
            if !scene.warnings.contains(&line) {
                scene.warnings.push(line);
            }
        }
    }
}

/// Adds every texture with its mip chain, or a fallback for an unreadable colour. Returns scene indices by source.
fn add_textures<'a>(
    materials: &'a [MtlMaterial],
    images: &Images,
    scene: &mut Scene,
) -> HashMap<Source<'a>, usize> {
    let mut sources: Vec<Source<'a>> = Vec::new();
    for maps in materials.iter().map(Maps::of) {
        let colours = [maps.colour, maps.emission].map(|map| colour_of(map, maps));
        let data = [data_of(maps), maps.relief.map(|(_, relief)| Source::Relief(relief))];
        for source in colours.into_iter().chain(data).flatten() {
            let readable = match &source {
                Source::Colour(name, _) => name_of(maps.colour) == Some(name) || images.get(name).is_ok(),
                Source::Data(names) => names.iter().flatten().all(|name| images.get(name).is_ok()),
                Source::Relief(relief) => images.get(relief.name()).is_ok(),
            };
            if readable && !sources.contains(&source) {
                sources.push(source);
            }
        }
    }
    let build = |source: &Source<'_>| match source {
        Source::Colour(name, opacity) => {
            let mask = opacity.and_then(|name| images::opacity(images.get(name).ok()?, true));
            match images.get(name) {
                Ok(image) => images::texture(name, image, Content::Colour, mask.as_ref()),
                Err(_) => Texture::missing(name),
            }
        }
        Source::Data([roughness, metallic]) => {
            let image = |name: Option<&str>| images.get(name?).ok();
            images::metallic_roughness(image(*roughness), image(*metallic))
        }
        Source::Relief(relief) => match (images.get(relief.name()), relief) {
            (Ok(image), Relief::Heights(name, multiplier)) if !normal_map::is_normal_map(image) => {
                normal_map::of_heights(name, image, f32::from_bits(*multiplier))
            }
            (Ok(image), _) => images::texture(relief.name(), image, Content::Data, None),
            (Err(_), _) => Texture::missing(relief.name()),
        },
    };
    let first = scene.textures.len();
    scene.textures.par_extend(sources.par_iter().map(build).map(Arc::new));
    sources.into_iter().enumerate().map(|(i, source)| (source, first + i)).collect()
}

/// The alpha mask: `map_d` if present, else the alpha of `map_Kd`, times `d`.
fn mask_of(maps: Maps<'_>, dissolve: f32, images: &Images) -> Option<AlphaMask> {
    let from_opacity = maps.opacity.and_then(|map| images::opacity(images.get(&map.file).ok()?, true));
    let from_colour = || maps.colour.and_then(|map| images::opacity(images.get(&map.file).ok()?, false));
    let mask = from_opacity.or_else(from_colour).unwrap_or_else(AlphaMask::whole);
    Some(mask.cut_at(0.5, dissolve)).filter(AlphaMask::cuts)
}
