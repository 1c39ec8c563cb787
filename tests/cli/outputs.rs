//! Where pictures go: standard output, files that are there already, folders without permission.

use std::fs;

use super::program::{Run, assert_fails, stderr};
use super::without_driver;

#[test]
fn standard_output_takes_the_picture_and_nothing_else() {
    let run = Run::new();
    let reference = ["reference", "cornell-box", "--size", "16x8", "--spp", "2"];
    let outputs = [
        run.render("cornell-box", &["--out", "-", "--frames", "2"]),
        run.glowworm(&[&reference[..], &["-o", "-"]].concat()),
    ];
    for output in outputs {
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let picture = image::load_from_memory_with_format(&output.stdout, image::ImageFormat::Png).unwrap();
        assert_eq!((picture.width(), picture.height()), (16, 8));
        assert!(stderr(&output).contains("note: standard output: "), "{}", stderr(&output));
    }
    assert!(run.files().is_empty());
    for (arguments, says) in [
        (&["render", "cornell-box", "-o", "-", "--layers"][..], "--layers needs an .exr"),
        (&["reference", "cornell-box", "-o", "-", "--resume"], "--resume: needs an .exr"),
        (&["export", "cornell-box", "-o", "-"], "--out -: must be a folder"),
    ] {
        assert_fails(&run.glowworm(arguments), 2, &[says]);
    }
}

#[test]
fn files_are_kept_on_request() {
    // Without a driver, anything after the check fails with another error.
    let run = without_driver();
    for name in ["a.png", "a.json", "f3.png"] {
        fs::write(run.path(name), "old").unwrap();
    }
    for arguments in [
        &["render", "cornell-box", "-o", "a.png"][..],
        &["render", "cornell-box", "-o", "b.png", "--json", "a.json"],
        &["reference", "cornell-box", "-o", "a.png"],
        &["export", "cornell-box", "-o", "b", "--json", "a.json"],
        &["info", "--passes", "--json", "a.json"],
    ] {
        let output = run.glowworm(&[arguments, &["--no-overwrite"]].concat());
        assert_fails(&output, 1, &[": is there already; give another name, or leave --no-overwrite out"]);
    }
    assert_eq!(run.files(), ["a.json", "a.png", "f3.png"]);
    let run = Run::new();
    fs::write(run.path("f3.png"), "old").unwrap();
    let sequence = ["--frames", "4", "--out", "f{frame}.png", "--no-overwrite"];
    assert_fails(&run.render("cornell-box", &sequence), 1, &["f3.png: is there already"]);
    assert_eq!(run.files(), ["f3.png"]);
    let output = run.render("cornell-box", &[&sequence[..], &["--frames", "2"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
}

#[cfg(unix)]
#[test]
fn read_only_pictures_are_refused() {
    use std::os::unix::fs::PermissionsExt;
    let run = without_driver();
    fs::write(run.path("a.png"), "old").unwrap();
    fs::set_permissions(run.path("a.png"), fs::Permissions::from_mode(0o444)).unwrap();
    assert_fails(&run.render("cornell-box", &[]), 1, &["a.png: is read-only"]);
    assert_eq!(fs::read(run.path("a.png")).unwrap(), b"old");
}

#[cfg(unix)]
#[test]
fn folders_without_permission_are_told_from_missing_ones() {
    use std::os::unix::fs::PermissionsExt;
    let run = without_driver();
    fs::create_dir(run.path("locked")).unwrap();
    fs::write(run.path("locked/a.obj"), "").unwrap();
    fs::set_permissions(run.path("locked"), fs::Permissions::from_mode(0o000)).unwrap();
    if fs::metadata(run.path("locked/a.obj")).is_ok() {
        eprintln!("skipped: this user may enter every folder");
    } else {
        let small = ["--size", "8x8", "--spp", "1", "--out", "a.png"];
        let output = run.glowworm(&[&["reference", "locked/a.obj"], &small[..]].concat());
        assert_fails(&output, 1, &["cannot read locked/a.obj: Permission denied"]);
        let output = run.render("cornell-box", &["--out", "locked/a.png"]);
        assert_fails(&output, 1, &["locked/a.png: cannot be written: Permission denied"]);
    }
    fs::set_permissions(run.path("locked"), fs::Permissions::from_mode(0o755)).unwrap();
}
