//! Splits an ASF or AMC file into lines and words.

use super::Problem;
use crate::recording::MAGNITUDE_MAX;
use crate::text::{Position, found};

pub(super) type Failure = (Position, Problem);

/// A word and its position; the end of the file is the empty word.
#[derive(Debug, Clone, Copy)]
pub(super) struct Word<'a> {
    pub(super) text: &'a str,
    pub(super) at: Position,
}

impl Word<'_> {
    pub(super) fn is(&self, keyword: &str) -> bool {
        self.text.eq_ignore_ascii_case(keyword)
    }

    pub(super) fn finite(&self) -> Result<f64, Failure> {
        let value: f64 = self.text.parse().unwrap_or(f64::NAN);
        // Comparisons with NaN are false, therefore NaN is refused too.
        if value.abs() <= MAGNITUDE_MAX { Ok(value) } else { Err(self.not("a finite number")) }
    }

    /// Creates the error that something else was expected at this word.
    pub(super) fn not(&self, expected: impl Into<String>) -> Failure {
        let found = if self.text.is_empty() {
            "the end of the line or file".to_owned()
        } else {
            found(self.text)
        };
        (self.at, Problem::Unexpected { expected: expected.into(), found })
    }
}

/// A line with at least one word.
#[derive(Debug, Clone)]
pub(super) struct Line<'a> {
    pub(super) words: Vec<Word<'a>>,
    end: Position,
}

impl<'a> Line<'a> {
    /// Returns word `index`, or an empty word at the line's end.
    pub(super) fn word(&self, index: usize) -> Word<'a> {
        self.words.get(index).copied().unwrap_or(Word { text: "", at: self.end })
    }

    pub(super) fn key(&self) -> Word<'a> {
        self.word(0)
    }

    /// Reads `N` numbers from word `from` on.
    pub(super) fn numbers<const N: usize>(&self, from: usize) -> Result<[f64; N], Failure> {
        let mut numbers = [0.0; N];
        for (index, number) in numbers.iter_mut().enumerate() {
            *number = self.word(from + index).finite()?;
        }
        Ok(numbers)
    }

    /// Checks that the line has no word from `from` on.
    pub(super) fn ends(&self, from: usize) -> Result<(), Failure> {
        self.words.get(from).map_or(Ok(()), |word| Err(word.not("the end of the line")))
    }
}

/// The lines of a text that contain more than white space, commas, parentheses and comments.
pub(super) struct Lines<'a> {
    lines: std::iter::Peekable<std::iter::Enumerate<std::str::Split<'a, char>>>,
    line: usize,
}

impl<'a> Lines<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        // If there is no LF, lines end with CR alone.
        let end = if text.contains('\n') { '\n' } else { '\r' };
        Self { lines: text.split(end).enumerate().peekable(), line: 0 }
    }

    /// Returns the next line, unless it starts a section.
    pub(super) fn next_in_section(&mut self) -> Option<Line<'a>> {
        self.skip_blank();
        self.next_if(|line| !line.trim_start().starts_with(':'))
    }

    pub(super) fn next(&mut self) -> Option<Line<'a>> {
        self.skip_blank();
        self.next_if(|_| true)
    }

    /// Skips the remaining lines of a section.
    pub(super) fn skip_section(&mut self) {
        while self.next_in_section().is_some() {}
    }

    /// Returns the position of the end of the last line, for errors about missing items.
    pub(super) fn end(&self) -> Position {
        Position { line: self.line + 1, column: 1 }
    }

    fn skip_blank(&mut self) {
        while self.lines.next_if(|(_, line)| words(line).next().is_none()).is_some() {}
    }

    fn next_if(&mut self, wanted: impl Fn(&str) -> bool) -> Option<Line<'a>> {
        let (index, line) = self.lines.next_if(|(_, line)| wanted(line))?;
        self.line = index + 1;
        let mut at = Position { line: index + 1, column: 1 };
        let mut byte = 0;
        let mut position = |to: usize| {
            at.column += line[byte..to].chars().count();
            byte = to;
            at
        };
        let words: Vec<Word<'a>> =
            words(line).map(|(byte, text)| Word { text, at: position(byte) }).collect();
        let end = position(line.trim_end().len());
        Some(Line { words, end })
    }
}

/// Returns the words of a line before its comment, with their offsets.
fn words(line: &str) -> impl Iterator<Item = (usize, &str)> {
    let line = line.split('#').next().unwrap_or_default();
    let separates = |c: char| c.is_whitespace() || matches!(c, ',' | '(' | ')');
    line.split(separates)
        .filter(|word| !word.is_empty())
        .map(move |word| (word.as_ptr() as usize - line.as_ptr() as usize, word))
}
