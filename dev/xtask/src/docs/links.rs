//! Finds links to missing files and headings, and names of missing source files.

use std::path::{Component, Path, PathBuf};

use super::fault::Fault;
use super::page::Page;
use sinew_steps::step;

pub(super) fn check(pages: &[Page]) -> Vec<Fault> {
    let of_page = |page: &Page| -> Vec<Fault> {
        let dead = |(line, link): &(usize, String)| {
            let what = fault(page, link, pages)?;
            Some(Fault { path: page.path.clone(), line: *line, what })
        };
        let gone = |(line, source): &(usize, String)| {
            let is_there = step::root().join(source).exists();
            let what = format!("`{source}`: there is no such file or folder");
            (!is_there).then(|| Fault { path: page.path.clone(), line: *line, what })
        };
        let links = page.links.iter().filter_map(dead);
        links.chain(page.sources.iter().filter_map(gone)).collect()
    };
    pages.iter().flat_map(of_page).collect()
}

/// Returns the file that a page links to, by its path in the repository, and the heading; `None` for a network
/// address.
pub(super) fn target<'a>(page: &Page, link: &'a str) -> Option<(PathBuf, Option<&'a str>)> {
    if link.contains("://") || link.starts_with("mailto:") {
        return None;
    }
    let (file, heading) = match link.split_once('#') {
        Some((file, heading)) => (file, Some(heading)),
        None => (link, None),
    };
    let path = match file {
        "" => page.path.clone(),
        file => plain(&page.path.parent().unwrap_or(Path::new("")).join(file)),
    };
    Some((path, heading))
}

fn fault(page: &Page, link: &str, pages: &[Page]) -> Option<String> {
    let (path, heading) = target(page, link)?;
    let linked = pages.iter().find(|page| page.path == path);
    if linked.is_none() && !step::root().join(&path).exists() {
        return Some(format!("`{link}`: there is no {}", path.display()));
    }
    let heading = heading?;
    let is_there = linked.is_some_and(|linked| linked.anchors.contains(heading));
    (!is_there).then(|| format!("`{link}`: {} has no heading of that name", path.display()))
}

/// Returns the path without `.` and `..`.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for component in path.components() {
        match component {
            Component::ParentDir => _ = plain.pop(),
            Component::Normal(name) => plain.push(name),
            _ => {}
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dead_links_are_found_and_others_are_not() {
        let page = |path: &str, text: &str| Page::new(path.into(), text);
        let pages = [
            page(
                "docs/a.md",
                "# One\n[b](../../README.md#two), [c](book.toml), [d](https://e.org), [f](#one)",
            ),
            page(
                "README.md",
                "# Two\n\n[gone](docs/gone.md)\n\n[heading](docs/a.md#two)\n\n\
                 `core/src/math.rs`, `core/src/gone.rs`",
            ),
        ];
        let faults: Vec<_> =
            check(&pages).iter().map(|fault| (fault.path.clone(), fault.line)).collect();
        assert_eq!(
            faults,
            [("README.md".into(), 3), ("README.md".into(), 5), ("README.md".into(), 7)]
        );
    }
}
