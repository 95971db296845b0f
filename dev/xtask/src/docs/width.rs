//! Finds lines that are too wide: prose of pages, and comments in source code.

use std::fs;
use std::path::Path;

use anyhow::{Context as _, Result};

use super::fault::Fault;
use super::files::files;
use super::page::Page;
use sinew_steps::step;

/// Columns of the widest allowed line. Tables, code and addresses may be wider.
const WIDEST: usize = 120;

pub(super) fn check(pages: &[Page]) -> Result<Vec<Fault>> {
    let mut faults = Vec::new();
    for page in pages {
        for (number, (line, is_prose)) in (1..).zip(&page.lines) {
            if *is_prose {
                faults.extend(fault(&page.path, number, line));
            }
        }
    }
    for path in files("*.rs")? {
        let text = fs::read_to_string(step::root().join(&path))
            .with_context(|| path.display().to_string())?;
        let comments = (1..).zip(text.lines()).filter(|(_, line)| {
            let line = line.trim_start();
            // Skips rows of a table in a comment.
            line.starts_with("//") && !line.trim_start_matches(['/', '!', ' ']).starts_with('|')
        });
        for (number, line) in comments {
            faults.extend(fault(&path, number, line));
        }
    }
    Ok(faults)
}

fn fault(path: &Path, line: usize, text: &str) -> Option<Fault> {
    let columns = columns(text);
    let is_too_wide = columns > WIDEST && !text.contains("://");
    let what = format!("{columns} columns, at most {WIDEST}");
    is_too_wide.then(|| Fault { path: path.to_path_buf(), line, what })
}

/// Returns the number of columns without the addresses of links, which cannot be broken.
fn columns(text: &str) -> usize {
    let mut parts = text.split("](");
    let first = parts.next().unwrap_or_default();
    let behind = parts.map(|part| part.split_once(')').map_or(part, |(_, behind)| behind));
    std::iter::once(first).chain(behind).map(|part| part.chars().count()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_do_not_make_a_line_wide_but_words_beside_them_do() {
        let fault = |text: &str| fault(Path::new("a.md"), 1, text).map(|fault| fault.what);
        let link = format!("[a page]({})", "x".repeat(WIDEST));
        assert_eq!(fault(&link), None);
        assert_eq!(fault(&format!("{link} {}", "ä".repeat(WIDEST - 8))), None);
        let wide = fault(&format!("{link} {}", "ä".repeat(WIDEST - 7)));
        assert_eq!(wide.as_deref(), Some("121 columns, at most 120"));
    }
}
