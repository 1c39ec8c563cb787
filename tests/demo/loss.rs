//! Devices that are lost: the window goes on with a new one, or ends with one line. Unsaved edits are in a file.

use serde_json::Value;

use crate::ONE_AT_A_TIME;
use crate::window::Demo;
use crate::x_server::XServer;

const SMALL: [&str; 4] = ["--size", "96x72", "--vpls=64", "--validate"];
/// The file of the unsaved edits, and submissions at which there are some.
const KEPT: &str = "glowworm-playroom-unsaved-0001.toml";
const EDITED: u64 = 600;

fn is_lost(event: &Value) -> bool {
    event["event"] == "device-lost"
}

#[test]
fn the_window_goes_on_after_a_loss() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    let mut demo = Demo::start_losing(&server, &EDITED.to_string(), &SMALL);
    demo.key_for("h", "toggle-headlamp");
    let lost = demo.wait("a loss", is_lost);
    assert!(lost["details"].as_str().unwrap().contains("the device was lost"), "{lost}");
    let seen = demo.events().iter().position(is_lost).unwrap();
    demo.wait_after(seen, "a device", |event| event["event"] == "device");
    let scene = demo.wait_after(seen, "its scene", |event| event["event"] == "scene");
    assert_eq!((&scene["details"]["name"], &scene["details"]["same"]), (&"playroom".into(), &true.into()));
    demo.frames(6);
    let kept = glowworm::formats::load_scene(demo.path(KEPT).to_str().unwrap(), None).unwrap();
    assert!(!kept.instances.is_empty());
    // Its edits are still unsaved, so it asks.
    demo.discard_and_close();
}

#[test]
fn a_device_that_is_lost_again_ends_the_window() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    let mut demo = Demo::start_losing(&server, &format!("{EDITED},{}", EDITED + 80), &SMALL);
    demo.key_for("h", "toggle-headlamp");
    demo.wait("a loss", is_lost);
    let (code, said) = demo.end();
    let errors: Vec<_> = said.lines().filter(|line| line.starts_with("glowworm: error: ")).collect();
    assert_eq!((code, errors.len()), (Some(1), 1), "{said}");
    assert!(
        errors[0].contains("the device was lost") && errors[0].contains("glowworm-playroom-unsaved"),
        "{said}"
    );
}
