//! The divided window: methods side by side, the reference, the error; and edits that are taken back.

use serde_json::Value;

use crate::ONE_AT_A_TIME;
use crate::window::{Demo, is_action};
use crate::x_server::XServer;

const SMALL: [&str; 7] = [
    "--antialiasing=none",
    "--reflections=none",
    "--size=480x360",
    "--vpls=64",
    "--temporal-sets=4",
    "--bounces=2",
    "--validate",
];

fn metrics(demo: &mut Demo<'_>, what: &str, is_it: impl Fn(&Value) -> bool) -> Value {
    let seen = demo.now();
    let event = demo.wait_after(seen, what, |event| event["event"] == "metrics" && is_it(&event["details"]));
    event["details"].clone()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
#[ignore = "long; `visit` looks into it once"]
fn methods_and_the_reference_stand_side_by_side() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    let mut demo = Demo::start(&server, &SMALL);
    demo.frames(6);

    // One set beside the four of the left side, while a board turns, and each by a clock of its own.
    demo.key_for("c", "toggle-split");
    let differs = metrics(&mut demo, "one set beside four", |_| true);
    assert!(number(&differs["flip"]) > 0.0, "{differs}");
    metrics(&mut demo, "motion", |details| details["temporal_error"].as_f64() > Some(0.0));
    demo.screen().keep("20-split");

    // The same on both sides is the same, bit for bit, once nothing moves.
    demo.key_for("space", "toggle-pause");
    demo.click_widget("T = 1");
    metrics(&mut demo, "one set on both sides", |details| number(&details["rmse"]) == 0.0);
    demo.key_for("space", "toggle-pause");

    // Each method in turn on the left.
    for widget in ["T = 16", "draft"] {
        let seen = demo.now();
        demo.click_widget(widget);
        demo.wait_after(seen, widget, |event| is_action(event, "set"));
        let differs = metrics(&mut demo, widget, |details| number(&details["flip"]) > 1e-3);
        assert!(number(&differs["ssim"]) < 1.0, "{differs}");
    }

    // The divider follows the pointer.
    let seen = demo.now();
    demo.drag_widget("divider", -120);
    demo.wait_after(seen, "divider further left", |event| {
        event["details"]["move-divider"].as_f64().is_some_and(|at| at < 0.4)
    });

    // The reference, once nothing moves.
    demo.key_for("space", "toggle-pause");
    demo.key_for("g", "toggle-reference");
    let early = metrics(&mut demo, "first samples", |details| !details["samples"].is_null());
    let late = metrics(&mut demo, "more samples", |details| {
        details["samples"].as_u64() >= early["samples"].as_u64().map(|samples| 16 * samples)
    });
    let ssim = |metrics: &Value| number(&metrics["ssim"]);
    assert!(ssim(&late) > ssim(&early), "the reference does not converge: {early}, {late}");
    demo.screen().keep("21-reference");
    let before = demo.screen().picture();
    demo.key_for("x", "toggle-difference");
    let difference = demo.screen();
    difference.keep("22-difference");
    assert!(difference.picture().difference(&before) > 3.0, "no error is shown");
    demo.key_for("x", "toggle-difference");
    demo.key_for("g", "toggle-reference");
    demo.close();
}

#[test]
#[ignore = "long; `visit` looks into it once"]
fn edits_and_settings_are_taken_back_and_made_again() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    let mut demo = Demo::start(&server, &SMALL);
    demo.key_for("space", "toggle-pause");
    demo.click_widget("Scene");
    demo.click_widget("Time");
    demo.click_widget("Lights and objects");
    let settled = |demo: &mut Demo<'_>| {
        demo.settle();
        demo.screen().picture()
    };
    demo.input(&["key", "Escape"]);
    let start = settled(&mut demo);
    let mut edits = 0;
    for widget in ["add point", "add spot", "T = 1", "add directional", "T = 8"] {
        let seen = demo.now();
        demo.click_widget(widget);
        demo.wait_after(seen, widget, |event| is_action(event, "add-light") || is_action(event, "set"));
        edits += 1;
    }
    for _ in 0..15 {
        let seen = demo.now();
        demo.input(&["key", "ctrl+d"]);
        demo.wait_after(seen, "copy", |event| is_action(event, "duplicate"));
        edits += 1;
    }
    demo.key_for("Escape", "select");
    let end = settled(&mut demo);
    assert!(end != start, "the edits change nothing");
    for _ in 0..edits {
        demo.key_for("ctrl+z", "undo");
    }
    assert!(settled(&mut demo) == start, "the start has not come back");
    for _ in 0..edits {
        demo.key_for("ctrl+shift+z", "redo");
    }
    // Each state has its selection, with an outline.
    demo.key_for("Escape", "select");
    assert!(settled(&mut demo) == end, "the end has not come back");
    demo.discard_and_close();
}

#[test]
#[ignore = "long; `visit` looks into it once"]
fn a_picture_of_a_file_stands_right_of_the_divider() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    let mut demo = Demo::start(&server, &[&SMALL[..], &["--exposure=0"]].concat());
    demo.key_for("space", "toggle-pause");
    demo.settle();
    let seen = demo.now();
    demo.key_for("shift+F12", "screenshot");
    let saved = demo.wait_after(seen, "a picture", |event| event["event"] == "saved");
    let picture = demo.path(saved["details"].as_str().unwrap());

    // Linear values get the tones of the left side.
    demo.key_for("c", "toggle-split");
    let seen = demo.now();
    demo.drop_file(&picture);
    demo.wait_after(seen, "the file", |event| !event["details"]["split"]["picture"].is_null());
    metrics(&mut demo, "the picture on both sides", |details| number(&details["flip"]) < 2e-3);
    demo.screen().keep("23-file");

    // What stands still is compared once.
    let seen = demo.now();
    demo.settle();
    assert!(demo.events()[seen..].iter().all(|event| event["event"] != "metrics"));

    let broken = demo.path("broken.png");
    std::fs::write(&broken, "no picture").unwrap();
    demo.drop_file(&broken);
    demo.wait_after(seen, "a notice", |event| !event["details"]["dismiss"].is_null());
    demo.screen().keep("24-notice");
    demo.close();
}
