use clap::{Args, Command};

use super::*;

/// What the command line `arguments` says over a scene file with `[settings]` `scene`.
fn resolve(scene: &str, arguments: &[&str]) -> Result<Settings, SettingsError> {
    use clap::FromArgMatches;
    let matches = Settings::augment_args(Command::new("test").no_binary_name(true))
        .try_get_matches_from(arguments)
        .unwrap();
    let cli = Settings::from_arg_matches(&matches).unwrap();
    Settings::resolve(&scene.parse().unwrap(), &cli, &given_options(&matches))
}

/// Whether the command line itself is refused.
fn refused(arguments: &[&str]) -> String {
    Settings::augment_args(Command::new("test").no_binary_name(true))
        .try_get_matches_from(arguments)
        .unwrap_err()
        .to_string()
}

#[test]
fn options_default_to_the_default() {
    assert_eq!(resolve("", &[]).unwrap(), Settings::default());
}

#[test]
fn each_field_is_an_option_and_a_key() {
    let keys: Vec<_> = toml::Table::try_from(Settings::default()).unwrap().keys().cloned().collect();
    let command = Settings::augment_args(Command::new("test"));
    let mut options: Vec<_> = command.get_arguments().map(|argument| argument.get_id().to_string()).collect();
    options.sort();
    let mut sorted_keys = keys.clone();
    sorted_keys.sort();
    assert_eq!(options, sorted_keys);
    for argument in command.get_arguments() {
        assert_eq!(Some(argument.get_id().as_str().replace('_', "-").as_str()), argument.get_long());
        assert!(argument.get_help().is_some(), "{} has no help", argument.get_id());
    }
}

#[test]
fn command_line_beats_scene_beats_default() {
    let scene = "vpls = 128\nbounces = 3\nexposure = 2.0\ntime_step = \"1/30\"\nsize = [64, 32]";
    let settings = resolve(scene, &["--bounces", "2", "--exposure", "auto", "--temporal-sets=4"]).unwrap();
    let expected = Settings {
        vpls: 128,
        bounces: 2,
        temporal_sets: 4,
        exposure: None,
        time_step: 1.0 / 30.0,
        size: [64, 32],
        ..Settings::default()
    };
    assert_eq!(settings, expected);
}

#[test]
fn options_are_read_in_every_way_of_writing() {
    let settings = resolve(
        "",
        &[
            "--size=640x360",
            "--time-step=0.5",
            "--exposure",
            "-1.5",
            "--tracer",
            "software",
            "--sequence",
            "random",
            "--missing-sets",
            "dark",
            "--clamp",
            "0",
            "--position-cutoff",
            "0.1",
            "--seed",
            "7",
            "--interleave",
            "1",
            "--budget",
            "3",
        ],
    )
    .unwrap();
    assert_eq!(settings.size, [640, 360]);
    assert_eq!(settings.time_step, 0.5);
    assert_eq!(settings.exposure, Some(-1.5));
    assert_eq!(settings.tracer, TracerKind::Software);
    assert_eq!(settings.sequence, Sequence::Random);
    assert_eq!(settings.missing_sets, MissingSets::Dark);
    assert_eq!((settings.clamp, settings.position_cutoff), (0.0, 0.1));
    assert_eq!((settings.seed, settings.interleave, settings.budget), (7, 1, 3));
    assert_eq!(resolve("", &["--time-step", "1/25"]).unwrap().time_step, 1.0 / 25.0);
}

#[test]
fn nonsense_is_refused_by_name() {
    for (arguments, says) in [
        (["--vpls", "many"], "must be a whole number"),
        (["--vpls", "-1"], "must be a whole number"),
        (["--vpls", "99999999999"], "must be a whole number"),
        (["--clamp", "much"], "must be a number"),
        (["--size", "640"], "must be a width and a height"),
        (["--size", "1x2x3"], "must be a width and a height"),
        (["--time-step", "1/"], "must be seconds"),
        (["--exposure", "bright"], "must be auto or stops"),
        (["--tracer", "magic"], "possible values: auto, software, hardware"),
        (["--missing-sets", "magic"], "possible values: scale, dark"),
    ] {
        let message = refused(&arguments);
        assert!(message.contains(arguments[0]) && message.contains(says), "{message}");
    }
}

#[test]
fn values_out_of_range_name_option_and_range() {
    for (arguments, message) in [
        (["--vpls", "0"], "--vpls 0: must be 1 to 65536"),
        (["--vpls", "65537"], "--vpls 65537: must be 1 to 65536"),
        (["--bounces", "17"], "--bounces 17: must be 1 to 16"),
        (["--interleave", "9"], "--interleave 9: must be 1 to 8"),
        (["--temporal-sets", "600"], "--temporal-sets 600: must be 1 to 64, and at most --vpls"),
        (["--budget", "0"], "--budget 0: must be at least 1"),
        (["--clamp", "-1"], "--clamp -1: must be a finite number of at least 0"),
        (["--clamp", "inf"], "--clamp inf: must be a finite number of at least 0"),
        (["--position-cutoff", "0"], "--position-cutoff 0: must be a finite number above 0"),
        (["--position-cutoff", "nan"], "--position-cutoff NaN: must be a finite number above 0"),
        (["--size", "0x0"], "--size 0x0: must be 1x1 to 16384x16384"),
        (["--size", "100000x100000"], "--size 100000x100000: must be 1x1 to 16384x16384"),
        (["--time-step", "1/0"], "--time-step inf: must be 0 to 1e9 seconds"),
        (["--time-step", "-1"], "--time-step -1: must be 0 to 1e9 seconds"),
        (["--exposure", "nan"], "--exposure NaN: must be auto or -64 to 64"),
    ] {
        let error = resolve("", &arguments).unwrap_err();
        assert_eq!(error.to_string(), message);
        assert!(error.is_usage(), "{message}");
    }
}

#[test]
fn bounds_are_in_range() {
    for arguments in [
        ["--vpls=65536", "--temporal-sets=64"],
        ["--vpls=1", "--temporal-sets=1"],
        ["--size=16384x16384", "--bounces=16"],
        ["--size=1x1", "--interleave=8"],
    ] {
        resolve("", &arguments).unwrap();
    }
}

#[test]
fn sets_need_vpls() {
    let error = resolve("", &["--vpls", "8"]).unwrap_err();
    assert!(error.is_usage() && error.to_string().contains("--temporal-sets is 16"), "{error}");
    let error = resolve("vpls = 8", &[]).unwrap_err();
    assert!(!error.is_usage(), "{error}");
}

#[test]
fn mistakes_of_a_scene_file_are_not_wrong_usage() {
    for (scene, says) in [
        ("vpls = 0", "[settings] vpls = 0: must be 1 to 65536"),
        ("vlps = 9", "vlps"),
        ("vpls = \"many\"", "vpls"),
        ("time_step = \"soon\"", "must be seconds"),
        ("exposure = \"bright\"", "must be auto or stops"),
        ("size = [1, 2, 3]", "size"),
    ] {
        let error = resolve(scene, &["--vpls", "64"]).unwrap_err();
        assert!(!error.is_usage(), "{error}");
        let message = error.to_string();
        assert!(message.contains(says) && !message.contains('\n'), "{message}");
    }
}

#[test]
fn a_report_can_be_read_back() {
    for exposure in [None, Some(1.5)] {
        let settings = Settings { exposure, ..Settings::default() };
        let json = serde_json::to_string(&settings).unwrap();
        assert_eq!(serde_json::from_str::<Settings>(&json).unwrap(), settings);
    }
}
