//! What a new user meets: the first lines, the question before edits are lost, the keyboard.

use std::path::Path;

use serde_json::Value;

use crate::ONE_AT_A_TIME;
use crate::window::{CACHE, Demo, WELCOMED, is_action};
use crate::x_server::XServer;

const SMALL: [&str; 8] = [
    "cornell-box",
    "--antialiasing=none",
    "--reflections=none",
    "--size=480x320",
    "--vpls=64",
    "--temporal-sets=4",
    "--bounces=2",
    "--validate",
];

fn is_question(event: &Value, what: &str) -> bool {
    event["event"] == "unsaved" && (event["details"] == what || event["details"].get(what).is_some())
}

#[test]
#[ignore = "long; `visit` looks into it once"]
fn the_first_lines_are_shown_until_they_are_dismissed() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    // Another test may have left it, or none.
    let _ = std::fs::remove_file(Path::new(CACHE).join("glowworm").join(WELCOMED));
    let mut demo = Demo::start_as_it_is(&server, &SMALL);
    demo.screen().keep("25-welcome");
    let seen = demo.now();
    demo.click_widget_at_once("Got it", [10, 10]);
    demo.wait_after(seen, "dismissal", |event| is_action(event, "dismiss-welcome"));
    demo.frames(3);
    assert!(!demo.shows("Got it"));
    let mut since = demo.events()[seen..].iter();
    assert!(!since.any(|event| is_action(event, "select")), "the click reaches the picture as well");
    demo.close();
    let mut demo = Demo::start_as_it_is(&server, &SMALL);
    demo.frames(6);
    assert!(!demo.shows("Got it"), "the first lines come back");
    demo.close();
}

#[test]
#[ignore = "long; `visit` looks into it once"]
fn edits_are_not_lost_without_a_question() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    let mut demo = Demo::start(&server, &SMALL);
    demo.click_widget("Scene");
    demo.click_widget("Time");
    demo.click_widget("Lights and objects");
    let seen = demo.now();
    demo.click_widget("add point");
    demo.wait_after(seen, "new light", |event| is_action(event, "add-light"));

    assert!(demo.title().starts_with('*'), "{} has unsaved edits", demo.title());

    // Closing asks; Escape goes on with the scene.
    let seen = demo.now();
    demo.input(&["key", "ctrl+q"]);
    demo.wait_after(seen, "question", |event| is_question(event, "quit"));
    demo.screen().keep("26-unsaved");
    assert!(demo.shows("Discard"));
    demo.input(&["key", "Escape"]);
    demo.frames(3);
    assert!(!demo.shows("Discard"));

    // Another scene asks too, and the same edits can be discarded.
    let seen = demo.now();
    demo.click_widget("scenes");
    demo.screen().keep("27-scenes");
    demo.click_widget("scene playroom");
    demo.wait_after(seen, "question", |event| is_question(event, "open"));
    demo.click_widget("Discard");
    demo.wait_after(seen, "scene", |event| event["details"]["name"] == "playroom");

    // Without the panel, too, it asks and saves.
    let seen = demo.now();
    demo.click_widget("add point");
    demo.wait_after(seen, "new light", |event| is_action(event, "add-light"));
    demo.key_for("Tab", "toggle-panel");
    let seen = demo.now();
    demo.input(&["key", "ctrl+q"]);
    demo.wait_after(seen, "question", |event| is_question(event, "quit"));
    demo.click_widget("Save …");
    demo.frames(3);
    demo.screen().keep("27-save");
    demo.input(&["key", "Return"]);
    let saved = demo.wait_after(seen, "saved", |event| event["event"] == "saved");
    assert!(demo.path(saved["details"].as_str().unwrap()).is_file());

    // Nothing is edited now, so nothing asks.
    demo.frames(2);
    assert!(!demo.title().starts_with('*'), "{} is saved", demo.title());
    let log = demo.close();
    let questions = log["events"].as_array().unwrap().iter().filter(|event| event["event"] == "unsaved");
    assert_eq!(questions.count(), 3);
}

#[test]
#[ignore = "long; `visit` looks into it once"]
fn the_keyboard_reaches_the_panel_and_comes_back() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    let mut demo = Demo::start(&server, &SMALL);
    demo.key_for("F6", "toggle-keyboard");
    // Scene, three methods, denoiser, T = 1.
    for _ in 0..5 {
        demo.input(&["key", "Tab"]);
    }
    demo.screen().keep("28-keyboard");
    let seen = demo.now();
    demo.input(&["key", "space"]);
    let set = demo.wait_after(seen, "one set", |event| is_action(event, "set"));
    assert_eq!(set["details"]["set"]["temporal_sets"], 1);
    // The last widget is the header of the last section.
    for _ in 0..6 {
        demo.input(&["key", "shift+Tab"]);
    }
    let seen = demo.now();
    demo.input(&["key", "space"]);
    demo.frames(12);
    demo.screen().keep("29-keyboard-settings");
    assert!(!demo.events()[seen..].iter().any(|event| is_action(event, "toggle-pause")));
    demo.input(&["key", "Escape"]);
    demo.key_for("space", "toggle-pause");
    demo.close();
}

#[test]
#[ignore = "long; `visit` looks into it once"]
fn a_number_keeps_the_keyboard_only_under_the_pointer() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    let mut demo = Demo::start(&server, &SMALL);
    demo.key_for("space", "toggle-pause");
    demo.click_widget("scrub value");
    let seen = demo.now();
    demo.input(&["type", "5"]);
    demo.wait_after(seen, "time", |event| is_action(event, "scrub"));
    demo.input(&["key", "c"]);
    assert!(!demo.events()[seen..].iter().any(|event| is_action(event, "toggle-split")), "typed keys act");
    demo.move_to_picture([200, 150]);
    demo.key_for("c", "toggle-split");
    demo.close();
}
