//! Writes the committed figures as a page of the documentation.

use std::fmt::Write as _;

use anyhow::{Context as _, Result};
use toml_edit::{DocumentMut, Item, TableLike};

use super::file::FILE;

/// Path of the page in the workspace.
pub(crate) const PAGE: &str = "docs/figures.md";

const HEAD: &str = "\
# Figures of a Cortex-M4F

`cargo xtask budget --accept` writes this page from [budget.toml](../dev/bench/budget.toml). [Speed of the
core](speed.md) explains the figures.

- Instructions are those that QEMU executes. Cycles are an estimate.
- Columns 6, 18, 32 and 64 of a kernel, a tick (`tick_..`) or a tick as boards run it (`board_..`) are numbers of
  bodies: a floating root, spherical joints. Columns 6, 12 and 20 are numbers of joints on a fixed base: all revolute,
  or all balls.
- `rig_..` is a tracker's step from encoders to efforts, with frames as coordinates or as poses of a larger performer.
- Show instructions are a tick of the image of QEMU's board, with its show. `show_..` decodes a show of 20 servos.
  `bus_..` and `drives_..` are a tick of 18 servos.
- `loop_..` is a tick of the whole loop of 6, 20 or 40 servos, without host link, storage and telemetry.
- `worst_instructions` are those of the longest tick, `painted_stack_bytes` are measured, `static_stack_bytes` are an
  upper bound from frames and calls.
";

/// Formats the promises and the figures of the file.
pub(crate) fn print(budget: &str) -> Result<String> {
    let document: DocumentMut = budget.parse().context(FILE)?;
    let mut page = HEAD.to_owned();
    page += "\n## Promises\n\n| figure | at most | why |\n| --- | --- | --- |\n";
    for promise in document.get("promises").and_then(Item::as_array_of_tables).into_iter().flatten()
    {
        let text = |key| promise.get(key).and_then(Item::as_str).unwrap_or_default();
        let at_most = promise.get("at_most").map(number).unwrap_or_default();
        let times = match text("times") {
            "" => String::new(),
            times => format!(" times `{times}`"),
        };
        writeln!(page, "| `{}` | {at_most}{times} | {} |", text("figure"), text("reason"))?;
    }
    let measured = document.get("measured").and_then(Item::as_table_like).context(FILE)?;
    for (section, rows) in measured.iter() {
        writeln!(page, "\n## {}", capitalized(section))?;
        // A new table begins where the columns change.
        let mut known = Vec::new();
        for (row, columns) in rows.as_table_like().context(FILE)?.iter() {
            let columns = columns.as_table_like().context(FILE)?;
            let names = names(columns);
            if names != known {
                writeln!(
                    page,
                    "\n| | {} |\n|{}",
                    names.join(" | "),
                    " --- |".repeat(names.len() + 1)
                )?;
                known = names;
            }
            let numbers: Vec<String> = columns.iter().map(|(_, item)| number(item)).collect();
            writeln!(page, "| `{row}` | {} |", numbers.join(" | "))?;
        }
    }
    Ok(page)
}

fn names(table: &dyn TableLike) -> Vec<String> {
    table.iter().map(|(name, _)| name.to_owned()).collect()
}

/// Returns a section's name as a heading.
fn capitalized(section: &str) -> String {
    let text = section.replace('_', " ");
    let (first, rest) = text.split_at(text.len().min(1));
    first.to_uppercase() + rest
}

/// Returns a number in the format of the file, so that it can be searched there.
fn number(item: &Item) -> String {
    let whole = item.as_integer().map(|number| number.to_string());
    whole.or_else(|| item.as_float().map(|number| number.to_string())).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_steps::step;

    #[test]
    fn the_page_of_figures_is_what_the_budget_says() {
        let read = |file| std::fs::read_to_string(step::root().join(file)).unwrap_or_default();
        let page = print(&read(FILE)).unwrap();
        if std::env::var_os("INSTA_UPDATE").is_some_and(|update| update == "always") {
            std::fs::write(step::root().join(PAGE), &page).unwrap();
        }
        assert!(
            read(PAGE) == page,
            "{PAGE} is not what {FILE} says: INSTA_UPDATE=always writes it"
        );
    }
}
