//! Stands for subcommands that a build without the features `window`, `bench` or `export` lacks.

use super::CliError;

/// Options of a subcommand that is lacking; nobody reads them.
#[derive(Clone, Debug, clap::Args)]
pub struct Ignored {
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    _arguments: Vec<String>,
}

fn lacking(subcommand: &str, feature: &str) -> Result<(), CliError> {
    Err(CliError::Usage(format!("this build lacks `{subcommand}`; build it with `--features {feature}`")))
}

#[cfg(not(feature = "window"))]
pub(super) mod demo {
    pub use super::Ignored as DemoOptions;

    pub fn demo(_: DemoOptions) -> Result<(), super::CliError> {
        super::lacking("demo", "window")
    }
}

#[cfg(not(feature = "bench"))]
pub(super) mod bench {
    pub use super::Ignored as BenchOptions;

    pub fn bench(_: &BenchOptions) -> Result<(), super::CliError> {
        super::lacking("bench", "bench")
    }
}

#[cfg(not(feature = "bench"))]
pub(super) mod compare {
    pub use super::Ignored as CompareArguments;

    pub fn compare(_: &CompareArguments) -> Result<(), super::CliError> {
        super::lacking("compare", "bench")
    }
}

#[cfg(not(feature = "export"))]
pub(super) mod export {
    pub use super::Ignored as ExportOptions;

    pub fn export(_: &ExportOptions) -> Result<(), super::CliError> {
        super::lacking("export", "export")
    }
}
