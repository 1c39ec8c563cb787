//! The `[[models]]` of a scene file.
//!
//! In: one entry. Out: a mesh with its materials in the scene under construction.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec3;

use super::builder::Builder;
use super::clip::clip_to_box;
use super::entry::{At, Entry};
use super::schema::{MaterialEntry, ModelEntry, Primitive};
use crate::builtin;
use crate::formats::error::SceneError;
use crate::formats::{gltf, obj};
use crate::scene::{GLTF_F0, Material, Mesh, Scene};

/// Download hint for an asset without a `download` key.
const DOWNLOAD: &str = "see the credits in the scene file";

/// Adds the mesh of the model of entry `index`.
pub(super) fn add_model(builder: &mut Builder, index: usize, model: &ModelEntry) -> Result<(), SceneError> {
    let entry = builder.entry(At::Entry("models", index), format!("model \"{}\"", model.name));
    if builder.models.contains_key(&model.name) {
        return Err(entry.error("another model has this name; rename one"));
    }
    check_keys(&entry, model)?;
    let mesh = if let Some(path) = &model.path {
        let folder = builder.path.parent().unwrap_or(Path::new(""));
        let file = folder.join(path);
        if !file.is_file() {
            return Err(entry.error(format!(
                "path {} is not a file; paths are relative to the scene file",
                file.display()
            )));
        }
        add_file(&entry, &file, &mut builder.scene)?
    } else if let Some(asset) = &model.asset {
        let file = find_asset(builder, asset, model.download.as_ref())?;
        add_file(&entry, &file, &mut builder.scene)?
    } else if let Some(name) = &model.builtin {
        let made = builtin::model(name).ok_or_else(|| {
            let known = builtin::MODELS.join(", ");
            entry.error(format!("unknown built-in model \"{name}\"; known are {known}"))
        })?;
        made.add_to(&mut builder.scene)
    } else {
        let primitive = entry.required("path, asset, builtin or primitive", model.primitive)?;
        let mesh = primitive_mesh(&entry, builder, model, primitive)?;
        push(&mut builder.scene, mesh)
    };
    remove_excluded(&entry, model, &mut builder.scene, mesh)?;
    Arc::make_mut(&mut builder.scene.meshes[mesh]).name.clone_from(&model.name);
    builder.models.insert(model.name.clone(), mesh);
    Ok(())
}

/// Adds the mesh of a model's file, by its ending; returns its index.
fn add_file(entry: &Entry, file: &Path, scene: &mut Scene) -> Result<usize, SceneError> {
    if gltf::is_gltf(file) {
        return gltf::add_model(file, scene);
    }
    if !file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("obj")) {
        let problem =
            format!("{} is no .obj, .gltf or .glb; convert the model to one of them", file.display());
        return Err(entry.error(problem));
    }
    obj::add_obj(file, scene)
}

fn push(scene: &mut Scene, mesh: Mesh) -> usize {
    scene.meshes.push(mesh.into());
    scene.meshes.len() - 1
}

fn check_keys(entry: &Entry, model: &ModelEntry) -> Result<(), SceneError> {
    let sources =
        [model.path.is_some(), model.asset.is_some(), model.builtin.is_some(), model.primitive.is_some()];
    if sources.iter().filter(|given| **given).count() != 1 {
        return Err(entry.error("needs exactly one of the keys path, asset, builtin and primitive"));
    }
    let primitive = model.primitive.is_some();
    for (key, given, fits) in [
        ("size", model.size.is_some(), primitive),
        ("subdivisions", model.subdivisions.is_some(), model.primitive == Some(Primitive::Sphere)),
        ("material", model.material.is_some(), primitive),
        ("download", model.download.is_some(), model.asset.is_some()),
        ("without_materials", !model.without_materials.is_empty(), !primitive),
    ] {
        if given && !fits {
            return Err(
                entry.error(format!("the key {key} is not allowed for this kind of model; remove it"))
            );
        }
    }
    Ok(())
}

/// The file of an asset, which may be downloaded from `download`.
pub(super) fn find_asset(
    builder: &Builder,
    asset: &Path,
    download: Option<&String>,
) -> Result<PathBuf, SceneError> {
    let found = match builder.assets {
        Some(folder) => {
            let file = folder.join(asset);
            if file.is_file() {
                return Ok(file);
            }
            format!("is not in {}", folder.display())
        }
        None => "is not shipped".to_owned(),
    };
    Err(SceneError::MissingAsset {
        scene: builder.scene.name.clone(),
        asset: asset.to_owned(),
        found,
        source_url: download.cloned().unwrap_or_else(|| DOWNLOAD.into()),
    })
}

fn primitive_mesh(
    entry: &Entry,
    builder: &mut Builder,
    model: &ModelEntry,
    primitive: Primitive,
) -> Result<Mesh, SceneError> {
    let size = entry.place("size", model.size.unwrap_or([1.0; 3]))?;
    if size.min_element() <= 0.0 {
        return Err(entry.error(format!("size must be above 0, is {size}")));
    }
    let subdivisions = model.subdivisions.unwrap_or(4);
    if subdivisions > 8 {
        return Err(entry.error(format!("subdivisions must be from 0 to 8, is {subdivisions}")));
    }
    let material = builder.scene.materials.len() as u32;
    builder.scene.materials.push(material_of(entry, &model.name, model.material.as_ref())?);
    Ok(match primitive {
        Primitive::Quad => {
            let half = 0.5 * size;
            let corner = |x: f32, z: f32| Vec3::new(x * half.x, 0.0, z * half.z);
            let corners = [corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)];
            Mesh::polygon(&model.name, &corners, material)
        }
        Primitive::Box => Mesh::cuboid(&model.name, size, material),
        Primitive::Sphere => Mesh::sphere(&model.name, size.x, subdivisions, material),
    })
}

fn material_of(entry: &Entry, name: &str, material: Option<&MaterialEntry>) -> Result<Material, SceneError> {
    let grey = Material::grey(name);
    let Some(material) = material else {
        return Ok(grey);
    };
    let emission = entry.power("material.emission", material.emission.unwrap_or_default())?;
    let metallic = entry.share("material.metallic", material.metallic.unwrap_or(0.0))?;
    let roughness = entry.share("material.roughness", material.roughness.unwrap_or(1.0))?;
    if metallic > 0.0 && material.roughness.is_none() {
        return Err(entry.error("material.metallic needs material.roughness"));
    }
    let base_colour = match material.albedo {
        Some(albedo) => entry.reflectance("material.albedo", albedo)?,
        None => grey.base_colour,
    };
    let plain = Material { base_colour, emission, ..grey };
    Ok(match material.roughness {
        None => plain,
        Some(_) => Material { metallic, roughness, f0: GLTF_F0, f90: 1.0, ..plain },
    })
}

/// Removes the triangles of `without_materials`, and clips the rest to the box `clip`.
fn remove_excluded(
    entry: &Entry,
    model: &ModelEntry,
    scene: &mut Scene,
    mesh: usize,
) -> Result<(), SceneError> {
    let mesh = Arc::make_mut(&mut scene.meshes[mesh]);
    for name in &model.without_materials {
        let named = |material: u32| scene.materials[material as usize].name == *name;
        let before = mesh.triangles.len();
        mesh.retain_triangles(|mesh, i| !named(mesh.triangle_materials[i]));
        if mesh.triangles.len() == before {
            return Err(entry.error(format!("without_materials: no triangle has the material \"{name}\"")));
        }
    }
    if let Some(clip) = &model.clip {
        let (min, max) = (entry.vector("clip.min", clip.min)?, entry.vector("clip.max", clip.max)?);
        if !min.cmplt(max).all() {
            return Err(entry.error(format!("clip.min must be below clip.max (min {min}, max {max})")));
        }
        clip_to_box(mesh, min, max);
    }
    if mesh.triangles.is_empty() {
        return Err(entry.error("without_materials and clip remove all triangles"));
    }
    mesh.drop_unused_vertices();
    Ok(())
}
