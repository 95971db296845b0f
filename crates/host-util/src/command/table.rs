//! Tables of words and numbers, without lines.

use comfy_table::{CellAlignment, Table, presets};

/// Creates an empty table. The columns in `right` are aligned to the right, for numbers.
pub fn table<const N: usize>(header: [&str; N], right: impl IntoIterator<Item = usize>) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header(header);
    for column in right {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}
