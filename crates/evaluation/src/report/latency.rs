//! Writes the table of the maximum latencies.

use comfy_table::{CellAlignment, Table, presets::ASCII_MARKDOWN};

use crate::capacity::MAX_LATENCY_STEPS;
use crate::latency::LatencyLimits;

/// Returns the table of the maximum latencies: two rows for each method, without and with prediction, and a column
/// for each rate.
pub fn latency_table(limits: &LatencyLimits) -> String {
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN);
    let heading = ["method", "looks ahead"].map(str::to_owned).into_iter();
    table.set_header(heading.chain(limits.rates_hz.iter().map(|rate| format!("{rate:.0} Hz"))));
    for row in &limits.rows {
        let cells = limits.rates_hz.iter().zip(&row.largest_steps);
        let cells = cells.map(|(rate, steps)| cell(*rate, *steps));
        let looks_ahead = if row.looks_ahead { "yes" } else { "no" };
        table.add_row([row.method.to_string(), looks_ahead.to_owned()].into_iter().chain(cells));
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.to_string()
}

fn cell(rate_hz: f64, steps: Option<usize>) -> String {
    match steps {
        None => "-".to_owned(),
        Some(1) => format!("1 step, {:.0} ms", 1e3 / rate_hz),
        Some(MAX_LATENCY_STEPS) => format!("{MAX_LATENCY_STEPS} steps or more"),
        Some(steps) => format!("{steps} steps, {:.0} ms", steps as f64 * 1e3 / rate_hz),
    }
}
