//! Words of a BVH file and where they stand.

use std::str::CharIndices;

use crate::text::Position;

/// A word and its place; the end of the file is the empty word.
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

/// Reads a text word by word.
///
/// `{`, `}` and `:` are words of their own, with or without white space around them.
pub(super) struct Tokens<'a> {
    text: &'a str,
    chars: std::iter::Peekable<CharIndices<'a>>,
    at: Position,
}

impl<'a> Tokens<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        Self { text, chars: text.char_indices().peekable(), at: Position { line: 1, column: 1 } }
    }

    /// The next word.
    pub(super) fn next(&mut self) -> Token<'a> {
        self.skip_while(char::is_whitespace);
        let at = self.at;
        let start = self.byte();
        if self.chars.next_if(|&(_, c)| is_mark(c)).is_some() {
            self.at.column += 1;
        } else {
            self.skip_while(|c| !c.is_whitespace() && !is_mark(c));
        }
        Token { text: &self.text[start..self.byte()], at }
    }

    /// What is left of the line up to a brace, without white space around it.
    pub(super) fn rest_of_line(&mut self) -> Token<'a> {
        self.skip_while(|c| c.is_whitespace() && !is_line_end(c));
        let at = self.at;
        let start = self.byte();
        self.skip_while(|c| !is_line_end(c) && c != '{' && c != '}');
        Token { text: self.text[start..self.byte()].trim_end(), at }
    }

    fn byte(&mut self) -> usize {
        self.chars.peek().map_or(self.text.len(), |&(byte, _)| byte)
    }

    fn skip_while(&mut self, wanted: impl Fn(char) -> bool) {
        while let Some((_, c)) = self.chars.next_if(|&(_, c)| wanted(c)) {
            let ends_line = c == '\n' || c == '\r' && self.chars.peek().is_none_or(|n| n.1 != '\n');
            if ends_line {
                self.at = Position { line: self.at.line + 1, column: 1 };
            } else {
                self.at.column += 1;
            }
        }
    }
}

fn is_mark(c: char) -> bool {
    matches!(c, '{' | '}' | ':')
}

fn is_line_end(c: char) -> bool {
    matches!(c, '\n' | '\r')
}
