//! Errors in settings.

/// Invalid settings.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingsError {
    /// The scene file's `[settings]` has an unknown key, a key of another group, or a value that cannot be parsed.
    #[error("{0}")]
    Table(String),
    /// A setting is out of its range.
    #[error("{}: must be {allowed}", assignment(setting, value, *from_command_line))]
    OutOfRange {
        /// The field's name.
        setting: &'static str,
        /// Its value.
        value: String,
        /// Its range.
        allowed: &'static str,
        /// Whether an option of the command line is at fault, not the scene file.
        from_command_line: bool,
    },
    /// More temporal sets than VPLs to fill them.
    #[error(
        "--temporal-sets is {temporal_sets}, but must be at most --vpls, which is {vpls}; lower the one or raise the other"
    )]
    MoreSetsThanVpls {
        /// The temporal sets.
        temporal_sets: u32,
        /// The VPL slots.
        vpls: u32,
        /// Whether an option of the command line is at fault, not the scene file.
        from_command_line: bool,
    },
}

impl SettingsError {
    /// Whether the command line is at fault (wrong usage), not the scene file.
    pub fn is_usage(&self) -> bool {
        match self {
            Self::Table(_) => false,
            Self::OutOfRange { from_command_line, .. } | Self::MoreSetsThanVpls { from_command_line, .. } => {
                *from_command_line
            }
        }
    }

    /// Sets whether one of the options `given` on the command line is at fault.
    pub(super) fn blame(mut self, given: &[&str]) -> Self {
        match &mut self {
            Self::Table(_) => {}
            Self::OutOfRange { setting, from_command_line, .. } => {
                *from_command_line = given.contains(setting);
            }
            Self::MoreSetsThanVpls { from_command_line, .. } => {
                *from_command_line = given.contains(&"temporal_sets") || given.contains(&"vpls");
            }
        }
        self
    }
}

/// A setting in the syntax of its source: `--temporal-sets 600` or `[settings] temporal_sets = 600`.
pub(super) fn assignment(setting: &str, value: &str, on_command_line: bool) -> String {
    if on_command_line {
        format!("--{} {value}", setting.replace('_', "-"))
    } else {
        format!("[settings] {setting} = {value}")
    }
}
