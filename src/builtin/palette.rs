//! Materials of the built-in models, with procedural textures.
//!
//! In: functions from texture coordinates to colour. Out: materials, textures and alpha masks with consistent indices;
//! a function used twice is evaluated once.

use std::collections::HashMap;

use glam::{Vec2, Vec3, Vec4, vec2};
use rayon::prelude::*;

use crate::scene::linear_to_srgb;
use crate::scene::{AlphaMask, Material, Texture};

/// A procedural texture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Recipe {
    /// Name for reports.
    pub name: &'static str,
    /// Size in texels.
    pub size: [u32; 2],
    /// Size in metres.
    pub extent: [f32; 2],
    /// Linear colour and opacity at a point in the unit square, y down.
    pub paint: fn(Vec2) -> Vec4,
}

/// Materials under construction; meshes hold indices into it.
#[derive(Debug, Default)]
pub(super) struct Palette {
    materials: Vec<Material>,
    recipes: Vec<Option<Recipe>>,
}

/// Finished materials.
pub(super) struct Paints {
    pub materials: Vec<Material>,
    pub textures: Vec<Texture>,
    pub alpha_masks: Vec<AlphaMask>,
    /// Size of each material's texture, metres.
    pub tiles: Vec<Vec2>,
}

impl Palette {
    /// A plain colour, linear.
    pub fn plain(&mut self, name: &str, albedo: [f32; 3]) -> u32 {
        self.push(Material::lambertian(name, Vec3::from_array(albedo)), None)
    }

    /// A plain colour under a coat: reflectance at normal incidence, exponent of the highlight.
    pub fn glossy(&mut self, name: &str, albedo: [f32; 3], specular: f32, shininess: f32) -> u32 {
        let material = Material::lambertian(name, Vec3::from_array(albedo));
        self.push(material.coated(Vec3::splat(specular), shininess), None)
    }

    /// A texture, multiplied with a tint.
    pub fn textured(&mut self, name: &str, recipe: Recipe, tint: [f32; 3]) -> u32 {
        self.push(Material::lambertian(name, Vec3::from_array(tint)), Some(recipe))
    }

    /// A texture under a coat, likewise.
    pub fn polished(&mut self, name: &str, recipe: Recipe, specular: f32, shininess: f32) -> u32 {
        let material = Material::lambertian(name, Vec3::ONE);
        self.push(material.coated(Vec3::splat(specular), shininess), Some(recipe))
    }

    fn push(&mut self, material: Material, recipe: Option<Recipe>) -> u32 {
        self.materials.push(material);
        self.recipes.push(recipe);
        self.materials.len() as u32 - 1
    }

    /// Evaluates the textures.
    pub fn finish(mut self) -> Paints {
        let mut used: Vec<Recipe> = Vec::new();
        let mut places: HashMap<&str, usize> = HashMap::new();
        for recipe in self.recipes.iter().flatten() {
            places.entry(recipe.name).or_insert_with(|| {
                used.push(*recipe);
                used.len() - 1
            });
        }
        let painted: Vec<(Texture, Option<AlphaMask>)> = used.par_iter().map(paint).collect();
        let mut paints = Paints { materials: vec![], textures: vec![], alpha_masks: vec![], tiles: vec![] };
        let mut masks = Vec::with_capacity(painted.len());
        for (texture, mask) in painted {
            masks.push(mask.map(|mask| {
                paints.alpha_masks.push(mask);
                paints.alpha_masks.len() - 1
            }));
            paints.textures.push(texture);
        }
        for (material, recipe) in self.materials.iter_mut().zip(&self.recipes) {
            let place = recipe.as_ref().and_then(|recipe| places.get(recipe.name).copied());
            material.base_colour_texture = place.map(Into::into);
            material.alpha_mask = place.and_then(|place| masks[place]);
            paints.tiles.push(recipe.map_or(Vec2::ONE, |recipe| Vec2::from_array(recipe.extent)));
        }
        paints.materials = self.materials;
        paints
    }
}

fn paint(recipe: &Recipe) -> (Texture, Option<AlphaMask>) {
    let [width, height] = recipe.size;
    let mut texels = vec![0; 4 * width as usize * height as usize];
    texels.par_chunks_mut(4 * width as usize).enumerate().for_each(|(y, row)| {
        for (x, texel) in row.chunks_mut(4).enumerate() {
            let place = (vec2(x as f32, y as f32) + 0.5) / vec2(width as f32, height as f32);
            let colour = (recipe.paint)(place);
            for (channel, value) in texel.iter_mut().zip(colour.truncate().to_array()) {
                *channel = linear_to_srgb(value);
            }
            texel[3] = (colour.w.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        }
    });
    let opacity: Vec<u8> = texels.chunks(4).map(|texel| texel[3]).collect();
    let mask = AlphaMask::from_opacity(width, height, &opacity, 1.0);
    (Texture::from_rgba8(recipe.name, width, height, texels), mask)
}
