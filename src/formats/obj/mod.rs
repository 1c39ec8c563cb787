//! Wavefront OBJ models, read by tobj.
//!
//! In: an `.obj` file with its libraries and images. Out: one mesh in the scene with all its triangles, sorted by
//! material, and their materials, textures and alpha masks. Degenerate faces are removed; missing normals are
//! generated with a crease angle (see `normals`); missing texture coordinates are zero.

mod materials;
mod mtl;
mod normal_map;
mod statements;
mod surface;

use std::cell::RefCell;
use std::path::Path;

use glam::{Vec2, Vec3};

use super::error::SceneError;
use crate::scene::polygon::triangulate;
use crate::scene::{MAX_COORDINATE, Material, Mesh, Scene, normals, tangents};
use mtl::MtlMaterial;
pub(crate) use mtl::find_any_case;

/// Reads `file` and adds its mesh and materials to `scene`; returns the index of the mesh.
pub(crate) fn add_obj(file: &Path, scene: &mut Scene) -> Result<usize, SceneError> {
    let bytes =
        std::fs::read(file).map_err(|reason| SceneError::Unreadable { file: file.to_owned(), reason })?;
    if bytes.contains(&0) {
        let problem = "is a binary file, not a Wavefront OBJ; export the model as text .obj";
        return Err(SceneError::invalid(file, None, problem));
    }
    // Comments and material names of old exporters are often Latin-1, so decode leniently.
    let text = String::from_utf8_lossy(&bytes);
    let meshes = statements::of_meshes(&text);
    let (parts, materials) = read_parts(file, &meshes, &mut scene.warnings).map_err(|error| {
        let unknown = || SceneError::invalid(file, None, format!("{error}; fix or re-export the model"));
        statements::error_in(file, &text).unwrap_or_else(unknown)
    })?;

    let first_material = scene.materials.len();
    materials::add_materials(file, &materials, scene);
    // Faces without a material are grey.
    let grey = scene.materials.len();
    scene.materials.push(Material::grey("grey"));
    if parts.iter().any(|part| part.material_id.is_none()) {
        warn_of_undefined(file, &meshes, &materials, scene);
    }
    let mut mesh = Mesh { name: stem(file), ..Mesh::default() };
    for part in &parts {
        let material = part.material_id.map_or(grey, |id| first_material + id);
        append(&mut mesh, part, material as u32);
    }
    let is_usable = |position: &Vec3| position.is_finite() && position.abs().max_element() <= MAX_COORDINATE;
    let is_finite = mesh.positions.iter().all(is_usable) && mesh.uvs.iter().all(|uv| uv.is_finite());
    if let (false, Some(error)) = (is_finite, statements::error_in(file, &text)) {
        return Err(error);
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

/// Lets tobj build meshes of polygons with one index a vertex. It asks for each library; of its materials it needs the names.
fn read_parts(
    file: &Path,
    meshes: &str,
    warnings: &mut Vec<String>,
) -> Result<(Vec<tobj::Mesh>, Vec<MtlMaterial>), tobj::LoadError> {
    let read = RefCell::new((Vec::new(), warnings));
    let options = tobj::LoadOptions { single_index: true, ..Default::default() };
    let (models, _) = tobj::load_obj_buf(&mut meshes.as_bytes(), &options, |libraries| {
        let (materials, warnings) = &mut *read.borrow_mut();
        let first = materials.len();
        materials.extend(mtl::read_libraries(file, &libraries.to_string_lossy(), warnings));
        let names: Vec<_> = materials[first..].iter().map(|material| material.name.clone()).collect();
        let named = names.iter().map(|name| tobj::Material { name: name.clone(), ..Default::default() });
        Ok((named.collect(), names.iter().cloned().zip(0..).collect()))
    })?;
    Ok((models.into_iter().map(|model| model.mesh).collect(), read.into_inner().0))
}

fn warn_of_undefined(file: &Path, meshes: &str, materials: &[MtlMaterial], scene: &mut Scene) {
    let mut undefined = statements::materials_of(meshes);
    undefined.retain(|name| !materials.iter().any(|material| material.name == *name));
    if let [first, others @ ..] = &undefined[..] {
        let more = if others.is_empty() { String::new() } else { format!(" and {} more", others.len()) };
        scene.warnings.push(format!(
            "{}: material {first}{more} is not defined in any material library; using grey",
            file.display()
        ));
    }
}

/// Appends one of tobj's meshes; all its faces have the same attributes, so its arrays are aligned.
fn append(mesh: &mut Mesh, part: &tobj::Mesh, material: u32) {
    let first = mesh.positions.len();
    let total = first + part.positions.len() / 3;
    mesh.positions.extend(part.positions.chunks_exact(3).map(Vec3::from_slice));
    if part.normals.len() == part.positions.len() {
        // A normal of zero counts as missing, and is generated from the faces.
        let normals = part.normals.chunks_exact(3).map(|normal| Vec3::from_slice(normal).normalize_or_zero());
        mesh.normals.extend(normals);
    }
    mesh.normals.resize(total, Vec3::ZERO);
    if part.texcoords.len() == 2 * (total - first) {
        // OBJ counts v from the bottom of the image.
        mesh.uvs.extend(part.texcoords.chunks_exact(2).map(|uv| Vec2::new(uv[0], 1.0 - uv[1])));
    }
    mesh.uvs.resize(total, Vec2::ZERO);
    // Without a list of them, all faces are triangles.
    let mut corners = &part.indices[..];
    let mut arities = part.face_arities.iter();
    while !corners.is_empty() {
        let (face, rest) = corners.split_at(arities.next().map_or(3, |&arity| arity as usize));
        corners = rest;
        let face: Vec<u32> = face.iter().map(|corner| first as u32 + corner).collect();
        let points: Vec<Vec3> = face.iter().map(|&corner| mesh.positions[corner as usize]).collect();
        mesh.triangles.extend(triangulate(&points).into_iter().map(|triangle| triangle.map(|i| face[i])));
    }
    mesh.triangle_materials.resize(mesh.triangles.len(), material);
}

/// Removes degenerate faces, sorts by material, generates missing normals, removes unused vertices.
fn clean_up(file: &Path, mesh: &mut Mesh) -> Result<(), SceneError> {
    let before = mesh.triangles.len();
    mesh.drop_degenerate_triangles();
    if mesh.triangles.is_empty() {
        let problem = match before {
            0 => "has no triangles; export a model with faces as .obj".to_owned(),
            _ => format!("all of its {before} triangles have zero area; re-export the model"),
        };
        return Err(SceneError::invalid(file, None, problem));
    }
    if mesh.triangles.len() < before {
        log::info!("{}: dropped {} triangles of zero area", file.display(), before - mesh.triangles.len());
    }
    mesh.sort_by_material();
    normals::fill_missing(mesh);
    mesh.drop_unused_vertices();
    Ok(())
}
