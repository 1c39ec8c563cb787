//! A session in which everything is used once.

use std::time::Duration;

use crate::ONE_AT_A_TIME;
use crate::desk::{Demo, Desk, Screen, is_action};

/// Small enough for a CPU driver with validation.
const SMALL: [&str; 7] =
    ["--size", "640x360", "--vpls=64", "--temporal-sets=4", "--bounces=2", "--seed=1", "--validate"];
/// Frames after which a still picture stands still.
const SETTLED: u64 = 12;

#[test]
fn a_session_from_start_to_end() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(desk) = Desk::open() else { return };
    let mut demo = Demo::start(&desk, &SMALL);

    // It opens on the built-in scene, which moves.
    let scene = demo.wait("scene", |event| event["event"] == "scene");
    assert_eq!(scene["details"]["name"], "playroom");
    demo.frames(6);
    let first = demo.screen();
    first.keep("1-start");
    assert_eq!((first.width, first.height), (640, 360));
    assert!(first.picture().colours() > 2000, "{} colours", first.picture().colours());
    demo.frames(10);
    assert!(demo.screen().picture().difference(&first.picture()) > 0.5, "nothing moves");
    assert_vpls_are_replaced(&demo);

    // It stands still when paused.
    demo.key_for("space", "toggle-pause");
    demo.frames(SETTLED);
    let still = demo.screen().picture();
    demo.frames(3);
    assert!(demo.screen().picture() == still, "a paused scene does not stand still");

    dragging_a_light_changes_the_indirect_light(&mut demo);
    each_view_shows_something_of_its_own(&mut demo);
    paths_and_single_vpls(&mut demo);
    a_preset_takes_effect(&mut demo);
    sizes_and_hiding(&mut demo);

    // A screenshot is what the screen shows.
    demo.key_for("Tab", "toggle-panel");
    demo.frames(SETTLED);
    let screen = demo.screen();
    let seen = demo.now();
    demo.key_for("F12", "screenshot");
    let saved = demo.wait_after(seen, "screenshot", |event| event["event"] == "saved");
    let picture = image::open(demo.path(saved["details"].as_str().unwrap())).unwrap().to_rgb8();
    assert_eq!(picture.dimensions(), (640, 360));
    assert!(picture.pixels().map(|pixel| pixel.0).eq(screen.pixels.iter().copied()), "another picture");
    demo.close();
}

/// The board turns, so VPLs become invalid and others are shot, in nearly every frame.
fn assert_vpls_are_replaced(demo: &Demo<'_>) {
    let frames: Vec<_> = demo.events().into_iter().filter(|event| event["event"] == "frame").collect();
    let count = |key: &str| -> u64 {
        frames.iter().filter_map(|frame| frame["measured"]["vpls"][key].as_u64()).sum()
    };
    let (invalidated, shot) = (count("invalidated"), count("shot"));
    assert!(invalidated > 0 && shot > 0, "{invalidated} invalidated, {shot} shot");
}

fn dragging_a_light_changes_the_indirect_light(demo: &mut Demo<'_>) {
    demo.click_thing("Scene");
    demo.click_thing("Lights and things");
    let seen = demo.now();
    demo.click_thing("add point");
    demo.wait_after(seen, "new light", |event| is_action(event, "add-light"));
    // Indirect light alone.
    demo.key_for("v", "step-buffer");
    demo.key_for("v", "step-buffer");
    demo.frames(SETTLED);
    let before = demo.screen();
    before.keep("2-light");
    // Along its arrow to the right, which stands in the middle of the window, and to the left.
    let seen = demo.now();
    demo.drag([355, 180], [180, 180]);
    demo.wait_after(seen, "moved light", |event| is_action(event, "edit-light"));
    demo.frames(SETTLED);
    let after = demo.screen();
    after.keep("3-light-dragged");
    let difference = after.picture().difference(&before.picture());
    assert!(difference > 2.0, "indirect light has changed by {difference} only");
    for _ in 0..2 {
        demo.key_for("shift+v", "step-buffer");
    }
    let seen = demo.now();
    demo.xdotool(&["key", "Delete"]);
    demo.wait_after(seen, "deletion", |event| is_action(event, "delete"));
}

fn each_view_shows_something_of_its_own(demo: &mut Demo<'_>) {
    demo.frames(SETTLED);
    let combined = demo.screen().picture();
    let mut seen = vec![combined.clone()];
    for view in 1..21 {
        demo.key_for("v", "step-buffer");
        demo.frames(2);
        let screen = demo.screen();
        screen.keep(&format!("4-view-{view:02}"));
        let picture = screen.picture();
        if view == 6 && picture == seen[5] {
            seen[5] = the_set_of_another_frame(demo, &picture);
        }
        // Nothing moves, so a set buffer is the same after its reprojection.
        let alike = |(other, known): (usize, &Screen)| *known == picture && (other, view) != (6, 7);
        assert!(!seen.iter().enumerate().any(alike), "view {view} looks like another one");
        // No VPL is chosen whose visibility could be seen.
        let brightness: f64 = picture.mean().iter().sum();
        assert!(brightness > 3.0 || picture.colours() > 1 || view == 9, "view {view} is black");
        seen.push(picture);
    }
    // Depth is grey, albedo has the red of the wall at the left.
    let depth = &seen[12];
    assert!(depth.pixels.iter().filter(|[r, g, b]| r == g && g == b).count() > depth.pixels.len() * 9 / 10);
    let albedo = seen[15].pixels[(100 * seen[15].width + 20) as usize];
    assert!(albedo[0] > albedo[1] + 60, "{albedo:?}");
    demo.key_for("v", "step-buffer");
    demo.frames(2);
    assert!(demo.screen().picture() == combined, "the picture has not come back");
}

/// One frame in four draws the very set whose buffer the next view shows: waits for another.
fn the_set_of_another_frame(demo: &mut Demo<'_>, buffer: &Screen) -> Screen {
    demo.key_for("shift+v", "step-buffer");
    demo.frames(1);
    let mut filtered = demo.screen().picture();
    for _ in 0..20 {
        if filtered != *buffer {
            break;
        }
        demo.frames(1);
        filtered = demo.screen().picture();
    }
    demo.key_for("v", "step-buffer");
    filtered
}

fn paths_and_single_vpls(demo: &mut Demo<'_>) {
    let plain = demo.screen().picture();
    demo.key_for("p", "toggle-paths");
    demo.frames(2);
    let paths = demo.screen();
    paths.keep("5-paths");
    assert!(paths.picture().difference(&plain) > 1.0, "no paths are drawn");
    demo.key_for("period", "step-vpl");
    demo.frames(2);
    let single = demo.screen();
    single.keep("6-single-vpl");
    assert!(single.picture().difference(&paths.picture()) > 1.0);
    demo.key_for("slash", "all-vpls");
    demo.key_for("p", "toggle-paths");
    demo.frames(2);
    assert!(demo.screen().picture() == plain, "paths leave something behind");
}

fn a_preset_takes_effect(demo: &mut Demo<'_>) {
    // Close one section, so that the other is in view.
    demo.click_thing("Lights and things");
    demo.click_thing("Settings");
    assert_eq!(demo.last_frame()["measured"]["vpls"]["slots"], 64);
    let seen = demo.now();
    demo.click_thing("draft");
    demo.wait_after(seen, "settings", |event| is_action(event, "set"));
    demo.frames(6);
    assert_eq!(demo.last_frame()["measured"]["vpls"]["slots"], 128);
    demo.screen().keep("7-settings");
}

fn sizes_and_hiding(demo: &mut Demo<'_>) {
    for size in [[1024, 700], [640, 360]] {
        let seen = demo.now();
        demo.resize(size[0], size[1]);
        demo.wait_after(seen, "size", |event| event["details"]["set"]["size"] == serde_json::json!(size));
        demo.frames(4);
        let screen = demo.screen();
        screen.keep(&format!("8-{}", size[0]));
        assert_eq!([screen.width, screen.height], size);
        assert!(screen.picture().colours() > 2000, "{}", screen.picture().colours());
    }
    let seen = demo.now();
    demo.minimise();
    demo.wait_after(seen, "hiding", |event| event["event"] == "hidden");
    let frame = demo.last_frame();
    std::thread::sleep(Duration::from_secs(1));
    assert_eq!(demo.last_frame(), frame, "a hidden window draws");
    demo.restore();
    demo.wait_after(seen, "coming back", |event| event["event"] == "seen");
    // The window manager maps the window when it likes; frames may be faster.
    let is_back = |demo: &mut Demo<'_>| {
        demo.frames(4);
        demo.screen().picture().colours() > 2000
    };
    assert!((0..10).any(|_| is_back(demo)), "the window does not come back");
}
