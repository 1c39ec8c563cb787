//! Bad input gives a one-line error and leaves no files behind.

use std::fs;

use super::program::{Run, assert_fails};

#[test]
fn bad_input_is_one_line() {
    let run = Run::new();
    fs::write(run.path("file"), "").unwrap();
    fs::write(run.path("broken.toml"), "lights = 3").unwrap();
    fs::create_dir(run.path("taken")).unwrap();
    fs::write(run.path("taken/bench.json"), "[1, 2]").unwrap();
    for (arguments, code, says) in [
        (&["--frames", "0"][..], 2, "--frames"),
        (&["--rounds", "0"], 2, "--rounds"),
        (&["--temporal-sets", "1,x"], 2, "--temporal-sets"),
        (&["--temporal-sets", "1,65"], 2, "--temporal-sets 65: must be a whole number, 1 to 64"),
        (
            &["--temporal-sets", "1,16", "--vpls", "64,8"],
            2,
            "--temporal-sets is 16, but must be at most --vpls, which is 8",
        ),
        (&["--vpls", "8,0"], 2, "--vpls 0"),
        (&["--size", "8x8,0x9"], 2, "--size 0x9"),
        (&["--bounces", "2,17"], 2, "--bounces 17"),
        (&["--interleave", "9"], 2, "--interleave 9"),
        (&["--models"], 2, "--models"),
        (&["cornell-box"], 1, "cornell-box: another scene of that name"),
        (&["no-such-scene"], 1, "no-such-scene"),
        (&["broken.toml"], 1, "broken.toml"),
        (&["--out", "no/a"], 1, "there is no folder no"),
        (&["--out", "file"], 1, "file: is not a folder"),
        (&["--out", "taken"], 1, "taken/bench.json: is not a report of glowworm bench"),
        (&["--against", "missing.json"], 1, "missing.json: cannot be read"),
        (&["--against", "broken.toml"], 1, "broken.toml: is not a report"),
        (&["--json", "no/a.json"], 1, "no/a.json"),
        (&["--device", "77"], 1, "--device 77"),
    ] {
        assert_fails(&run.glowworm(&[&["bench", "cornell-box"], arguments].concat()), code, &[says]);
    }
    assert_eq!(run.files(), ["broken.toml", "file", "taken"]);
}

#[test]
fn bad_input_of_data_sets_is_one_line() {
    let run = Run::new();
    fs::create_dir(run.path("full")).unwrap();
    fs::write(run.path("full/a"), "").unwrap();
    fs::create_dir(run.path("odd")).unwrap();
    fs::write(run.path("odd/glowworm-dataset.json"), "7").unwrap();
    fs::write(run.path("file"), "").unwrap();
    for (arguments, code, says) in [
        (&[][..], 2, "--out"),
        (&["--out", "a", "--frames", "0"], 2, "--frames"),
        (&["--out", "a", "--spp", "x"], 2, "--spp"),
        (&["--out", "a", "--samples", "17"], 2, "--samples"),
        (&["--out", "a", "--size", "0x9"], 2, "--size 0x9"),
        (&["--out", "a", "--bounces", "-1"], 2, "--bounces"),
        (&["--out", "full"], 1, "full: is not empty"),
        (&["--out", "odd", "--resume"], 1, "odd/glowworm-dataset.json"),
        (&["--out", "no/a"], 1, "no/a"),
        (&["--out", "file"], 1, "file"),
    ] {
        assert_fails(&run.glowworm(&[&["dataset", "cornell-box"], arguments].concat()), code, &[says]);
    }
    assert_fails(&run.glowworm(&["dataset", "no-such-scene", "--out", "a"]), 1, &["no-such-scene"]);
    assert_eq!(run.files(), ["file", "full", "odd"]);
}
