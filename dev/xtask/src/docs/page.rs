//! The parts of a Markdown file that are checked.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

use anyhow::{Context as _, Result};
use pulldown_cmark::{CodeBlockKind, Event, Options, Parser, Tag, TagEnd};

use sinew_steps::step;

/// A Markdown file of the repository.
pub(super) struct Page {
    /// Path in the repository.
    pub(super) path: PathBuf,
    /// Lines, and whether each is prose: neither code nor table.
    pub(super) lines: Vec<(String, bool)>,
    /// Links and images, with their lines.
    pub(super) links: Vec<(usize, String)>,
    /// Paths of source files, with their lines.
    pub(super) sources: Vec<(usize, String)>,
    /// Headings that can be linked to.
    pub(super) anchors: BTreeSet<String>,
    /// Commands in blocks of `sh`, with the line.
    pub(super) commands: Vec<(usize, String)>,
}

impl Page {
    pub(super) fn read(path: PathBuf) -> Result<Self> {
        let text = fs::read_to_string(step::root().join(&path))
            .with_context(|| path.display().to_string())?;
        Ok(Self::new(path, &text))
    }

    pub(super) fn new(path: PathBuf, text: &str) -> Self {
        let mut page = Self {
            path,
            lines: text.lines().map(|line| (line.to_owned(), true)).collect(),
            links: Vec::new(),
            sources: Vec::new(),
            anchors: BTreeSet::new(),
            commands: Vec::new(),
        };
        let line_of = |offset: usize| text[..offset].matches('\n').count() + 1;
        let mut heading: Option<String> = None;
        let mut in_shell = false;
        let events = Parser::new_ext(text, Options::ENABLE_TABLES).into_offset_iter();
        for (event, range) in events {
            if let Event::Code(code) = &event
                && code.contains("/src/")
            {
                page.sources.push((line_of(range.start), code.to_string()));
            }
            match event {
                Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
                Event::End(TagEnd::Heading(_)) => {
                    page.add_anchor(&heading.take().unwrap_or_default());
                }
                Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                    page.links.push((line_of(range.start), dest_url.into_string()));
                }
                Event::Start(Tag::CodeBlock(kind)) => {
                    in_shell =
                        matches!(kind, CodeBlockKind::Fenced(language) if &*language == "sh");
                    page.mark_no_prose(line_of(range.start), line_of(range.end));
                }
                Event::End(TagEnd::CodeBlock) => in_shell = false,
                Event::Start(Tag::Table(_)) => {
                    page.mark_no_prose(line_of(range.start), line_of(range.end) - 1);
                }
                Event::Text(text) if in_shell => page.add_commands(line_of(range.start), &text),
                Event::Text(text) | Event::Code(text) => {
                    if let Some(heading) = &mut heading {
                        heading.push_str(&text);
                    }
                }
                _ => {}
            }
        }
        page
    }

    /// Adds the anchor that GitHub and mdBook give to a heading.
    fn add_anchor(&mut self, heading: &str) {
        let name: String = heading
            .trim()
            .to_lowercase()
            .chars()
            .filter(|letter| letter.is_alphanumeric() || " -_".contains(*letter))
            .map(|letter| if letter == ' ' { '-' } else { letter })
            .collect();
        let numbered = (1..).map(|number| format!("{name}-{number}"));
        let free =
            std::iter::once(name.clone()).chain(numbered).find(|name| !self.anchors.contains(name));
        self.anchors.extend(free);
    }

    fn mark_no_prose(&mut self, first: usize, last: usize) {
        for (_, is_prose) in self.lines.iter_mut().take(last).skip(first - 1) {
            *is_prose = false;
        }
    }

    /// Adds the commands of a block. Lines that continue after a backslash are joined.
    fn add_commands(&mut self, first: usize, block: &str) {
        let mut command: Option<(usize, String)> = None;
        for (line, text) in (first..).zip(block.lines()) {
            let (begun, mut whole) = command.take().unwrap_or((line, String::new()));
            if let Some(begin) = text.strip_suffix('\\') {
                whole.push_str(begin);
                command = Some((begun, whole));
            } else {
                whole.push_str(text);
                self.commands.push((begun, whole));
            }
        }
        self.commands.extend(command);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page(text: &str) -> Page {
        Page::new("docs/page.md".into(), text)
    }

    #[test]
    fn headings_are_named_as_github_names_them() {
        let page = page("# Why `x` differs, and how\n\n## Größe – 1.5\n\n## Twice\n\n## Twice\n");
        let expected = ["why-x-differs-and-how", "größe--15", "twice", "twice-1"];
        assert_eq!(page.anchors, expected.map(str::to_owned).into());
    }

    #[test]
    fn only_shell_blocks_have_commands_and_a_backslash_goes_on() {
        let page = page("```sh\none \\\n  two\nthree\n```\n\n```text\nfour\n```\n");
        assert_eq!(page.commands, [(2, "one   two".to_owned()), (4, "three".to_owned())]);
    }

    #[test]
    fn code_and_tables_are_no_prose() {
        let page = page("prose\n\n```\ncode\n```\n\n| a |\n|---|\n| b |\n\nprose\n");
        let prose: Vec<usize> =
            (1..).zip(&page.lines).filter(|(_, line)| line.1).map(|(at, _)| at).collect();
        assert_eq!(prose, [1, 2, 6, 10, 11]);
    }

    #[test]
    fn links_and_pictures_have_their_lines() {
        let page = page("[a](b.md#c)\n\n![d](e.png)\n");
        assert_eq!(page.links, [(1, "b.md#c".to_owned()), (3, "e.png".to_owned())]);
    }
}
