//! Every method is chosen in turn while lights move.

use serde_json::Value;

use crate::ONE_AT_A_TIME;
use crate::window::{Demo, is_action};
use crate::x_server::XServer;

/// Menu in the bar, method, and the setting that it is of.
const METHODS: [(&str, &str, &str); 9] = [
    ("method of direct light", "soft", "direct"),
    ("method of reflections", "rays", "reflections"),
    ("method", "none", "indirect"),
    ("method of direct light", "hard", "direct"),
    ("method", "paths", "indirect"),
    ("denoiser", "bmfr", "denoise"),
    ("denoiser", "svgf", "denoise"),
    ("method", "vpls", "indirect"),
    ("method of reflections", "none", "reflections"),
];

#[test]
#[ignore = "long; `visit` looks into it once"]
fn every_method_is_chosen_in_turn_while_lights_move() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    let arguments = ["--reflections=none", "--size=320x180", "--vpls=64", "--bounces=2", "--validate"];
    let mut demo = Demo::start(&server, &arguments);
    demo.frames(12);
    for (menu, method, setting) in METHODS {
        demo.click_widget(menu);
        let seen = demo.now();
        demo.click_widget(&format!("{menu} {method}"));
        let set = demo.wait_after(seen, method, |event| is_action(event, "set"));
        assert_eq!(set["details"]["set"][setting], method, "{set}");
        let takes_vpls = set["details"]["set"]["indirect"] == "vpls";
        demo.wait_after(seen, "a frame by it", |event| has_passes(event, takes_vpls));
        demo.frames(6);
        let before = demo.screen().picture();
        before.keep(&format!("24-{menu}-{method}"));
        let [red, green, blue] = before.mean();
        assert!(red.min(green).min(blue) > 5.0, "{menu} {method}: black");
        assert!(before.colours() > 1000, "{menu} {method}: {} colours", before.colours());
        // The swaying light lights something else by now.
        demo.frames(6);
        assert!(demo.screen().picture().difference(&before) > 0.5, "{menu} {method}: nothing moves");
    }
    demo.close();
}

/// Whether the passes of a frame draw light of VPLs, or not.
fn has_passes(event: &Value, vpls: bool) -> bool {
    let passes = &event["measured"]["passes"];
    passes.is_object() && passes.get("indirect_shading").is_some() == vpls
}
