//! Shapes and their PLY files.

use glam::{Affine3A, Vec3};
use glowworm::formats::load_scene;
use glowworm::scene::{Instance, Material, Mesh, Scene};

use crate::support::*;

#[test]
fn every_triangle_is_there_once_bit_by_bit() {
    let scene = load_scene("cornell-box", None).unwrap();
    let exported = export(&scene);
    let document = roxmltree::Document::parse(&exported.text).unwrap();
    let mesh = &scene.meshes[0];
    let mut expected: Vec<_> = (0..mesh.triangles.len() as u32)
        .map(|triangle| {
            let material = mesh.triangle_materials[triangle as usize];
            (material, mesh.triangle_positions(triangle).map(|corner| corner.to_array().map(f32::to_bits)))
        })
        .collect();
    let mut found = Vec::new();
    for shape in elements(document.root_element(), "shape") {
        let id = only(shape, "ref").attribute("id").unwrap();
        let material: u32 = id.split('-').nth(1).unwrap().parse().unwrap();
        let ply = exported.mesh(shape);
        assert!(ply.uvs.is_empty());
        found.extend((0..ply.triangles.len()).map(|triangle| {
            (material, ply.corners(triangle).map(|corner| corner.to_array().map(f32::to_bits)))
        }));
        for (triangle, vertices) in ply.triangles.iter().enumerate().filter(|_| !ply.normals.is_empty()) {
            let normals = vertices.map(|vertex| ply.normals[vertex as usize]);
            assert!(normals.iter().all(|normal| normal.distance(ply.front(triangle)) < 1e-2));
        }
    }
    expected.sort_unstable();
    found.sort_unstable();
    assert_eq!(found, expected);
    assert_eq!(exported.report.triangles, expected.len());
}

#[test]
fn lamps_shine_on_their_front_side_and_are_flat_unless_they_reflect() {
    for base in [0.0, 0.5] {
        let mut scene = Scene::new("emitters");
        scene
            .materials
            .push(Material { base_colour: Vec3::splat(base), ..Material::emitter("glow", Vec3::ONE) });
        scene.meshes.push(Mesh::sphere("ball", 1.0, 1, 0).into());
        let places = [
            Affine3A::from_translation(Vec3::new(5.0, 0.0, 0.0)),
            Affine3A::from_scale_rotation_translation(
                Vec3::new(-1.0, 2.0, 1.0),
                glam::Quat::from_rotation_x(0.4),
                Vec3::ZERO,
            ),
        ];
        for (index, place) in places.into_iter().enumerate() {
            scene.instances.push(Instance::fixed("lamp", 0, place));
            scene.add_area_light(index);
        }
        let exported = export(&scene);
        let document = roxmltree::Document::parse(&exported.text).unwrap();
        let is_flat = base == 0.0;
        for (index, place) in places.into_iter().enumerate() {
            let shape = by_id(document.root_element(), &format!("instance-{index}-lamp"));
            assert_eq!(elements(shape, "boolean").len(), usize::from(is_flat));
            assert_eq!(vector(value(only(shape, "emitter"), "radiance")), Vec3::ONE);
            // In world space, facing outwards, even for mirrored instances.
            assert_eq!(to_world(shape), glam::Mat4::IDENTITY);
            let ply = exported.mesh(shape);
            assert_eq!((ply.triangles.len(), ply.normals.is_empty()), (80, is_flat));
            for triangle in 0..ply.triangles.len() {
                let middle: Vec3 = ply.corners(triangle).iter().sum::<Vec3>() / 3.0;
                let out = middle - Vec3::from(place.translation);
                assert!(ply.front(triangle).dot(out) > 0.0);
                let outward = |&vertex: &u32| ply.normals[vertex as usize].dot(out) > 0.0;
                assert!(is_flat || ply.triangles[triangle].iter().all(outward));
            }
        }
        let named = exported.report.inexact.iter().any(|line| line.contains("follows their smooth normals"));
        assert_eq!(named, !is_flat);
    }
}

#[test]
fn meshes_that_are_there_more_than_once_are_groups() {
    let exported = export(&all_kinds());
    let document = roxmltree::Document::parse(&exported.text).unwrap();
    let root = document.root_element();
    for (mesh, instances) in [
        ("mesh-1-wedge", ["instance-1-wedge", "instance-2-mirrored_wedge"]),
        ("mesh-2-ball", ["instance-3-egg", "instance-4-thrown_ball"]),
    ] {
        let group = by_id(root, mesh);
        assert_eq!((kind(group), elements(group, "shape").len()), ("shapegroup", 1));
        assert!(exported.mesh(only(group, "shape")).triangles.len() >= 4);
        for id in instances {
            let instance = by_id(root, id);
            assert_eq!((kind(instance), only(instance, "ref").attribute("id")), ("instance", Some(mesh)));
        }
    }
    assert!(to_world(by_id(root, "instance-2-")).determinant() < 0.0);
}

#[test]
fn what_is_neither_seen_nor_shines_is_left_out() {
    let exported = export(&scene(
        r#"
        [[models]]
        name = "box"
        primitive = "box"
        [[instances]]
        model = "box"
        [[instances]]
        name = "hidden"
        model = "box"
        visible = false
        "#,
    ));
    let document = roxmltree::Document::parse(&exported.text).unwrap();
    assert_eq!(elements(document.root_element(), "shape").len(), 1);
    assert_eq!(exported.report.triangles, 12);
}

#[test]
fn small_and_smooth_scenes_are_remarked_upon() {
    let ball = |radius: f32| {
        export(&scene(&format!(
            "models = [{{ name = \"ball\", primitive = \"sphere\", size = [{radius}, {radius}, {radius}] }}]
            instances = [{{ model = \"ball\" }}]"
        )))
    };
    let says = |exported: &Exported, what| exported.report.inexact.iter().any(|line| line.contains(what));
    let (small, large) = (ball(0.02), ball(2.0));
    assert!(says(&small, "this small") && !says(&large, "this small"));
    assert!(says(&large, "flips that normal"));
    assert!(!says(&export(&load_scene("cornell-box", None).unwrap()), "normal"));
}
