//! Devices that are lost: the window goes on with a new one, or ends with one line. Unsaved edits are in a file.

use serde_json::Value;

use crate::ONE_AT_A_TIME;
use crate::window::{Demo, is_action};
use crate::x_server::XServer;

// Nothing moves, so that frames and their submissions come with input, and otherwise ten a second.
const SMALL: [&str; 7] = [
    "cornell-box",
    "--antialiasing=none",
    "--reflections=none",
    "--indirect=none",
    "--size",
    "480x360",
    "--validate",
];
/// The file of the unsaved edits, and submissions at which there are some.
const KEPT: &str = "glowworm-cornell-box-unsaved-0001.toml";
const EDITED: u64 = 500;

fn add_a_light(demo: &mut Demo<'_>) {
    demo.click_widget("Scene");
    demo.click_widget("Lights and objects");
    demo.click_widget("add point");
    demo.wait("a light", |event| is_action(event, "add-light"));
}

fn is_lost(event: &Value) -> bool {
    event["event"] == "device-lost"
}

#[test]
#[ignore = "long; cli::a_lost_device_ends_the_program_with_one_line is quicker"]
fn the_window_goes_on_after_a_loss() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    let mut demo = Demo::start_losing(&server, &EDITED.to_string(), &SMALL);
    add_a_light(&mut demo);
    let lost = demo.wait("a loss", is_lost);
    assert!(lost["details"].as_str().unwrap().contains("the device was lost"), "{lost}");
    let seen = demo.events().iter().position(is_lost).unwrap();
    demo.wait_after(seen, "a device", |event| event["event"] == "device");
    let scene = demo.wait_after(seen, "its scene", |event| event["event"] == "scene");
    assert_eq!((&scene["details"]["name"], &scene["details"]["same"]), (&"cornell-box".into(), &true.into()));
    demo.frames(6);
    let kept = glowworm::formats::load_scene(demo.path(KEPT).to_str().unwrap(), None).unwrap();
    let lights = glowworm::formats::load_scene("cornell-box", None).unwrap().lights.len();
    assert_eq!(kept.lights.len(), lights + 1);
    // Its edits are still unsaved, so it asks.
    demo.discard_and_close();
}

#[test]
#[ignore = "long; `visit` looks into it once"]
fn a_device_that_is_lost_again_ends_the_window() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    let mut demo = Demo::start_losing(&server, &format!("{EDITED},{}", EDITED + 80), &SMALL);
    add_a_light(&mut demo);
    demo.wait("a loss", is_lost);
    let (code, said) = demo.end();
    let errors: Vec<_> = said.lines().filter(|line| line.starts_with("glowworm: error: ")).collect();
    assert_eq!((code, errors.len()), (Some(1), 1), "{said}");
    assert!(
        errors[0].contains("the device was lost") && errors[0].contains("glowworm-cornell-box-unsaved"),
        "{said}"
    );
}
