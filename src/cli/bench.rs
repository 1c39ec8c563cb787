//! `glowworm bench`: frame times and quality of scenes, and changes since an earlier report.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use toml::Value;

use super::micro::{MicroOptions, micro};
use super::options::{RunOptions, count, folder};
use super::progress::controlled;
use super::table_text::text;
use super::{CliError, device, say};
use crate::bench::{
    Axis, Bench, BenchError, Comparison, Folder, MICRO_FILE, Method, Noise, Plan, Report, Sweep,
    compare_reports, lacks_models, read_report, tables,
};
use crate::builtin::{BENCH_SCENES, BENCH_SCENES_OF_ASSETS};
use crate::estimators;
use crate::settings::{GivenSettings, Settings};
use crate::vulkan::Device;

/// Default number of measured frames.
const FRAMES: u32 = 240;
/// Default number of rounds.
const ROUNDS: u32 = 2;
/// Default samples a pixel of the path tracer's pictures.
const SPP: u32 = 1024;
/// Default size in pixels.
const SIZE: [u32; 2] = [1024, 1024];
/// Defaults on a CPU device, which takes some 50 ms for such a frame.
const ON_CPU: OnCpu = OnCpu { frames: 20, size: [256, 256], time_step: 1.0 / 20.0, still_frames: 64 };

struct OnCpu {
    frames: u32,
    size: [u32; 2],
    time_step: f64,
    still_frames: u32,
}

/// Help after the options.
const HELP: &str = "\
A frame's time runs from its start until the device has finished it; frames do not overlap and are not presented. Each \
run warms up until all set buffers are filled; then all settings are measured at the same moments of the animation. \
Defaults on a CPU device: 256x256 pixels, 1/20 s per frame, 20 frames or, if greater, one per temporal set. \
--out receives report.html, bench.json (everything), bench.csv, bench.md, plots/ and pictures/; with --quality and several \
--methods also their pictures at equal frame time, with maps of their errors; unfinished/ holds the \
results of an interrupted run. --against exits with 3 if something is slower or worse beyond noise; to compare an existing report, \
name its folder with --out and add --resume.";

/// Options of `bench`.
#[derive(Clone, Debug, clap::Args)]
#[command(args_override_self = true, after_help = HELP)]
pub(super) struct BenchOptions {
    /// Scenes to measure: built-in ones, scene files (.toml) or models (.obj, .gltf, .glb). Otherwise those of --against, or the
    /// built-in set-ups of the dissertation.
    #[arg(value_name = "SCENE")]
    pub scenes: Vec<String>,
    /// Measure the set-ups of the dissertation with the real models in --assets; missing ones are skipped.
    #[arg(long, conflicts_with = "scenes")]
    pub models: bool,
    /// Frames to measure in each run; fewer than the temporal sets miss some sets. More: narrower confidence intervals.
    /// Otherwise that of --against, or 240, or on a CPU device the most temporal sets, but at least 20.
    #[arg(long, value_name = "N", value_parser = count::<u32>(1..=100_000))]
    pub frames: Option<u32>,
    /// Measurements of each setting. From two on, confidence intervals come from the variance between rounds. Otherwise
    /// that of --against, or 2.
    #[arg(long, value_name = "N", value_parser = count::<u32>(1..=1000))]
    pub rounds: Option<u32>,
    /// Methods to measure side by side, such as vpls,vpls@T=1,none@direct=soft,reference@4: an estimator with settings, or the
    /// path tracer with samples a pixel; all: each of them. Otherwise that of the settings.
    #[arg(long, value_name = "METHOD", value_delimiter = ',', value_parser = Method::list)]
    pub methods: Vec<Vec<Method>>,
    /// Also compare pictures with the path tracer's of the same moments.
    #[arg(long)]
    pub quality: bool,
    /// Samples a pixel of the path tracer's pictures for --quality. More: less noise counts as an error. 0: compare with the first
    /// run of each scene instead. Otherwise that of --against, or 1024.
    #[arg(long, value_name = "N", value_parser = count::<u32>(0..=1 << 20))]
    pub spp: Option<u32>,
    /// Report what is faster, slower, better or worse than in this bench.json, and exit with 3 if anything is slower or worse.
    #[arg(long, value_name = "FILE", help_heading = "Files")]
    pub against: Option<PathBuf>,
    /// Run micro-benchmarks instead: rays per second of each tracer, BVH operations, each pass. Lists use their first
    /// value. Writes micro.json and micro.md.
    #[arg(long, conflicts_with_all = ["frames", "methods", "quality", "spp", "against", "resume"])]
    pub micro: bool,
    /// Most rays in a set. More: less noise in the rates.
    #[arg(long, value_name = "N", default_value = "262144", requires = "micro")]
    #[arg(value_parser = count::<u32>(1..=1 << 24))]
    pub rays: u32,
    /// Folder of the report; an earlier report in it is replaced once the new one is complete.
    #[arg(short, long, value_name = "DIR", value_parser = folder(), default_value = "glowworm-bench", help_heading = "Files")]
    pub out: PathBuf,
    /// Resume the interrupted run in the folder; options that are not given keep their values.
    #[arg(long, help_heading = "Files")]
    pub resume: bool,
    #[command(flatten)]
    pub settings: SweptSettings,
    #[command(flatten)]
    pub run: RunOptions,
}

/// The given settings, some with several values.
#[derive(Clone, Debug)]
pub(super) struct SweptSettings {
    /// The settings with one value.
    pub given: GivenSettings,
    /// The given values of settings that accept several.
    lists: BTreeMap<String, Vec<Value>>,
}

/// The settings that accept several values.
fn swept() -> Vec<Axis> {
    Axis::all().into_iter().filter(|axis| *axis != Axis::Method).collect()
}

/// The size of pictures and the lists of the settings' method that are measured unless others are given.
fn default_list(axis: Axis, settings: &Settings, on_cpu: bool) -> Option<String> {
    match axis {
        Axis::Size => Some(if on_cpu { ON_CPU.size } else { SIZE }.map(|side| side.to_string()).join("x")),
        Axis::Number(axis) => {
            let own = estimators::method(settings).axes.iter().find(|own| own.setting == axis.setting)?;
            own.default_sweep.map(str::to_owned)
        }
        Axis::Method => None,
    }
}

/// The values of a list in the syntax of the command line.
fn values<'a>(axis: Axis, texts: impl Iterator<Item = &'a str>) -> Vec<Value> {
    // The parser has checked the texts.
    texts.filter_map(|text| Settings::value(axis.key(), text).ok()).collect()
}

impl clap::Args for SweptSettings {
    fn augment_args(command: clap::Command) -> clap::Command {
        let more = |command: clap::Command, name: &str, text: &str| {
            command.mut_arg(name, |argument| {
                let help = argument.get_help().map(ToString::to_string).unwrap_or_default();
                argument.help(format!("{help}. {text}"))
            })
        };
        let list = |command: clap::Command, axis: Axis| {
            let command = more(command, axis.key(), "A list such as A,B measures each");
            command.mut_arg(axis.key(), |argument| {
                let argument = argument.value_delimiter(',');
                match default_list(axis, &Settings::default(), false) {
                    Some(list) => argument.default_value(list),
                    None => argument,
                }
            })
        };
        let command = swept().into_iter().fold(GivenSettings::augment_args(command), list);
        let command = more(command, "time_step", "On a CPU device the default is 1/20");
        more(command, "size", "On a CPU device the default is 256x256")
    }

    fn augment_args_for_update(command: clap::Command) -> clap::Command {
        Self::augment_args(command)
    }
}

impl clap::FromArgMatches for SweptSettings {
    fn from_arg_matches(matches: &clap::ArgMatches) -> Result<Self, clap::Error> {
        let mut given = GivenSettings::from_arg_matches(matches)?;
        let listed = swept().into_iter().filter(|axis| given.remove(axis.key()));
        let list = |axis: Axis| {
            let texts = matches.get_many::<String>(axis.key()).into_iter().flatten();
            (axis.key().to_owned(), values(axis, texts.map(String::as_str)))
        };
        Ok(Self { lists: listed.map(list).collect(), given })
    }

    fn update_from_arg_matches(&mut self, matches: &clap::ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl SweptSettings {
    /// All given settings, each with its first value.
    pub fn first(&self) -> GivenSettings {
        let mut given = self.given.clone();
        for (key, values) in &self.lists {
            if let Some(value) = values.first() {
                given.insert(key, value.clone());
            }
        }
        given
    }

    /// The given lists; otherwise those of the `old` plan; otherwise the default ones, or the scenes' values.
    fn sweep(&self, old: Option<&Sweep>, on_cpu: bool) -> Sweep {
        // Wrong values are told later.
        let settings = Settings::resolve(&toml::Table::new(), &self.given).unwrap_or_default();
        let list = |axis: Axis| {
            let default = || Some(values(axis, default_list(axis, &settings, on_cpu)?.split(',')));
            let others = || match old {
                Some(old) => old.settings.get(axis.key()).cloned(),
                None => default(),
            };
            Some((axis.key().to_owned(), self.lists.get(axis.key()).cloned().or_else(others)?))
        };
        Sweep { methods: Vec::new(), settings: swept().into_iter().filter_map(list).collect() }
    }
}

/// Measures, reports and compares.
pub(super) fn bench(options: &BenchOptions) -> Result<(), CliError> {
    let main_file = if options.micro { MICRO_FILE } else { "report.html" };
    let json = options.run.files.report.check([options.out.join(main_file)])?;
    // Read it before anything is written: the new report may replace it.
    let old = options.against.as_deref().map(read_report).transpose()?;
    let folder = Folder::new(&options.out)?;
    let device = device::open(&options.run.device)?;
    if options.micro {
        return micro(micro_options(options, &device)?, &device, &folder, json.as_ref());
    }
    let earlier = if options.resume { folder.earlier()?.map(|(_, report)| report) } else { None };
    let mut plan = plan(options, earlier.as_ref().or(old.as_ref()), &device)?;
    plan.quality |= earlier.is_some_and(|earlier| earlier.plan.quality);
    let mut bench = Bench::new(&device, plan, folder, options.run.files.assets_folder())?;
    if options.resume && !bench.resume()? {
        say::note(&format!("{}: no earlier run to resume; starting over", options.out.display()));
    }
    device::note_slow(&device);
    controlled(bench.work_left(), |control| bench.run(control))?;
    device::check_validation(&device.validation_messages())?;
    bench.write()?;
    let report = bench.report();
    if let Some(warning) = Noise::of(&report.runs).warning() {
        say::warning(&warning);
    }
    if let Some(json) = json {
        json.save_json(report)?;
    }
    let table = tables(report).into_iter().next().map(|table| text(&table)).unwrap_or_default();
    say::print(&format!("{table}{}\n", options.out.join("report.html").display()))?;
    match (&old, &options.against) {
        (Some(old), Some(path)) => print_changes(&compare_reports(old, report), path),
        _ => Ok(()),
    }
}

/// The scenes of the options, if they name any.
fn given_scenes(options: &BenchOptions) -> Result<Option<Vec<String>>, CliError> {
    Ok(match options {
        _ if options.models => Some(models(options)?),
        _ if !options.scenes.is_empty() => Some(options.scenes.clone()),
        _ => None,
    })
}

fn micro_options(options: &BenchOptions, device: &Device) -> Result<MicroOptions, CliError> {
    let mut given = options.settings.first();
    if device.is_cpu() && !given.has("size") {
        given.insert("size", ON_CPU.size.map(i64::from).to_vec());
    }
    Ok(MicroOptions {
        scenes: given_scenes(options)?.unwrap_or_else(|| BENCH_SCENES.map(str::to_owned).into()),
        settings: given,
        assets: options.run.files.assets_folder(),
        rays: options.rays as usize,
        rounds: options.rounds,
    })
}

/// The plan of the options; defaults come from the `old` report, except for `--quality`.
fn plan(options: &BenchOptions, old: Option<&Report>, device: &Arc<Device>) -> Result<Plan, CliError> {
    let old = old.map(|report| &report.plan);
    let scenes = given_scenes(options)?
        .or_else(|| old.map(|old| old.scenes.clone()))
        .unwrap_or_else(|| BENCH_SCENES.map(str::to_owned).into());
    let mut settings = old.map(|old| old.settings.clone()).unwrap_or_default();
    settings.extend(options.settings.given.table().clone());
    let on_cpu = device.is_cpu();
    if on_cpu && old.is_none() {
        settings.entry("time_step").or_insert(ON_CPU.time_step.into());
        settings.entry("still_frames").or_insert(ON_CPU.still_frames.into());
    }
    let mut sweep = options.settings.sweep(old.map(|old| &old.sweep), on_cpu);
    for method in options.methods.concat() {
        if !sweep.methods.contains(&method) {
            sweep.methods.push(method);
        }
    }
    if let (Some(old), true) = (old, sweep.methods.is_empty()) {
        sweep.methods = old.sweep.methods.clone();
    }
    // Methods say what is swept by default.
    let axes = || {
        swept().into_iter().filter_map(|axis| if let Axis::Number(axis) = axis { Some(axis) } else { None })
    };
    if !sweep.methods.is_empty() {
        let is_default = |key: &str| axes().any(|axis| axis.setting == key && axis.default_sweep.is_some());
        sweep.settings.retain(|key, _| options.settings.lists.contains_key(key) || !is_default(key));
    }
    // Frames that divide the work may cast very different numbers of rays, so measure each.
    let least = if on_cpu { ON_CPU.frames } else { FRAMES };
    let dividing: Vec<&str> = axes().filter(|axis| axis.divides_work).map(|axis| axis.setting).collect();
    let values = dividing.iter().filter_map(|key| sweep.settings.get(*key)).flatten();
    let values = values.filter_map(|value| u32::try_from(value.as_integer()?).ok());
    let stated = sweep.methods.iter().flat_map(|method| dividing.iter().filter_map(|key| method.states(key)));
    let default = values.chain(stated).fold(least, u32::max);
    let frames = options.frames.or(old.map(|old| old.frames)).unwrap_or(default);
    let rounds = options.rounds.or(old.map(|old| old.rounds)).unwrap_or(ROUNDS);
    let spp = options.spp.or(old.map(|old| old.spp)).unwrap_or(SPP);
    Ok(Plan { scenes, frames, rounds, quality: options.quality, spp, sweep, settings })
}

/// The scenes whose models are present.
fn models(options: &BenchOptions) -> Result<Vec<String>, CliError> {
    let assets = options.run.files.assets_folder();
    let mut scenes = Vec::new();
    for scene in BENCH_SCENES_OF_ASSETS {
        if lacks_models(scene, assets.as_deref())? {
            say::warning(&format!("{scene} is skipped: its models are not in --assets or GLOWWORM_ASSETS"));
        } else {
            scenes.push(scene.to_owned());
        }
    }
    Ok(scenes)
}

/// Prints the changes; an error if anything is slower.
fn print_changes(comparison: &Comparison, path: &std::path::Path) -> Result<(), CliError> {
    let path = path.display();
    if let Some(what) = comparison.other_machine {
        say::warning(&format!(
            "--against {path}: was measured with another {what}, so differences may not come from glowworm"
        ));
    }
    if comparison.compared == 0 {
        return Err(BenchError::Report {
            path: path.to_string().into(),
            reason: "has no run with the scenes and settings of this one; nothing was compared".to_owned(),
        }
        .into());
    }
    if comparison.unmatched > 0 {
        let (runs, those) = if comparison.unmatched == 1 { ("run", "that is") } else { ("runs", "that are") };
        say::warning(&format!(
            "--against {path}: {} {runs} {those} in one report only",
            comparison.unmatched
        ));
    }
    let slower = comparison.changes.iter().filter(|change| change.is_regression()).count();
    let faster = comparison.changes.len() - slower;
    let lines: String = comparison.changes.iter().map(|change| format!("{change}\n")).collect();
    let compared = comparison.compared;
    let runs = if compared == 1 { "run" } else { "runs" };
    say::print(&format!(
        "{lines}against {path}: {slower} slower or worse, {faster} faster or better beyond noise, in {compared} {runs}\n"
    ))?;
    if slower > 0 { Err(CliError::Regression { path: path.to_string(), slower }) } else { Ok(()) }
}
