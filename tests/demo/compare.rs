//! Frame rates of temporal sets, measured in the window: progress, cancel, table, and the report of `bench`.

use glowworm::bench::{Noise, Summary, read_report};
use serde_json::Value;

use crate::ONE_AT_A_TIME;
use crate::window::{Demo, is_action};
use crate::x_server::XServer;

const SMALL: [&str; 7] = [
    "cornell-box",
    "--antialiasing=none",
    "--reflections=none",
    "--size=640x400",
    "--vpls=64",
    "--bounces=2",
    "--validate",
];

#[test]
#[ignore = "long; `visit` looks into it once"]
fn the_frame_rate_of_temporal_sets_is_measured_shown_and_saved() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    let mut demo = Demo::start(&server, &SMALL);
    demo.resize(700, 260);
    demo.frames(6);
    let seen = demo.now();
    demo.key_for("F3", "toggle-compare");
    // It takes as long as it takes, but the window goes on.
    while !demo.events()[seen..].iter().any(|event| event["event"] == "compared") {
        demo.frames(1);
    }
    let compared = demo.wait_after(seen, "measurements", |event| event["event"] == "compared");
    let rows: Vec<Value> = compared["details"].as_array().unwrap().clone();
    let names: Vec<&str> = rows.iter().map(|row| row["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["vpls@T=1", "vpls@T=1 (half)", "vpls@T=4", "vpls@T=8", "vpls@T=16", "vpls@T=32"]);
    let number = |row: &Value, key: &str| row[key].as_f64().unwrap();
    assert_eq!(number(&rows[0], "flip"), 0.0, "each is compared with the first");
    assert!(rows[1..].iter().all(|row| number(row, "flip") > 0.0), "{rows:?}");
    assert!(number(&rows[4], "fps") > 1.2 * number(&rows[0], "fps"), "{rows:?}");
    assert!(rows.iter().all(|row| row["settings"]["size"] == rows[0]["settings"]["size"]), "{rows:?}");
    demo.screen().keep("30-compare");

    // A click on a row switches to it, and the picture keeps its size.
    let seen = demo.now();
    demo.click_widget("compared vpls@T=4");
    let set = demo.wait_after(seen, "four sets", |event| is_action(event, "set"));
    assert_eq!(set["details"]["set"]["temporal_sets"], 4);
    assert_eq!(set["details"]["set"]["size"], rows[0]["settings"]["size"]);

    // The report is that of `bench`.
    let seen = demo.now();
    demo.click_widget("compare: Save report");
    let saved = demo.wait_after(seen, "the report", |event| event["event"] == "saved");
    let folder = demo.path(saved["details"].as_str().unwrap()).parent().unwrap().to_owned();
    let report = read_report(&folder.join("bench.json")).unwrap();
    let noise = Noise::of(&report.runs);
    let fps: Vec<f64> =
        report.runs.iter().map(|run| Summary::of(run, &noise).unwrap().median("fps")).collect();
    assert_eq!(fps, rows.iter().map(|row| number(row, "fps")).collect::<Vec<_>>());
    for file in ["report.html", "bench.csv", "scene.toml"] {
        assert!(folder.join(file).is_file(), "{file}");
    }

    // A measurement can be cancelled, and the window goes on.
    let seen = demo.now();
    demo.click_widget("compare: Measure again");
    demo.wait_after(seen, "another one", |event| is_action(event, "compare"));
    let seen = demo.now();
    demo.click_widget("compare: Cancel");
    demo.wait_after(seen, "its end", |event| is_action(event, "compare"));
    demo.frames(4);
    demo.close();
}
