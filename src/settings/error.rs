//! Errors in settings.

use super::Setting;

/// Invalid settings.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingsError {
    /// The scene file's `[settings]` has an unknown key, a key of another group, or a value that is not allowed.
    #[error("{0}")]
    Table(String),
    /// An option has a value that is not allowed.
    #[error("{0}")]
    Option(String),
    /// Two settings do not go together.
    #[error("{message}")]
    Conflict {
        /// One line that names both.
        message: String,
        /// Whether an option of the command line is at fault, not the scene file.
        is_usage: bool,
    },
}

impl SettingsError {
    /// An option with a value that is not allowed.
    pub(super) fn option(setting: &Setting, text: &str) -> Self {
        Self::Option(format!("--{} {text}: must be {}", setting.option(), setting.kind))
    }

    /// Whether the command line is at fault (wrong usage), not the scene file.
    pub fn is_usage(&self) -> bool {
        match self {
            Self::Table(_) => false,
            Self::Option(_) => true,
            Self::Conflict { is_usage, .. } => *is_usage,
        }
    }
}
