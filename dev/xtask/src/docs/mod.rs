//! The book: built from `docs/`, and held to what it says.

mod book;
mod cargo;
mod commands;
mod figures;
mod links;
mod page;
mod width;

use std::path::PathBuf;

use anyhow::{Context as _, Result, ensure};

use crate::step;
use page::Page;

/// What is wrong, and in which line of which file.
struct Fault {
    path: PathBuf,
    line: usize,
    what: String,
}

/// Checks every page of the repository, then builds the book.
pub(crate) fn run() -> Result<()> {
    text()?;
    with_programs()
}

/// Checks the commands on all pages with the programs themselves, then builds the book.
pub(crate) fn with_programs() -> Result<()> {
    eprintln!("\n== documentation: commands");
    let pages = pages()?;
    refuse(&commands::check(&pages)?)?;
    book::build(&pages)
}

/// Checks what is known without the programs, which take minutes to build.
pub(crate) fn text() -> Result<()> {
    eprintln!("\n== documentation: links, figures, width");
    let pages = pages()?;
    let mut faults = links::check(&pages);
    faults.extend(book::check(&pages));
    faults.extend(figures::check(&pages)?);
    faults.extend(width::check(&pages)?);
    refuse(&faults)
}

/// Names faults, and fails if there are any.
fn refuse(faults: &[Fault]) -> Result<()> {
    for Fault { path, line, what } in faults {
        eprintln!("   {}:{line}: {what}", path.display());
    }
    ensure!(faults.is_empty(), "the documentation has {} faults, see above", faults.len());
    Ok(())
}

/// All Markdown files that are no one's output.
fn pages() -> Result<Vec<Page>> {
    files("*.md")?.into_iter().map(Page::read).collect()
}

/// The repository's files of a pattern, new ones too.
fn files(pattern: &str) -> Result<Vec<PathBuf>> {
    let listed =
        ["ls-files", "--cached", "--others", "--exclude-standard", "--deduplicate", pattern];
    let list = step::output(step::command("git").args(listed)).context("`git ls-files` failed")?;
    // A file that was moved is listed until that is committed.
    Ok(list.lines().map(PathBuf::from).filter(|path| step::root().join(path).is_file()).collect())
}
