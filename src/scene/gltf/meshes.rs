//! Meshes.
//!
//! In: a mesh of the file. Out: one of the scene's with the triangles of all its primitives, its normals completed (flat
//! ones where the file has none), its texture coordinates transformed.

use ::gltf::mesh::Mode;
use ::gltf::{Mesh as FileMesh, Primitive, Semantic};
use glam::{Affine3A, Vec2, Vec3};

use super::materials::{Coordinates, Materials};
use super::source::Source;
use crate::scene::error::SceneError;
use crate::scene::mesh::Mesh;
use crate::scene::{MAX_COORDINATE, SurfaceTransform, normals};

/// The mesh `mesh`; none if it has no triangles.
pub(super) fn mesh_of(
    source: &mut Source,
    mesh: &FileMesh<'_>,
    materials: &Materials,
) -> Result<Option<Mesh>, SceneError> {
    let name = mesh.name().map_or_else(|| format!("mesh {}", mesh.index()), str::to_owned);
    let mut made = Mesh { name, ..Mesh::default() };
    for primitive in mesh.primitives() {
        append(source, &mut made, mesh, &primitive, materials)?;
    }
    made.drop_degenerate_triangles();
    made.sort_by_material();
    normals::fill_missing(&mut made);
    made.drop_unused_vertices();
    Ok((!made.triangles.is_empty()).then_some(made))
}

fn append(
    source: &mut Source,
    made: &mut Mesh,
    mesh: &FileMesh<'_>,
    primitive: &Primitive<'_>,
    materials: &Materials,
) -> Result<(), SceneError> {
    let place = format!("mesh {} primitive {}", mesh.index(), primitive.index());
    if primitive.morph_targets().len() > 0 {
        source.not_shown.insert("morph targets (the shape at rest is)".to_owned());
    }
    if primitive.get(&Semantic::Colors(0)).is_some() {
        source.not_shown.insert("vertex colours".to_owned());
    }
    if matches!(primitive.mode(), Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
        source.not_shown.insert("points and lines".to_owned());
        return Ok(());
    }
    let Some(accessor) = primitive.get(&Semantic::Positions) else {
        return Err(source.error(format!("{place} has no POSITION; export the file again")));
    };
    let positions: Vec<Vec3> =
        source.vertices(&accessor, "POSITION")?.into_iter().map(Vec3::from_array).collect();
    if positions.iter().any(|position| position.abs().max_element() > MAX_COORDINATE) {
        return Err(
            source.error(format!("{place}: a vertex is beyond +-{MAX_COORDINATE:e}; scale the model down"))
        );
    }
    let of_all = |count: usize, what: &str| {
        if count == positions.len() {
            Ok(())
        } else {
            let total = positions.len();
            Err(source
                .error(format!("{place} has {total} positions, but {count} {what}; export the file again")))
        }
    };
    let mut given: Option<Vec<Vec3>> = None;
    if let Some(accessor) = primitive.get(&Semantic::Normals) {
        let normals = source.vertices(&accessor, "NORMAL")?;
        of_all(normals.len(), "normals")?;
        given = Some(normals.into_iter().map(|n| Vec3::from_array(n).normalize_or_zero()).collect());
    }
    let (material, coordinates) = materials.of(&primitive.material());
    let uvs = match primitive.get(&Semantic::TexCoords(coordinates.set)) {
        Some(accessor) => {
            let uvs = source.vertices(&accessor, "TEXCOORD")?;
            of_all(uvs.len(), "texture coordinates")?;
            uvs.into_iter().map(|uv| transformed(uv, &coordinates)).collect()
        }
        None => vec![Vec2::ZERO; positions.len()],
    };
    let indices = match primitive.indices() {
        Some(accessor) => source.indices(&accessor)?,
        None => (0..positions.len() as u32).collect(),
    };
    if let Some(index) = indices.iter().find(|index| **index as usize >= positions.len()) {
        let total = positions.len();
        return Err(
            source.error(format!("{place} uses vertex {index}, but has {total}; export the file again"))
        );
    }
    let triangles = triangles_of(primitive.mode(), &indices);
    let first = made.positions.len() as u32;
    match given {
        Some(normals) => {
            made.positions.extend(&positions);
            made.normals.extend(normals);
            made.uvs.extend(uvs);
            made.triangles.extend(triangles.iter().map(|triangle| triangle.map(|vertex| first + vertex)));
        }
        // Flat normals: no two triangles share a vertex.
        None => {
            for triangle in &triangles {
                let corners = triangle.map(|vertex| positions[vertex as usize]);
                let [a, b, c] = corners;
                let next = made.positions.len() as u32;
                made.positions.extend(corners);
                made.normals.extend([(b - a).cross(c - a).normalize_or_zero(); 3]);
                made.uvs.extend(triangle.map(|vertex| uvs[vertex as usize]));
                made.triangles.push([next, next + 1, next + 2]);
            }
        }
    }
    made.triangle_materials.resize(made.triangles.len(), material);
    Ok(())
}

fn transformed(uv: [f32; 2], coordinates: &Coordinates) -> Vec2 {
    coordinates.offset + coordinates.matrix * Vec2::from_array(uv)
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
    if transform.matrix3.determinant() < 0.0 {
        baked.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    baked
}
