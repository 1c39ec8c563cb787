//! Errors of a run, and their exit codes.

use std::error::Error;
use std::path::PathBuf;

use clap::error::ContextKind;

#[cfg(feature = "bench")]
use crate::bench::BenchError;
use crate::dataset::DatasetError;
#[cfg(feature = "export")]
use crate::export::ExportError;
use crate::formats::SceneError;
use crate::metrics::MetricsError;
use crate::output::OutputError;
use crate::reference::ReferenceError;
use crate::renderer::RenderError;
use crate::settings::SettingsError;
use crate::vulkan::VulkanError;

/// Exit code of an interrupted run: 128 + SIGINT, as of shells.
pub(super) const INTERRUPTED: u8 = 130;

/// A failed run. Its text is one line that names the file or option at fault.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// The command line is wrong.
    #[error("{0}")]
    Usage(String),
    /// The command line or the scene file has a setting that cannot be used.
    #[error("{}{error}", if error.is_usage() { String::new() } else { format!("{scene}: ") })]
    Settings {
        /// The scene whose settings took part.
        scene: String,
        /// The error of the settings.
        error: SettingsError,
    },
    /// The scene cannot be loaded.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A picture, plot or report cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Pictures cannot be compared.
    #[error(transparent)]
    Metrics(#[from] MetricsError),
    /// Vulkan cannot be loaded, has no fitting device, or failed.
    #[error(transparent)]
    Vulkan(#[from] VulkanError),
    /// The scene cannot be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The reference cannot be rendered.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// The scene cannot be exported.
    #[error(transparent)]
    #[cfg(feature = "export")]
    Export(#[from] ExportError),
    /// A data set cannot be written or read.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// A benchmark failed.
    #[error("{0}")]
    #[cfg(feature = "bench")]
    Bench(BenchError),
    /// Something is slower than in the earlier report.
    #[error("--against {path}: {slower} {} slower or worse beyond noise", if *.slower == 1 { "figure is" } else { "figures are" })]
    Regression {
        /// The earlier report.
        path: String,
        /// Number of slower times.
        slower: usize,
    },
    /// The window could not be opened or was lost.
    #[error("{0}")]
    Window(String),
    /// The picture cannot be resumed.
    #[error("{path}: {reason}")]
    Resume {
        /// The picture.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
    /// The file is there, and is not to be replaced.
    #[error("{0}: is there already; give another name, or leave --no-overwrite out")]
    Exists(PathBuf),
    /// Rendering was interrupted.
    #[error("interrupted after {done} of {frames} frames; {}", if *.kept { "their pictures are written" } else { "nothing was written" })]
    Stopped {
        /// Complete frames.
        done: u64,
        /// Requested frames.
        frames: u64,
        /// Whether their pictures are there.
        kept: bool,
    },
    /// A reference was interrupted.
    #[error(
        "interrupted after {samples} of {spp} samples per pixel; {}{}",
        if *.samples > 0 { format!("{} holds them", .path.display()) } else { "nothing was written".to_owned() },
        if *.samples > 0 && *.resumable { "; --resume continues" } else { "" }
    )]
    Interrupted {
        /// The picture.
        path: PathBuf,
        /// Completed samples per pixel.
        samples: u64,
        /// Requested samples per pixel.
        spp: u64,
        /// Whether a later run can resume.
        resumable: bool,
    },
    /// The validation layer reported errors.
    #[error("--validate: {count} messages of the validation layer, the first: {first}")]
    Validation {
        /// Number of messages.
        count: usize,
        /// The first.
        first: String,
    },
    /// Standard output cannot be written to.
    #[error("standard output: {0}")]
    StandardOutput(std::io::Error),
}

#[cfg(feature = "bench")]
impl From<BenchError> for CliError {
    /// Errors shared with other commands keep their text.
    fn from(error: BenchError) -> Self {
        match error {
            BenchError::Scene(error) => error.into(),
            BenchError::Settings { scene, error } => Self::Settings { scene, error },
            BenchError::Render(error) => error.into(),
            BenchError::Output(error) => error.into(),
            BenchError::Metrics(error) => error.into(),
            other => Self::Bench(other),
        }
    }
}

impl CliError {
    /// A command line that clap refuses, in one line that ends with the `help` to see.
    pub(super) fn usage(error: &clap::Error, help: &str) -> Self {
        let context = |kind| error.get(kind).map(ToString::to_string).unwrap_or_default();
        if let Some(allowed) = error.source() {
            let option = context(ContextKind::InvalidArg);
            let name = option.split_whitespace().next().unwrap_or_default();
            let value = context(ContextKind::InvalidValue);
            return Self::Usage(format!("{name} {value}: {allowed}; see {help}"));
        }
        let text = error.render().to_string();
        let parts: Vec<_> = text
            .split("\n\n")
            .filter(|part| !part.starts_with("Usage:") && !part.starts_with("For more information"))
            .flat_map(str::split_whitespace)
            .collect();
        let message = parts.join(" ");
        Self::Usage(format!("{}; see {help}", message.trim_start_matches("error: ")))
    }

    /// 2 for wrong usage, 3 for a slowdown, 130 for an interruption, 1 for everything else.
    pub fn exit_code(&self) -> u8 {
        let is_usage = match self {
            Self::Regression { .. } => return 3,
            Self::Stopped { .. }
            | Self::Interrupted { .. }
            | Self::Dataset(DatasetError::Interrupted { .. }) => return INTERRUPTED,
            #[cfg(feature = "bench")]
            Self::Bench(BenchError::Stopped { .. } | BenchError::Interrupted { .. }) => return INTERRUPTED,
            Self::Usage(_) => true,
            Self::Settings { error, .. } => error.is_usage(),
            Self::Output(error) => error.is_usage(),
            Self::Metrics(error) => error.is_usage(),
            #[cfg(feature = "bench")]
            Self::Bench(_) => false,
            #[cfg(feature = "export")]
            Self::Export(_) => false,
            Self::Scene(_)
            | Self::Vulkan(_)
            | Self::Render(_)
            | Self::Reference(_)
            | Self::Dataset(_)
            | Self::Window(_)
            | Self::Exists(_)
            | Self::Resume { .. }
            | Self::Validation { .. }
            | Self::StandardOutput(_) => false,
        };
        if is_usage { 2 } else { 1 }
    }
}
