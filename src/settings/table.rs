//! Settings read from a table, a scene file's `[settings]` or a report, and written to one.
//!
//! In: keys and values, flat or with a table for each group, such as `[settings.vpls]`. Out: [`Settings`], or one line
//! that names the key. Each value is read as the command line reads the option of that name.

use std::fmt::{Formatter, Result as FormatResult};

use serde::de::{self, Deserialize, DeserializeSeed, Deserializer, MapAccess, Visitor};
use serde::ser::{Serialize, Serializer};
use toml::{Table, Value};

use super::value::text_of;
use super::{GROUPS, Group, Settings, SettingsError, all};

/// Flattens `table`: all settings by key, without the groups' subtables. Fails for an unknown or repeated key, one in
/// the wrong subtable, or a subtable as value.
pub(crate) fn flat(table: &Table) -> Result<Table, SettingsError> {
    let mut flat = Table::new();
    let root = GROUPS[0].table;
    let mut add = |place: &str, key: &str, value: &Value| {
        let group = GROUPS.iter().find(|group| group.settings.iter().any(|known| known.key == key));
        let problem = match group {
            None => format!("unknown setting; {}", known(place)),
            Some(group) if place != root && place != group.table => format!("belongs in [{}]", group.table),
            Some(_) if value.is_table() => "must be a value, not a table".to_owned(),
            Some(_) if flat.insert(key.to_owned(), value.clone()).is_some() => "is set twice".to_owned(),
            Some(_) => return Ok(()),
        };
        Err(SettingsError::Table(format!("[{place}] {key}: {problem}")))
    };
    for (key, value) in table {
        match value {
            Value::Table(group) => {
                let place = format!("{root}.{key}");
                if !GROUPS.iter().any(|group| group.table == place) {
                    let tables = GROUPS.map(|group| format!("[{}]", group.table)).join(", ");
                    return Err(SettingsError::Table(format!(
                        "[{place}]: unknown table; known are {tables}"
                    )));
                }
                group.iter().try_for_each(|(key, value)| add(&place, key, value))?;
            }
            value => add(root, key, value)?,
        }
    }
    Ok(flat)
}

/// The settings allowed in the table `place`, for an error message.
fn known(place: &str) -> String {
    let here = GROUPS.iter().filter(|group: &&Group| place == GROUPS[0].table || place == group.table);
    let keys: Vec<_> = here.flat_map(|group| group.settings).map(|setting| setting.key).collect();
    format!("known are {}", keys.join(", "))
}

impl Settings {
    /// The value of the setting `key` that a text of the command line stands for.
    ///
    /// # Errors
    /// If there is no such setting, or the text is not allowed.
    pub(crate) fn value(key: &str, text: &str) -> Result<toml::Value, SettingsError> {
        let table = Table::from_iter([(key.to_owned(), text.into())]);
        let settings = Self::from_table(&table)?;
        Ok(all()
            .find(|setting| setting.key == key)
            .map_or_else(|| text.into(), |setting| setting.value(&settings)))
    }

    /// The defaults, overridden by `table`, flat or with subtables of groups.
    ///
    /// # Errors
    /// If a key is unknown or in another group's subtable, or a value is not allowed.
    pub fn from_table(table: &Table) -> Result<Self, SettingsError> {
        let mut settings = Self::default();
        let table = flat(table)?;
        for setting in all() {
            if let Some(value) = table.get(setting.key) {
                let (key, text) = (setting.key, text_of(value));
                let error = |problem| SettingsError::Table(format!("[settings] {key} = {text}: {problem}"));
                setting.set(&mut settings, &text).map_err(error)?;
            }
        }
        Ok(settings)
    }

    /// All settings under their keys.
    pub(crate) fn to_table(&self) -> Table {
        all().map(|setting| (setting.key.to_owned(), setting.value(self))).collect()
    }
}

impl Serialize for Settings {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(all().map(|setting| (setting.key, setting.value(self))))
    }
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
        let mut table = Table::new();
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
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        let value = Value::deserialize(deserializer)?;
        let alone = Table::from_iter([(self.0.to_owned(), value.clone())]);
        Settings::from_table(&alone).map_err(de::Error::custom)?;
        Ok(value)
    }
}
