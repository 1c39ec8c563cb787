//! Recordings replay to the same pixels; saved scenes load to the same scene.

use crate::ONE_AT_A_TIME;
use crate::window::{Demo, is_action};
use crate::x_server::XServer;

const SMALL: [&str; 6] = ["--size", "240x150", "--vpls=64", "--temporal-sets=4", "--bounces=2", "--validate"];

/// F4 copies the command of the very picture on screen, of a paused scene that moves, with another camera; twice the same.
#[test]
#[ignore = "long; `visit` looks into it once"]
fn the_command_renders_to_what_is_on_screen() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    let mut demo = Demo::start(&server, &SMALL);
    demo.frames(3);
    demo.key_for("space", "toggle-pause");
    demo.input(&["keydown", "d"]);
    demo.frames(2);
    demo.input(&["keyup", "d"]);
    demo.key_for("shift+Tab", "toggle-overlays");
    demo.frames(100);
    demo.settle();
    let screen = demo.screen().whole_picture();
    let mut commands = Vec::new();
    for _ in 0..2 {
        let seen = demo.now();
        demo.input(&["key", "F4"]);
        let command = demo.wait_after(seen, "command", |event| event["event"] == "command");
        commands.push(command["details"].as_str().unwrap().to_owned());
        demo.frames(4);
    }
    assert_eq!(commands[0], commands[1], "saved once, named twice");
    let arguments: Vec<&str> = commands[1].split(' ').skip(1).collect();
    demo.assert_renders_to(&arguments, "playroom.png", &screen);
    demo.close();
}

#[test]
#[ignore = "long; `visit` looks into it once"]
fn a_recording_renders_to_what_was_on_screen() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    let mut demo = Demo::start(&server, &SMALL);
    demo.frames(3);
    let seen = demo.now();
    demo.key_for("ctrl+r", "toggle-recording");
    demo.wait_after(seen, "recording", |event| event["event"] == "scene");
    demo.frames(4);

    // Fly, look around, move the ball, change a setting, all while the board turns.
    demo.input(&["keydown", "a"]);
    demo.frames(3);
    demo.input(&["keyup", "a"]);
    demo.move_to_picture([120, 75]);
    demo.input(&["mousedown", "3"]);
    demo.move_to_picture([110, 78]);
    demo.input(&["mouseup", "3"]);
    let seen = demo.now();
    demo.click_picture([22, 139]);
    demo.wait_after(seen, "choice", |event| is_action(event, "select"));
    demo.key_for("space", "toggle-pause");
    demo.key_for("shift+Tab", "toggle-overlays");
    // Until the paused picture stands still: which frame is on screen is not known to the frame.
    demo.frames(100);
    demo.settle();
    let screen = demo.screen().whole_picture();
    screen.keep("9-recorded");
    let seen = demo.now();
    demo.input(&["key", "ctrl+r"]);
    let saved = demo.wait_after(seen, "recording", |event| event["event"] == "saved");
    let file = saved["details"].as_str().unwrap().to_owned();

    demo.assert_renders_to(&["render", &file, "--out=replayed.png"], "replayed.png", &screen);
    demo.close();
}
