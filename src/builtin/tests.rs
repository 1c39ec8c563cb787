//! Checks every model made by code: solids closed and outside out, normals, no faces that lie on each other.

use super::*;

/// Materials of open surfaces without thickness: cloth and leaves.
const OPEN: [&str; 5] = ["red cloth", "green cloth", "blue cloth", "leaf", "ivy"];

/// Models of solids and open surfaces.
const MADE: [&str; 5] = ["atrium", "atrium-drapery", "cathedral", "meeting-room", "two-coloured torus"];

fn pieces(name: &str) -> (Part, Vec<Material>) {
    let mut palette = Palette::default();
    let part = assemble(name, &mut palette).expect("the model has a name");
    (part, palette.finish().materials)
}

#[test]
fn solids_are_closed_and_the_rest_is_open() {
    for name in MADE {
        let (part, materials) = pieces(name);
        for (i, piece) in part.pieces.iter().enumerate() {
            let material = &materials[piece.triangle_materials[0] as usize].name;
            let check = if OPEN.contains(&material.as_str()) { checks::open_surface } else { checks::solid };
            let checked = check(piece).and_then(|()| checks::surface(piece));
            assert!(
                checked.is_ok(),
                "{name}, piece {i} of {material}, first at {}: {checked:?}",
                piece.positions[0]
            );
        }
    }
}

#[test]
fn no_two_faces_lie_on_each_other() {
    for name in MADE {
        let found = checks::overlaps(&pieces(name).0.pieces);
        assert!(
            found.is_empty(),
            "{name}: {} overlaps, such as\n{}",
            found.len(),
            found[..found.len().min(25)].join("\n")
        );
    }
}

#[test]
fn models_are_the_same_every_time() {
    for name in MADE {
        let [first, second] = [model(name), model(name)].map(|model| model.expect("the model has a name"));
        assert!(first.mesh == second.mesh && first.materials == second.materials, "{name}");
        assert!(first.textures == second.textures && first.alpha_masks == second.alpha_masks, "{name}");
    }
}
