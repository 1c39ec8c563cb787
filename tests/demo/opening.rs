//! Scenes are opened while another is shown: by name, by drop, and broken ones.

use std::fs;

use crate::ONE_AT_A_TIME;
use crate::window::Demo;
use crate::x_server::XServer;

#[test]
#[ignore = "long; `visit` looks into it once"]
fn a_broken_scene_changes_nothing_and_a_dropped_one_opens() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    let mut demo = Demo::start(
        &server,
        &[
            "--antialiasing=none",
            "--reflections=none",
            "--size",
            "480x300",
            "--vpls=64",
            "--temporal-sets=4",
            "--validate",
        ],
    );
    demo.key_for("space", "toggle-pause");
    demo.frames(12);
    let before = demo.screen().picture();

    // The error is in the second line of the file; the current scene stays.
    fs::write(demo.path("broken.toml"), "name = \"broken\"\nlight = 3\n").unwrap();
    let seen = demo.now();
    demo.click_widget("path");
    demo.input(&["type", "broken.toml"]);
    demo.input(&["key", "Return"]);
    let failed = demo.wait_after(seen, "failure", |event| event["event"] == "scene-failed");
    let said = failed["details"].as_str().unwrap();
    assert!(said.contains("broken.toml:2") && said.contains("light"), "{said}");
    let after = demo.screen();
    after.keep("10-broken");
    demo.click_widget("dismiss");
    let after = demo.screen();
    assert!(after.picture() == before, "a broken scene changes the picture");

    // A good one, dropped; a space in its name is percent-encoded on the way.
    let scene = "[[models]]\nname = \"ball\"\nprimitive = \"sphere\"\n\n[[instances]]\nmodel = \"ball\"\n\n\
                 [[lights]]\ntype = \"point\"\nposition = [3, 3, 3]\nintensity = [20, 20, 20]\n";
    fs::write(demo.path("a ball.toml"), scene).unwrap();
    let seen = demo.now();
    demo.drop_file(&demo.path("a%20ball.toml"));
    let opened = demo.wait_after(seen, "dropped scene", |event| event["event"] == "scene");
    assert!(opened["details"]["name"].as_str().unwrap().ends_with("a ball.toml"), "{opened}");
    let dropped = demo.screen();
    dropped.keep("11-dropped");
    assert!(dropped.picture().difference(&before) > 5.0, "the dropped scene is not seen");
    demo.close();
}
