//! A visit to one scene in one window: what each longer test of the window looks into, once.

use std::fs;

use crate::ONE_AT_A_TIME;
use crate::edits::{saved, settled};
use crate::window::{Demo, is_action};
use crate::x_server::XServer;

const SMALL: [&str; 9] = [
    "cornell-box",
    "--antialiasing=none",
    "--reflections=none",
    "--size",
    "320x200",
    "--vpls=64",
    "--temporal-sets=4",
    "--bounces=2",
    "--validate",
];

/// Takes 70 seconds: it draws some 400 frames.
#[test]
fn a_visit() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    let mut demo = Demo::start(&server, &SMALL);
    let start = settled(&mut demo);
    start.keep("50-visit");
    assert_eq!((start.width, start.height), (320, 200), "the size that was asked for");
    assert!(start.colours() > 1000, "{} colours", start.colours());

    // Before there are edits, so that nothing asks.
    a_broken_scene_is_one_line(&mut demo);
    let lit = a_light_is_added_taken_back_and_made_again(&mut demo, &start);
    a_buffer_and_the_paths_are_shown_and_hidden(&mut demo);
    another_method_draws_and_the_first_one_comes_back(&mut demo);
    assert!(settled(&mut demo) == lit, "something of all this is left in the picture");

    // The saved scene has the light; `edits::objects_are_added` renders one.
    let file = saved(&mut demo);
    let lights = |scene: &str| glowworm::formats::load_scene(scene, None).unwrap().lights.len();
    assert_eq!(lights(demo.path(&file).to_str().unwrap()), lights("cornell-box") + 1);
    // What is saved is not asked about.
    demo.close();
}

fn a_light_is_added_taken_back_and_made_again(
    demo: &mut Demo<'_>,
    start: &crate::screen::Screen,
) -> crate::screen::Screen {
    for section in ["Scene", "Time", "Lights and objects"] {
        demo.click_widget(section);
    }
    let seen = demo.now();
    demo.click_widget("add point");
    demo.wait_after(seen, "new light", |event| is_action(event, "add-light"));
    assert!(demo.title().starts_with('*'), "{} has unsaved edits", demo.title());
    let lit = settled(demo);
    lit.keep("51-lit");
    assert!(lit.difference(start) > 1.0, "the light lights nothing");
    demo.key_for("ctrl+z", "undo");
    assert!(settled(demo) == *start, "something is left of the light");
    demo.key_for("ctrl+shift+z", "redo");
    assert!(settled(demo) == lit, "the light has not come back");
    lit
}

fn a_buffer_and_the_paths_are_shown_and_hidden(demo: &mut Demo<'_>) {
    let picture = demo.screen().picture();
    for (show, hide, action) in [("v", "shift+v", "step-buffer"), ("p", "p", "toggle-paths")] {
        demo.key_for(show, action);
        let shown = demo.screen().picture();
        assert!(shown.difference(&picture) > 1.0, "{action} shows nothing");
        demo.key_for(hide, action);
    }
}

fn another_method_draws_and_the_first_one_comes_back(demo: &mut Demo<'_>) {
    demo.click_widget("method");
    let seen = demo.now();
    demo.click_widget("method paths");
    let has = |event: &serde_json::Value, pass: &str| event["measured"]["passes"].get(pass).is_some();
    demo.wait_after(seen, "a frame by paths", |event| has(event, "paths_trace"));
    demo.settle();
    assert!(demo.screen().picture().colours() > 1000, "paths draw nothing");
    let seen = demo.now();
    demo.key_for("ctrl+z", "undo");
    demo.wait_after(seen, "a frame by VPLs", |event| has(event, "indirect_shading"));
}

/// The error is in the second line of the file.
fn a_broken_scene_is_one_line(demo: &mut Demo<'_>) {
    fs::write(demo.path("broken.toml"), "name = \"broken\"\nlight = 3\n").unwrap();
    let seen = demo.now();
    demo.drop_file(&demo.path("broken.toml"));
    let failed = demo.wait_after(seen, "failure", |event| event["event"] == "scene-failed");
    let said = failed["details"].as_str().unwrap();
    assert!(said.contains("broken.toml:2") && said.contains("light") && !said.contains('\n'), "{said}");
    demo.click_widget("dismiss");
}
