//! Formats measured numbers as tables with aligned columns.

use std::fmt::Write;

use super::cycles::Kind;
use super::figures::{FigureKey, Figures};
use super::file::{Budget, Verdict, change};
use super::trace::Mix;
use crate::elf::Elf;

/// Formats a table: the first column is left-aligned, all others right-aligned.
pub(crate) fn aligned(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or_default();
    let width = |column: usize| {
        rows.iter()
            .filter_map(|row| row.get(column))
            .map(|cell| cell.chars().count())
            .max()
            .unwrap_or_default()
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let mut line = String::new();
        for (column, (cell, width)) in row.iter().zip(&widths).enumerate() {
            let _ = match column {
                0 => write!(line, "{cell:<width$}"),
                _ => write!(line, "  {cell:>width$}"),
            };
        }
        let _ = writeln!(text, "{}", line.trim_end());
    }
    text
}

/// Formats all figures of a section, and the change of each since it was accepted.
pub(crate) fn section(figures: &Figures, budget: Option<&Budget>, section: &str) -> String {
    let columns = figures.names(|place| (place.section == section).then_some(&place.column));
    let mut rows = vec![vec![section.replace('_', " ")]];
    for column in &columns {
        rows[0].extend([(*column).to_owned(), String::new()]);
    }
    for row in figures.names(|place| (place.section == section).then_some(&place.row)) {
        let mut cells = vec![row.to_owned()];
        for column in &columns {
            let place = FigureKey::new(section, row, column);
            let now = figures.get(&place);
            cells.push(now.map_or_else(|| "-".to_owned(), |now| now.to_string()));
            cells.push(match (budget.and_then(|budget| budget.accepted(&place)), now) {
                (Some(before), Some(now)) if before != now => change(before, now),
                _ => String::new(),
            });
        }
        rows.push(cells);
    }
    aligned(&rows)
}

/// Formats every promise, and whether it holds.
pub(crate) fn promises(verdicts: &[Verdict<'_>]) -> String {
    let mut rows = vec![["promise", "measured", "bound", ""].map(str::to_owned).to_vec()];
    rows.extend(verdicts.iter().map(|verdict| {
        vec![
            format!("{} at most {}", verdict.place, verdict.bound_text()),
            verdict.measured.to_string(),
            format!("{:.0}", verdict.bound),
            if verdict.holds() { "holds" } else { "MISSED" }.to_owned(),
        ]
    }));
    aligned(&rows)
}

/// Formats the instructions of kernels in one run, by kind of instruction.
pub(crate) fn mixes<'a>(
    title: &str,
    mixes: impl IntoIterator<Item = (String, u64, &'a Mix)>,
) -> String {
    let mut rows = vec![vec![title.to_owned(), "instructions".to_owned(), "cycles".to_owned()]];
    rows[0].extend(Kind::ALL.map(|(_, name)| name.to_owned()));
    for (name, runs, mix) in mixes {
        let per_run = |count: u64| count.div_ceil(runs).to_string();
        let mut row = vec![name, per_run(mix.instructions), per_run(mix.cycles)];
        row.extend(mix.kinds.map(per_run));
        rows.push(row);
    }
    aligned(&rows)
}

/// Returns the last part of a function's path, with the type of a method.
pub(crate) fn short_name(elf: &Elf, function: usize) -> String {
    let name = &elf.functions()[function].name;
    let parts: Vec<&str> = name.split("::").collect();
    let short = parts[parts.len().saturating_sub(4)..].join("::");
    short.chars().take(72).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned() {
        let rows = [vec!["µ", "number", ""], vec!["longer", "1", "+1 %"]];
        let rows = rows.map(|row| row.into_iter().map(str::to_owned).collect());
        assert_eq!(aligned(&rows), "µ       number\nlonger       1  +1 %\n");
    }
}
