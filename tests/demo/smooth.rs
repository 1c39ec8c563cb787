//! Frames go on whatever is done in the window.

use serde_json::Value;

use crate::ONE_AT_A_TIME;
use crate::window::{Demo, is_action, is_frame};
use crate::x_server::XServer;

/// A part of a session: what is done in it, and its first frame.
type Part = (&'static str, u64);

#[test]
#[ignore = "long; `visit` looks into it once"]
fn frames_go_on_while_one_scrubs_picks_edits_and_loads() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    let (log, parts) = session(&server);
    let frames: Vec<u64> =
        log["events"].as_array().unwrap().iter().filter(|event| is_frame(event)).map(number).collect();
    assert!(frames.windows(2).all(|pair| pair[1] == pair[0] + 1), "a frame is missing: {frames:?}");
    let ends = parts.iter().skip(1).map(|part| part.1).chain([u64::MAX]);
    for ((part, begin), end) in parts.iter().zip(ends) {
        assert!(frames.iter().any(|frame| (*begin..end).contains(frame)), "no frame while {part}: {parts:?}");
    }
}

#[test]
#[ignore = "long; `visit` looks into it once"]
fn a_picture_has_fewer_pixels_in_motion_and_all_of_them_at_rest() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    // No device keeps this rate.
    let fast = ["cornell-box", "--target-fps=1000", "--vpls=64", "--reflections=none", "--validate"];
    let mut demo = Demo::start(&server, &fast);
    let size_of = |event: &Value| {
        let size = &event["details"]["set"]["size"];
        [0, 1].map(|axis| size[axis].as_u64().unwrap_or(0))
    };
    let seen = demo.now();
    demo.resize(480, 300);
    demo.wait_after(seen, "the size", |event| event["event"] == "layout");
    let [left, top, right, bottom] = demo.viewport().map(u64::from);
    let all = [right - left, bottom - top];
    let seen = demo.now();
    demo.input(&["keydown", "d"]);
    demo.wait_after(seen, "fewer pixels", |event| (1..all[0]).contains(&size_of(event)[0]));
    let seen = demo.now();
    demo.input(&["keyup", "d"]);
    demo.wait_after(seen, "all pixels", |event| size_of(event) == all);
    // It keeps them.
    let seen = demo.now();
    demo.settle();
    assert!(demo.events()[seen..].iter().all(|event| size_of(event) == [0; 2]));
    demo.close();
}

fn number(event: &Value) -> u64 {
    event["frame"].as_u64().unwrap()
}

/// Scrubs, picks, edits and loads another scene while the animation plays.
fn session(server: &XServer) -> (Value, Vec<Part>) {
    let mut demo = Demo::start(server, &["--size", "640x360", "--vpls=64"]);
    let mut parts = Vec::new();
    let mut begins = |demo: &mut Demo<'_>, part: &'static str| {
        parts.push((part, demo.last_frame()["frame"].as_u64().unwrap() + 1));
    };
    demo.frames(10);
    begins(&mut demo, "playing");
    demo.frames(20);
    begins(&mut demo, "scrubbing");
    demo.drag_widget("scrub", 60);
    begins(&mut demo, "picking");
    for x in [30, 120, 220, 320] {
        demo.click_picture([x, 250]);
    }
    begins(&mut demo, "a new light");
    demo.click_widget("Scene");
    demo.click_widget("Time");
    // A selection has opened it.
    demo.input(&["key", "Escape"]);
    if !demo.shows("add spot") {
        demo.click_widget("Lights and objects");
    }
    demo.click_widget("add spot");
    begins(&mut demo, "dragging it");
    demo.drag_picture([355, 180], [300, 180]);
    begins(&mut demo, "copying it");
    let seen = demo.now();
    demo.input(&["key", "ctrl+d"]);
    demo.wait_after(seen, "copy", |event| is_action(event, "duplicate"));
    demo.frames(6);
    begins(&mut demo, "loading");
    let seen = demo.now();
    demo.click_widget("Lights and objects");
    demo.click_widget("Scene");
    demo.click_widget("path");
    demo.input(&["type", "cornell-box"]);
    demo.input(&["key", "Return"]);
    demo.click_widget("Discard");
    demo.wait_after(seen, "another scene", |event| event["details"]["name"] == "cornell-box");
    begins(&mut demo, "another scene");
    demo.frames(10);
    (demo.close(), parts)
}
