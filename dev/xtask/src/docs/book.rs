//! Builds the book with mdBook.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};

use super::fault::Fault;
use super::links;
use super::page::Page;
use sinew_steps::step;

const VERSION: &str = "0.5.4";

/// Folder of the pages; `book.toml` sets the output folder.
const PAGES: &str = "docs";
const SITE: &str = "target/site";

/// Finds pages that the book does not list, and links that would be dead in it.
pub(super) fn check(pages: &[Page]) -> Vec<Fault> {
    let summary = Path::new(PAGES).join("SUMMARY.md");
    let contents = pages.iter().find(|page| page.path == summary);
    let listed: Vec<PathBuf> = contents
        .iter()
        .flat_map(|page| page.links.iter().filter_map(|(_, link)| links::target(page, link)))
        .map(|(path, _)| path)
        .collect();
    let mut faults = Vec::new();
    for page in pages.iter().filter(|page| page.path.starts_with(PAGES) && page.path != summary) {
        if !listed.contains(&page.path) {
            let what = "SUMMARY.md does not list this page".to_owned();
            faults.push(Fault { path: page.path.clone(), line: 1, what });
        }
        for (line, link, path) in outside(page) {
            // mdBook treats every link to Markdown as a link to one of its pages.
            if path.extension().is_none_or(|extension| extension == "md") {
                let what = format!(
                    "`{link}`: a page may link to pages of the book, and to files that are no Markdown"
                );
                faults.push(Fault { path: page.path.clone(), line, what });
            }
        }
    }
    faults
}

/// Installs mdBook if it is missing, builds the book, and copies the files that it links to.
pub(super) fn build(pages: &[Page]) -> Result<()> {
    let tools = step::root().join("target/tools");
    let mdbook = tools.join("bin/mdbook");
    let found = step::output(step::command(&mdbook.to_string_lossy()).arg("--version"));
    if found.is_none_or(|version| version.trim() != format!("mdbook v{VERSION}")) {
        // Not optimized: it compiles in a third of the time, and still builds this book in a second.
        step::run(
            "mdBook",
            step::cargo()
                .args(["install", "--quiet", "--locked", "--debug"])
                .args(["--no-default-features", "--features", "search"])
                .args(["--version", VERSION, "mdbook", "--root"])
                .arg(&tools)
                .env("CARGO_TARGET_DIR", tools.join("build")),
        )?;
        // Only the program is needed.
        fs::remove_dir_all(tools.join("build")).context("target/tools/build")?;
    }
    step::run("book", step::command(&mdbook.to_string_lossy()).args(["build", PAGES]))?;
    for page in pages.iter().filter(|page| page.path.starts_with(PAGES)) {
        for (.., path) in outside(page) {
            let copy = step::root().join(SITE).join(&path);
            fs::create_dir_all(copy.parent().unwrap_or(&copy))?;
            fs::copy(step::root().join(&path), &copy)
                .with_context(|| path.display().to_string())?;
        }
    }
    eprintln!("   {SITE}/{PAGES}/index.html");
    Ok(())
}

/// Returns the links of a page to files outside of the book: line, link and path.
fn outside(page: &Page) -> impl Iterator<Item = (usize, &str, PathBuf)> {
    page.links.iter().filter_map(|(line, link)| {
        let (path, _) = links::target(page, link)?;
        (!path.starts_with(PAGES)).then_some((*line, link.as_str(), path))
    })
}
