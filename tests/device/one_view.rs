//! `render`, on the device, and `reference`, on the CPU, see the same view.

use std::path::Path;

use glam::Vec3;
use glowworm::output::Picture;

use crate::program::{Run, stderr};
use crate::support::layer;

/// A view other than the Cornell box's default.
const VIEW: [&str; 5] = ["--eye", "0.45,0.4,-0.5", "--target=0.1,0.15,0.3", "--vfov", "70"];

/// Positions of the visible surfaces.
fn positions(run: &Run, name: &str) -> Vec<Vec3> {
    let picture = Picture::read_exr(Path::new(&run.path(name))).unwrap();
    layer(&picture, "position").into_iter().map(Vec3::from).collect()
}

#[test]
fn every_command_sees_the_same_view() {
    let run = Run::new();
    let size = ["--size", "24x16"];
    for (name, view) in [("view", &VIEW[..]), ("own", &[])] {
        let [render, reference] = ["render", "reference"].map(|command| format!("{name}-{command}.exr"));
        let output = ["--out", &render, "--layers", "--antialiasing=none"];
        let output = run.render("cornell-box", &[&size[..], view, &output].concat());
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let command = ["reference", "cornell-box", "--spp", "1", "--pixel-filter", "center", "--layers"];
        let output = run.glowworm(&[&command[..], &size, view, &["--out", &reference]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let (drawn, traced) = (positions(&run, &render), positions(&run, &reference));
        let same = drawn.iter().zip(&traced).filter(|(a, b)| a.distance(**b) < 1e-4).count();
        // At an edge one of the two may hit another surface.
        assert!(same * 100 >= drawn.len() * 97, "{name}: {same} of {}", drawn.len());
    }
    let (own, view) = (positions(&run, "own-reference.exr"), positions(&run, "view-reference.exr"));
    let both: Vec<_> =
        own.iter().zip(&view).filter(|(a, b)| **a != Vec3::ZERO && **b != Vec3::ZERO).collect();
    assert!(both.iter().filter(|(a, b)| a.distance(**b) < 1e-2).count() * 10 < both.len());
}
