//! docs/OPTIONS.md, made from the options as the command line has them.

use clap::{Arg, Command};

use crate::settings::GROUPS;

/// The page above the tables.
const BEGINNING: &str = "\
# Options

`glowworm info --options` writes this page. `glowworm COMMAND --help` documents each command in more detail. The last occurrence of
a repeated option counts.

Exit codes: 0 done; 1 failed, with one line on standard error that names the file, line or option at fault; 2 wrong usage;
3 `bench --against` found a slowdown; 130 interrupted. A file on disk is replaced only by a complete new one.

## Settings

Options of `demo`, `render` and `bench` (those of SVGF, BMFR, exposure and tone curve also of `denoise`), and keys of a scene file's
`[settings]` (with `_` for `-`), whose values may be written as here: `size = \"256x144\"`, `time_step = \"1/60\"`. The command
line overrides the scene file, which overrides the default. Ranges are in brackets.
";

/// One option of one or more commands.
#[derive(PartialEq)]
struct Row {
    heading: String,
    text: String,
}

/// The page of a program.
pub(super) fn page(program: &Command) -> String {
    let mut rows: Vec<(Row, Vec<String>)> = Vec::new();
    let global = program.get_arguments().filter(|option| option.is_global_set());
    let of_commands = program.get_subcommands().flat_map(|command| {
        let name = format!("`{}`", command.get_name());
        command.get_arguments().map(move |option| (name.clone(), option))
    });
    let all = of_commands.chain(global.map(|option| ("Every command".to_owned(), option)));
    for (command, option) in all.filter(|(_, option)| option.get_long().is_some()) {
        let row = row(option);
        match rows.iter_mut().find(|(known, _)| *known == row) {
            Some((_, commands)) => commands.push(command),
            None => rows.push((row, vec![command])),
        }
    }
    let mut page = BEGINNING.to_owned();

    // List the settings by group; those that a command changes follow below.
    for group in GROUPS {
        if group.table != "settings" {
            page += &format!(
                "\n### {}\n\nIn a scene file these may also stand in `[{}]`.\n",
                group.title, group.table
            );
        }
        page += &table(&mut rows, |row, commands| {
            row.heading == group.title && commands.iter().any(|command| command == "`render`")
        });
    }

    // List the others by the commands that have them.
    while let Some((_, commands)) = rows.iter().rev().max_by_key(|(_, commands)| commands.len()) {
        let commands = commands.clone();
        page += &format!("\n## {}\n", commands.join(", "));
        page += &table(&mut rows, |_, of| *of == commands);
    }
    page
}

/// Takes the rows that are wanted out of `rows`, as a table.
fn table(rows: &mut Vec<(Row, Vec<String>)>, wanted: impl Fn(&Row, &[String]) -> bool) -> String {
    let lines = rows.extract_if(.., |(row, commands)| wanted(row, commands)).map(|(row, _)| row.text);
    format!("\n| option | default | |\n|---|---|---|\n{}", lines.collect::<String>())
}

fn row(option: &Arg) -> Row {
    let takes_value = option.get_action().takes_values();
    let short = option.get_short().map_or_else(String::new, |letter| format!("`-{letter}`, "));
    let mut name = format!("--{}", option.get_long().unwrap_or_default());
    let values = option.get_possible_values();
    if takes_value && values.is_empty() {
        let units = option.get_value_names().unwrap_or_default();
        name += &units.iter().map(|unit| format!(" {unit}")).collect::<String>();
    }
    let defaults =
        option.get_default_values().iter().filter(|_| takes_value).map(|text| text.to_string_lossy());
    let default: String = defaults.collect::<Vec<_>>().join(" ");
    let mut text = option.get_help().map(ToString::to_string).unwrap_or_default();
    if takes_value && values.iter().any(|value| value.get_help().is_some()) {
        let described = values.iter().map(|value| {
            let help = value.get_help().map_or_else(String::new, |help| format!(": {help}"));
            format!("`{}`{help}", value.get_name())
        });
        text += &format!(". {}", described.collect::<Vec<_>>().join("; "));
    }
    let cells = [format!("{short}`{name}`"), default, text].map(|cell| cell.replace('|', "\\|"));
    Row {
        heading: option.get_help_heading().unwrap_or_default().to_owned(),
        text: format!("| {} |\n", cells.join(" | ")),
    }
}
