//! Spheres of many materials in rows on a ground: plastics in front, metals behind, from smooth to rough.

use glam::Vec3;

use crate::scene::Mesh;
use crate::scene::{GLTF_F0, Material};

/// Roughness of the smoothest and the roughest sphere of a row.
const ROUGHNESS: [f32; 2] = [0.1, 1.0];

/// Spheres of a row.
const STEPS: usize = 7;

/// Name, metallic and base colour of each row, from the front.
const ROWS: [(&str, f32, Vec3); 4] = [
    ("red plastic", 0.0, Vec3::new(0.62, 0.035, 0.03)),
    ("white plastic", 0.0, Vec3::new(0.78, 0.77, 0.74)),
    ("copper", 1.0, Vec3::new(0.955, 0.638, 0.538)),
    ("silver", 1.0, Vec3::new(0.972, 0.96, 0.915)),
];

const RADIUS: f32 = 0.44;

const ROW_DISTANCE: f32 = 1.3;

/// Subdivisions of a sphere: 5,120 triangles.
const SUBDIVISIONS: u32 = 4;

/// Edges of the ground, metres.
const GROUND: [f32; 2] = [24.0, 20.0];

/// Mesh of the grid (metres; the ground at y = 0) with its materials.
pub(super) fn model() -> (Mesh, Vec<Material>) {
    let mut mesh = Mesh { name: "material-grid".into(), ..Mesh::default() };
    let mut materials = vec![surface("ground", 0.0, Vec3::new(0.42, 0.40, 0.37), 0.5)];
    let [x, z] = GROUND.map(|edge| 0.5 * edge);
    mesh.push_polygon(&[[-x, z], [x, z], [x, -z], [-x, -z]].map(|[x, z]| Vec3::new(x, 0.0, z)), 0);
    for (row, (name, metallic, colour)) in ROWS.into_iter().enumerate() {
        for step in 0..STEPS {
            let part = step as f32 / (STEPS - 1) as f32;
            let roughness = ROUGHNESS[0] + (ROUGHNESS[1] - ROUGHNESS[0]) * part;
            let mut sphere = Mesh::sphere("", RADIUS, SUBDIVISIONS, materials.len() as u32);
            let middle = Vec3::new(step as f32 - 3.0, RADIUS, ROW_DISTANCE * (1.5 - row as f32));
            sphere.positions.iter_mut().for_each(|position| *position += middle);
            mesh.append(sphere);
            materials.push(surface(
                &format!("{name}, roughness {roughness:.2}"),
                metallic,
                colour,
                roughness,
            ));
        }
    }
    (mesh, materials)
}

fn surface(name: &str, metallic: f32, colour: Vec3, roughness: f32) -> Material {
    Material { metallic, roughness, f0: GLTF_F0, f90: 1.0, ..Material::lambertian(name, colour) }
}
