//! Tables of a report as text for the terminal.

use crate::bench::Table;

/// Formats a table for the terminal.
pub(super) fn text(table: &Table) -> String {
    let lines = || std::iter::once(&table.columns).chain(&table.rows);
    let width =
        |column: usize| lines().filter_map(|line| line.get(column)).map(|cell| cell.chars().count()).max();
    let mut text = format!("{}\n", table.title);
    for line in lines() {
        for (column, cell) in line.iter().enumerate() {
            let width = width(column).unwrap_or(0);
            text += &if column == 0 { format!("{cell:<width$}") } else { format!("  {cell:>width$}") };
        }
        text.push('\n');
    }
    text
}
