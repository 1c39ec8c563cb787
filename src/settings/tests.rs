//! How settings are read, checked, laid over each other and written.

use clap::{Args, Command};

use super::*;

/// Resolves the command line `arguments` over a scene file with `[settings]` `scene`.
fn resolve(scene: &str, arguments: &[&str]) -> Result<Settings, SettingsError> {
    use clap::FromArgMatches;
    let matches = Settings::augment_args(Command::new("test").no_binary_name(true))
        .try_get_matches_from(arguments)
        .unwrap();
    let cli = Settings::from_arg_matches(&matches).unwrap();
    Settings::resolve(&scene.parse().unwrap(), &cli, &given_options(&matches))
}

/// The error of a command line that clap rejects.
fn rejected(arguments: &[&str]) -> String {
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
        bounces: 2,
        vpl: VplSettings { slots: 128, temporal_sets: 4, ..VplSettings::default() },
        exposure: None,
        time_step: 1.0 / 30.0,
        size: [64, 32],
        ..Settings::default()
    };
    assert_eq!(settings, expected);
}

#[test]
fn options_are_parsed_in_every_syntax() {
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
            "--indirect",
            "none",
        ],
    )
    .unwrap();
    assert_eq!(settings.size, [640, 360]);
    assert_eq!(settings.time_step, 0.5);
    assert_eq!(settings.exposure, Some(-1.5));
    assert_eq!(settings.tracer, TracerKind::Software);
    assert_eq!(settings.indirect, Indirect::NONE);
    assert_eq!(settings.vpl.sequence, Sequence::Random);
    assert_eq!(settings.vpl.missing_sets, MissingSets::Dark);
    assert_eq!((settings.vpl.clamp, settings.vpl.position_cutoff), (0.0, 0.1));
    assert_eq!((settings.seed, settings.vpl.interleave, settings.vpl.budget), (7, 1, 3));
    assert_eq!(resolve("", &["--time-step", "1/25"]).unwrap().time_step, 1.0 / 25.0);
}

#[test]
fn invalid_values_name_their_option() {
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
        let message = rejected(&arguments);
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
        (["--svgf-alpha", "1.5"], "--svgf-alpha 1.5: must be 0 to 1"),
        (["--svgf-levels", "6"], "--svgf-levels 6: must be 0 to 5"),
        (["--svgf-depth", "0"], "--svgf-depth 0: must be a finite number above 0"),
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
fn errors_of_a_scene_file_are_not_wrong_usage() {
    for (scene, says) in [
        ("vpls = 0", "[settings] vpls = 0: must be 1 to 65536"),
        ("vlps = 9", "[settings] vlps: unknown setting; known are indirect, "),
        ("vpls = \"many\"", "[settings] vpls = many: must be a whole number"),
        ("vpls = 2.5", "[settings] vpls = 2.5: must be a whole number"),
        ("vpls = true", "[settings] vpls = true: must be a whole number"),
        ("vpls = \"\"", "[settings] vpls = : must be"),
        ("tracer = \"magic\"", "[settings] tracer = magic: must be one of auto, software, hardware"),
        ("time_step = \"soon\"", "must be seconds"),
        ("exposure = \"bright\"", "must be auto or stops"),
        ("size = [1, 2, 3]", "[settings] size = [1, 2, 3]: must be a width and a height"),
        ("size = \"9\"", "[settings] size = 9: must be a width and a height"),
        ("[vpls]\nvpls = 0", "[settings] vpls = 0: must be 1 to 65536"),
        (
            "[vpls]\nvlps = 9",
            "[settings.vpls] vlps: unknown setting; known are vpls, pool, candidates, interleave",
        ),
        ("[vpls]\nseed = 9", "[settings.vpls] seed: belongs in [settings]"),
        ("[vpls]\nvpls = { vpls = 9 }", "[settings.vpls] vpls: must be a value, not a table"),
        ("[lamps]\nvpls = 9", "[settings.lamps]: unknown table; known are [settings], [settings.effects], "),
        ("[seed]\nseed = 9", "[settings.seed]: unknown table; known are [settings], [settings.effects], "),
        ("svgf_separable = \"perhaps\"", "[settings] svgf_separable = perhaps: must be one of true, false"),
        ("budget = 9\n[vpls]\nbudget = 9", "budget: is set twice"),
    ] {
        let error = resolve(scene, &["--vpls", "64"]).unwrap_err();
        assert!(!error.is_usage(), "{error}");
        let message = error.to_string();
        assert!(message.contains(says) && !message.contains('\n'), "{message}");
    }
}

#[test]
fn settings_round_trip_through_json() {
    for exposure in [None, Some(1.5)] {
        let settings = Settings { exposure, ..Settings::default() };
        let json = serde_json::to_string(&settings).unwrap();
        assert!(json.contains(r#""indirect":"vpls""#) && json.contains(r#""vpls":512"#), "{json}");
        assert_eq!(serde_json::from_str::<Settings>(&json).unwrap(), settings);
    }
}

/// A non-default value of each option, in the syntax of the command line.
const NON_DEFAULTS: [(&str, &str); 38] = [
    ("indirect", "none"),
    ("direct", "rays"),
    ("reflections", "none"),
    ("antialiasing", "none"),
    ("bounces", "3"),
    ("size", "256x144"),
    ("seed", "7"),
    ("time_step", "1/25"),
    ("tracer", "software"),
    ("exposure", "-1.5"),
    ("denoise", "none"),
    ("noise", "white"),
    ("reflection_depth", "1"),
    ("reflection_roughness", "0.4"),
    ("svgf_alpha", "0.1"),
    ("svgf_moments_alpha", "0.3"),
    ("svgf_history", "16"),
    ("svgf_clamp", "1.5"),
    ("svgf_firefly", "5"),
    ("svgf_levels", "3"),
    ("svgf_feedback", "2"),
    ("svgf_separable", "true"),
    ("svgf_adaptive", "false"),
    ("svgf_reinhard", "true"),
    ("svgf_depth", "2"),
    ("svgf_normal", "64"),
    ("svgf_luminance", "8"),
    ("vpls", "64"),
    ("pool", "600"),
    ("candidates", "3"),
    ("interleave", "2"),
    ("temporal_sets", "8"),
    ("budget", "5"),
    ("refresh", "3"),
    ("clamp", "12.5"),
    ("position_cutoff", "0.3"),
    ("sequence", "random"),
    ("missing_sets", "dark"),
];

#[test]
fn a_scene_file_accepts_the_syntax_of_the_command_line() {
    assert_eq!(NON_DEFAULTS.len(), Settings::default().to_table().len());
    for (key, text) in NON_DEFAULTS {
        let option = resolve("", &[&format!("--{}={text}", key.replace('_', "-"))]).unwrap();
        assert_ne!(option, Settings::default(), "{key}");
        assert_eq!(resolve(&format!("{key} = \"{text}\""), &[]).unwrap(), option, "{key}");
        let differing = option.differing();
        assert_eq!(differing.keys().collect::<Vec<_>>(), [key]);
        assert_eq!(Settings::from_table(&differing), Ok(option), "{key}");
    }
}

#[test]
fn a_group_may_be_a_subtable() {
    let [root, effects, svgf, vpls] = groups().try_into().unwrap();
    assert_eq!((root.table.as_str(), root.heading.as_str()), ("settings", "Settings"));
    assert_eq!([&effects.table, &svgf.table], ["settings.effects", "settings.svgf"]);
    assert_eq!(vpls.table, "settings.vpls");
    assert_eq!(vpls.heading, "Virtual point lights (--indirect vpls)");
    let keys: Vec<_> = NON_DEFAULTS.map(|(key, _)| key).into();
    assert_eq!([root.settings, effects.settings, svgf.settings, vpls.settings.clone()].concat(), keys);

    let line = |key: &str| {
        let (_, text) = NON_DEFAULTS.iter().find(|(other, _)| *other == key).unwrap();
        format!("{key} = \"{text}\"\n")
    };
    let flat: String = keys.iter().map(|key| line(key)).collect();
    let shared: String =
        keys.iter().filter(|key| !vpls.settings.iter().any(|of| of == *key)).map(|key| line(key)).collect();
    let own: String = vpls.settings.iter().map(|key| line(key)).collect();
    let settings = resolve(&flat, &[]).unwrap();
    assert_eq!(settings.differing().len(), keys.len());
    assert_eq!(resolve(&format!("{shared}[vpls]\n{own}"), &[]).unwrap(), settings);
    let over = resolve("[vpls]\nvpls = 300\nbudget = 3", &["--vpls", "200"]).unwrap();
    assert_eq!((over.vpl.slots, over.vpl.budget), (200, 3));
}
