//! How settings are declared, read, checked, laid over each other and written.

use clap::{Args, Command, FromArgMatches, ValueEnum};
use toml::Value;

use super::*;

fn command() -> Command {
    GivenSettings::augment_args(Command::new("test").no_binary_name(true))
}

/// The settings that a command line gives, or its error.
fn given(arguments: &[&str]) -> Result<GivenSettings, String> {
    let matches = command().try_get_matches_from(arguments).map_err(|error| error.to_string())?;
    GivenSettings::from_arg_matches(&matches).map_err(|error| error.to_string())
}

/// Resolves the command line `arguments` over a scene file with `[settings]` `scene`.
fn resolve(scene: &str, arguments: &[&str]) -> Result<Settings, SettingsError> {
    Settings::resolve(&scene.parse().unwrap(), &given(arguments).unwrap())
}

/// Texts that a setting accepts, its bounds among them, and texts that it refuses.
fn samples(kind: Kind) -> (Vec<String>, Vec<String>) {
    let texts = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>();
    match kind {
        Kind::Whole { least, most, .. } => {
            let below = i64::from(least) - 1;
            let above = u64::from(most) + 1;
            (
                [least, most, least.midpoint(most)].map(|value| value.to_string()).into(),
                [texts(&["many", "", "2.5", "true"]), vec![below.to_string(), above.to_string()]].concat(),
            )
        }
        Kind::Number { least, most, above, .. } => {
            let mut taken = vec![(least + 0.125).to_string()];
            let mut refused = [texts(&["much", "", "nan", "inf"]), vec![(least - 0.5).to_string()]].concat();
            (if above { &mut refused } else { &mut taken }).push(least.to_string());
            if most.is_finite() {
                taken.push(most.to_string());
                refused.push((most + 0.5).to_string());
            }
            (taken, refused)
        }
        Kind::Seconds { most } => (
            [texts(&["0", "1/25", "0.5"]), vec![most.to_string()]].concat(),
            [texts(&["soon", "1/", "1/0", "-1", "nan"]), vec![(2.0 * most).to_string()]].concat(),
        ),
        Kind::Auto(kind) => {
            let (taken, refused) = samples(*kind);
            ([taken, texts(&["auto"])].concat(), refused)
        }
        Kind::Size { most } => (
            [texts(&["1x1", "256X144"]), vec![format!("{most}x{most}")]].concat(),
            [texts(&["640", "1x2x3", "big", "0x9", "9x0"]), vec![format!("{}x9", most + 1)]].concat(),
        ),
        Kind::Features => (
            texts(&["1", "nx,wx*wx,sqrt(wy)*d"]),
            texts(&["", "1,", "q", "nx*ny*nz*wx", &["1"; 65].join(",")]),
        ),
        Kind::Flag | Kind::Choice(_) => {
            let names = kind.choices().iter().map(|choice| choice.get_name().to_owned()).collect();
            (names, texts(&["magic", "", "1"]))
        }
    }
}

/// Walks all descriptors: a setting needs nothing but its declaration.
#[test]
fn a_declaration_makes_option_key_range_and_help() {
    let help = command().render_long_help().to_string();
    let page = include_str!("../../docs/OPTIONS.md");
    let defaults = Settings::default();
    for setting in all() {
        let option = format!("--{}", setting.option());
        assert!(help.contains(&option), "{option}");
        assert!(page.contains(&format!("| `{option}")), "{option} is not in docs/OPTIONS.md");
        assert!(setting.full_help().len() > 40, "{option}: {}", setting.full_help());
        let (taken, refused) = samples(setting.kind);
        for text in taken.iter().chain([&setting.text(&defaults)]) {
            let settings =
                Settings::from_table(given(&[&format!("{option}={text}")]).unwrap().table()).unwrap();
            // A scene file accepts the syntax of the command line, and what is written.
            let written = format!("{} = {}", setting.key, setting.value(&settings));
            for table in [written, format!("{} = \"{text}\"", setting.key)] {
                assert_eq!(Settings::from_table(&table.parse().unwrap()), Ok(settings.clone()), "{table}");
            }
            let json = serde_json::to_string(&settings).unwrap();
            assert_eq!(serde_json::from_str::<Settings>(&json).unwrap(), settings, "{json}");
            assert_eq!(Settings::from_table(&settings.differing()), Ok(settings.clone()), "{option} {text}");
            assert!(settings.differing().keys().all(|key| key == setting.key));
        }
        // At least one of the values is not the default, and reaches the field.
        assert!(taken.iter().any(|text| {
            let mut changed = defaults.clone();
            setting.set(&mut changed, text).is_ok() && changed != defaults
        }));
        for text in refused {
            let message = given(&[&format!("{option}={text}")]).unwrap_err();
            assert!(message.contains(&option), "{message}");
            let table = toml::Table::from_iter([(setting.key.to_owned(), Value::String(text.clone()))]);
            let error = Settings::from_table(&table).unwrap_err();
            let expected = format!("[settings] {} = {text}: must be {}", setting.key, setting.kind);
            assert_eq!(error.to_string(), expected);
            assert!(!error.is_usage());
        }
    }
}

#[test]
fn keys_are_unique_and_in_one_group() {
    let mut keys: Vec<_> = all().map(|setting| setting.key).collect();
    keys.sort_unstable();
    assert!(keys.windows(2).all(|pair| pair[0] != pair[1]), "{keys:?}");
    assert_eq!(GROUPS[0].table, "settings");
    assert!(GROUPS[1..].iter().all(|group| group.table.starts_with("settings.")));
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
    assert_eq!(resolve("", &[]).unwrap(), Settings::default());
}

#[test]
fn options_set_their_fields() {
    let settings =
        resolve("", &["--clamp", "0", "--exposure", "-1.5", "--sequence=random", "--seed=7"]).unwrap();
    assert_eq!((settings.vpl.clamp, settings.exposure, settings.seed), (0.0, Some(-1.5), 7));
    assert_eq!(settings.vpl.sequence, Sequence::Random);
    let names = |kind: Kind| kind.choices().iter().map(|of| of.get_name().to_owned()).collect::<Vec<_>>();
    assert_eq!(names(find("denoise").unwrap().kind), ["svgf", "bmfr", "none"]);
    assert_eq!(names(find("direct").unwrap().kind), ["auto", "hard", "soft", "paths"]);
    assert_eq!(names(find("tracer").unwrap().kind), ["auto", "software", "hardware"]);
}

#[test]
fn what_is_out_of_range_is_found_by_a_check() {
    let mut settings = Settings { bounces: 17, ..Settings::default() };
    let error = settings.check().unwrap_err();
    assert_eq!(error.to_string(), "--bounces 17: must be a whole number, 1 to 16");
    settings.bounces = 16;
    assert_eq!(settings.check(), Ok(()));
    settings.vpl.slots = 8;
    assert!(settings.check().is_err());
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
        ("vpls = 0", "[settings] vpls = 0: must be a whole number, 1 to 65536"),
        ("vlps = 9", "[settings] vlps: unknown setting; known are preset, indirect, "),
        ("vpls = 2.5", "[settings] vpls = 2.5: must be a whole number"),
        ("vpls = true", "[settings] vpls = true: must be a whole number"),
        ("direct = \"maps\"", "[settings] direct = maps: must be one of auto, hard, soft, paths"),
        ("size = [1, 2, 3]", "[settings] size = [1, 2, 3]: must be a width and a height"),
        ("[vpls]\nvpls = 0", "[settings] vpls = 0: must be a whole number, 1 to 65536"),
        (
            "[vpls]\nvlps = 9",
            "[settings.vpls] vlps: unknown setting; known are vpls, pool, candidates, interleave",
        ),
        ("[vpls]\nseed = 9", "[settings.vpls] seed: belongs in [settings]"),
        ("[vpls]\nvpls = { vpls = 9 }", "[settings.vpls] vpls: must be a value, not a table"),
        ("[lamps]\nvpls = 9", "[settings.lamps]: unknown table; known are [settings], [settings.effects], "),
        ("[seed]\nseed = 9", "[settings.seed]: unknown table; known are [settings], [settings.effects], "),
        ("budget = 9\n[vpls]\nbudget = 9", "budget: is set twice"),
    ] {
        // The mistake counts even where an option overrides it.
        let error = resolve(scene, &["--vpls", "64"]).unwrap_err();
        assert!(!error.is_usage(), "{error}");
        let message = error.to_string();
        assert!(message.contains(says) && !message.contains('\n'), "{message}");
    }
}

#[test]
fn reports_have_plain_numbers() {
    let json = serde_json::to_string(&Settings { exposure: Some(1.5), ..Settings::default() }).unwrap();
    for part in [r#""indirect":"vpls""#, r#""vpls":512"#, r#""svgf_alpha":0.05"#, r#""exposure":1.5"#] {
        assert!(json.contains(part), "{part}: {json}");
    }
}

#[test]
fn a_group_may_be_a_subtable() {
    let over = resolve("[vpls]\nvpls = 300\nbudget = 3", &["--vpls", "200"]).unwrap();
    assert_eq!((over.vpl.slots, over.vpl.budget), (200, 3));
    for group in &GROUPS[1..] {
        let settings = group.settings.iter().map(|setting| {
            let (taken, _) = samples(setting.kind);
            (setting.key.to_owned(), Value::String(taken[0].clone()))
        });
        let own = toml::Table::from_iter(settings);
        let name = group.table.trim_start_matches("settings.").to_owned();
        let grouped = toml::Table::from_iter([(name, Value::Table(own.clone()))]);
        assert_eq!(Settings::from_table(&grouped), Settings::from_table(&own));
    }
}

#[test]
fn a_preset_comes_before_other_settings_and_leaves_what_the_picture_is_of() {
    let scene = "vpls = 300\nbounces = 5\nsize = [64, 32]\nexposure = 1.0";
    // The command line's presets change what the scene file sets, but not what stands beside them.
    let settings = resolve(scene, &["--temporal-sets", "4", "--preset", "tonna"]).unwrap();
    let tonna =
        Settings { size: [64, 32], exposure: Some(1.0), ..Settings::default() }.with_preset(Preset::Tonna);
    let vpl = VplSettings { temporal_sets: 4, ..tonna.vpl };
    assert_eq!(settings, Settings { vpl, ..tonna });
    assert_eq!((settings.bounces, settings.vpl.slots, settings.indirect), (2, 512, Indirect::TONNA));
    // A scene file's own come first, too, wherever they stand.
    let settings = resolve("filter = \"hpsf\"\npreset = \"meijer\"", &[]).unwrap();
    assert_eq!((settings.paths.filter, settings.bounces), (PathFilter::Hpsf, 1));
    assert_eq!(resolve("preset = \"granja\"", &["--preset", "default"]).unwrap(), Settings::default());
}

#[test]
fn settings_are_written_as_a_preset_and_what_differs() {
    for preset in <Preset as clap::ValueEnum>::value_variants() {
        let base = Settings { seed: 7, ..Settings::default() }.with_preset(*preset);
        assert_eq!(base.check(), Ok(()), "{preset:?}");
        // At its default, but not that of the preset.
        let settings = Settings { still_frames: 1024, bounces: 2, ..base };
        assert_eq!(Settings::from_table(&settings.differing()).unwrap(), settings, "{preset:?}");
        let json = serde_json::to_string(&settings).unwrap();
        assert_eq!(serde_json::from_str::<Settings>(&json).unwrap(), settings, "{preset:?}");
        let name = preset.to_possible_value().unwrap().get_name().to_owned();
        assert!(json.contains(&format!("\"preset\":\"{name}\"")), "{json}");
    }
}

#[test]
fn whole_numbers_may_have_an_exponent() {
    for (text, number) in [
        ("12", Some(12)),
        ("1e3", Some(1000)),
        ("2.50E2", Some(250)),
        ("0.5e1", Some(5)),
        ("1.5e0", None),
        ("1e-1", None),
        ("1e", None),
        ("e3", None),
        ("1e20", None),
        ("-1e3", None),
        ("1.5", None),
    ] {
        assert_eq!(read_whole(text), number, "{text}");
    }
    assert_eq!(resolve("", &["--vpls", "1e3"]).unwrap().vpl.slots, 1000);
}
