//! The tree of objects and the timeline: a ball gets keys, which are moved in time, posed, taken back and saved.

use std::fs;

use serde_json::Value;

use crate::ONE_AT_A_TIME;
use crate::window::{Demo, is_action};
use crate::x_server::XServer;

const SCENE: &str = "# A ball above a floor.
[[models]]
name = \"floor\"
primitive = \"quad\"
size = [4, 1, 4]
[[models]]
name = \"ball\"
primitive = \"sphere\"
size = [0.5, 0.5, 0.5]
[[instances]]
model = \"floor\"  # at the bottom
[[instances]]
name = \"left ball\"
model = \"ball\"
translation = [-0.7, 0.5, 0]
[[instances]]
name = \"right ball\"  # it stands
model = \"ball\"
translation = [0.7, 0.5, 0]
[[lights]]
type = \"point\"
position = [0, 3, 2]
intensity = [30, 30, 30]
[camera]
eye = [0, 1, 5]
target = [0, 0.5, 0]
";

/// Times of the keys that an edit of an instance leaves.
fn times(edit: &Value) -> Vec<f64> {
    let keys = edit["details"]["edit-instance"][1]["animation"]["keyframes"].as_array();
    keys.into_iter().flatten().map(|key| key["time"].as_f64().unwrap()).collect()
}

/// Does something, and waits for the edit that it makes.
fn edit(demo: &mut Demo<'_>, what: impl FnOnce(&mut Demo<'_>)) -> Value {
    let seen = demo.now();
    what(demo);
    demo.wait_after(seen, "edit", |event| is_action(event, "edit-instance"));
    demo.events()[seen..].iter().rfind(|event| is_action(event, "edit-instance")).unwrap().clone()
}

#[test]
#[ignore = "long; `visit` looks into it once"]
fn a_ball_gets_keys_on_the_timeline() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("balls.toml");
    fs::write(&file, SCENE).unwrap();
    let options =
        ["--antialiasing=none", "--reflections=none", "--indirect=none", "--size=480x640", "--validate"];
    let mut demo = Demo::start(&server, &[&[file.to_str().unwrap()][..], &options].concat());
    demo.key_for("space", "toggle-pause");

    // A search opens the branch of the balls.
    demo.click_widget("Scene");
    demo.click_widget("Lights and objects");
    demo.frames(3);
    assert!(demo.shows("branch ball") && !demo.shows("node right ball"));
    demo.click_widget("search");
    demo.input(&["type", "right"]);
    let seen = demo.now();
    demo.click_widget("node right ball");
    demo.wait_after(seen, "selection", |event| event["details"]["select"]["instance"] == 2);
    assert!(!demo.shows("branch floor"));

    // A key where the clock stands, and one in the middle of the timeline.
    demo.click_widget("add key");
    let seen = demo.now();
    demo.click_widget("scrub");
    let scrub = demo.wait_after(seen, "scrubbing", |event| is_action(event, "scrub"));
    let middle = scrub["details"]["scrub"].as_f64().unwrap();
    let added = edit(&mut demo, |demo| demo.click_widget("add key"));
    let [first, second] = times(&added)[..] else { panic!("{added}") };
    assert!(first < second && (second - middle).abs() < 0.01, "{added}");
    demo.settle();
    let before = demo.screen().picture();
    demo.screen().keep("31-keys");

    // The handle poses this key, not the other one.
    let posed = edit(&mut demo, |demo| demo.drag_picture([370, 320], [440, 320]));
    let keys = &posed["details"]["edit-instance"][1]["animation"]["keyframes"];
    assert!(keys[1]["translation"][0].as_f64() > Some(0.2) && keys[0]["translation"].is_null(), "{posed}");
    demo.settle();
    demo.screen().keep("32-key-posed");
    assert!(demo.screen().picture().difference(&before) > 0.2, "the ball has not moved");

    // It is dragged to a later time, but not past the other one; one step takes that back.
    let later = edit(&mut demo, |demo| demo.drag_widget("key 1", 40));
    assert!(times(&later)[0] == first && times(&later)[1] > second + 1.0, "{later}");
    let limited = edit(&mut demo, |demo| demo.drag_widget("key 1", -200));
    assert!((times(&limited)[1] - first - 0.01).abs() < 1e-6, "{limited}");
    demo.key_for("ctrl+z", "undo");

    // The file keeps its comments, and plays as the window does.
    let seen = demo.now();
    demo.key_for("ctrl+s", "ask-save");
    demo.frames(3);
    demo.input(&["key", "Return"]);
    let saved = demo.wait_after(seen, "saved", |event| event["event"] == "saved");
    let saved = demo.path(saved["details"].as_str().unwrap());
    let text = fs::read_to_string(&saved).unwrap();
    for part in ["# A ball above a floor.", "# at the bottom", "# it stands", "keyframes = [\n    { time = "]
    {
        assert!(text.contains(part), "{part} is missing:\n{text}");
    }
    let scene = glowworm::formats::load_scene(saved.to_str().unwrap(), None).unwrap();
    let keys = &scene.instances[2].animation.as_ref().unwrap().keyframes;
    assert_eq!([keys[0].time, keys[1].time], times(&later)[..]);

    let seen = demo.now();
    demo.click_widget("key 1");
    demo.wait_after(seen, "the key's time", |event| event["details"]["scrub"] == keys[1].time);
    let rest = edit(&mut demo, |demo| demo.click_widget("delete key"));
    assert_eq!(times(&rest), [first]);
    demo.discard_and_close();
}
