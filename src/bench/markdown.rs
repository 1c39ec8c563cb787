//! The report as Markdown; plots are linked.

use std::fmt::Write as _;

use super::charts::Chart;
use super::html::headline;
use super::micro::{MicroReport, micro_tables};
use super::report::Report;
use super::summary::Noise;
use super::tables::Table;

/// The whole text.
pub(super) fn page(report: &Report, tables: &[Table], charts: &[Chart]) -> String {
    let mut text = format!("# glowworm bench\n\n{}\n\n", headline(report));
    // Writing to a String cannot fail.
    for (what, value) in report.machine.lines() {
        let _ = writeln!(text, "- {what}: {}", escaped(&value));
    }
    if let Some(warning) = Noise::of(&report.runs).warning() {
        let _ = write!(text, "\n> {warning}\n");
    }
    for table in tables {
        let _ = write!(text, "\n## {}\n\n{}\n\n{}", escaped(&table.title), table.note, body(table));
    }
    let _ = writeln!(text, "\n## Plots");
    for chart in charts {
        let _ = writeln!(text, "\n![{}](plots/{}.svg)", escaped(&chart.title), chart.name);
    }
    text
}

/// The report of micro-benchmarks.
pub(super) fn micro_page(report: &MicroReport) -> String {
    let mut text = "# glowworm bench --micro\n\n".to_owned();
    for (what, value) in report.machine.lines() {
        let _ = writeln!(text, "- {what}: {}", escaped(&value));
    }
    for table in micro_tables(report) {
        let _ = write!(text, "\n## {}\n\n{}\n\n{}", escaped(&table.title), table.note, body(&table));
    }
    text
}

fn body(table: &Table) -> String {
    let line = |cells: &[String]| {
        let cells: Vec<_> = cells.iter().map(|cell| escaped(cell)).collect();
        format!("| {} |\n", cells.join(" | "))
    };
    let rule: Vec<&str> =
        (0..table.columns.len()).map(|column| if column == 0 { "---" } else { "---:" }).collect();
    let mut text = line(&table.columns);
    let _ = writeln!(text, "| {} |", rule.join(" | "));
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
