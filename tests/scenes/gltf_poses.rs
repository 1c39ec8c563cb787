//! What nodes of glTF files pose: morph targets, skins, instances, mirrors.

use glam::{Mat4, Quat};
use serde_json::{Value, json};

use super::gltf_files::{add_accessor, buffer, document, glb, load_glb};
use super::gltf_structure::{Change, TRIANGLE, assert_corners, at, corners};
use super::*;

/// Adds a skin of `joints`, with inverse bind matrices, that moves each vertex by its own pair of joints and weights.
fn add_skin(
    d: &mut Value,
    b: &mut Vec<u8>,
    joints: &[usize],
    inverse: &[Mat4],
    vertices: [([f32; 4], [f32; 4]); 3],
) {
    let matrices: Vec<f32> = inverse.iter().flat_map(Mat4::to_cols_array).collect();
    let matrices = add_accessor(d, b, &matrices, "MAT4", inverse.len());
    let indices = add_accessor(d, b, &vertices.map(|vertex| vertex.0).concat(), "VEC4", 3);
    let weights = add_accessor(d, b, &vertices.map(|vertex| vertex.1).concat(), "VEC4", 3);
    d["skins"] = json!([{ "joints": joints, "inverseBindMatrices": matrices }]);
    let attributes = &mut d["meshes"][0]["primitives"][0]["attributes"];
    (attributes["JOINTS_0"], attributes["WEIGHTS_0"]) = (json!(indices), json!(weights));
}

/// The first joint alone.
const FIRST: ([f32; 4], [f32; 4]) = ([0.0; 4], [1.0, 0.0, 0.0, 0.0]);

fn add_target(d: &mut Value, b: &mut Vec<u8>, deltas: [f32; 9]) {
    let target = add_accessor(d, b, &deltas, "VEC3", 3);
    d["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": target }, {}]);
}

const LIFT: [f32; 9] = [0.0, 0.0, 2.0, 0.0, 0.0, 2.0, 0.0, 0.0, 4.0];

/// What a file poses, and the corners of its triangles.
type Posed<'a> = (&'a str, Change, Vec<Vec3>);

fn check_posed(table: &[Posed]) {
    for (what, change, expected) in table {
        let (mut document, mut bytes) = (document(), buffer());
        change(&mut document, &mut bytes);
        let scene = load_glb(&document, &bytes);
        check_consistency(&scene);
        assert_corners(what, &scene, 0.0, expected);
        assert!(scene.warnings.iter().all(|warning| !warning.contains("not shown")), "{:?}", scene.warnings);
        for (instance, transform) in scene.instances.iter().zip(&scene.pose(0.0).instances) {
            assert!(transform.inverse().is_finite(), "{what}");
            let mesh = &scene.meshes[instance.mesh];
            let [a, b, c] = mesh.triangle_positions(0);
            let facet = (b - a).cross(c - a).normalize();
            assert!(
                mesh.normals[mesh.triangles[0][0] as usize].distance(facet) < 1e-3,
                "{what}: flat shading"
            );
        }
        // As a model of a scene file it stands there, too.
        let text = "[[models]]\nname = 'm'\npath = 'm.glb'\n[[instances]]\nmodel = 'm'\n[camera]\neye = [0, 0, 9]\n\
                    target = [0, 0, 0]\n[[lights]]\ntype = 'point'\nposition = [0, 0, 9]\nintensity = [1, 1, 1]\n";
        let folder = Folder::new().with("m.glb", glb(&document, &bytes)).with("s.toml", text);
        let model = folder.load("s.toml").unwrap();
        assert_eq!(corners(&model, 0.0).len(), expected.len(), "{what}");
    }
}

#[test]
fn targets_and_skins_pose_meshes_at_rest() {
    let lifted = [Vec3::Z, Vec3::X + Vec3::Z, Vec3::Y + 2.0 * Vec3::Z];
    check_posed(&[
        (
            "weights of a mesh",
            |d, b| (add_target(d, b, LIFT), d["meshes"][0]["weights"] = json!([0.5, 1])).1,
            lifted.to_vec(),
        ),
        (
            "weights of a node, in place of the mesh's",
            |d, b| {
                add_target(d, b, LIFT);
                d["meshes"][0]["weights"] = json!([7]);
                d["nodes"] = json!([{ "mesh": 0, "weights": [0.5] }, { "mesh": 0, "weights": [0] }]);
                d["scenes"][0]["nodes"] = json!([0, 1]);
            },
            [lifted, TRIANGLE].concat(),
        ),
        (
            "a skin, whatever its node's transform",
            |d, b| {
                add_skin(d, b, &[1], &[Mat4::from_translation(Vec3::NEG_Y)], [FIRST; 3]);
                d["nodes"] = json!([
                    { "mesh": 0, "skin": 0, "translation": [9, 9, 9] },
                    { "translation": [5, 1, 0] }
                ]);
                d["scenes"][0]["nodes"] = json!([0, 1]);
            },
            at(Vec3::X * 5.0).to_vec(),
        ),
        (
            "a skin below its own joint, of two joints each below the other",
            |d, b| {
                let half = ([0.0, 1.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0]);
                let second = ([1.0, 0.0, 0.0, 0.0], [0.5, 0.0, 0.0, 0.0]);
                add_skin(d, b, &[0, 1], &[Mat4::IDENTITY; 2], [FIRST, half, second]);
                d["nodes"] = json!([
                    { "children": [1], "translation": [2, 0, 0] },
                    { "children": [2], "translation": [0, 0, 4] },
                    { "mesh": 0, "skin": 0 }
                ]);
            },
            vec![Vec3::X * 2.0, Vec3::new(3.0, 0.0, 2.0), Vec3::new(2.0, 1.0, 4.0)],
        ),
        (
            "morphed, then skinned, by a mirroring joint",
            |d, b| {
                add_target(d, b, LIFT);
                d["meshes"][0]["weights"] = json!([0.5]);
                add_skin(d, b, &[1], &[Mat4::IDENTITY], [FIRST; 3]);
                d["nodes"] = json!([{ "mesh": 0, "skin": 0 }, { "scale": [-1, 1, 1] }]);
            },
            vec![Vec3::Z, Vec3::Y + 2.0 * Vec3::Z, Vec3::NEG_X + Vec3::Z],
        ),
    ]);
}

/// As in the sample assets MorphPrimitivesTest and RecursiveSkeletons.
#[test]
fn several_primitives_and_skeletons_are_posed_together() {
    let lifted = [Vec3::Z, Vec3::X + Vec3::Z, Vec3::Y + 2.0 * Vec3::Z];
    check_posed(&[
        (
            "each primitive of a mesh by its own targets",
            |d, b| {
                add_target(d, b, LIFT);
                let lifted = d["meshes"][0]["primitives"][0].clone();
                add_target(d, b, [0.0; 9]);
                d["meshes"][0]["primitives"].as_array_mut().unwrap().push(lifted);
                d["meshes"][0]["weights"] = json!([0.5, 1]);
            },
            [TRIANGLE, lifted].concat(),
        ),
        (
            "skeletons below what other skeletons move",
            |d, b| {
                add_skin(d, b, &[0], &[Mat4::IDENTITY], [FIRST; 3]);
                let mut other = d["skins"][0].clone();
                other["joints"] = json!([2]);
                d["skins"].as_array_mut().unwrap().push(other);
                d["nodes"] = json!([
                    { "children": [1], "translation": [2, 0, 0] },
                    { "children": [2], "translation": [9, 9, 9], "mesh": 0, "skin": 0 },
                    { "children": [3], "translation": [0, 3, 0] },
                    { "mesh": 0, "skin": 1, "translation": [7, 7, 7] }
                ]);
            },
            [at(Vec3::X * 2.0), at(Vec3::new(11.0, 12.0, 9.0))].concat(),
        ),
    ]);
}

#[test]
fn instances_are_placed_hidden_flat_and_mirrored() {
    check_posed(&[
        (
            "instances of a mesh",
            |d, b| {
                let places = add_accessor(d, b, &[0.0, 0.0, 1.0, 0.0, 0.0, 2.0], "VEC3", 2);
                let scales = add_accessor(d, b, &[1.0, 1.0, 1.0, 2.0, 2.0, 2.0], "VEC3", 2);
                let turn = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2).to_array();
                let turns = add_accessor(d, b, &[[0.0, 0.0, 0.0, 1.0], turn].concat(), "VEC4", 2);
                let attributes = json!({ "TRANSLATION": places, "SCALE": scales, "ROTATION": turns });
                d["nodes"][0]["extensions"] =
                    json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
                d["nodes"][0]["translation"] = json!([5, 0, 0]);
                d["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
            },
            [
                at(Vec3::new(5.0, 0.0, 1.0)),
                [Vec3::new(5.0, 0.0, 2.0), Vec3::new(5.0, 2.0, 2.0), Vec3::new(3.0, 0.0, 2.0)],
            ]
            .concat(),
        ),
        (
            "hidden with all below",
            |d, _| {
                let hidden = json!({ "KHR_node_visibility": { "visible": false } });
                let shown = json!({ "KHR_node_visibility": { "visible": true } });
                d["nodes"] = json!([
                    { "mesh": 0, "extensions": hidden, "children": [1] }, { "mesh": 0, "extensions": shown },
                    { "mesh": 0, "extensions": shown, "translation": [1, 0, 0] }
                ]);
                d["scenes"][0]["nodes"] = json!([0, 2]);
                d["extensionsRequired"] = json!(["KHR_node_visibility"]);
            },
            at(Vec3::X).to_vec(),
        ),
        ("flat", |d, _| d["nodes"][0]["scale"] = json!([2, 1, 0]), vec![Vec3::ZERO, Vec3::X * 2.0, Vec3::Y]),
        (
            "a mirror in a mirror",
            |d, _| {
                d["nodes"] =
                    json!([{ "children": [1], "scale": [-1, 1, 1] }, { "mesh": 0, "scale": [-3, 1, 1] }]);
            },
            vec![Vec3::ZERO, Vec3::X * 3.0, Vec3::Y],
        ),
    ]);
}

#[test]
fn normals_follow_joints_and_targets() {
    let turn = Quat::from_rotation_y(1.0);
    for skinned in [false, true] {
        let (mut d, mut b) = (document(), buffer());
        let up = add_accessor(&mut d, &mut b, &[0.0, 0.0, 1.0].repeat(3), "VEC3", 3);
        d["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(up);
        if skinned {
            add_skin(&mut d, &mut b, &[1], &[Mat4::IDENTITY], [FIRST; 3]);
            d["nodes"] =
                json!([{ "mesh": 0, "skin": 0 }, { "rotation": turn.to_array(), "scale": [3, 3, 3] }]);
        } else {
            let change = (turn * Vec3::Z - Vec3::Z).to_array();
            let target = add_accessor(&mut d, &mut b, &change.repeat(3), "VEC3", 3);
            d["meshes"][0]["primitives"][0]["targets"] = json!([{ "NORMAL": target }]);
            d["meshes"][0]["weights"] = json!([1]);
        }
        let mesh = &load_glb(&d, &b).meshes[0];
        assert!(
            mesh.normals.iter().all(|normal| normal.distance(turn * Vec3::Z) < 1e-5),
            "{:?}",
            mesh.normals
        );
    }
}
