//! Charts of one metric of a sweep over two of its parameters.

use maud::{Markup, html};

use super::frame::{WIDTH, chart};
use super::path::px;
use crate::sweep::Grid;

const CELL: f64 = 34.0;

/// Minimum width of a cell for its number, and of a column for its label.
const NUMBER: f64 = 30.0;

/// Draws a grid of coloured cells with their values: larger values are darker. Empty cells are crossed.
pub fn heat_map(grid: &Grid) -> Markup {
    let longest = grid.rows.iter().map(|label| label.chars().count()).max().unwrap_or(0);
    // A letter is about 7 units wide.
    let (left, top) = (f64::max(110.0, 16.0 + 7.0 * longest as f64), 46.0);
    let width = (WIDTH - left - 8.0) / grid.columns.len() as f64;
    let every = labelled(width);
    let height = top + CELL * grid.rows.len() as f64 + 46.0;
    let (low, high) = grid.range;
    let description = if low <= high {
        format!("{} by {}: from {low:.3} to {high:.3}", grid.row_name, grid.column_name)
    } else {
        "No cell has a value".into()
    };
    chart(
        height,
        &grid.title,
        &description,
        &html! {
            text class="axis-name" x="8" y="36" { (grid.row_name) @if !grid.condition.is_empty() { " · " (grid.condition) } }
            @for (row, row_label) in grid.rows.iter().enumerate() {
                @let y = top + CELL * row as f64;
                text class="tick" x=(px(left - 8.0)) y=(px(y + 0.5 * CELL + 4.0)) text-anchor="end" { (row_label) }
                @for column in 0..grid.columns.len() {
                    @let x = left + width * column as f64;
                    @match grid.cells[row * grid.columns.len() + column] {
                        Some(value) => {
                            @let level = level(value, low, high);
                            g class={ "heat heat-" (level) } {
                                rect x=(px(x + 1.0)) y=(px(y + 1.0)) width=(px(width - 2.0)) height=(px(CELL - 2.0)) rx="3" {}
                                @if width >= NUMBER { text x=(px(x + 0.5 * width)) y=(px(y + 0.5 * CELL + 4.0)) text-anchor="middle" { (number(value)) } }
                            }
                        }
                        None => path class="grid" d={
                            "M" (px(x + 4.0)) " " (px(y + 4.0)) "L" (px(x + width - 4.0)) " " (px(y + CELL - 4.0))
                            "M" (px(x + width - 4.0)) " " (px(y + 4.0)) "L" (px(x + 4.0)) " " (px(y + CELL - 4.0))
                        } {}
                    }
                }
            }
            @let bottom = top + CELL * grid.rows.len() as f64;
            @for (column, column_label) in grid.columns.iter().enumerate() {
                @let x = left + width * (column as f64 + 0.5);
                @if column.is_multiple_of(every) { text class="tick" x=(px(x)) y=(px(bottom + 16.0)) text-anchor="middle" { (column_label) } }
            }
            text class="axis-name" x=(px(WIDTH - 10.0)) y=(px(bottom + 34.0)) text-anchor="end" { (grid.column_name) }
        },
    )
}

/// Returns the smallest n for which a label fits at every n-th column of this width.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to some hundreds")]
fn labelled(width: f64) -> usize {
    libm::ceil(NUMBER / width).max(1.0) as usize
}

/// Number of steps of the colour scale.
const LEVELS: usize = 9;

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "between 0 and the number of levels"
)]
fn level(value: f64, low: f64, high: f64) -> usize {
    let share = if high > low { (value - low) / (high - low) } else { 0.0 };
    ((share * LEVELS as f64) as usize).min(LEVELS - 1)
}

/// Formats a number with three digits.
fn number(value: f64) -> String {
    match value.abs() {
        small if small < 10.0 => format!("{value:.2}"),
        middle if middle < 100.0 => format!("{value:.1}"),
        _ => format!("{value:.0}"),
    }
}
