//! The report as Markdown; plots are linked.

use super::charts::Chart;
use super::html::headline;
use super::machine::Machine;
use super::micro::{MicroReport, micro_tables};
use super::report::Report;
use super::summary::Noise;
use super::tables::Table;

/// The whole text.
pub(super) fn page(report: &Report, tables: &[Table], charts: &[Chart]) -> String {
    let mut text = format!("# glowworm bench\n\n{}\n\n", headline(report)) + &machine(&report.machine);
    if let Some(warning) = Noise::of(&report.runs).warning() {
        text += &format!("\n> {warning}\n");
    }
    text.extend(tables.iter().map(section));
    text += "\n## Plots\n";
    text.extend(
        charts.iter().map(|chart| format!("\n![{}](plots/{}.svg)\n", escaped(&chart.title), chart.name)),
    );
    text
}

/// The report of micro-benchmarks.
pub(super) fn micro_page(report: &MicroReport) -> String {
    let tables: String = micro_tables(report).iter().map(section).collect();
    format!("# glowworm bench --micro\n\n{}{tables}", machine(&report.machine))
}

fn machine(machine: &Machine) -> String {
    machine.lines().into_iter().map(|(what, value)| format!("- {what}: {}\n", escaped(&value))).collect()
}

fn section(table: &Table) -> String {
    format!("\n## {}\n\n{}\n\n{}", escaped(&table.title), table.note, body(table))
}

fn body(table: &Table) -> String {
    let line = |cells: &[String]| {
        let cells: Vec<_> = cells.iter().map(|cell| escaped(cell)).collect();
        format!("| {} |\n", cells.join(" | "))
    };
    let rule: Vec<&str> =
        (0..table.columns.len()).map(|column| if column == 0 { "---" } else { "---:" }).collect();
    let mut text = line(&table.columns) + &format!("| {} |\n", rule.join(" | "));
    text.extend(table.rows.iter().map(|row| line(row)));
    text
}

/// Escapes Markdown.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for c in text.chars() {
        if matches!(c, '|' | '*' | '`' | '[' | ']' | '<' | '>' | '\\') {
            escaped.push('\\');
        }
        escaped.push(c);
    }
    escaped
}
