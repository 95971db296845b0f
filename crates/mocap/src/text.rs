//! Positions and words of a text file, for error messages.

/// A position in a text; both numbers count from 1, columns in characters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Position {
    /// Line; line ends are LF, CR LF or CR.
    pub line: usize,
    /// Column, in characters.
    pub column: usize,
}

/// Returns a word of the file for a message, shortened and without control characters.
pub(crate) fn shown(word: &str) -> String {
    const LENGTH_MAX: usize = 40;
    let mut shown: String = word.chars().take(LENGTH_MAX).flat_map(char::escape_debug).collect();
    if word.chars().nth(LENGTH_MAX).is_some() {
        shown.push('…');
    }
    shown
}

/// Describes the word that was found instead of the expected one, or bytes that are not text.
pub(crate) fn found(word: &str) -> String {
    if word.contains(|c: char| c.is_control() || c == char::REPLACEMENT_CHARACTER) {
        return "bytes that are not text".to_owned();
    }
    format!("`{}`", shown(word))
}

/// Returns a count with its noun: "1 frame", "2 frames".
pub fn counted(count: usize, thing: &str) -> String {
    format!("{count} {thing}{}", if count == 1 { "" } else { "s" })
}
