//! Formats coordinates as text.

use std::fmt::Write as _;

/// Returns the path data of a line through points.
pub(crate) fn line(points: impl IntoIterator<Item = (f64, f64)>) -> String {
    let mut data = String::new();
    for (index, (x, y)) in points.into_iter().enumerate() {
        let command = if index == 0 { 'M' } else { 'L' };
        write!(data, "{command}{} {}", px(x), px(y)).expect("a string takes everything");
    }
    data
}

/// Formats a coordinate with one decimal: finer than visible, and identical on every machine.
pub fn px(x: f64) -> String {
    let text = format!("{x:.1}");
    let short = text.strip_suffix(".0").unwrap_or(&text);
    if short == "-0" { "0".into() } else { short.into() }
}
