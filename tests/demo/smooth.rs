//! Frame pacing, and the cost of the panel.

use serde_json::Value;

use crate::ONE_AT_A_TIME;
use crate::window::{Demo, is_action, is_frame};
use crate::x_server::XServer;

/// Most sessions. Other load on the machine delays different frames each time, so the best run of each part of a session
/// counts.
const RUNS: usize = 5;
/// Limit of the longest frame over the median.
const LONGEST: f64 = 3.0;
/// Limit of the panel's fraction of a frame.
const PANEL_SHARE: f64 = 0.05;

/// A part of a session: what is done in it, and its first frame.
type Part = (&'static str, u64);

#[test]
#[ignore = "measures frame times, so it must run alone: ./test --test demo smooth -- --ignored"]
fn frames_are_even_while_one_scrubs_picks_edits_and_loads() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    // Longest frame over median of each part, and the panel's share of a frame; the least of all runs.
    let mut best: Option<(Vec<(&str, f64)>, f64)> = None;
    let is_even = |(parts, panel): &(Vec<(&str, f64)>, f64)| {
        parts.iter().all(|(_, longest)| *longest <= LONGEST) && *panel <= PANEL_SHARE
    };
    for _ in 0..RUNS {
        let (log, parts) = session(&server);
        let (mut run, mut panel) = judge(&log, &parts);
        if let Some((earlier, least)) = best {
            run.iter_mut().zip(&earlier).for_each(|(part, earlier)| part.1 = part.1.min(earlier.1));
            panel = panel.min(least);
        }
        let now = (run, panel);
        if is_even(&now) {
            return;
        }
        best = Some(now);
    }
    panic!("longest frames over the median, and the panel's share of a frame: {best:?}");
}

/// Scrubs, picks, edits and loads another scene while the animation plays: stationary frames are much cheaper and would
/// distort the median.
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
    demo.click_widget("Lights and objects");
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

/// Of each part, the longest frame over the median of all, apart from frames in which another scene appears; the share of the
/// panel in a frame.
fn judge(log: &Value, parts: &[Part]) -> (Vec<(&'static str, f64)>, f64) {
    let events = log["events"].as_array().unwrap();
    let number = |event: &Value| event["frame"].as_u64().unwrap();
    let swaps: Vec<u64> = events.iter().filter(|event| event["event"] == "scene").map(number).collect();
    let counts = |frame: u64| frame >= parts[0].1 && swaps.iter().all(|swap| frame.abs_diff(*swap) > 2);
    let frames: Vec<&Value> =
        events.iter().filter(|event| is_frame(event)).filter(|event| counts(number(event))).collect();
    let median = |key: &str| {
        let mut values: Vec<f64> = frames.iter().map(|frame| frame[key].as_f64().unwrap()).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let interval = median("interval_ms");
    let panel = (median("ui_cpu_ms") + median("ui_device_ms")) / interval;
    let ends = parts.iter().skip(1).map(|part| part.1).chain([u64::MAX]);
    let longest = parts.iter().zip(ends).map(|((part, begin), end)| {
        let within = frames.iter().filter(|frame| (*begin..end).contains(&number(frame)));
        let longest = within.map(|frame| frame["interval_ms"].as_f64().unwrap()).fold(0.0, f64::max);
        (*part, longest / interval)
    });
    let longest: Vec<(&str, f64)> = longest.collect();
    eprintln!("frames {}: median {interval:.1} ms, longest {longest:.2?}, panel {panel:.3}", frames.len());
    (longest, panel)
}
