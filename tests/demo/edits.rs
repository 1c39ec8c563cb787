//! Materials and the environment are edited while the scene is shown, recorded and saved.

use std::fs;

use serde_json::Value;

use crate::ONE_AT_A_TIME;
use crate::screen::Screen;
use crate::window::{Demo, is_action};
use crate::x_server::XServer;

const SMALL: [&str; 8] = [
    "--antialiasing=none",
    "--reflections=none",
    "--size",
    "480x300",
    "--vpls=64",
    "--temporal-sets=4",
    "--bounces=2",
    "--validate",
];

fn is_edited(event: &Value) -> bool {
    event["event"] == "scene-edited"
}

/// The picture alone, once it stands still.
pub fn settled(demo: &mut Demo<'_>) -> Screen {
    demo.key_for("shift+Tab", "toggle-overlays");
    demo.settle();
    let screen = demo.screen();
    demo.key_for("shift+Tab", "toggle-overlays");
    screen.whole_picture()
}

/// The scene file that is saved for a command line.
pub fn saved(demo: &mut Demo<'_>) -> String {
    let seen = demo.now();
    demo.key_for("F4", "copy-command");
    let saved = demo.wait_after(seen, "a scene file", |event| event["event"] == "saved");
    saved["details"].as_str().unwrap().to_owned()
}

#[test]
#[ignore = "long; `visit` looks into it once"]
fn a_material_is_picked_edited_recorded_and_saved() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    let mut demo = Demo::start(&server, &[&["cornell-box"][..], &SMALL].concat());
    let seen = demo.now();
    demo.key_for("ctrl+r", "toggle-recording");
    demo.wait_after(seen, "recording", |event| event["event"] == "scene");
    let before = settled(&mut demo);
    before.keep("12-material");

    // The wall at the back turns into metal, live.
    inspect_the_wall(&mut demo);
    let seen = demo.now();
    demo.drag_widget("metallic", 60);
    let edit = demo.wait_after(seen, "edit", |event| is_action(event, "edit-material"));
    assert_eq!(edit["details"]["edit-material"]["name"], "white");
    demo.wait_after(seen, "the edited scene", is_edited);
    demo.screen().keep("13-material-edited");
    demo.key_for("i", "toggle-inspector");
    let metal = settled(&mut demo);
    metal.keep("14-material-metal");
    let difference = metal.difference(&before);
    assert!(difference > 1.5, "the picture has changed by {difference} only");

    // The saved scene is the one on screen.
    let file = saved(&mut demo);
    let text = fs::read_to_string(demo.path(&file)).unwrap();
    assert!(text.contains("[[materials]]") && text.contains("metallic"), "{text}");
    demo.assert_renders_to(&["render", "--out=rendered.png", "--frames=24", &file], "rendered.png", &metal);

    // Taken back, nothing of it is left.
    inspect_the_wall(&mut demo);
    let seen = demo.now();
    demo.click_widget("reset material");
    demo.wait_after(seen, "the scene of the file", is_edited);
    demo.key_for("i", "toggle-inspector");
    demo.frames(16);
    let end = settled(&mut demo);
    assert!(end == before, "the picture has not come back");

    // The recording of all this renders to the same picture.
    let seen = demo.now();
    demo.input(&["key", "ctrl+r"]);
    let recording = demo.wait_after(seen, "recording", |event| event["event"] == "saved");
    let recording = recording["details"].as_str().unwrap();
    let text = fs::read_to_string(demo.path(recording)).unwrap();
    assert!(text.contains("edited = "), "the edit was not recorded");
    demo.assert_renders_to(&["render", "--out=rendered.png", recording], "rendered.png", &end);
    demo.discard_and_close();
}

/// Clicks the wall at the back with the inspector.
fn inspect_the_wall(demo: &mut Demo<'_>) {
    demo.key_for("i", "toggle-inspector");
    demo.click_picture([248, 90]);
}

#[test]
#[ignore = "long; `visit` looks into it once"]
fn a_map_is_dropped_chosen_dimmed_and_saved() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let scene = "[[models]]\nname = \"ball\"\nprimitive = \"sphere\"\n[[instances]]\nmodel = \"ball\"\n\
                 [[lights]]\ntype = \"point\"\nposition = [3, 3, 3]\nintensity = [20, 20, 20]\n";
    fs::write(file("ball.toml"), scene).unwrap();
    for (name, colour) in [("blue.exr", [0.1, 0.2, 1.0]), ("red.exr", [1.0, 0.2, 0.1])] {
        image::Rgb32FImage::from_pixel(8, 4, image::Rgb(colour)).save(file(name)).unwrap();
    }
    fs::write(file("broken.hdr"), "#?RADIANCE\nnothing\n").unwrap();
    let ball = file("ball.toml");
    let mut demo = Demo::start(&server, &[&[ball.to_str().unwrap(), "--exposure=0"][..], &SMALL].concat());
    let black = settled(&mut demo);

    let seen = demo.now();
    demo.drop_file(&file("blue.exr"));
    demo.wait_after(seen, "the map", is_edited);
    let blue = settled(&mut demo);
    blue.keep("15-map-dropped");
    assert!(blue.mean()[2] > black.mean()[2] + 50.0, "{:?} after {:?}", blue.mean(), black.mean());

    // A broken one says so in one line, and changes nothing.
    let seen = demo.now();
    demo.drop_file(&file("broken.hdr"));
    let failed = demo.wait_after(seen, "failure", |event| event["event"] == "scene-failed");
    let said = failed["details"].as_str().unwrap();
    assert!(said.contains("broken.hdr") && said.contains("decoded") && !said.contains('\n'), "{said}");
    demo.screen().keep("16-map-broken");
    demo.click_widget("dismiss");
    assert!(settled(&mut demo) == blue, "a broken map changes the picture");

    // Another by its name.
    demo.click_widget("Scene");
    demo.click_widget("Environment");
    demo.click_widget("map");
    let seen = demo.now();
    demo.input(&["type", file("red.exr").to_str().unwrap()]);
    demo.input(&["key", "Return"]);
    demo.wait_after(seen, "the map", is_edited);
    let red = settled(&mut demo);
    assert!(red.mean()[0] > blue.mean()[0] + 50.0, "{:?} after {:?}", red.mean(), blue.mean());

    // Its slider dims it, without another scene.
    let seen = demo.now();
    demo.drag_widget("strength", -40);
    demo.wait_after(seen, "dimming", |event| is_action(event, "edit-environment"));
    let dim = settled(&mut demo);
    dim.keep("17-map-dimmed");
    assert!(dim.mean()[0] < red.mean()[0] - 20.0, "{:?} after {:?}", dim.mean(), red.mean());
    assert!(!demo.events()[seen..].iter().any(is_edited), "a scene was built for a number");

    let saved_file = saved(&mut demo);
    let text = fs::read_to_string(demo.path(&saved_file)).unwrap();
    for part in ["[environment]", "red.exr", "strength"] {
        assert!(text.contains(part), "{text}");
    }
    assert!(!text.contains("blue") && !text.contains("broken"), "{text}");
    demo.assert_renders_to(
        &["render", "--out=rendered.png", "--frames=24", &saved_file],
        "rendered.png",
        &dim,
    );
    demo.close();
}

#[test]
#[ignore = "long; `visit` looks into it once"]
fn lights_get_an_extent_which_is_saved() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    // High enough for the panel to show the sliders.
    let mut demo = Demo::start(&server, &[&SMALL[..], &["--size=160x600"]].concat());
    demo.frames(3);
    demo.click_widget("Scene");
    demo.click_widget("Time");
    demo.click_widget("Lights and objects");
    for (kind, slider) in [("add point", "light radius"), ("add directional", "light angle")] {
        let seen = demo.now();
        demo.click_widget(kind);
        demo.wait_after(seen, kind, |event| is_action(event, "add-light"));
        let seen = demo.now();
        demo.drag_widget(slider, 30);
        demo.wait_after(seen, slider, |event| is_action(event, "edit-light"));
        assert!(!demo.events()[seen..].iter().any(is_edited), "a scene was built for a number");
    }
    let file = saved(&mut demo);
    let scene = glowworm::formats::load_scene(demo.path(&file).to_str().unwrap(), None).unwrap();
    assert!(scene.lights.iter().any(|light| light.radius > 0.0));
    assert!(scene.lights.iter().any(|light| light.half_angle > 0.0));
    demo.close();
}

#[test]
#[ignore = "long; `visit` looks into it once"]
fn objects_are_copied_and_deleted() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    let mut demo = Demo::start(&server, &[&["cornell-box"][..], &SMALL].concat());
    demo.wait("scene", |event| event["event"] == "scene");
    let before = settled(&mut demo);
    // The tall box.
    demo.click_picture([211, 180]);
    edit_by_key(&mut demo, "ctrl+d", "duplicate");
    let two = settled(&mut demo);
    two.keep("15-copied");
    let difference = two.difference(&before);
    assert!(difference > 1.0, "the picture has changed by {difference} only");
    let file = saved(&mut demo);
    let text = fs::read_to_string(demo.path(&file)).unwrap();
    assert!(text.contains(" copy\""), "{text}");

    // The copy is selected.
    edit_by_key(&mut demo, "Delete", "delete");
    assert!(settled(&mut demo) == before, "something is left of the copy");
    edit_by_key(&mut demo, "ctrl+z", "undo");
    assert!(settled(&mut demo) == two, "the copy has not come back");
    demo.discard_and_close();
}

/// Takes 50 seconds: that what is saved renders to the very picture is tried here alone in a quick run.
#[test]
fn objects_are_added() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    let mut demo = Demo::start(&server, &[&["cornell-box"][..], &SMALL].concat());
    let before = settled(&mut demo);
    demo.click_widget("Scene");
    demo.click_widget("Time");
    demo.click_widget("Lights and objects");
    demo.click_widget("add an object");
    let seen = demo.now();
    demo.click_widget("add sphere");
    demo.wait_after(seen, "addition", |event| is_action(event, "add-object"));
    demo.wait_after(seen, "the edited scene", |event| event["event"] == "scene");
    demo.screen().keep("30-sphere");
    let with_ball = settled(&mut demo);
    assert!(with_ball.difference(&before) > 1.0, "there is no ball");
    let file = saved(&mut demo);
    let text = fs::read_to_string(demo.path(&file)).unwrap();
    assert!(text.contains("primitive = \"sphere\""), "{text}");
    demo.assert_renders_to(
        &["render", "--out=rendered.png", "--frames=24", &file],
        "rendered.png",
        &with_ball,
    );
    edit_by_key(&mut demo, "ctrl+z", "undo");
    assert!(settled(&mut demo) == before, "something is left of the ball");
    demo.discard_and_close();
}

/// Presses a key, and waits until the renderer was built anew.
fn edit_by_key(demo: &mut Demo<'_>, key: &str, action: &str) {
    let seen = demo.now();
    demo.input(&["key", key]);
    demo.wait_after(seen, "action", |event| is_action(event, action));
    demo.wait_after(seen, "the edited scene", |event| event["event"] == "scene");
}
