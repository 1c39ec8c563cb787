//! Meshes.
//!
//! In: a mesh of the file, and how a node poses it. Out: one of the scene's with the triangles of all its primitives, its normals completed (flat
//! ones where the file has none), and tangents and a second set of texture coordinates where its materials need them.

use ::gltf::mesh::Mode;
use ::gltf::{Mesh as FileMesh, Primitive, Semantic};
use glam::{Affine3A, Vec3, Vec4};

use super::attributes::Attributes;
use super::materials::Materials;
use super::shape::Shape;
use super::source::Source;
use crate::formats::error::SceneError;
use crate::scene::{MAX_COORDINATE, Mesh, Scene, SurfaceTransform, normals, tangents};

/// The mesh `mesh`; none if it has no triangles.
pub(super) fn mesh_of(
    source: &mut Source,
    (mesh, shape): (&FileMesh<'_>, &Shape),
    materials: &Materials,
    scene: &Scene,
) -> Result<Option<Mesh>, SceneError> {
    let name = mesh.name().map_or_else(|| format!("mesh {}", mesh.index()), str::to_owned);
    let mut made = Mesh { name, ..Mesh::default() };
    for primitive in mesh.primitives() {
        let piece = piece_of(source, (&primitive, shape), (mesh.index(), materials), scene)?;
        piece.into_iter().for_each(|piece| made.append(piece));
    }
    made.drop_degenerate_triangles();
    made.sort_by_material();
    normals::fill_missing(&mut made);
    made.drop_repeated_triangles();
    tangents::fill_missing(&mut made, &scene.materials);
    made.drop_unused_vertices();
    Ok((!made.triangles.is_empty()).then_some(made))
}

/// The triangles of a primitive; none if it has none.
fn piece_of(
    source: &mut Source,
    (primitive, shape): (&Primitive<'_>, &Shape),
    (mesh, materials): (usize, &Materials),
    scene: &Scene,
) -> Result<Option<Mesh>, SceneError> {
    let place = format!("mesh {mesh} primitive {}", primitive.index());
    if matches!(primitive.mode(), Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
        source.not_shown.insert("points and lines".to_owned());
        return Ok(None);
    }
    let Some(accessor) = primitive.get(&Semantic::Positions) else {
        source.not_shown.insert("primitives without positions".to_owned());
        return Ok(None);
    };
    let material = materials.of(&primitive.material());
    let vectors = |list: Vec<[f32; 3]>| list.into_iter().map(Vec3::from_array).collect();
    let positions: Vec<Vec3> = vectors(source.vertices(&accessor, "POSITION")?);
    let reader = Attributes { source, primitive, place: &place, count: positions.len() };
    let normals = reader.read::<3>(&Semantic::Normals, "normals")?.map(vectors);
    let has_normals = normals.is_some();
    let mut piece = Mesh { positions, normals: normals.unwrap_or_default(), ..Mesh::default() };
    reader.add_to(&mut piece, &scene.materials[material])?;
    shape.pose(&reader, &mut piece)?;
    let in_range = |position: &Vec3| position.abs().cmple(Vec3::splat(MAX_COORDINATE)).all();
    if !piece.positions.iter().all(in_range) {
        return Err(
            source.error(format!("{place}: a vertex is beyond +-{MAX_COORDINATE:e}; scale the model down"))
        );
    }
    let indices = match primitive.indices() {
        Some(accessor) => source.indices(&accessor)?,
        None => (0..piece.positions.len() as u32).collect(),
    };
    if let Some(index) = indices.iter().find(|index| **index as usize >= piece.positions.len()) {
        let total = piece.positions.len();
        return Err(
            source.error(format!("{place} uses vertex {index}, but has {total}; export the file again"))
        );
    }
    piece.triangles = triangles_of(primitive.mode(), &indices);
    piece.triangle_materials = vec![material as u32; piece.triangles.len()];
    if shape.mirrors() {
        piece.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    match has_normals {
        true => piece.normals.iter_mut().for_each(|normal| *normal = normal.normalize_or_zero()),
        false => shade_flat(&mut piece),
    }
    if !piece.tangents.is_empty() {
        let usable = |(tangent, normal): (&Vec4, &Vec3)| tangents::usable(*tangent, *normal);
        piece.tangents = piece.tangents.iter().zip(&piece.normals).map(usable).collect();
    }
    Ok(Some(piece))
}

/// Gives each triangle vertices of its own with its normal. The file's tangents do not count then.
fn shade_flat(piece: &mut Mesh) {
    piece.tangents.clear();
    piece.unshare_vertices();
    piece.normals = piece
        .positions
        .chunks_exact(3)
        .flat_map(|corners| [(corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero(); 3])
        .collect();
}

fn triangles_of(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => indices
            .windows(3)
            .enumerate()
            .map(|(i, t)| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] })
            .collect(),
        Mode::TriangleFan => match indices {
            [hub, rim @ ..] => rim.windows(2).map(|edge| [*hub, edge[0], edge[1]]).collect(),
            [] => Vec::new(),
        },
        _ => indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
    }
}

/// The mesh transformed: a mirroring transform turns its triangles over, so that their front stays in front.
pub(super) fn baked(mesh: &Mesh, transform: &Affine3A) -> Mesh {
    let placement = SurfaceTransform::new(transform);
    let mut baked = mesh.clone();
    for position in &mut baked.positions {
        *position = transform.transform_point3(*position);
    }
    for normal in &mut baked.normals {
        *normal = placement.normal(*normal);
    }
    let mirrored = transform.matrix3.determinant() < 0.0;
    if mirrored {
        baked.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    let side = if mirrored { -1.0 } else { 1.0 };
    for (tangent, normal) in baked.tangents.iter_mut().zip(&baked.normals) {
        let direction = transform.transform_vector3(tangent.truncate());
        *tangent = tangents::usable(direction.extend(side * tangent.w), *normal);
    }
    baked
}
