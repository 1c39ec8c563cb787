//! Settings as options of the command line.

use clap::builder::PossibleValuesParser;
use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Command};
use toml::Table;

use super::{GROUPS, Setting, Settings, SettingsError, all};

/// The settings that the options of a command line give: each setting is an option.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GivenSettings(Table);

impl GivenSettings {
    /// The given settings by key.
    pub fn table(&self) -> &Table {
        &self.0
    }

    /// Whether a setting is given.
    pub fn has(&self, key: &str) -> bool {
        self.0.contains_key(key)
    }

    /// Takes a setting back; whether it was given.
    pub fn remove(&mut self, key: &str) -> bool {
        self.0.remove(key).is_some()
    }

    /// Gives a setting, by its key, a value.
    pub fn insert(&mut self, key: &str, value: impl Into<toml::Value>) {
        self.0.insert(key.to_owned(), value.into());
    }

    /// Checks each setting by itself.
    ///
    /// # Errors
    /// If a key is unknown or a value not allowed.
    pub fn check(&self) -> Result<(), SettingsError> {
        Settings::default().set_given(self)
    }
}

impl From<Table> for GivenSettings {
    fn from(table: Table) -> Self {
        Self(table)
    }
}

impl Setting {
    /// The setting's option.
    fn argument(&'static self, heading: &'static str) -> Arg {
        let argument = Arg::new(self.key)
            .long(self.option())
            .help(self.help())
            .help_heading(heading)
            .default_value(self.text(&Settings::default()))
            .allow_negative_numbers(true);
        let argument = match self.kind.unit() {
            Some(unit) => argument.value_name(unit.into_owned()),
            None => argument.value_name(self.key.to_uppercase()),
        };
        match self.kind.choices() {
            choices if choices.is_empty() => argument.value_parser(parser_of(self.key)),
            choices => argument.value_parser(PossibleValuesParser::new(choices)),
        }
    }
}

/// Checks the text of an option that is, or stands for, a setting.
pub(crate) fn parser_of(key: &'static str) -> impl Fn(&str) -> Result<String, String> + Clone {
    move |text| {
        let setting = super::find(key).ok_or_else(|| format!("{key} is no setting"))?;
        setting.set(&mut Settings::default(), text).map(|()| text.to_owned())
    }
}

impl clap::Args for GivenSettings {
    fn augment_args(command: Command) -> Command {
        let options = |group: super::Group| group.settings.iter().map(move |of| of.argument(group.title));
        command.args(GROUPS.into_iter().flat_map(options))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl clap::FromArgMatches for GivenSettings {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        Ok(Self::among(all(), matches))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl GivenSettings {
    /// The values given for some settings, all of which are options of the command.
    fn among(settings_of: impl Iterator<Item = &'static Setting>, matches: &ArgMatches) -> Self {
        let mut given = Self::default();
        let mut settings = Settings::default();
        let is_given = |of: &&Setting| matches.value_source(of.key) == Some(ValueSource::CommandLine);
        for setting in settings_of.filter(is_given) {
            // The parser has checked the text.
            let text = matches.get_one::<String>(setting.key).map_or("", String::as_str);
            if setting.set(&mut settings, text).is_ok() {
                given.insert(setting.key, setting.value(&settings));
            }
        }
        given
    }
}

/// The settings of denoisers and of what is shown that the options of a command line give: those of a command that renders nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GivenDenoising(pub GivenSettings);

impl GivenDenoising {
    /// Groups with their settings.
    fn groups() -> impl Iterator<Item = (super::Group, Vec<&'static Setting>)> {
        let is_own = |group: &super::Group, setting: &Setting| {
            ["settings.svgf", "settings.bmfr"].contains(&group.table)
                || ["denoise", "exposure", "tone_map"].contains(&setting.key)
        };
        GROUPS.into_iter().map(move |group| {
            let own = group.settings.iter().filter(|setting| is_own(&group, setting)).collect();
            (group, own)
        })
    }
}

impl clap::Args for GivenDenoising {
    fn augment_args(command: Command) -> Command {
        let options = |(group, settings): (super::Group, Vec<&'static Setting>)| {
            settings.into_iter().map(move |of| of.argument(group.title))
        };
        command.args(Self::groups().flat_map(options))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl clap::FromArgMatches for GivenDenoising {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        Ok(Self(GivenSettings::among(Self::groups().flat_map(|(_, settings)| settings), matches)))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}
