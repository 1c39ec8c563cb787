//! Shadows of direct light where they are easily lost: walls without thickness, light that grazes a wall under cornices.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::{Vec2, Vec3};
use glowworm::output::Picture;
use glowworm::scene::Scene;
use glowworm::settings::{Indirect, Settings};

use super::rooms::{SUN, SUN_IRRADIANCE, WINDOW, cornices, thin_room};
use super::support::golden::reference;
use super::support::{GpuFixture, assets, channel, layer, luminance, mean, named_scene, plain};

const SQUARE: [u32; 2] = [256; 2];

/// A picture whose pixels are true or false.
struct Mask {
    size: [usize; 2],
    pixels: Vec<bool>,
}

impl Mask {
    /// Whether all pixels at most `reach` away are the same as this one; those outside of the picture count as the same.
    fn is_even(&self, at: usize, reach: usize) -> bool {
        let (x, y) = (at % self.size[0], at / self.size[0]);
        let near = |at: usize, side: usize| at.saturating_sub(reach)..(at + reach + 1).min(side);
        near(y, self.size[1])
            .all(|y| near(x, self.size[0]).all(|x| self.pixels[y * self.size[0] + x] == self.pixels[at]))
    }

    /// How many true pixels lie in the middle of 3x3 true ones: none where nothing is wider than two pixels.
    fn wide(&self) -> usize {
        let [width, height] = self.size;
        let inner = (1..height - 1).flat_map(|y| (1..width - 1).map(move |x| y * width + x));
        inner.filter(|at| self.pixels[*at] && self.is_even(*at, 1)).count()
    }
}

fn drawn(gpu: &GpuFixture, scene: &Arc<Scene>, size: [u32; 2]) -> Picture {
    let settings = Settings { size, indirect: Indirect::NONE, ..plain() };
    gpu.rendered(scene, &settings, 1).read_picture(true).unwrap()
}

/// Radiance of the sun at a point inside the room: all or nothing, by where the ray leaves the room.
fn through_the_window(position: Vec3, normal: Vec3) -> f32 {
    let to_sun = -SUN.normalize();
    let cosine = normal.dot(to_sun);
    let at = position + to_sun * ((2.0 - position.x) / to_sun.x);
    let at = Vec2::new(at.y, at.z);
    let [low, high] = WINDOW.map(Vec2::from);
    let is_lit = cosine > 0.0 && at.cmpgt(low).all() && at.cmplt(high).all();
    if is_lit { SUN_IRRADIANCE * cosine * 0.6 / PI } else { 0.0 }
}

fn check_thin_room(apart: bool, eye: [f32; 3], target: [f32; 3]) {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = thin_room(apart, eye, target);
    const SIZE: [u32; 2] = [320, 240];
    let (ours, reference) = (drawn(&gpu, &scene, SIZE), reference("thin-room", &scene, SIZE, 0, 1));
    for (picture, what) in [(reference, "reference"), (ours, "renderer")] {
        let places = layer(&picture, "position").into_iter().zip(layer(&picture, "normal"));
        let expected: Vec<f32> =
            places.map(|(position, normal)| through_the_window(position.into(), normal.into())).collect();
        let is_inside: Vec<bool> =
            channel(&picture, "instance").iter().map(|instance| *instance >= 0.0).collect();
        let patch = Mask {
            size: SIZE.map(|side| side as usize),
            pixels: expected.iter().map(|light| *light > 0.0).collect(),
        };
        let direct = layer(&picture, "direct");
        let (mut leaks, mut brightest, mut lost, mut lit) = (0, 0.0f32, 0, 0);
        for at in (0..expected.len()).filter(|at| is_inside[*at] && patch.is_even(*at, 2)) {
            let found = luminance(&direct[at]);
            if expected[at] == 0.0 && found != 0.0 {
                leaks += 1;
                brightest = brightest.max(found);
            }
            lit += u32::from(expected[at] > 0.0);
            lost += u32::from(expected[at] > 0.0 && (found / expected[at] - 1.0).abs() > 0.02);
        }
        let said = format!(
            "{what}: the sun leaks into {leaks} pixels, of {brightest} at most; {lost} of {lit} pixels of the patch are wrong"
        );
        eprintln!("{said}");
        assert!(is_inside.iter().filter(|inside| **inside).count() > 60_000);
        assert!(leaks == 0 && lost == 0, "{said}");
    }
}

/// The floor with the patch of sunlight.
const DOWN: [[f32; 3]; 2] = [[1.6, 1.9, 1.6], [-1.4, 0.2, -1.0]];
/// The corner of ceiling, window's wall and another one.
const UP: [[f32; 3]; 2] = [[-1.5, 0.6, -1.2], [1.5, 1.9, 1.0]];

#[test]
fn no_sun_leaks_into_a_room_of_one_mesh() {
    for [eye, target] in [DOWN, UP] {
        check_thin_room(false, eye, target);
    }
}

#[test]
fn no_sun_leaks_between_meshes_that_only_meet() {
    for [eye, target] in [DOWN, UP] {
        check_thin_room(true, eye, target);
    }
}

/// Direct light, luminance, by the renderer and by the path tracer.
fn direct(scene: &Arc<Scene>) -> Option<[Vec<f32>; 2]> {
    let gpu = GpuFixture::open()?;
    // One sample is exact: there is one light, and it is a point.
    let pictures = [drawn(&gpu, scene, SQUARE), reference("square", scene, SQUARE, 0, 1)];
    Some(pictures.map(|picture| layer(&picture, "direct").iter().map(luminance).collect()))
}

/// The mean must be within half a percent of the path tracer's.
fn check_mean(scene: &Arc<Scene>) {
    let Some([ours, reference]) = direct(scene) else { return };
    let ratio = mean(ours) / mean(reference);
    eprintln!("the mean is {ratio:.5} of the reference's");
    assert!((ratio - 1.0).abs() <= 0.005, "the mean is {ratio} of the reference's");
}

#[test]
fn cornices_cast_all_their_shadows() {
    check_mean(&cornices());
}

#[test]
fn shadows_of_cornices_are_wrong_at_their_edges_only() {
    let Some([ours, reference]) = direct(&cornices()) else { return };
    let average = mean(reference.iter().copied());
    let is_wrong =
        |(ours, reference): (&f32, &f32)| (ours - reference).abs() > 0.05 * reference + 0.01 * average;
    let pixels: Vec<bool> = ours.iter().zip(&reference).map(is_wrong).collect();
    let wrong = Mask { size: SQUARE.map(|side| side as usize), pixels };
    let (count, wide) = (wrong.pixels.iter().filter(|wrong| **wrong).count(), wrong.wide());
    eprintln!("{count} wrong pixels, {wide} in the middle of 3x3 wrong ones");
    assert_eq!(wide, 0, "of {count} wrong pixels, so many are in the middle of 3x3 wrong ones");
}

#[test]
fn sponza_is_lit_as_in_the_reference() {
    let Some(assets) = assets() else { return };
    check_mean(&named_scene("sponza", Some(&assets)));
}
