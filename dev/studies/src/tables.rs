//! Tables in the style of the studies.

use comfy_table::{CellAlignment, Row, Table, presets::ASCII_MARKDOWN};

/// Creates a table without rows.
pub(crate) fn table(header: impl Into<Row>) -> Table {
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN);
    table.set_header(header);
    table
}

/// Aligns the first column to the left, and all others, which are numbers, to the right.
pub(crate) fn aligned(mut table: Table) -> Table {
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}
