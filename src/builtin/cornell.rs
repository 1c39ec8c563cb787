//! The procedural Cornell box.

use glam::{Affine3A, Vec3};

use crate::scene::Material;
use crate::scene::Mesh;
use crate::scene::{Camera, Instance, Scene};

/// Metres a millimetre: the measurements are published in millimetres.
const MILLIMETRE: f32 = 1e-3;

/// The walls of the Cornell box: material and corners in millimetres, seen from inside. The ceiling has
/// a hole for the light, so it consists of four strips.
const WALLS: [(u32, [[f32; 3]; 4]); 8] = [
    (WHITE, [[552.8, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 559.2], [549.6, 0.0, 559.2]]),
    (WHITE, [[556.0, 548.8, 0.0], [556.0, 548.8, 227.0], [0.0, 548.8, 227.0], [0.0, 548.8, 0.0]]),
    (WHITE, [[556.0, 548.8, 332.0], [556.0, 548.8, 559.2], [0.0, 548.8, 559.2], [0.0, 548.8, 332.0]]),
    (WHITE, [[556.0, 548.8, 227.0], [556.0, 548.8, 332.0], [343.0, 548.8, 332.0], [343.0, 548.8, 227.0]]),
    (WHITE, [[213.0, 548.8, 227.0], [213.0, 548.8, 332.0], [0.0, 548.8, 332.0], [0.0, 548.8, 227.0]]),
    (WHITE, [[549.6, 0.0, 559.2], [0.0, 0.0, 559.2], [0.0, 548.8, 559.2], [556.0, 548.8, 559.2]]),
    (GREEN, [[0.0, 0.0, 559.2], [0.0, 0.0, 0.0], [0.0, 548.8, 0.0], [0.0, 548.8, 559.2]]),
    (RED, [[552.8, 0.0, 0.0], [549.6, 0.0, 559.2], [556.0, 548.8, 559.2], [556.0, 548.8, 0.0]]),
];

/// Ground plan (x, z in millimetres, counter-clockwise seen from above) and height of the two blocks.
const BLOCKS: [([[f32; 2]; 4], f32); 2] = [
    ([[130.0, 65.0], [82.0, 225.0], [240.0, 272.0], [290.0, 114.0]], 165.0),
    ([[423.0, 247.0], [265.0, 296.0], [314.0, 456.0], [472.0, 406.0]], 330.0),
];

const LIGHT: [[f32; 3]; 4] =
    [[343.0, 548.8, 227.0], [343.0, 548.8, 332.0], [213.0, 548.8, 332.0], [213.0, 548.8, 227.0]];

const WHITE: u32 = 0;
const RED: u32 = 1;
const GREEN: u32 = 2;
const EMITTER: u32 = 3;

/// Mesh of the Cornell box (metres) with its materials.
pub(crate) fn cornell_model() -> (Mesh, Vec<Material>) {
    let mut mesh = Mesh { name: "cornell-box".into(), ..Mesh::default() };
    let mut push = |corners: &[[f32; 3]], material: u32| {
        let corners: Vec<Vec3> =
            corners.iter().map(|corner| Vec3::from_array(*corner) * MILLIMETRE).collect();
        mesh.push_polygon(&corners, material);
    };
    for (material, corners) in WALLS {
        push(&corners, material);
    }
    for (plan, height) in BLOCKS {
        push(&plan.map(|[x, z]| [x, height, z]), WHITE);
        for i in 0..4 {
            let ([ax, az], [bx, bz]) = (plan[i], plan[(i + 1) % 4]);
            push(&[[ax, 0.0, az], [bx, 0.0, bz], [bx, height, bz], [ax, height, az]], WHITE);
        }
    }
    push(&LIGHT, EMITTER);
    mesh.sort_by_material();
    // Linear RGB of the measured reflectances; the light's 17:12:4 is its warm spectrum at a brightness
    // that exposes the box well.
    let materials = vec![
        Material::lambertian("white", Vec3::new(0.740, 0.742, 0.734)),
        Material::lambertian("red", Vec3::new(0.611, 0.055, 0.062)),
        Material::lambertian("green", Vec3::new(0.117, 0.423, 0.115)),
        Material::emitter("light", Vec3::new(17.0, 12.0, 4.0)),
    ];
    (mesh, materials)
}

/// The Cornell box after the measurements that Cornell University publishes
/// (<https://www.graphics.cornell.edu/online/box/data.html>), in metres, with its area light.
pub(crate) fn cornell_box() -> Scene {
    let mut scene = Scene::new("cornell-box");
    let (mesh, materials) = cornell_model();
    scene.meshes.push(mesh.into());
    scene.materials = materials;
    scene.instances.push(Instance::fixed("cornell-box", 0, Affine3A::IDENTITY));
    scene.add_area_light(0);
    // Published: at (278, 273, -800) along +z, focal length 0.035 and film 0.025 high.
    let eye = Vec3::new(278.0, 273.0, -800.0) * MILLIMETRE;
    scene.files.cameras = 1;
    scene.camera = Camera {
        vertical_fov: 2.0 * (0.5f32 * 0.025 / 0.035).atan(),
        near: 0.01,
        far: 10.0,
        ..Camera::looking(eye, eye + Vec3::Z)
    };
    scene
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::LightKind;

    #[test]
    fn cornell_box_faces_its_inside() {
        let scene = cornell_box();
        let mesh = &scene.meshes[0];
        assert_eq!(mesh.triangles.len(), 2 * (8 + 10 + 1));
        let middle = Vec3::new(0.278, 0.2744, 0.2796);
        // Walls and light face the centre of the box, blocks away from their own centres.
        for (i, triangle) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = mesh.triangle_positions(i as u32);
            let normal = (b - a).cross(c - a).normalize();
            assert!(normal.dot(mesh.normals[triangle[0] as usize]) > 0.999);
            let centre = (a + b + c) / 3.0;
            let block = (a.max(b).max(c)).max_element() < 0.54 && a.min(b).min(c).x > 0.05 && centre.y > 1e-4;
            let towards = if block {
                let own = if centre.x + 0.5 * centre.z < 0.37 { [0.186, 0.168] } else { [0.368, 0.351] };
                centre - Vec3::new(own[0], 0.05, own[1])
            } else {
                middle - centre
            };
            assert!(normal.dot(towards) > 0.0, "triangle {i} at {centre} looks along {normal}");
        }
    }

    #[test]
    fn cornell_light_has_its_published_size() {
        let scene = cornell_box();
        let LightKind::Area { triangles, .. } = &scene.lights[0].kind else { panic!("an area light") };
        let area: f32 = triangles.iter().map(|t| scene.meshes[0].triangle_area(t.triangle)).sum();
        assert!((area - 0.130 * 0.105).abs() < 1e-7);
        assert!((scene.camera.vertical_fov.to_degrees() - 39.3).abs() < 0.05);
    }
}
