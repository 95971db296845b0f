//! Splits a BVH file into words with their positions.

use crate::text::Position;

/// A word and its position; the end of the file is the empty word.
#[derive(Debug, Clone, Copy)]
pub(super) struct Token<'a> {
    pub(super) text: &'a str,
    pub(super) at: Position,
}

impl Token<'_> {
    pub(super) fn is(&self, keyword: &str) -> bool {
        self.text.eq_ignore_ascii_case(keyword)
    }

    pub(super) fn is_end(&self) -> bool {
        self.text.is_empty()
    }
}

/// A reader of a text, word by word.
///
/// `{`, `}` and `:` are separate words, with or without white space around them.
pub(super) struct Tokens<'a> {
    /// Text that is not read yet.
    text: &'a str,
    at: Position,
}

impl<'a> Tokens<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self { text, at: Position { line: 1, column: 1 } }
    }

    /// Returns the next word; skips comments, which begin with `#` or `//`.
    pub(super) fn next(&mut self) -> Token<'a> {
        self.skip_while(char::is_whitespace);
        while is_comment(self.text) {
            self.skip_while(|c| !is_line_end(c));
            self.skip_while(char::is_whitespace);
        }
        let at = self.at;
        let text = if self.text.starts_with(is_mark) {
            let (mark, rest) = self.text.split_at(1);
            self.text = rest;
            self.at.column += 1;
            mark
        } else {
            self.skip_while(|c| !c.is_whitespace() && !is_mark(c))
        };
        Token { text, at }
    }

    /// Returns the rest of the line up to a brace, without white space around it.
    pub(super) fn rest_of_line(&mut self) -> Token<'a> {
        self.skip_while(|c| c.is_whitespace() && !is_line_end(c));
        let at = self.at;
        let rest = self.skip_while(|c| !is_line_end(c) && c != '{' && c != '}');
        // A name may contain `#`, but no word of it begins with `#`.
        let marks = rest.match_indices(['#', '/']).map(|(place, _)| place);
        let begins_word = |place: &usize| rest[..*place].ends_with(char::is_whitespace);
        let comment = marks.filter(begins_word).find(|place| is_comment(&rest[*place..]));
        Token { text: rest[..comment.unwrap_or(rest.len())].trim_end(), at }
    }

    /// Skips characters while `wanted` accepts them, and returns them.
    fn skip_while(&mut self, wanted: impl Fn(char) -> bool) -> &'a str {
        let mut chars = self.text.chars();
        let mut rest = self.text;
        while let Some(c) = chars.next().filter(|c| wanted(*c)) {
            rest = chars.as_str();
            let ends_line = c == '\n' || c == '\r' && !rest.starts_with('\n');
            if ends_line {
                self.at = Position { line: self.at.line + 1, column: 1 };
            } else {
                self.at.column += 1;
            }
        }
        let skipped = &self.text[..self.text.len() - rest.len()];
        self.text = rest;
        skipped
    }
}

fn is_comment(text: &str) -> bool {
    text.starts_with('#') || text.starts_with("//")
}

fn is_mark(c: char) -> bool {
    matches!(c, '{' | '}' | ':')
}

fn is_line_end(c: char) -> bool {
    matches!(c, '\n' | '\r')
}
