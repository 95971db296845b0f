//! The book: built from `docs/`, with checks of its links and commands.

mod book;
mod cargo;
mod commands;
mod fault;
mod files;
mod links;
mod page;
mod width;

use anyhow::{Result, ensure};

use crate::nextest;
use fault::Fault;
use files::files;
use page::Page;
use sinew_steps::step;

/// Checks every page of the repository, then builds the book.
pub(crate) fn run() -> Result<()> {
    text()?;
    nextest::build()?;
    commands()?;
    book()
}

/// Checks the commands on all pages with the programs themselves, which must have been built. Commands of the studies
/// are checked only if their program is built.
pub(crate) fn commands() -> Result<()> {
    step::of("documentation: commands", || refuse(&commands::check(&pages()?)?))
}

/// Builds the book.
pub(crate) fn book() -> Result<()> {
    book::build(&pages()?)
}

/// Checks everything that does not need the programs, which take minutes to build.
pub(crate) fn text() -> Result<()> {
    step::of("documentation: links, width", || {
        let pages = pages()?;
        let mut faults = links::check(&pages);
        faults.extend(book::check(&pages));
        faults.extend(width::check(&pages)?);
        refuse(&faults)
    })
}

/// Prints the faults, and fails if there are any.
fn refuse(faults: &[Fault]) -> Result<()> {
    for Fault { path, line, what } in faults {
        eprintln!("   {}:{line}: {what}", path.display());
    }
    ensure!(faults.is_empty(), "the documentation has {} faults, see above", faults.len());
    Ok(())
}

/// Returns all Markdown files of the repository that are not generated.
fn pages() -> Result<Vec<Page>> {
    files("*.md")?.into_iter().map(Page::read).collect()
}
