//! The text of an edited scene, in which a user's comments, order and formatting survive.
//!
//! In: a document with what it was opened from. Out: the text of that file with what the edits have changed; or, for other
//! uses than saving, a text written anew.

use std::path::{Path, PathBuf};

use toml::{Table, Value};
use toml_edit::{ArrayOfTables, DocumentMut, Item, TableLike};

use super::SceneDocument;
use crate::formats::scene_file::schema::SceneFile;
use crate::scene::RecordedFrame;
use crate::settings::Settings;

impl SceneDocument {
    /// The text of a scene file for this scene. Its paths are absolute, so that it may lie anywhere.
    pub fn text(&self) -> String {
        self.text_with(Vec::new())
    }

    /// The text of a scene file for this scene with `recording`.
    pub fn text_with(&self, recording: Vec<RecordedFrame>) -> String {
        toml::to_string(&self.table(recording)).unwrap_or_default()
    }

    /// The text to be saved at `target`. A scene file keeps its comments, order and formatting, but for what was edited; in
    /// its own folder its paths remain relative.
    pub fn text_to_save(&self, target: &Path) -> String {
        let Some(origin) = &self.origin else { return self.text() };
        let (mut before, mut now) = (origin.table.clone(), self.table(Vec::new()));
        if folder_of(target) != folder_of(&self.path) {
            forget_paths(&mut before);
        }
        for table in [&mut before, &mut now] {
            // The same values may be written otherwise.
            if let Some(Value::Table(settings)) = table.get_mut("settings")
                && let Ok(values) = Settings::from_table(settings)
            {
                *settings = values.differing();
            }
        }
        edited(&origin.text, before, now).unwrap_or_else(|| self.text())
    }

    /// The content of a scene file for this scene, with absolute paths and flat settings.
    pub(super) fn table(&self, recording: Vec<RecordedFrame>) -> Table {
        let file = SceneFile { recording, ..self.file.clone() };
        // Only settings could fail to serialise, and they were parsed from TOML.
        let mut table = Table::try_from(&file).unwrap_or_default();
        table.iter_mut().for_each(|(_, value)| shorten(value));
        if !self.settings.is_empty() {
            table.insert("settings".to_owned(), Value::Table(self.settings.clone()));
        }
        table
    }
}

/// The folder of a file, if it is there.
fn folder_of(file: &Path) -> Option<PathBuf> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
    std::fs::canonicalize(folder.unwrap_or(Path::new("."))).ok()
}

/// Leaves out the paths of models and map, as if they were not in the file yet.
fn forget_paths(table: &mut Table) {
    let models = table.get_mut("models").and_then(Value::as_array_mut).into_iter().flatten();
    for model in models.filter_map(Value::as_table_mut) {
        model.remove("path");
    }
    if let Some(environment) = table.get_mut("environment").and_then(Value::as_table_mut) {
        environment.remove("map");
    }
}

/// Writes numbers that are exact in single precision with no more digits than that needs.
fn shorten(value: &mut Value) {
    match value {
        Value::Float(number) => {
            let single = *number as f32;
            let short = single.to_string().parse().unwrap_or(*number);
            if f64::from(single) == *number && short as f32 == single {
                *number = short;
            }
        }
        Value::Array(values) => values.iter_mut().for_each(shorten),
        Value::Table(table) => table.iter_mut().for_each(|(_, value)| shorten(value)),
        _ => {}
    }
}

/// The `text` of a file that holds `before`, changed so that it holds `now`. The tables of settings are flat.
fn edited(text: &str, mut before: Table, mut now: Table) -> Option<String> {
    let mut document: DocumentMut = text.parse().ok()?;
    let settings = |table: &mut Table| match table.remove("settings") {
        Some(Value::Table(settings)) => settings,
        _ => Table::new(),
    };
    let (settings_before, settings_now) = (settings(&mut before), settings(&mut now));
    // A recording belongs to the unedited scene.
    document.remove("recording");
    update(document.as_table_mut(), &before, &now);
    update_settings(&mut document, &settings_before, &settings_now);
    Some(document.to_string())
}

/// Gives `table`, which holds `before`, the values of `now`. What is the same in both keeps its text.
fn update(table: &mut dyn TableLike, before: &Table, now: &Table) {
    for key in before.keys().filter(|key| !now.contains_key(*key)) {
        table.remove(key);
    }
    for (key, value) in now {
        let old = before.get(key);
        if old == Some(value) {
            continue;
        }
        match (old, value, table.get_mut(key)) {
            (Some(Value::Table(old)), Value::Table(new), Some(item)) if item.is_table_like() => {
                item.as_table_like_mut().into_iter().for_each(|table| update(table, old, new));
            }
            (Some(Value::Array(old)), Value::Array(new), Some(Item::ArrayOfTables(tables)))
                if tables.len() == old.len() =>
            {
                update_tables(tables, old, new);
            }
            (
                Some(Value::Array(old)),
                Value::Array(new),
                Some(Item::Value(toml_edit::Value::Array(tables))),
            ) if tables.len() == old.len()
                && !new.is_empty()
                && old.iter().chain(new).all(Value::is_table) =>
            {
                update_inline_tables(tables, old, new);
            }
            _ => set(table, key, value),
        }
    }
}

/// Sets a value; one that is there keeps the comment beside it.
fn set(table: &mut dyn TableLike, key: &str, value: &Value) {
    let item = item_of(value);
    match table.get_mut(key) {
        Some(Item::Value(known)) => {
            let decor = known.decor().clone();
            if let Ok(value) = item.into_value() {
                *known = value;
                *known.decor_mut() = decor;
            }
        }
        _ => drop(table.insert(key, item)),
    }
}

/// What becomes of the next table of an array.
enum Step {
    /// Table i before is table j now.
    Keep(usize, usize),
    Remove,
    /// Table j is new.
    Insert(usize),
}

/// How the tables before become those now: those of both are paired, in order, so that most values stay the same.
fn steps(old: &[Value], new: &[Value]) -> Vec<Step> {
    let (rows, columns) = (old.len(), new.len());
    let mut most = vec![vec![0; columns + 1]; rows + 1];
    let paired = |most: &[Vec<usize>], i: usize, j: usize| match common_values(&old[i], &new[j]) {
        0 => 0,
        common => common + most[i + 1][j + 1],
    };
    for i in (0..rows).rev() {
        for j in (0..columns).rev() {
            most[i][j] = paired(&most, i, j).max(most[i + 1][j]).max(most[i][j + 1]);
        }
    }
    let (mut i, mut j, mut steps) = (0, 0, Vec::new());
    while i < rows || j < columns {
        if i < rows && j < columns && most[i][j] > 0 && most[i][j] == paired(&most, i, j) {
            steps.push(Step::Keep(i, j));
            (i, j) = (i + 1, j + 1);
        } else if j == columns || i < rows && most[i + 1][j] >= most[i][j + 1] {
            steps.push(Step::Remove);
            i += 1;
        } else {
            steps.push(Step::Insert(j));
            j += 1;
        }
    }
    steps
}

/// The same for an array of tables.
fn update_tables(tables: &mut ArrayOfTables, old: &[Value], new: &[Value]) {
    let mut at = 0;
    for step in steps(old, new) {
        match step {
            Step::Keep(i, j) => {
                if let (Some(table), Value::Table(old), Value::Table(new)) =
                    (tables.get_mut(at), &old[i], &new[j])
                {
                    update(table, old, new);
                }
            }
            Step::Remove => {
                tables.remove(at);
                continue;
            }
            Step::Insert(j) => {
                if let Ok(mut table) = item_of(&new[j]).into_table() {
                    table.set_position(tables.get(at).and_then(toml_edit::Table::position));
                    tables.insert(at, table);
                }
            }
        }
        at += 1;
    }
}

/// The same for an array of tables between brackets, which are in lines of their own if the first one is. A comment beside a
/// table lies before the next one. As many tables as before are paired one by one.
fn update_inline_tables(tables: &mut toml_edit::Array, old: &[Value], new: &[Value]) {
    let prefix = |table: &toml_edit::Value| {
        table.decor().prefix().and_then(|prefix| prefix.as_str()).unwrap_or_default().to_owned()
    };
    let first = tables.get(0).map(&prefix).unwrap_or_default();
    let line = first.rfind('\n').map(|at| first[at..].to_owned());
    let gap = line.clone().unwrap_or_else(|| " ".to_owned());
    let same = || (0..new.len()).map(|index| Step::Keep(index, index)).collect();
    let mut at = 0;
    for step in if old.len() == new.len() { same() } else { steps(old, new) } {
        match step {
            Step::Keep(i, j) => {
                if let (Some(table), Value::Table(old), Value::Table(new)) =
                    (tables.get_mut(at).and_then(toml_edit::Value::as_inline_table_mut), &old[i], &new[j])
                {
                    update(table, old, new);
                }
            }
            Step::Remove => {
                let before = prefix(&tables.remove(at));
                match tables.get_mut(at) {
                    Some(next) => next.decor_mut().set_prefix(before),
                    None if line.is_some() => tables.set_trailing(before.trim_end().to_owned() + "\n"),
                    None => {}
                }
                continue;
            }
            Step::Insert(j) => {
                let Ok(mut table) = item_of(&new[j]).into_value() else { continue };
                let before = if let Some(next) = tables.get_mut(at) {
                    let before = prefix(next);
                    next.decor_mut().set_prefix(gap.clone());
                    before
                } else {
                    let comment = tables.trailing().as_str().unwrap_or_default().trim_end().to_owned();
                    if line.is_some() {
                        tables.set_trailing("\n");
                    }
                    comment + &gap
                };
                *table.decor_mut() = toml_edit::Decor::new(before, "");
                tables.insert_formatted(at, table);
            }
        }
        at += 1;
    }
}

/// How many values two tables have in common.
fn common_values(a: &Value, b: &Value) -> usize {
    let (Value::Table(a), Value::Table(b)) = (a, b) else { return 0 };
    a.iter().filter(|(key, value)| b.get(*key) == Some(value)).count()
}

/// Sets the settings that differ, each in the table in which the file has it, or else in `[settings]`.
fn update_settings(document: &mut DocumentMut, before: &Table, now: &Table) {
    let keys = before.keys().chain(now.keys().filter(|key| !before.contains_key(*key)));
    for key in keys.filter(|key| before.get(*key) != now.get(*key)) {
        let settings = document.entry("settings").or_insert(Item::Table(toml_edit::Table::new()));
        let Some(settings) = settings.as_table_like_mut() else { return };
        let has_it = |(_, item): &(&str, &Item)| item.get(key).is_some();
        let group = settings.iter().find(has_it).map(|(group, _)| group.to_owned());
        let place = match group {
            Some(group) => settings.get_mut(&group).and_then(Item::as_table_like_mut),
            None => Some(settings),
        };
        match (place, now.get(key)) {
            (Some(place), Some(value)) => set(place, key, value),
            (Some(place), None) => drop(place.remove(key)),
            (None, _) => {}
        }
    }
}

/// A value as it is written anew, with the place that its order gives it.
fn item_of(value: &Value) -> Item {
    const KEY: &str = "value";
    let text = toml::to_string(&Table::from_iter([(KEY.to_owned(), value.clone())])).unwrap_or_default();
    let mut document: DocumentMut = text.parse().unwrap_or_default();
    let mut item = document.remove(KEY).unwrap_or_default();
    tidy(&mut item);
    item
}

/// Tables are written where they were read; without a place, after the one before. Keyframes have a line each.
fn tidy(item: &mut Item) {
    match item {
        Item::Table(table) => {
            table.set_position(None);
            for (mut key, item) in table.iter_mut() {
                tidy(item);
                if key == "keyframes"
                    && let Ok(toml_edit::Value::Array(mut keys)) = std::mem::take(item).into_value()
                {
                    keys.iter_mut().for_each(|key| *key.decor_mut() = toml_edit::Decor::new("\n    ", ""));
                    keys.set_trailing_comma(true);
                    keys.set_trailing("\n");
                    key.fmt();
                    *item = Item::Value(keys.into());
                }
            }
        }
        Item::ArrayOfTables(tables) => {
            for table in tables.iter_mut() {
                table.set_position(None);
                table.iter_mut().for_each(|(_, item)| tidy(item));
            }
        }
        _ => {}
    }
}
