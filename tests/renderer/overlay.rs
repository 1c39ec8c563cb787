//! Lines, points and light paths lie where they should.

use glam::{Affine3A, Vec2, Vec3};
use glowworm::estimators::vpls::{InvalidationReason, PathStyle, SlotState, VplDebugView, reason_colour};
use glowworm::output::Picture;
use glowworm::renderer::{DebugView, Line, Renderer};
use glowworm::scene::{Camera, Pose};
use glowworm::settings::{Settings, VplSettings};

use super::support::{GpuFixture, channel, scene, vpls};
use super::views::{STUDIO, settings, view};

const SIDE: usize = 64;

/// Pictures that differ by lines alone.
fn frozen() -> Settings {
    Settings { still_frames: 4, ..settings(1, 1) }
}

/// Where a world position lies in the picture, and its view depth; none outside.
fn project(camera: &Camera, point: Vec3) -> Option<(usize, usize, f32)> {
    let [ray, ray_x, ray_y] = camera.pixel_rays(1.0);
    let v = point - camera.eye;
    let depth = v.dot(ray);
    let at = Vec2::new(v.dot(ray_x) / ray_x.length_squared(), v.dot(ray_y) / ray_y.length_squared()) / depth;
    let pixel = (at * 0.5 + 0.5) * SIDE as f32;
    let inside = depth > camera.near && pixel.min_element() >= 0.0 && pixel.max_element() < SIDE as f32;
    inside.then_some((pixel.x as usize, pixel.y as usize, depth))
}

fn shown(renderer: &mut Renderer, pose: &Pose, view: &DebugView) -> Picture {
    renderer.set_view(view).unwrap();
    renderer.render(pose).unwrap();
    renderer.read_picture(true).unwrap()
}

fn rgb(picture: &Picture, x: usize, y: usize) -> [u8; 3] {
    let [r, g, b, _] = picture.display[y * SIDE + x];
    [r, g, b]
}

#[test]
#[ignore = "long; vpls_that_became_invalid_flash_with_their_reason is quicker"]
fn vpls_are_drawn_where_they_are() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(STUDIO);
    let pose = scene.pose(0.0);
    let mut renderer = gpu.rendered(&scene, &settings(4, 2), 4);
    let slots: Vec<_> = vpls(&renderer).slots().filter(|slot| slot.state == SlotState::Valid).collect();
    let (mut seen, mut hidden) = (0, 0);
    for slot in &slots {
        let Some((x, y, depth)) = project(&pose.camera, slot.position) else { continue };
        // Its own point comes last on its path.
        let look = VplDebugView {
            vpl_paths: Some(PathStyle::Bounce),
            single_vpl: Some(slot.slot),
            ..VplDebugView::default()
        };
        let paths = view("depth").with_options(&look);
        let plain = view("depth").with_options(&VplDebugView { vpl_paths: None, ..look });
        let plain = shown(&mut renderer, &pose, &plain);
        let drawn = shown(&mut renderer, &pose, &paths);
        let in_front = depth <= channel(&drawn, "depth")[y * SIDE + x] * 1.005;
        let behind = depth > channel(&drawn, "depth")[y * SIDE + x] * 1.02;
        let colour = if slot.bounce == 1 { [255, 140, 26] } else { [64, 166, 255] };
        if in_front {
            let off = rgb(&drawn, x, y).iter().zip(colour).map(|(a, b)| a.abs_diff(b)).max();
            assert!(off <= Some(2), "slot {}: {:?}", slot.slot, rgb(&drawn, x, y));
            seen += 1;
        } else if behind {
            assert_ne!(rgb(&drawn, x, y), colour);
            assert_ne!(rgb(&drawn, x, y), rgb(&plain, x, y), "dimmed, not dropped");
            hidden += 1;
        }
    }
    assert!(seen >= 5 && hidden >= 2, "{seen} seen, {hidden} hidden");
}

#[test]
#[ignore = "long; lines_that_begin_behind_the_eye_are_cut_off is quicker"]
fn lines_cover_what_lies_on_them_and_nothing_else() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(STUDIO);
    let pose = scene.pose(0.0);
    let mut renderer = gpu.rendered(&scene, &frozen(), 4);
    let plain = shown(&mut renderer, &pose, &DebugView::default());
    // Across the middle of the picture, before everything; and far behind the wall.
    let ahead = |depth: f32, x: f32| {
        let [ray, ray_x, _] = pose.camera.pixel_rays(1.0);
        pose.camera.eye + (ray + ray_x * x) * depth
    };
    for (depth, hidden, colour) in
        [(0.5, 1.0, Some([0u8, 255, 0])), (50.0, 0.0, None), (50.0, 1.0, Some([0, 255, 0]))]
    {
        let (from, to) = (ahead(depth, -0.5), ahead(depth, 0.5));
        let line = Line { from, to, colour: [0.0, 1.0, 0.0, 1.0], width: 4.0, hidden };
        let drawn = shown(&mut renderer, &pose, &DebugView { lines: vec![line], ..DebugView::default() });
        for y in 0..SIDE {
            for x in 0..SIDE {
                let on = (18..46).contains(&x) && (31..33).contains(&y);
                let off = !(12..52).contains(&x) || !(28..36).contains(&y);
                match colour {
                    Some(colour) if on => assert_eq!(rgb(&drawn, x, y), colour, "{x}, {y}"),
                    Some(_) if !off => {}
                    _ => assert_eq!(rgb(&drawn, x, y), rgb(&plain, x, y), "{x}, {y}"),
                }
            }
        }
    }
}

#[test]
fn lines_that_begin_behind_the_eye_are_cut_off() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(STUDIO);
    let pose = scene.pose(0.0);
    let mut renderer = gpu.rendered(&scene, &frozen(), 4);
    let plain = shown(&mut renderer, &pose, &DebugView::default());
    let [ray, ray_x, ray_y] = pose.camera.pixel_rays(1.0);
    let colour = [1.0, 0.0, 1.0, 1.0];
    let changed = |from: Vec3, to: Vec3, renderer: &mut Renderer| {
        let line = Line { from, to, colour, width: 2.0, hidden: 1.0 };
        let drawn = shown(renderer, &pose, &DebugView { lines: vec![line], ..DebugView::default() });
        let pixels = drawn.display.iter().zip(&plain.display);
        pixels
            .enumerate()
            .filter(|(_, (a, b))| a != b)
            .map(|(at, _)| (at % SIDE, at / SIDE))
            .collect::<Vec<_>>()
    };
    let eye = pose.camera.eye;
    assert!(changed(eye - ray, eye - ray * 2.0 + ray_x, &mut renderer).is_empty(), "all of it is behind");
    // From behind, past the right side of the eye, to a place right of the middle: never left of that.
    let end = eye + (ray + ray_x * 0.25) * 1.0;
    let pixels = changed(eye - ray + (ray_x + ray_y) * 0.5, end, &mut renderer);
    assert!(pixels.len() > 10, "{}", pixels.len());
    assert!(pixels.iter().all(|(x, _)| *x >= 36), "{pixels:?}");
}

#[test]
fn vpls_that_became_invalid_flash_with_their_reason() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(STUDIO);
    let mut pose = scene.pose(0.0);
    let mut renderer = gpu.rendered(
        &scene,
        &Settings { vpl: VplSettings { budget: 1, ..settings(4, 2).vpl }, ..settings(4, 2) },
        4,
    );
    // The block comes between the light and the wall behind it.
    pose.instances[1] = Affine3A::from_translation(Vec3::new(-1.0, 1.6, -0.6)) * pose.instances[1];
    let look = VplDebugView { vpl_paths: Some(PathStyle::Bounce), ..VplDebugView::default() };
    let paths = view("depth").with_options(&look);
    let drawn = shown(&mut renderer, &pose, &paths);
    let depths = channel(&drawn, "depth");
    let (mut flashing, mut in_front) = (0, 0);
    for slot in vpls(&renderer).slots() {
        let last = vpls(&renderer).history(slot.slot).and_then(|history| history.invalidation);
        let Some(last) = last else { continue };
        assert_eq!(last.frame, vpls(&renderer).frame());
        let Some((x, y, depth)) = project(&pose.camera, last.position) else { continue };
        if depth > depths[y * SIDE + x] * 1.005 {
            continue;
        }
        in_front += 1;
        // In so small a picture they lie on top of one another.
        let shows = |reason| {
            let colour = reason_colour(reason).map(|value| (value * 255.0) as u8);
            rgb(&drawn, x, y).iter().zip(colour).all(|(a, b)| a.abs_diff(b) <= 2)
        };
        flashing += u32::from(InvalidationReason::ALL.into_iter().any(shows));
    }
    assert!(in_front >= 5 && 3 * flashing >= 2 * in_front, "{flashing} of {in_front} flash");

    // A second later nothing is left of them.
    for _ in 0..30 {
        renderer.render(&pose).unwrap();
    }
    let later = shown(&mut renderer, &pose, &paths);
    let is_red =
        |pixel: &&[u8; 4]| pixel[0] == 255 && pixel[1..3].iter().all(|value| (25..27).contains(value));
    let red = |picture: &Picture| picture.display.iter().filter(is_red).count();
    assert!(red(&drawn) > 0 && red(&later) == 0, "{} and {}", red(&drawn), red(&later));
}
