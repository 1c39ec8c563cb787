//! Portals, and visible area lights beside them.

use crate::support::*;

#[test]
fn light_passes_through_portals() {
    let exported = export(&all_kinds());
    let document = roxmltree::Document::parse(&exported.text).unwrap();
    let root = document.root_element();
    let integrator = only(root, "integrator");
    assert_eq!((kind(integrator), value(integrator, "hide_emitters")), ("volpath", "true"));
    let sky = by_id(root, "instance-6-sky");
    assert_eq!(kind(only(sky, "bsdf")), "null");
    assert_eq!(kind(only(sky, "emitter")), "area");
    // It emits into the room.
    let ply = exported.mesh(sky);
    assert!((0..2).all(|triangle| ply.front(triangle).x > 0.999));
}

#[test]
fn emitters_beside_portals_have_a_copy_for_the_camera() {
    let exported = export(&all_kinds());
    let document = roxmltree::Document::parse(&exported.text).unwrap();
    let shapes: Vec<_> = elements(document.root_element(), "shape")
        .into_iter()
        .filter(|shape| shape.attribute("id").unwrap().starts_with("instance-5-lamp"))
        .collect();
    let [shape, pane, copy] = shapes[..] else { panic!("{} shapes", shapes.len()) };
    assert!(elements(shape, "emitter").len() == 1 && elements(pane, "emitter").is_empty());
    assert_eq!(value(only(copy, "emitter"), "sampling_weight"), "0.0");
    let glass = only(pane, "bsdf");
    assert_eq!((value(glass, "int_ior"), value(glass, "ext_ior")), ("1.0", "1.0"));

    // Each is behind the one before it, by more than Mitsuba's ray offset.
    let meshes = [shape, pane, copy].map(|shape| exported.mesh(shape));
    for pair in meshes.windows(2) {
        for triangle in 0..2 {
            let front = pair[0].front(triangle);
            for (near, far) in pair[0].corners(triangle).into_iter().zip(pair[1].corners(triangle)) {
                let step = (near - far).dot(front);
                let reach = pair[0].positions.iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
                assert!(step > 1.5e-4 * (1.0 + reach) && step < 3e-4 * (1.0 + reach), "{step}");
            }
        }
    }
}

#[test]
fn without_portals_there_are_no_copies() {
    let mut scene = all_kinds();
    for instance in &mut scene.instances {
        instance.visible = true;
    }
    let exported = export(&scene);
    assert!(!exported.text.contains("hide_emitters") && !exported.text.contains("dielectric"));
    // The masked lattice also needs volpath.
    assert_eq!(exported.report.integrator, "volpath");
}
