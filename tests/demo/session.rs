//! A session that uses every feature once.

use crate::ONE_AT_A_TIME;
use crate::screen::Screen;
use crate::window::{Demo, is_action, is_frame};
use crate::x_server::XServer;

/// Small enough for a CPU driver with validation.
const SMALL: [&str; 9] = [
    "--antialiasing=none",
    "--reflections=none",
    "--size",
    "480x360",
    "--vpls=64",
    "--temporal-sets=4",
    "--bounces=2",
    "--seed=1",
    "--validate",
];

#[test]
#[ignore = "long; `visit` looks into it once"]
fn a_session_from_start_to_end() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    let mut demo = Demo::start(&server, &SMALL);

    // It opens on the built-in scene, which moves.
    let scene = demo.wait("scene", |event| event["event"] == "scene");
    assert_eq!(scene["details"]["name"], "playroom");
    demo.frames(6);
    let first = demo.screen();
    first.keep("1-start");
    let shown = first.whole_picture();
    assert_eq!((shown.width, shown.height), (480, 360), "the size that was asked for");
    assert!(first.picture().colours() > 2000, "{} colours", first.picture().colours());
    demo.frames(10);
    assert!(demo.screen().picture().difference(&first.picture()) > 0.5, "nothing moves");
    assert_vpls_are_replaced(&mut demo);

    // The picture is stationary when paused.
    demo.key_for("space", "toggle-pause");
    demo.settle();
    let still = demo.screen().picture();
    demo.frames(3);
    assert!(demo.screen().picture() == still, "a paused scene does not stand still");

    dragging_a_light_changes_the_indirect_light(&mut demo);
    each_view_shows_something_of_its_own(&mut demo);
    paths_and_single_vpls(&mut demo);
    a_preset_takes_effect(&mut demo);
    sizes_and_hiding(&mut demo);

    // A screenshot equals the screen.
    let seen = demo.now();
    demo.key_for("Tab", "toggle-panel");
    demo.wait_after(seen, "size", |event| event["details"]["set"]["size"] == serde_json::json!([480, 300]));
    demo.settle();
    let screen = demo.screen();
    let seen = demo.now();
    demo.key_for("F12", "screenshot");
    let saved = demo.wait_after(seen, "screenshot", |event| event["event"] == "saved");
    let picture = image::open(demo.path(saved["details"].as_str().unwrap())).unwrap().to_rgb8();
    assert_eq!(picture.dimensions(), (480, 300));
    assert!(picture.pixels().map(|pixel| pixel.0).eq(screen.pixels.iter().copied()), "another picture");
    demo.discard_and_close();
}

/// The board turns, so VPLs are invalidated and shot in nearly every frame.
fn assert_vpls_are_replaced(demo: &mut Demo<'_>) {
    let frames: Vec<_> = demo.events().iter().filter(|event| is_frame(event)).collect();
    let count = |key: &str| -> u64 {
        frames.iter().filter_map(|frame| frame["measured"]["vpls"][key].as_u64()).sum()
    };
    let (invalidated, shot) = (count("invalidated"), count("shot"));
    assert!(invalidated > 0 && shot > 0, "{invalidated} invalidated, {shot} shot");
}

fn dragging_a_light_changes_the_indirect_light(demo: &mut Demo<'_>) {
    demo.click_widget("Scene");
    demo.click_widget("Time");
    demo.click_widget("Lights and objects");
    let seen = demo.now();
    demo.click_widget("add point");
    demo.wait_after(seen, "new light", |event| is_action(event, "add-light"));
    // Indirect light alone.
    demo.key_for("v", "step-buffer");
    demo.key_for("v", "step-buffer");
    demo.settle();
    let before = demo.screen();
    before.keep("2-light");
    // Drag it along its arrow, at the centre of the window, to the right and to the left.
    let seen = demo.now();
    demo.drag_picture([275, 180], [100, 180]);
    demo.wait_after(seen, "moved light", |event| is_action(event, "edit-light"));
    demo.settle();
    let after = demo.screen();
    after.keep("3-light-dragged");
    let difference = after.picture().difference(&before.picture());
    assert!(difference > 2.0, "indirect light has changed by {difference} only");
    for _ in 0..2 {
        demo.key_for("shift+v", "step-buffer");
    }
    let seen = demo.now();
    demo.input(&["key", "Delete"]);
    demo.wait_after(seen, "deletion", |event| is_action(event, "delete"));
}

fn each_view_shows_something_of_its_own(demo: &mut Demo<'_>) {
    demo.settle();
    let combined = demo.screen().picture();
    let mut seen = vec![combined.clone()];
    for view in 1..26 {
        demo.key_for("v", "step-buffer");
        let screen = demo.screen();
        screen.keep(&format!("4-view-{view:02}"));
        let picture = screen.picture();
        if view == 20 && picture == seen[19] {
            seen[19] = the_set_of_another_frame(demo, &picture);
        }
        // Nothing moves, so a set buffer is the same after its reprojection.
        // The room has neither metal nor surfaces that emit, and all sets have seen it, some turns ago.
        let may_be = [(20, 21), (13, 14), (22, 23)];
        let alike = |(other, known): (usize, &Screen)| *known == picture && !may_be.contains(&(other, view));
        assert!(!seen.iter().enumerate().any(alike), "view {view} looks like another one");
        // No VPL is selected, so this view shows nothing.
        let brightness: f64 = picture.mean().iter().sum();
        let is_black = [13, 14, 24].contains(&view);
        assert!(brightness > 3.0 || picture.colours() > 1 || is_black, "view {view} is black");
        seen.push(picture);
    }
    // Depth is grey, albedo has the red of the wall at the left.
    let depth = &seen[6];
    assert!(depth.pixels.iter().filter(|[r, g, b]| r == g && g == b).count() > depth.pixels.len() * 9 / 10);
    let albedo = seen[9].pixels[(148 * seen[9].width + 15) as usize];
    assert!(albedo[0] > albedo[1] + 60, "{albedo:?}");
    // Paths and effects are not in use, so their views show nothing.
    for view in 0..17 {
        demo.key_for("v", "step-buffer");
        let black: f64 = demo.screen().picture().mean().iter().sum();
        assert!(black < 1.0, "view {view} of paths and effects is not black");
    }
    demo.key_for("v", "step-buffer");
    // Another view begins a new mean of still frames.
    demo.settle();
    assert!(demo.screen().picture() == combined, "the picture has not come back");
}

/// One frame in four draws the set whose buffer the next view shows: waits for another.
fn the_set_of_another_frame(demo: &mut Demo<'_>, buffer: &Screen) -> Screen {
    demo.key_for("shift+v", "step-buffer");
    let mut filtered = demo.screen().picture();
    for wait in 0..20 {
        if filtered != *buffer {
            break;
        }
        // Whatever a picture of the screen takes, not always a multiple of the sets.
        demo.frames(wait % 2);
        filtered = demo.screen().picture();
    }
    demo.key_for("v", "step-buffer");
    filtered
}

fn paths_and_single_vpls(demo: &mut Demo<'_>) {
    let plain = demo.screen().picture();
    demo.key_for("p", "toggle-paths");
    let paths = demo.screen();
    paths.keep("5-paths");
    assert!(paths.picture().difference(&plain) > 1.0, "no paths are drawn");
    demo.key_for("period", "step-vpl");
    let single = demo.screen();
    single.keep("6-single-vpl");
    assert!(single.picture().difference(&paths.picture()) > 1.0);
    demo.key_for("slash", "all-vpls");
    demo.key_for("p", "toggle-paths");
    demo.settle();
    assert!(demo.screen().picture() == plain, "paths leave something behind");
}

fn a_preset_takes_effect(demo: &mut Demo<'_>) {
    // Close one section, so that the other is in view.
    demo.click_widget("Lights and objects");
    demo.click_widget("Settings");
    // A frozen picture has no VPLs.
    let slots = demo.events().iter().rev().find_map(|event| event["measured"]["vpls"]["slots"].as_u64());
    assert_eq!(slots, Some(64));
    let seen = demo.now();
    demo.click_widget("draft");
    demo.wait_after(seen, "settings", |event| is_action(event, "set"));
    demo.wait_after(seen, "128 VPLs", |event| event["measured"]["vpls"]["slots"] == 128);
    demo.screen().keep("7-settings");
    // A preset is of all settings, also of how long a picture takes to freeze.
    let seen = demo.now();
    demo.key_for("ctrl+z", "undo");
    demo.wait_after(seen, "64 VPLs", |event| event["measured"]["vpls"]["slots"] == 64);
}

fn sizes_and_hiding(demo: &mut Demo<'_>) {
    // The panel and the bar keep their size, the picture has the rest.
    for (size, picture) in [([960, 480], [710, 432]), ([480, 300], [230, 230])] {
        let seen = demo.now();
        demo.resize(size[0], size[1]);
        demo.wait_after(seen, "size", |event| event["details"]["set"]["size"] == serde_json::json!(picture));
        let screen = demo.screen();
        screen.keep(&format!("8-{}", size[0]));
        assert_eq!([screen.width, screen.height], size);
        assert!(screen.picture().colours() > 2000, "{}", screen.picture().colours());
    }
    demo.minimise();
    let frame = demo.last_frame();
    demo.turns(20);
    assert_eq!(demo.last_frame(), frame, "a hidden window draws");
    demo.restore();
    let screen = demo.screen();
    screen.keep("8-restored");
    assert!(screen.picture().colours() > 2000, "the window does not come back");
}
