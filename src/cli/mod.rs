//! The command line: parses arguments, runs a subcommand, maps errors to exit codes.
//!
//! Exit codes: 0 done; 1 failed; 2 wrong usage; 3 slower than an earlier benchmark; 130 interrupted. A failure is one line on
//! standard error.

#[cfg(feature = "bench")]
mod bench;
#[cfg(feature = "bench")]
mod compare;
#[cfg(feature = "bench")]
mod compare_report;
mod dataset;
#[cfg(feature = "window")]
mod demo;
mod denoise;
mod device;
mod error;
#[cfg(feature = "export")]
mod export;
mod info;
mod info_scene;
#[cfg(not(all(feature = "window", feature = "bench", feature = "export")))]
mod lacking;
#[cfg(feature = "bench")]
mod micro;
mod options;
mod options_page;
mod progress;
mod reference;
mod render;
mod say;
mod scene;
#[cfg(feature = "bench")]
mod table_text;

#[cfg(not(feature = "window"))]
use lacking::demo;
#[cfg(not(feature = "export"))]
use lacking::export;
#[cfg(not(feature = "bench"))]
use lacking::{bench, compare};

pub use error::CliError;
pub use say::{install_panic_hook, say_error};

use std::ffi::OsString;

use clap::error::ErrorKind;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::builtin;
use crate::formats::SceneError;
use crate::untrusted::nearest;

/// Real-time global illumination by temporally interleaved instant radiosity, on Vulkan.
///
/// Without a subcommand it is `demo`.
#[derive(Debug, Parser)]
#[command(name = "glowworm", version, propagate_version = true, args_conflicts_with_subcommands = true)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    demo: demo::DemoOptions,
    /// Log more: -v notes, -vv details. `RUST_LOG` overrides it.
    #[arg(short, long, action = clap::ArgAction::Count, global = true)]
    verbose: u8,
    /// No progress and no notes, only warnings and errors.
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Threads of the work on the CPU: path tracing, loading, building BVHs, tracing light paths. Otherwise one for each of its
    /// cores.
    #[arg(long, value_name = "N", value_parser = options::count::<usize>(1..=1024), global = true)]
    threads: Option<usize>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Show a scene in a window.
    Demo(demo::DemoOptions),
    /// Render a scene to a picture or a sequence of pictures.
    Render(render::RenderOptions),
    /// Measure frame times across settings, report them, compare them with an earlier report.
    Bench(bench::BenchOptions),
    /// Path trace a scene on the CPU: the ground truth.
    Reference(reference::ReferenceOptions),
    /// Path trace noisy and converged pictures of an animation, with features, for denoisers.
    Dataset(dataset::DatasetOptions),
    /// Run a denoiser over a data set.
    Denoise(denoise::DenoiseOptions),
    /// Export a scene at one frame for another renderer.
    Export(export::ExportOptions),
    /// Compare a picture or a sequence with its reference.
    Compare(compare::CompareArguments),
    /// List the Vulkan devices, what each can do, and which would be used; or describe a scene, or the program.
    Info(info::InfoOptions),
}

/// Runs the program with `arguments`, the program's name first.
///
/// # Errors
/// The failure, to be printed with [`say_error`]; exit with [`CliError::exit_code`].
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> Result<(), CliError> {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let parsed = Arguments::command().try_get_matches_from(&arguments);
    let arguments = match parsed.and_then(|matches| Arguments::from_arg_matches(&matches)) {
        Ok(parsed) => parsed,
        Err(error) if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) => {
            return say::print(&error.render().to_string());
        }
        Err(error) => return Err(refusal(&error, &arguments)),
    };
    if arguments.quiet {
        say::be_quiet();
    }
    say::start_log(arguments.verbose);
    progress::watch_interruptions();
    if let Some(threads) = arguments.threads {
        // Fails if the threads are there, as in tests; then they stay.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
    }
    match arguments.command {
        Some(Command::Demo(options)) => demo::demo(options),
        Some(Command::Render(options)) => render::render(&options),
        Some(Command::Bench(options)) => bench::bench(&options),
        Some(Command::Reference(options)) => reference::reference(&options),
        Some(Command::Dataset(options)) => dataset::dataset(&options),
        Some(Command::Denoise(options)) => denoise::denoise(&options),
        Some(Command::Export(options)) => export::export(&options),
        Some(Command::Compare(options)) => compare::compare(&options),
        Some(Command::Info(options)) => info::info(&options),
        None => demo::demo(arguments.demo).map_err(|error| match error {
            CliError::Scene(SceneError::NotFound(name)) if name.extension().is_none() => {
                neither(&name.to_string_lossy())
            }
            other => other,
        }),
    }
}

/// Why clap refuses `arguments`, with the help that says what would do.
fn refusal(error: &clap::Error, arguments: &[OsString]) -> CliError {
    let command = Arguments::command();
    let names: Vec<_> = arguments.iter().skip(1).map(|argument| argument.to_string_lossy()).collect();
    if error.kind() == ErrorKind::ArgumentConflict
        && names[0].starts_with('-')
        && let Some(name) = names.iter().find(|name| command.find_subcommand(&***name).is_some())
    {
        let option = &names[0];
        return CliError::Usage(format!(
            "{option}: options stand behind the subcommand; see glowworm {name} --help"
        ));
    }
    let Some(name) = names.into_iter().find(|name| !name.starts_with('-')) else {
        return CliError::usage(error, "glowworm --help");
    };
    if command.find_subcommand(&*name).is_some() {
        return CliError::usage(error, &format!("glowworm {name} --help"));
    }
    // Of what follows an unknown name, no error is the first one.
    let is_first = arguments.get(1).is_some_and(|first| *first == *name);
    if is_first && !name.contains(['.', '/', '\\']) && !builtin::NAMES.contains(&&*name) {
        return neither(&name);
    }
    CliError::usage(error, "glowworm --help")
}

/// The error about a name of nothing.
fn neither(name: &str) -> CliError {
    let command = Arguments::command();
    let known = command.get_subcommands().map(clap::Command::get_name).chain(builtin::NAMES);
    let like = nearest(name, known).map_or_else(String::new, |like| format!(" (did you mean {like}?)"));
    CliError::Usage(format!("{name}: neither a subcommand nor a scene{like}; see glowworm --help"))
}

#[cfg(all(test, feature = "window", feature = "bench", feature = "export"))]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
mod tests {
    use super::*;

    fn parse(arguments: &[&str]) -> Arguments {
        Arguments::try_parse_from([&["glowworm"], arguments].concat()).unwrap()
    }

    fn refused(arguments: &[&str]) -> String {
        let arguments = [&["glowworm"], arguments].concat();
        let error = Arguments::try_parse_from(&arguments).unwrap_err();
        let error = refusal(&error, &arguments.iter().map(OsString::from).collect::<Vec<_>>());
        assert_eq!(error.exit_code(), 2);
        error.to_string()
    }

    #[test]
    fn the_command_line_is_well_formed() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn without_a_subcommand_it_is_the_demo() {
        assert!(parse(&[]).command.is_none());
        let arguments = parse(&["sponza", "--vpls", "64"]);
        assert!(arguments.command.is_none());
        assert_eq!(arguments.demo.scene, "sponza");
        assert_eq!(arguments.demo.settings.table()["vpls"].as_integer(), Some(64));
    }

    #[test]
    fn subcommands_take_the_shared_options() {
        let Some(Command::Render(render)) = parse(&[
            "render",
            "cornell-box",
            "--frames",
            "3",
            "--out",
            "a.exr",
            "--layers",
            "--device",
            "1",
            "--validate",
            "--assets",
            "models",
            "--json",
            "a.json",
            "-v",
            "--size",
            "8x4",
        ])
        .command
        else {
            panic!("not render");
        };
        assert_eq!((render.scene.as_str(), render.frames, render.layers), ("cornell-box", Some(3), true));
        assert_eq!(render.settings.table().len(), 1);
        assert!(render.settings.has("size"));
        assert_eq!(render.run.device.device.as_deref(), Some("1"));
        assert!(render.run.device.validate);
        assert_eq!(render.run.files.assets_folder(), Some("models".into()));
    }

    #[test]
    fn the_page_of_options_is_what_info_prints() {
        let page = options_page::page(&Arguments::command());
        assert!(
            page == include_str!("../../docs/OPTIONS.md"),
            "write it anew: glowworm info --options > docs/OPTIONS.md"
        );
    }

    #[test]
    fn wrong_usage_is_one_line() {
        let (program, render) = ("see glowworm --help", "see glowworm render --help");
        for (arguments, says, help) in [
            (vec!["render"], "<SCENE>", render),
            (vec!["render", "cornell-box"], "--out", render),
            (vec!["render", "cornell-box", "--out", "a.png", "--frames", "0"], "--frames", render),
            (vec!["render", "cornell-box", "--out", "a.png", "--vlps", "1"], "--vpls", render),
            (vec!["render", "cornell-box", "--out", "a.png", "--vpls", "x"], "--vpls", render),
            (
                vec!["reference", "a.obj", "-o", "a", "--spp", "1e-1"],
                "--spp 1e-1: must be",
                "reference --help",
            ),
            (
                vec!["export", "a.obj", "-o", "-"],
                "only a single picture goes to standard output",
                "export --help",
            ),
            (
                vec!["rendr", "cornell-box"],
                "rendr: neither a subcommand nor a scene (did you mean render?)",
                program,
            ),
            (vec!["cornel-box", "-x"], "(did you mean cornell-box?)", program),
            (vec!["my.toml", "--vlps", "1"], "--vpls", program),
            (vec!["--frames", "3"], "--frames", program),
            (vec!["-q", "render", "a.obj"], "-q: options stand behind the subcommand", render),
            (vec!["render", "a.obj", "-o", "a.png", "-q", "-v"], "cannot be used with", render),
        ] {
            let message = refused(&arguments);
            assert!(message.contains(says) && !message.contains('\n'), "{message}");
            assert!(message.ends_with(help), "{message}");
        }
    }
}
