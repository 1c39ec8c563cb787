//! Settings read from a table: a scene file's `[settings]`, a report.
//!
//! In: keys and values, flat or with a table for each group, such as `[settings.vpls]`. Out: [`Settings`], or one line
//! that names the key. Each value is read as the command line reads the option of that name.

use std::error::Error;
use std::fmt::{Formatter, Result as FormatResult};
use std::sync::LazyLock;

use clap::error::{ContextKind, ContextValue};
use clap::{Args, Command, FromArgMatches};
use serde::de::{DeserializeSeed, Deserializer, MapAccess, Visitor};
use serde::{Deserialize, de};

use super::error::assignment;
use super::{Settings, SettingsError};

/// The table of the settings that all methods share; each group has a subtable.
const ROOT: &str = "settings";

static OPTIONS: LazyLock<Command> =
    LazyLock::new(|| Settings::augment_args(Command::new(ROOT).no_binary_name(true)));

/// A group of settings: one struct of this module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Group {
    /// Its table in a scene file: `settings` or `settings.vpls`.
    pub table: String,
    /// Its title in the help of the command line and in the demo's panel.
    pub heading: String,
    /// Keys.
    pub settings: Vec<String>,
}

/// All groups, the shared one first.
pub(crate) fn groups() -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for option in OPTIONS.get_arguments() {
        // clap leaves the group of the outer struct empty.
        let of = OPTIONS.get_groups().find(|group| group.get_args().any(|id| id == option.get_id()));
        let table = of.map_or(ROOT, |group| group.get_id().as_str());
        let key = option.get_id().to_string();
        match groups.iter_mut().find(|group| group.table == table) {
            Some(group) => group.settings.push(key),
            None => groups.push(Group {
                table: table.to_owned(),
                heading: option.get_help_heading().unwrap_or_default().to_owned(),
                settings: vec![key],
            }),
        }
    }
    groups
}

/// Flattens `table`: all settings by key, without the groups' subtables. Fails for an unknown or repeated key, one in
/// the wrong subtable, or a subtable as value.
pub(crate) fn flat(table: &toml::Table) -> Result<toml::Table, SettingsError> {
    let groups = groups();
    let mut flat = toml::Table::new();
    let mut add = |place: &str, key: &str, value: &toml::Value| {
        let group = groups.iter().find(|group| group.settings.iter().any(|known| known == key));
        let problem = match group {
            None => format!("unknown setting; {}", known(&groups, place)),
            Some(group) if place != ROOT && place != group.table => format!("belongs in [{}]", group.table),
            Some(_) if value.is_table() => "must be a value, not a table".to_owned(),
            Some(_) if flat.insert(key.to_owned(), value.clone()).is_some() => "is set twice".to_owned(),
            Some(_) => return Ok(()),
        };
        Err(SettingsError::Table(format!("[{place}] {key}: {problem}")))
    };
    for (key, value) in table {
        match value {
            toml::Value::Table(group) => {
                let place = format!("{ROOT}.{key}");
                if !groups.iter().any(|group| group.table == place) {
                    let tables: Vec<_> = groups.iter().map(|group| format!("[{}]", group.table)).collect();
                    let tables = tables.join(", ");
                    return Err(SettingsError::Table(format!(
                        "[{place}]: unknown table; known are {tables}"
                    )));
                }
                group.iter().try_for_each(|(key, value)| add(&place, key, value))?;
            }
            value => add(ROOT, key, value)?,
        }
    }
    Ok(flat)
}

/// The settings allowed in the table `place`, for an error message.
fn known(groups: &[Group], place: &str) -> String {
    let here = groups.iter().filter(|group| place == ROOT || place == group.table);
    let keys: Vec<_> = here.flat_map(|group| &group.settings).map(String::as_str).collect();
    format!("known are {}", keys.join(", "))
}

/// A value in the syntax of the command line.
pub(super) fn text_of(value: &toml::Value) -> String {
    match value {
        toml::Value::String(text) => text.clone(),
        toml::Value::Float(number) => number.to_string(),
        toml::Value::Array(sides) if sides.len() == 2 => {
            sides.iter().map(ToString::to_string).collect::<Vec<_>>().join("x")
        }
        other => other.to_string(),
    }
}

impl Settings {
    /// The value of the setting `key` that a text of the command line stands for.
    ///
    /// # Errors
    /// If there is no such setting, or the text cannot be parsed.
    pub fn value(key: &str, text: &str) -> Result<toml::Value, SettingsError> {
        let table = toml::Table::from_iter([(key.to_owned(), text.into())]);
        let settings = Self::from_table(&table)?.to_table();
        settings.get(key).cloned().ok_or_else(|| SettingsError::Table(format!("{key}: unknown setting")))
    }

    /// The defaults, overridden by `table`, flat or with subtables of groups. Ranges are not checked.
    ///
    /// # Errors
    /// If a key is unknown or in another group's subtable, or a value cannot be parsed.
    pub fn from_table(table: &toml::Table) -> Result<Self, SettingsError> {
        let option =
            |(key, value): (&String, &toml::Value)| format!("--{}={}", key.replace('_', "-"), text_of(value));
        let options: Vec<_> = flat(table)?.iter().map(option).collect();
        let matches = OPTIONS.clone().try_get_matches_from(options);
        matches.and_then(|matches| Self::from_arg_matches(&matches)).map_err(|error| from_clap(&error))
    }
}

/// Translates clap's error into the terms of a scene file.
fn from_clap(error: &clap::Error) -> SettingsError {
    let text = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => text.clone(),
        Some(ContextValue::Strings(texts)) => texts.join(", "),
        _ => String::new(),
    };
    let option = text(ContextKind::InvalidArg);
    let key = option.split_whitespace().next().unwrap_or_default().trim_start_matches('-').replace('-', "_");
    let expected = match error.source() {
        Some(source) => source.to_string(),
        None => format!("must be one of {}", text(ContextKind::ValidValue)),
    };
    SettingsError::Table(format!("{}: {expected}", assignment(&key, &text(ContextKind::InvalidValue), false)))
}

impl<'de> Deserialize<'de> for Settings {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(SettingsVisitor)
    }
}

struct SettingsVisitor;

impl<'de> Visitor<'de> for SettingsVisitor {
    type Value = Settings;

    fn expecting(&self, formatter: &mut Formatter<'_>) -> FormatResult {
        formatter.write_str("a table of settings")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Settings, A::Error> {
        let mut table = toml::Table::new();
        while let Some(key) = map.next_key::<String>()? {
            let value = map.next_value_seed(Checked(&key))?;
            table.insert(key, value);
        }
        Settings::from_table(&table).map_err(de::Error::custom)
    }
}

/// Deserialises the value of this key. Checking it at once gives an error the line of the key.
struct Checked<'a>(&'a str);

impl<'de> DeserializeSeed<'de> for Checked<'_> {
    type Value = toml::Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<toml::Value, D::Error> {
        let value = toml::Value::deserialize(deserializer)?;
        let alone = toml::Table::from_iter([(self.0.to_owned(), value.clone())]);
        Settings::from_table(&alone).map_err(de::Error::custom)?;
        Ok(value)
    }
}
