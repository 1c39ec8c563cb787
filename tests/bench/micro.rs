//! Micro-benchmarks: tables against JSON, tracers against each other, ray sets against those of a real frame.

use std::fs;

use glowworm::bench::micro::{
    Contender, Obvhs, OwnTracer, Query, RayKind, ShaderTracer, differing, ray_sets,
};
use glowworm::renderer::PreparedScene;
use glowworm::settings::{Settings, VplSettings};
use serde_json::Value;

use super::program::{PASS_NAMES, Run, assert_fails, stderr};
use super::support::{GpuFixture, named_scene};

fn small(run: &Run, scene: &str) -> (String, Value) {
    let output = run.glowworm(&[
        "bench",
        "--micro",
        scene,
        "--antialiasing=none",
        "--size",
        "32x24",
        "--vpls",
        "64",
        "--rays",
        "3000",
        "--rounds",
        "2",
        "--out",
        "a",
        "--json",
        "b.json",
        "--validate",
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let report = fs::read_to_string(run.path("a/micro.json")).unwrap();
    assert_eq!(fs::read_to_string(run.path("b.json")).unwrap(), report);
    (String::from_utf8(output.stdout).unwrap(), serde_json::from_str(&report).unwrap())
}

/// The cells of the line that begins with these.
fn line<'t>(text: &'t str, cells: &[&str]) -> Vec<&'t str> {
    let split = |line: &'t str| -> Vec<&'t str> {
        line.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect()
    };
    let mut lines = text.lines().map(split).filter(|line| line.starts_with(cells));
    lines.next().unwrap_or_else(|| panic!("no line {cells:?} in {text}"))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

#[test]
fn the_table_says_what_the_json_says() {
    let run = Run::new();
    let (text, report) = small(&run, "cornell-box");
    assert_eq!(report["format"], "glowworm bench micro 1");
    let scene = &report["scenes"][0];
    let runs = scene["rays"].as_array().unwrap();
    assert_eq!(runs.len(), RayKind::ALL.len() * Query::ALL.len());
    for run in runs {
        let rays = format!("{} ({})", run["kind"].as_str().unwrap(), run["rays"]);
        for (index, tracer) in run["tracers"].as_array().unwrap().iter().enumerate() {
            let name = tracer["tracer"].as_str().unwrap();
            let cells = line(&text, &[&rays, run["query"].as_str().unwrap(), name]);
            assert_eq!(cells[3], format!("{:.2}", number(&tracer["spread"]["median"])), "{rays} {name}");
            assert_eq!(cells[6], tracer["differing"].to_string());
            // The median is that of the rates, and a tracer's speed relative to itself is 1.
            let rates: Vec<f64> = tracer["rates"].as_array().unwrap().iter().map(number).collect();
            assert!(rates.len() == 2 && rates.contains(&number(&tracer["spread"]["median"])));
            assert_eq!(cells[7 + index], "1.00");
            for (other, cell) in run["tracers"].as_array().unwrap().iter().zip(&cells[7..]) {
                let over = &tracer["over"][other["tracer"].as_str().unwrap()];
                assert_eq!(*cell, format!("{:.2}", number(over)));
            }
        }
        assert!(number(&run["hit_share"]) > 0.05, "{run}");
    }
    let times = scene["times"].as_array().unwrap();
    let passes = PASS_NAMES.map(|name| [format!("{name}, still"), format!("{name}, moving")]).concat();
    for what in ["BVH build".to_owned(), "BVH upload".to_owned()].into_iter().chain(passes) {
        let time = times.iter().find(|time| time["what"] == *what).unwrap();
        assert_eq!(line(&text, &[&what])[1], format!("{:.3}", number(&time["spread"]["median"])), "{what}");
    }
    let ms =
        |what: &str| number(&times.iter().find(|time| time["what"] == what).unwrap()["spread"]["median"]);
    for pass in ["gbuffer", "direct_shading", "indirect_shadows"] {
        assert!(ms(&format!("{pass}, still")) > 0.0 && ms(&format!("{pass}, moving")) > 0.0, "{pass}");
    }
    assert!(line(&text, &["BVH update, 100 moving"]).len() == 4);
    let page = fs::read_to_string(run.path("a/micro.md")).unwrap();
    assert!(page.contains("## Rays of cornell-box") && page.contains("## Times of crowd in ms"), "{page}");
}

#[test]
fn only_what_knows_masks_casts_rays_at_them() {
    let run = Run::new();
    let (text, report) = small(&run, "atrium-drapery");
    let tracers = report["scenes"][0]["rays"][0]["tracers"].as_array().unwrap();
    let names: Vec<_> = tracers.iter().filter_map(|tracer| tracer["tracer"].as_str()).collect();
    // The last one if the device has ray queries.
    let ours = ["glowworm, CPU", "glowworm, shader", "ray queries"];
    assert!(names.len() >= 2 && ours.starts_with(&names), "{text}");
    assert!(report["scenes"][0]["notes"][0].as_str().unwrap().contains("alpha masks"));
}

#[test]
fn options_that_do_not_go_together_are_refused() {
    let run = Run::new();
    for (arguments, says) in [
        (&["--micro", "--quality"][..], "--quality"),
        (&["--micro", "--frames", "3"], "--frames"),
        (&["--micro", "--resume"], "--resume"),
        (&["--micro", "--rays", "0"], "--rays"),
        (&["--rays", "5"], "--micro"),
    ] {
        assert_fails(&run.glowworm(&[&["bench", "cornell-box"], arguments].concat()), 2, &[says]);
    }
    assert!(run.files().is_empty());
}

#[test]
fn all_tracers_answer_alike() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("playroom", None);
    let pose = scene.pose(0.0);
    let prepared = PreparedScene::new(&scene);
    let settings = Settings { size: [128, 128], ..Settings::default() };
    let sets = ray_sets(&prepared, &pose, &settings, 20_000);
    let mut own = OwnTracer(prepared.bvh());
    let mut shaders = ShaderTracer::all(&gpu.device, prepared.bvh()).unwrap();
    let mut obvhs = Obvhs::new(&scene, &pose).unwrap();
    for (set, query) in sets.iter().flat_map(|set| Query::ALL.map(|query| (set, query))) {
        let expected = own.cast(set, query).unwrap().answers;
        assert!(expected.len() > 5_000 && expected.iter().any(|answer| *answer >= 0.0));
        let mut tracers: Vec<&mut dyn Contender> = vec![&mut obvhs];
        tracers.extend(shaders.iter_mut().map(|tracer| tracer as &mut dyn Contender));
        for tracer in tracers {
            let cast = tracer.cast(set, query).unwrap();
            assert!(cast.seconds > 0.0);
            // The other library's triangle test is less exact at edges.
            let differing = differing(&expected, &cast.answers);
            assert!(differing <= 3, "{}, {set:?}, {query:?}: {differing}", tracer.name());
        }
    }
}

#[test]
fn shadow_rays_are_those_of_real_frames() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("cornell-box", None);
    let pose = scene.pose(0.0);
    for interleave in [1, 4] {
        let settings = Settings {
            size: [72, 56],
            still_frames: 0,
            vpl: VplSettings { slots: 64, temporal_sets: 1, interleave, ..VplSettings::default() },
            ..Settings::default()
        };
        let mut renderer = gpu.rendered(&scene, &settings, 1);
        let cast = renderer.finish().unwrap()[0].figures.counters.get("shadow_rays");
        let sets = ray_sets(&PreparedScene::new(&scene), &pose, &settings, 1 << 20);
        let rays = sets.iter().find(|set| set.kind == RayKind::Shadow).unwrap().rays.len();
        // A frame draws only what faces its pixels, and casts short rays besides.
        let cast = cast as usize;
        assert!(rays < cast && cast < 2 * rays, "{rays}, and {cast} in a frame");
        assert!(rays > 10_000 / (interleave * interleave) as usize);
    }
}
