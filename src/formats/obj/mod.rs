//! Wavefront OBJ models, parsed by tobj.
//!
//! In: an `.obj` file with its libraries and images. Out: one mesh in the scene with all its triangles, sorted by
//! material, and their materials, textures and alpha masks. Degenerate faces are removed; missing normals are
//! generated with a crease angle (see `normals`); missing texture coordinates are zero.

mod materials;
mod mtl;
mod normal_map;
mod surface;
mod text;

use std::path::Path;

use glam::{Vec2, Vec3};

use super::error::SceneError;
use crate::scene::{Material, Mesh, Scene, normals, tangents};
use text::ObjText;

/// Reads `file` and adds its mesh and materials to `scene`; returns the index of the mesh.
pub(crate) fn add_obj(file: &Path, scene: &mut Scene) -> Result<usize, SceneError> {
    let bytes =
        std::fs::read(file).map_err(|reason| SceneError::Unreadable { file: file.to_owned(), reason })?;
    let obj = ObjText::check(file, &bytes)?;

    // Load the materials and a grey fallback for undefined ones.
    let first_material = scene.materials.len();
    let materials = mtl::read_libraries(file, &obj.libraries, &mut scene.warnings);
    materials::add_materials(file, &materials, scene);
    warn_of_undefined(file, &obj, &materials, scene);
    let grey = scene.materials.len();
    scene.materials.push(Material::grey("grey"));

    // Let tobj build single-indexed triangles.
    let options = tobj::LoadOptions { single_index: true, triangulate: true, ..Default::default() };
    let by_name = materials.iter().enumerate().map(|(i, material)| (material.name.clone(), i)).collect();
    let library = (materials, by_name);
    let text = format!("mtllib all\n{}", obj.text);
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, |_| Ok(library.clone()))
        .map_err(|error| SceneError::invalid(file, None, format!("{error}; fix or re-export the model")))?;

    let mut mesh = Mesh { name: stem(file), ..Mesh::default() };
    for model in &models {
        let material = model.mesh.material_id.map_or(grey, |id| first_material + id);
        append(&mut mesh, &model.mesh, material as u32);
    }
    clean_up(file, &mut mesh)?;
    tangents::fill_missing(&mut mesh, &scene.materials);
    if !mesh.triangle_materials.contains(&(grey as u32)) {
        scene.materials.pop();
    }
    scene.meshes.push(mesh.into());
    Ok(scene.meshes.len() - 1)
}

/// File name without folder and extension.
pub(crate) fn stem(file: &Path) -> String {
    file.file_stem().map_or_else(|| "model".into(), |stem| stem.to_string_lossy().into_owned())
}

fn warn_of_undefined(file: &Path, obj: &ObjText, materials: &[tobj::Material], scene: &mut Scene) {
    let defined = |name: &&String| materials.iter().any(|material| material.name == **name);
    let undefined: Vec<&str> =
        obj.materials.iter().filter(|name| !defined(name)).map(String::as_str).collect();
    if let Some(first) = undefined.first() {
        let more = match undefined.len() {
            1 => String::new(),
            n => format!(" and {} more", n - 1),
        };
        scene.warnings.push(format!(
            "{}: material {first}{more} is not defined in any material library; using grey",
            file.display()
        ));
    }
}

/// Appends one of tobj's meshes; all its faces have the same attributes, so its arrays are aligned.
fn append(mesh: &mut Mesh, part: &tobj::Mesh, material: u32) {
    let first = mesh.positions.len() as u32;
    let count = part.positions.len() / 3;
    mesh.positions.extend(part.positions.chunks_exact(3).map(Vec3::from_slice));
    if part.normals.len() == part.positions.len() {
        mesh.normals.extend(part.normals.chunks_exact(3).map(Vec3::from_slice));
    } else {
        mesh.normals.resize(first as usize + count, Vec3::ZERO);
    }
    if part.texcoords.len() == 2 * count {
        // OBJ counts v from the bottom of the image.
        mesh.uvs.extend(part.texcoords.chunks_exact(2).map(|uv| Vec2::new(uv[0], 1.0 - uv[1])));
    } else {
        mesh.uvs.resize(first as usize + count, Vec2::ZERO);
    }
    let triangles = part.indices.chunks_exact(3).map(|t| [first + t[0], first + t[1], first + t[2]]);
    mesh.triangles.extend(triangles);
    mesh.triangle_materials.resize(mesh.triangles.len(), material);
}

/// Removes degenerate faces, sorts by material, generates missing normals, removes unused vertices.
fn clean_up(file: &Path, mesh: &mut Mesh) -> Result<(), SceneError> {
    let before = mesh.triangles.len();
    mesh.drop_degenerate_triangles();
    if mesh.triangles.is_empty() {
        return Err(SceneError::invalid(
            file,
            None,
            format!("all of its {before} triangles have zero area; re-export the model"),
        ));
    }
    if mesh.triangles.len() < before {
        log::info!("{}: dropped {} triangles of zero area", file.display(), before - mesh.triangles.len());
    }
    mesh.sort_by_material();
    normals::fill_missing(mesh);
    mesh.drop_unused_vertices();
    Ok(())
}
